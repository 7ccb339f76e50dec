"""Writes docs/licences.md from pyproject.toml, the metadata of the installed packages, and the crates of the core.

Run it in an environment with every group installed, and with cargo: ``python .ci/licences.py``.
"""

import json
import re
import subprocess
import tomllib
from collections import Counter
from importlib.metadata import metadata
from pathlib import Path

ROOT = Path(__file__).parents[1]
PURPOSE = {
    "ezdxf": "outlines from DXF",
    "gmsh": "triangulation; meshes in its format",
    "lazy-loader": "names that are loaded when they are first used",
    "matplotlib": "pictures",
    "meshio": "meshes in other programs' formats",
    "numpy": "arrays",
    "pillow": "pictures in the report",
    "jinja2": "the page of a report",
    "psutil": "memory of the process and of the machine",
    "pydantic": "checks of inputs and case files",
    "rich": "the terminal",
    "scipy": "sparse matrices, optimisation",
    "shapely": "clipping of Voronoi cells, overlap of polygons",
    "typer": "the command line",
    "typing-extensions": "types with defaults, before Python 3.13",
}
INTRODUCTION = """# Licences

flangeway has the BSD 3-Clause licence; the text is in the file `LICENSE`. This page lists its dependencies. The script
`python .ci/licences.py` makes it from the metadata of the packages.

## What Gmsh's licence means for you

Gmsh has the GNU General Public License, version 2 or later. flangeway contains no part of it. `pip` installs Gmsh from
a separate package, and flangeway calls it to make triangulations, in the same process or, for long meshes, in a second
one.

- **Use** of flangeway has no conditions, also for commercial purposes and inside a company. The GPL allows everyone to
  run a program for any purpose, and your models, meshes, profiles and results are yours.
- **Distribution of flangeway**, changed or not, is under its BSD licence, which is compatible with the GPL.
- **Distribution of a bundle** in which flangeway and Gmsh work together (an installer, a container, a frozen
  application) must follow the GPL: offer the source of Gmsh, and license the programs that run with it in one process,
  including yours, under terms that the GPL allows. If this is not possible, do not bundle Gmsh, and ask a lawyer
  whether that is enough in your case. The authors of Gmsh also offer other licences.

This is our reading of the licences; it is not legal advice.
"""


NOT_IN_METADATA = {"fmpy": "BSD-2-Clause"}
"""From the file of the licence."""


def licence(name: str) -> str:
    """Return what the metadata of an installed package says of its licence."""
    if name in NOT_IN_METADATA:
        return NOT_IN_METADATA[name]
    fields = metadata(name)
    if "License-Expression" in fields:
        return fields["License-Expression"]
    prefix = "License :: OSI Approved :: "
    classifiers = [text.removeprefix(prefix) for text in fields.get_all("Classifier") or [] if text.startswith(prefix)]
    if classifiers:
        return ", ".join(classifiers)
    return fields["License"].splitlines()[0] if "License" in fields else "not stated"


def table(requirements: list[str], *, purpose: bool = False) -> list[str]:
    """Return the lines of a table with a row for each requirement."""
    lines = ["| package | from version | licence |", "|---|---|---|"]
    if purpose:
        lines = ["| package | from version | licence | for |", "|---|---|---|---|"]
    for requirement in sorted(requirements):
        name, bound = re.findall(r"^([\w.-]+)(?:\[.*\])?>=([\w.]+)", requirement)[0]
        lines.append(f"| {name} | {bound} | {licence(name)} |" + (f" {PURPOSE[name]} |" if purpose else ""))
    return lines


def linked_crates() -> tuple[list[dict[str, str]], Counter[str]]:
    """Return the crates that the core names itself, and how many of all that are linked have each licence."""
    command = ["cargo", "metadata", "--format-version=1", "--locked", "--manifest-path", str(ROOT / "core/Cargo.toml")]
    command.append("--filter-platform=x86_64-unknown-linux-gnu")
    graph = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    packages = {package["id"]: package for package in graph["packages"]}
    needs = {
        node["id"]: [dep["pkg"] for dep in node["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
        for node in graph["resolve"]["nodes"]
    }
    core = graph["resolve"]["root"]
    reached, waiting = set(), list(needs[core])
    while waiting:
        if (crate := waiting.pop()) not in reached:
            reached.add(crate)
            waiting += needs[crate]
    direct = sorted((packages[crate] for crate in needs[core]), key=lambda package: package["name"])
    return direct, Counter(packages[crate]["license"].replace("/", " OR ") for crate in reached)


def page() -> str:
    """Return the page as it has to be."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = [INTRODUCTION, "## Installed with flangeway", "", *table(project["dependencies"], purpose=True)]
    for group, requirements in sorted(project["optional-dependencies"].items()):
        lines += ["", f"## Group `{group}`", "", *table(requirements)]
    direct, licences = linked_crates()
    lines += ["", "## Compiled into the core", ""]
    lines += ["These crates and what they need are linked into `flangeway._core`; the wheel carries a list of all of"]
    lines += ["them, with versions and licences, in its metadata (`sboms/`).", ""]
    lines += ["| crate | version | licence |", "|---|---|---|"]
    lines += [f"| {crate['name']} | {crate['version']} | {crate['license']} |" for crate in direct]
    lines += ["", f"All {licences.total()} linked crates by licence:", "", "| licence | crates |", "|---|---|"]
    lines += [f"| {name} | {count} |" for name, count in sorted(licences.items(), key=lambda item: (-item[1], item[0]))]
    return "\n".join([*lines, "", *BUNDLED])


BUNDLED = """## In the report

The interactive report carries three.js (MIT), Flatbush (ISC) and what Flatbush needs, as one file; their texts are in
`src/flangeway/report/viewer/libraries/LICENCES.txt`, which the wheel carries beside `LICENSE`.

## In the pages of the site

Formulas are shown with a part of the font STIX Math (SIL Open Font License; its text is in
`docs/stylesheets/formulas-licence.txt`). Search from the disk needs iframe-worker (MIT), in `docs/javascripts/`.
Neither is in the wheel.
""".splitlines()

if __name__ == "__main__":
    (ROOT / "docs" / "licences.md").write_text(page() + "\n", encoding="utf-8")
