"""Measured running surfaces on nominal bodies, whole outlines from files, and files of slices."""

import math

import numpy as np
import pytest

from flangeway.cases.rigid_run import GeometryCase
from flangeway.errors import InputError
from flangeway.mesh import check, triangulate
from flangeway.railway.profiles.bundled import RailProfile, rail, wheel
from flangeway.railway.profiles.formats.instrument_files import write_segment_csv
from flangeway.railway.profiles.joining import (
    BLEND_FACTOR,
    MAX_BLEND_MM,
    MIN_BLEND_MM,
    joined,
    nominal_profile,
    on_plain_body,
    whole_profile,
)
from flangeway.railway.profiles.named import RailFile
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.track.placements import Track


def file_of(folder, points, kind, head="", name="m.txt"):
    np.savetxt(folder / name, points, "%.6f", header=f"unit: mm\nkind: {kind}\n{head}")
    return folder / name


def head_points(name="60E1", wear=0.0, spacing=0.3):
    """A head from its top, worn by `wear` at the gauge side of its top, from the gauge side outwards."""
    profile = nominal_profile(name)
    points = profile.running_surface.sampled(spacing=spacing)[::-1] - [0.0, profile.outline.bounds()[1, 1]]
    worn = np.clip((-points[:, 0] - 0.0) / 20.0, 0.0, 1.0) * np.clip((points[:, 1] + 14.0) / 14.0, 0.0, 1.0)
    return points - np.column_stack([np.zeros(len(points)), wear * worn])


def wheel_points(name="S1002", spacing=0.3):
    return wheel(name).running_surface.sampled(spacing=spacing)


@pytest.mark.parametrize("name", ["60E1", "136RE-8"])
def test_the_nominal_head_on_its_own_rail_is_the_rail(name, tmp_path):
    """Joined to the rail that it comes from, a head changes area and outline by micrometres only."""
    measured = read_profile(file_of(tmp_path, head_points(name), "rail"), ReadOptions(smooth_mm=0.0))
    found, nominal = joined(measured, name), nominal_profile(name)
    assert isinstance(found.profile, RailProfile)
    # each straight transition of 3 mm may cut a corner of the head
    assert found.profile.outline.area == pytest.approx(nominal.outline.area, abs=2.0)
    assert nominal.outline.closest(found.measured.sampled(spacing=0.5))[2].max() < 2e-3
    assert max(joint.gap_mm for joint in found.joints) < 1e-3
    assert found.profile.held_names == ("base",)
    assert found.profile.outline.bounds()[0, 1] == 0.0


@pytest.mark.parametrize("name", ["S1002", "heavy-haul"])
def test_the_nominal_tread_on_its_own_wheel_is_the_wheel(name, tmp_path):
    """Joined to the wheel that it comes from, a running surface gives that wheel again."""
    measured = read_profile(file_of(tmp_path, wheel_points(name), "wheel"), ReadOptions(smooth_mm=0.0))
    found, nominal = joined(measured, name), wheel(name)
    assert found.profile.outline.area == pytest.approx(nominal.outline.area, abs=2.0)
    assert found.profile.flange_height_mm == pytest.approx(nominal.flange_height_mm, abs=2e-3)
    assert found.profile.flange_back_mm == pytest.approx(nominal.flange_back_mm, abs=2e-3)
    assert "cut" in found.profile.outline.names


def test_the_rule_is_kept(tmp_path):
    """The measured part is whole, transitions are straight and end on the nominal outline, a blend beyond the foot."""
    points = head_points("60E1", wear=2.0) * [0.99, 1.0]
    measured = read_profile(file_of(tmp_path, points, "rail"), ReadOptions(smooth_mm=0.0))
    found = joined(measured, "60E1")
    outline, nominal = found.profile.outline, found.nominal.outline
    assert outline.part(["measured"]).length == pytest.approx(measured.surface.length, rel=1e-9)
    for joint, name in zip(found.joints, ("transition_field", "transition_gauge"), strict=True):
        (straight,) = outline.part([name]).segments
        ends = sorted([straight.start, straight.end])
        np.testing.assert_allclose(ends, sorted([joint.end, joint.landing]), atol=1e-9)
        assert nominal.closest([joint.landing, joint.foot])[2].max() < 1e-9
        assert joint.gap_mm == pytest.approx(np.hypot(*np.subtract(joint.end, joint.foot)), abs=1e-9)
        blend = min(max(MIN_BLEND_MM, BLEND_FACTOR * joint.gap_mm), MAX_BLEND_MM)
        places = nominal.lengths_at([joint.foot, joint.landing])
        assert abs(places[1] - places[0]) == pytest.approx(blend, abs=1e-6)
    assert found.nominal.outline.area - outline.area > 10.0


def test_heads_that_count_from_the_base_are_placed_by_it(tmp_path):
    """A head in the rail's own frame gives the rail."""
    path = file_of(tmp_path, head_points() + np.array([0.0, 172.0]), "rail", "origin: base")
    found = joined(read_profile(path, ReadOptions(smooth_mm=0.0)), "60E1")
    assert found.profile.outline.bounds()[1, 1] == pytest.approx(172.0, abs=1e-5)


def test_heads_are_placed_by_their_gauge_face(tmp_path):
    """A head that counts from the gauge face 14 mm below its top comes to its place on the rail."""
    points = head_points()
    left = points[points[:, 0] < 0.0]
    face = np.interp(-14.0, left[:, 1], left[:, 0])
    path = file_of(tmp_path, points - [face, 0.0], "rail", "origin: gauge")
    found = joined(read_profile(path, ReadOptions(smooth_mm=0.0)), "60E1")
    assert np.ptp(found.measured.bounds()[:, 0]) == pytest.approx(np.ptp(points[:, 0]), abs=1e-3)
    assert rail("60E1").outline.closest(found.measured.sampled(spacing=0.5))[2].max() < 5e-3


@pytest.mark.parametrize(
    ("points", "kind", "name", "message"),
    [
        (lambda: head_points() + np.array([0.0, 8.0]), "rail", "60E1", "top is 8 mm above that of the nominal 60E1"),
        (lambda: head_points("136RE") + np.array([25.0, 0.0]), "rail", "136RE", "mm from the nominal 136RE"),
        (head_points, "rail", "S1002", "--join S1002, a wheel, for a rail"),
        (wheel_points, "wheel", "AAR-1B", "flange's back"),
    ],
)
def test_what_does_not_fit_is_refused(points, kind, name, message, tmp_path):
    """A head at the wrong place, the other kind, a wheel with another back, and unknown names are refused."""
    measured = read_profile(file_of(tmp_path, points(), kind), ReadOptions(smooth_mm=0.0))
    with pytest.raises(InputError, match=message):
        joined(measured, name)


@pytest.mark.parametrize(("name", "lateral_offset", "lean"), [("136RE", 6.0, 0.0), ("60E1", 0.0, 0.025)])
def test_a_head_counted_from_elsewhere_is_moved_to_its_field_side(name, lateral_offset, lean, tmp_path):
    """A head counted from a mark beside its middle, or from the highest point as it leans, fits with a notice."""
    points = head_points(name) @ np.array([[1.0, -lean], [lean, 1.0]]) / np.hypot(1.0, lean)
    points = points - points[np.argmax(points[:, 1])] * [float(lean != 0.0), 1.0] + [lateral_offset, 0.0]
    found = joined(read_profile(file_of(tmp_path, points, "rail"), ReadOptions(smooth_mm=0.0)), name)
    assert any("moved sideways" in notice for notice in found.profile.notices)
    assert max(joint.gap_mm for joint in found.joints) < 2.5
    assert found.joints[0].gap_mm < 0.2


def test_a_wheel_that_no_bundled_one_is_like_has_a_plain_body(tmp_path):
    """Any running surface of a wheel becomes a wheel below a block, its surface as measured, and is meshed."""
    points = wheel_points()
    measured = read_profile(file_of(tmp_path, points, "wheel"), ReadOptions(smooth_mm=0.0))
    found = on_plain_body(measured)
    assert found.running_surface.length == pytest.approx(measured.surface.length, rel=1e-12)
    assert found.outline.bounds(["cut"])[:, 1] == pytest.approx([50.0, 50.0])
    check(triangulate(found.outline, size=4.0), region_area=found.outline.area, area_tolerance=2e-3)


@pytest.mark.parametrize("make", [lambda: rail("60E1"), lambda: wheel("S1002")])
def test_whole_outlines_become_rails_and_wheels(make, tmp_path):
    """From a closed outline without useful names, head, base, running surface and cut are found again."""
    profile = make()
    is_rail = isinstance(profile, RailProfile)
    outline = profile.outline
    path = tmp_path / "whole.csv"
    text = write_segment_csv(outline, "rail" if is_rail else "wheel", "whole", "base" if is_rail else "tape")
    rows = [("any," + row.partition(",")[2]) if ",line," in row or ",arc," in row else row for row in text.splitlines()]
    path.write_text("\n".join(rows), encoding="utf-8")
    found = whole_profile(read_profile(path))
    assert found.outline.area == pytest.approx(outline.area, rel=1e-12)
    if is_rail:
        head, nominal = found.outline.part(found.running_names), outline.part(profile.running_names)
        assert head.length == pytest.approx(nominal.length, abs=1.0)
        assert np.ptp(head.bounds()[:, 0]) == pytest.approx(
            np.ptp(outline.bounds(profile.running_names)[:, 0]), abs=0.3
        )
        assert found.outline.bounds(found.held_names)[1, 1] == 0.0
    else:
        running = found.outline.part(found.running_names)
        assert running.length == pytest.approx(outline.part(profile.running_names).length, rel=1e-12)
        assert found.outline.bounds(["cut"])[0, 1] == 50.0


@pytest.mark.parametrize(
    ("slope", "depth", "words"),
    [
        (1 / 40, 35.0, "1.4 degrees to the track's middle: if it was measured in the track's axes"),
        (-1 / 40, 35.0, "from the track's middle: a left-hand rail, measured in the track's axes, needs --mirror"),
        (0.0, 35.0, ""),
    ],
)
def test_a_head_that_holds_its_inclination_is_reported(slope, depth, words, tmp_path):
    """A head with the rail's inclination in its points says so, and to which side: with a cant it would lean twice."""
    head = head_points()
    worn = head - [0.0, 3.0] * np.exp(-(((head[:, :1] + 25.0) / 15.0) ** 2))
    angle = np.arctan(slope)
    turned = worn @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    np.savetxt(tmp_path / "head.txt", turned[turned[:, 1] > -depth])
    notices = joined(read_profile(tmp_path / "head.txt", ReadOptions(unit="mm", kind="rail")), "60E1").profile.notices
    leaning = [notice for notice in notices if "leans" in notice]
    assert len(leaning) == (1 if words else 0)
    assert words in "".join(leaning)


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
            track = Track(rail=RailFile(file=str(file), position_mm=position, body=body))
            placed = track.rail_of("right").running_surface.transformed(track.placement("right"))
            nominal = Track(rail="60E1")
            expected = rail("60E1").running_surface.transformed(nominal.placement("right"))
            assert placed.bounds()[1, 1] == pytest.approx(-depth, abs=2e-3)
            assert placed.bounds()[0, 0] == pytest.approx(expected.bounds()[0, 0] + depth / 40.0, abs=3e-3)


def test_a_lower_rail_lets_the_wheelset_roll(tmp_path):
    """With a dip in the right rail only, the wheelset rolls by the depth over the distance of the contacts."""
    track = Track(rail=RailFile(file=str(rail_file(tmp_path)), position_mm=150.0), left={"rail": "60E1"})
    locus = GeometryCase(track=track).geometry().locus([0.0])
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
    """Messages name the input of a case."""
    file = rail_file(tmp_path)
    with pytest.raises(InputError) as caught:
        _ = Track(rail=str(file)).rails
    assert "track.rail.position_mm: 50 to 250 mm" in caught.value.allowed
    with pytest.raises(InputError, match="--position 3"):
        read_profile(tmp_path / "slice0.txt", ReadOptions(position=3.0))
