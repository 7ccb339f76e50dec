"""The pages on elasticity, followed to the letter: the blocks of each are one script, its outputs compared."""

import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from flangeway.study.cook import NEARLY_INCOMPRESSIBLE_WORK, CookCode, cook_row

DOCS = Path(__file__).parents[1] / "docs"
PAGES = {
    "tutorials/elasticity.md": 9,
    "how-to/read-a-mesh.md": 4,
    "how-to/refine-adaptively.md": 4,
    "how-to/nearly-incompressible.md": 8,
}
"""Pages, and the number of lines that each prints."""

NUMBER = r"-?\d+\.?\d*"
TUTORIAL_FILES = (
    "elasticity-mesh.png",
    "elasticity-stress.png",
    "elasticity-deformed.png",
    "plate-stresses.vtu",
    "plate.pvd",
)


def blocks(page: str, kind: str) -> list[str]:
    """The page's blocks of one kind."""
    return re.findall(rf"```{kind}\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), flags=re.DOTALL)


def run(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a page's code in a folder."""
    monkeypatch.chdir(folder)
    exec(compile("\n".join(blocks(page, "python")), page, "exec"), {})
    plt.close("all")


@pytest.mark.parametrize("page", PAGES)
def test_the_page_prints_what_it_says(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same lines come out, each number within 5 % or one of its last digit (meshes differ between machines)."""
    run(page, tmp_path, monkeypatch)
    printed, said = capsys.readouterr().out.splitlines(), "".join(blocks(page, "text")).splitlines()
    assert len(printed) == len(said) == PAGES[page]
    for line, expected in zip(printed, said, strict=True):
        assert re.sub(NUMBER, "#", line) == re.sub(NUMBER, "#", expected)
        for found, given in zip(re.findall(NUMBER, line), re.findall(NUMBER, expected), strict=True):
            last_digit = 10.0 ** -len(given.partition(".")[2])
            assert float(found) == pytest.approx(float(given), rel=0.05, abs=1.01 * last_digit), line
    if page.startswith("tutorials"):
        assert all((tmp_path / name).stat().st_size > 0 for name in TUTORIAL_FILES)


def test_the_readme_prints_energy_and_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The README's first Python block runs: energy of a sheared square to 5 %, and an error of a few per cent."""
    run("../README.md", tmp_path, monkeypatch)
    energy, error = (float(word) for word in capsys.readouterr().out.split())
    assert energy == pytest.approx(3.92e-4, rel=0.05)
    assert 0.0 < error < 0.05


def test_a_support_left_out_is_named_as_the_tutorial_says() -> None:
    """The sentence that the tutorial quotes is the message of a plate held in x only."""
    space = Space(rectangle_grid(2.0, 1.0, 2, 1), Virtual(1))
    held = [PrescribedDisplacement("left", x=0.0)]
    with pytest.raises(InputError, match="body `plate` can slide in y"):
        solve_elasticity(Elasticity(space, Elastic(1.0, 0.3), supports=held, name="plate"))


def test_the_table_of_nearly_incompressible_numbers_is_computed() -> None:
    """The rows of the page's table for the two coarser meshes are those of the program, to their last digit."""
    text = (DOCS / "how-to" / "nearly-incompressible.md").read_text(encoding="utf-8")
    names = {("F", 1): "triangles, order 1", ("V", 1): "dual polygons, order 1"}
    names |= {("F", 2): "triangles, order 2", ("V", 2): "dual polygons, order 2"}
    for (method, order), name in names.items():
        (row,) = re.findall(rf"^\| {name} \|(.*)\|$", text, flags=re.MULTILINE)
        for level, given in enumerate(re.findall(r"-[\d.]+", row)[:2], start=1):
            work = cook_row(CookCode(method, level, order), poisson=0.4999).solution.load_work
            last_digit = 10.0 ** -len(given.partition(".")[2])
            assert 100.0 * (work / NEARLY_INCOMPRESSIBLE_WORK - 1.0) == pytest.approx(
                float(given), abs=1.5 * last_digit
            )


def test_pictures_are_small() -> None:
    """Every picture of elasticity is stored with less than 150 kB."""
    pictures = list((DOCS / "images").glob("elasticity-*.png"))
    assert len(pictures) == 3
    assert all(picture.stat().st_size < 150_000 for picture in pictures)
