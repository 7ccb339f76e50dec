"""A block that slides over the edges of another: forces must not jump as nodes pass from edge to edge."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from flangeway.contact import (
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Pairing,
    Penalty,
    SegmentToSegment,
    press,
    solve_contact,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.geometry import Arc, Line, Outline, Placement, rectangle
from tests.contact.steel_boxes import BoxDiscretisation, Method, surface_of

pytestmark = pytest.mark.ci  # costs a minute or more

SMOOTH, N_EDGES, DEPTH = 0.02, 20, 0.01
QUADRATIC = BoxDiscretisation(0.1, order=2)
OTHER = BoxDiscretisation(0.083, order=2)
WAYS: dict[str, tuple[Pairing, Enforcement]] = {
    "nodes-penalty": (NodeToSegment(), Penalty(1e6, per="length")),
    "segments-penalty": (SegmentToSegment(), Penalty(1e6, per="length")),
    "segments-multiplier": (SegmentToSegment(), Multiplier()),
    "dual-multiplier": (SegmentToSegment(weighting="dual"), Multiplier()),
}

CASES = [("nodes-penalty", OTHER, True), ("segments-penalty", OTHER, False), ("segments-multiplier", QUADRATIC, True)]
CASES += [("segments-multiplier", OTHER, False), ("dual-multiplier", OTHER, False)]


Imbalance = Callable[[ContactSolution], float]


def slid(
    block: BoxDiscretisation,
    ground: BoxDiscretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    round_edges: bool = False,
) -> list[ContactSolution]:
    """Solutions of a secondary block, 1 wide, that slides upon a primary one, 6 wide, over 20 edges, 3 for each edge.

    The block's bottom is a shallow arc instead of a line between sharp edges if they are round.
    """
    outline = sledge() if round_edges else rectangle(1.0, 1.0, centre=(0.0, 0.5))
    start = Placement(0.0, (-N_EDGES * ground.edge_length / 2.0, 0.0))
    moved = block.part("block", outline, "top", placement=start)
    rest = ground.part("ground", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    contact = Contact(surface_of(moved, "bottom"), surface_of(rest, "top"), pairing, enforcement)
    found = [press([contact], {moved: Placement(0.0, (0.0, -DEPTH))})]
    for distance in np.arange(1, 3 * N_EDGES + 1) * ground.edge_length / 3.0:
        where = {moved: Placement(0.0, (float(distance), -DEPTH)).after(start)}
        last = found[-1]
        placements = tuple(where.get(part, part.placement) for part in last.system.parts)
        state = solve_contact(last.response, last.system, placements, start=last.state)
        assert state.status.converged, f"at {distance:.6g}: {state.status.message}"
        found.append(replace(last, state=state, steps=()))
    return found


def roughness(found: list[ContactSolution]) -> tuple[float, float]:
    """Maximum distance of values from their smooth parts, parabolas along the path.

    Of the normal force over its mean, and of each node's vertical force over the maximum force of a node.
    """
    system = found[0].system
    normal = np.array([each.forces[0, 1:] for each in found])
    nodes = np.array([each.state.nodal_forces[system.nodes_of(system.contacts[0].secondary), 1] for each in found])
    powers = np.vander(np.linspace(0.0, 1.0, len(found)), 3)
    rough = [values - powers @ np.linalg.lstsq(powers, values, rcond=None)[0] for values in (normal, nodes)]
    return float(np.abs(rough[0]).max() / normal.mean()), float(np.abs(rough[1]).max() / nodes.max())


def sledge() -> Outline:
    """Block 1 wide whose bottom is an arc of radius 5."""
    radius, half = 5.0, 0.5
    rise = radius - np.sqrt(radius**2 - half**2)
    arc = Arc((-half, float(rise)), (half, float(rise)), (0.0, radius), counter_clockwise=True)
    corners = [arc.end, (half, 1.0), (-half, 1.0), arc.start]
    lines = [Line(a, b) for a, b in pairwise(corners)]
    return Outline.from_segments([arc, *lines], ["bottom", "right", "top", "left"])


@pytest.mark.parametrize(("way", "block", "round_edges"), CASES)
def test_smooth_over_twenty_edges(imbalance: Imbalance, way: str, block: BoxDiscretisation, round_edges: bool) -> None:
    """The force on a quadratic block is smooth to 0.5 %, with segments node by node to 2 %, and balanced."""
    found = slid(block, QUADRATIC, *WAYS[way], round_edges=round_edges)
    of_force, of_nodes = roughness(found)
    assert of_force < 0.005
    assert of_nodes < SMOOTH or way.startswith("nodes")
    assert max(map(imbalance, found)) < 1e-10
    assert max(abs(each.forces[0, 0] / each.forces[0, 1]) for each in found) < SMOOTH / 10.0
    assert max(each.status.iterations for each in found[1:]) <= 6


def test_nodes_feel_the_edges() -> None:
    """Node by node the force of quadratic node-to-segment contact jumps by more than 2 %: the measure sees it."""
    assert roughness(slid(OTHER, QUADRATIC, *WAYS["nodes-penalty"]))[1] > SMOOTH


@pytest.mark.parametrize("method", ["fem", "vem"])
def test_linear_multipliers(imbalance: Imbalance, method: Method) -> None:
    """With multipliers on linear elements the force is smooth to 2 % as well."""
    block, ground = BoxDiscretisation(0.083, method, 1), BoxDiscretisation(0.1, method, 1)
    found = slid(block, ground, SegmentToSegment(), Multiplier())
    assert roughness(found)[0] < SMOOTH
    assert max(map(imbalance, found)) < 1e-10
