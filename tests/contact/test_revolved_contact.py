"""Contact of bodies of revolution: uniform pressure, equilibrium along the axis, exact forces, and bad inputs."""

import numpy as np
import pytest

from flangeway import Body, Elastic, Lagrange, Part, Placement
from flangeway.contact import (
    AugmentedLagrange,
    Contact,
    Multiplier,
    NodeToNode,
    NodeToSegment,
    Penalty,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.errors import InputError
from flangeway.mesh import PolyMesh, rectangle_grid
from flangeway.post import pressure_patches
from flangeway.solve import StepSettings

STEEL = Elastic(210e3, 0.3, "axisymmetric")
LAWS = [Penalty(1e6, per="length"), AugmentedLagrange(1e7, per="length", penetration=1e-9), Multiplier()]


def cylinder(
    name: str, n: int, *, order: int = 1, radius: float = 2.0, inner: float = 0.0, held="xy", tilt: float = 0.0
) -> Part:
    """A cylinder or a tube of 1 mm height above y = 0 (``upper``) or below, held at its other end; a cone if tilted."""
    above = name == "upper"
    grid = rectangle_grid(radius - inner, 1.0, n, 3, origin=(inner, 0.0 if above else -1.0))
    x, y = grid.points.T
    points = np.column_stack((x, y + tilt * x * (1.0 - np.abs(y))))
    mesh = PolyMesh(points, grid.cell_offsets, grid.cell_points, {}, grid.edge_sets)
    support = {"top" if above else "bottom": held} if held else None
    return Part(name, Body(name, mesh, Lagrange(order), STEEL, support))


def touching(upper: Part, lower: Part, pairing=None, law=LAWS[2], friction: float = 0.0) -> Contact:
    """The faces at y = 0."""
    faces = [Surface(part, part.body.mesh.edge_sets[name]) for part, name in ((upper, "bottom"), (lower, "top"))]
    return Contact(*faces, pairing or SegmentToSegment(), law, friction)


@pytest.mark.parametrize(
    ("inner", "order", "law"), [(0.0, 1, LAWS[0]), (0.7, 2, LAWS[1]), (0.7, 1, LAWS[2]), (0.0, 2, LAWS[2])]
)
def test_a_uniform_pressure_passes_to_round_off(inner: float, order: int, law) -> None:
    """Stacked on meshes that do not match, ends free to slide: the stress of a bar, the force of its whole section."""
    upper, lower = (cylinder(name, n, order=order, inner=inner, held="y") for name, n in (("upper", 4), ("lower", 7)))
    found = press([touching(upper, lower, law=law)], {upper: Placement(0.0, (0.0, -0.001))})
    assert found.status.converged, found.status.message
    table = {name: np.asarray(values) for name, values in found.friction_table.columns.items()}
    softness = 2.0 / 210e3 + (1.0 / law.value if isinstance(law, Penalty) else 0.0)
    rtol = 1e-4 if isinstance(law, AugmentedLagrange) else 1e-11
    np.testing.assert_allclose(table["pressure"], 0.001 / softness, rtol=rtol)
    (patch,) = pressure_patches(found.system, found.state)
    half_width = 1.0 - inner / 2.0 if inner else 2.0  # about the axis it is the radius
    np.testing.assert_allclose((patch.width, patch.half_width), (2.0 - inner, half_width), rtol=1e-12)
    np.testing.assert_allclose(found.forces[0, 1], np.pi * (4.0 - inner**2) * 0.001 / softness, rtol=rtol)


@pytest.mark.parametrize(("order", "pairing"), [(1, NodeToSegment()), (2, NodeToNode())], ids=["segment", "node"])
def test_nodes_of_matching_meshes_pass_a_uniform_pressure(order: int, pairing) -> None:
    """Node pairings with multipliers: the force of the bar, its pressure at all nodes, and the radius as width."""
    upper, lower = (cylinder(name, 5, order=order, held="y") for name in ("upper", "lower"))
    found = press([touching(upper, lower, pairing)], {upper: Placement(0.0, (0.0, -0.001))})
    np.testing.assert_allclose(found.forces[0, 1], np.pi * 4.0 * 0.001 * 105e3, rtol=1e-11)
    pressures = np.asarray(found.friction_table.columns["pressure"])
    on_axis = np.asarray(found.friction_table.columns["x"]) < 1e-12  # a node of order 2 has no share of the force there
    np.testing.assert_allclose(pressures[~on_axis | (order == 1)], 105.0, rtol=1e-10)
    (patch,) = pressure_patches(found.system, found.state)
    np.testing.assert_allclose(patch.width, 2.0, rtol=1e-12 if order == 1 else 0.06)
    np.testing.assert_allclose(patch.pressures[1:], 105.0, rtol=1e-10)


@pytest.mark.parametrize(
    ("inner", "order", "pairing", "law", "friction", "tilt", "depth"),
    [
        (0.3, 2, SegmentToSegment(), LAWS[2], 0.8, 1e-3, 0.02),
        # two corners on each other, and a concave joint beside them, are guarded
        (0.3, 2, SegmentToSegment(), LAWS[2], 0.8, 2e-3, 0.00125),
        (0.0, 1, NodeToSegment(), LAWS[0], 0.2, 1e-3, 0.02),
    ],
)
def test_axial_forces_are_in_equilibrium(inner, order, pairing, law, friction, tilt, depth) -> None:
    """Forces along the axis on both sides, and the reaction at the held end by the stiffness, agree to round-off."""
    upper = cylinder("upper", 2, order=order, radius=2.1, inner=inner, tilt=tilt)
    lower = cylinder("lower", 4, order=order, radius=1.0, inner=inner)
    contact = touching(upper, lower, pairing, law, friction)
    found = press([contact], {upper: Placement(0.0, (0.0, -depth))}, steps=StepSettings(1.0, 1.0, 1.0))
    assert found.status.converged, found.status.message
    force = found.forces[0, 1]
    assert force > 0.0
    np.testing.assert_allclose(found.resultants[0, 1, 1], -force, rtol=1e-11)
    moved = upper.body.elasticity.stiffness().full() @ found.field(upper).displacements.ravel()
    held = upper.body.space.edge_nodes(upper.body.mesh.edge_sets["top"]).ravel()
    np.testing.assert_allclose(moved.reshape(-1, 2)[np.unique(held), 1].sum(), -force, rtol=1e-9)
    assert (found.dissipated_work >= 0.0).all()


def test_a_cylinder_between_two_others_carries_the_load() -> None:
    """A part that nothing holds moves along the axis alone; the load is that on the whole circumference."""
    lower = cylinder("lower", 5)
    middle = cylinder("upper", 4, radius=1.5, held=None)
    mesh = rectangle_grid(1.0, 1.0, 3, 2, origin=(0.0, 1.0))
    top = Part("top", Body("top", mesh, Lagrange(1), STEEL, "top"))
    above = Contact(
        Surface(top, mesh.edge_sets["bottom"]),
        Surface(middle, middle.body.mesh.edge_sets["top"]),
        SegmentToSegment(),
        Multiplier(),
    )
    found = press([touching(middle, lower), above], {}, loads={top: (None, -1000.0, None)})
    assert found.status.converged, found.status.message
    np.testing.assert_allclose(found.forces[:, 1], 1000.0, rtol=1e-9)


def off_axis(**changes):
    return Part("upper", cylinder("upper", 2).body, Placement(**changes))


def plane(name: str) -> Part:
    mesh = rectangle_grid(2.0, 1.0, 2, 2, origin=(0.0, -1.0))
    return Part(name, Body(name, mesh, Lagrange(1), Elastic(210e3, 0.3), "bottom"))


def turned(**options):
    upper, lower = cylinder("upper", 2), cylinder("lower", 2)
    motion = options.pop("motion", Placement(0.0, (0.0, -0.001)))
    loads = {upper: options["load"]} if "load" in options else None
    return press([touching(upper, lower)], {upper: motion}, loads=loads)


def stiffness(**changes):
    body = cylinder("lower", 2).body
    matrix = body.elasticity.stiffness().full()
    top = np.flatnonzero(body.nodes[:, 1] == 0.0)[::-1].tolist()
    given = {"coordinates": body.nodes, "surfaces": {"top": top}, "held": body.supported}
    return Body.from_stiffness("k", matrix, axisymmetric=True, **{**given, **changes})


REFUSED = [
    (lambda: off_axis(translation=(1.0, 0.0)), "a shift along its axis"),
    (lambda: turned(motion=Placement(0.0, (0.1, -0.1))), "a motion of part 'upper'"),
    (lambda: turned(load=(1.0, -1.0, None)), "a force along its axis"),
    (lambda: touching(cylinder("upper", 2), plane("lower")), "both axisymmetric"),
    (
        lambda: touching(cylinder("upper", 2), cylinder("lower", 2), SegmentToSegment(weighting="dual")),
        "weighting='standard'",
    ),
    (lambda: Body("b", rectangle_grid(1.0, 1.0, 1, 1), Lagrange(1), STEEL, thickness=2.0), "summed around the axis"),
    (lambda: stiffness(held=None), "nodes on the axis that can leave it"),
]


@pytest.mark.parametrize("case", range(len(REFUSED)))
def test_what_leaves_the_axis_is_refused(case: int) -> None:
    """The message names what is allowed."""
    make, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        make()


def test_a_stiffness_matrix_of_revolution_is_the_mesh() -> None:
    """The mesh's own matrix in `from_stiffness` gives its forces to 1e-12."""
    upper, lower = cylinder("upper", 4, radius=1.0), cylinder("lower", 2)
    given = Part("lower", stiffness())
    forces = []
    for part, edges in ((lower, lower.body.mesh.edge_sets["top"]), (given, given.body.edge_sets["top"])):
        contact = Contact(
            Surface(upper, upper.body.mesh.edge_sets["bottom"]), Surface(part, edges), SegmentToSegment(), Multiplier()
        )
        forces.append(press([contact], {upper: Placement(0.0, (0.0, -0.01))}).forces)
    np.testing.assert_allclose(forces[1][0, 1], forces[0][0, 1], rtol=1e-12)
