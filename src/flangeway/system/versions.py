"""Versions of the programs that made a result."""

import platform
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("flangeway", "numpy", "scipy", "gmsh")


def versions() -> dict[str, str]:
    """Return the versions of flangeway, Python and the libraries that decide the numbers."""
    by_name = {name: version_of(name) for name in PACKAGES}
    return {"flangeway": by_name.pop("flangeway"), "python": platform.python_version(), **by_name}


def version_of(name: str) -> str:
    """Return the version of an installed package."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"  # run from its source folder
