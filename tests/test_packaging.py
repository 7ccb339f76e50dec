"""What a user gets who installs flangeway: files, types, version, dependencies and their licences."""

import ast
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

import flangeway

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "flangeway"
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETTINGS["project"]
STUDIES = tomllib.loads((ROOT / "studies" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
GROUPS = {"": PROJECT["dependencies"], **PROJECT["optional-dependencies"]}
REQUIREMENTS = sorted({requirement for group in GROUPS.values() for requirement in group})
COMPILED = {".pyc", ".so"}
DATA = sorted(
    path.relative_to(PACKAGE)
    for path in PACKAGE.rglob("*")
    if path.is_file() and path.suffix not in {".py", *COMPILED} and not path.name.startswith(".")
)


def resources_named(module: Path) -> set[str]:
    """File names in a module that reads files of the package."""
    text = module.read_text(encoding="utf-8")
    if "importlib.resources" not in text:
        return set()
    tree = ast.parse(text)
    reads = any(isinstance(node, ast.ImportFrom) and node.module == "importlib.resources" for node in ast.walk(tree))
    words = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    return {word for word in words if re.fullmatch(r"[\w./]+\.(csv|css|html|js|txt)", word)} if reads else set()


def test_every_file_that_code_reads_is_in_the_package():
    """A file that a module reads from the package is there under that name."""
    names = {path.as_posix() for path in DATA} | {path.name for path in DATA}
    named = {word: module for module in PACKAGE.rglob("*.py") for word in resources_named(module)}
    assert len(named) > 10
    missing = {
        word: module.name
        for word, module in named.items()
        if not any(name == word or name.endswith(f"/{word}") for name in names)
    }
    assert missing == {}


def test_the_wheel_has_one_package_with_all_its_files():
    """The package and all files beside its modules are packed, but for what git ignores, and nothing else."""
    assert SETTINGS["tool"]["maturin"]["python-source"] == "src"
    assert [path.name for path in (ROOT / "src").iterdir() if not path.name.startswith((".", "_"))] == ["flangeway"]
    assert {entry["format"] for entry in SETTINGS["tool"]["maturin"]["include"]} == {"sdist"}
    assert not SETTINGS["tool"]["maturin"].keys() & {"exclude", "python-packages"}
    if (ROOT / ".git").exists():
        paths = "\n".join(str(PACKAGE / path) for path in DATA)
        ignored = subprocess.run(
            ["git", "check-ignore", "--stdin"], input=paths, cwd=ROOT, capture_output=True, text=True, check=False
        )
        assert ignored.stdout == ""


def test_the_installed_package_has_every_file():
    """Where flangeway is installed from a wheel, each file of its sources came with it."""
    installed = Path(flangeway.__file__).parent
    assert [str(path) for path in DATA if not (installed / path).is_file()] == []


def test_type_information_ships():
    """The marker of typed packages stands beside the package's first module, and the compiled core has a stub."""
    assert {Path("py.typed"), Path("_core.pyi")} <= set(DATA)


def test_licences_of_bundled_files_ship():
    """The licence files of the project's settings exist, and are all licence files in its sources."""
    stated = {ROOT / name for name in PROJECT["license-files"]}
    found = {path for path in PACKAGE.rglob("*") if re.match(r"(LICEN[CS]E|COPYING|NOTICE)", path.name)}
    assert all(path.stat().st_size for path in stated)
    assert stated == {ROOT / "LICENSE", *found}
    assert (ROOT / "studies" / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()


def test_the_version_has_one_place():
    """No module spells the version; the crate, the citation and the studies, which need it, give the same one."""
    version = PROJECT["version"]
    core = tomllib.loads((ROOT / "core" / "Cargo.toml").read_text(encoding="utf-8"))
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert flangeway.__version__ == core["package"]["version"] == version
    assert re.findall(r"^version: (.*)$", citation, flags=re.MULTILINE) == [version]
    assert (STUDIES["version"], STUDIES["dependencies"]) == (version, [f"flangeway=={version}"])
    assert [path for path in PACKAGE.rglob("*.py") if f'"{version}"' in path.read_text(encoding="utf-8")] == []


def test_optional_groups_are_few():
    """There are at most four optional groups of packages."""
    assert len(PROJECT["optional-dependencies"]) <= 4


@pytest.mark.parametrize("requirement", REQUIREMENTS)
def test_every_dependency_has_a_lower_bound_and_a_licence(requirement):
    """A direct dependency says from which version it works, and the page of licences has it with that version."""
    found = re.fullmatch(r"([\w.-]+)(?:\[[\w,-]+\])?>=([\d.]+)(?:[,;].*)?", requirement)
    assert found, f"{requirement} has no lower bound"
    page = (ROOT / "docs" / "licences.md").read_text(encoding="utf-8")
    rows = re.findall(rf"^\| {re.escape(found[1])} \| {re.escape(found[2])} \| (.+?) \|", page, flags=re.MULTILINE)
    assert rows, "run .ci/licences.py"
    assert "not stated" not in rows
