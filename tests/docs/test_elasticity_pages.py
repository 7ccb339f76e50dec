"""The page on nearly incompressible bodies: its table is computed."""

import re
from pathlib import Path

import pytest

from flangeway.cases.bodies.cook import NEARLY_INCOMPRESSIBLE_WORK, CookCode, solve_cook

DOCS = Path(__file__).parents[2] / "docs"


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
