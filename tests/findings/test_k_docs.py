"""K: links into the reference lead to names that it shows."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"\(([^)\s]*reference/\w+\.md)#(flangeway[\w.]+)\)")


def hidden(name: str) -> bool:
    """Whether a filter of the reference hides a name; `!` begins a pattern of what is left out."""
    (line,) = re.findall(r"filters: \[(.*?)\]  *#", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    patterns = re.findall(r'"!(.*?)"', line)
    assert patterns
    return any(re.search(pattern, name) for pattern in patterns)


@pytest.mark.parametrize("page", sorted((ROOT / "docs").rglob("*.md")), ids=lambda page: page.stem)
def test_k_no_link_leads_to_a_hidden_name(page: Path) -> None:
    """No part of a linked name is left out of the reference."""
    names = {name for _, path in LINK.findall(page.read_text(encoding="utf-8")) for name in path.split(".")}
    assert not {name for name in names if hidden(name)}


def test_k_filters_hide_constants() -> None:
    """A private name and a constant are hidden, a class is not."""
    assert [hidden(name) for name in ("_private", "EPS", "STRAIN_PLACES", "Space")] == [True, True, False, False]
