"""The general case: bodies of any shape with supports, loads, motions and contacts."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from flangeway.cases.bodies.bodies_model import BodiesModel, BodyModel, build_bodies
from flangeway.cases.bodies.bodies_run import (
    BodiesCase,
    BodiesRun,
    BodyResult,
    ForcesSummary,
    summarise_bodies,
    support_reactions_of,
)
from flangeway.cases.bodies.bodies_tables import BodiesInputs, ContactTable
from flangeway.cases.case import Progress
from flangeway.contact import ContactSolution, press
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.post import check_contact, cut_zones, pressure_patches, relative_nodal_residual
from flangeway.problems import Part
from flangeway.solve import ElasticitySolution, Status, StepSettings, solve_elasticity
from flangeway.types import Floats

MAX_NODAL_RESIDUAL = 1e-6  # see `relative_nodal_residual`; a correct solution has round-off, below 1e-9

SMALLEST_STEP = 1.0 / 1024.0
"""Share of all loads and motions below which a step is not halved any more."""


class TwoBodiesCase(BodiesInputs, BodiesCase):
    """Bodies, one, two or more, in the plane; all positions are in common axes, x to the right and y up."""

    name: ClassVar[str] = "two-bodies"
    title: ClassVar[str] = "Bodies of any shape with supports, loads, motions and contacts"
    essential: ClassVar[tuple[str, ...]] = ("thickness_mm", "hypothesis")
    example: ClassVar[Mapping[str, Any]] = {
        "bodies": [
            {
                "name": "cylinder",
                "young_MPa": 210e3,
                "poisson": 0.3,
                "disc": {"radius_mm": 40.0, "centre_mm": [0.0, 40.0], "half": "lower"},
                "method": "fem",
                "order": 1,
                "size_mm": 5.0,
                "fine": [{"at_mm": [[-1.5, 0.0], [1.5, 0.0]], "size_mm": 0.08, "growth": 0.15}],
            },
            {
                "name": "block",
                "rectangle": {"width_mm": 160.0, "height_mm": 80.0, "centre_mm": [0.0, -40.0]},
                "method": "vem",
                "order": 1,
                "size_mm": 8.0,
                "fine": [{"at_mm": [[-1.5, 0.0], [1.5, 0.0]], "size_mm": 0.1, "growth": 0.15}],
            },
        ],
        "supports": [{"body": "cylinder", "edges": "cut"}, {"body": "block", "edges": "bottom"}],
        "motions": [{"body": "cylinder", "push_N": [0.0, -2000.0]}],
        "contacts": [
            {
                "secondary": "cylinder",
                "secondary_edges": "rim",
                "secondary_box_mm": [-8.0, -1.0, 8.0, 2.0],
                "primary": "block",
                "primary_edges": "top",
                "primary_box_mm": [-10.0, -1.0, 10.0, 1.0],
            }
        ],
    }

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
        results = {name: BodyResult(solution) for name, solution in alone.items()}
        status = _worst([solution.status for solution in alone.values()])
        contact: ContactSolution | None = None
        checks: tuple[str, ...] = ()
        if model.contacts:
            contact = self._pressed(model, progress)
            in_contact, checks = checked_bodies(contact, model)
            status = _worst([in_contact, status])
            for name, body in model.bodies.items():
                if body.part is not None:
                    results[name] = BodyResult(contact.field(body.part), contact.placement(body.part))
        in_order = {name: results[name] for name in model.bodies}
        summary = summarise_bodies(
            self,
            status,
            in_order,
            contact,
            {"meshing": meshed - start, "total": time.perf_counter() - start},
            results={} if contact is None else _moved_by_forces(contact, model),
            forces=[] if contact is None else _forces(contact, model),
            supports=support_reactions_of(self, model, in_order, contact) if status.converged else [],
            notices=[*model.notices, *_notices(contact, self.contacts), *checks],
        )
        return BodiesRun(self, status, summary, in_order, contact)

    def _pressed(self, model: BodiesModel, progress: Progress) -> ContactSolution:
        progress("condensing the bodies to their surfaces")
        sizes, given = None, self.steps.number
        if given is not None or not any(each.friction_coefficient for each in model.contacts):
            step = 1.0 / (given or 1)
            sizes = StepSettings(step, step, min(step, SMALLEST_STEP))
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


def _notices(contact: ContactSolution | None, tables: Sequence[ContactTable]) -> list[str]:
    if contact is None:
        return []
    return [
        f"{each.secondary.part.name} on {each.primary.part.name}: the surfaces overlapped by {depth:.3g} mm before any "
        "motion; the overlap is removed as an interference fit, which interference = true calls intended."
        for each, depth, table in zip(contact.system.contacts, contact.initial_penetration, tables, strict=True)
        if depth > 1e-9 * contact.system.parts[0].body.elasticity.size and not table.interference
    ]


def _moved_by_forces(contact: ContactSolution, model: BodiesModel) -> dict[str, Any]:
    """How far a push, or loads, moved a body along what its supports leave free."""
    if model.push is not None:
        (part,), load = model.push.parts, model.push.load[:2]
        moved = float(_moved(contact, part, model) @ model.push.directions[0])
        return {"pushed_body": part.name, "push_N": load.tolist(), "pushed_mm": moved}
    sliding = [part for part in contact.system.parts if len(part.body.freedom.axes) == 1 and part.body.supported.any()]
    if len(sliding) != 1:
        return {}
    return {"sliding_body": sliding[0].name, "slid_mm": _moved(contact, sliding[0], model).tolist()}


def _moved(contact: ContactSolution, part: Part, model: BodiesModel) -> Floats:
    """Shift (2,) of a part's supports beyond its given motions."""
    given = part.placement
    for leg in model.legs:
        given = leg.get(part, Placement()).after(given)
    return np.subtract(contact.placement(part).translation, given.translation)


def _forces(contact: ContactSolution, model: BodiesModel) -> list[ForcesSummary]:
    rows = []
    for body in model.bodies.values():
        if body.part is not None:
            on_body, loads = contact.nodal_forces(body.part).sum(axis=0), body.load_N
            rows.append(ForcesSummary(body.name, on_body.tolist(), loads.tolist(), (-on_body - loads).tolist()))
    return rows


def checked_bodies(contact: ContactSolution, model: BodiesModel) -> tuple[Status, tuple[str, ...]]:
    """Return the final status, and warnings about what makes the result less exact.

    Errors, which make the status that of a failure besides an overlap (see `ContactSolution.overlaps`): those of
    `check_contact`, nodes that are not in equilibrium, and a body that moved through another one. The message also
    says if nothing touches.

    - `model`: the bodies and their loads.
    """
    status = contact.status
    if status.checks is None or not contact.forces.any():
        return status, ()
    patches = pressure_patches(contact.system, contact.state)
    names = [
        f"the contact of {each.secondary.part.name} on {each.primary.part.name}" for each in contact.system.contacts
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
    return status, (*checks.warnings, *missing)


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
