"""The pages on elasticity, followed to the letter: followed to the letter."""

import re
from pathlib import Path

import pytest

from flangeway.cases.bodies.cook import NEARLY_INCOMPRESSIBLE_WORK, CookCode, solve_cook

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {
    "how-to/read-a-mesh.md": {"python": 4, "text": 3},
    "how-to/refine-adaptively.md": {"python": 2, "text": 2},
    "how-to/nearly-incompressible.md": {"python": 2, "text": 2},
}


@pytest.mark.parametrize("page", PAGES)
def test_the_page_prints_what_it_says(page, follow):
    """The scripts print what the page shows, to 5 % (meshes differ a little between machines)."""
    assert follow(page, tolerance=0.05) == PAGES[page]


def test_the_readme_prints_what_it_says(follow):
    """The README's scripts print the energy, the errors and the rates that are shown, to 5 %."""
    assert follow("../README.md", tolerance=0.05, skip=[".venv/bin", "wheelset: "]) == {"python": 2, "text": 2}


def test_the_table_of_nearly_incompressible_numbers_is_computed() -> None:
    """The rows of the page's table for the two coarser meshes are those of the program, to their last digit."""
    text = (DOCS / "how-to" / "nearly-incompressible.md").read_text(encoding="utf-8")
    names = {("F", 1): "triangles, order 1", ("V", 1): "dual polygons, order 1"}
    names |= {("F", 2): "triangles, order 2", ("V", 2): "dual polygons, order 2"}
    for (method, order), name in names.items():
        (row,) = re.findall(rf"^\| {name} \|(.*)\|$", text, flags=re.MULTILINE)
        for level, given in enumerate(re.findall(r"-[\d.]+", row)[:2], start=1):
            work = solve_cook(CookCode(method, level, order).space(), 0.4999).load_work
            last_digit = 10.0 ** -len(given.partition(".")[2])
            assert 100.0 * (work / NEARLY_INCOMPRESSIBLE_WORK - 1.0) == pytest.approx(
                float(given), abs=1.5 * last_digit
            )
