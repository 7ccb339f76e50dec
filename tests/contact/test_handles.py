"""Handles shared by parts: forces from statics, equality with one body, springs, stability, bad inputs."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.geometry import Placement, circle, polygon
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.problems import Body, Part
from flangeway.solve import Handle
from tests.contact.steel_boxes import surface_of

YOUNG = 20e3
SLENDER = Elastic(YOUNG, 0.0)  # a uniform pressure makes no strain across it
LAW = SegmentToSegment(), Multiplier()
TURNED = 0.4
IMAGE = Placement(TURNED, (3.0, -1.0))  # nothing depends on where the whole stands


def block(name, width, height, held, at=(0.0, 0.0), cells=(4, 3), image=IMAGE) -> Part:
    """A block with its lower left corner at a point, in a plane that is turned."""
    mesh = rectangle_grid(width, height, *cells)
    return Part(name, Body(name, mesh, Lagrange(1), SLENDER, held), image.after(Placement(0.0, at)))


def along(vector) -> np.ndarray:
    """A vector of the turned plane in space."""
    return IMAGE.vectors([vector])[0]


def at(point) -> np.ndarray:
    """A point of the turned plane in space."""
    return IMAGE.points([point])[0]


def moved(found: ContactSolution, part: Part) -> Placement:
    """Rigid motion of a part in space."""
    return found.state.placements[found.system.parts.index(part)].after(part.placement.inverse())


def moment_about(found: ContactSolution, point) -> float:
    """Moment of all contacts on their secondary sides about a point."""
    forces = found.resultants[:, 0]
    return float((forces[:, 2] - point[0] * forces[:, 1] + point[1] * forces[:, 0]).sum())


def roller(name, centre, radius=1.0, size=0.12) -> tuple[Part, Surface]:
    """A roller, held at its axle, and its surface."""
    outline, x = circle(radius), 0.3 * radius
    axle = polygon([(-x, -x), (x, -x), (x, x), (-x, x)], ["axle"] * 4)
    mesh = triangulate(outline, size=size * radius, holes=[axle])
    part = Part(name, Body(name, mesh, Lagrange(1), SLENDER, "axle"), Placement(0.0, centre))
    return part, Surface(part, mesh.edge_set("circle"), outline)


def two_punches(**options) -> ContactSolution:
    """Punches of width 1 and 2 on a common foundation, on one handle."""
    base = block("base", 8.0, 2.0, "bottom", cells=(16, 4))
    left = block("left", 1.0, 2.0, "top", (1.0, 2.0), (4, 4))
    right = block("right", 2.0, 2.0, "top", (5.0, 2.0), (8, 4))
    contacts = [Contact(surface_of(each, "bottom"), surface_of(base, "top"), *LAW) for each in (left, right)]
    return press(contacts, {}, handles=[Handle((left, right), **options)])


def test_a_force_on_two_punches_is_shared_by_the_lever_rule() -> None:
    """The contacts bear the force along which the handle slides, and its moment about the pivot."""
    pivot, point = at((3.0, 5.0)), at((1.9, 4.0))
    load = np.append(along((0.0, -30.0)), 0.0)
    found = two_punches(pivot=pivot, load=load, load_point=point, directions=along((0.0, 1.0))[None])
    assert found.status.converged, found.status.message
    up = found.forces @ along((0.0, 1.0))
    assert up.sum() == pytest.approx(30.0, rel=1e-10)
    now, where = moved(found, found.system.parts[0]).points([pivot, point])
    arm = where - now
    moment = arm[0] * load[1] - arm[1] * load[0]
    assert moment_about(found, now) + moment == pytest.approx(0.0, abs=1e-8 * 30.0)


def test_punches_on_columns_share_a_force_as_springs_do() -> None:
    """Columns of stiffness E b / h side by side under a handle that does not turn carry shares b of the force."""
    heights, widths = 2.0, (1.0, 3.0)
    parts, contacts = [], []
    for number, width in enumerate(widths):
        low = block(f"low {number}", width, heights, "bottom", (5.0 * number, 0.0))
        high = block(f"high {number}", width, heights, "top", (5.0 * number, heights))
        contacts.append(Contact(surface_of(high, "bottom"), surface_of(low, "top"), *LAW))
        parts.append(high)
    load = np.append(along((0.0, -80.0)), 0.0)
    found = press(contacts, {}, handles=[Handle(tuple(parts), at((2.0, 4.0)), along((0.0, 1.0))[None], False, load)])
    assert found.status.converged, found.status.message
    np.testing.assert_allclose(found.forces, [along((0.0, 20.0)), along((0.0, 60.0))], atol=1e-9)
    np.testing.assert_allclose(
        moved(found, parts[1]).translation, along((0.0, -80.0 * 2.0 * heights / (YOUNG * 4.0))), atol=1e-11
    )


def test_a_spring_is_in_series_with_contact_and_moves_with_its_motion() -> None:
    """A punch pressed by a spring, whose other end moves by d, bears d / (1/k + 1/k of the columns)."""
    low, high = block("low", 2.0, 1.0, "bottom"), block("high", 2.0, 3.0, "top", (0.0, 1.0))
    spring, columns, moved = 7000.0, YOUNG * 2.0 / 4.0, 0.01
    handle = Handle((high,), at((1.0, 4.0)), along((0.0, 1.0))[None], turns=False, stiffness=np.array([[spring]]))
    x, y = along((0.0, -moved))
    found = press(
        [Contact(surface_of(high, "bottom"), surface_of(low, "top"), *LAW)],
        {high: Placement(0.0, (x, y))},
        handles=[handle],
    )
    force = moved / (1.0 / spring + 1.0 / columns)
    np.testing.assert_allclose(found.forces[0], along((0.0, force)), atol=1e-10 * force)


def test_a_rotation_spring_bears_the_moment_that_contact_does_not() -> None:
    """A punch under a force beside its middle turns against a spring: their moments agree."""
    found = two_punches(pivot=at((3.75, 4.0)), load=np.append(along((0.0, -40.0)), 25.0),
                        directions=along((0.0, 1.0))[None], stiffness=np.diag([0.0, 3e5]))  # fmt: skip
    assert found.status.converged, found.status.message
    motion = moved(found, found.system.parts[0])
    assert abs(motion.rotation_rad) > 1e-5
    moment = moment_about(found, motion.points([at((3.75, 4.0))])[0]) + 25.0
    assert moment == pytest.approx(3e5 * motion.rotation_rad, rel=1e-9)


def bridge(*, parts: int):
    """Two feet held at their tops, as one body or as two on one handle, on two uneven foundations under a skew load."""
    feet, at_x = rectangle_grid(1.0, 2.0, 4, 8), (0.0, 4.0)
    bases = [block(f"base {i}", 2.0, 1.0, "bottom", (x - 0.5, -1.0 - 0.001 * i), (9, 4)) for i, x in enumerate(at_x)]
    if parts == 2:
        own = [Part(f"foot {i}", Body("foot", feet, Lagrange(1), SLENDER, "top"), IMAGE.after(Placement(0.0, (x, 0.0))))
               for i, x in enumerate(at_x)]  # fmt: skip
        surfaces = [surface_of(part, "bottom") for part in own]
    else:
        n, (_, x) = len(feet.points), at_x
        both = feet.merged(feet.placed(Placement(0.0, (x, 0.0))))
        own = [Part("feet", Body("feet", both, Lagrange(1), SLENDER, "top"), IMAGE)]
        edges = feet.edge_sets["bottom"]
        surfaces = [Surface(own[0], edges), Surface(own[0], edges + n)]
    contacts = [Contact(surface, surface_of(base, "top"), *LAW) for surface, base in zip(surfaces, bases, strict=True)]
    load = np.append(along((1.0, -50.0)), 20.0)
    handle = Handle(tuple(own), at((1.5, 2.5)), load=load, stiffness=np.diag([2e3, 2e3, 0.0]))
    return press(contacts, {}, handles=[handle])


def test_bodies_bolted_together_are_one_body() -> None:
    """Two feet whose tops one handle holds move and bear as one body whose whole top is held."""
    one, two = bridge(parts=1), bridge(parts=2)
    assert one.status.converged, one.status.message
    assert two.status.converged, two.status.message
    np.testing.assert_allclose(one.resultants[:, 0], two.resultants[:, 0], rtol=1e-8, atol=1e-8)
    both = zip(one.state.placements[:1] * 2, [two.state.placements[i] for i in (0, 2)], (0.0, 4.0), strict=True)
    for whole, foot, x in both:
        np.testing.assert_allclose(whole.points([[x, 1.0]]), foot.points([[0.0, 1.0]]), atol=1e-11)


@pytest.mark.parametrize("spring", [0.7, 1.25])
def test_a_roller_on_a_roller_is_stable_from_a_spring_on(spring) -> None:
    """On top of a roller a force of F is unstable; a spring across it of F / (R + r) holds it."""
    (_lower, below), (upper, above) = roller("lower", (0.0, 0.0), 0.5, 0.08), roller("upper", (0.0, 1.5), 1.0, 0.03)
    force = 400.0
    stiffness = np.diag([spring * force / 1.5, 0.0])
    handle = Handle((upper,), np.array([0.0, 1.5]), turns=False, load=np.array([0.0, -force, 0.0]), stiffness=stiffness)
    found = press([Contact(above, below, *LAW)], {}, handles=[handle])
    assert found.status.converged, found.status.message
    assert found.forces[0] == pytest.approx([0.0, force], abs=1e-3 * force)  # meshes are not quite symmetric
    _, _, words = found.status.message.partition("; ")
    assert words.startswith("`upper` can slide") == ("out of an unstable equilibrium" in words) == (spring < 1.0)


def test_wrong_handles_are_refused() -> None:
    """What is wrong with a handle is said with the part's name."""
    base, loose = block("base", 2.0, 1.0, "bottom"), block("loose", 1.0, 1.0, None, (0.0, 1.0))
    high = block("high", 1.0, 1.0, "top", (1.0, 1.0))
    contacts = [Contact(surface_of(each, "bottom"), surface_of(base, "top"), *LAW) for each in (loose, high)]
    pivot, apart = np.zeros(2), block("apart", 1.0, 1.0, "top")
    for handles, motion, words in (
        ([Handle((loose,), pivot)], {}, "'loose'"),
        ([Handle((apart,), pivot)], {}, "'apart'"),
        ([Handle((high,), pivot), Handle((high, base), pivot)], {}, "'high'"),
        ([Handle((base, high), pivot)], {high: Placement(0.0, (0.0, -0.1))}, "'base'.*'high'|'high'.*'base'"),
        (Handle((high,), pivot), {}, "handles"),
    ):
        with pytest.raises(InputError, match=words):
            press(contacts, motion, handles=handles)
    with pytest.raises(InputError, match="'high'"):
        press(contacts, {}, loads={high: (None, -1.0, None)}, handles=[Handle((high,), pivot)])
    for wrong in (
        {"pivot": (0.0, 0.0, 0.0)}, {"load": (0.0, 1.0)}, {"directions": [(2.0, 0.0)]}, {"load_point": (np.nan, 0.0)},
        {"directions": np.zeros((0, 2)), "turns": False}, {"stiffness": -np.eye(3)}, {"stiffness": np.eye(2)},
        {"directions": [(1.0, 0.0), (1.0, 0.0)]}, {"turns": None}, {"soft_motions": "held"}, {"parts": high},
    ):  # fmt: skip
        with pytest.raises(InputError):
            Handle(**({"parts": (high,), "pivot": pivot} | wrong))
    with pytest.raises(InputError, match="parts"):
        Handle((high, high), pivot)
