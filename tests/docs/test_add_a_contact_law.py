"""The how-to 'add an enforcement or a pairing in one file', followed to the letter: its code is saved and run."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-a-contact-law.md"
MODULES = ("blocks", "rough", "gauss_points")


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """The page's scripts, and what each prints; its three files are saved where they can be imported."""
    text = PAGE.read_text(encoding="utf-8")
    for name in MODULES:
        code = re.search(rf"Save this as `{name}.py`:\n\n```python\n(.*?)```", text, flags=re.DOTALL)
        assert code is not None, name
        (tmp_path / f"{name}.py").write_text(code.group(1), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield re.findall(r"```python\n(from blocks.*?)```\n\n```text\n(.*?)```", text, flags=re.DOTALL)
    for name in MODULES:
        sys.modules.pop(name, None)


@pytest.mark.ci
def test_the_scripts_print_what_the_page_shows(scripts, capsys):
    """Both scripts run with the saved files and print the numbers of the page."""
    assert len(scripts) == 2
    for code, shown in scripts:
        exec(code, {})
        assert capsys.readouterr().out == shown


def test_the_rough_pressure_is_that_of_the_closed_form(scripts):
    """The pressure of two columns with p = c g^2 between them is the root of the equation on the page."""
    assert scripts
    from blocks import APPROACH, HEIGHT, YOUNG, pressures  # noqa: PLC0415 (saved from the page)
    from rough import RoughSurfaces  # noqa: PLC0415

    from flangeway import SegmentToSegment  # noqa: PLC0415

    coefficient = 3e5
    gap = brentq(lambda g: YOUNG * (APPROACH - g) / (2.0 * HEIGHT) - coefficient * g**2, 0.0, APPROACH)
    found = pressures(SegmentToSegment(), RoughSurfaces(coefficient, 2.0, 1e-3))
    np.testing.assert_allclose(found, coefficient * gap**2, atol=0.01)
