"""Cases that break weak contact methods: each converges, bears what it must, and its forces balance."""

from collections.abc import Callable

import numpy as np
import pytest

from flangeway.contact import (
    AugmentedLagrange,
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Pairing,
    Penalty,
    SegmentToSegment,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.geometry import Outline, Placement, polygon, rectangle
from flangeway.solve import NewtonSettings, StepSettings
from tests.contact.steel_boxes import (
    BoxDiscretisation,
    ContactCase,
    Method,
    pressed_boxes,
    surface_of,
)

BALANCED = 1e-10
WAYS: dict[str, tuple[Pairing, Enforcement]] = {
    "nodes-penalty": (NodeToSegment(), Penalty(1e6, per="length")),
    "nodes-multiplier": (NodeToSegment(), Multiplier()),
    "segments-penalty": (SegmentToSegment(), Penalty(1e6, per="length")),
    "segments-augmented": (SegmentToSegment(), AugmentedLagrange(1e6, per="length", penetration=1e-6)),
    "segments-multiplier": (SegmentToSegment(), Multiplier()),
    "dual-multiplier": (SegmentToSegment(weighting="dual"), Multiplier()),
}
SIDES = {
    "T3": (BoxDiscretisation(0.2), BoxDiscretisation(0.23)),
    "T6": (BoxDiscretisation(0.2, order=2), BoxDiscretisation(0.23, order=2)),
    "VEM2-T3": (BoxDiscretisation(0.3, "vem", 2), BoxDiscretisation(0.2)),
}
EACH_WAY = pytest.mark.parametrize(
    ("way", "sides"),
    list(zip(WAYS.values(), (SIDES[name] for name in ("VEM2-T3", "T6", "T3", "T6", "VEM2-T3", "T6")), strict=True)),
    ids=WAYS,
)
"""Each way to pair and to press, on one of the meshes."""
Solve = Callable[[ContactCase], ContactSolution]


def moved(x: float, y: float) -> Placement:
    return Placement(0.0, (x, y))


def block_on_long_block(
    sides: tuple[BoxDiscretisation, BoxDiscretisation],
    way: tuple[Pairing, Enforcement],
    *,
    secondary: str = "upper",
    round_the_corner: bool = False,
    depth: float = 0.02,
) -> ContactCase:
    """A block 2 wide and 1 high pressed upon one 6 wide and 2 high: contact up to sharp edges.

    The surface of the upper block may go round its corners and up its sides.
    """
    outline = block_with_ears() if round_the_corner else rectangle(2.0, 1.0, centre=(0.0, 0.5))
    short = sides[0].part("upper", outline, "top")
    long = sides[1].part("lower", rectangle(6.0, 2.0, centre=(0.0, -1.0)), "bottom")
    names = ("left", "bottom", "right") if round_the_corner else ("bottom",)
    surfaces = [surface_of(short, *names), surface_of(long, "top")]
    if secondary == "lower":
        surfaces.reverse()
    return ContactCase((Contact(*surfaces, *way),), {short: moved(0.0, -depth)})


def block_with_ears() -> Outline:
    """Outline of the short block whose sides are cut below the held top, which no contact surface may touch."""
    points = [(-1.0, 0.0), (1.0, 0.0), (1.0, 0.7), (1.0, 1.0), (-1.0, 1.0), (-1.0, 0.7)]
    return polygon(points, ["bottom", "right", "upper_right", "top", "upper_left", "left"])


def block_into_corner(
    sides: tuple[BoxDiscretisation, BoxDiscretisation],
    way: tuple[Pairing, Enforcement],
    *,
    as_one: bool = False,
    gap: float = 0.01,
    motion: tuple[float, float] = (-0.02, -0.03),
) -> ContactCase:
    """A block, at first a gap away from the floor and the wall of one body, is moved into their corner.

    There is one contact of surfaces with a corner, or one contact for the floor and one for the wall that share the
    block's corner node.
    """
    outline = polygon(
        [(-1.0, -1.0), (2.0, -1.0), (2.0, 0.0), (0.0, 0.0), (0.0, 2.0), (-1.0, 2.0)],
        ["base", "right", "floor", "wall", "top", "back"],
    )
    corner = sides[1].part("walls", outline, {"base": "xy", "back": "xy"})
    square = polygon(
        [(0.0, 0.0), (1.0, 0.0), (1.2, 0.2), (1.2, 1.2), (0.2, 1.2), (0.0, 1.0)],
        ["bottom", "lower_right", "right", "top", "upper_left", "left"],
    )
    pressed = sides[0].part("block", square, {"right": "xy", "top": "xy"}, placement=moved(gap, gap))
    if as_one:
        pairs = [(surface_of(pressed, "left", "bottom"), surface_of(corner, "floor", "wall"))]
    else:
        pairs = [
            (surface_of(pressed, "bottom"), surface_of(corner, "floor")),
            (surface_of(pressed, "left"), surface_of(corner, "wall")),
        ]
    contacts = tuple(Contact(secondary, primary, *way) for secondary, primary in pairs)
    return ContactCase(contacts, {pressed: moved(*motion)})


@pytest.fixture(scope="module")
def solved(imbalance: Callable[[ContactSolution], float]) -> Solve:
    """Solve a case, which must converge and be balanced."""

    def solve(case: ContactCase) -> ContactSolution:
        solution = case.solve()
        assert solution.status.converged, solution.status.message
        assert imbalance(solution) < BALANCED
        assert (solution.state.forces >= 0.0).all()
        return solution

    return solve


@pytest.mark.parametrize(("secondary", "round_the_corner"), [("upper", True), ("lower", False)])
@EACH_WAY
def test_short_block_on_long_one(
    solved: Solve,
    way: tuple[Pairing, Enforcement],
    sides: tuple[BoxDiscretisation, BoxDiscretisation],
    secondary: str,
    round_the_corner: bool,
) -> None:
    """Contact up to sharp edges bears 402 kN, whichever side is secondary, also if the surface goes round the edges."""
    case = block_on_long_block(sides, way, secondary=secondary, round_the_corner=round_the_corner)
    solution = solved(case)
    sign = 1.0 if secondary == "upper" else -1.0
    assert sign * solution.forces[0, 1] == pytest.approx(402.0, rel=0.05)
    assert abs(solution.forces[0, 0]) < 0.002 * abs(solution.forces[0, 1])
    lower = case.part("lower")
    loaded = np.abs(solution.nodal_forces(lower)).max(axis=1) > 0.0
    reach = 1.0 + 1.1 * max(side.edge_length for side in sides)
    assert np.abs(lower.body.space.nodes[loaded, 0]).max() < reach


@EACH_WAY
def test_block_into_a_corner(
    solved: Solve, way: tuple[Pairing, Enforcement], sides: tuple[BoxDiscretisation, BoxDiscretisation]
) -> None:
    """Two contacts that share the corner's node and one contact of surfaces with a corner bear the same forces."""
    apart = solved(block_into_corner(sides, way))
    as_one = solved(block_into_corner(sides, way, as_one=True))
    total = apart.forces.sum(axis=0)
    assert total == pytest.approx([252.0, 360.0], rel=0.12)
    # by nodes, the corner's node has one edge to face in one contact, two in two; with a penalty, a node that gets a
    # constraint of its own makes the contact stiffer there
    near = 0.08 if isinstance(way[0], NodeToSegment) else 0.02 if isinstance(way[1], Penalty) else 1e-6
    assert as_one.forces[0] == pytest.approx(total, rel=near)


@pytest.mark.parametrize(
    ("way", "method", "order"),
    [
        ("nodes-multiplier", "fem", 2),
        ("nodes-penalty", "vem", 1),
        ("segments-multiplier", "vem", 2),
        ("segments-augmented", "fem", 1),
        ("dual-multiplier", "fem", 2),
    ],
)
def test_matching_meshes(solved: Solve, way: str, method: Method, order: int) -> None:
    """Meshes that match node by node converge without hopping and pass the contact patch test."""
    side = BoxDiscretisation(0.25, method, order)
    case = pressed_boxes(side, side, *WAYS[way])
    solution = solved(case)
    assert len(solution.steps) == 1
    pressures = solution.state.forces / np.concatenate([pairs.areas for pairs in solution.state.linearisation.pairs])  # type: ignore[attr-defined]
    assert np.ptp(pressures) < 1e-8 * pressures.mean()


@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=["nodes", "segments"])
def test_bodies_that_do_not_meet(solved: Solve, pairing: Pairing) -> None:
    """Bodies that stay apart, out of reach or nearly touching, bear nothing, which is said, and converge at once."""
    for gap in (5.0, 0.05):
        solution = solved(block_into_corner(SIDES["T3"], (pairing, Multiplier()), gap=gap))
        assert (solution.forces == 0.0).all()
        assert solution.status.message.endswith("; nothing touches")


@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=["nodes", "segments"])
def test_a_block_dropped_from_afar(solved: Solve, pairing: Pairing) -> None:
    """A block that starts out of reach of the corner bears what it bears if it starts near."""
    near = solved(block_into_corner(SIDES["T3"], (pairing, Multiplier())))
    far = solved(block_into_corner(SIDES["T3"], (pairing, Multiplier()), gap=3.0, motion=(-3.01, -3.02)))
    assert far.forces == pytest.approx(near.forces, rel=1e-9, abs=1e-9 * near.forces.max())


def test_a_failure_says_where_and_what_to_try() -> None:
    """An iteration that is cut short names contact nodes, their places, and what may help."""
    case = block_on_long_block(SIDES["T6"], WAYS["nodes-penalty"], round_the_corner=True, depth=0.3)
    solution = case.solve(settings=NewtonSettings(max_iterations=2), steps=StepSettings(smallest=1.0))
    assert not solution.status.converged
    for words in ("not converged in 2 iterations", "of 'upper' at (", "on 'lower'", "take smaller steps"):
        assert words in solution.status.message
