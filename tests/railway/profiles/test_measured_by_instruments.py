"""Measured and worn profiles: as instruments write them, from noisy files to the equilibrium."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks import worn
from flangeway.cases import Wheelset
from flangeway.cases.case_file import load_case
from flangeway.cases.rigid_run import GeometryCase
from flangeway.cases.wheelset.wheelset_notes import side_warnings
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.instrument_files import write_miniprof
from flangeway.railway.profiles.joining import joined, on_plain_body
from flangeway.railway.profiles.named import RailFile, WheelFile, profile_of
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.profiles.smoothing import smoothed, usual_wavelength_mm
from flangeway.railway.rigid.rigid_equilibrium import rigid_equilibrium
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import Track, WheelPair
from flangeway.railway.track.supports import Sleepers
from flangeway.railway.track.wheelset_loads import WheelsetLoad
from flangeway.railway.wheelset.supported_rail import supported_rail


def on_body(path, body):
    """A rail or wheel of a file on the body of a bundled one."""
    kind = "rail" if str(path).endswith("ban") else "wheel"
    return profile_of((RailFile if kind == "rail" else WheelFile)(file=path, body=body), kind)


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
    profile = on_body(saved(tmp_path, points, "worn.ban"), "60E1")
    found = supported_rail(profile, Elastic(210e3, 0.3), Sleepers(), 25.0)
    mesh = found.problem.elasticity.space.mesh
    corners = np.vstack([segment.start for segment in profile.outline.part(profile.running_names).segments])
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
    profile = on_body(path, "heavy-haul")
    (note,) = [each for each in profile.notices if each.startswith("Beyond")]
    x, y = 70.0 + tread()[-80, 0], -tread()[-80, 1]
    assert f"x = {x:.4g}" in note
    assert "rim.whl" in note
    assert "rim" in note.rpartition("(")[2]
    assert float(note.partition("y = ")[2].partition(" ")[0]) == pytest.approx(y, abs=1.0)
    worn, new = (
        RigidGeometry.of(Track(), WheelPair(wheel=each, back_to_back_mm=1360.0)) for each in (profile, wheel("S1002"))
    )
    at = np.array([-4.0, 0.0, 3.0])
    np.testing.assert_allclose(
        worn.locus(at).right.rolling_radii_mm[:, 0], new.locus(at).right.rolling_radii_mm[:, 0], atol=0.02
    )


def test_a_web_below_the_head_is_left_out_and_said(tmp_path):
    """A head whose file goes on down an upright line for 25 mm stands as the head alone; a note has the coordinates."""
    points = head()
    down = points[-1] - np.column_stack((np.zeros(100), np.linspace(0.25, 25.0, 100)))
    with_web = on_body(saved(tmp_path, np.vstack((points, down)), "web.ban"), "60E1")
    plain = on_body(saved(tmp_path, points, "plain.ban"), "60E1")
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
def test_heads_worn_flat_stand_in_the_middle_alone(tmp_path, worn_mm):
    """Points of a flat top with sharp corners: one equilibrium, as on lines and arcs; waves at its corners had nine."""
    points = rail("60E1").running_surface.sampled(spacing=0.25, max_deviation=1e-3)
    points = points - [0.0, points[:, 1].max()]
    flat = np.stack((points[:, 0], np.minimum(points[:, 1], -worn_mm)), axis=1)
    track = Track(rail=on_body(saved(tmp_path, flat, "flat.ban"), "60E1"))
    axle = WheelPair(back_to_back_mm=1360.0, radius_mm=460.0, radius_at="flange-tip")
    found = rigid_equilibrium(RigidGeometry.of(track, axle), WheelsetLoad(2e5))
    assert found.position.motion_in_space.lateral_mm == pytest.approx(0.0, abs=1e-6)
    assert found.position.stable
    assert len(found.positions) == 1


def test_a_left_rail_is_mirrored_with_a_warning(tmp_path):
    """Wear of 3 mm at the field side mirrors a head, with a warning that names the key; 1 mm does not, nor the key."""
    right = read_profile(saved(tmp_path, head(3.0), "right.ban"))
    left = saved(tmp_path, head(3.0) * [-1.0, 1.0], "left.ban")
    np.testing.assert_allclose(read_profile(left).points, right.points, atol=1e-8)
    (warning,) = side_warnings(Track(rail=RailFile(file=left, body="60E1")))
    assert "left-hand" in warning
    assert "track.rail.mirror" in warning
    kept = read_profile(left, ReadOptions(mirror=False))
    np.testing.assert_allclose(kept.points[::-1], right.points * [-1.0, 1.0], atol=1e-8)
    small = saved(tmp_path, head(1.0) * [-1.0, 1.0], "small.ban")
    assert not read_profile(small).orientation.mirrored
    assert any("field side" in each for each in side_warnings(Track(rail=RailFile(file=small, body="60E1"))))


def test_a_wheel_worn_in_memory_stands_on_its_worn_surface():
    """A running surface 0.6 mm higher lowers the rigid wheelset by 0.6 mm and its rolling radius as much."""
    new = wheel("S1002")
    worn = replace(new, fine=new.running_surface.transformed(Placement(translation=(0.0, 0.6))))
    axles = [WheelPair(wheel=each, back_to_back_mm=1360.0) for each in (worn, new)]
    found = [RigidGeometry.of(Track(), axle).locus(np.array([0.0])) for axle in axles]
    assert found[0].vertical_mm[0] - found[1].vertical_mm[0] == pytest.approx(-0.6, abs=1e-9)
    radii = [each.right.rolling_radii_mm[0, 0] for each in found]
    assert radii[1] - radii[0] == pytest.approx(0.6, abs=1e-9)


@pytest.mark.parametrize("case", [Wheelset, GeometryCase])
def test_mirror_unit_and_tape_are_inputs_of_cases(case, tmp_path):
    """Every case takes ``mirror``, ``unit`` and ``tape_mm`` of files, and those of the left side."""
    right = head(2.0)
    left = saved(tmp_path, right * [-1.0, 1.0], "left.ban")
    inches = tmp_path / "inches.txt"
    np.savetxt(inches, right / 25.4, "%.6f")
    wheels = tmp_path / "wheel.txt"
    np.savetxt(wheels, wheel("S1002").running_surface.sampled(spacing=0.5) / 25.4, "%.6f")
    made = case(
        track={
            "rail": {"file": str(inches), "unit": "in", "body": "60E1"},
            "left": {"rail": {"file": left, "mirror": True, "body": "60E1"}},
        },
        wheelset={"wheel": {"file": str(wheels), "unit": "in", "tape_mm": 71.0, "body": "S1002"}},
    )
    track = made.track
    outlines = [track.rail_of(side).outline.sampled(spacing=1.0) for side in ("left", "right")]
    assert track.rail_of("right").outline.closest(outlines[0])[2].max() < 0.02
    assert not any("field side" in each for side in ("left", "right") for each in track.rail_of(side).notices)
    assert made.wheels.wheel_of("left").flange_back_mm == 71.0
    wrong = track.replaced(left={"rail": {"mirror": False}})
    assert any("track.left.rail.mirror" in each for each in wrong.rail_of("left").notices)


def test_what_is_said_of_no_file_is_refused():
    """What a file does not say is refused of a bundled profile, and of a side without one, with its path."""
    for name, value in (("track.rail.mirror", True), ("wheelset.wheel.tape_mm", 70.0), ("track.left.rail.unit", "in")):
        with pytest.raises(InputError, match=name.rpartition(".")[0].replace(".", r"\.")):
            load_case("wheelset", **{name: value}).check()


NOISE_MM, SPACING_MM = worn.NOISE_MM, worn.SPACING_MM


@pytest.fixture(scope="module")
def pairs(tmp_path_factory):
    """Inputs that name files of the pair, without and with noise."""
    found = {}
    for name, noise in (("smooth", 0.0), ("noisy", NOISE_MM)):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(worn, "NOISE_MM", noise)
            found[name] = worn.worn_pair(tmp_path_factory.mktemp(name))
    return found


@pytest.fixture(scope="module")
def runs(pairs):
    """Function that solves a case once: tangent without and with noise, curve with noise; and what it said."""

    @cache
    def solved(name):
        case, said = f"wheelset-{'curve' if name == 'curve' else 'tangent'}", []
        run = load_case(case, **pairs["smooth" if name == "smooth" else "noisy"], size_scale=3.0).run(said.append)
        return run, said

    return solved


@pytest.mark.ci
@pytest.mark.parametrize("name", ["smooth", "noisy", "curve"])
def test_the_chain_ends_in_equilibrium(name, runs):
    """From the files to the equilibrium: converged, errors below 1e-10, contact forces that carry the load."""
    run, _ = runs(name)
    assert run.result.status.converged, run.result.status.message
    assert run.result.equilibrium.residuals.equilibrium_residual < 1e-10
    along, onto = run.result.model.problem.forces.in_track
    total = sum(patch.force_on_wheel_N for patch in run.result.patches)
    assert total == pytest.approx([-along, onto], rel=1e-8, abs=1.0)


def test_a_hollow_tread_conforms(runs):
    """The worn wheel touches at one wide place: more than 9 mm half width, where the new pair has 6.4 mm."""
    patches = runs("smooth")[0].result.patches
    assert [patch.side for patch in patches] == ["left", "right"]
    assert min(patch.half_width for patch in patches) > 9.0


def test_noise_is_no_wear(runs):
    """With 30 micrometres of noise the contacts are as many, 1.5 mm about their places, their pressure within 20 %."""
    smooth, noise = (runs(name)[0].result.patches for name in ("smooth", "noisy"))
    assert [patch.side for patch in noise] == [patch.side for patch in smooth]
    for one, other in zip(smooth, noise, strict=True):
        assert other.rail_point_mm == pytest.approx(one.rail_point_mm, abs=1.5)
        assert other.max_pressure == pytest.approx(one.max_pressure, rel=0.2)


def test_the_run_says_how_the_noise_was_smoothed(runs):
    """What was done to the files stands among the assumptions of the run, with wheel and rail named."""
    said = [line for line in runs("noisy")[0].summary["assumptions"] if "The noise is" in line]
    assert len(said) == 2
    noise = [float(line.split("The noise is ")[1].split(" micrometres")[0]) for line in said]
    assert noise == pytest.approx([1e3 * NOISE_MM] * 2, rel=0.2)
    assert "AAR-1B" in said[0]
    assert "136RE" in said[1]


def test_a_conforming_pair_costs_no_second_model(runs):
    """Its wide contact is foreseen: one model of at most 2.4 times the bundled pair's surface nodes."""
    run, said = runs("noisy")
    plain = load_case("wheelset-tangent", size_scale=3.0).run()
    nodes = [sum(len(each.points) for each in one.result.model.system.surface_nodes) for one in (run, plain)]
    assert not any(sentence.startswith("once more") for sentence in said)
    assert nodes[0] < 2.4 * nodes[1]


def test_the_wavelength_bounds_the_scatter_of_the_curvature():
    """White noise of 30 micrometres on a straight line leaves a curvature that scatters by 0.001/mm, as is bound."""
    x = np.arange(0.0, 400.0, SPACING_MM)
    points = np.column_stack((x, NOISE_MM * np.random.default_rng(3).normal(size=len(x))))
    found = smoothed(points, limit_um=1e4)
    assert found.wavelength_mm == usual_wavelength_mm(1e3 * NOISE_MM, SPACING_MM) == 11.0
    inner = found.points[40:-40]
    curvature = np.gradient(np.gradient(inner[:, 1], inner[:, 0]), inner[:, 0])
    assert np.std(curvature) == pytest.approx(1e-3, rel=0.3)
    assert usual_wavelength_mm(2.0, SPACING_MM) == 5.0
    assert usual_wavelength_mm(500.0, SPACING_MM) == 20.0


TAPE_MM = 72.0


@pytest.fixture
def file(tmp_path):
    """A worn S1002, measured from 3 mm above the flange's tip to the rim, whose file counts from the flange's back."""
    points = wheel("S1002").running_surface.sampled(spacing=0.5)
    points = points[(points[:, 0] > -60.0) | (points[:, 1] < -25.0)]
    points = points[points[:, 0] > -63.0]
    hollow = 0.4 * np.exp(-((points[:, 0] / 25.0) ** 2))
    points = points + np.column_stack([np.zeros(len(points)), hollow])
    path = tmp_path / "worn.whl"
    path.write_text(write_miniprof(points, "wheel", "worn", TAPE_MM), encoding="utf-8")
    return path


def bodies(file):
    """The wheel on every bundled body and on the plain one."""
    measured = read_profile(file, ReadOptions(smooth_mm=5.0))
    return [on_plain_body(measured), *(joined(measured, name).profile for name in ("S1002", "AAR-1B", "heavy-haul"))]


def test_the_joined_body_does_not_move_the_wheel(file):
    """On any body a measured wheel stands its file's tape distance from the inner face, and reaches the same shift."""
    wheels = bodies(file)
    assert [each.flange_back_mm for each in wheels] == [TAPE_MM] * 4
    shifts = []
    for each in wheels:
        path = RigidGeometry.of(Track(), WheelPair(wheel=each, back_to_back_mm=1360.0)).path(40.0)
        shifts.append((path.rail_level - 460.0 * np.sin(path.roll)).max())
    assert np.ptp(shifts) < 0.02
    assert all(f"{TAPE_MM:g} mm from the flange's back (from the file)" in each.certainty for each in wheels)


def test_tape_mm_is_an_input_of_cases(file):
    """``tape_mm`` moves the wheel on its axle, and the distance stands with its origin in the summary's words."""
    places = {}
    for tape in (None, 70.0, 74.0):
        axle = WheelPair(wheel=WheelFile(file=str(file), body="plain", tape_mm=tape), back_to_back_mm=1360.0)
        profile = axle.wheel_of("right")
        face = axle.placement("right").points(profile.running_surface.sampled(spacing=0.5))
        places[tape] = axle.back_to_back_mm / 2.0 + profile.flange_back_mm
        assert profile.flange_back_mm == (tape or TAPE_MM)
        # the file counts from the flange's back: its points stay where they are, the tape line moves on them
        assert face[:, 0].min() == pytest.approx(680.0 + TAPE_MM - 63.0, abs=0.6)
    assert places[74.0] - places[70.0] == 4.0


def test_a_back_that_is_not_measured_is_assumed_and_said(tmp_path):
    """A file that counts from the tape line and does not show the flange's back gets 70 mm, with a notice."""
    points = wheel("AAR-1B").running_surface.sampled(spacing=0.5)
    path = tmp_path / "half.txt"
    for head, expected in (("", 70.0), ("tape_mm: 77", 77.0)):
        header = f"unit: mm\nkind: wheel\norigin: tape\n{head}"
        np.savetxt(path, points[points[:, 0] > -66.0], "%.5f", header=header)
        measured = read_profile(path)
        assert on_plain_body(measured).flange_back_mm == expected
        assert any("flange's back is not measured" in each for each in measured.notices) == (not head)
    np.savetxt(path, points, "%.5f")
    assert read_profile(path, ReadOptions(unit="mm")).flange_back_mm == pytest.approx(77.7875, abs=0.01)
