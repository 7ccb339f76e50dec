"""The how-tos that add a material, an element, a contact law or a result: their code is saved and used as it stands."""

import importlib
import json
import math
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from flangeway import SegmentToSegment
from flangeway.elements import Lagrange, Virtual
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement, Torsion
from flangeway.report import RECORDS
from flangeway.solve import solve_nonlinear, solve_torsion
from flangeway.space import Space
from flangeway_studies.torsion_bars import Rectangle
from tests.docs.conftest import DOCS, blocks_of

MODULE = re.compile(r"Save this as `(\w+)\.py`[^\n]*\n\n```python\n(.*?)^```$", flags=re.MULTILINE | re.DOTALL)
SAMPLES = DOCS.parent / "tests" / "independent" / "calculix"
MAX_LINES = 70  # of a kind of result, imports and the mechanics of the example too


@pytest.fixture
def saved(tmp_path, monkeypatch):
    """Save the modules of a page where they can be imported until the test ends; return its other Python and text."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    modules = {}

    def save(page):
        modules.update(MODULE.findall((DOCS / "how-to" / f"{page}.md").read_text(encoding="utf-8")))
        for name, code in modules.items():
            Path(f"{name}.py").write_text(code, encoding="utf-8")
        blocks = blocks_of(f"how-to/{page}.md")
        return [each for each in blocks if each.kind in ("python", "text") and each.text not in modules.values()]

    yield save
    for name in modules:
        sys.modules.pop(name, None)


@pytest.mark.parametrize(
    ("page", "n_shown"),
    [
        ("add-a-material", 0),
        ("add-an-element", 0),
        pytest.param("add-a-contact-law", 2, marks=pytest.mark.ci),
        ("contact-of-your-stiffness-matrix", 4),
    ],
)
def test_what_uses_the_saved_code_prints_what_the_page_shows(page, n_shown, saved, tmp_path, capsys):
    """Scripts run as they stand, their own assertions included, and print the numbers of the page."""
    if page == "contact-of-your-stiffness-matrix":
        pytest.importorskip("skfem")
        pytest.importorskip("felupe")
        for file in SAMPLES.iterdir():
            shutil.copy(file, tmp_path)
    shown, names = [], {}
    for block in saved(page):
        if block.kind == "python":
            exec(compile(block.text, page, "exec"), names)
        elif not block.text.startswith("*"):  # a part of a deck
            assert capsys.readouterr().out == block.text
            shown.append(block)
    assert len(shown) == n_shown


def test_the_rough_pressure_is_that_of_the_closed_form(saved):
    """The pressure of two columns with p = c g^2 between them is the root of the equation on the page."""
    saved("add-a-contact-law")
    blocks, rough = importlib.import_module("blocks"), importlib.import_module("rough")
    coefficient = 3e5
    gap = brentq(
        lambda g: blocks.YOUNG * (blocks.APPROACH - g) / (2.0 * blocks.HEIGHT) - coefficient * g**2,
        0.0,
        blocks.APPROACH,
    )
    found = blocks.pressures(SegmentToSegment(), rough.RoughSurfaces(coefficient, 2.0, 1e-3))
    np.testing.assert_allclose(found, coefficient * gap**2, atol=0.01)


@pytest.mark.parametrize(("make", "element"), [(lambda m: m, Lagrange(1)), (dual, Virtual(1)), (dual, Virtual(3))])
def test_a_stretched_square_has_the_stress_of_the_formula(saved, make, element):
    """Stretch along x without strain across: 1 - d times the elastic stress; unloading keeps d."""
    saved("add-a-material")
    material = importlib.import_module("damage").Damage(Elastic(200.0, 0.3))
    assert material.n_history == 1
    space = Space(make(rectangle_grid(1.0, 1.0, 3, 3)), element)
    supports = [PrescribedDisplacement(side, x=lambda p: 0.02 * p[:, 0], y=0.0) for side in space.mesh.edge_sets]
    problem = Elasticity(space, material.elastic, supports=supports)
    modulus = material.elastic.matrix[0, 0]
    kappa = np.sqrt(modulus * 0.02**2 / 200.0)
    left = 1.0 - 0.5 * (1.0 - np.exp(-kappa / 0.01))
    out, half = solve_nonlinear(problem, material, [1.0, 0.5])
    np.testing.assert_allclose(out.stress[:, 0, 0], left * modulus * 0.02, rtol=1e-8)
    np.testing.assert_allclose(half.stress[:, 0, 0], left * modulus * 0.01, rtol=1e-8)


def test_the_error_of_the_element_falls_fourfold_when_the_mesh_is_halved(saved):
    """The torsion constant of a rectangle converges with h squared, from above by warping, from below by Prandtl's."""
    saved("add-an-element")
    quadrilateral = importlib.import_module("quadrilateral")
    exact = Rectangle(2.0, 1.0).torsion_constant
    for formulation, sign in (("warping", 1.0), ("prandtl", -1.0)):
        errors = []
        for n in (8, 16):
            mesh = rectangle_grid(2.0, 1.0, 2 * n, n, cells="quadrilaterals")
            space = Space(mesh, quadrilateral.Quadrilateral())
            errors.append(sign * (solve_torsion(Torsion(space, formulation=formulation)).torsion_constant - exact))
        assert errors[0] > errors[1] > 0.0
        assert 1.8 < np.log2(errors[0] / errors[1]) < 2.2


def test_the_kind_of_result_has_numbers_picture_page_and_columns(saved, capsys):
    """Its code writes the report in US units; pressure and half width are those of Hertz (1882) by hand."""
    (use,) = saved("add-a-result")
    code = Path("roller_on_plate.py").read_text(encoding="utf-8")
    assert len([line for line in code.splitlines() if line.strip()]) <= MAX_LINES
    known = set(RECORDS)
    exec(use.text, {})
    for kind in set(RECORDS) - known:
        del RECORDS[kind]
    pressure = math.sqrt(500.0 * 115_385.0 / (math.pi * 25.0))
    half_width = math.sqrt(4.0 * 500.0 * 25.0 / (math.pi * 115_385.0))
    summary = json.loads(Path("roller", "summary.json").read_text(encoding="utf-8"))
    assert summary["max_pressure_MPa"] == pytest.approx(pressure, rel=1e-9)
    assert f"{pressure:.6f}"[:8] in capsys.readouterr().out
    page = Path("roller", "report.html").read_text(encoding="utf-8")
    for value, name in ((pressure / 6.894757293168361, "maximum pressure, ksi"), (half_width / 25.4, "contact, in")):
        assert name in page
        assert f">{value:.2f}" in page
    assert Path("roller", "pressure.png").is_file()
