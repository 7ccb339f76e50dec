"""Makes of the site what Markdown cannot: formulas as MathML, which browsers show without a script, and notebooks.

Examples of the gallery become notebooks to download, beside their thumbnails. Each module has a reference page.
"""

import ast
import base64
import html
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

EXAMPLES = Path(__file__).parents[1] / "examples" / "gallery"
DRAWING = EXAMPLES / "gallery_drawing.py"
"""What the examples import; their notebooks have it as a cell."""
SOURCES = {"flangeway": "src", "flangeway_studies": "studies"}
"""Folders below the project in which the packages are."""
PACKAGE = re.compile(r"^::: ([\w.]+)$", re.MULTILINE)
FOLDED = ("performance.md", "validation.md", "reference/summary.md")
"""Pages of many tables, whose long ones are folded: a page of more than 15,000 pixels is not read."""
MAX_ROWS = 3
TABLE = re.compile(r"<table>.*?</table>", re.DOTALL)
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Show a menu of versions where mike publishes this one beside others."""
    if "MIKE_DOCS_VERSION" in os.environ:
        config.extra["version"] = {"provider": "mike"}
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add a page for each notebook, with the outputs and pictures that are stored in it."""
    for file in [file for file in files if file.src_uri.endswith(".ipynb")]:
        name = PurePosixPath(file.src_uri)
        content: list[str] = []
        for number, cell in enumerate(json.loads(file.content_string)["cells"]):
            source = "".join(cell["source"])
            content.append(source if cell["cell_type"] == "markdown" else f"```python\n{source}\n```")
            for shown, picture in _outputs(cell, f"{name.stem}-{number}.png"):
                content.append(shown)
                if picture:
                    uri = str(name.with_name(f"{name.stem}-{number}.png"))
                    files.append(File.generated(config, uri, content=picture))
        content.append(f"[Download this notebook]({name.name}); it runs in Jupyter, in an environment with flangeway.")
        files.append(File.generated(config, str(name.with_suffix(".md")), content="\n\n".join(content) + "\n"))
    for path in sorted(EXAMPLES.glob("*.py")):
        if path != DRAWING:
            notebook = json.dumps(example_notebook(path), ensure_ascii=False, indent=1)
            files.append(File.generated(config, f"examples/{path.stem}.ipynb", content=notebook + "\n"))
    for file in [file for file in files if file.src_uri.startswith("reference/")]:
        for name in PACKAGE.findall(file.content_string):
            _split(name, file, files, config)
    return files


def _split(package: str, file: File, files: Files, config: MkDocsConfig) -> None:
    """Give each module of a package a page of its own, and the package's page a list of them."""
    folder = EXAMPLES.parents[1] / SOURCES[package.partition(".")[0]] / package.replace(".", "/")
    if not folder.is_dir():
        return
    lines = []
    for path in sorted(folder.rglob("*.py"), key=lambda path: (len(path.relative_to(folder).parts) > 1, path)):
        if path.stem == "__init__":
            continue
        inside = ".".join(path.relative_to(folder).with_suffix("").parts)
        about = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").partition("\n\n")[0]
        page = f"{PurePosixPath(file.src_uri).stem}/{inside}.md"
        lines.append(f"- [`{inside}`]({page}): {' '.join(about.split())}")
        text = f"# {inside}\n\n::: {package}.{inside}\n"
        files.append(File.generated(config, f"reference/{page}", content=text))
    options = "    options: {show_submodules: false}"
    content = file.content_string.replace(f"::: {package}\n", "\n".join((f"::: {package}", options, "", *lines, "")))
    file.content_string = content


def example_notebook(path: Path) -> dict[str, Any]:
    """Notebook of an example of the gallery: its title, what draws, its code, and the call that shows the picture."""
    title, _, code = path.read_text(encoding="utf-8").removeprefix('"""').partition('."""\n')
    drawing = DRAWING.read_text(encoding="utf-8").partition('"""\n')[2]
    own = "".join(line for line in code.splitlines(keepends=True) if not line.startswith("from gallery_drawing"))
    code_cells = ["%matplotlib inline", drawing.strip(), own.strip(), "main()"]
    cells: list[dict[str, Any]] = [{"cell_type": "markdown", "id": "title", "metadata": {}, "source": f"# {title}"}]
    for number, source in enumerate(code_cells):
        more: dict[str, Any] = {"execution_count": None, "outputs": []}
        cells.append({"cell_type": "code", "id": f"code-{number}", "metadata": {}, "source": source, **more})
    kernel = {"name": "python3", "display_name": "Python 3"}
    return {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


def _outputs(cell: dict[str, Any], picture: str) -> Iterator[tuple[str, bytes]]:
    """Markdown of each output of a cell, and the picture that it shows."""
    for output in cell.get("outputs", ()):
        data = output.get("data", {})
        if "text" in output:
            yield f"```text\n{''.join(output['text']).rstrip()}\n```", b""
        elif "image/png" in data:
            yield f"![What the cell above draws]({picture})", base64.b64decode("".join(data["image/png"]))
        elif "text/html" in data:
            yield "".join(data["text/html"]), b""


def on_page_content(content: str, page: Page, **_: Any) -> str:
    """Replace the formulas of a page, which pymdownx.arithmatex has marked; search lists the reference last."""
    if page.file.src_uri.startswith("reference/"):
        page.meta.setdefault("search", {"boost": 0.2})
    if page.file.src_uri in FOLDED:
        content = TABLE.sub(_folded, content)
    return FORMULA.sub(_mathematics, content)


def _folded(found: re.Match[str]) -> str:
    """A long table behind its number of rows; a search within the page, and a link into it, open it."""
    rows = found[0].count("<tr>") - 1
    if rows <= MAX_ROWS:
        return found[0]
    return f"<details><summary>table of {rows} rows</summary>{found[0]}</details>"


def _mathematics(found: re.Match[str]) -> str:
    kind, formula = found[1], html.unescape(found[2]).strip()
    fenced = formula.replace("\\lvert", "\\left|").replace("\\rvert", "\\right|")  # else spaced as operators
    made = convert(fenced, display="block" if kind == "div" else "inline")
    if "\\" in re.sub(r"<[^>]*>", "", html.unescape(made)):
        raise ValueError(f"a formula with an unknown command: {formula}")
    return f'<{kind} class="formula">{made}</{kind}>'
