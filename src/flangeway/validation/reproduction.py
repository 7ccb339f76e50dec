"""One of the things that ``flangeway reproduce`` can do."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from rich.console import Console

from flangeway.cases.case import closest
from flangeway.errors import InputError
from flangeway.report.page.console import plain_table
from flangeway.system.output_folder import refuse_unwritable
from flangeway.validation.published_numbers import Reproduced
from flangeway.validation.validation_page import Chapter, Verdict

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
    chapter
        What the page of validation says of it.
    brief
        Whether it takes seconds, so that nothing is left out if all shall be quick.

    """

    compute: Compute
    write: Callable[[Any, Path, Callable[[str], None]], list[Path]]
    print_summary: Callable[[Console, Any, list[Path]], None]
    files: tuple[str, ...]
    chapter: Chapter
    brief: bool = False

    def check_folder(self, folder: Path) -> None:
        """Refuse a folder that cannot take the files; see `flangeway.system.output_folder.refuse_unwritable`."""
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


def print_verdicts(console: Console, verdicts: Mapping[str, Verdict]) -> None:
    """Print a line for each reproduction: numbers with a limit, those within, others, verdict and time."""
    shown = plain_table("reproduction")
    for name in ("with a limit", "within", "shown only", "verdict", "seconds"):
        shown.add_column(name, justify="right")
    for key, verdict in verdicts.items():
        counts = (verdict.n_required, verdict.n_within, verdict.n_shown)
        shown.add_row(
            key,
            *map(str, counts),
            "passed" if verdict.passed else "not passed",
            f"{verdict.seconds:.1f}",
            style="green" if verdict.passed else "bold red",
        )
    console.print(shown)
