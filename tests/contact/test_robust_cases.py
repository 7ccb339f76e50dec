"""Cases that break weak contact methods and simple searches: each converges, bears what it must, and balances."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.pushed import outcome
from flangeway.contact import (
    AugmentedLagrange,
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
from flangeway.contact.node_to_segment import CONCAVE_SLACK, FOOT_SLACK, guarded_margins
from flangeway.contact.pairs import Enforcement
from flangeway.elements import Lagrange
from flangeway.geometry import Arc, Line, Outline, Placement, polygon, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, rectangle_grid, triangulate
from flangeway.problems import Body, Part
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
    solution = case.solve(settings=NewtonSettings(max_iterations=1), steps=StepSettings(smallest=1.0))
    assert not solution.status.converged
    for words in ("not converged in 1 iteration", "of 'upper' at (", "on 'lower'", "finer mesh"):
        assert words in solution.status.message


STEEL = Elastic(210e3, 0.3)
PAIRINGS = NodeToSegment(), SegmentToSegment()


def part(name: str, shape: Outline | PolyMesh, held, size: float = 1.0, **where) -> Part:
    """A body of linear triangles of a mesh, or of an outline that is meshed."""
    mesh = shape if isinstance(shape, PolyMesh) else triangulate(shape, size=size)
    return Part(name, Body(name, mesh, Lagrange(1), STEEL, held), **where)


def pressed(
    secondary: tuple[Part, tuple[str, ...]],
    primary: tuple[Part, tuple[str, ...]],
    moved: tuple[Part, tuple[float, float]],
    pairing: Pairing,
    law: Enforcement | None = None,
) -> ContactSolution:
    """Parts along edge sets in contact, one of them moved."""
    sides = (surface_of(body, *names) for body, names in (secondary, primary))
    return press([Contact(*sides, pairing, law or Multiplier())], {moved[0]: Placement(0.0, moved[1])})


def positions(solution: ContactSolution) -> tuple[np.ndarray, np.ndarray]:
    """Moved nodes of the secondary and the primary surface."""
    contact, nodes_of = solution.system.contacts[0], solution.system.nodes_of
    return solution.state.positions[nodes_of(contact.secondary)], solution.state.positions[nodes_of(contact.primary)]


def test_a_coarse_secondary_bears_by_nodes_what_it_bears_by_segments() -> None:
    """A box in elements of 2 mm on a block in elements of 0.4 mm: no node of the block stays inside of the box."""
    box = part("upper", rectangle(8.0, 4.0, centre=(0.0, 2.0)), "top", 2.0)
    block = part("lower", rectangle(20.0, 10.0, centre=(0.0, -5.0)), "bottom", 0.4)
    by_nodes, by_segments = (
        pressed((box, ("bottom",)), (block, ("top",)), (box, (0.0, -0.01)), pairing) for pairing in PAIRINGS
    )
    assert by_nodes.status.converged
    assert by_nodes.forces[0, 1] == pytest.approx(by_segments.forces[0, 1], rel=0.005)
    above, below = positions(by_nodes)
    above = above[np.argsort(above[:, 0])]
    under = below[np.abs(below[:, 0]) < 3.999]
    assert (under[:, 1] - np.interp(under[:, 0], *above.T)).max() < 1e-4


def test_a_narrow_punch_between_two_secondary_nodes_bears_by_nodes_what_it_bears_by_segments() -> None:
    """A punch 1 mm wide, pressed 0.05 mm between nodes of a block that are 4 mm apart."""
    punch = part("punch", rectangle(1.0, 2.0, centre=(1.2, 1.0)), "top", 0.5)
    block = part("block", rectangle_grid(40.0, 20.0, 10, 5, origin=(-20.0, -20.0)), "bottom")
    by_nodes, by_segments = (
        pressed((block, ("top",)), (punch, ("bottom",)), (punch, (0.0, -0.05)), pairing) for pairing in PAIRINGS
    )
    assert by_nodes.status.converged
    assert by_segments.status.converged
    assert by_nodes.forces[0, 1] == pytest.approx(by_segments.forces[0, 1], rel=0.01)


def test_a_square_on_its_corner_bears_by_segments_what_it_bears_by_nodes() -> None:
    """Held by its upper sides and pressed 0.2 mm into a block, it does not overlap the block; elements of 1 mm."""
    r = 2.0 * np.sqrt(2.0)
    corners = [(0.0, 0.0), (0.75 * r, 0.75 * r), (r, r), (0.0, 2.0 * r), (-r, r), (-0.75 * r, 0.75 * r)]
    names = ["right", "above_right", "upper_right", "upper_left", "above_left", "left"]
    die = part("die", polygon(corners, names), {"upper_right": "xy", "upper_left": "xy"})
    block = part("block", rectangle(20.0, 10.0, centre=(0.0, -5.0)), "bottom")
    by_nodes, by_segments = (
        pressed((die, ("left", "right")), (block, ("top",)), (die, (0.0, -0.2)), pairing) for pairing in PAIRINGS
    )
    assert by_segments.status.converged
    assert by_segments.forces[0, 1] == pytest.approx(by_nodes.forces[0, 1], rel=0.03)
    of_die, of_block = positions(by_segments)
    assert of_die[:, 1].min() >= of_block[:, 1].min() - 1e-9


@pytest.mark.parametrize("pairing", PAIRINGS, ids=["nodes", "segments"])
def test_a_corner_with_an_upright_side_does_not_overlap(pairing: Pairing) -> None:
    """One side of a wedge is 3 degrees from the normal of the block into which its tip is pressed by 0.2 mm."""
    points = [(0.0, 0.0), (4.0 * np.tan(np.deg2rad(3.0)), 4.0), (-4.0, 4.0)]
    die = part("die", polygon(points, ["right", "top", "left"]), "top")
    block = part("block", rectangle(20.0, 10.0, centre=(0.0, -5.0)), "bottom")
    solution = pressed((die, ("left", "right")), (block, ("top",)), (die, (0.0, -0.2)), pairing)
    assert solution.status.converged, solution.status.message
    of_die, of_block = positions(solution)
    assert of_die[:, 1].min() >= of_block[:, 1].min() - 1e-9


@pytest.mark.parametrize("pairing", PAIRINGS, ids=["nodes", "segments"])
def test_blocks_side_by_side_are_pushed_apart_sideways(pairing: Pairing) -> None:
    """Corners overlap by 0.2 mm over half an edge of 1 mm: they are not pushed along the sides, nor overlooked."""
    sides = "bottom", "left", "top"
    right = part("right", rectangle(4.0, 4.0, centre=(2.0, 3.5)), "right")
    left = part("left", rectangle(4.0, 4.0, centre=(-2.0, 0.0)), "left")
    solution = pressed((left, ("bottom", "right", "top")), (right, sides), (right, (-0.2, 0.0)), pairing)
    assert solution.status.converged, solution.status.message
    x, y = solution.forces[0]
    assert x < 0.0
    assert abs(y) < 0.2 * abs(x)


@pytest.mark.parametrize("pairing", PAIRINGS, ids=["nodes", "segments"])
def test_a_corner_pressed_on_a_corner_along_the_diagonal_is_said_to_be_arbitrary(pairing: Pairing) -> None:
    """Two blocks of 4 mm whose corners meet at the origin; with one of them aside nothing is said."""
    points = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (4.0, 4.0), (0.0, 4.0), (0.0, 3.0)])
    upper = polygon(points, ["bottom", "lower_right", "right", "top", "upper_left", "left"])
    lower = polygon(-points, ["top", "upper_left", "left", "bottom", "lower_right", "right"])
    for aside, said in ((0.0, True), (-0.5, False)):
        die = part("die", upper, {"right": "xy", "top": "xy"}, placement=Placement(0.0, (aside, 0.0)))
        block = part("block", lower, {"left": "xy", "bottom": "xy"})
        solution = pressed((die, ("left", "bottom")), (block, ("right", "top")), (die, (-0.01, -0.01)), pairing)
        assert solution.status.converged
        assert ("a corner meets a corner at (-0.01, -0.01)" in solution.status.message) == said


def test_bodies_that_overlap_where_no_contact_was_looked_for_have_not_converged() -> None:
    """A box of which the sides alone are named, pressed into a block: the message has the place and the depth."""
    outline = polygon(
        [(-8.0, 0.0), (8.0, 0.0), (8.0, 24.0), (-8.0, 24.0), (-8.0, 20.0)], ["bottom", "right", "top", "above", "left"]
    )
    for depth, converges in ((1.9, False), (1e-5, False), (-0.1, True)):
        box = part("upper", outline, "top", 8.0)
        block = part("lower", rectangle(64.0, 32.0, centre=(0.0, -16.0)), "bottom", 8.0)
        law = Penalty(1e6, per="length")
        found = pressed((box, ("left",)), (block, ("top",)), (box, (0.0, -depth)), SegmentToSegment(), law)
        assert found.status.converged == converges
        if depth > 1.0:
            for word in ("overlap by 1.9", " at (", "edges"):
                assert word in found.status.message
            assert max(each.depth for each in found.overlaps) == pytest.approx(1.9, rel=0.05)


SMOOTH, N_EDGES, DEPTH = 0.02, 20, 0.01
QUADRATIC = BoxDiscretisation(0.1, order=2)
OTHER = BoxDiscretisation(0.083, order=2)
SLIDING: dict[str, tuple[Pairing, Enforcement]] = {
    "nodes-penalty": (NodeToSegment(), Penalty(1e6, per="length")),
    "segments-penalty": (SegmentToSegment(), Penalty(1e6, per="length")),
    "segments-multiplier": (SegmentToSegment(), Multiplier()),
    "dual-multiplier": (SegmentToSegment(weighting="dual"), Multiplier()),
}

SLIDES = [("nodes-penalty", OTHER, True), ("segments-penalty", OTHER, False), ("segments-multiplier", QUADRATIC, True)]
SLIDES += [("segments-multiplier", OTHER, False), ("dual-multiplier", OTHER, False)]


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


@pytest.mark.parametrize(("way", "block", "round_edges"), SLIDES)
@pytest.mark.ci
def test_smooth_over_twenty_edges(imbalance: Imbalance, way: str, block: BoxDiscretisation, round_edges: bool) -> None:
    """The force on a quadratic block is smooth to 0.5 %, with segments node by node to 2 %, and balanced."""
    found = slid(block, QUADRATIC, *SLIDING[way], round_edges=round_edges)
    of_force, of_nodes = roughness(found)
    assert of_force < 0.005
    assert of_nodes < SMOOTH or way.startswith("nodes")
    assert max(map(imbalance, found)) < 1e-10
    assert max(abs(each.forces[0, 0] / each.forces[0, 1]) for each in found) < SMOOTH / 10.0
    assert max(each.status.iterations for each in found[1:]) <= 6


@pytest.mark.ci
def test_nodes_feel_the_edges() -> None:
    """Node by node the force of quadratic node-to-segment contact jumps by more than 2 %: the measure sees it."""
    assert roughness(slid(OTHER, QUADRATIC, *SLIDING["nodes-penalty"]))[1] > SMOOTH


@pytest.mark.parametrize("method", ["fem", "vem"])
@pytest.mark.ci
def test_linear_multipliers(imbalance: Imbalance, method: Method) -> None:
    """With multipliers on linear elements the force is smooth to 2 % as well."""
    block, ground = BoxDiscretisation(0.083, method, 1), BoxDiscretisation(0.1, method, 1)
    found = slid(block, ground, SegmentToSegment(), Multiplier())
    assert roughness(found)[0] < SMOOTH
    assert max(map(imbalance, found)) < 1e-10


@pytest.mark.parametrize(("number", "steps"), [(78, (1, 5)), (142, (5,)), (143, (1, 5)), (282, (1,))])
def test_bodies_pushed_by_loads_are_in_equilibrium(number: int, steps: tuple[int, ...]) -> None:
    """Nodes that pass a corner, or are at a joint that hardly turns: no search cycles, and forces are equal."""
    found = outcome(number, steps)
    assert all(found.converged), found.messages
    assert found.touches
    assert found.wrong == ()


@pytest.mark.parametrize(
    ("turn", "order", "margin"), [(0.1, 1, CONCAVE_SLACK), (1e-3, 1, FOOT_SLACK), (0.1, 2, FOOT_SLACK)]
)
def test_points_behind_a_joint_have_one_edge_where_it_is_smooth(turn: float, order: int, margin: float) -> None:
    """Two edges of a bore: chords that turn leave out points behind their joint, which tangential arcs do not."""
    angles = turn * np.linspace(-1.0, 1.0, 2 * order + 1)
    points = np.column_stack((np.sin(angles), np.cos(angles)))
    edges = np.stack([points[: order + 1], points[order:]])
    assert guarded_margins(edges).tolist() == [[FOOT_SLACK, margin], [margin, FOOT_SLACK]]
