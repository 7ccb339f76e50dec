"""What releases are made of: the workflow that builds wheels, and the container file."""

import re
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
