"""The how-to 'contact of your own stiffness matrix', followed to the letter with CalculiX's files."""

import shutil
import sys
from pathlib import Path

import pytest

from tests.docs.conftest import blocks_of

PAGE = "how-to/contact-of-your-stiffness-matrix.md"
SAMPLES = Path(__file__).parents[1] / "independent" / "calculix"


def test_the_scripts_print_what_the_page_shows(tmp_path, monkeypatch, capsys) -> None:
    """Each program's block is pressed with the force of the page."""
    pytest.importorskip("skfem")
    pytest.importorskip("felupe")
    for file in SAMPLES.iterdir():
        shutil.copy(file, tmp_path)
    first, *blocks = blocks_of(PAGE)
    (tmp_path / "ground.py").write_text(first.text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.delitem(sys.modules, "ground", raising=False)
    scripts = [each.text for each in blocks if each.kind == "python"]
    shown = [each.text for each in blocks if each.kind == "text" and not each.text.startswith("*")]
    assert len(scripts) == len(shown) == 4
    for code, expected in zip(scripts, shown, strict=True):
        exec(code, {})
        assert capsys.readouterr().out == expected
    sys.modules.pop("ground")
