"""The page of the keys of `summary.json`."""

import runpy
from pathlib import Path

import pytest

from flangeway.cases import load_case

OF_EVERY_RUN = {"status", "case", "timings_s", "peak_memory_MB", "versions"}


SCRIPT = runpy.run_path(str(Path(__file__).parents[2] / ".ci" / "summary_page.py"))
"""What writes it."""


def keys_of(content):
    """Keys of numbers in mappings and in lists of mappings; those of tables are named in headings."""
    for key, value in content.items():
        rows = [value] if isinstance(value, dict) else value if isinstance(value, list) else []
        inner = [row for row in rows if isinstance(row, dict)]
        yield from (name for row in inner for name in keys_of(row)) if inner else (() if value == [] else (key,))


def test_the_page_is_what_the_quantities_say():
    """The page is the one that its script writes."""
    assert SCRIPT["PAGE"].read_text(encoding="utf-8") == SCRIPT["page"](), "run python .ci/summary_page.py"


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("hertz", {"size_mm": 1.0}),
        ("rolling-patch", {"cells_along": 8, "cells_across": 8, "curve_points": 3}),
        ("wheelset-tangent", {"size_scale": 8.0}),
        ("crane-wheel", {"order": 1}),
    ],
)
def test_every_key_of_a_run_is_on_the_page(name, inputs):
    """Numbers that a run reports are explained; sentences and names have their place in other tables."""
    run, text = load_case(name, **inputs).run(), SCRIPT["page"]()
    words = {"assumptions", "warnings", "notices", "notes", "name"}
    numbers = {key: value for key, value in run.summary.items() if key not in OF_EVERY_RUN | words}
    assert not [key for key in dict.fromkeys(keys_of(numbers)) if f"`{key}`" not in text]
