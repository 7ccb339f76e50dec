"""Contact in space: Hertz's pressures, blocks whose meshes do not match, floating blocks, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flangeway.contact import (
    AugmentedLagrange,
    Barrier,
    FaceSurface,
    Penalty,
    RigidCylinder,
    RigidPlane,
    RigidSphere,
    SpatialContact,
    press_spatial,
)
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.mesh import PolyhedralMesh, octree, quadtree
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure, Traction, fixed
from flangeway.space import Space
from flangeway_studies.polyhedra import PLANE_MODULUS, SHRUNK, STEEL, pressed_blocks, sphere_on_block


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0])
def test_a_rigid_sphere_presses_as_hertz_says(radius):
    """At three loads the maximum pressure is within 0.5 % and the radius of contact within 1 % of Hertz's."""
    solution = sphere_on_block(radius, 6)
    assert solution.status.converged, solution.status.message
    (contact,), force = solution.contacts, PLANE_MODULUS * radius**3 / 3.0 / 50.0
    assert contact.resultant[2] == pytest.approx(-force, rel=1e-12)
    assert contact.pressures.max() == pytest.approx(2.0 * PLANE_MODULUS * radius / np.pi / 50.0, rel=0.005)
    assert contact.semi_axes((0.0, 0.0, 20.0)) == pytest.approx((radius, radius), rel=0.01)
    assert contact.area == pytest.approx(np.pi * radius**2 / 4.0, rel=0.1)
    assert contact.forces.min() == 0.0
    checks = solution.status.checks
    assert checks is not None
    assert checks.gap_under_pressure < 1e-5


def test_a_rigid_cylinder_presses_as_in_the_plane():
    """In a slice between planes of symmetry the pressure of a cylinder is that of Hertz's line contact."""
    radius, size = 1.0, 40.0

    def finer(centres, sides):
        away = np.linalg.norm(centres - (0.0, size), axis=1)
        return sides > 1.001 * np.maximum(size / 512, 0.2 * (away - 1.25 * radius))

    mesh = PolyhedralMesh.extruded(quadtree(size, size, 1, 1, finer=finer, levels=9), [0.0, 0.1])
    mesh = mesh.with_face_set("patch", lambda p: (p[:, 1] == size) & (p[:, 0] < 2.0))
    symmetric = [PrescribedDisplacement("left", x=0.0), *(PrescribedDisplacement(end, z=0.0) for end in ("z-", "z+"))]
    block = Elasticity(Space(mesh, Virtual(1)), STEEL, supports=[*symmetric, fixed("bottom", 3)])
    roller = RigidCylinder((0.0, size + 50.0, 0.0), 50.0, (0.0, 0.0, 2.0))
    line_load = np.pi * PLANE_MODULUS * radius**2 / 4.0 / 50.0
    solution = press_spatial(
        [SpatialContact(FaceSurface(block, "patch"), roller)], {roller: (0.0, -0.05 * line_load, 0.0)}
    )
    assert solution.status.converged, solution.status.message
    assert solution.contacts[0].pressures.max() == pytest.approx(2.0 * line_load / np.pi / radius, rel=0.005)


TURNS = {"tilted": np.eye(3), "turned": Rotation.from_rotvec([0.2, 0.4, -0.3]).as_matrix()}


@pytest.mark.parametrize("turn", TURNS)
def test_common_faces_pass_a_uniform_pressure(turn):
    """Cut into common faces, blocks that do not match have the pressure 100 and the strain of the whole, to 1e-10."""
    solution = pressed_blocks(TURNS[turn], cut=True)
    assert solution.status.converged, solution.status.message
    (contact,) = solution.contacts
    assert np.abs(contact.pressures - 100.0).max() < 1e-8
    for body, field in solution.displacements.items():
        assert isinstance(body, Elasticity)
        assert np.abs(field - SHRUNK * body.space.nodes).max() < 1e-10 * abs(SHRUNK) * 40.0
    checks = solution.status.checks
    assert checks is not None
    assert max(checks.force_residual, checks.moment_residual, checks.gap_under_pressure, checks.slide) < 1e-10


def test_nodes_on_faces_miss_a_uniform_pressure():
    """Without common faces pressures are off by a third: this is why they are cut."""
    solution = pressed_blocks(TURNS["tilted"], cut=False)
    assert solution.status.converged
    (contact,) = solution.contacts
    assert 0.2 < np.abs(contact.pressures / 100.0 - 1.0).max() < 0.6
    assert contact.resultant[2] == pytest.approx(40000.0, rel=1e-9)
    # action and reaction at points that slide apart leave a moment: that of the forces on all displaced nodes
    moment, checks = np.zeros(3), solution.status.checks
    for body, field in solution.displacements.items():
        assert isinstance(body, Elasticity)
        forces = (contact.contact.gradients(body).T @ contact.forces).reshape(-1, 3)
        moment += np.cross(body.space.nodes + field, forces).sum(axis=0)
    assert checks is not None
    measured = checks.moment_residual * contact.forces.max() * contact.contact.secondary.body.size
    assert measured == pytest.approx(np.abs(moment).max(), rel=1e-6)
    assert measured > 0.1


def cube(*loads: Traction | Pressure, held: bool = True) -> Elasticity[PolyhedralMesh]:
    """A cube of 10 mm in 4 x 4 x 4 cells that only contact holds along z."""
    mesh = octree((10.0, 10.0, 10.0), (4, 4, 4), finer=lambda _, sides: sides < 0.0, levels=0)
    mesh = mesh.with_face_set("half", lambda p: (p[:, 2] == 10.0) & (p[:, 0] <= 5.0))
    guided = [PrescribedDisplacement((0.0, 0.0, 0.0), 0.0, 0.0), PrescribedDisplacement((10.0, 0.0, 0.0), y=0.0)]
    return Elasticity(Space(mesh, Virtual(1)), STEEL, loads=loads, supports=guided if held else [])


GROUND = RigidPlane((0.0, 0.0, 0.0), (0.0, 0.0, 3.0))


def test_contact_alone_holds_a_cube_and_lets_it_lift_off():
    """A cube that nothing else holds along z rests on a plane; loaded near one side, the other one lifts off."""
    even = press_spatial([SpatialContact(FaceSurface(cube(Traction("z+", (0.0, 0.0, -50.0))), "z-"), GROUND)])
    assert even.status.converged, even.status.message
    assert even.contacts[0].pressures == pytest.approx(np.full(25, 50.0), rel=1e-9)
    leaning = cube(Traction("half", (0.0, 0.0, -50.0)), Traction("half", (1.0, 0.0, 0.0)), Traction("z-", (-0.5, 0, 0)))
    uneven = press_spatial([SpatialContact(FaceSurface(leaning, "z-"), GROUND)])
    assert uneven.status.converged, uneven.status.message
    (contact,) = uneven.contacts
    assert contact.resultant == pytest.approx([0.0, 0.0, 2500.0], abs=1e-8)
    assert ((contact.forces == 0.0) == (contact.points[:, 0] == 10.0)).all()
    # 2500 N at x = 2.5 and 50 N to the right at the height 10
    assert contact.forces @ contact.points[:, 0] == pytest.approx(2500.0 * 2.5 + 50.0 * 10.0, rel=1e-8)


def test_a_penalty_lets_the_plane_be_entered():
    """With a penalty of 1e4 MPa/mm a pressure of 50 MPa goes 5 um deep."""
    law = Penalty(1e4, per="length")
    body = cube(Traction("z+", (0.0, 0.0, -50.0)))
    solution = press_spatial([SpatialContact(FaceSurface(body, "z-"), GROUND, law)])
    assert solution.status.converged, solution.status.message
    bottom = solution.field(body).displacements[body.space.nodes_along("z-"), 2]
    assert bottom == pytest.approx(np.full(25, -0.005), rel=1e-9)


def test_a_barrier_keeps_a_gap():
    """With a barrier of 0.05 N/mm and a reach of 0.1 mm a pressure of 50 MPa leaves the gap 0.05 / (50 + 0.5) mm."""
    body = cube(Traction("z+", (0.0, 0.0, -50.0)))
    solution = press_spatial([SpatialContact(FaceSurface(body, "z-"), GROUND, Barrier(0.05, 0.1))])
    assert solution.status.converged, solution.status.message
    bottom = solution.field(body).displacements[body.space.nodes_along("z-"), 2]
    assert bottom == pytest.approx(np.full(25, 0.05 / 50.5), rel=1e-9)


def test_what_is_not_in_equilibrium_is_no_solution():
    """A cube pulled off its plane, and a sphere that enters the block outside of its patch, did not converge."""
    pulled = press_spatial([SpatialContact(FaceSurface(cube(Traction("z+", (0.0, 0.0, 50.0))), "z-"), GROUND)])
    assert not pulled.status.converged
    assert "no solution" in pulled.status.message
    ball, body = RigidSphere((5.0, 5.0, -400.0), 400.0), cube(Traction("z+", (0.0, 0.0, -2000.0)))
    mesh = body.space.mesh.with_face_set(
        "patch", lambda p: (p[:, 2] == 0.0) & (np.abs(p[:, :2] - 5.0) < 3.0).all(axis=1)
    )
    block = replace(body, space=Space(mesh, Virtual(1)))
    narrow = press_spatial([SpatialContact(FaceSurface(block, "patch"), ball)])
    assert not narrow.status.converged
    assert "enters" in narrow.status.message


def test_few_nodes_under_pressure_are_named():
    """A message says that a contact of a few nodes needs smaller cells."""
    solution = sphere_on_block(1.0, 1)
    assert solution.status.converged
    assert "smaller cells" in solution.status.message
    assert len(solution.table) == (solution.contacts[0].forces > 0.0).sum()


def test_wrong_arguments_are_refused():
    """No contact, a load on what has none, a law that is not for space, and a set of faces that is not there."""
    body = cube()
    surface, ball = FaceSurface(body, "z-"), RigidSphere((0.0, 0.0, -5.0), 5.0)
    with pytest.raises(InputError, match="one or more"):
        press_spatial([])
    with pytest.raises(InputError, match="rigid surface of a contact"):
        press_spatial([SpatialContact(surface, GROUND)], {ball: (0.0, 0.0, 1.0)})
    with pytest.raises(InputError, match="AugmentedLagrange"):
        SpatialContact(surface, GROUND, AugmentedLagrange(1e4, "length", 1e-3))
    with pytest.raises(InputError, match="lid"):
        FaceSurface(body, "lid")
    with pytest.raises(InputError, match="radius"):
        RigidSphere((0.0, 0.0, 0.0), -1.0)
