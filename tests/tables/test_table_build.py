"""Tables of a wheelset: beside its own positions, in files, interrupted, and by `flangeway creep-table`."""

import csv
import json

import numpy as np
import pytest

from flangeway.cases import Wheelset
from flangeway.cli.batch_commands import values_of
from flangeway.errors import InputError
from flangeway.tables import (
    CreepTable,
    TableRequest,
    make_table,
    table_build,
    table_positions,
    write_table,
)
from flangeway.tables.table_build import _Build, _go_over, claimed_error
from flangeway.tables.table_positions import CHECKED_FRICTIONS, FRICTION, PositionTask, compute_position
from tests.tables.conftest import COARSE


@pytest.fixture(scope="module")
def folder(small, tmp_path_factory):
    """The small table in files, with the FMU."""
    place = tmp_path_factory.mktemp("table")
    write_table(small[0], place, fmu=True)
    return place


def test_the_table_has_the_wheelset_of_each_position(small):
    """Both wheels carry the load, the middle is symmetric, at 0.5 mm to the right radii differ as the cone says."""
    table, sentences, _ = small
    found = table.contacts([0.0, 0.5], 0.0, 100.0)
    vertical = (found["normal_force_N"] * np.cos(found["contact_angle_rad"])).sum(axis=(1, 2))
    np.testing.assert_allclose(vertical, 1e5, rtol=2e-4)
    np.testing.assert_allclose(found["normal_force_N"][0, 0], found["normal_force_N"][0, 1], rtol=1e-6)
    radii = found["rolling_radius_mm"][:, :, 0]
    assert radii[0, 0] == pytest.approx(radii[0, 1], abs=1e-6)
    assert radii[1, 1] > radii[1, 0]
    assert found["position_mm"][0, 1, 0, 0] == pytest.approx(-found["position_mm"][0, 0, 0, 0])
    checks = table.metadata["checks"]
    assert checks["exact_solutions"] == 2 * 13  # the forces of one position serve the other one
    assert checks["not_converged"] == 0
    assert checks["between_creepages"]["n"] == 8
    assert checks["between_positions"]["n"] == 8
    assert 0.0 < checks["between_positions"]["max"] < 0.5
    assert checks["between_positions"]["max"] < checks["claimed_error"]
    assert checks["jumps"] == []
    assert any(each.startswith("creep forces at positions: 1 of 1; 0 s left") for each in sentences)


def test_the_error_is_measured_at_frictions_of_their_own(small):
    """Each position at which the error is measured has another coefficient; the table is within its claim there."""
    table, frictions = small[0], []
    assert table.metadata["checks"]["frictions"] == list(CHECKED_FRICTIONS)
    for lateral in (0.123, 0.341):
        checked = compute_position(PositionTask(COARSE, (lateral, 0.0, 100.0), "check", 1.0, 2))
        friction = float(checked["friction"])
        frictions.append(friction)
        force = np.hypot(checked["exact"][..., 0], checked["exact"][..., 1]).max(axis=1)
        # one patch a side: sliding takes most of the friction, and no more
        assert (force <= friction * checked["normal_force_N"] * (1.0 + 1e-6)).all()
        assert (force > 0.3 * friction * checked["normal_force_N"]).any()
        for side in range(2):
            of_table = table.forces(lateral, 0.0, 100.0, checked["creepages"][side][0], friction=friction)
            error = of_table[0, side].sum(axis=0)[:2] - checked["exact"][side][0][:2]
            claimed = table.metadata["checks"]["claimed_error"] * friction * checked["normal_force_N"][side]
            assert np.hypot(*error) < claimed
    assert abs(frictions[0] - frictions[1]) > 0.01
    assert all(CHECKED_FRICTIONS[0] <= friction <= CHECKED_FRICTIONS[1] for friction in frictions)


def test_forces_are_exact_at_a_position_and_creepages_of_the_table(small):
    """At its nodes the table has the forces of its position; the same with other friction."""
    table = small[0]
    exact = small[2][0.5, 0.0, 100.0]
    forces = table.values["forces"][1, 0, 0]
    np.testing.assert_allclose(forces[:, 0], exact["forces"], atol=1e-3)
    contacts = table.contacts(0.5, 0.0, 100.0)
    limit = contacts["normal_force_N"][0, :, 0]
    # slip 0.5 and no spin, creep angle 0: u1 = 2 mu N
    creepages = np.zeros((1, 2, 1, 3))
    creepages[0, :, 0, 0] = 2.0 * limit / contacts["stiffness_N"][0, :, 0, 0]
    free = np.zeros((1, 2, 1, 3))
    free[..., :2] = contacts["free_creepage"]
    assert (np.abs(free[..., 0]) > 1e-5).all()  # the wheel is stretched, also on a rail that cannot bend
    for friction in (FRICTION, 0.1):
        found = table.forces(0.5, 0.0, 100.0, free + friction * creepages, friction=friction)
        expected = exact["forces"][:, 1, 2, 0] * 0.5
        np.testing.assert_allclose(
            found[0, :, 0, :2], expected[:, :2] * (friction * limit)[:, None], rtol=1e-3, atol=5.0
        )


def test_a_jump_is_located_and_not_interpolated(few_points, monkeypatch):
    """Patches that do not overlap are apart: lateral positions are added up to both sides of the jump."""
    build = _Build(TableRequest(COARSE, [0.0, 1.0], [0.0], [100.0]), 1, lambda _: None)

    def contact(task):
        lateral = task.position[0]
        side = [0, 1, 1] if lateral > 0.3 else [0, 1]
        point = np.zeros((len(side), 2)) + ([9.0, 0.0] if lateral > 0.8 else [0.0, 0.0])
        found = {"side": np.array(side), "rail_point_mm": point, "radius_mm": np.full(len(side), 4.0)}
        return found | {"axle": np.zeros(2)}

    monkeypatch.setattr(table_build, "compute_position", contact)
    build = build._with_jumps()
    for jump in (0.3, 0.8):
        low, high = max(x for x in build.lateral if x <= jump), min(x for x in build.lateral if x > jump)
        assert high - low <= table_build.JUMP_MM
    joined = build._cells((len(build.lateral), 1, 1))[:, 0, 0]
    starts = np.array(build.lateral)[:-1]
    ends = np.array(build.lateral)[1:]
    crosses_8 = (starts <= 0.8) & (ends > 0.8)
    np.testing.assert_array_equal(joined[:, 0], ~crosses_8)
    np.testing.assert_array_equal(joined[:, 1], ~(crosses_8 | ((starts <= 0.3) & (ends > 0.3))))
    assert not _go_over(contact(PositionTask(COARSE, (0.0, 0, 0))), contact(PositionTask(COARSE, (0.5, 0, 0))), 1)


def test_positions_are_added_where_the_error_is_too_large(small, few_points, monkeypatch):
    """An error above the tolerance in an interval makes its middle a position of the table; a fresh sample counts."""
    request = TableRequest(COARSE, [0.0, 0.5], [0.0], [100.0], tolerance=0.99)
    known = small[2]
    monkeypatch.setattr(
        table_build, "compute_position", lambda task: known[0.0 if task.position[0] < 0.4 else 0.5, 0.0, 100.0]
    )
    errors, places = iter([2.0, 0.3, 0.1, 0.1]), []

    def differences(_, position, __):
        places.append(position)
        return [{"side": "left", "jump": False, "force": next(errors), "normal_force": 0.0}]

    monkeypatch.setattr(table_build, "_differences", differences)
    monkeypatch.setattr(table_build, "MAX_PASSES", 2)
    table = make_table(request, workers=1)
    np.testing.assert_allclose(table.axes[0], (0.0, 0.25, 0.5))
    assert table.metadata["checks"]["within_tolerance"]
    assert table.metadata["checks"]["between_positions"]["max"] == 0.1
    assert len(set(places)) == 4


def test_a_position_is_the_mirror_image_of_the_opposite_one(few_points):
    """Opposite lateral position and yaw exchange left and right: numbers of patches and forces are the same."""
    build = _Build(TableRequest(COARSE, [-0.5, 0.5], [-2.0, 2.0], [100.0]), 1, lambda _: None)
    build._run("contact", build._positions(), build.contacts)
    build._run("table", [(-0.5, -2.0, 100.0)], build.sampled)
    assert list(build.sampled) == [(0.5, 2.0, 100.0), (-0.5, -2.0, 100.0)]
    found, computed = (
        build.sampled[-0.5, -2.0, 100.0],
        compute_position(PositionTask(COARSE, (-0.5, -2.0, 100.0), "table")),
    )
    for name in {*computed} - {"force_errors", "moment_errors"}:
        # numbers that are stored in single precision may be rounded to its neighbouring values
        single = np.asarray(computed[name]).dtype == np.float32
        limit = 2.0 * np.finfo(np.float32).eps if single else 1e-9
        np.testing.assert_allclose(found[name], computed[name], rtol=limit, atol=1e-9, err_msg=name)
    curve = COARSE.replaced(load={"lateral_force_kN": 10.0})
    curved = _Build(TableRequest(curve, [0.0], [0.0], [100.0]), 1, lambda _: None)
    assert curved._image((-0.5, -2.0, 100.0)) == (-0.5, -2.0, 100.0)


@pytest.mark.parametrize("law", ["exponential", "positions"])
def test_the_claimed_error_holds_at_500_further_points(law):
    """In at most a tenth of 300 samples one of 500 further errors is above the claim; it is less than twice them."""
    random, exceeded, over = np.random.default_rng(5), 0, []
    for _ in range(300):
        places = np.repeat(np.arange(48), 12)

        def errors(places):
            n = len(places)
            level = random.uniform(0.5, 1.5, places.max() + 1)[places] if law == "positions" else 1.0
            draw = random.exponential if law == "exponential" else lambda size: np.abs(random.normal(size=size))
            return level * draw(size=n)

        claim, most = claimed_error(errors(places), places), errors(np.arange(500)).max()
        exceeded += most > claim
        over.append(claim / most)
    assert exceeded <= 30
    assert np.median(over) < 2.0


def test_files_have_the_numbers_of_the_table(small, folder):
    """npz, both CSV files and the README; a table that was read gives the same forces."""
    table, read = small[0], CreepTable.load(folder / "creep-table.npz")
    assert read.metadata == table.metadata
    creepages = [1e-3, -5e-4, 3e-6]
    np.testing.assert_array_equal(read.forces(0.2, 0.0, 100.0, creepages), table.forces(0.2, 0.0, 100.0, creepages))
    with (folder / "patches.csv").open() as file:
        patches = list(csv.DictReader(file))
    assert [each["side"] for each in patches] == ["left", "right", "left", "right"]
    normal = table.values["normal_force_N"][1, 0, 0, 1, 0]
    assert float(patches[3]["normal_force_N"]) == pytest.approx(normal)
    assert float(patches[3]["position_x_mm"]) == pytest.approx(table.values["position_mm"][1, 0, 0, 1, 0, 0])
    with (folder / "forces.csv").open() as file:
        rows = [each for each in csv.DictReader(file) if each["patch"] == "4" and each["slip"] == "0.5"]
    values = np.array([[float(each[name]) for name in ("longitudinal", "lateral", "moment")] for each in rows])
    np.testing.assert_allclose(values, table.values["forces"][1, 0, 0, 1, 0, 1].reshape(-1, 3), rtol=1e-4, atol=1e-6)
    readme = (folder / "README.md").read_text(encoding="utf-8")
    for name in table.values:
        assert f"`{name}`" in readme or name in ("slip", "spin_angle_rad", "creep_angle_rad"), name


def test_an_interrupted_table_goes_on_from_the_cache(few_points, tmp_path, monkeypatch):
    """What was computed before Ctrl-C is in the cache: the same call computes the rest only."""
    monkeypatch.setenv("FLANGEWAY_CACHE", str(tmp_path))
    computed = []
    monkeypatch.setattr(
        table_positions, "_computed", lambda task: computed.append((task.kind, task.position)) or {"side": np.zeros(1)}
    )
    request = TableRequest(COARSE, [0.0, 0.5, 1.0], [0.0], [100.0])

    def stop(sentence):
        if len(computed) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(table_build, "REPORT_S", 0.0)
    build = _Build(request, 1, stop)
    with pytest.raises(KeyboardInterrupt):
        build._run("contact", build._positions(), build.contacts)
    assert len(computed) == 2
    again = _Build(request, 1, lambda _: None)
    again._run("contact", again._positions(), again.contacts)
    assert [position[0] for _, position in computed] == [0.0, 0.5, 1.0]


@pytest.mark.ci
def test_processes_give_what_this_process_gives(monkeypatch, tmp_path):
    """Two workers return the positions of one."""
    monkeypatch.setenv("FLANGEWAY_CACHE", str(tmp_path))
    positions = [(0.0, 0.0, 100.0), (0.5, 0.0, 100.0)]
    request = TableRequest(COARSE, [0.0, 0.5], [0.0], [100.0])
    mine = {each: compute_position(PositionTask(COARSE, each)) for each in positions}
    build = _Build(request, 2, lambda _: None)
    build._run("contact", positions, build.contacts)
    for each in positions:
        np.testing.assert_array_equal(build.contacts[each]["normal_force_N"], mine[each]["normal_force_N"])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"lateral_mm": []}, "lateral_mm"),
        ({"yaw_mrad": [1.0, 0.0]}, "yaw_mrad"),
        ({"load_kN": [np.nan]}, "load_kN"),
        ({"tolerance": 0.0}, "tolerance = 0"),
        ({"lateral_mm": list(range(3000))}, "3000 positions"),
        ({"case": Wheelset(contact="plane")}, r"contact\.kind = plane"),
        ({"case": COARSE.replaced(position={"lateral_mm": 1.0})}, r"position\.lateral_mm"),
        ({"case": COARSE.replaced(rolling={"speed_km_h": 80.0})}, r"rolling\.speed_km_h"),
    ],
)
def test_wrong_requests_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        TableRequest(**{"case": COARSE, "lateral_mm": [0.0], "yaw_mrad": [0.0], "load_kN": [100.0], **values})


COMMAND = (
    *("creep-table", "wheelset", "--set", "size_scale=8", "--set", "order=1", "--set", "support=fixed"),
    *("--lateral=0:0.5:0.5", "--yaw", "0", "--load", "100", "--tolerance", "1", "--workers", "1"),
)


@pytest.fixture
def known(small, monkeypatch):
    """Positions that are computed already."""
    positions = small[2]
    monkeypatch.setattr(
        table_build, "compute_position", lambda task: positions[0.5 * (task.position[0] > 0.3), 0.0, 100.0]
    )
    error = [{"side": "left", "jump": False, "force": 0.01, "normal_force": 0.0}]
    monkeypatch.setattr(table_build, "_differences", lambda *_: error)


def test_the_command_writes_the_table(known, call, tmp_path):
    """How it ended, errors and the report's name are printed, progress is on stderr, the files are there."""
    status, out, err = call(*COMMAND, "--out", "made")
    assert status == 0, err
    lines = out.splitlines()
    assert lines[0] == "creep-table: converged, error of 1.00% within the tolerance of 100.00%"
    assert any(
        line.split() == ["positions:", "lateral", "x", "yaw", "x", "load", "2", "x", "1", "x", "1"] for line in lines
    )
    assert any(line.split() == ["patches", "4"] for line in lines)
    assert max(map(len, lines)) <= 80
    assert lines[-1] == "Report: made/report.html"
    assert "exact at random positions: 2 of 2; 0 s left of this stage" in err
    assert sorted(path.name for path in (tmp_path / "made").iterdir()) == [
        "README.md", "creep-forces.png", "creep-table.npz", "forces.csv", "patches.csv", "report.html", "summary.json",
    ]  # fmt: skip
    assert CreepTable.load(tmp_path / "made" / "creep-table.npz").axes[0].tolist() == [0.0, 0.5]


def test_a_table_beyond_its_tolerance_ends_with_status_1(known, call, tmp_path, monkeypatch):
    """As JSON and quietly too."""
    error = [{"side": "left", "jump": False, "force": 1.5, "normal_force": 0.0}]
    monkeypatch.setattr(table_build, "_differences", lambda *_: error)
    monkeypatch.setattr(table_build, "MAX_PASSES", 1)
    status, out, err = call(*COMMAND, "--json", "--no-pictures", "--out", "made")
    assert status == 1
    assert err == "" or "positions" in err
    found = json.loads(out)
    assert found == json.loads((tmp_path / "made" / "summary.json").read_text(encoding="utf-8"))
    assert not found["status"]["converged"]
    assert found["checks"]["between_positions"]["max"] == 1.5
    assert not (tmp_path / "made" / "creep-forces.png").exists()
    status, out, err = call(*COMMAND, "-q", "--no-pictures")
    assert out.splitlines()[0] == "creep-table: NOT converged, error of 150.00% above the tolerance of 100.00%"
    assert len(out.splitlines()) == 2
    assert (status, err) == (1, "")


def test_axes_are_ranges_or_lists():
    assert values_of("-1:1:0.5", "--lateral") == [-1.0, -0.5, 0.0, 0.5, 1.0]
    assert values_of("150,200", "--load") == [150.0, 200.0]
    assert values_of("0", "--yaw") == [0.0]
    for wrong in ("", "a", "1:2", "0:1:0.3", "0:1:0", "1:0:1", "0:1:1e-9", "1,,2", "0:1:nan"):
        with pytest.raises(InputError, match="--lateral"):
            values_of(wrong, "--lateral")
