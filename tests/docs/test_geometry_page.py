"""The page on the geometry of wheel and rail: its programs run, its names and numbers are true."""

from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_page_runs_from_top_to_bottom(follow, tmp_path):
    """Both commands end well and write what the page says; all code runs, and its assertions hold."""
    assert follow("theory/wheel-rail-geometry.md") == {"sh": 1, "python": 3}
    for name in ("wheelset-curve", "s1002-60e1"):
        assert {"contact_locus.png", "conicity.csv", "table.csv"} <= {
            path.name for path in (tmp_path / "out" / f"geometry-{name}").iterdir()
        }
