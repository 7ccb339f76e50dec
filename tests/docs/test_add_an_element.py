"""The how-to 'add an element in one file', followed to the letter: its code is taken from the page and used."""

import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from flangeway.exact import Rectangle
from flangeway.mesh import rectangle_grid
from flangeway.problems import Torsion
from flangeway.solve import solve_torsion
from flangeway.space import Space

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-an-element.md"


def code_blocks():
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.fixture
def quadrilateral(tmp_path, monkeypatch):
    """The module `quadrilateral`, saved from the page into a file of its own."""
    (tmp_path / "quadrilateral.py").write_text(code_blocks()[0], encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield importlib.import_module("quadrilateral")
    del sys.modules["quadrilateral"]


def test_the_use_shown_on_the_page_runs(quadrilateral):
    """The blocks after the first run as they stand, their own assertions included."""
    exec(compile("".join(code_blocks()[1:]), str(PAGE), "exec"), {})


def test_error_falls_fourfold_when_the_mesh_is_halved(quadrilateral):
    """The torsion constant of a rectangle converges with h squared, from above by warping, from below by Prandtl's."""
    exact = Rectangle(2.0, 1.0).torsion_constant
    for formulation, sign in (("warping", 1.0), ("prandtl", -1.0)):
        errors = []
        for n in (8, 16):
            mesh = rectangle_grid(2.0, 1.0, 2 * n, n, cells="quadrilaterals")
            space = Space(mesh, quadrilateral.Quadrilateral())
            errors.append(sign * (solve_torsion(Torsion(space, formulation=formulation)).torsion_constant - exact))
        assert errors[0] > errors[1] > 0.0
        assert 1.8 < np.log2(errors[0] / errors[1]) < 2.2
