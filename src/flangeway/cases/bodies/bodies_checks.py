"""Whether bodies that were pressed are an answer: every check that stands between a result and its user."""

import numpy as np

from flangeway.cases.bodies.bodies_model import BodiesModel
from flangeway.cases.bodies.pressing import Pressed, moved_part
from flangeway.post import check_contact, cut_zones, deepest_overlap, nodal_imbalance, pressure_patches
from flangeway.problems import ElasticField
from flangeway.solve import Status

MAX_IMBALANCE = 1e-6
"""See `nodal_imbalance`; what is found without fault has round-off, below 1e-9."""

SHARE_OF_BODY = 0.25
"""Motion between two looks for an overlap on the way, over the smaller side of the smaller body."""
MOST_STOPS = 200


def checked_bodies(pressed: Pressed, model: BodiesModel) -> tuple[Status, tuple[str, ...]]:
    """Return the final status, and warnings about what makes the result less exact.

    Errors, which make the status that of a failure besides an overlap (see `ContactSolution.overlaps`): those of
    `check_contact`, nodes that are not in balance, and a body that was carried through another one. The status says as
    well if nothing touches.

    Parameters
    ----------
    pressed
        What was found.
    model
        The bodies and what presses them.

    """
    status, contact = pressed.status, pressed.contact
    if not (status.converged or contact.overlapped):
        return status, ()
    if status.converged and not contact.forces.any() and model.push is None:
        overlaps = _carried_through(model)
        message = "; ".join(overlaps) or f"{status.message}; nothing touches"
        return Status(not overlaps, message, status.iterations), ()
    patches = pressure_patches(contact.system, contact.state)
    names = [
        f"the contact of {each.secondary.part.name} on {each.primary.part.name}" for each in contact.system.contacts
    ]
    checks = check_contact(contact.system, contact.state, patches, names)
    errors = [*checks.errors, *_unbalanced(pressed, model)]
    if errors and status.converged:
        status = Status(False, "; ".join(errors), status.iterations)
    missing = (
        f"{surface.part.name}: there is contact at the end of the edges that were given for it, and its boundary goes "
        "on there: contact beyond is missing; give more edges, unless they were left out on purpose"
        for surface in cut_zones(contact.system, contact.state)
    )
    return status, (*checks.warnings, *missing)


def _carried_through(model: BodiesModel) -> list[str]:
    """Pairs that do not touch at the end, and would overlap on the way."""
    errors = []
    for one, other in {(each.secondary.part, each.primary.part) for each in model.contacts}:
        pair = (one, other)
        places = [moved_part(part, model.motion, 1.0).points(part.body.mesh.points) for part in pair]
        starts = [part.placement.points(part.body.mesh.points) for part in pair]
        travel = sum(float(np.hypot(*(end - start).T).max()) for start, end in zip(starts, places, strict=True))
        smallest = min(float(np.ptp(start, axis=0).min()) for start in starts)
        n_stops = min(int(np.ceil(travel / (SHARE_OF_BODY * smallest))), MOST_STOPS)
        for stop in range(1, n_stops):
            share = stop / n_stops
            meshes = [part.body.mesh.placed(moved_part(part, model.motion, share)) for part in pair]
            if deepest_overlap(*meshes) is not None:
                errors.append(
                    f"{one.name} and {other.name} would overlap after {100.0 * share:.3g} % of the motion and do not "
                    "touch at its end: one was carried through the other; move it less, or in smaller steps "
                    "(steps.number)"
                )
                break
    return sorted(errors)


def _unbalanced(pressed: Pressed, model: BodiesModel) -> list[str]:
    """Bodies in contact whose nodes are not in balance."""
    errors = []
    for body in model.bodies.values():
        if body.part is not None:
            back = pressed.placement(body.part).inverse()
            forces = back.vectors(pressed.contact.nodal_forces(body.part))
            field = ElasticField(body.problem, pressed.contact.field(body.part).displacements)
            left = nodal_imbalance(field, forces, ~body.part.body.free.reshape(-1, 2))
            if not left <= MAX_IMBALANCE:
                errors.append(
                    f"{body.name}: {left:.1e} of the largest nodal force is not in balance; raise this with the case "
                    "file as a fault, unless its cells are of very different sizes or its materials of very different "
                    "moduli"
                )
    return errors
