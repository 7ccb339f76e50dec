"""A block that slides over the edges of another: forces must not jump as nodes pass from edge to edge."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

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

Floats = NDArray[np.float64]

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


@dataclass(frozen=True, eq=False)
class Slide:
    """Forces of a block that slides.

    Parameters
    ----------
    distances
        How far it has moved, shape (n,).
    forces
        Force on it at each place, shape (n, 2).
    node_forces
        Vertical contact forces of the block's surface nodes at each place, shape (n, n_nodes).
    imbalances
        Maximum difference of force or moment between both sides over the force, shape (n,).
    iterations
        Newton iterations of each step, shape (n,).
    failure
        Message of the step that did not converge, empty if all did; the arrays end before it.

    """

    distances: Floats
    forces: Floats
    node_forces: Floats
    imbalances: Floats
    iterations: NDArray[np.int64]
    failure: str

    @property
    def roughness(self) -> float:
        """Maximum distance of the normal force from its smooth part, a parabola along the path, over its mean."""
        normal = self.forces[:, 1]
        return float(np.abs(self._rough(normal[:, None])).max() / normal.mean())

    @property
    def node_roughness(self) -> float:
        """The same for the force of each node, over the maximum force of a node."""
        return float(np.abs(self._rough(self.node_forces)).max() / self.node_forces.max())

    def _rough(self, values: Floats) -> Floats:
        """Values (n, m) less their parabolas along the path."""
        powers = np.vander(self.distances / max(float(self.distances[-1]), np.finfo(np.float64).tiny), 3)
        rest: Floats = values - powers @ np.linalg.lstsq(powers, values, rcond=None)[0]
        return rest


def slide_block(
    imbalance: Imbalance,
    block: BoxDiscretisation,
    ground: BoxDiscretisation,
    pairing: Pairing,
    enforcement: Enforcement,
    *,
    round_edges: bool = False,
) -> Slide:
    """Press a secondary block, 1 wide, upon a primary one, 6 wide, and slide it over 20 edges in 3 steps for each.

    The block's bottom is a shallow arc instead of a line between sharp edges if they are round.
    """
    outline = sledge() if round_edges else rectangle(1.0, 1.0, centre=(0.0, 0.5))
    start = Placement(0.0, (-N_EDGES * ground.edge_length / 2.0, 0.0))
    moved = block.part("block", outline, "top", placement=start)
    rest = ground.part("ground", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    contact = Contact(surface_of(moved, "bottom"), surface_of(rest, "top"), pairing, enforcement)
    pressed = press([contact], {moved: Placement(0.0, (0.0, -DEPTH))})
    system, response, state = pressed.system, pressed.response, pressed.state
    distances = np.arange(3 * N_EDGES + 1) * ground.edge_length / 3.0
    forces, at_nodes, imbalances, iterations = [], [], [], []
    failure = "" if state.status.converged else state.status.message
    for distance in distances:
        if failure:
            break
        where = {moved: Placement(0.0, (float(distance), -DEPTH)).after(start)}
        placements = tuple(where.get(part, part.placement) for part in system.parts)
        state = solve_contact(response, system, placements, start=state)
        if not state.status.converged:
            failure = f"at {distance:.6g}: {state.status.message}"
            break
        solution = ContactSolution(system, response, state, (), pressed.initial_penetration)
        forces.append(solution.forces[0])
        at_nodes.append(state.nodal_forces[system.nodes_of(contact.secondary), 1])
        imbalances.append(imbalance(solution))
        iterations.append(state.status.iterations)
    return Slide(
        distances[: len(forces)], np.array(forces).reshape(-1, 2), np.array(at_nodes), np.array(imbalances),
        np.array(iterations), failure,
    )  # fmt: skip


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
    slide = slide_block(imbalance, block, QUADRATIC, *WAYS[way], round_edges=round_edges)
    assert slide.failure == ""
    assert slide.distances[-1] == pytest.approx(N_EDGES * QUADRATIC.edge_length)
    assert slide.roughness < 0.005
    if not way.startswith("nodes"):
        assert slide.node_roughness < SMOOTH
    assert slide.imbalances.max() < 1e-10
    assert abs(slide.forces[:, 0] / slide.forces[:, 1]).max() < SMOOTH / 10.0
    assert slide.iterations.max() <= 6


def test_nodes_feel_the_edges(imbalance: Imbalance) -> None:
    """Node by node the force of quadratic node-to-segment contact jumps by more than 2 %: the measure sees it."""
    slide = slide_block(imbalance, OTHER, QUADRATIC, *WAYS["nodes-penalty"])
    assert slide.node_roughness > SMOOTH


@pytest.mark.parametrize("method", ["fem", "vem"])
def test_linear_multipliers(imbalance: Imbalance, method: Method) -> None:
    """With multipliers on linear elements the force is smooth to 2 % as well."""
    block, ground = BoxDiscretisation(0.083, method, 1), BoxDiscretisation(0.1, method, 1)
    slide = slide_block(imbalance, block, ground, SegmentToSegment(), Multiplier())
    assert slide.failure == ""
    assert slide.roughness < SMOOTH
    assert slide.imbalances.max() < 1e-10
