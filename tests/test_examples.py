"""Every example runs, and its own checks hold."""

import ast
import re
import runpy
from pathlib import Path

import nbformat
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
ARGUMENTS = {"wheelset_tangent": {"size_scale": 2.0}}


@pytest.mark.ci
@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_example_runs_and_its_checks_hold(path, capsys):
    """The script's `main` ends without an error on a coarse mesh and says what it found."""
    runpy.run_path(str(path))["main"](**ARGUMENTS.get(path.stem, {}))
    assert capsys.readouterr().out


MAX_NAMES = 10  # that a first contact needs: of shapes, meshes, bodies, surfaces, and what presses them


def first_script_of_the_tutorial():
    """Return the blocks of the tutorial up to its first contact."""
    page = (EXAMPLES.parent / "docs" / "tutorials" / "contact.md").read_text(encoding="utf-8")
    return "\n".join(re.findall(r"```python\n(.*?)```", page.partition("## Compare")[0], re.DOTALL))


@pytest.mark.parametrize(
    "script", [(EXAMPLES / "first_contact.py").read_text(encoding="utf-8"), first_script_of_the_tutorial()]
)
def test_a_first_contact_needs_at_most_ten_names_and_no_numpy(script):
    """A roller is meshed, pressed on a block and its force printed with ten names of the package at most."""
    imports = [node for node in ast.walk(ast.parse(script)) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert all(isinstance(node, ast.ImportFrom) and node.module.startswith("flangeway") for node in imports)
    assert "press(" in script
    assert len({name.name for node in imports for name in node.names}) <= MAX_NAMES


GALLERY = sorted(path for path in (EXAMPLES / "gallery").glob("*.py") if path.stem != "gallery_drawing")


@pytest.fixture(scope="module")
def example_notebook():
    """Return what makes the notebooks of the site."""
    return runpy.run_path(str(EXAMPLES.parent / "docs" / "hooks.py"))["example_notebook"]


@pytest.mark.ci
@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_an_example_of_the_gallery_holds_as_its_notebook_and_is_on_the_page(path, capsys, example_notebook):
    """The notebook's cells run one after the other, print a number and return a picture; the page has both."""
    notebook = example_notebook(path)
    nbformat.validate(notebook)
    title, *cells = (cell["source"] for cell in notebook["cells"])
    names = {"__name__": "__main__"}
    for source in cells[1:-1]:  # the first is a command of Jupyter, the last the call
        exec(compile(source, path.name, "exec"), names)
    assert eval(cells[-1], names).axes
    assert re.search(r"\d", capsys.readouterr().out)
    assert 15 <= len(path.read_text().splitlines()) <= 50
    docs = EXAMPLES.parent / "docs"
    assert (docs / "images" / "examples" / f"{path.stem}.png").stat().st_size <= 25_000
    page = (docs / "gallery.md").read_text(encoding="utf-8")
    assert f"images/examples/{path.stem}.png" in page
    assert f"{title.removeprefix('# ')}: [`{path.stem}`](examples/{path.stem}.ipynb)" in page
