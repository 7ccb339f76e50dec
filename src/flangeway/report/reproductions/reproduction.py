"""One of the things that ``flangeway reproduce`` can do."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from rich.console import Console

from flangeway.errors import InputError
from flangeway.study import refuse_unwritable
from flangeway.study.case import closest
from flangeway.study.reproductions import Reproduced

ALL = "all"
"""The name that stands for every reproduction."""


class Compute(Protocol):
    """Computes again what was published, with `quick` only the cheaper part of it."""

    def __call__(self, *, quick: bool = ..., progress: Callable[[str], None] = ...) -> Reproduced:
        """Compute."""


@dataclass(frozen=True)
class Reproduction:
    """One reproduction.

    Parameters
    ----------
    compute
        Called with ``quick`` and ``progress``.
    write
        Called with what was computed, the folder and ``progress``; writes all files or none and returns them.
    print_summary
        Called with a console, what was computed, and the files.
    files
        Names of all files that it may write.

    """

    compute: Compute
    write: Callable[[Any, Path, Callable[[str], None]], list[Path]]
    print_summary: Callable[[Console, Any, list[Path]], None]
    files: tuple[str, ...]

    def check_folder(self, folder: Path) -> None:
        """Refuse a folder that cannot take the files; see `flangeway.study.refuse_unwritable`."""
        refuse_unwritable(folder, self.files)


def find_reproductions(name: str, known: Mapping[str, Reproduction]) -> dict[str, Reproduction]:
    """Return the reproduction of that name among those known, or every one for ``"all"``.

    Raises
    ------
    InputError
        If there is none.

    """
    if name == ALL:
        return dict(known)
    if name not in known:
        names = [*known, ALL]
        raise InputError(f"a reproduction called {name!r}", f"one of: {', '.join(names)}", closest(name, names))
    return {name: known[name]}
