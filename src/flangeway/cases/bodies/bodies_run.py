"""The general case: bodies of any shape with supports, loads, motions and contacts, and what came out of it."""

import dataclasses
import time
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.case import RunnableCase, example_of
from flangeway.cases.summary import RunResult
from flangeway.contact import Contact, ContactSolution, LoadStep, press
from flangeway.contact.bodies_model import BodiesModel, BodyModel, build_bodies
from flangeway.contact.contact_records import BodiesProblem, ContactTable
from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.geometry import Placement
from flangeway.geometry.arrays import norms
from flangeway.post import (
    PressurePatch,
    Stresses,
    cell_stresses,
    check_contact,
    corner_stresses,
    cut_zones,
    nodal_residual,
    pressure_patches,
    relative_nodal_residual,
)
from flangeway.problems import ElasticField
from flangeway.quantities import Quantities, Quantity, values
from flangeway.solve import ElasticitySolution, Status, StepSettings, solve_elasticity
from flangeway.types import Floats, Progress

# --- What came out of a case of bodies that are pressed, pulled and held: one kind of result for all of them.


XY = ("x", "y")


@dataclass(frozen=True, eq=False)
class BodyResult:
    """One body.

    Parameters
    ----------
    field
        Elastic displacements in the body's frame, mm.
    placement
        Rigid motion of the body's frame.
    contact_force, load
        Resultants of the contacts and of the loads on a body in contact, N, shape (2,); None without contact.

    """

    field: ElasticField
    placement: Placement = dataclasses.field(default_factory=Placement)
    contact_force: Floats | None = None
    load: Floats | None = None

    def moved(self, points: Floats, displacements: Floats) -> Floats:
        """Whole motion in space of points (n, 2) of the body with elastic displacements (n, 2), shape (n, 2)."""
        motion: Floats = self.placement.points(points + displacements) - points
        return motion

    @property
    def supports_force(self) -> Floats | None:
        """Resultant of the supports on a body in contact, which balances the others, N, shape (2,)."""
        return None if self.contact_force is None or self.load is None else -self.contact_force - self.load

    @property
    def max_displacement(self) -> float:
        """Maximum distance that a node has moved from its initial position, mm."""
        space = self.field.space
        return float(norms(self.moved(space.nodes, self.field.displacements[: space.n_nodes])).max())

    @cached_property
    def stresses(self) -> Stresses:
        """Stresses of each cell, or of higher orders at the corners of the cells, MPa."""
        of = cell_stresses if self.field.space.order == 1 else corner_stresses
        return of(self.field.problem, self.field.displacements)


@dataclass(frozen=True, eq=False)
class PairResult:
    """A contact of two bodies.

    Parameters
    ----------
    solution, number
        The solution of all contacts, and the number of this one.
    patches
        Its regions of contact.

    """

    solution: ContactSolution
    number: int
    patches: list[PressurePatch]

    @property
    def contact(self) -> Contact:
        """The pair of surfaces."""
        return self.solution.system.contacts[self.number]

    @property
    def sides(self) -> tuple[str, str]:
        """Names of the secondary and the primary body."""
        return self.contact.secondary.part.name, self.contact.primary.part.name

    @property
    def name(self) -> str:
        """Both bodies."""
        return " on ".join(self.sides)

    @property
    def fullest(self) -> PressurePatch | None:
        """Region with the maximum pressure; None where nothing touches."""
        return max(self.patches, key=lambda patch: patch.max_pressure, default=None)

    @property
    def remark(self) -> str | None:
        """Why the maximum pressure is approximate."""
        return None if self.fullest is None else self.fullest.remark

    @cached_property
    def nodes(self) -> dict[str, NDArray[Any]]:
        """Columns of the nodes with friction: forces, pressure, traction, slip, and whether it sticks."""
        table = {name: np.asarray(column) for name, column in self.solution.friction_table.columns.items()}
        return {name: column[table["contact"] == self.number] for name, column in table.items()}

    @property
    def sticking_share(self) -> float:
        """Fraction of the length in contact that sticks."""
        lengths = np.divide(self.nodes["normal_force"], self.nodes["pressure"])
        return float(lengths[self.nodes["sticks"]].sum() / max(lengths.sum(), np.finfo(float).tiny))


@dataclass(frozen=True, eq=False)
class SupportForce:
    """Force of a support, by the number of its table, on its body in space; N, shape (2,)."""

    number: int
    body: str
    force: Sequence[float]


MAX_DISPLACEMENT: Quantity[BodyResult] = Quantity(
    "max_displacement", "maximum displacement", lambda body: body.max_displacement, "mm", ".6g"
)
MAX_VON_MISES: Quantity[BodyResult] = Quantity(
    "max_von_mises", "maximum von Mises stress", lambda body: body.stresses.von_mises.max(), "MPa", ".6g"
)
BODY: Quantities[BodyResult] = (
    Quantity("name", "body", lambda body: body.field.problem.name),
    Quantity("elements", "elements", lambda body: body.field.space.mesh.n_cells, form=","),
    Quantity("unknowns", "unknowns", lambda body: 2 * body.field.space.n_nodes, form=","),
    MAX_DISPLACEMENT,
    MAX_VON_MISES,
    Quantity("min_principal", "minimum principal stress", lambda b: b.stresses.principal[:, 2].min(), "MPa", ".6g"),
    Quantity(
        *("max_in_plane_shear", "maximum in-plane shear stress"),
        lambda b: b.stresses.in_plane_shear.max(),
        "MPa",
        ".6g",
    ),
)
FORCES: Quantities[BodyResult] = (
    Quantity("body", "body", lambda body: body.field.problem.name),
    Quantity("contact", "contact", lambda body: body.contact_force, "N", ".6g", XY),
    Quantity("loads", "loads", lambda body: body.load, "N", ".6g", XY),
    Quantity("supports", "supports", lambda body: body.supports_force, "N", ".6g", XY),
)
HALF_WIDTH: Quantity[PressurePatch] = Quantity(
    "half_width", "half width of contact", lambda patch: patch.half_width, "mm", ".6g"
)
PATCH_PRESSURE: Quantity[PressurePatch] = Quantity(
    "max_pressure", "maximum pressure", lambda patch: patch.max_pressure, "MPa", ".6g", remark=lambda p: p.remark
)
REMARK: Quantity[PressurePatch | PairResult] = Quantity(
    "max_pressure_remark", "", lambda of: of.remark, meaning="why it is approximate"
)
AT_EDGE: Quantity[PressurePatch] = Quantity(
    "reaches_an_end", "reaches an end of the surface", lambda patch: patch.at_edge
)
PATCH: Quantities[PressurePatch] = (
    Quantity("centre", "centre of pressure", lambda patch: patch.centre, "mm", ".6g", XY),
    HALF_WIDTH,
    PATCH_PRESSURE,
    REMARK,
    Quantity("force", "force on the secondary body", lambda patch: patch.force, "N", ".6g", XY),
    AT_EDGE,
)
SIDES: Quantities[PairResult] = (
    Quantity("secondary", "secondary", lambda pair: pair.sides[0]),
    Quantity("primary", "primary", lambda pair: pair.sides[1]),
)
MAX_PRESSURE: Quantity[PairResult] = Quantity(
    "max_pressure",
    "maximum pressure",
    lambda pair: 0.0 if pair.fullest is None else pair.fullest.max_pressure,
    "MPa",
    ".6g",
    remark=lambda pair: pair.remark,
)
PAIR: Quantities[PairResult] = (
    *SIDES,
    Quantity("force_on_secondary", "force on it", lambda pair: pair.solution.forces[pair.number], "N", ".6g", XY),
    Quantity(
        *("initial_penetration", "initial overlap"), lambda p: p.solution.initial_penetration[p.number], "mm", ".6g"
    ),
    MAX_PRESSURE,
    REMARK,
)
STICKING: Quantity[PairResult] = Quantity(
    "sticking_share", "sticking fraction", lambda pair: pair.sticking_share, form=".3f"
)
DISSIPATED: Quantity[PairResult] = Quantity(
    "dissipated", "dissipated work", lambda pair: pair.solution.dissipated_by_contact[pair.number], "N mm", ".6g"
)
FRICTION: Quantities[PairResult] = (
    *SIDES,
    Quantity("coefficient", "coefficient", lambda pair: pair.contact.friction_coefficient, form="g"),
    Quantity("tangential_force", "tangential force", lambda p: p.nodes["tangential_force"].sum(), "N", ".6g"),
    Quantity(
        *("max_traction", "maximum traction"), lambda p: np.abs(p.nodes["traction"]).max(initial=0.0), "MPa", ".6g"
    ),
    Quantity(
        "max_slip_in_step",
        "maximum slip in the last step",
        lambda pair: np.abs(pair.nodes["slip"]).max(initial=0.0),
        "mm",
    ),
    STICKING,
    DISSIPATED,
)
REACTION: Quantities[SupportForce] = (
    Quantity("number", "support", lambda support: support.number, form="d"),
    Quantity("body", "body", lambda support: support.body),
    Quantity("force", "force on it", lambda support: support.force, "N", ".6g", XY),
)


@dataclass(frozen=True, eq=False)
class BodiesRun(RunResult):
    """A case and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    status
        How it ended.
    bodies
        Displacements by the names of the bodies.
    timings_s
        Seconds by stage.
    contact
        The contacts, None for bodies without.
    model
        Bodies with supports and loads, None where the case has no tables of them.
    notices
        What the reader should know.

    """

    main_table = "bodies"

    case: "BodiesCase"
    status: Status
    bodies: Mapping[str, BodyResult]
    timings_s: Mapping[str, float]
    contact: ContactSolution | None = None
    model: BodiesModel | None = None
    notices: Sequence[str] = ()

    def parts(self) -> dict[str, Any]:
        """See `RunResult.parts`; `results` are the numbers that the case is about."""
        return {
            "results": values(self.case.quantities(self), self),
            "forces": [values(FORCES, body) for body in self.in_contact],
            "contacts": [
                values(PAIR, pair) | {"patches": [values(PATCH, patch) for patch in pair.patches]}
                for pair in self.pairs
            ],
            "friction": [values(FRICTION, pair) for pair in self.rubbing],
            "bodies": [values(BODY, body) for body in self.bodies.values()],
            "supports": [values(REACTION, reaction) for reaction in self.reactions],
            "notices": self.notices,
        }

    @property
    def in_contact(self) -> list[BodyResult]:
        """Bodies in contact."""
        return [body for body in self.bodies.values() if body.contact_force is not None]

    @cached_property
    def patches(self) -> list[PressurePatch]:
        """Regions of contact."""
        return [] if self.contact is None else pressure_patches(self.contact.system, self.contact.state)

    @cached_property
    def pairs(self) -> list[PairResult]:
        """The contacts with their regions."""
        contact = self.contact
        n_contacts = 0 if contact is None else len(contact.system.contacts)
        return [
            PairResult(contact, number, [patch for patch in self.patches if patch.contact == number])
            for number in range(n_contacts)
            if contact is not None
        ]

    @property
    def rubbing(self) -> list[PairResult]:
        """The contacts with friction."""
        return [pair for pair in self.pairs if pair.contact.friction_coefficient]

    @property
    def theory(self) -> LineContact | None:
        """Hertz's solution, where the case has one."""
        return self.case.theory_of(self)

    @property
    def reactions(self) -> list[SupportForce]:
        """Force of each support on its body, in the order of the tables; none where it has not converged.

        Supports that fix the same component of a node share its reaction.
        """
        if self.model is None or not self.status.converged:
            return []
        rows = {name: iter(self._reactions(name)) for name in self.bodies}
        return [SupportForce(n, body, next(rows[body])) for n, body in enumerate(self.model.supported, 1)]

    def _reactions(self, name: str) -> list[list[float]]:
        """Force of each support of a body, x and y."""
        assert self.model is not None
        body, result = self.model.bodies[name], self.bodies[name]
        supports = body.problem.prescribed
        if not supports:
            return []
        n_nodes = body.problem.space.n_nodes
        forces = np.zeros((n_nodes, 2))
        if body.part is not None and self.contact is not None:
            forces = result.placement.inverse().vectors(self.contact.nodal_forces(body.part))
        residual = nodal_residual(result.field, forces)[:n_nodes]
        fixed = np.zeros((len(supports), n_nodes, 2))  # 1 where a support fixes a component of a node
        for row, support in zip(fixed, supports, strict=True):
            row[body.problem.support_nodes(support)] = [support.x is not None, support.y is not None]
        of_supports = (fixed * (residual / np.maximum(fixed.sum(axis=0), 1))).sum(axis=1)
        rows: list[list[float]] = result.placement.vectors(of_supports).tolist()
        return rows

    def shift(self, name: str) -> Floats:
        """Shift of the supports of a body in contact beyond its given motions, mm, shape (2,)."""
        assert self.model is not None
        part = self.model.bodies[name].part
        assert part is not None
        placement = part.placement
        for leg in self.model.legs:
            placement = leg.get(part, Placement()).after(placement)
        return np.subtract(self.bodies[name].placement.translation, placement.translation)

    @property
    def pushed_mm(self) -> float | None:
        """How far a push moved its body along the force; None without a push."""
        push = None if self.model is None else self.model.push
        return None if push is None else float(self.shift(push.parts[0].name) @ push.directions[0])

    def at_step(self, step: LoadStep) -> dict[str, BodyResult]:
        """Displacements of all bodies at one of the load steps of `contact`; those in no contact carry its share."""
        share = min(step.share, 1.0)
        assert self.contact is not None
        results = {
            name: BodyResult(ElasticField(body.field.problem, share * body.field.displacements), body.placement)
            for name, body in self.bodies.items()
        }
        solution = replace(self.contact, state=step.state)
        for part in solution.system.parts:
            results[part.name] = BodyResult(solution.field(part), solution.placement(part))
        return results


class BodiesCase(RunnableCase):
    """A case of bodies, in contact or not."""

    @abstractmethod
    def quantities(self, run: BodiesRun) -> Sequence[Quantity[BodiesRun]]:
        """Return the numbers that the case is about, shown first."""

    def theory_of(self, run: BodiesRun) -> LineContact | None:  # noqa: ARG002 (cases without Hertz's solution)
        """Return Hertz's solution for the force of a run, where the case has one."""
        return None


# --- The general case: bodies of any shape with supports, loads, motions and contacts.


MAX_NODAL_RESIDUAL = 1e-6  # see `relative_nodal_residual`; a correct solution has round-off, below 1e-9

MIN_STEP = 1.0 / 1024.0  # fraction of all loads and motions below which a step is not halved any more
ROUND_OFF = 1e-9  # overlap relative to the size of a body that is no overlap


class TwoBodiesCase(BodiesProblem, BodiesCase):
    """Bodies, one, two or more, in the plane; all positions are in common axes, x to the right and y up."""

    name = "two-bodies"
    title = "Bodies of any shape with supports, loads, motions and contacts"
    essential = ("thickness_mm", "hypothesis")
    example = example_of(name)

    def check(self) -> None:
        """See `RunnableCase.check`; the bodies are meshed."""
        build_bodies(self)

    def run(self, progress: Progress = lambda _: None) -> BodiesRun:
        """See `RunnableCase.run`."""
        start = time.perf_counter()
        progress("meshing the bodies")
        model = build_bodies(self)
        meshed = time.perf_counter()
        alone = {name: _alone(body, progress) for name, body in model.bodies.items() if body.part is None}
        status = _worst([solution.status for solution in alone.values()])
        contact: ContactSolution | None = None
        notices = list(model.notices)
        if model.contacts:
            contact = self._pressed(model, progress)
            in_contact, warnings = checked_bodies(contact, model)
            status = _worst([in_contact, status])
            notices += [*_overlaps(contact, self.contacts), *warnings]
        notices += filter(None, [body.problem.locking for body in model.bodies.values() if body.part is None])
        results = {}
        for name, body in model.bodies.items():
            if body.part is None or contact is None:
                results[name] = BodyResult(alone[name])
            else:
                force = contact.nodal_forces(body.part).sum(axis=0)
                results[name] = BodyResult(contact.field(body.part), contact.placement(body.part), force, body.load)
        timings = {"meshing": meshed - start, "total": time.perf_counter() - start}
        return BodiesRun(self, status, results, timings, contact, model, notices)

    def quantities(self, run: BodiesRun) -> Sequence[Quantity[BodiesRun]]:
        """How far a push, or loads, moved a body along what its supports leave free."""
        if run.model is None or run.contact is None:
            return ()
        push = run.model.push
        if push is not None:
            return (
                Quantity("pushed_body", "pushed body", lambda _: push.parts[0].name),
                Quantity("push", "push", lambda _: push.load[:2], "N", ".6g", XY),
                Quantity("pushed", "displacement by the push", lambda run: run.pushed_mm, "mm", ".6g"),
            )
        bodies = [part.body for part in run.contact.system.parts]
        sliding = [body.name for body in bodies if len(body.freedom.axes) == 1 and body.supported.any()]
        if len(sliding) != 1:
            return ()
        return (
            Quantity("sliding_body", "sliding body", lambda _: sliding[0]),
            Quantity("slid", "its displacement", lambda r: r.shift(sliding[0]), "mm", ".6g", XY),
        )

    def _pressed(self, model: BodiesModel, progress: Progress) -> ContactSolution:
        progress("condensing the bodies to their surfaces")
        sizes, given = None, self.steps.number
        if given is not None or not any(pair.friction_coefficient for pair in model.contacts):
            step = 1.0 / (given or 1)
            sizes = StepSettings(step, step, min(step, MIN_STEP))
        handles = [] if model.push is None else [model.push]
        legs, loads = list(model.legs), model.body_loads
        return press(model.contacts, legs, body_loads=loads, handles=handles, steps=sizes, progress=progress)


def _worst(statuses: Sequence[Status]) -> Status:
    """The first failure; otherwise the first."""
    failed = [status for status in statuses if not status.converged]
    return [*failed, *statuses, Status(True, "the forces are in equilibrium", 0)][0]


def _alone(body: BodyModel, progress: Progress) -> ElasticitySolution:
    """A body without contact."""
    if not body.problem.loads and not any(support.x or support.y for support in body.problem.prescribed):
        raise InputError(
            f"body {body.name!r}, which has no load, no prescribed displacement and no contact",
            "a load, a prescribed displacement or a contact for each body",
            "add [[loads]], a displacement in [[supports]], or a contact",
        )
    progress(f"solving for {body.name}")
    return solve_elasticity(body.problem)


def _overlaps(contact: ContactSolution, tables: Sequence[ContactTable]) -> list[str]:
    """Warnings about overlaps before any motion that are not intended."""
    return [
        (
            f"{pair.secondary.part.name} on {pair.primary.part.name}: the surfaces overlapped by {depth:.3g} mm "
            "before any motion; the overlap is removed as an interference fit, which interference = true calls "
            "intended."
        )
        for pair, depth, table in zip(contact.system.contacts, contact.initial_penetration, tables, strict=True)
        if depth > ROUND_OFF * contact.system.parts[0].body.elasticity.size and not table.interference
    ]


def checked_bodies(contact: ContactSolution, model: BodiesModel) -> tuple[Status, tuple[str, ...]]:
    """Return the final status, and warnings about what makes the result less exact.

    Errors, which make the status that of a failure besides an overlap (see `ContactSolution.overlaps`): those of
    `check_contact`, nodes that are not in equilibrium, and a body that moved through another one. The message also
    says if nothing touches.

    - `model`: the bodies and their loads.
    """
    status = contact.status
    if status.checks is None:
        return status, ()
    measured = status.checks.warnings
    if status.converged:  # they are warnings of the case, not words of its first line
        status = replace(status, message=status.message.removesuffix("; ".join(("", *measured))))
    if not contact.state.forces.any():
        return status, measured
    patches = pressure_patches(contact.system, contact.state)
    names = [
        f"the contact of {pair.secondary.part.name} on {pair.primary.part.name}" for pair in contact.system.contacts
    ]
    checks = check_contact(contact.system, contact.state, patches, names)
    errors = [*checks.errors, *_residual_errors(contact, model)]
    if errors and status.converged:
        status = replace(status, converged=False, message="; ".join(errors))
    missing = (
        f"{surface.part.name}: there is contact at the end of the given edges, and the boundary continues: contact "
        "beyond is missing; give more edges, unless they were left out on purpose"
        for surface in cut_zones(contact.system, contact.state)
    )
    return status, (*measured, *checks.warnings, *missing)


def _residual_errors(contact: ContactSolution, model: BodiesModel) -> list[str]:
    """Bodies in contact whose nodes are not in equilibrium."""
    errors = []
    for body in model.bodies.values():
        if body.part is not None:
            forces = contact.placement(body.part).inverse().vectors(contact.nodal_forces(body.part))
            left = relative_nodal_residual(contact.field(body.part), forces, ~body.part.body.free.reshape(-1, 2))
            if not left <= MAX_NODAL_RESIDUAL:
                errors.append(
                    f"{body.name}: the nodal residual is {left:.1e} of the maximum nodal force; report this with the "
                    "case file as a defect, unless its elements have very different sizes or its materials very "
                    "different moduli"
                )
    return errors
