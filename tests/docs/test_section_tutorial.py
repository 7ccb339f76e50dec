"""The tutorial on sections, followed to the letter: its files are saved and read, its outputs compared."""

import re
from pathlib import Path

import pytest

from flangeway.cases.section.section_run import TorsionCase, run_section
from flangeway.formats import read_section
from tests.docs.conftest import refuse_other_lines

TEXT = (Path(__file__).parents[2] / "docs" / "tutorials" / "section.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"`(\w+\.toml)`:\n\n```toml\n(.*?)```", TEXT, flags=re.DOTALL))
OUTPUTS = re.findall(r"```text\n(.*?)```", TEXT, flags=re.DOTALL)


@pytest.fixture
def saved(tmp_path):
    """Folder with all files of the page."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_the_girder_prints_what_the_page_says(call, saved):
    """Each line of the page is printed, with the same constants to 1e-3; the mesh may differ a little."""
    status, out, _ = call("section", "girder.toml", "--no-pictures")
    assert status == 0
    lines = OUTPUTS[0].splitlines()
    refuse_other_lines("\n".join(line for line in lines if not re.search("gap|Time|Report", line)), out, 1e-3)


@pytest.mark.ci
def test_the_slit_girder_is_as_the_page_says(saved):
    """Cut open, the girder has about a two-hundredth of its torsion constant, and its shear centre above the top."""
    closed, cut = (
        run_section(read_section(saved / name), TorsionCase(size=3.0)).constants
        for name in ("girder.toml", "slit.toml")
    )
    assert 150.0 < closed.torsion_constant / cut.torsion_constant < 250.0
    assert cut.shear_centre[1] > 180.0


def test_two_materials_and_the_path_are_read(call, saved):
    """The composite section is weighted and says so; the half disc has its area."""
    status, out, _ = call("section", "concrete.toml", "--size", "10", "--no-pictures")
    assert status == 0
    assert "several Poisson's ratios" in out
    assert "References: E =" in out
    assert read_section(saved / "half.toml").section.area == pytest.approx(3926.99, rel=1e-6)
