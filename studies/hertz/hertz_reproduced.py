"""The published Hertz problem (chapter 6.2.2, Tables 9 to 14) computed again, and computed without its oscillations.

As published: node-to-segment, a penalty per node, straight edges, ten load steps. The penalty is taken as Table 10
prints it, and halved with each refinement, so that it falls with the elements' size (by 2 on M1 to 16 on M4): with that
reading the extremes of Tables 12 to 14 come out, and the pressures of Figure 76. Beside it: segment-to-segment with
multipliers weighted by biorthogonal functions, the gap measured between the circles.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np

from flangeway.cases.bodies.presets import HertzCase
from flangeway.cases.case import Progress
from flangeway.contact import ContactLinearisation, ContactSolution
from flangeway.errors import FlangewayError
from flangeway.exact import LineContact
from flangeway.post import StressLine, stresses_along
from flangeway.problems import ElasticField
from flangeway.solve import Status
from flangeway.types import Floats
from studies.published_numbers import Reproduced, ReproducedNumber, compare, published_rows

Variant = Literal["printed", "halved", "segments"]
"""Node-to-segment with the penalty printed, or halved with each refinement; segment-to-segment with multipliers."""

CODES = ("FDO1", "VVO1", "FDO2", "VVO2", "VDO2", "HEO2")
"""Method, cells and order: finite, virtual, hybrid; Delaunay, Voronoi, edge-refined (Table 8)."""
LEVELS = (1, 2, 3, 4)
QUICK_LEVELS = (1, 2, 3)
FINE = 3  # level from which the tighter limits hold

REFERENCE_FORCE = 251.84
"""Force in kN of the published reference solution, from which its p0 = 671.51 kN/cm^2 and a = 0.239 cm follow."""
EXTREMES: dict[int, tuple[Literal["principal_3", "in_plane_shear", "von_mises"], str]] = {
    12: ("principal_3", "min minimum principal stress"),
    13: ("in_plane_shear", "max maximum shear stress"),
    14: ("von_mises", "max von Mises stress"),
}
"""Published tables of extreme stresses: name among `HertzRow.extremes`, and quantity."""

STRESS_LIMIT = 0.03  # maximum relative difference from a published extreme
STRESS_CODES = ("VVO1", "VVO2")
"""Rows whose extremes have a limit; those of the others depend on the mesh through their oscillations."""
FORCE_LIMITS = {1: 0.01, 2: 0.005}
"""Maximum relative difference of the force by order; of order 2 at M1 and M2 it is that of order 1."""
EXACT_LIMITS = {"force": 0.005, "sigma_3": 0.01, "half width": 0.02, "pressure": 0.015, "oscillation": 0.005}
"""Limits of segment-to-segment contact against Hertz's theory, at order 2 on M3 and M4."""

AS_PRINTED = "(penalty as printed)"
"""Suffix of the quantities of Tables 12 to 14 computed with the penalty as Table 10 prints it."""
VARIANTS: dict[Variant, str] = {
    "printed": "node-to-segment, penalty as printed",
    "halved": "node-to-segment, penalty halved with each refinement",
    "segments": "segment-to-segment with multipliers between the circles",
}
"""Names of the variants."""

SLACK = 0.02  # nodes keep the edge that they faced within this fraction of it; otherwise some configurations cycle
METHODS = {"FD": "fem", "VD": "vem-triangles", "VV": "vem", "HE": "fem"}
PUBLISHED_DISCS: dict[str, Any] = {
    "radius_mm": 4.0,
    "lower_radius_mm": 4.0,
    "indentation_mm": 0.05,
    "thickness_mm": 1.0,
    "young_MPa": 20e3,
    "fine_arc_deg": 360.0 / 11.0,
    "body_size_mm": 0.5,
    "n_steps": 10,
}
"""Half discs that are fine along an arc about their apex (Moherdaui 2021, Figure 66)."""
LINE_POINTS = 201


def rms_from_hertz(
    x: Floats, pressures: Floats, theory: LineContact, within: float, weights: Floats | None = None
) -> float:
    """Root mean square difference of pressures from Hertz's, over its maximum, at nodes nearer than ``within``.

    - `x`, `pressures`: positions of the nodes from the middle before the deformation, and their pressures, (n,).
    - `weights`: those of the nodes, (n,); left out: all alike.
    """
    inside = np.abs(x) < within
    apart = (pressures - theory.pressure(x))[inside] / theory.max_pressure
    return float(np.sqrt(np.average(apart**2, weights=None if weights is None else weights[inside])))


@dataclass(frozen=True, eq=False)
class SurfacePressure:
    """Pressure at the nodes of the upper disc that face the lower one, from left to right."""

    x: Floats
    """Positions before the deformation, as Hertz's theory has them, shape (n,): by a second-order effect that it leaves
    out, the surface moves towards the middle (by 1.1 % in the published problem)."""
    values: Floats
    """Pressures, shape (n,): for node-to-segment the forces over the nodes' influence widths, half of the way to either
    neighbour, for segment-to-segment those of the multipliers' field."""

    @classmethod
    def of(cls, contact: ContactSolution) -> "SurfacePressure":
        """Pressure of a solution."""
        lin, pair = contact.state.linearisation, contact.system.contacts[0]
        assert isinstance(lin, ContactLinearisation)
        part, pairs = pair.secondary.part, lin.pairs[0]
        x = part.body.space.nodes[pair.secondary.nodes][:, 0]
        forces, areas = np.zeros(len(x)), np.zeros(len(x))
        np.add.at(forces, pairs.nodes, contact.state.forces)
        np.add.at(areas, pairs.nodes, pairs.areas)
        known = np.flatnonzero(areas > 0.0)
        known = known[np.argsort(x[known])]
        at, of_node = x[known], areas[known]
        if not pair.pairing.averages:  # influence widths (Moherdaui 2021, Figures 24 and 63)
            of_node = np.diff(np.concatenate((at[:1], (at[:-1] + at[1:]) / 2.0, at[-1:]))) * part.body.thickness
        return cls(at, forces[known] / of_node)

    def maximum_difference(self, theory: LineContact, margin: float = 0.0) -> float:
        """Maximum difference from Hertz's curve over p0 at nodes farther than `margin` from the contact's ends."""
        inside = np.abs(np.abs(self.x) - theory.half_width) > margin
        return float(np.abs(self.values - theory.pressure(self.x))[inside].max()) / theory.max_pressure

    @property
    def oscillation(self) -> float:
        """Root mean square difference between a loaded node and the mean of its neighbours, over the maximum pressure.

        The two loaded nodes at each end are left out, where the pressure falls steeply.
        """
        loaded = self.values[self.values > 0.0]
        if len(loaded) < 7:
            return 0.0
        apart = loaded[1:-1] - (loaded[:-2] + loaded[2:]) / 2.0
        return float(np.sqrt(np.mean(apart[1:-1] ** 2))) / float(loaded.max())


@dataclass(frozen=True, eq=False, kw_only=True)
class HertzRow:
    """One configuration on one mesh, lengths in cm, forces in kN."""

    code: str
    level: int
    variant: Variant  # code, level, variant: such as ``"VVO2"`` and 4 for VVO2 on M4; see `Variant`
    status: Status  # how it ended
    n_unknowns: int
    size: float
    """n_unknowns, size: unknowns of both discs; edge length of the upper triangles, one edge or one polygon's width."""
    iterations: tuple[int, ...]  # Newton iterations of each load step
    force: float
    half_width: float  # force, half_width: force between the discs, and half of the loaded length of the upper one
    extremes: dict[str, float]
    """Minimum principal stress, maximum shear stress in the plane and maximum von Mises stress of both discs, of each
    element at order 1, and unaveraged at all corners above."""
    theory: LineContact  # Hertz's contact under the same force
    pressure: SurfacePressure  # pressure at the nodes of the zone
    points: Floats
    nodal_forces: Floats
    """points, nodal_forces: positions of the loaded nodes of the upper disc and the forces on them, shapes (n, 2)."""
    line: StressLine  # stresses of the lower disc down the line of symmetry to a depth of 1 cm
    fields: tuple[ElasticField, ElasticField]  # displacements of the upper and the lower disc

    @property
    def name(self) -> str:
        """Published code with the mesh, such as ``VVO2M4``."""
        return f"{self.code}M{self.level}"

    @property
    def pressure_difference(self) -> float:
        """Maximum difference of the pressure from Hertz's over p0, without the element at each end of the contact."""
        return self.pressure.maximum_difference(self.theory, self.size)


@dataclass(frozen=True, eq=False, kw_only=True)
class HertzReproduction(Reproduced):
    """The Hertz problem computed again."""

    rows: tuple[HertzRow, ...]  # configurations in the order of the tables; node-to-segment first

    def of(self, variant: Variant) -> tuple[HertzRow, ...]:
        """Rows of one variant."""
        return tuple(row for row in self.rows if row.variant == variant)

    @property
    def failures(self) -> tuple[str, ...]:
        """Configurations that did not converge."""
        failed = [row for row in self.rows if not row.status.converged]
        return tuple(f"{row.name}, {VARIANTS[row.variant]}: {row.status.message}" for row in failed)


@cache
def _published() -> dict[tuple[str, str], dict[str, str]]:
    rows = published_rows("hertz_tables_9_to_14.csv")
    return {(row["table"] if row["code"] else row["quantity"], row["code"]): row for row in rows}


def published_value(key: str, code: str, level: int) -> float:
    """Published number by table and code, or by the quantity of Tables 9 and 10 without a code."""
    return float(_published()[key, code][f"M{level}"])


def published_case(code: str, level: int, variant: Variant = "printed") -> HertzCase:
    """Return a published configuration, or the same discs with segment-to-segment contact between their circles.

    The keys' mm, N and MPa stand for cm, kN and kN/cm^2. With ``"segments"`` virtual elements have their default
    stabilisation: the published one, half of the trace, is many times too stiff for the shapes of edges that
    polynomials miss, and multipliers answer to it.

    - `code`, `level`: one of `CODES`, and the mesh, 1 to 4.
    - `variant`: see `Variant`.
    """
    upper, lower = (published_value(f"element size Delaunay {side}", "", level) for side in ("slave", "master"))
    values: dict[str, Any] = {
        **PUBLISHED_DISCS,
        "method": METHODS[code[:2]],
        "order": int(code[3]),
        "halved_edges": code[1] == "E",
        "size_mm": upper,
        "lower_size_mm": lower,
    }
    if variant == "segments":
        values |= {"enforcement": "multiplier", "weighting": "dual"}
    else:
        penalty = published_value(f"penalty {'Voronoi' if code[1] == 'V' else 'Delaunay'}", "", level)
        values |= {"pairing": "node-to-segment", "slack": SLACK, "stabilisation": "trace", "curved": False}
        values |= {"enforcement": "penalty", "nodal_penalty_N_per_mm": penalty / 2.0 ** (level * (variant == "halved"))}
    return HertzCase.from_values(values)


def reproduce_hertz(
    *, quick: bool = False, levels: Sequence[int] = LEVELS, progress: Progress = lambda _: None
) -> HertzReproduction:
    """Compute all configurations again, and those of order 2 with segment-to-segment contact; without M4 if `quick`."""
    start = time.perf_counter()
    chosen = [level for level in levels if not quick or level in QUICK_LEVELS]
    rows: list[HertzRow] = []
    numbers: list[ReproducedNumber] = []
    for variant, name in VARIANTS.items():
        for code in CODES:
            for level in chosen if variant != "segments" or code.endswith("2") else ():
                progress(f"{code}M{level}, {name}")
                row = hertz_row(code, level, variant)
                rows.append(row)
                numbers += _exact_numbers(row) if variant == "segments" else _published_numbers(row)
    return HertzReproduction(rows=tuple(rows), numbers=tuple(numbers), seconds=time.perf_counter() - start)


def hertz_row(code: str, level: int, variant: Variant) -> HertzRow:
    """Compute one configuration; see `published_case`. Without any contact it is a `FlangewayError`."""
    case = published_case(code, level, variant)
    run = case.run()
    contact = run.contact
    if contact is None or not run.patches:
        raise FlangewayError(f"{code}M{level}, {VARIANTS[variant]}: {run.status.message}")
    patch, status = max(run.patches, key=lambda each: float(each.normal_forces.sum())), contact.status
    if status.converged and patch.at_edge:
        message = "contact reaches the end of its candidate zone; check the indentation and the radii"
        status = Status(False, message, status.iterations)
    force = float(contact.forces[0, 1])
    upper, lower = (run.bodies[name].field for name in ("upper", "lower"))
    spaces = (upper.problem.space, lower.problem.space)
    stresses = [body.stresses for body in run.bodies.values()]
    # the line begins below the chord that the mesh has at the apex
    below = 1.1 * case.lower_mesh_size**2 / (8.0 * case.lower_radius_mm)
    return HertzRow(
        code=code,
        level=level,
        variant=variant,
        status=status,
        n_unknowns=sum(2 * (space.n_dofs - space.n_nodes) for space in spaces)
        + sum(int(part.body.free.sum()) for part in contact.system.parts),
        size=case.size_mm,
        iterations=tuple(step.state.status.iterations for step in contact.steps),
        force=force,
        half_width=patch.half_width,
        extremes={
            "principal_3": min(float(each.principal[:, 2].min()) for each in stresses),
            "in_plane_shear": max(float(each.in_plane_shear.max()) for each in stresses),
            "von_mises": max(float(each.von_mises.max()) for each in stresses),
        },
        theory=case.theory(force),
        pressure=SurfacePressure.of(contact),
        points=patch.points,
        nodal_forces=patch.forces,
        line=stresses_along(lower, (0.0, -below), (0.0, -1.0), LINE_POINTS),
        fields=(upper, lower),
    )


def _published_numbers(row: HertzRow) -> Iterator[ReproducedNumber]:
    """Force and extremes; those of the other reading with a suffix."""
    printed = row.variant == "printed"
    limit = FORCE_LIMITS[int(row.code[3])] if row.level >= FINE else FORCE_LIMITS[1]
    note = f"published for the reference solution; {sum(row.iterations)} Newton iterations"
    if not printed:
        note += ": the lower penalty is more compliant"
    name = "force" if printed else "force (penalty halved with each refinement)"
    words = None if printed else ""
    yield compare("6.2.2", row.name, name, "kN", (REFERENCE_FORCE, row.force), limit, note, words=words)
    for table, (key, quantity) in EXTREMES.items():
        published = published_value(str(table), row.code, row.level)
        reference = published_value(str(table), "ABAQUS", row.level)
        note = _deviation(row, published, reference, row.extremes[key])
        name = f"{quantity} {AS_PRINTED}" if printed else quantity
        values, words = (published, row.extremes[key]), None if not printed and row.code in STRESS_CODES else ""
        yield compare(table, row.name, name, "kN/cm^2", values, STRESS_LIMIT, note, words=words)


def _deviation(row: HertzRow, published: float, reference: float, computed: float) -> str:
    """Pressure oscillation, and the reason for a difference."""
    oscillation = f"pressure oscillates by {100.0 * row.pressure.oscillation:.1f} % rms"
    if abs(computed / published - 1.0) <= STRESS_LIMIT:
        return oscillation
    theirs, ours = (100.0 * (value / reference - 1.0) for value in (published, computed))
    against = f"published is {theirs:+.1f} %, computed {ours:+.1f} % from the published reference {reference:g}"
    if row.variant == "printed":
        reason = "a penalty halved with each refinement gives a smaller difference"
    elif row.code == "FDO1":
        reason = "the extreme is one triangle's constant and changes by several per cent with the mesh"
    else:
        reason = "the extreme is one vertex's value and follows the oscillation of the forces, mesh by mesh"
    return f"{oscillation}; {against}: {reason}"


def _exact_numbers(row: HertzRow) -> Iterator[ReproducedNumber]:
    exact = published_case(row.code, row.level).theory(REFERENCE_FORCE)
    note = "segment-to-segment, multipliers, gap between the circles"
    fine = row.level >= FINE
    if not fine:
        note += "; limits are for M3 and M4"
    for quantity, unit, published, computed, key in (
        ("force", "kN", REFERENCE_FORCE, row.force, "force"),
        ("min minimum principal stress", "kN/cm^2", -exact.max_pressure, row.extremes["principal_3"], "sigma_3"),
        ("half width", "cm", exact.half_width, row.half_width, "half width"),
        ("maximum difference from Hertz's pressure", "over p0", 0.0, row.pressure_difference, "pressure"),
        ("oscillation of the pressure", "over p0", 0.0, row.pressure.oscillation, "oscillation"),
    ):
        words = None if fine else ""
        yield compare("Hertz", row.name, quantity, unit, (published, computed), EXACT_LIMITS[key], note, words=words)
