"""The page on the geometry of wheel and rail: its programs run, its names and numbers are true."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "theory" / "wheel-rail-geometry.md").read_text(encoding="utf-8")


def test_the_page_runs_from_top_to_bottom(follow, tmp_path):
    """Both commands end well and write what the page says; all code runs, and its assertions hold."""
    assert follow("theory/wheel-rail-geometry.md") == {"sh": 1, "python": 3}
    for name in ("wheelset-curve", "s1002-60e1"):
        assert {"contact_locus.png", "conicity.csv", "table.csv"} <= {
            path.name for path in (tmp_path / "out" / f"geometry-{name}").iterdir()
        }


def test_the_names_of_the_page_are_in_the_program():
    """Each name in backticks that looks like one of the program is defined in it."""
    source = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "src" / "flangeway").rglob("*.py"))
    quoted = re.findall(r"`([A-Za-z_][\w.]*)(?:\([^`]*\))?`", re.sub(r"```.*?```", "", TEXT, flags=re.DOTALL))
    names = {part for word in quoted for part in word.split(".") if "_" in part or re.match(r"[A-Z][a-z]+[A-Z]", part)}
    assert len(names) > 10
    for name in names - {"h_right", "h_left"}:
        assert re.search(rf"(class|def) {name}\b|^\s*{name}\b\s*[:=]", source, re.MULTILINE), name
