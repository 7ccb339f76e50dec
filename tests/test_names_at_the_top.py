"""The names that scripts take from the package itself, and from the packages directly below it."""

import ast
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import flangeway
import flangeway.railway

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.ipynb")]


def stub_of(package):
    """Names of packages, and of other names with the modules that they come from, in the stub of a package."""
    tree = ast.parse(Path(package.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    packages = {alias.name for node in imports if node.module is None for alias in node.names}
    return packages, {alias.name: node.module for node in imports if node.module for alias in node.names}


def test_importing_loads_nothing_heavy():
    """Importing the package loads neither NumPy nor matplotlib, and its first names of mechanics no matplotlib."""
    code = (
        "import sys, flangeway, flangeway.railway; assert not {'numpy', 'scipy', 'matplotlib'} & set(sys.modules); "
        "flangeway.solve_elasticity; assert 'numpy' in sys.modules and 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("package", [flangeway, flangeway.railway])
def test_every_name_is_the_one_of_its_module(package):
    """Every name of the stub is found, is listed by dir, and is the object of that name in its module."""
    packages, names = stub_of(package)
    assert {*packages, *names} <= set(dir(package))
    for name, module in names.items():
        assert getattr(package, name) is getattr(import_module(f"{package.__name__}.{module}"), name)
    for name in packages:
        assert getattr(package, name).__name__ == f"{package.__name__}.{name}"


def test_names_are_few_and_explained():
    """There are not more than fifty names besides packages, and the package's own text speaks of each."""
    assert len(stub_of(flangeway)[1]) <= 50
    for package in (flangeway, flangeway.railway):
        assert [name for name in stub_of(package)[1] if f"`{name}`" not in package.__doc__] == []


def test_unknown_names_are_an_attribute_error():
    """A name that there is not is an AttributeError that tells it."""
    with pytest.raises(AttributeError, match="solve_everything"):
        _ = flangeway.solve_everything


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_import_from_one_level(page):
    """Pages and notebooks import from the package or from one directly below it."""
    deep = r"(?:from|import) flangeway(?:\.\w+){2,}"
    assert re.findall(deep, page.read_text(encoding="utf-8")) == []
