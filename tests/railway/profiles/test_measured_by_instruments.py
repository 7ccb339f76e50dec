"""Measured profiles as instruments write them, and one surface for start and gap."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flangeway.cases import WheelsetTangentCase
from flangeway.cases.rigid.rigid_case import GeometryCase
from flangeway.cases.wheelset.wheelset_profiles import profile_named, side_warnings
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.miniprof import write_miniprof
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.rigid.rigid_equilibrium import rigid_equilibrium
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.wheelset.supported_rail import RailSupport, supported_rail

GAUGE = {"gauge_mm": 1435.0, "rail_inclination": 0.025, "gauge_depth_mm": 14.0}


@cache
def head(corner_mm: float = 0.0) -> np.ndarray:
    """A 60E1's head from its top, from the field side to the gauge side, its gauge corner worn."""
    points = rail("60E1").running_surface.sampled(spacing=0.3) - [0.0, 172.0]
    points[:, 1] -= corner_mm * np.exp(-(((points[:, 0] + 27.0) / 9.0) ** 2)) * (points[:, 1] > -12.0)
    return points[np.concatenate([[True], np.hypot(*np.diff(points, axis=0).T) > 0.02])]


@cache
def tread() -> np.ndarray:
    """An S1002 from its flange's back to its rim, which goes on upright for 25 mm."""
    points = wheel("S1002").running_surface.sampled(spacing=0.3)
    end = points[-1]
    steps = np.linspace(0.0, np.pi / 2.0, 20)[1:, None]
    corner = end + 3.0 * np.column_stack((np.sin(steps), 1.0 - np.cos(steps)))
    upright = corner[-1] + np.column_stack((np.zeros(80), np.linspace(0.3, 25.0, 80)))
    return np.vstack((points, corner, upright))


def saved(folder, points, name):
    path = folder / name
    path.write_text(write_miniprof(points, "rail" if name.endswith("ban") else "wheel", "measured"), encoding="utf-8")
    return str(path)


def test_points_at_a_joint_far_from_contact_are_projected(tmp_path):
    """Points up to 2 mm beside the chords of a joined section are at the nearest point of its boundary."""
    points = head(1.0) * [0.97, 1.0]
    profile = profile_named(saved(tmp_path, points, "worn.ban"), "rail", body="60E1")
    found = supported_rail(profile, Elastic(210e3, 0.3), RailSupport(), 25.0)
    mesh = found.problem.elasticity.space.mesh
    corners = np.vstack([segment.start for segment in profile.outline.part(profile.head_names).segments])
    beside = corners + np.random.default_rng(3).uniform(-1.4, 1.4, corners.shape)
    nodes, shares = found.on_surface(beside)
    ends = mesh.points[mesh.boundary_edges]
    dense = (ends[:, :1] + np.linspace(0.0, 1.0, 401)[:, None] * (ends[:, 1:] - ends[:, :1])).reshape(-1, 2)
    nearest = np.linalg.norm(beside[:, None] - dense, axis=2).min(axis=1)
    # nodes of the middles of edges are not points of the mesh
    corner = nodes < mesh.n_points
    held = np.where(corner[..., None], mesh.points[np.where(corner, nodes, 0)], 0.0)
    middle = held.sum(axis=1) / corner.sum(axis=1)[:, None]
    at = np.einsum("np,npx->nx", shares, np.where(corner[..., None], held, middle[:, None]))
    np.testing.assert_allclose(np.linalg.norm(beside - at, axis=1), nearest, atol=0.02)
    with pytest.raises(InputError, match="surface"):
        found.on_surface(np.array([[0.0, 100.0]]))


def test_an_overhang_beyond_the_tread_is_left_out_and_said(tmp_path):
    """An upright rim, beyond which the body juts out, is left out of contact; a note has the file's own coordinates."""
    path = saved(tmp_path, tread(), "rim.whl")
    profile = profile_named(path, "wheel", body="heavy-haul")
    (note,) = [each for each in profile.notices if each.startswith("Beyond")]
    x, y = 70.0 + tread()[-80, 0], -tread()[-80, 1]
    assert f"x = {x:.4g}" in note
    assert "rim.whl" in note
    assert "rim" in note.rpartition("(")[2]
    assert float(note.partition("y = ")[2].partition(" ")[0]) == pytest.approx(y, abs=1.0)
    worn, new = (
        RigidGeometry.of(Track(rail("60E1"), **GAUGE), Wheelset(each, 1360.0, 488.0))
        for each in (profile, wheel("S1002"))
    )
    at = np.array([-4.0, 0.0, 3.0])
    np.testing.assert_allclose(
        worn.locus(at).right.rolling_radii_mm[:, 0], new.locus(at).right.rolling_radii_mm[:, 0], atol=0.02
    )


def test_a_web_below_the_head_is_left_out_and_said(tmp_path):
    """A head whose file goes on down an upright line for 25 mm stands as the head alone; a note has the coordinates."""
    points = head()
    down = points[-1] - np.column_stack((np.zeros(100), np.linspace(0.25, 25.0, 100)))
    with_web = profile_named(saved(tmp_path, np.vstack((points, down)), "web.ban"), "rail", body="60E1")
    plain = profile_named(saved(tmp_path, points, "plain.ban"), "rail", body="60E1")
    (note,) = [each for each in with_web.notices if "below the head" in each]
    assert "web.ban (gauge side)" in note
    assert with_web.outline.area == pytest.approx(plain.outline.area, rel=2e-3)
    at = np.linspace(-20.0, 20.0, 41)
    tops = [one.running_surface.sampled(spacing=0.05) for one in (with_web, plain)]
    heights = [np.interp(at, points[::-1, 0], points[::-1, 1]) for points in tops]
    np.testing.assert_allclose(heights[0], heights[1], atol=2e-3)


@pytest.mark.parametrize("worn_mm", [2.0, 8.0, 15.0])
@pytest.mark.parametrize("angle_deg", [60.0, 75.0])
def test_a_worn_gauge_face_shows_the_side(tmp_path, worn_mm, angle_deg):
    """The face of a flange on a head that is not worn on top: right-hand as it is, left-hand mirrored.

    The middle between the faces lies off the head's, so that the field side drops more 25 mm from it.
    """
    points = rail("136RE").running_surface.sampled(spacing=0.25)
    points = points - [0.0, points[:, 1].max()]
    points = points[points[:, 1] > -28.0]
    face = points[:, 0].min() + worn_mm + (points[:, 1] + 14.0) / np.tan(np.radians(angle_deg))
    worn = np.stack((np.maximum(points[:, 0], face), points[:, 1]), axis=1)
    for side in (1.0, -1.0):
        path = tmp_path / "head.txt"
        np.savetxt(path, worn * [side, 1.0], header="x_mm y_mm")
        assert read_profile(path, ReadOptions(kind="rail")).orientation.mirrored == (side < 0.0)


@pytest.mark.parametrize("worn_mm", [5.0, 8.0])
def test_heads_worn_flat_have_all_their_equilibria(tmp_path, worn_mm):
    """Sharp corners of a flat top: where a flange rides on them the touch jumps by micrometres, which is no gap."""
    points = rail("60E1").running_surface.sampled(spacing=0.25, max_deviation=1e-3)
    points = points - [0.0, points[:, 1].max()]
    flat = np.stack((points[:, 0], np.minimum(points[:, 1], -worn_mm)), axis=1)
    track = Track(profile_named(saved(tmp_path, flat, "flat.ban"), "rail", body="60E1"), **GAUGE)
    found = rigid_equilibrium(RigidGeometry.of(track, Wheelset(wheel("S1002"), 1360.0, 460.0)), WheelsetLoad(2e5))
    assert found.position.motion_in_space.lateral_mm == pytest.approx(0.0, abs=1e-6)
    assert found.position.stable
    assert len(found.positions) > 1


def test_a_left_rail_is_mirrored_with_a_warning(tmp_path):
    """Wear of 3 mm at the field side mirrors a head, with a warning that names the key; 1 mm does not, nor the key."""
    right = read_profile(saved(tmp_path, head(3.0), "right.ban"))
    left = saved(tmp_path, head(3.0) * [-1.0, 1.0], "left.ban")
    np.testing.assert_allclose(read_profile(left).points, right.points, atol=1e-8)
    (warning,) = side_warnings(Track(profile_named(left, "rail", body="60E1"), **GAUGE))
    assert "left-hand" in warning
    assert "rail_mirror" in warning
    kept = read_profile(left, ReadOptions(mirror=False))
    np.testing.assert_allclose(kept.points[::-1], right.points * [-1.0, 1.0], atol=1e-8)
    small = saved(tmp_path, head(1.0) * [-1.0, 1.0], "small.ban")
    assert not read_profile(small).orientation.mirrored
    assert any(
        "field side" in each for each in side_warnings(Track(profile_named(small, "rail", body="60E1"), **GAUGE))
    )


def test_a_wheel_worn_in_memory_stands_on_its_worn_surface():
    """A running surface 0.6 mm higher lowers the rigid wheelset by 0.6 mm and its rolling radius as much."""
    new = wheel("S1002")
    worn = replace(new, fine=new.running_surface.transformed(Placement(translation=(0.0, 0.6))))
    track = Track(rail("60E1"), **GAUGE)
    found = [RigidGeometry.of(track, Wheelset(each, 1360.0, 488.0)).locus(np.array([0.0])) for each in (worn, new)]
    assert found[0].vertical_mm[0] - found[1].vertical_mm[0] == pytest.approx(-0.6, abs=1e-9)
    radii = [each.right.rolling_radii_mm[0, 0] for each in found]
    assert radii[1] - radii[0] == pytest.approx(0.6, abs=1e-9)


@pytest.mark.parametrize("case", [WheelsetTangentCase, GeometryCase])
def test_mirror_unit_and_tape_are_keys_of_cases(case, tmp_path):
    """Every case takes ``rail_mirror``, ``rail_unit``, ``wheel_tape_mm`` and those of the left side."""
    right = head(2.0)
    left = saved(tmp_path, right * [-1.0, 1.0], "left.ban")
    inches = tmp_path / "inches.txt"
    np.savetxt(inches, right / 25.4, "%.6f")
    wheels = tmp_path / "wheel.txt"
    np.savetxt(wheels, wheel("S1002").running_surface.sampled(spacing=0.5) / 25.4, "%.6f")
    values = {
        "rail": str(inches), "rail_unit": "in", "left_rail": str(left), "left_rail_mirror": True, "rail_body": "60E1",
        "wheel": str(wheels), "wheel_unit": "in", "wheel_tape_mm": 71.0, "wheel_body": "S1002", "gauge_mm": 1435.0,
    }  # fmt: skip
    made = case.from_values(values)
    track, axle = made.track(), made.wheelset()
    outlines = [track.rail_of(side).outline.sampled(spacing=1.0) for side in ("left", "right")]
    assert track.rail_of("right").outline.closest(outlines[0])[2].max() < 0.02
    assert not any("field side" in each for side in ("left", "right") for each in track.rail_of(side).notices)
    assert axle.wheel.flange_back_mm == 71.0
    wrong = case.from_values({**values, "left_rail_mirror": False}).track()
    assert any("left_rail_mirror" in each for each in wrong.rail_of("left").notices)


def test_a_key_for_no_file_is_refused():
    """What is said of the file of a bundled or missing profile is refused, with the key."""
    for values in ({"rail_mirror": True}, {"wheel_tape_mm": 70.0}, {"left_rail_unit": "in"}):
        with pytest.raises(InputError, match=next(iter(values))):
            WheelsetTangentCase.from_values(values).problem()
