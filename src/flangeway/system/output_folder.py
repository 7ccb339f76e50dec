"""A folder of results that is filled at once or not at all, and the versions of the programs that made it."""

import os
import platform
import tempfile
from collections.abc import Callable, Iterable
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from flangeway.errors import InputError

# --- Versions of the programs that made a result.


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


# --- A folder of results that is filled at once or not at all.


Writer = Callable[[Path], object]
ENDINGS = (
    *(".html", ".json", ".md", ".png", ".pvd", ".vtu"),
    *(".csv", ".fmu", ".npz", ".parquet", ".sqlite", ".xlsx"),
)
"""Of the files of results."""


def refuse_unwritable(folder: Path, names: Iterable[str] = ()) -> None:
    """Raise `InputError` for a folder in which results, or files of some names, cannot be written.

    Nothing stays behind. A folder inside of it that is called like a file of results, see `ENDINGS`, is refused.
    """
    try:
        existing = _existing(folder)
        if folder.resolve() == Path(folder.absolute().anchor):
            raise InputError(
                f"output folder {folder}, the root of the file system", "a folder for results", "name one with --out"
            )
        if not existing.is_dir():
            raise InputError(
                f"output folder {folder}: {existing} is not a folder",
                "a folder, or a place where one can be made",
                "remove what is in the way, or choose another folder with --out",
            )
        with tempfile.TemporaryDirectory(dir=existing, prefix=".flangeway-"):
            pass
        _refuse_folders(folder, (*names, *(path.name for path in folder.glob("*") if path.suffix in ENDINGS)))
    except (OSError, ValueError) as reason:  # a zero byte in the name is the latter
        raise _unwritable(folder, reason) from reason


def write_together(folder: Path, writers: dict[str, Writer]) -> list[Path]:
    """Write files in a temporary folder, then move them to their places in order; return them.

    If a writer fails or the user stops it, no file is at its place and nothing stays behind. Files of the same names
    are replaced; others are left alone. The names, of the functions that write one file each, may be in a folder of the
    folder. An `InputError` if the system does not allow to write there.
    """
    try:
        _refuse_folders(folder, writers)
        # within one file system, so that moving is renaming
        with tempfile.TemporaryDirectory(dir=_existing(folder), prefix=".flangeway-") as name:
            stage = Path(name)
            for file, write in writers.items():
                (stage / file).parent.mkdir(exist_ok=True)
                write(stage / file)
            for file in writers:
                (folder / file).parent.mkdir(parents=True, exist_ok=True)
                os.replace(stage / file, folder / file)  # noqa: PTH105 (documented as atomic)
    except OSError as reason:
        raise _unwritable(folder, reason) from reason
    return [folder / file for file in writers]


def bytes_writer(data: bytes) -> Writer:
    """Return a function that writes bytes to a file."""
    return partial(Path.write_bytes, data=data)


def text_writer(text: str) -> Writer:
    """Return a function that writes text to a file, in UTF-8."""
    return bytes_writer(text.encode("utf-8"))


def write_text(file: Path, text: str) -> list[Path]:
    """Write a text to a file, or nothing; see `write_together`."""
    return write_together(file.parent, {file.name: text_writer(text)})


def _refuse_folders(folder: Path, names: Iterable[str]) -> None:
    for name in names:
        if (folder / name).is_dir():
            raise InputError(
                f"output file {folder / name}, which is a folder",
                "names that are free, or files to write over",
                "remove it, or choose another place for the results",
            )


def _existing(folder: Path) -> Path:
    """Return the folder, or the nearest one above it that is there."""
    parent = folder.absolute()
    while parent != parent.parent and not os.path.lexists(parent):
        parent = parent.parent
    return parent


def _unwritable(folder: Path, reason: OSError | ValueError) -> InputError:
    return InputError(
        f"output folder {folder}, which cannot be written: {getattr(reason, 'strerror', None) or reason}",
        "a folder with permission and room to write",
        "choose another folder with --out",
    )
