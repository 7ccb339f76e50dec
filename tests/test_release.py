"""What releases are made of: the workflows, the container file, and what a stranger meets first."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

from flangeway.mesh.gmsh_mesher import DEBIAN_PACKAGES

ROOT = Path(__file__).parents[1]
DOCKERFILE = (ROOT / "Dockerfile").read_text(encoding="utf-8")
JOBS = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text(encoding="utf-8"))["jobs"]


def test_only_a_tag_publishes_and_only_what_was_tested():
    """The jobs that may write anywhere wait for the tests, run for tags only, and take no password."""
    writing = {name: job for name, job in JOBS.items() if "permissions" in job}
    assert writing.keys() == {"publish", "pages"}
    assert set(JOBS["publish"]["needs"]) == {"source", "test"}
    assert JOBS["pages"]["needs"] == "publish"
    assert all("github.ref_type == 'tag'" in job["if"] for job in writing.values())
    assert "secrets" not in str(JOBS)


def test_the_container_has_the_libraries_of_gmsh_and_no_root():
    """The image installs each library that the Gmsh wheel needs, and the program runs as a user of its own."""
    installed = re.sub(r"^#.*", "", DOCKERFILE.rpartition("FROM ")[2], flags=re.MULTILINE)
    assert set(re.findall(r"\blib[\w-]+", installed)) == set(DEBIAN_PACKAGES)
    assert re.findall(r"^USER (\w+)$", installed, flags=re.MULTILINE) == ["flangeway"]
    assert installed.index("USER") < installed.index('ENTRYPOINT ["flangeway"]') < installed.index("CMD")


def test_a_release_writes_the_address_of_the_project_everywhere(tmp_path):
    """Every file with the placeholder of the address gets the address of the release; no placeholder stays."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
    placeholder = "https://flangeway" + ".invalid"
    having = [
        name
        for name in listed or ["pyproject.toml", "SECURITY.md"]
        if (ROOT / name).suffix in (".toml", ".md", ".yml", ".cff", ".py", ".html")
        and placeholder in (ROOT / name).read_text(encoding="utf-8")
    ]
    assert "pyproject.toml" in having
    for name in having:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    script = tmp_path / ".ci" / "addresses.py"
    subprocess.run([sys.executable, script, "https://host.example/owner/name/"], check=True)
    for name in set(having) - {".ci/addresses.py"}:
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert placeholder not in text, name
        assert "https://host.example/owner/name" in text, name


def test_each_push_runs_tests_lint_types_and_the_strict_site():
    """The workflow of a push installs with both oldest and newest Python, on three systems, and checks all of it."""
    workflow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))
    on, jobs = workflow[True], workflow["jobs"]  # YAML reads the key `on` as true
    assert {"push", "pull_request", "schedule"} <= on.keys()
    matrix = jobs["test"]["strategy"]["matrix"]["include"]
    assert {"3.11", "3.13"} <= {row["python"] for row in matrix}
    assert {row["runner"].partition("-")[0] for row in matrix} == {"ubuntu", "macos", "windows"}
    commands = " ".join(step.get("run", "") for step in jobs["checks"]["steps"])
    assert all(word in commands for word in ("ruff format --check", "ruff check", "mypy", "mkdocs build --strict"))
    command = re.findall(r"<!-- test command -->\n```sh\n(.*?)\n", (ROOT / "README.md").read_text("utf-8"))[0]
    tests = " ".join(step.get("run", "") for step in jobs["test"]["steps"])
    assert command.rpartition("pytest ")[2] in tests
    assert command.partition("pip install ")[2].partition(" && ")[0] in tests


def test_the_readme_is_short_and_its_picture_small():
    """The README has less than 150 lines, and its first picture less than 300 kB."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(readme.splitlines()) < 150
    (first, *_) = re.findall(r"!\[.*?\]\((.*?)\)", readme)
    assert (ROOT / first).stat().st_size < 300_000
