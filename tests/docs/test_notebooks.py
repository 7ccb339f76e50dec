"""The notebooks of the gallery: small files with stored outputs, which a new run prints and draws again."""

import json
import runpy
from pathlib import Path

import pytest

from tests.docs.conftest import refuse_other_lines

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
MAX_SIZE = 200_000


def code_cells(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def printed(cell):
    return "".join("".join(output["text"]) for output in cell["outputs"] if output["output_type"] == "stream")


def kinds(cell):
    return sorted(kind for output in cell["outputs"] for kind in output.get("data", ()))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_small_and_has_its_outputs(path):
    """A notebook begins with a title, shows numbers and a picture, has no error and is less than 200 kB."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert path.stat().st_size < MAX_SIZE
    assert "".join(notebook["cells"][0]["source"]).startswith("# ")
    assert any(printed(cell) for cell in code_cells(notebook))
    assert any("image/png" in kinds(cell) for cell in code_cells(notebook))
    assert not any(output["output_type"] == "error" for cell in code_cells(notebook) for output in cell["outputs"])


@pytest.mark.ci
@pytest.mark.filterwarnings("ignore")  # of Jupyter
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_new_run_prints_and_draws_the_same(path):
    """Executed again, every cell prints the stored lines, with numbers to 2 %, and draws as many pictures."""
    script = runpy.run_path(str(ROOT / ".ci" / "notebooks.py"))
    stored, again = json.loads(path.read_text(encoding="utf-8")), script["executed"](path)
    for old, new in zip(code_cells(stored), code_cells(again), strict=True):
        refuse_other_lines(printed(old), printed(new), 0.02)
        assert kinds(old) == kinds(new)
