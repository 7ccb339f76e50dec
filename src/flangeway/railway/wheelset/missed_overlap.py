"""Whether wheel and rail overlap where they were not looked at."""

import numpy as np
from numpy.typing import NDArray

from flangeway.contact import Surface
from flangeway.geometry import Contour
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import BodyResponse, ContactState
from flangeway.types import Floats

SPACING_MM = 0.1
ALLOWED_MM = 0.05
"""Overlap that curves between nodes and the stiff motion of what lies outside of the zones may show."""


def missed_contact(model: WheelsetModel, response: BodyResponse, state: ContactState) -> tuple[Side, ...]:
    """Sides on which the deformed profiles overlap outside of a candidate zone.

    Outside of its zone a profile moves with the nearest end of it: what bears no force is hardly strained.
    """
    found = []
    for side in SIDES:
        contact = model.contact(side)
        wheel_profile = model.problem.wheelset.wheel_of(side)
        rail_profile = model.problem.track.rail_of(side)
        curves = {
            "wheel": wheel_profile.outline.part(wheel_profile.running_names),
            "rail": rail_profile.outline.part(rail_profile.head_names),
        }
        edges = {}
        for surface in (contact.secondary, contact.primary):
            role = surface.part.name.partition("-")[0]
            edges[role] = _edge(model, response, state, surface, curves[role], lowest=role == "wheel")
        if _overlap(edges["wheel"], edges["rail"]):
            found.append(side)
    return tuple(found)


def _edge(
    model: WheelsetModel, response: BodyResponse, state: ContactState, surface: Surface, curve: Contour, *, lowest: bool
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Grid cells, outermost heights in them, and which of these lie outside of the zone."""
    nodes = model.system.nodes_of(surface)
    displacements = state.positions[nodes] - response.reference(state.placements)[nodes]
    points = curve.sampled(spacing=SPACING_MM / 2.0)
    ends = surface.part.body.space.nodes[surface.nodes[[0, -1]]]
    at = [int(np.argmin(np.linalg.norm(points - end, axis=1))) for end in ends]
    numbers = np.arange(len(points))
    outside = (numbers < min(at)) | (numbers > max(at))
    first_is_nearer = (numbers < min(at)) == (at[0] < at[1])
    placement = state.placements[model.system.parts.index(surface.part)]
    placed = placement.points(points) + np.where(first_is_nearer[:, None], displacements[0], displacements[-1])
    cells = np.rint(placed[:, 0] / SPACING_MM).astype(np.int64)
    order = np.lexsort((placed[:, 1] * (1.0 if lowest else -1.0), cells))
    chosen = order[np.concatenate(([True], np.diff(cells[order]) > 0))]
    return cells[chosen], placed[chosen, 1], outside[chosen]


def _overlap(wheel: tuple[Floats, Floats, NDArray[np.bool_]], rail: tuple[Floats, Floats, NDArray[np.bool_]]) -> bool:
    _, on_wheel, on_rail = np.intersect1d(wheel[0], rail[0], return_indices=True)
    looked_at = ~(wheel[2][on_wheel] | rail[2][on_rail])
    gap = wheel[1][on_wheel] - rail[1][on_rail]
    return bool((gap[~looked_at] < -ALLOWED_MM).any())
