"""Bending of the rails on their bases."""

import numpy as np
import pytest

from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase
from flangeway.post import stresses_at
from flangeway.problems import ElasticField
from flangeway.railway.profiles.bundled import rail
from flangeway.railway.wheelset.bending import narrowest_web, rail_bending
from flangeway.railway.wheelset.wheelset_result import solve_wheelset

THICKNESS = 10.0


@pytest.fixture(scope="module")
def curve():
    """A curve with elements of order 2, whose forces through cuts are accurate."""
    return solve_wheelset(WheelsetCurveCase.from_values({"size_scale": 2.0, "order": 2}).problem())


@pytest.fixture(scope="module")
def tangent():
    """A wheelset on straight track."""
    return solve_wheelset(WheelsetTangentCase.from_values({"size_scale": 2.0, "order": 2}).problem())


def in_rail(result, side):
    """Contact force on the rail of a side in the frame of its profile, and its place."""
    placement = result.placements[f"rail-{side}"]
    force = -placement.inverse().vectors([result.force_on_wheel_N(side)])[0]
    moment = 0.0
    for patch in result.patches:
        if patch.side == side:
            own = -placement.inverse().vectors([patch.force_on_wheel_N])[0]
            moment += patch.rail_point_mm[0] * own[1] - patch.rail_point_mm[1] * own[0]
    return force, moment


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_web_bears_the_contact_force(curve, side):
    """Force and moment through the web's narrowest place are those of the contact forces on the head, to 2 %."""
    found = rail_bending(curve, side)
    force, moment = in_rail(curve, side)
    size = float(np.linalg.norm(force))
    assert found.web_normal_N == pytest.approx(force[1], abs=0.02 * size)
    assert found.web_shear_N == pytest.approx(force[0], abs=0.02 * size)
    arm = (0.0, found.web_height_mm)
    expected = moment - (arm[0] * force[1] - arm[1] * force[0])
    assert found.web_moment_Nmm == pytest.approx(expected, abs=0.02 * size * 90.0)


@pytest.mark.parametrize("side", ["left", "right"])
def test_stresses_of_the_web_are_those_of_a_beam(curve, side):
    """At the narrowest place the faces have the force over the section and the moment over its modulus, to 5 %."""
    found = rail_bending(curve, side)
    mean = found.web_normal_N / (THICKNESS * found.web_thickness_mm)
    bent = 6.0 * found.web_moment_Nmm / (THICKNESS * found.web_thickness_mm**2)
    gauge, field = found.faces
    scale = abs(mean) + abs(bent)
    assert gauge.web_MPa == pytest.approx(mean - bent, abs=0.05 * scale)
    assert field.web_MPa == pytest.approx(mean + bent, abs=0.05 * scale)


def test_stresses_along_the_surface_are_principal_stresses_of_the_cells(curve):
    """In the fillets the stress along the surface is that in the cells below it, along it, to 8 % of the maximum."""
    found = rail_bending(curve, "right")
    part = curve.model.parts["rail-right"]
    field = ElasticField(part.body.elasticity, curve.displacements["rail-right"])
    for face in found.faces:
        heights = face.points_mm[:, 1]
        near = (heights > 30.0) & (heights < 135.0)
        components = stresses_at(field, (face.points_mm - 1e-6 * face.outwards)[near]).components
        along = np.stack((-face.outwards[near, 1], face.outwards[near, 0]), axis=1)
        planes = np.array([[components[:, 0], components[:, 2]], [components[:, 2], components[:, 1]]])
        cells = np.einsum("ni,ijn,nj->n", along, planes, along)
        maximum = np.abs(face.stresses_MPa).max()
        assert np.abs(cells - face.stresses_MPa[near]).max() < 0.08 * maximum


def test_faces_go_up_from_the_base(curve):
    """Each face has points on its own side, from the base up, with normals out of the rail."""
    for face, sign in zip(rail_bending(curve, "right").faces, (-1.0, 1.0), strict=True):
        assert face.face == ("gauge" if sign < 0.0 else "field")
        assert (sign * face.points_mm[:, 0] > 0.0).all()
        assert face.points_mm[-1, 1] > 130.0
        assert face.points_mm[0, 1] < 20.0
        web = np.abs(face.points_mm[:, 1] - 90.0) < 20.0
        assert (sign * face.outwards[web, 0] > 0.99).all()


def test_extremes_are_the_maximum_between_two_heights(curve):
    """Tension and compression are the maximum and the least value between the heights; without edges they are nan."""
    face = rail_bending(curve, "right").faces[0]
    upper = face.points_mm[:, 1] > 90.0
    assert face.extreme(1.0, 90.0)[0] == face.stresses_MPa[upper].max()
    value, place = face.extreme(-1.0, 90.0)
    assert value == face.stresses_MPa[upper].min()
    assert place[1] > 90.0
    assert np.isnan(face.extreme(1.0, 500.0)[0])


def test_the_flange_bends_the_outer_rail_outwards(curve):
    """In the curve the outer rail's gauge face moves outwards and its web is in tension at the lower gauge fillet."""
    outer = rail_bending(curve, "right")
    assert outer.gauge_outward_mm > 0.5
    assert outer.head_motion.lateral_mm > 0.5
    gauge, field = outer.faces
    assert gauge.extreme(1.0, below_mm=outer.web_height_mm)[0] > 100.0
    assert field.extreme(-1.0, below_mm=outer.web_height_mm)[0] < -1000.0


def test_sides_of_a_symmetric_wheelset_mirror_each_other(tangent):
    """On straight track both rails bend alike, mirrored."""
    left, right = (rail_bending(tangent, side) for side in ("left", "right"))
    assert left.head_motion.lateral_mm == pytest.approx(-right.head_motion.lateral_mm, rel=1e-6)
    assert left.head_motion.vertical_mm == pytest.approx(right.head_motion.vertical_mm, rel=1e-6)
    assert left.head_motion.roll_rad == pytest.approx(-right.head_motion.roll_rad, rel=1e-6)
    assert left.gauge_outward_mm == pytest.approx(right.gauge_outward_mm, rel=1e-6)
    for one, other in zip(left.faces, right.faces, strict=True):
        assert one.web_MPa == pytest.approx(other.web_MPa, rel=1e-6)


def test_the_head_moves_as_its_points_do(tangent):
    """The fitted motion of the head's top and roll is that of points of the head far from it, to 0.1 mm."""
    found = rail_bending(tangent, "right")
    part, placement = tangent.model.parts["rail-right"], tangent.placements["rail-right"]
    mesh = part.body.mesh
    moved = placement.vectors(tangent.displacements["rail-right"][: mesh.n_points])
    points = placement.points(mesh.points)
    top = placement.points([(0.0, mesh.points[:, 1].max())])[0]
    far = (mesh.points[:, 1] > 153.0) & (mesh.points[:, 1] < 160.0)
    arms = points[far] - top
    motion = found.head_motion
    rigid = np.array([motion.lateral_mm, motion.vertical_mm]) + motion.roll_rad * np.stack(
        (-arms[:, 1], arms[:, 0]), axis=1
    )
    assert np.abs(moved[far] - rigid).max() < 0.1


@pytest.mark.parametrize(("name", "thickness", "height"), [("136RE", 17.46, 90.2), ("60E1", 16.5, None)])
def test_the_web_of_bundled_rails_has_its_nominal_thickness(name, thickness, height):
    """The narrowest place is 11/16 in thick in the 136RE and 16.5 mm in the 60E1."""
    found, left, right = narrowest_web(rail(name).outline)
    assert right - left == pytest.approx(thickness, abs=0.02)
    assert left == pytest.approx(-right, abs=1e-6)
    if height is not None:
        assert found == pytest.approx(height, abs=0.5)
