"""The modules of the package, and what each imports."""

import ast
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

PACKAGE = Path(__file__).parents[2] / "src" / "flangeway"
TOP = "flangeway"
"""Name of the package itself among the modules below it."""
NAME = re.compile(r"(\.*)([A-Za-z_]\w*(?:\.\w+)*)(?::[\w.]+)?")
"""A text that may name a module: relative to a package after dots, and with the name of a thing in it after a colon."""


def name_of(path: Path) -> str:
    """Dotted name of a module below flangeway; a package's is that of its folder."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts) or TOP


FILES = {name_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}
MODULES = {name: path for name, path in FILES.items() if name != TOP}


class Evaluated(Mapping[str, T]):
    """Values of modules by their names, each computed when it is first read: collecting the tests parses nothing."""

    def __init__(self, function: Callable[[str], T], names: Mapping[str, Path]) -> None:
        self.value, self.names = cache(function), names

    def __getitem__(self, name: str) -> T:
        return self.value(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


TREES = Evaluated(lambda name: parsed(MODULES[name]), MODULES)


def module_of(dotted: str) -> str | None:
    """Module that a dotted name such as ``flangeway.mesh.dual`` loads, of flangeway; None if it is not of flangeway."""
    words = dotted.split(".")
    if words[0] != TOP:
        return None
    below = [".".join(words[1:end]) for end in range(len(words), 1, -1)]
    return next((name for name in below if name in {*FILES, "_core"}), TOP)


def absolute(dots: str, name: str, package: str) -> str:
    """Dotted name of what a relative import of a package names; without dots the name as it is."""
    parents = package.split(".")
    return ".".join([*parents[: len(parents) + 1 - len(dots)], *([name] if name else [])]) if dots else name


def named_in(text: str, package: str) -> str | None:
    """Module of flangeway that a text such as ``"flangeway.report:plot_result"`` names as a whole.

    The names of packages that the module itself is in do not count: these are loaded before it, and files beside it are
    read by such names.
    """
    match = NAME.fullmatch(text)
    module = module_of(absolute(match[1], match[2], package)) if match else None
    inside = f"{package}.".startswith(f"{TOP}.{module}.")
    return None if module == TOP or inside else module


def imports_in(tree: ast.Module, package: str) -> set[str]:
    """Modules of flangeway that a module of a package imports: inside functions, for types, and by texts.

    - `package`: dotted name of its package, for relative names.
    """
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {module_of(alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = absolute("." * node.level, node.module or "", package)
            found |= {module_of(f"{base}.{alias.name}") for alias in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(named_in(node.value, package))
    return found - {None}


def imports_of(name: str) -> set[str]:
    """Modules that a module imports; of a package whose names are loaded when used, those of its stub too."""
    path = FILES[name]
    package = f"{TOP}.{name}" if name != TOP else TOP
    if path.stem != "__init__":
        package = package.rpartition(".")[0]
    paths = [path]
    if "lazy_loader" in path.read_text(encoding="utf-8"):
        paths.append(path.with_suffix(".pyi"))
    return set().union(*(imports_in(parsed(each), package) for each in paths)) - {name}


IMPORTS = Evaluated(imports_of, FILES)
