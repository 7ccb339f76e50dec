"""Parts whose rigid motions contact and loads decide: forces from statics, equilibrium, symmetry, bad inputs."""

import numpy as np
import pytest

from flangeway.contact import (
    AugmentedLagrange,
    Barrier,
    Contact,
    Multiplier,
    NodeToSegment,
    Penalty,
    SegmentToSegment,
    Surface,
    solve_contact,
)
from flangeway.contact import press as press_parts
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement, circle, polygon
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.problems import Body, Part
from flangeway.solve import CondensedBodies, StepSettings, SurfaceNodes
from tests.contact.steel_boxes import surface_of

STEEL = Elastic(20e3, 0.3)
MODULUS = 20e3 / (1.0 - 0.3**2)  # of plane strain
PAIRINGS = [SegmentToSegment(), NodeToSegment()]
LAWS = [
    *(Multiplier(), Penalty(1e7, per="length"), AugmentedLagrange(1e6, per="length", penetration=1e-8)),
    Barrier(1e-6, 1e-3),
]
WAYS = pytest.mark.parametrize(
    ("pairing", "law"),
    [(PAIRINGS[1], LAWS[0]), (PAIRINGS[0], LAWS[2]), (PAIRINGS[0], LAWS[3])],
    ids=["nodes-multiplier", "segments-augmented", "segments-barrier"],
)
EQUILIBRIUM = 1e-10


def block(name, width, height, held=None, at=(0.0, 0.0), cells=(5, 3), element=None, turned=0.0) -> Part:
    """A block with its lower left corner at a point."""
    mesh = rectangle_grid(width, height, *cells)
    return Part(name, Body(name, mesh, element or Lagrange(1), STEEL, held), Placement(turned, at))


def disc(name, radius, size, held=None, at=(0.0, 0.0), turned=0.0) -> tuple[Part, Surface]:
    """A disc about its own origin, and its surface on the circle."""
    outline = circle(radius)
    mesh = triangulate(outline, size=size)
    part = Part(name, Body(name, mesh, Lagrange(1), STEEL, held), Placement(turned, at))
    return part, Surface(part, mesh.boundary_edges, outline)


def unbalanced(solution, part: Part) -> float:
    """Resultant force and moment about the origin of the contacts on a part, over their forces and its size."""
    total, scale = np.zeros(3), 0.0
    for contact, forces in zip(solution.system.contacts, solution.resultants, strict=True):
        for surface, mine in ((contact.secondary, forces[0]), (contact.primary, forces[1])):
            if surface.part is part:
                total += mine
                scale += np.linalg.norm(mine[:2])
    return float(np.abs(total / (scale * np.array([1.0, 1.0, part.body.elasticity.size]))).max())


def stack(pairing, law, element=None, *, force=100.0, held=((0.0, 0.0), "x")):
    """Three blocks of one width upon each other; the middle one may slide up and turn, the top one is pressed down."""
    base = block("base", 2.0, 1.0, {"bottom": "y", (0.0, 0.0): "x"}, element=element)
    middle = block("middle", 2.0, 1.5, dict([held]) if held else None, (0.0, 1.0), (7, 2), element)
    top = block("top", 2.0, 1.0, {"top": "y", (0.0, 1.0): "x"}, (0.0, 2.5), (4, 2), element)
    contacts = [
        Contact(surface_of(middle, "bottom"), surface_of(base, "top"), pairing, law),
        Contact(surface_of(top, "bottom"), surface_of(middle, "top"), pairing, law),
    ]
    return press_parts(contacts, {}, loads={top: (None, -force, None)})


@pytest.mark.parametrize(
    ("element", "law"),
    [(Lagrange(1), LAWS[0]), (Lagrange(2), LAWS[1]), (Virtual(1), LAWS[2]), (Lagrange(2), LAWS[3])],
    ids=str,
)
def test_a_stack_is_pressed_uniformly(element, law) -> None:
    """Blocks that only contact holds upright pass a uniform pressure on: strain and forces are exact."""
    solution = stack(SegmentToSegment(), law, element)
    assert solution.status.converged, solution.status.message
    np.testing.assert_allclose(solution.forces, [[0.0, 100.0]] * 2, atol=1e-8)
    for part in solution.system.parts:
        moved = solution.field(part).displacements[: part.body.space.n_nodes]
        x, y = part.body.space.nodes.T
        y = y - (1.0 if part.name == "top" else 0.0)
        exact = 50.0 / MODULUS * np.stack((0.3 / 0.7 * x, -y), axis=1)
        np.testing.assert_allclose(moved, exact, atol=1e-4 * np.abs(exact).max())


def on_a_wide_base(pairing, law, friction=(0.0, 0.0)):
    """Contacts of a block that nothing holds with a wide base below and a block above it; that block, and itself."""
    base = block("base", 4.0, 1.0, "bottom", (-1.0, 0.0), (8, 2))
    middle = block("middle", 2.0, 1.0, None, (0.0, 1.0), (6, 3))
    top = block("top", 2.0, 1.0, "top", (0.0, 2.0), (6, 2))
    contacts = [
        Contact(surface_of(upper, "bottom"), surface_of(lower, "top"), pairing, law, of)
        for upper, lower, of in ((middle, base, friction[0]), (top, middle, friction[1]))
    ]
    return contacts, top, middle


def test_motions_that_stay_free_are_named_and_zero() -> None:
    """The middle of a stack slides on a wider base: it stays in place, and the message names the motion."""
    contacts, top, _ = on_a_wide_base(SegmentToSegment(), Multiplier())
    solution = press_parts(contacts, {}, loads={top: (None, -100.0, None)})
    assert solution.status.converged
    assert "`middle` can slide in x, which hardly anything prevents" in solution.status.message
    assert abs(solution.state.motions[0]) < 1e-3
    np.testing.assert_allclose(solution.forces[:, 1], 100.0, rtol=1e-4)


def test_a_body_that_nothing_touches_stays_where_it_is() -> None:
    """Two blocks apart, and no load: nothing moves, and all three motions are named."""
    base, loose = block("base", 2.0, 1.0, "bottom"), block("loose", 1.0, 1.0, None, (0.5, 1.05))
    contact = Contact(surface_of(loose, "bottom"), surface_of(base, "top"), SegmentToSegment(), Multiplier())
    solution = press_parts([contact], {base: Placement(0.0, (0.0, 0.02))})
    assert solution.status.converged
    assert "`loose` can slide in x, slide in y and turn: nothing holds it" in solution.status.message
    np.testing.assert_array_equal(solution.state.motions, 0.0)
    # pushed by more than the gap it yields without force
    pushed = press_parts([contact], {base: Placement(0.0, (0.0, 0.15))})
    assert pushed.status.converged
    assert not pushed.state.nodal_forces.any()
    # where the contact ends; nothing brings it back from there, so that the last iteration may leave it a little apart
    np.testing.assert_allclose(pushed.state.motions, [0.0, 0.1, 0.0], atol=1e-6)


@WAYS
def test_a_disc_in_a_groove(pairing, law) -> None:
    """A disc falls from a distance into a right-angled groove: each flank carries the load over sqrt(2), at 45 deg."""
    flanks = polygon([(-3.0, -3.0), (3.0, -3.0), (3.0, 1.5), (0.0, -1.5), (-3.0, 1.5)], list("brudl"))
    mesh = triangulate(flanks, size=0.4)
    groove = Part("groove", Body("groove", mesh, Lagrange(1), STEEL, "b"))
    _roller, surface = disc("roller", 1.0, 0.15, at=(0.02, 0.1 + np.sqrt(2.0) - 1.5))
    top = block("top", 2.0, 1.0, "top", (-1.0, 0.93), (20, 10))
    contacts = [Contact(surface, surface_of(groove, name), pairing, law) for name in "ud"]
    contacts.append(Contact(surface, surface_of(top, "bottom"), pairing, law))
    solution = press_parts(contacts, {}, loads={top: (None, -40.0, None)})
    assert solution.status.converged, solution.status.message
    tolerance = 2e-3 if isinstance(pairing, SegmentToSegment) else 2e-2
    expected = np.array([[-20.0, 20.0], [20.0, 20.0], [0.0, -40.0]])
    np.testing.assert_allclose(solution.forces, expected, atol=tolerance * 40.0)
    assert solution.forces[2, 1] == pytest.approx(-40.0, rel=1e-6)


def test_a_lever_turns_about_its_one_held_point() -> None:
    """Moments about the pivot are in equilibrium at any angle; the iteration converges as Newton's method does."""
    lever = block("lever", 6.0, 0.5, {(0.0, 0.25): "xy"}, (0.0, 0.0), (30, 2), turned=0.3)
    _base, surface = disc("post", 0.4, 0.08, {(-0.4, 0.0): "y", (0.4, 0.0): "y", (0.0, 0.4): "x"}, (2.0, 0.1))
    weight, load = disc("weight", 0.4, 0.08, {(-0.4, 0.0): "y", (0.4, 0.0): "y", (0.0, 0.4): "x"}, (4.4, 2.25))
    contacts = [Contact(surface, surface_of(lever, "bottom"), *pair) for pair in [(SegmentToSegment(), Multiplier())]]
    contacts.append(Contact(load, surface_of(lever, "top"), SegmentToSegment(), Multiplier()))
    solution = press_parts(contacts, {}, loads={weight: (None, -0.5, None)})
    assert solution.status.converged, solution.status.message
    pivot = lever.placement.points([[0.0, 0.25]])[0]
    x, y, moments = solution.resultants[:, 1].T
    moments = moments - pivot[0] * y + pivot[1] * x
    assert abs(moments.sum()) < 1e-10 * abs(moments[0])
    assert solution.forces[1, 1] == pytest.approx(0.5, rel=1e-10)
    assert abs(solution.state.motions[0]) > 1e-3
    residuals = [each.residual for each in solution.state.history]
    assert residuals[-1] < 1e-11
    assert len(residuals) <= 12


def wedged(seed: int):
    """A random disc in a random groove, pressed by a jaw."""
    rng = np.random.default_rng(seed)
    slopes, radius, n = rng.uniform(0.5, 1.2, 2), rng.uniform(0.6, 1.0), int(rng.integers(5, 8))
    law, pairing = LAWS[seed % 4], PAIRINGS[seed // 4]
    outline = polygon(
        [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0 * slopes[1]), (0.0, 0.0), (-2.0, 2.0 * slopes[0])], list("brudl")
    )
    mesh = triangulate(outline, size=1.5 / n)
    groove = Part("groove", Body("groove", mesh, Lagrange(1), STEEL, "b"))
    angles = np.arctan([-slopes[0], slopes[1]])
    normals = np.stack((-np.sin(angles), np.cos(angles)), axis=1)
    centre = np.linalg.solve(normals, [radius, radius])  # touches both flanks
    roller, surface = disc("roller", radius, 0.8 / n)
    roller = Part("roller", roller.body, Placement(rng.uniform(0.0, 6.0), centre))
    surface = Surface(roller, surface.edges, surface.curve)
    jaw = Body("jaw", rectangle_grid(2.0, 1.0, 4 * n, n), Lagrange(1 + seed % 2), STEEL, "top")
    jaw_part = Part("jaw", jaw, Placement(0.0, (centre[0] - 1.0, centre[1] + radius + 0.01)))
    contacts = [Contact(surface, surface_of(groove, name), pairing, law, 0.25) for name in "ud"]
    contacts.append(Contact(surface, surface_of(jaw_part, "bottom"), pairing, law, 0.25))
    force = rng.uniform(60.0, 180.0)
    return press_parts(contacts, {}, loads={jaw_part: (None, -force, None)}), roller, force


@pytest.mark.parametrize("seed", [1, pytest.param(3, marks=pytest.mark.ci), 4])
def test_random_wedges_with_friction_are_in_equilibrium(seed) -> None:
    """Forces and moments are in equilibrium, within the cone, and friction dissipates."""
    solution, roller, force = wedged(seed)
    assert solution.status.converged, solution.status.message
    assert unbalanced(solution, roller) < (EQUILIBRIUM if "kept" not in solution.status.message else 1e-3)
    assert solution.resultants[2, 0, 1] == pytest.approx(-force, rel=1e-9)
    assert cone_error(solution) < 1e-9
    assert (solution.dissipated_work >= 0.0).all()


def test_what_cannot_be_solved_is_refused_or_named() -> None:
    """Loads and motions of parts of which nothing is held, and loads that nothing answers to."""
    base, loose = block("base", 2.0, 1.0, "bottom"), block("loose", 1.0, 1.0, None, (0.5, 1.0))
    high = block("high", 1.0, 1.0, "top", (0.5, 9.0))
    law = SegmentToSegment(), Multiplier()
    contact = Contact(surface_of(loose, "bottom"), surface_of(base, "top"), *law)
    with pytest.raises(InputError, match="a load on part 'loose', of which None is held"):
        press_parts([contact], {}, loads={loose: (0.0, -1.0, None)})
    with pytest.raises(InputError, match="a motion of part 'loose', of which nothing is held"):
        press_parts([contact], {loose: Placement(0.0, (0.0, -0.1))})
    with pytest.raises(InputError, match="three finite numbers"):
        press_parts([contact], {}, loads={base: (None, None, None)})
    with pytest.raises(InputError, match="which has no contact"):
        press_parts([contact], {}, loads={high: (0.0, 1.0, None)})
    away = press_parts(
        [Contact(surface_of(high, "bottom"), surface_of(base, "top"), *law)], {}, loads={high: (None, -1.0, None)}
    )
    assert not away.status.converged
    assert "no contact holds a load: `high` can slide in y" in away.status.message
    pulled = press_parts(
        [Contact(surface_of(loose, "bottom"), surface_of(base, "top"), *law)], {}, loads={base: (0.0, None, None)}
    )
    assert pulled.status.converged
    surface = SurfaceNodes(loose.body, np.arange(3, dtype=np.int32))
    with pytest.raises(InputError, match="leaves free to move"):
        solve_contact(CondensedBodies([surface]), None, (Placement(),))
    mesh = rectangle_grid(1.0, 1.0, 2, 2)
    pieces = Body("pieces", mesh.merged(mesh.placed(Placement(0.0, (3.0, 0.0)))), Lagrange(1), STEEL)
    with pytest.raises(InputError, match="one piece that is held"):
        CondensedBodies([SurfaceNodes(pieces, np.arange(3, dtype=np.int32))])


def dragged(pairing, law):
    """A block that friction alone holds: pressed, then dragged by the block above it, over a base."""
    contacts, top, middle = on_a_wide_base(pairing, law, (0.3, 0.5))
    push = [{}, {top: Placement(0.0, (0.02, 0.0))}]
    return press_parts(contacts, push, loads={top: (None, -100.0, None)}), middle


def cone_error(solution) -> float:
    """Tangential force beyond Coulomb's limit over the maximum force, in any step."""
    beyond = [
        (np.abs(step.state.friction.forces) - step.state.linearisation.coefficients * step.state.forces).max()
        for step in solution.steps
    ]
    return max(beyond) / solution.state.forces.max()


@pytest.mark.parametrize(
    ("pairing", "law"), list(zip(PAIRINGS[::-1], LAWS[::2], strict=False)), ids=["nodes", "segments"]
)
def test_a_block_that_friction_alone_holds_is_dragged(pairing, law) -> None:
    """It sticks to the block with more friction and slides on the base with the limit as force."""
    solution, middle = dragged(pairing, law)
    assert solution.status.converged, solution.status.message
    assert max(step.state.status.iterations for step in solution.steps) <= 30
    assert solution.status.message.count(";") == 0  # no motion stays free
    table = solution.friction_table.columns
    lower = table["contact"] == 0
    assert not table["sticks"][lower].any()
    assert table["sticks"][~lower].any()
    np.testing.assert_allclose(np.abs(table["tangential_force"][lower]), 0.3 * table["normal_force"][lower], rtol=1e-8)
    assert unbalanced(solution, middle) < EQUILIBRIUM
    assert cone_error(solution) < 1e-9
    slid = solution.state.motions[0]
    assert 0.5 * 0.02 < slid < 0.02
    dragging = [step.share > 1.0 for step in solution.steps]
    assert solution.dissipated_work[dragging].sum() == pytest.approx(0.3 * 100.0 * slid, rel=0.1)
    assert (solution.dissipated_work >= 0.0).all()


@pytest.mark.parametrize(("share", "holds"), [(0.99, True), (1.01, False)])
def test_a_load_along_the_surface_is_held_up_to_the_limit(share: float, holds: bool) -> None:
    """Friction alone carries a tangential load on a sled below the limit; above it nothing does, and this is named."""
    base, sled = block("base", 4.0, 1.0, "bottom"), block("sled", 2.0, 1.0, "top", (1.0, 1.0), (6, 3))
    contact = Contact(surface_of(sled, "bottom"), surface_of(base, "top"), SegmentToSegment(), Multiplier(), 0.3)
    found = press_parts([contact], {}, loads={sled: (share * 30.0, -100.0, None)}, steps=StepSettings(1.0, 1.0, 1.0))
    assert found.status.converged == holds
    if holds:
        np.testing.assert_allclose(found.forces, [[-share * 30.0, 100.0]], rtol=1e-9)
        assert ";" not in found.status.message
    else:
        assert "no friction holds a load: `sled` can slide in x" in found.status.message
        assert found.status.iterations <= 30  # of one attempt
