"""What makes a contact pressure wrong or rough although the iteration converged."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.contact import Contact, ContactState, ContactSystem, Surface
from flangeway.contact.pairs import Constraints
from flangeway.post.pressure import MIN_SEGMENTS, PressurePatch, pressure_remark
from flangeway.units import sentence

SMALL_PENETRATION = 0.05
"""Penetration over the elastic sinking of the surfaces: about the relative error that it makes in the pressure."""

MAX_PENETRATION = 1.0
MAX_PULL = 1e-9
MAX_TURN = np.deg2rad(30.0)  # turn at the end of a surface below which the boundary goes on as the same surface


@dataclass(frozen=True)
class ContactChecks:
    """What was found.

    - `errors`: sentences about what makes the result wrong.
    - `warnings`: sentences about what makes it less exact.
    """

    errors: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def check_contact(
    system: ContactSystem,
    state: ContactState,
    patches: Sequence[PressurePatch],
    names: Sequence[str],
    finer: str = "take smaller elements there",
    stiffer: str = "raise the penalty",
) -> ContactChecks:
    """Check the regions of contact of a solution, independently of the iteration that found it.

    Errors: forces or positions that are not finite, nodes that pull, and a penetration of the size of the elastic
    sinking p a / E* (maximum pressure, half width, modulus of contact; for Hertz's contact it is the height of the
    circle over the half width). Warnings: a penetration above 5 % of that, or a gap that
    a barrier leaves, straight edges in contact whose distance h^2 / 8 R from their curve is above it, regions of fewer
    than 8 segments, and a pressure that oscillates from node to node.

    Parameters
    ----------
    system, state
        The contacts and their solution.
    patches
        Its regions of contact, see `pressure_patches`.
    names
        What the contacts are called in the sentences, one for each.
    finer, stiffer
        How to get a finer mesh and a stiffer contact, for the advice.
    """
    if not (np.isfinite(state.forces).all() and np.isfinite(state.positions).all()):
        return ContactChecks(errors=("forces or positions are not finite numbers",))
    errors: list[str] = []
    warnings: list[str] = []
    solved = system.solved(state.linearisation, state.forces)
    for number, ((contact, pairs, _, forces), name) in enumerate(zip(solved, names, strict=True)):
        if forces.min(initial=0.0) < -MAX_PULL * np.abs(forces).max(initial=0.0):
            errors.append(sentence("{} pulls with {:.3g N} at a node, which contact cannot", name, -forces.min()))
        mine = [patch for patch in patches if patch.contact == number]
        depth = float(-pairs.gaps[forces > 0.0].min(initial=0.0))
        sinking = max((_sinking(contact, patch) for patch in mine), default=np.inf)
        if depth > SMALL_PENETRATION * sinking:
            too_soft = sentence(
                "the penetration of {}, {:.1e mm}, is {:.0f} % of what the surfaces sink; {}",
                name,
                depth,
                100.0 * depth / sinking,
                stiffer,
            )
            (errors if depth > MAX_PENETRATION * sinking else warnings).append(too_soft)
        # a barrier keeps surfaces apart: the mean gap by force, since at the ends of a contact it is the whole reach
        apart = float((forces * np.maximum(pairs.gaps, 0.0)).sum()) / max(float(forces.sum()), 1e-300)
        if apart > SMALL_PENETRATION * sinking:
            warnings.append(
                sentence(
                    "surfaces of {} are {:.1e mm} apart under pressure, {:.0f} % of what "
                    "they sink, and the force is too large by about as much; take a smaller barrier",
                    name,
                    apart,
                    100.0 * apart / sinking,
                )
            )
        facets = _facet_depth(contact, pairs, np.flatnonzero(forces > 0.0))
        if facets > SMALL_PENETRATION * sinking:
            drawn = contact.secondary.curve is not None and contact.primary.curve is not None
            warnings.append(
                sentence(
                    "straight edges in {} are up to {:.1e mm} off the smooth curves they approximate, "
                    "{:.0f} % of what the surfaces sink, which makes its pressures wrong; "
                    "{}{}",
                    name,
                    facets,
                    100.0 * facets / sinking,
                    "" if drawn else "give its surfaces their drawn curves (curved), or ",
                    finer,
                )
            )
        for patch in mine:
            warnings += roughness(patch.n_segments, patch.oscillation, name, finer)
    return ContactChecks(tuple(errors), tuple(warnings))


def cut_zones(system: ContactSystem, state: ContactState) -> tuple[Surface, ...]:
    """Surfaces at whose ends there is contact, while the body's boundary goes on there without a corner.

    Contact beyond such an end is missed, unless it was left out on purpose.
    """
    cut: list[Surface] = []
    for contact, pairs, _, forces in system.solved(state.linearisation, state.forces):
        loaded = np.flatnonzero(forces > 0.0)
        if len(loaded):
            cut += _cut(contact, pairs, loaded)
    return tuple(cut)


def roughness(n_segments: float, oscillation: float, name: str, finer: str) -> list[str]:
    """Sentence about a region of contact called `name` whose pressure is not reliable; none if it is."""
    remark = pressure_remark(n_segments, oscillation)
    if remark is None:
        return []
    if n_segments < MIN_SEGMENTS:
        return [f"{name} is {remark}, fewer than {MIN_SEGMENTS}; {finer} for a reliable pressure"]
    return [f"the pressure of {name} {remark} from node to node; {finer}"]


def _facet_depth(contact: Contact, pairs: Constraints, loaded: NDArray[np.int64]) -> float:
    """Sum of the maximum distances of both sides' edges in contact from the curves they approximate."""
    secondary = np.isin(contact.secondary.edge_places, pairs.nodes[loaded]).any(axis=1)
    primary = pairs.primary_edges[np.isin(pairs.rows, loaded).any(axis=1)]
    depths = contact.secondary.facet_depth[secondary], contact.primary.facet_depth[primary]
    return sum(float(each.max(initial=0.0)) for each in depths)


def _sinking(contact: Contact, patch: PressurePatch) -> float:
    """Maximum pressure times half width over the modulus of contact."""
    softness = sum(part.body.softness for part in contact.parts)
    return float(patch.pressures.max()) * patch.half_width * softness


def _cut(contact: Contact, pairs: Constraints, loaded: NDArray[np.int64]) -> list[Surface]:
    nodes, edges = pairs.nodes[loaded], pairs.primary_edges[np.isin(pairs.rows, loaded).any(axis=1)]
    ends = {
        contact.secondary: (nodes.min() == 0, nodes.max() == len(contact.secondary.nodes) - 1),
        contact.primary: (edges.min() == 0, edges.max() == len(contact.primary.edges) - 1),
    }
    found = []
    for surface, reached in ends.items():
        first, last = reached[::-1] if surface.part.placement.mirrored else reached
        if (first and _goes_on(surface, forwards=False)) or (last and _goes_on(surface, forwards=True)):
            found.append(surface)
    return found


def _goes_on(surface: Surface, *, forwards: bool) -> bool:
    """Whether the boundary has a further edge beyond an end, hardly turned against the last one."""
    body = surface.part.body
    own = surface.edges[-1 if forwards else 0]
    outer = body.boundary_edges
    beyond = outer[outer[:, 0] == own[1]] if forwards else outer[outer[:, 1] == own[0]]
    if len(beyond) != 1 or (surface.edges == beyond[0]).all(axis=1).any():
        return False
    (ax, ay), (bx, by) = (body.nodes[edge[1]] - body.nodes[edge[0]] for edge in (own, beyond[0]))
    return bool(abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)) < MAX_TURN)
