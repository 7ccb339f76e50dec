"""Pages that are followed to the letter: files are saved and read, outputs compared."""

import re
import shutil
from pathlib import Path

import pytest

from flangeway.cases.section_run import TorsionCase, run_section
from flangeway.formats import read_section
from tests.docs.conftest import blocks_of

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLES = DOCS.parent / "examples"
OF_OTHER_TESTS = [
    *("pip install", "reproduce ", "flangeway damage", "Wheel S1002 on rail", "import", "energy", "cells  ", "left: "),
]  # fmt: skip
"""Words of lines of the README that other tests run: installation, studies, lives of profiles, scripts."""


FOLLOWED = (
    ("tutorials/first-wheelset.md", {"sh": 4, "text": 3, "python": 2}, 0.02, ["pip install"]),
    ("tutorials/wheelset-in-a-curve.md", {"python": 2, "sh": 9, "text": 10}, 0.02, []),
    ("tutorials/creep-forces-in-a-curve.md", {"python": 1, "sh": 4, "text": 5}, 0.02, []),
    ("tutorials/profile-life.md", {"python": 1, "sh": 2, "text": 3, "toml": 3}, 0.02, []),
    ("tutorials/contact.md", {"python": 5, "text": 3}, 0.01, []),
    ("tutorials/elasticity.md", {"python": 7, "text": 6}, 0.05, []),
    ("tutorials/your-own-problem.md", {"python": 6, "text": 6}, 0.05, []),
    ("how-to/tree-of-inputs.md", {"toml": 1, "sh": 4, "text": 4, "python": 2}, 0.02, []),
    ("how-to/read-a-mesh.md", {"python": 4, "text": 3}, 0.05, []),
    ("how-to/refine-adaptively.md", {"python": 2, "text": 2}, 0.05, []),
    ("how-to/polyhedra.md", {"python": 1, "text": 1}, 1e-3, []),
    ("how-to/contact-in-space.md", {"python": 1, "text": 1, "py": 1}, 1e-3, []),
    ("how-to/nearly-incompressible.md", {"python": 3, "text": 3}, 0.05, []),
    ("how-to/bring-your-profile.md", {"python": 2, "sh": 7, "text": 2, "toml": 1}, 0.02, []),
    ("how-to/write-a-case-file.md", {"toml": 5, "inp": 1, "sh": 7, "text": 4, "python": 2}, 0.01, ["flangeway: cyl"]),
    ("theory/wheel-rail-geometry.md", {"sh": 1, "python": 3}, 0.02, []),
    ("theory/spatial-wheelset.md", {"python": 1, "text": 1}, 0.01, []),
    ("theory/rolling.md", {"python": 1, "text": 1}, 0.01, []),
    ("theory/three-dimensions.md", {"python": 1, "text": 1}, 1e-6, []),
    ("../README.md", {"python": 2, "text": 2}, 0.05, [".venv/bin", "wheelset: "]),
    ("../README.md", {"sh": 2}, 0.02, OF_OTHER_TESTS),
)
"""Pages with the number of their blocks, the part to which numbers agree, and words of what is left out."""


@pytest.mark.parametrize(("page", "blocks", "tolerance", "skip"), FOLLOWED)
def test_a_page_runs_from_top_to_bottom(page, blocks, tolerance, skip, follow, tmp_path):
    """Files are saved, commands and scripts end well in their order, and what is shown is printed."""
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    assert follow(page, tolerance, skip) == blocks
    if page == "tutorials/first-wheelset.md":
        listed = re.findall(r"^\| (`.*?`) \|", (DOCS / page).read_text(encoding="utf-8"), flags=re.MULTILINE)
        names = re.findall(r"`([\w-]+\.\w+)`", " ".join(listed))
        assert len(names) > 8
        assert all((tmp_path / "out" / "wheelset" / name).stat().st_size > 0 for name in names)


def test_files_of_pages_are_those_of_the_examples():
    """The campaign, the life of a wheel and its strategies stand on their pages as in the files."""
    campaign, life = (
        (DOCS / page).read_text(encoding="utf-8") for page in ("how-to/run-a-campaign.md", "tutorials/profile-life.md")
    )
    files = {
        name: (EXAMPLES / f"{name}.toml").read_text("utf-8") for name in ("shift", "wheel-life", "wheel-strategies")
    }
    assert f"```toml\n{files['shift']}```" in campaign
    assert f"```toml\n{files['wheel-life']}```" in life
    assert files["wheel-strategies"].endswith(life.split("ends with\n\n```toml\n")[1].split("```")[0])


def test_the_installation_of_the_page_is_that_of_the_readme():
    """The README's command is the page's command to install and to run; what it shows is what the page shows."""
    page, readme = (
        (DOCS / name).read_text(encoding="utf-8") for name in ("tutorials/first-wheelset.md", "../README.md")
    )
    (command,) = re.findall(r"^(python3 -m venv .*)$", page, flags=re.MULTILINE)
    assert f"{command} && .venv/bin/flangeway run wheelset\n" in readme
    (shown,) = re.findall(r"^```text\n(wheelset: .*?)^```$", readme, flags=re.MULTILINE | re.DOTALL)
    assert shown in page


def test_the_manufactured_solution_of_the_readme_has_twelve_lines_or_less():
    """The README's problem of one's own, from its first import to the table of rates, is at most 12 lines."""
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    scripts = re.findall(r"^```python\n(.*?)^```$", readme, flags=re.MULTILINE | re.DOTALL)
    (script,) = [script for script in scripts if "convergence(problem" in script]
    assert len([line for line in script.splitlines() if line.strip()]) <= 12


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
    assert follow(PAGE, 1e-3, ["flangeway: wrong.toml"]) == {"toml": 5, "sh": 2, "text": 2}
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
