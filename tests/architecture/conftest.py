"""The modules of the package, and what each imports."""

import ast
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "src" / "flangeway"


def name_of(path: Path) -> str:
    """Dotted name of a module below flangeway; a package's is that of its folder."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in sorted(PACKAGE.rglob("*.py")) if path != PACKAGE / "__init__.py"}
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in MODULES.items()}


def imports_of(name: str) -> set[str]:
    """Modules and packages below flangeway that a module imports, inside functions and for types too."""
    found = set()
    for node in ast.walk(TREES[name]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: relative import"
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.add(whole if whole.removeprefix("flangeway.") in {*MODULES, "_core"} else str(node.module))
    return {each.removeprefix("flangeway.") for each in found if each.startswith("flangeway.")} - {name}


IMPORTS = {name: imports_of(name) for name in MODULES}
