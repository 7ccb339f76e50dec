"""Prepares the package for its reference: each name once, at the module that defines it."""

from pathlib import Path
from typing import Any

import griffe


class Folders(griffe.Extension):
    """Adds folders without ``__init__.py``, which Griffe leaves out, and hides what the others re-export."""

    def on_package(self, *, pkg: griffe.Module, loader: griffe.GriffeLoader, **_: Any) -> None:
        """Change the package once it is loaded."""
        for folder in sorted(Path(pkg.filepath).parent.iterdir()):
            if (folder / "__init__.py").exists():
                _hide_exports(pkg.members[folder.name])
            elif any(folder.glob("*.py")):
                _add(folder, pkg, loader)


def _hide_exports(package: griffe.Object | griffe.Alias) -> None:
    for member in package.members.values():
        if member.is_alias:
            member.public = False
        elif member.is_module:
            _hide_exports(member)


def _add(folder: Path, pkg: griffe.Module, loader: griffe.GriffeLoader) -> None:
    shared = {"lines_collection": loader.lines_collection, "modules_collection": loader.modules_collection}
    added = griffe.Module(folder.name, filepath=[folder], **shared)
    pkg.set_member(folder.name, added)
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
