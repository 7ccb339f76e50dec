"""Theory pages lead to functions by name: the names are there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCE = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "src" / "flangeway").rglob("*.py"))
PLACES = (r"(?:class|def) (\w+)", r"^\s*(\w+)\s*[:=]", r'"(\w+)"[:,]', r"flangeway\.(\w+)")
DEFINED = {name for place in PLACES for name in re.findall(place, SOURCE, re.MULTILINE)}
PAGES = ("contact.md", "elasticity.md", "elements.md", "torsion.md", "wheel-rail-geometry.md")


@pytest.mark.parametrize("page", PAGES)
def test_every_name_on_the_page_is_in_the_program(page):
    """Each identifier in backticks is in the package: a class, a function, a field or a key; each path exists."""
    text = (ROOT / "docs" / "theory" / page).read_text(encoding="utf-8")
    quoted = re.findall(r"`([A-Za-z_][\w./]*)(?:\([^`]*\))?`", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    names = {word for word in quoted if "_" in word or "." in word or re.match(r"[A-Z][a-z]+[A-Z]?", word)}
    assert len(names) > 10
    for name in names:
        if "/" in name:
            assert (ROOT / name).exists() or (ROOT / "src" / "flangeway" / name).exists(), name
        elif name.endswith(".csv"):
            continue
        elif name.endswith(".json"):
            assert f"``{name}``" in SOURCE, name
        else:
            for part in name.removeprefix("fw.").removeprefix("flangeway.").split("."):
                assert part in DEFINED, f"{name} on {page}"
