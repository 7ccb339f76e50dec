"""The how-to 'add a material in one file', followed to the letter: its code is taken from the page and used."""

import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement
from flangeway.solve import solve_nonlinear
from flangeway.space import Space

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-a-material.md"


def code_blocks():
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.fixture
def material(tmp_path, monkeypatch):
    """The material of the module `damage`, saved from the page into a file of its own."""
    (tmp_path / "damage.py").write_text(code_blocks()[0], encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield importlib.import_module("damage").Damage(Elastic(200.0, 0.3))
    del sys.modules["damage"]


def test_the_use_shown_on_the_page_runs(material):
    """The second block of the page runs as it stands, its own assertions included."""
    assert material.n_history == 1
    exec(compile(code_blocks()[1], str(PAGE), "exec"), {})


@pytest.mark.parametrize(("make", "element"), [(lambda m: m, Lagrange(1)), (dual, Virtual(1)), (dual, Virtual(3))])
def test_a_stretched_square_has_the_stress_of_the_formula(material, make, element):
    """Stretch along x without strain across: 1 - d times the elastic stress; unloading keeps d."""
    space = Space(make(rectangle_grid(1.0, 1.0, 3, 3)), element)
    supports = [PrescribedDisplacement(side, x=lambda p: 0.02 * p[:, 0], y=0.0) for side in space.mesh.edge_sets]
    problem = Elasticity(space, material.elastic, supports=supports)
    modulus = material.elastic.matrix[0, 0]
    kappa = np.sqrt(modulus * 0.02**2 / 200.0)
    left = 1.0 - 0.5 * (1.0 - np.exp(-kappa / 0.01))
    out, half = solve_nonlinear(problem, material, [1.0, 0.5])
    np.testing.assert_allclose(out.stress[:, 0, 0], left * modulus * 0.02, rtol=1e-8)
    np.testing.assert_allclose(half.stress[:, 0, 0], left * modulus * 0.01, rtol=1e-8)
