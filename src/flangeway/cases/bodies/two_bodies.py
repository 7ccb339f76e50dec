"""The general case: bodies of any shape with supports, loads, motions and contacts."""

import time
from collections.abc import Sequence
from dataclasses import replace

from flangeway.cases.bodies.bodies_model import BodiesModel, BodyModel, build_bodies
from flangeway.cases.bodies.bodies_run import XY, BodiesCase, BodiesRun, BodyResult
from flangeway.cases.bodies.bodies_tables import BodiesInputs, ContactTable
from flangeway.cases.case import Progress, example_of
from flangeway.contact import ContactSolution, press
from flangeway.errors import InputError
from flangeway.post import check_contact, cut_zones, pressure_patches, relative_nodal_residual
from flangeway.quantities import Quantity
from flangeway.solve import ElasticitySolution, Status, StepSettings, solve_elasticity
from flangeway.units import sentence

MAX_NODAL_RESIDUAL = 1e-6  # see `relative_nodal_residual`; a correct solution has round-off, below 1e-9

MIN_STEP = 1.0 / 1024.0  # fraction of all loads and motions below which a step is not halved any more
ROUND_OFF = 1e-9  # overlap relative to the size of a body that is no overlap


class TwoBodiesCase(BodiesInputs, BodiesCase):
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
                Quantity("push", "push", lambda _: push.load[:2], "N", "z.6g", XY),
                Quantity("pushed", "displacement by the push", "pushed_mm", "mm", ".6g"),
            )
        bodies = [part.body for part in run.contact.system.parts]
        sliding = [body.name for body in bodies if len(body.freedom.axes) == 1 and body.supported.any()]
        if len(sliding) != 1:
            return ()
        return (
            Quantity("sliding_body", "sliding body", lambda _: sliding[0]),
            Quantity("slid", "its displacement", lambda r: r.shift(sliding[0]), "mm", "z.6g", XY),
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
        sentence(
            "{} on {}: the surfaces overlapped by {:.3g mm} before any "
            "motion; the overlap is removed as an interference fit, which interference = true calls intended.",
            pair.secondary.part.name,
            pair.primary.part.name,
            depth,
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
    if status.checks is None or not contact.forces.any():
        return status, ()
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
