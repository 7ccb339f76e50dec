"""Rails that vary along the track and wheels that vary around the axle, from files of slices."""

import math

import numpy as np
import pytest

from flangeway.cases.rigid.rigid_case import GeometryCase
from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.track.placements import Track


def head(lower=0.0):
    """Points of a 60E1's head about its top, z down, from the gauge side."""
    profile = rail("60E1")
    points = profile.running_surface.sampled(spacing=0.5)[::-1] - [0.0, 172.0]
    return points * [1.0, -1.0] + [0.0, lower]


def rail_file(folder, *, text="", lower=(0.0, 2.0, 4.0), header="0.05 1000.0 offset, scale\n3\n0 0 0\n1\n"):
    """A rail whose head falls: slices at 50, 150 and 250 mm."""
    for number, depth in enumerate(lower):
        np.savetxt(folder / f"slice{number}.txt", head(depth), fmt="%.5f")
    names = "".join(f"{0.1 * number} 'slice{number}.txt' % comment\n" for number in range(len(lower)))
    file = folder / "dip.slcs"
    file.write_text(f"% a made-up dip\n\n{header}{names}{text}")
    return file


def at(file, position, **options):
    return read_profile(file, ReadOptions(position=position, **options))


@pytest.mark.parametrize(("position", "depth"), [(75.0, 0.5), (250.0, 4.0)])
def test_a_section_is_between_its_neighbours(tmp_path, position, depth):
    """Positions are scaled with their offset; a section between two slices has the heights between them."""
    found = at(rail_file(tmp_path), position)
    nominal = rail("60E1").running_surface
    assert found.title == f"dip at {position:g} mm"
    assert found.kind == "rail"
    assert nominal.closest(found.points + np.array([0.0, 172.0 + depth]))[2].max() < 3e-3


def test_all_sections_are_placed_as_the_first_slice(tmp_path):
    """A lower head stays lower on the track, on the body of a bundled rail and on a plain one."""
    file = rail_file(tmp_path)
    for body in ("60E1", "plain"):
        for position, depth in ((50.0, 0.0), (200.0, 3.0)):
            inputs = {"rail": str(file), "rail_position_mm": position, "rail_body": body, "gauge_mm": 1435.0}
            track = GeometryCase.from_values(inputs | {"wheel": "S1002"}).track()
            profile = track.rail
            placed = profile.running_surface.transformed(track.placement("right"))
            nominal = Track(rail("60E1"), 1435.0)
            expected = nominal.rail.running_surface.transformed(nominal.placement("right"))
            assert placed.bounds()[1, 1] == pytest.approx(-depth, abs=2e-3)
            assert placed.bounds()[0, 0] == pytest.approx(expected.bounds()[0, 0] + depth / 40.0, abs=3e-3)


def test_a_lower_rail_lets_the_wheelset_roll(tmp_path):
    """With a dip in the right rail only, the wheelset rolls by the depth over the distance of the contacts."""
    file = rail_file(tmp_path)
    inputs = {"rail": str(file), "rail_position_mm": 150.0, "left_rail": "60E1", "wheel": "S1002", "gauge_mm": 1435.0}
    locus = GeometryCase.from_values(inputs).geometry().locus([0.0])
    assert locus.roll_rad[0] == pytest.approx(-2.0 / 1500.0, rel=0.03)


def wheel_file(folder, depth=0.8):
    """An S1002 with a flat about 10 degrees, slices in degrees."""
    points = wheel("S1002").running_surface.sampled(spacing=0.5) * [1.0, -1.0]
    flat = points.copy()
    flat[:, 1] -= depth * np.exp(-(((points[:, 0]) / 25.0) ** 2))
    for name, each in (("round", points), ("flat", flat)):
        np.savetxt(folder / f"{name}.txt", each[::-1], fmt="%.5f")
    file = folder / "flat.slcw"
    scale = math.pi / 180.0
    slices = "5 'round.txt'\n10 'flat.txt'\n15 'round.txt'\n"
    file.write_text(f"0.0 {scale:.10f} TH_OFFSET, TH_SCALE\n3 NSLC\n0 0 0\n2\n{slices}")
    return file


@pytest.mark.parametrize(("angle", "depth"), [(370.0, 0.8), (7.5, 0.4), (-90.0, 0.0)])
def test_a_flat_keeps_its_depth_and_ends_beside_it(tmp_path, angle, depth):
    """The flat is above the tread of the round wheel; angles are modulo a turn, beyond the slices it is round."""
    found = at(wheel_file(tmp_path), angle)
    height = found.points[np.argmin(np.abs(found.points[:, 0])), 1]
    assert height == pytest.approx(depth, abs=0.02)
    assert not any("moved to zero" in notice for notice in found.notices)


def test_features_cut_and_part_the_slices(tmp_path):
    """Parts are interpolated by themselves; a part that one slice does not have is left out between the slices."""
    header = "0 1 offset, scale\n3\n3 0 0 features\n1\n"
    table = "0 10.0 60 110\n0.1 10.0 60 110\n0.2 -1 60 110\n"
    file = rail_file(tmp_path, header=header, text=table)
    whole, between, cut = (at(file, position) for position in (0.0, 0.05, 0.15))
    ends = whole.points[[0, -1]]
    np.testing.assert_allclose(between.points[[0, -1], 0], ends[:, 0], atol=0.5)
    lengths = [np.hypot(*np.diff(each.points, axis=0).T).sum() for each in (whole, between, cut)]
    assert lengths == pytest.approx([100.0, 100.0, 50.0], abs=1.0)


@pytest.mark.parametrize(("phase", "height"), [(0.0, -0.3), (20.0, 0.3)])
def test_a_corrugation_lowers_and_lifts_the_section(tmp_path, phase, height):
    """One slice and a wave of 40 mm along the track: its height at 10 mm, with a phase in mm."""
    np.savetxt(tmp_path / "slice0.txt", head(), fmt="%.5f")
    file = tmp_path / "wave.slcs"
    file.write_text(f"0 1\n1\n0\n0 1\n0 'slice0.txt'\n1\n0.3 40 {phase}\n")
    assert at(file, 10.0).points[:, 1].max() == pytest.approx(height, abs=1.1e-4)


WRONG = (
    ("0 0\n", "line 1: scale = 0", "positive scale"),
    ("0 1\n2\n0 0 0\n7\n", "line 4: interpolation = 7", "0 to 2"),
    ("0 1\n2\n0 0 0\n1\n0 slice0.txt\n", "line 5: '0 slice0.txt'", "quotation marks"),
    ("0 1\n2\n0 0 0\n1\n0 'slice0.txt'\n0 'slice1.txt'\n", "line 6: position 0", "increase"),
    ("0 1\n2\n2\n1\n0 'slice0.txt'\n1 'slice1.txt'\n0 5 1\n1 0 9\n", "line 7: lengths that do not", "2 lengths"),
    ("0 1\n2\n0 0 0\n1\n0 'slice0.txt'\n1 'gone.txt'\n", "gone.txt", "can be read"),
)


@pytest.mark.parametrize(("text", "given", "allowed"), WRONG)
def test_wrong_files_are_refused_with_their_line(tmp_path, text, given, allowed):
    """The message names the line and what is allowed."""
    rail_file(tmp_path)
    file = tmp_path / "wrong.slcs"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        at(file, 0.7)
    assert given in caught.value.given
    assert allowed in caught.value.allowed


def test_a_position_is_needed_and_only_for_slices(tmp_path):
    """Messages name the key of a case."""
    file = rail_file(tmp_path)
    with pytest.raises(InputError) as caught:
        GeometryCase.from_values({"rail": str(file), "gauge_mm": 1435.0}).track()
    assert "rail_position_mm: 50 to 250 mm" in caught.value.allowed
    with pytest.raises(InputError, match="rail_position_mm of the bundled 60E1"):
        GeometryCase.from_values({"rail": "60E1", "rail_position_mm": 1.0}).track()
    with pytest.raises(InputError, match="--position 3"):
        read_profile(tmp_path / "slice0.txt", ReadOptions(position=3.0))
