"""What came out of a case of bodies that are pressed, pulled and held: one kind of result for all of them."""

import dataclasses
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from flangeway.cases.bodies.bodies_model import BodiesModel, BodyModel
from flangeway.cases.bodies.bodies_tables import BodiesInputs
from flangeway.cases.case import Case, Progress, RunnableCase
from flangeway.cases.summary import RunResult, StatusSummary, Summary, SummaryPart
from flangeway.contact import ContactSolution, LoadStep
from flangeway.exact import LineContact
from flangeway.geometry import Placement
from flangeway.post import PressurePatch, cell_stresses, corner_stresses, nodal_residual, pressure_patches
from flangeway.problems import ElasticField, PrescribedDisplacement
from flangeway.solve import Status
from flangeway.types import Floats

# ruff: noqa: N815 (units in names)


@dataclass(frozen=True)
class PatchSummary(SummaryPart):
    """A region of contact."""

    centre_mm: Sequence[float]
    half_width_mm: float
    max_pressure_MPa: float
    max_pressure_remark: str | None
    force_N: Sequence[float]
    reaches_an_end: bool


@dataclass(frozen=True, kw_only=True)
class PairSummary(SummaryPart):
    """A contact of two bodies."""

    secondary: str
    primary: str
    force_on_secondary_N: Sequence[float]
    initial_penetration_mm: float
    max_pressure_MPa: float
    max_pressure_remark: str | None
    patches: Sequence[PatchSummary]


@dataclass(frozen=True, kw_only=True)
class FrictionSummary(SummaryPart):
    """Friction of a contact: tractions, slips and the sticking share of the length in contact at the end, and work."""

    secondary: str
    primary: str
    coefficient: float
    tangential_force_N: float
    max_traction_MPa: float
    max_slip_in_step_mm: float
    sticking_share: float
    dissipated_N_mm: float


@dataclass(frozen=True, kw_only=True)
class BodySummary(SummaryPart):
    """A body: size of its mesh, and extreme values."""

    name: str
    elements: int
    unknowns: int
    max_displacement_mm: float
    max_von_mises_MPa: float
    min_principal_MPa: float
    max_in_plane_shear_MPa: float


@dataclass(frozen=True)
class ForcesSummary(SummaryPart):
    """Forces on a body in contact."""

    body: str
    contact_N: Sequence[float]
    loads_N: Sequence[float]
    supports_N: Sequence[float]


@dataclass(frozen=True)
class ReactionRow(SummaryPart):
    """Force of a support on its body."""

    number: int
    body: str
    force_N: Sequence[float]


@dataclass(frozen=True, kw_only=True)
class BodiesSummary(Summary):
    """What ``summary.json`` holds of such a case; `results` are the numbers that the case is about, by name."""

    results: dict[str, Any]
    forces: Sequence[ForcesSummary] = ()
    contacts: Sequence[PairSummary]
    friction: Sequence[FrictionSummary] = ()
    bodies: Sequence[BodySummary]
    supports: Sequence[ReactionRow] = ()
    notices: Sequence[str]


@dataclass(frozen=True, eq=False)
class BodyResult:
    """One body.

    Parameters
    ----------
    field
        Elastic displacements in the body's frame, mm.
    placement
        Rigid motion of the body's frame.

    """

    field: ElasticField
    placement: Placement = dataclasses.field(default_factory=Placement)

    def moved(self, points: Floats, displacements: Floats) -> Floats:
        """Whole motion in space of points (n, 2) of the body with elastic displacements (n, 2), shape (n, 2)."""
        motion: Floats = self.placement.points(points + displacements) - points
        return motion


@dataclass(frozen=True, eq=False)
class BodiesRun(RunResult):
    """A case and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    status
        How it ended.
    summary
        What ``summary.json`` holds.
    bodies
        Displacements by the names of the bodies.
    contact
        The contacts, None for bodies without.
    theory
        Hertz's solution, where the case has one.

    """

    main_table: ClassVar[str] = "bodies"

    case: Case
    status: Status
    summary: BodiesSummary
    bodies: Mapping[str, BodyResult]
    contact: ContactSolution | None = None
    theory: LineContact | None = None

    @property
    def patches(self) -> list[PressurePatch]:
        """Regions of contact."""
        return [] if self.contact is None else pressure_patches(self.contact.system, self.contact.state)

    def at_step(self, step: LoadStep) -> dict[str, BodyResult]:
        """Displacements of all bodies at one of the load steps of `contact`; those in no contact carry its share."""
        share = min(step.share, 1.0)
        assert self.contact is not None
        found = {
            name: BodyResult(ElasticField(body.field.problem, share * body.field.displacements), body.placement)
            for name, body in self.bodies.items()
        }
        there = replace(self.contact, state=step.state)
        for part in there.system.parts:
            found[part.name] = BodyResult(there.field(part), there.placement(part))
        return found


class BodiesCase(RunnableCase):
    """A case of bodies, in contact or not."""

    @abstractmethod
    def run(self, progress: Progress = lambda _: None) -> BodiesRun:
        """See `RunnableCase.run`."""


def summarise_bodies(
    case: Case,
    status: Status,
    bodies: Mapping[str, BodyResult],
    contact: ContactSolution | None,
    timings_s: Mapping[str, float],
    *,
    results: Mapping[str, Any],
    forces: Sequence[ForcesSummary] = (),
    supports: Sequence[ReactionRow] = (),
    notices: Sequence[str] = (),
) -> BodiesSummary:
    """Return the summary of such a case.

    - `bodies`: displacements by the names of the bodies.
    - `contact`: the contacts, if there are any.
    - `timings_s`: seconds by stage.
    - `results`: what this case is about, shown first.
    - `forces`, `supports`: forces on the bodies in contact, and of the supports.
    - `notices`: what the reader should know.
    """
    return BodiesSummary(
        status=StatusSummary(status.converged, status.message),
        results=dict(results),
        forces=forces,
        contacts=[] if contact is None else _contacts(contact),
        friction=[] if contact is None else _friction(contact),
        bodies=[_body(name, body) for name, body in bodies.items()],
        supports=supports,
        notices=notices,
        timings_s=dict(timings_s),
        case={"name": case.name, **case.model_dump()},
    )


def _body(name: str, body: BodyResult) -> BodySummary:
    problem, values = body.field.problem, body.field.displacements
    space = problem.space
    of = cell_stresses if space.order == 1 else corner_stresses
    stresses = of(problem, values)
    return BodySummary(
        name=name,
        elements=space.mesh.n_cells,
        unknowns=2 * space.n_nodes,
        max_displacement_mm=np.hypot(*body.moved(space.nodes, values[: space.n_nodes]).T).max(),
        max_von_mises_MPa=stresses.von_mises.max(),
        min_principal_MPa=stresses.principal[:, 2].min(),
        max_in_plane_shear_MPa=stresses.in_plane_shear.max(),
    )


def _contacts(contact: ContactSolution) -> list[PairSummary]:
    patches = pressure_patches(contact.system, contact.state)
    rows = []
    for number, each in enumerate(contact.system.contacts):
        mine = [
            PatchSummary(
                *(patch.centre.tolist(), patch.half_width, patch.pressures.max(), patch.remark),
                *(patch.force.tolist(), patch.at_edge),
            )
            for patch in patches
            if patch.contact == number
        ]
        most = max(mine, key=lambda patch: patch.max_pressure_MPa, default=None)
        rows.append(
            PairSummary(
                secondary=each.secondary.part.name,
                primary=each.primary.part.name,
                force_on_secondary_N=contact.forces[number].tolist(),
                initial_penetration_mm=contact.initial_penetration[number],
                max_pressure_MPa=0.0 if most is None else most.max_pressure_MPa,
                max_pressure_remark=None if most is None else most.max_pressure_remark,
                patches=mine,
            )
        )
    return rows


def _friction(contact: ContactSolution) -> list[FrictionSummary]:
    table = {name: np.asarray(values) for name, values in contact.friction_table.columns.items()}
    rows, works = [], contact.dissipated_by_contact
    for number, each in enumerate(contact.system.contacts):
        if not each.friction_coefficient:
            continue
        mine = table["contact"] == number
        lengths = np.divide(table["normal_force"], table["pressure"])[mine]
        rows.append(
            FrictionSummary(
                secondary=each.secondary.part.name,
                primary=each.primary.part.name,
                coefficient=each.friction_coefficient,
                tangential_force_N=float(table["tangential_force"][mine].sum()),
                max_traction_MPa=float(np.abs(table["traction"][mine]).max(initial=0.0)),
                max_slip_in_step_mm=float(np.abs(table["slip"][mine]).max(initial=0.0)),
                sticking_share=float(lengths[table["sticks"][mine]].sum() / max(lengths.sum(), 1e-300)),
                dissipated_N_mm=float(works[number]),
            )
        )
    return rows


def support_reactions_of(
    case: BodiesInputs, model: BodiesModel, results: Mapping[str, BodyResult], contact: ContactSolution | None
) -> list[ReactionRow]:
    """Force of each support on its body in space, in the order of the case's tables.

    Supports that fix the same component of a node share its reaction.
    """
    reactions = {name: iter(_reactions(body, results[name], contact)) for name, body in model.bodies.items()}
    return [ReactionRow(n, table.body, next(reactions[table.body])) for n, table in enumerate(case.supports, 1)]


def _reactions(body: BodyModel, result: BodyResult, contact: ContactSolution | None) -> list[list[float]]:
    """Force of each support of a body, x and y."""
    problem = body.problem
    if not problem.prescribed:
        return []
    forces = np.zeros((problem.space.n_nodes, 2))
    if body.part is not None and contact is not None:
        forces = result.placement.inverse().vectors(contact.nodal_forces(body.part))
    residual = nodal_residual(result.field, forces)[: problem.space.n_nodes]
    fixed = np.array([_fixed_by(body, support) for support in problem.prescribed])
    forces_of = fixed * (residual / np.maximum(fixed.sum(axis=0), 1))
    rows: list[list[float]] = result.placement.vectors(forces_of.sum(axis=1)).tolist()
    return rows


def _fixed_by(body: BodyModel, support: PrescribedDisplacement) -> Floats:
    """Which components of which nodes a support fixes: 1 or 0, shape (n_nodes, 2)."""
    fixed = np.zeros((body.problem.space.n_nodes, 2))
    fixed[body.problem.support_nodes(support)] = [support.x is not None, support.y is not None]
    return fixed
