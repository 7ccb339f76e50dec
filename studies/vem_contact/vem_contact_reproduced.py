"""Node-to-node contact of polygons with inserted nodes: what ``flangeway reproduce vem-contact`` computes.

The contact patch test and Hertz's problem on the meshes of Moherdaui (2021, 6.2), each with elements that differ in
nothing but the pairing: nodes against segments, averages over segments, and nodes against inserted nodes.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

from flangeway.cases.bodies.bodies_model import build_bodies
from flangeway.cases.bodies.presets import HertzCase
from flangeway.cases.case import Progress
from flangeway.contact import Contact, ContactSolution, Multiplier, NodeToNode, Surface, press
from flangeway.exact import LineContact
from flangeway.mesh import insert_nodes, match_boundaries
from flangeway.post import pressure_patches
from flangeway.problems import Body, Part
from flangeway.types import Floats
from studies.contact_patch.contact_patch_reproduced import LAWS, ROTATION_DEG, PatchRun, patch_run
from studies.hertz.hertz_reproduced import SLACK, published_case, rms_from_hertz
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare

CODES = ("VVO1", "VVO2", "VDO2", "FDO2")
"""Polygons of order 1 and 2; triangles with virtual and with finite elements of order 2, those with inserted nodes
virtual in either case."""
PAIRINGS = ("node-to-segment", "segment-to-segment", "node-to-node")
LEVELS = (1, 2, 3)
RATIOS = (1e-2, 1e-4, 1e-6)  # lengths of short edges over those beside them
SHORT_LEVEL = 2
PATCH_LIMIT = 1e-9  # of relative deviations from the uniform pressure and stress
PEAK_LIMITS = {1: 0.05, 2: 0.005}  # relative difference of the maximum pressure, by order
RMS_LIMITS = {1: 0.04, 2: 0.005}  # root mean square difference from Hertz's pressure over its maximum
SAME_FORCE, SAME_ERROR = 1e-4, 0.3
"""Relative change of the force and of the root mean square difference by short edges."""


@dataclass(frozen=True, eq=False, kw_only=True)
class PairingRow:
    """Hertz's problem by one pairing, lengths in cm and forces in kN: a row of ``hertz.csv``."""

    code: str  # published code with the mesh, such as ``"VVO2M2"``
    pairing: str  # name of the pairing
    ratio: float  # length of inserted edges over those beside them; 0 without such edges
    converged: bool
    n_unknowns: int  # of both discs, the supported ones included
    n_constraints: int  # of the contact
    iterations: int  # of Newton's method
    cpu_s: float  # process time with meshes and stiffness
    force: float
    peak: float  # maximum pressure over Hertz's under the same force
    rms: float
    """See `rms_from_hertz`, with areas of the nodes as weights, but for one element at both ends."""
    oscillation: float  # see `flangeway.post.pressure.oscillation_of`
    x: Floats  # positions of the loaded nodes before the deformation
    pressures: Floats  # their pressures
    theory: LineContact

    @property
    def row(self) -> Row:
        """What ``hertz.csv`` has of it."""
        return {name: value for name, value in vars(self).items() if name not in ("x", "pressures", "theory")}


@dataclass(frozen=True, eq=False, kw_only=True)
class VemContactReproduction(Reproduced):
    """Patch tests, and Hertz's problem by three pairings and with short edges."""

    patches: tuple[PatchRun, ...]
    rows: tuple[PairingRow, ...]  # by pairing
    short: tuple[PairingRow, ...]  # node-to-node with short edges, ratio 0 first for each code

    @property
    def failures(self) -> tuple[str, ...]:
        """Solutions that did not converge, and pressures that node-to-segment contact has closer to Hertz's."""
        found = [f"{row.code}, {row.pairing}: not converged" for row in (*self.rows, *self.short) if not row.converged]
        found += [f"{run.code}, {run.law}: {run.solution.status.message}" for run in self.patches if not run.converged]
        at = {(row.code, row.pairing): row.rms for row in self.rows}
        found += [
            f"{code}: the error of the pressure is {rms:.2g} node-to-node, {at[code, PAIRINGS[0]]:.2g} node-to-segment"
            for (code, pairing), rms in at.items()
            if pairing == PAIRINGS[2] and not rms < at[code, PAIRINGS[0]]
        ]
        return tuple(found)


def hertz_case(code: str, level: int, pairing: str) -> HertzCase:
    """The published discs with multipliers between the circles, in one step."""
    given = published_case(code, level, "segments")
    keys = {name: getattr(given, name) for name in given.model_fields_set} | {"pairing": pairing, "n_steps": 1}
    if pairing != "segment-to-segment":
        del keys["weighting"]
    return HertzCase.from_values(keys | ({"slack": SLACK} if pairing == "node-to-segment" else {}))


def hertz_row(code: str, level: int, pairing: str) -> PairingRow:
    """Hertz's problem by one pairing."""
    start = time.process_time()
    case = hertz_case(code, level, pairing)
    run = case.run()
    assert run.contact is not None
    return _row(f"{code}M{level}", pairing, 0.0, case, run.contact, time.process_time() - start)


def short_edge_row(code: str, level: int, ratio: float) -> PairingRow:
    """Node-to-node, with nodes beside the starts of the upper disc's edges that may touch, by a part of each edge."""
    start = time.process_time()
    case = hertz_case(code, level, "segment-to-segment")
    model = build_bodies(case.bodies())
    (contact,) = model.contacts
    sides = (contact.secondary, contact.primary)
    bodies = [side.part.body for side in sides if isinstance(side.part.body, Body)]
    meshes = [body.mesh.with_edge_set("touching", side.edges) for body, side in zip(bodies, sides, strict=True)]
    ends = meshes[0].points[sides[0].edges]
    meshes[0] = insert_nodes(meshes[0], "touching", (1.0 - ratio) * ends[:, 0] + ratio * ends[:, 1])
    meshes = list(match_boundaries(meshes[0], "touching", meshes[1], "touching"))
    surfaces = []
    for side, body, mesh in zip(sides, bodies, meshes, strict=True):
        part = Part(side.part.name, replace(body, mesh=mesh), side.part.placement)
        surfaces.append(Surface(part, mesh.edge_sets["touching"], side.curve))
    motion = {surfaces[0].part: model.motion[sides[0].part]}
    found = press([Contact(surfaces[0], surfaces[1], NodeToNode(), Multiplier())], motion)
    return _row(f"{code}M{level}", PAIRINGS[2], ratio, case, found, time.process_time() - start)


def _row(code: str, pairing: str, ratio: float, case: HertzCase, found: ContactSolution, cpu_s: float) -> PairingRow:
    theory = case.theory(float(found.forces[0, 1]))
    patch = max(pressure_patches(found.system, found.state), key=lambda each: float(each.normal_forces.sum()))
    secondary = found.system.contacts[0].secondary
    x = secondary.part.body.nodes[secondary.nodes[patch.nodes], 0]
    return PairingRow(
        code=code,
        pairing=pairing,
        ratio=ratio,
        converged=found.status.converged,
        n_unknowns=sum(2 * part.body.space.n_dofs for part in found.system.parts if isinstance(part.body, Body)),
        n_constraints=len(found.state.forces),
        iterations=found.state.status.iterations,
        cpu_s=cpu_s,
        force=float(found.forces[0, 1]),
        peak=float(patch.pressures.max()) / theory.max_pressure,
        rms=rms_from_hertz(
            x, patch.pressures, theory, theory.half_width - case.size_mm, patch.normal_forces / patch.pressures
        ),
        oscillation=patch.oscillation,
        x=x,
        pressures=patch.pressures,
        theory=theory,
    )


def reproduce_vem_contact(
    *,
    quick: bool = False,  # noqa: ARG001
    progress: Progress = lambda _: None,
) -> VemContactReproduction:
    """Compute patch tests, and Hertz's problem by three pairings and with short edges; `quick` or not."""
    start = time.perf_counter()
    patches = []
    for elements in ("VEM1", "VEM2"):
        for level, turn, laws in ((1, 0.0, tuple(LAWS)), (1, ROTATION_DEG, tuple(LAWS)), (2, 0.0, ("multiplier",))):
            for law in laws:
                code = f"{elements}M{level}" + (" rotated" if turn else "")
                progress(f"contact patch test: {code}, {law}")
                changed = {**LAWS[law], "pairing": PAIRINGS[2], "rotation_deg": turn}
                patches.append(patch_run(code, law, (elements, elements), level, changed))
    rows = []
    for code in CODES:
        for level in LEVELS:
            for pairing in PAIRINGS:
                progress(f"Hertz: {code}M{level}, {pairing}")
                rows.append(hertz_row(code, level, pairing))
    short = []
    for code in CODES[:2]:
        known = [row for row in rows if (row.code, row.pairing) == (f"{code}M{SHORT_LEVEL}", PAIRINGS[2])]
        progress(f"short edges: {code}M{SHORT_LEVEL}")
        short += [*known, *(short_edge_row(code, SHORT_LEVEL, ratio) for ratio in RATIOS)]
    numbers = (*_patch_numbers(patches), *_hertz_numbers(rows), *_short_numbers(short))
    return VemContactReproduction(
        patches=tuple(patches), rows=tuple(rows), short=tuple(short), numbers=numbers,
        seconds=time.perf_counter() - start,
    )  # fmt: skip


def _patch_numbers(patches: list[PatchRun]) -> Iterator[ReproducedNumber]:
    for run in patches:
        for quantity, value in (("pressure", run.pressure_error), ("stress", run.stress_error)):
            name = f"contact patch test: deviation of the {quantity}"
            yield compare("Figure 64", f"{run.code}, {run.law}", name, "1", (0.0, value), PATCH_LIMIT)


def _hertz_numbers(rows: list[PairingRow]) -> Iterator[ReproducedNumber]:
    for row in rows:
        required, order = row.pairing == PAIRINGS[2] and not row.code.endswith("M1"), int(row.code[3])
        words = None if required else ""
        note = "" if required else "limits are for node-to-node contact on M2 and M3"
        yield compare(
            "Hertz", row.code, f"maximum pressure over Hertz's, {row.pairing}", "1", (1.0, row.peak),
            PEAK_LIMITS[order], note, words=words,
        )  # fmt: skip
        yield compare(
            "Hertz", row.code, f"root mean square difference from Hertz's pressure, {row.pairing}", "over p0",
            (0.0, row.rms), RMS_LIMITS[order], note, words=words,
        )  # fmt: skip


def _short_numbers(short: list[PairingRow]) -> Iterator[ReproducedNumber]:
    for row in short:
        if not row.ratio:
            plain = row
            continue
        code = f"{row.code}, edges of {row.ratio:g}"
        yield compare(
            "Hertz", code, "force over that without short edges", "1", (1.0, row.force / plain.force), SAME_FORCE
        )
        yield compare(
            "Hertz", code, "error of the pressure over that without short edges", "1", (1.0, row.rms / plain.rms),
            SAME_ERROR,
        )  # fmt: skip


def hertz_rows(found: VemContactReproduction) -> list[Row]:
    """Rows of ``hertz.csv``."""
    return [row.row for row in (*found.rows, *(row for row in found.short if row.ratio))]
