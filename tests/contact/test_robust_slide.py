"""A block that slides over the edges of another: forces must not jump as nodes pass from edge to edge."""

import pytest

from flangeway.contact import Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.contact.contact import Pairing
from flangeway.contact.enforcement import Enforcement
from flangeway.study.contact_cases import Discretisation, slide_block

SMOOTH = 0.02
QUADRATIC = Discretisation(0.1, order=2)
OTHER = Discretisation(0.083, order=2)
WAYS: dict[str, tuple[Pairing, Enforcement]] = {
    "nodes-penalty": (NodeToSegment(), Penalty(1e6, per="length")),
    "segments-penalty": (SegmentToSegment(), Penalty(1e6, per="length")),
    "segments-multiplier": (SegmentToSegment(), Multiplier()),
    "dual-multiplier": (SegmentToSegment(weighting="dual"), Multiplier()),
}


CASES = [(way, block, False) for way in WAYS for block in (QUADRATIC, OTHER)]
CASES += [("segments-penalty", OTHER, True), ("segments-multiplier", QUADRATIC, True), ("nodes-penalty", OTHER, True)]


@pytest.mark.parametrize(("way", "block", "round_edges"), CASES)
def test_smooth_over_twenty_edges(way: str, block: Discretisation, round_edges: bool) -> None:
    """The force on a quadratic block is smooth to 0.5 %, with segments node by node to 2 %, and balanced."""
    slide = slide_block(block, QUADRATIC, *WAYS[way], round_edges=round_edges, steps_per_edge=3)
    assert slide.failure == ""
    assert slide.distances[-1] == pytest.approx(20 * QUADRATIC.edge_length)
    assert slide.roughness < 0.005
    if not way.startswith("nodes"):
        assert slide.node_roughness < SMOOTH
    assert slide.imbalances.max() < 1e-10
    assert abs(slide.forces[:, 0] / slide.forces[:, 1]).max() < SMOOTH / 10.0
    assert slide.iterations.max() <= 6


def test_nodes_feel_the_edges() -> None:
    """Node by node the force of quadratic node-to-segment contact jumps by more than 2 %: the measure sees it."""
    slide = slide_block(OTHER, QUADRATIC, *WAYS["nodes-penalty"], steps_per_edge=3)
    assert slide.node_roughness > SMOOTH


@pytest.mark.parametrize("method", ["fem", "vem"])
def test_linear_multipliers(method: str) -> None:
    """With multipliers on linear elements the force is smooth to 2 % as well."""
    block, ground = Discretisation(0.083, method, 1), Discretisation(0.1, method, 1)  # type: ignore[arg-type]
    slide = slide_block(block, ground, SegmentToSegment(), Multiplier(), steps_per_edge=3)
    assert slide.failure == ""
    assert slide.roughness < SMOOTH
    assert slide.imbalances.max() < 1e-10
