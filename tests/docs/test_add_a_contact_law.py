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


def test_the_tangent_of_the_new_pairing_is_the_derivative_of_its_gaps(scripts):
    """Gradients and curvatures of Gauss-point pairs agree with differences of their gaps to 1e-6."""
    assert scripts
    from blocks import HEIGHT, block, side  # noqa: PLC0415 (saved from the page)
    from gauss_points import GaussPointsToSegment  # noqa: PLC0415

    secondary, primary = side(block("upper", 3, HEIGHT, 0.0)), side(block("lower", 2, -HEIGHT, -HEIGHT))
    draw = np.random.default_rng(0)
    points, other = (
        each.part.body.space.nodes[each.nodes] + 0.3 * draw.standard_normal((len(each.nodes), 2))
        for each in (secondary, primary)
    )
    kept = np.full(len(GaussPointsToSegment().key_nodes(secondary)), -1)

    def pairs(change):
        first, second = points + change[: len(points)], other + change[len(points) :]
        return GaussPointsToSegment().pair(secondary, primary, first, second[primary.edge_places], kept)

    now = pairs(np.zeros((len(points) + len(other), 2)))
    forces = draw.random(len(now.keys))
    members = np.concatenate((now.secondary_members, len(points) + primary.edge_places[now.primary_edges]), axis=1)

    def gradient(found):
        total = np.zeros((len(points) + len(other), 2))
        np.add.at(total, members, forces[:, None, None] * found.gradients[:, 0])
        return total

    way = draw.standard_normal((len(points) + len(other), 2))
    step = 1e-6
    ahead, behind = pairs(step * way), pairs(-step * way)
    rate = forces @ (ahead.gaps - behind.gaps) / (2.0 * step)
    assert (gradient(now) * way).sum() == pytest.approx(rate, rel=1e-6)
    loaded, second = now.curvatures(forces)
    local = way[members[loaded]].reshape(len(loaded), -1)
    bending = np.einsum("mi,mij,mj->", local, second, local)
    assert bending == pytest.approx(((gradient(ahead) - gradient(behind)) * way).sum() / (2.0 * step), rel=1e-5)
