"""Executes the notebooks of docs/notebooks/ and stores what they print and draw in them.

``python .ci/notebooks.py [NAME ...]``, all if none is named; pictures are stored in 96 colours.
"""

import base64
import io
import os
import sys
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).parents[1] / "docs" / "notebooks"
SHOWN = ("image/png", "text/html", "text/plain")
"""Kinds of output, the first one that there is is kept."""


def executed(path: Path) -> Any:
    """Return a notebook with the outputs of a new run; an error of a cell is raised."""
    notebook = nbformat.read(path, as_version=4)
    environment = os.environ | {"MPLBACKEND": "module://matplotlib_inline.backend_inline"}  # whatever this process has
    NotebookClient(notebook, timeout=600, kernel_name="python3").execute(env=environment)
    for cell in notebook.cells:
        cell.metadata.clear()  # times of execution
        if cell.cell_type == "code":
            cell.outputs = _joined([_small(output) for output in cell.outputs if _wanted(output)])
    notebook.metadata.pop("language_info", None)
    return notebook


def _wanted(output: Any) -> bool:
    """Leave out progress and warnings, and the names of objects that a last line returns."""
    if output.output_type == "stream":
        return bool(output.name == "stdout")
    return any(kind in output.data for kind in SHOWN[:2])


def _joined(outputs: list[Any]) -> list[Any]:
    """Make one output of lines that were printed one by one."""
    kept: list[Any] = []
    for output in outputs:
        if kept and output.output_type == kept[-1].output_type == "stream":
            kept[-1].text += output.text
        else:
            kept.append(output)
    return kept


def _small(output: Any) -> Any:
    if output.output_type == "stream":
        return output
    kind = next(kind for kind in SHOWN if kind in output.data)
    output.data = {kind: output.data[kind]}
    if kind == "image/png":
        with Image.open(io.BytesIO(base64.b64decode(output.data[kind]))) as full:
            packed = io.BytesIO()
            full.convert("RGB").quantize(96, dither=Image.Dither.NONE).save(packed, "PNG", optimize=True)
        output.data[kind] = base64.b64encode(packed.getvalue()).decode()
    return output


def main(names: list[str]) -> None:
    """Execute notebooks and store them."""
    for path in sorted(FOLDER.glob("*.ipynb")):
        if not names or path.stem in names:
            nbformat.write(executed(path), path)


if __name__ == "__main__":
    main(sys.argv[1:])
