"""The tutorials, followed to the letter."""

import re
import shutil
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def test_the_first_wheelset_is_as_the_page_says(follow, tmp_path):
    """Each command of the page works and writes what the page lists; its lines are printed, to 2 %."""
    page = "tutorials/first-wheelset.md"
    assert follow(page, tolerance=0.02, skip=["pip install"]) == {"sh": 4, "text": 2, "python": 1}
    folder = tmp_path / "out" / "wheelset"
    listed = re.findall(r"^\| (`.*?`) \|", (DOCS / page).read_text(encoding="utf-8"), flags=re.MULTILINE)
    names = re.findall(r"`([\w-]+\.\w+)`", " ".join(listed))
    assert len(names) > 8
    for name in names:
        assert (folder / name).stat().st_size > 0, name


def test_the_installation_of_the_page_is_that_of_the_readme():
    """The README's command is the page's command to install and to run; what it shows is what the page shows."""
    page, readme = (
        (DOCS / name).read_text(encoding="utf-8") for name in ("tutorials/first-wheelset.md", "../README.md")
    )
    (command,) = re.findall(r"^(python3 -m venv .*)$", page, flags=re.MULTILINE)
    assert f"{command} && .venv/bin/flangeway run wheelset\n" in readme
    (shown,) = re.findall(r"^```text\n(wheelset: .*?)^```$", readme, flags=re.MULTILINE | re.DOTALL)
    assert shown in page


@pytest.mark.ci
def test_the_commands_of_the_readme_run_as_printed(follow, tmp_path):
    """Each command ends well, in its order, in a fresh folder; studies and lives of profiles have their own tests."""
    shutil.copytree(DOCS.parent / "examples", tmp_path / "examples")
    skip = ["pip install", "reproduce ", "flangeway damage", "Wheel S1002 on rail", "import", "energy", "cells  "]
    assert follow("../README.md", skip=skip) == {"sh": 2}


def test_the_campaign_of_the_examples_is_that_of_its_page():
    """The file that the README runs is the one that the page on campaigns explains."""
    page = (DOCS / "how-to" / "run-a-campaign.md").read_text(encoding="utf-8")
    assert f"```toml\n{(DOCS.parent / 'examples' / 'shift.toml').read_text(encoding='utf-8')}```" in page


def test_the_curve_is_as_the_page_says(follow):
    """Every command and script ends well, in its order, and prints the lines that the page shows, to 2 %."""
    assert follow("tutorials/wheelset-in-a-curve.md") == {"python": 2, "sh": 9, "text": 10}


def test_creep_forces_are_as_the_page_says(follow):
    """Every command and script ends well, in its order, and prints the lines that the page shows, to 2 %."""
    assert follow("tutorials/creep-forces-in-a-curve.md", tolerance=0.02) == {"python": 1, "sh": 4, "text": 5}


def test_the_life_of_a_profile_is_as_the_page_says(follow, tmp_path):
    """The file of the page is that of the examples; the command and the script print what the page shows, to 2 %."""
    page, file = "tutorials/profile-life.md", DOCS.parent / "examples" / "wheel-life.toml"
    text = (DOCS / page).read_text(encoding="utf-8")
    assert f"```toml\n{file.read_text(encoding='utf-8')}```" in text
    strategies = text.split("ends with\n\n```toml\n")[1].split("```")[0]
    assert file.with_name("wheel-strategies.toml").read_text(encoding="utf-8").endswith(strategies)
    shutil.copytree(file.parent, tmp_path / "examples")
    assert follow(page, tolerance=0.02) == {"python": 1, "sh": 2, "text": 3, "toml": 3}


def test_the_contact_is_as_the_page_says(follow):
    """The scripts print what the page shows, to 1 % (meshes differ a little between machines)."""
    assert follow("tutorials/contact.md", tolerance=0.01) == {"python": 5, "text": 3}


def test_the_plane_problem_is_as_the_page_says(follow, tmp_path):
    """The scripts print what the page shows, to 5 %, and write the pictures and files that they name."""
    page = "tutorials/elasticity.md"
    assert follow(page, tolerance=0.05) == {"python": 7, "text": 6}
    names = set(re.findall(r'"([\w-]+\.(?:png|vtu|pvd))"', (DOCS / page).read_text(encoding="utf-8")))
    assert len(names) == 6
    for name in names:
        assert (tmp_path / name).stat().st_size > 0, name


def test_your_own_problem_is_as_the_page_says(follow):
    """The scripts print what the page shows, to 5 % (meshes differ a little between machines)."""
    assert follow("tutorials/your-own-problem.md", tolerance=0.05) == {"python": 6, "text": 6}


def test_the_manufactured_solution_of_the_readme_has_twelve_lines_or_less():
    """The README's problem of one's own, from its first import to the table of rates, is at most 12 lines."""
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    scripts = re.findall(r"^```python\n(.*?)^```$", readme, flags=re.MULTILINE | re.DOTALL)
    (script,) = [script for script in scripts if "convergence(problem" in script]
    assert len([line for line in script.splitlines() if line.strip()]) <= 12
