"""`flangeway creep-table`: files and exit status, interruption, and axes on the command line."""

import json

import pytest

from flangeway.cli.creep_table_command import values_of
from flangeway.errors import InputError
from flangeway.tables import CreepTable, table_build

COMMAND = (
    *("creep-table", "wheelset", "--set", "size_scale=8", "--set", "order=1", "--set", "rail_support=fixed"),
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


def test_an_interruption_leaves_nothing(call, tmp_path, monkeypatch):
    """Ctrl-C ends with status 130, without a file."""

    def interrupt(task):
        raise KeyboardInterrupt

    monkeypatch.setattr(table_build, "compute_position", interrupt)
    status, _, err = call(*COMMAND, "--out", "made")
    assert status == 130
    assert "interrupted; positions that are done are kept in the cache" in err
    assert not (tmp_path / "made").exists()


def test_axes_are_ranges_or_lists():
    assert values_of("-1:1:0.5", "--lateral") == [-1.0, -0.5, 0.0, 0.5, 1.0]
    assert values_of("150,200", "--load") == [150.0, 200.0]
    assert values_of("0", "--yaw") == [0.0]
    for wrong in ("", "a", "1:2", "0:1:0.3", "0:1:0", "1:0:1", "0:1:1e-9", "1,,2", "0:1:nan"):
        with pytest.raises(InputError, match="--lateral"):
            values_of(wrong, "--lateral")
