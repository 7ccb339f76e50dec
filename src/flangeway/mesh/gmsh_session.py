"""Gmsh brought in only when it is needed, used without disturbing a caller that uses it too."""

import importlib
import re
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from flangeway.errors import InputError, MissingLibraryError

DEBIAN_PACKAGES = {
    "libGL": "libgl1",
    "libGLU": "libglu1-mesa",
    "libX11": "libx11-6",
    "libXcursor": "libxcursor1",
    "libXext": "libxext6",
    "libXfixes": "libxfixes3",
    "libXft": "libxft2",
    "libXinerama": "libxinerama1",
    "libXrender": "libxrender1",
    "libfontconfig": "libfontconfig1",
    "libgomp": "libgomp1",
}
"""Debian packages that bring the shared libraries which the Gmsh wheel expects of the system."""

_LOCK = threading.RLock()


def load_gmsh() -> Any:
    """Return the module gmsh; a `MissingLibraryError` names the packages of a shared library that is missing."""
    try:
        return importlib.import_module("gmsh")
    except OSError as reason:
        library = re.search(r"(lib[A-Za-z0-9_+-]+)\.so", str(reason))
        missing = library.group(1) if library else "a shared library"
        package = DEBIAN_PACKAGES.get(missing)
        first = f" (Debian package {package})" if package else ""
        raise MissingLibraryError(
            f"Gmsh needs {missing}{first}, which this system lacks: {reason}\n"
            "  what to do: on Debian or Ubuntu run\n"
            f"    apt-get install {' '.join(sorted(DEBIAN_PACKAGES.values()))}\n"
            "  elsewhere install the packages that bring the same libraries"
        ) from reason


@contextmanager
def gmsh_model(name: str, options: Mapping[str, float]) -> Iterator[Any]:
    """Give gmsh with a new, empty model that is removed at the end, and options by name for its time.

    If the caller has initialised Gmsh, the options and the current model are restored; if not, Gmsh is finalised. One
    thread at a time.
    """
    with _LOCK:
        gmsh = load_gmsh()
        owner = not gmsh.isInitialized()
        if owner:
            # no configuration files and no signal handlers: the caller's process stays his
            gmsh.initialize(readConfigFiles=False, interruptible=False)
        before = {} if owner else {option: gmsh.option.getNumber(option) for option in options}
        current = None if owner else gmsh.model.getCurrent()
        try:
            for option, value in options.items():
                gmsh.option.setNumber(option, value)
            gmsh.model.add(name)
            try:
                yield gmsh
            finally:
                gmsh.model.remove()
        finally:
            if owner:
                gmsh.finalize()
            else:
                for option, value in before.items():
                    gmsh.option.setNumber(option, value)
                gmsh.model.setCurrent(current)


def generate(gmsh: Any) -> None:
    """Make the plane mesh of the current model; an `InputError` with Gmsh's reason if it fails."""
    try:
        gmsh.model.mesh.generate(2)
    except Exception as reason:
        raise InputError(
            f"a region that Gmsh does not mesh: {reason}",
            "outlines without slivers much smaller than the size",
            "reduce the size, or look at the outline",
        ) from reason
