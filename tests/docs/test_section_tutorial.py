"""The tutorial on sections, followed to the letter: its files are saved and read, its outputs compared."""

import pytest

from flangeway.cases.section.section_run import TorsionCase, run_section
from flangeway.formats import read_section
from tests.docs.conftest import blocks_of

PAGE = "tutorials/section.md"


@pytest.fixture
def saved(tmp_path):
    """Folder with all files of the page."""
    for block in blocks_of(PAGE):
        if block.file:
            (tmp_path / block.file).write_text(block.text, encoding="utf-8")
    return tmp_path


def test_the_page_runs_and_its_wrong_girder_is_refused(follow, call):
    """The girder has the page's constants to 1e-3; a hole across the boundary has the page's message."""
    assert follow(PAGE, 1e-3, ["flangeway: wrong.toml"]) == {"toml": 5, "sh": 1, "text": 1}
    (shown,) = (block.text for block in blocks_of(PAGE) if "flangeway: wrong.toml" in block.text)
    assert call("section", "wrong.toml")[::2] == (2, shown)


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
