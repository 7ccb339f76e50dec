"""Paths through bodies, large strains, gaps under pressure, nodes that left their partners, a body on itself."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.pushed import Case
from flangeway.contact import (
    Barrier,
    Contact,
    ContactSolution,
    Enforcement,
    Multiplier,
    NodeToNode,
    NodeToSegment,
    Pairing,
    Penalty,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement, polygon, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, rectangle_grid, triangulate
from flangeway.post import check_contact, pressure_patches
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)
PENALTIES = [Penalty(value, "length") for value in (3e3, 3e4, 3e5, 3e6)]


def blocks(pairing: Pairing, law: Enforcement | None = None, friction: float = 0.0, n: int = 8) -> Contact:
    """A block of 4 x 4 mm above one of 10 x 10 mm, held at its top and its bottom."""
    upper = rectangle_grid(4.0, 4.0, n, 4, origin=(-2.0, 0.0))
    lower = rectangle_grid(10.0, 10.0, 20, 8, origin=(-5.0, -10.0))
    top = Part("upper", Body("upper", upper, Lagrange(1), STEEL, "top"))
    base = Part("lower", Body("lower", lower, Lagrange(1), STEEL, "bottom"))
    sides = Surface(top, upper.edge_sets["bottom"]), Surface(base, lower.edge_sets["top"])
    return Contact(*sides, pairing, law or Multiplier(), friction)


def moved(contact: Contact, *shifts: tuple[float, float]) -> ContactSolution:
    """The upper part moved by shifts, one after the other."""
    return press([contact], [{contact.secondary.part: Placement(0.0, shift)} for shift in shifts])


def test_blocks_that_just_touch_have_no_penetration() -> None:
    """It is 0, not -0, which summaries would show."""
    (depth,) = moved(blocks(SegmentToSegment()), (0.0, -0.01)).initial_penetration
    assert str(float(depth)) == "0.0"


def test_a_body_that_moved_through_another_has_not_converged() -> None:
    """Below the plate nothing touches, but the way leads through it; beside and above it leads nowhere."""
    contact = blocks(SegmentToSegment())
    through = moved(contact, (0.0, -100.0))
    assert not through.status.converged
    assert "moved through" in through.status.message or through.status.checks is None
    for shifts in ([(0.0, 50.0)], [(50.0, 0.0), (0.0, -100.0)], [(0.0, -0.01), (0.0, 0.02)]):
        assert moved(contact, *shifts).status.converged


def test_strains_beyond_the_linear_range_are_said_with_their_size() -> None:
    """The largest strain grows with the motion; a notice names it from 5 % on."""
    small, large = (moved(blocks(NodeToSegment()), (0.0, -depth)) for depth in (0.01, 1.0))
    assert small.status.checks is not None
    assert large.status.checks is not None
    assert small.status.checks.warnings == ()
    assert large.status.checks.max_strain == pytest.approx(100.0 * small.status.checks.max_strain, rel=0.1)
    assert large.status.checks.max_strain > 0.05
    assert "not linear" in large.status.message


def test_a_linear_body_that_turns_by_more_than_a_radian_is_no_solution() -> None:
    """A strip displaced by 0.6 of its length over a stop: rotations of 1.65 rad make its sides twice as long."""
    solution = Case.of(57).solve(1)
    assert solution.status.checks is not None
    assert solution.status.checks.max_turn > 1.0
    assert not solution.status.converged
    assert any("not linear" in error for error in solution.status.checks.errors)


def test_an_unbalanced_solution_is_refused() -> None:
    """A nodal force changed by a thousandth in a state that had converged is an error of balance."""
    contact = blocks(NodeToSegment())
    solution = moved(contact, (0.0, -0.01))
    forces = solution.state.nodal_forces.copy()
    forces[np.abs(forces).sum(axis=1).argmax()] *= 1.001
    wrong = replace(solution, state=replace(solution.state, nodal_forces=forces))
    given = [(part.placement, None) for part in solution.system.parts]
    assert wrong.checked(given).status.converged is False
    assert solution.checked(given).status.converged


@pytest.mark.parametrize("laws", [[Barrier(value, 0.01) for value in (0.01, 1.0, 10.0, 1e3)], PENALTIES])
def test_the_error_of_a_law_is_stated_and_refused_above_a_half(laws: Sequence[Enforcement]) -> None:
    """Penetration or gap change the force of pressed blocks by what is stated, relative to multipliers' force."""
    exact = moved(blocks(NodeToSegment(), Multiplier()), (0.0, -0.01)).forces[0, 1]
    for law in laws:
        solution = moved(blocks(NodeToSegment(), law), (0.0, -0.01))
        error = abs(solution.forces[0, 1] / exact - 1.0)
        assert solution.status.checks.force_error == pytest.approx(error, rel=0.1, abs=0.01)
        assert solution.status.converged == (error < 0.5), (law, error)
        assert ("apart under pressure" in solution.status.message) == (error > 0.05 and isinstance(law, Barrier))
        assert ("the penetration of" in solution.status.message) == (error > 0.05 and isinstance(law, Penalty))


def test_contacts_without_names_are_called_by_their_parts() -> None:
    """Warnings of a coarse contact name both parts; a name too many and a text in place of a list are refused."""
    solution = moved(blocks(NodeToSegment(), n=4), (0.0, -0.01))
    patches = pressure_patches(solution.system, solution.state)
    checks = check_contact(solution.system, solution.state, patches)
    assert any(all(part.name in each for part in solution.system.parts) for each in checks.warnings)
    for names in (["one", "another"], "contact"):
        with pytest.raises(InputError, match="one name for each"):
            check_contact(solution.system, solution.state, patches, names)


@pytest.mark.parametrize(("slide", "converged"), [(0.05, True), (0.5, False)])
def test_nodes_that_left_their_partners_have_not_converged(slide: float, converged: bool) -> None:
    """A slide by a tenth of an edge is small; one by an edge or two fails, with the advice to match the boundaries."""
    solution = moved(blocks(NodeToNode()), (0.0, -0.01), (slide, 0.0))
    assert solution.status.converged == converged, solution.status.message
    if not converged:
        assert "match the boundaries" in solution.status.message


DOWN = Placement(np.pi, mirrored=True)
"""Reflection at the axis of the slit."""

LEG = triangulate(
    polygon(
        [(0, 0), (4, 0), (4, 0.1), (12, 0.1), (20, 0.1), (20, 3), (16, 3), (0, 3)],
        names=["root", "tip", "inner", "slit", "end", "pushed", "side", "left"],
    ),
    size=1.1,
)
LEGS = ("upper", "lower")
PLATE = triangulate(rectangle(2.0, 1.0, (18.5, 3.5)), size=0.5)


def hairpin() -> PolyMesh:
    """Both legs as one mesh, the lower one the mirror image of the upper one."""
    points, cells = LEG.points, LEG.batch_points(3, np.arange(LEG.n_cells))
    off = points[:, 1] > 1e-9
    lower = np.where(off, len(points) + np.cumsum(off) - 1, np.arange(len(points)))
    mesh = PolyMesh.from_cells(np.vstack((points, points[off] * [1, -1])), [*cells, *lower[cells][:, ::-1]])
    for name in ("slit", "inner", "pushed", "left"):
        edges = LEG.edge_sets[name]
        mesh = mesh.with_edge_set(f"upper {name}", edges).with_edge_set(f"lower {name}", lower[edges][:, ::-1])
    return mesh.with_edge_set("left", np.concatenate((mesh.edge_sets["upper left"], mesh.edge_sets["lower left"])))


def squeezed(legs: dict[str, Surface], pairing: Pairing, path: str | None = None) -> ContactSolution:
    """Press two plates against the legs' outer sides and the legs' inner sides together."""
    plates = [
        Part(n, Body(n, PLATE, Lagrange(1), STEEL, held="top"), at) for n, at in (("a", Placement()), ("b", DOWN))
    ]
    pairs = [(legs["upper slit"], legs["lower slit"])]
    pairs += [(Surface(p, PLATE.edge_sets["bottom"]), legs[f"{n} pushed"]) for p, n in zip(plates, LEGS, strict=True)]
    moves = {plate: Placement(0.0, (0.0, y)) for plate, y in zip(plates, (-0.4, 0.4), strict=True)}
    return press([Contact(*both, pairing, Multiplier()) for both in pairs], moves, path=path)


def of_one_body(slit: str = "slit", element: Lagrange | Virtual | None = None) -> dict[str, Surface]:
    """Surfaces of the hairpin as one body."""
    mesh = hairpin()
    pin = Part("pin", Body("pin", mesh, element or Lagrange(1), STEEL, held="left"))
    names = {f"{leg} {each}": f"{leg} {at}" for leg in LEGS for each, at in (("slit", slit), ("pushed", "pushed"))}
    return {name: Surface(pin, mesh.edge_sets[edges]) for name, edges in names.items()}


def of_two_bodies() -> dict[str, Surface]:
    """Surfaces of the legs as two bodies, which slide along the axis of symmetry where they were cut."""
    surfaces = {}
    for name, at in (("upper", Placement()), ("lower", DOWN)):
        body = Body(name, LEG, Lagrange(1), STEEL, held={"left": "xy", "root": "y"})
        part = Part(name, body, at)
        surfaces |= {f"{name} {each}": Surface(part, LEG.edge_sets[each]) for each in ("slit", "pushed")}
    return surfaces


def test_one_body_is_in_equilibrium_with_itself_as_two_halves_are() -> None:
    """Forces in the slit and at the plates are those of two halves cut at the axis of symmetry, to 1e-4."""
    one, two = squeezed(of_one_body(), NodeToSegment()), squeezed(of_two_bodies(), NodeToSegment())
    assert one.status.converged, one.status.message  # slender legs: to round-off, above the tolerance
    assert two.status.converged, two.status.message
    np.testing.assert_allclose(one.forces, two.forces, atol=1e-4 * np.abs(two.forces).max())
    assert one.forces[0, 1] > 0.5 * one.forces[1, 1] > 0.0
    np.testing.assert_allclose(one.resultants[0, 0], -one.resultants[0, 1], atol=1e-9 * np.abs(one.resultants).max())


def test_a_body_that_overlaps_itself_elsewhere_is_no_solution() -> None:
    """Where the edges that meet were not given, the body overlaps itself, and the status says so."""
    found = squeezed(of_one_body("inner"), SegmentToSegment())
    assert not found.status.converged
    assert "pin overlaps itself by 0." in found.status.message


def test_surfaces_that_meet_are_refused() -> None:
    """Two surfaces of one part with a node in common are refused, as is a second contact of the same edges."""
    legs = of_one_body()
    part, mesh = legs["upper slit"].part, legs["upper slit"].part.body.mesh
    inner = Surface(part, mesh.edge_sets["upper inner"])
    with pytest.raises(InputError, match="with itself, whose surfaces have nodes in common"):
        Contact(legs["upper slit"], inner, NodeToSegment(), Multiplier())
    slits = legs["upper slit"], legs["lower slit"]
    both = [Contact(*each, NodeToSegment(), Multiplier()) for each in (slits, slits[::-1])]
    with pytest.raises(InputError, match="two contacts of 'pin' and 'pin' along the same edges"):
        press(both, {})
