"""Prepares the package for its reference: each name once, at the module that defines it."""

from pathlib import Path
from typing import Any

import griffe


class Folders(griffe.Extension):
    """Adds folders without ``__init__.py``, which Griffe leaves out, and hides what the others re-export."""

    def on_package(self, *, pkg: griffe.Module, loader: griffe.GriffeLoader, **_: Any) -> None:
        """Change the package once it is loaded."""
        _complete(Path(pkg.filepath).parent, pkg, loader)


def _complete(folder: Path, package: griffe.Module, loader: griffe.GriffeLoader) -> None:
    for inner in sorted(folder.iterdir()):
        if not any(inner.rglob("*.py")):
            continue
        if not (inner / "__init__.py").exists():
            _add(inner, package, loader)
        else:
            _hide_exports(package.members[inner.name])
        _complete(inner, package.members[inner.name], loader)


def _hide_exports(package: griffe.Object | griffe.Alias) -> None:
    for member in package.members.values():
        if member.is_alias:
            member.public = False


def _add(folder: Path, package: griffe.Module, loader: griffe.GriffeLoader) -> None:
    shared = {"lines_collection": loader.lines_collection, "modules_collection": loader.modules_collection}
    added = griffe.Module(folder.name, filepath=[folder], **shared)
    package.set_member(folder.name, added)
    for path in sorted(folder.glob("*.py")):
        code = path.read_text(encoding="utf-8")
        loader.lines_collection[path] = code.splitlines()
        module = griffe.visit(
            path.stem,
            filepath=path,
            code=code,
            extensions=loader.extensions,
            parent=added,
            docstring_parser=loader.docstring_parser,
            docstring_options=loader.docstring_options,
            **shared,
        )
        added.set_member(path.stem, module)
