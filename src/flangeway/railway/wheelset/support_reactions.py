"""What holds the bodies: reactions of the rails' bases and of the wheels' rigid cuts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.problems import LinearBody
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class SupportReaction:
    """What the support of a part does to it, beside the contact forces on it.

    The bodies are linear: forces act on them at their undeformed nodes, and moments are of those.

    - `part`: name of the part: ``rail-left`` and so on.
    - `reference_mm`: point of the moments, axes of the track, shape (2,): the middle of a rail's base, the middle of
      the axle.
    - `force_N`: force of the support on the part, axes of the track, shape (2,).
    - `moment_Nmm`: moment of the support on the part, counter-clockwise.
    - `contact_force_N`: resultant of the contact forces on the part, in the same axes.
    - `eccentricity_mm`: place of the resultant along a rail's base from its middle, away from the track; nan for a
      wheel and without a force across the base.
    - `force_error`, `moment_residual`: what is left of force and moment, over the contact force and over the sum of its
      nodes' forces times arms.
    """

    part: str
    side: Side
    reference_mm: Floats
    force_N: Floats  # noqa: N815 (the unit newton)
    moment_Nmm: float  # noqa: N815
    contact_force_N: Floats  # noqa: N815
    eccentricity_mm: float
    force_error: float
    moment_residual: float


def support_reactions(result: WheelsetResult) -> tuple[SupportReaction, ...]:
    """Reactions of all supports, from the stiffness times the displacements, in the order of the model's parts."""
    model = result.model
    on_surfaces = dict(zip((part.name for part in model.system.parts), _contact_forces(result), strict=True))
    internal = {id(body): body.elasticity.condensed_stiffness().matrix.full() for body in model.bodies}
    reactions = []
    for name, part in model.parts.items():
        body, placement = part.body, result.placements[name]
        nodes = body.space.nodes
        moves = (internal[id(body)] @ result.displacements[name][: len(nodes)].ravel()).reshape(-1, 2)
        held = np.flatnonzero(~body.free.reshape(-1, 2).all(axis=1))
        reaction = np.where(body.free.reshape(-1, 2), 0.0, moves)[held]
        surface, contact = on_surfaces[name]
        if name.startswith("wheel"):
            reference = np.array(result.equilibrium.position.axle(model.problem.wheelset))
            eccentricity = float("nan")
        else:
            middle = _middle(body, held)
            reference = placement.points([middle])[0]
            eccentricity = _eccentricity(nodes[held] - middle, reaction)
        moments = _moments(placement.points(nodes[held]) - reference, placement.vectors(reaction))
        contact_arms = placement.points(nodes[surface]) - reference
        contact_moments = _moments(contact_arms, contact)
        size = float(np.linalg.norm(contact_arms, axis=1) @ np.linalg.norm(contact, axis=1))
        force, contact_force = placement.vectors(reaction).sum(axis=0), contact.sum(axis=0)
        for array in (reference, force, contact_force):
            array.setflags(write=False)
        reactions.append(
            SupportReaction(
                name,
                "left" if name.endswith("left") else "right",
                reference,
                force,
                float(moments.sum()),
                contact_force,
                eccentricity,
                _relative(float(np.linalg.norm(force + contact_force)), float(np.linalg.norm(contact_force))),
                _relative(abs(float(moments.sum() + contact_moments.sum())), size),
            )
        )
    return tuple(reactions)


@dataclass(frozen=True)
class HoldingForce:
    """Force and moment on the wheelset where its position is prescribed, at the middle of the axle.

    - `lateral_N`, `vertical_N`: force on the wheelset, axes of the track: positive to the right and up.
    - `moment_Nmm`: moment on the wheelset, counter-clockwise, about the middle of the axle.
    """

    lateral_N: float  # noqa: N815
    vertical_N: float  # noqa: N815
    moment_Nmm: float  # noqa: N815


def holding_force(result: WheelsetResult) -> HoldingForce | None:
    """Force and moment that, with the contact forces and the load, keep the wheelset in equilibrium where it is held.

    Components that are not prescribed are zero but for the residual. None if nothing is prescribed.
    """
    if all(value is None for value in result.model.problem.prescribed.components):
        return None
    return HoldingForce(*(-result.equilibrium.residual).tolist())


def _contact_forces(result: WheelsetResult) -> list[tuple[NDArray[np.int32], Floats]]:
    """Surface nodes of each of the system's parts and the contact forces on them, axes of the track."""
    surfaces = result.model.system.surface_nodes
    ends = np.cumsum([len(surface.nodes) for surface in surfaces])[:-1]
    forces = np.split(result.equilibrium.state.nodal_forces, ends)
    return [(surface.nodes, force) for surface, force in zip(surfaces, forces, strict=True)]


def _middle(body: LinearBody, held: NDArray[np.int64]) -> Floats:
    """Middle of the held nodes' box, in the body's frame."""
    points = body.space.nodes[held]
    middle: Floats = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return middle


def _eccentricity(arms: Floats, forces: Floats) -> float:
    """Where the line of action of forces at arms (n, 2) passes the height zero; nan if they have no vertical part."""
    vertical = float(forces[:, 1].sum())
    return float(_moments(arms, forces).sum()) / vertical if vertical != 0.0 else float("nan")


def _moments(arms: Floats, forces: Floats) -> Floats:
    moments: Floats = arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]
    return moments


def _relative(error: float, reference: float) -> float:
    return error / reference if reference > 0.0 else error
