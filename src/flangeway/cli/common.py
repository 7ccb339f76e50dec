"""What commands share: exit statuses, errors as messages, progress, ``--out``, ``--set``, ``--unit``.

NumPy, SciPy, Matplotlib and what needs them are imported inside of functions, so that help is quick.
"""

import functools
import inspect
import os
import re
import shlex
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flangeway.errors import InputError, MissingLibraryError, OutOfMemoryError
from flangeway.system.workbook import spreadsheet_library

if TYPE_CHECKING:
    from flangeway.cases.case import Case
    from flangeway.report.page.record import Report
    from flangeway.units import Units as UnitSystem

STARTED_S = time.perf_counter()
Progress = Callable[[str], None]

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130
NOTHING_WRITTEN = "interrupted; nothing was written"


def path_given(text: str) -> Path:
    """Return the path that an option names; an empty name is refused, which `Path` would take for the folder here."""
    if not text.strip():
        raise typer.BadParameter("an empty name")
    return Path(text)


def completion(names: Callable[[], Iterable[str]], *endings: str) -> Callable[[str], list[str]]:
    """Return what completes an argument in a shell: names, and files with some endings."""

    def complete(incomplete: str) -> list[str]:
        folder = Path(incomplete).parent if "/" in incomplete else Path()
        files = [str(path) for path in folder.glob("*") if path.suffix.lower() in endings]
        folders = [f"{path}/" for path in folder.glob("*") if endings and path.is_dir() and path.name[0] != "."]
        return [name for name in [*names(), *sorted(files + folders)] if name.startswith(incomplete)]

    return complete


def choices(*words: str) -> dict[str, Any]:
    """Return how an option that takes one of some words is shown in the help, and completed in a shell."""
    return {"metavar": f"[{'|'.join(words)}]", "autocompletion": completion(lambda: words)}


Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for the results.", parser=path_given),
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Drop the results that are there, and compute all anew.")]
Unit = Annotated[
    str | None,
    typer.Option("--unit", help="Unit of a file that names none.", **choices("mm", "cm", "m", "in", "ft")),
]
Units = Annotated[
    str | None,
    typer.Option("--units", help="Units of tables, tiles, pictures and CSV files.", **choices("metric", "us")),
]


def units_given(name: str | None) -> "UnitSystem | None":
    """Return the units that an option names."""
    for known in (None, "metric", "us"):
        if name == known:
            return known
    raise InputError(f"--units {name}", "metric or us", "choose one of these")


def results_folder(out: Path | None, name: str) -> Path:
    """Return the folder for results, ``out/NAME`` if none is given; an `InputError` if they cannot be written there."""
    from flangeway.system.output_folder import refuse_unwritable  # noqa: PLC0415

    folder = out or Path("out", name)
    refuse_unwritable(folder)
    return folder


def case_names() -> list[str]:
    """Names of all cases."""
    from flangeway.cases.case_file import CASE_FILES, CASES  # noqa: PLC0415

    return [*CASES, *CASE_FILES]


def geometry_names() -> list[str]:
    """Names of all cases of ``flangeway geometry``."""
    from flangeway.cases.rigid_run import GEOMETRY_CASES  # noqa: PLC0415

    return [*GEOMETRY_CASES]


def profile_names(kind: str = "") -> list[str]:
    """Names of the bundled rails, of the wheels, or of both if no kind is given."""
    from flangeway.railway.profiles import bundled  # noqa: PLC0415

    rails = [] if kind == "wheel" else [*bundled.SECTIONS, bundled.REFERENCE_RAIL]
    return rails if kind == "rail" else [*rails, *bundled.WHEELS, *bundled.REFERENCE_WHEELS]


def section_names() -> list[str]:
    """Names of the bundled sections."""
    from flangeway.railway.profiles.bundled import SECTIONS  # noqa: PLC0415

    return [*SECTIONS]


def complete_setting(ctx: typer.Context, incomplete: str) -> list[str]:
    """Complete path or key of ``--set`` for the case that the command names, and names and choices behind ``KEY=``.

    Bash hands over what is behind the sign alone unless its ``COMP_WORDBREAKS`` lacks it.
    """
    from flangeway.cases import CASES, find_case  # noqa: PLC0415
    from flangeway.cases.rigid_run import GeometryCase  # noqa: PLC0415

    # the parser has given up at a --set without a value, so that ctx lacks the case; bash and other shells name it here
    typed = f"{os.environ.get('COMP_WORDS', '')} {os.environ.get('_TYPER_COMPLETE_ARGS', '')}".split()
    named: list[type[Case]] = [find_case(word) for word in typed if word in case_names()]
    if ctx.info_name == "geometry":
        named = [GeometryCase]
    elif ctx.info_name == "creep-table":
        named = [CASES["wheelset"]]
    choices_of: dict[str, list[str]] = {}
    for caption, rows in named[0].tables_of_inputs() if named else ():
        table = re.sub(r"\.[\w-]+: ?", ".", f"{caption}.").strip(".")  # without the kinds of tables
        for key, _, allowed, _ in rows:
            choices_of.setdefault(f"{table}.{key}".lstrip("."), allowed.split(" or "))
    chosen, equals, _ = incomplete.partition("=")
    kind = chosen.rpartition(".")[2]
    if not equals:
        names = dict.fromkeys([*choices_of, *(path.rpartition(".")[2] for path in choices_of)])
        return [f"{name}=" for name in names if name.startswith(incomplete)]
    if kind in ("rail", "wheel"):
        values = profile_names(kind)
    else:
        values = next((words for path, words in choices_of.items() if f".{path}".endswith(f".{chosen}")), [])
    return [word for value in values if " " not in value and (word := f"{chosen}={value}").startswith(incomplete)]


PROFILES_ALONE = (".ban", ".whl", ".prr", ".prw", ".rail", ".wheel", ".dxf", ".slcs", ".slcw")
PROFILE_FILES = (*PROFILES_ALONE, ".csv", ".txt", ".dat", ".json")  # these endings have tables too
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Any other input of the case, as often as needed; `flangeway cases CASE` lists all.",
        autocompletion=complete_setting,
    ),
]
Workers = Annotated[
    int | None, typer.Option("--workers", metavar="N", help="Processes here; as many as cores if left out.")
]


def settings_of(settings: list[str] | None, advice: str) -> dict[str, Any]:
    """Return the values of ``--set``, by key."""
    from flangeway.records import GivenText  # noqa: PLC0415

    given: dict[str, Any] = {}
    for setting in settings or []:
        key, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f"--set {setting}", "--set KEY=VALUE", advice)
        given[key.strip()] = GivenText(value.strip())
    return given


@contextmanager
def errors_as_exit_status() -> Iterator[None]:
    """Turn the errors that users can meet into a message and an exit status."""
    try:
        with interruption_reported():
            yield
    except (InputError, MissingLibraryError) as error:
        complain(str(error))
        raise typer.Exit(WRONG_INPUT if isinstance(error, InputError) else FAILED) from None
    except MemoryError as error:
        if not isinstance(error, OutOfMemoryError):
            error = OutOfMemoryError(str(error.args[0]) if error.args else "a computation")
        complain(f"out of memory, nothing was written: {error}")
        raise typer.Exit(FAILED) from None


@contextmanager
def interruption_reported(message: str = NOTHING_WRITTEN) -> Iterator[None]:
    """Turn Ctrl-C into a message and an exit status."""
    try:
        yield
    except KeyboardInterrupt:
        complain(message)
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def progress_shown() -> Iterator[Progress]:
    """Show sentences on stderr: one changing line on a terminal, a line each elsewhere."""
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import Progress as Bar  # noqa: PLC0415
    from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    from flangeway.mesh import long_meshes_reported  # noqa: PLC0415

    console = Console(stderr=True)
    if not console.is_terminal:
        with long_meshes_reported(show_progress):
            yield show_progress
        return
    columns = (SpinnerColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False))
    with Bar(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def show(sentence: str) -> None:
            bar.update(task, description=sentence)

        with long_meshes_reported(show):
            yield show


def show_progress(sentence: str) -> None:
    """Show a sentence on stderr, in a line of its own."""
    print(sentence, file=sys.stderr, flush=True)


@dataclass
class Show:
    """How a command shows what it found; it takes the times of what the user waits for."""

    quiet: bool
    as_json: bool
    no_pictures: bool
    xlsx: bool = False
    units: "UnitSystem | None" = None
    marks_s: list[float] = field(default_factory=lambda: [STARTED_S])

    @contextmanager
    def progress(self, kept: str = "") -> Iterator[Progress]:
        """Show sentences on stderr, unless it is quiet.

        - `kept`: what is kept when it is interrupted, and where.
        """
        self.marks_s.append(time.perf_counter())
        goes_on = f"interrupted; {kept}, and the same command goes on from there"
        with interruption_reported(goes_on if kept else NOTHING_WRITTEN):
            if self.quiet:
                yield lambda _: None
                return
            with progress_shown() as progress:
                yield progress

    def record(
        self,
        record: "Report",
        folder: Path,
        others: Callable[[], Sequence[Path]] = tuple,
        *,
        last: bool = True,
        **further: bool,
    ) -> bool:
        """Print the numbers, which do not wait for the pictures, write all files, and print where the report is.

        - `others`: writes further files afterwards, and returns them.
        - `last`: whether JSON is that of this record; otherwise `json` prints it for all records.
        - `further`: options of `write_record`.

        Returns whether it ended well.
        """
        from flangeway.report.page.html_page import write_record  # noqa: PLC0415
        from flangeway.report.page.record import REPORT, print_record  # noqa: PLC0415

        console = stdout()
        if not self.as_json:
            print_record(console, record, quiet=self.quiet)
        with self.progress() as progress:
            files = write_record(record, folder, progress, pictures=not self.no_pictures, xlsx=self.xlsx, **further)
        self.files(others())
        if not self.as_json:
            if not self.quiet:
                console.print(self._times(len(files)), soft_wrap=True)
            console.print(f"Report: {folder / REPORT}", soft_wrap=True)
        self.marks_s = [time.perf_counter()]
        if last:
            self.json(record.summary)
        return record.converged

    def files(self, files: Iterable[Path]) -> None:
        """Print the names of files, unless JSON is wanted."""
        if self.as_json:
            return
        for file in files:
            stdout().print(f"File: {file}", soft_wrap=True)

    def json(self, content: Mapping[str, Any]) -> None:
        """Print a summary as JSON, if that is wanted."""
        from flangeway.cases.summary import summary_text  # noqa: PLC0415

        if self.as_json:
            typer.echo(summary_text(content), nl=False)

    def _times(self, n_files: int) -> str:
        """What the user waited for since the last report."""
        ends = [*self.marks_s, time.perf_counter()]
        names = ("loading", "computing", "pictures and files")
        parts = [f"{name} {end - begin:.1f}" for name, begin, end in zip(names, ends, ends[1:], strict=False)]
        return f"{ends[-1] - ends[0]:.1f} s: {', '.join(parts)} ({n_files} files)"


SHOWN = {
    "quiet": Annotated[
        bool, typer.Option("--quiet", "-q", help="Show only how it ended, warnings, and where the report is.")
    ],
    "as_json": Annotated[bool, typer.Option("--json", help="Print the numbers as JSON, and nothing else.")],
    "no_pictures": Annotated[bool, typer.Option("--no-pictures", help="Draw no pictures; the report has none.")],
    "xlsx": Annotated[bool, typer.Option("--xlsx", help="Write all tables as one workbook too, tables.xlsx.")],
    "units": Units,
}


def shows_results(command: Callable[..., bool]) -> Callable[..., None]:
    """Add the options of `SHOWN` to a command, which gets them as ``show``, and make its result the exit status."""
    signature = inspect.signature(command)
    parameters = [parameter for parameter in signature.parameters.values() if parameter.name != "show"]
    more = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=None if kind is Units else False, annotation=kind
        )
        for name, kind in SHOWN.items()
    ]

    @functools.wraps(command)
    def wrapped(**given: Any) -> None:
        shown = {name: given.pop(name) for name in SHOWN}
        with errors_as_exit_status():
            if shown["xlsx"]:
                spreadsheet_library()  # before anything is computed
            show = Show(**shown | {"units": units_given(shown["units"])})
            raise typer.Exit(DONE if command(**given, show=show) else FAILED)

    wrapped.__signature__ = signature.replace(parameters=[*parameters, *more], return_annotation=None)  # type: ignore[attr-defined]
    wrapped.__annotations__ = {parameter.name: parameter.annotation for parameter in [*parameters, *more]}
    return wrapped


def command_typed() -> str:
    """Return the command as it was typed, without the options of `SHOWN`."""
    shown = {"-q", "--quiet", "--json", "--no-pictures", "--xlsx"}
    return shlex.join(["flangeway", *(word for word in sys.argv[1:] if word not in shown)])


def stdout() -> Any:
    """Return the terminal for results."""
    from rich.console import Console  # noqa: PLC0415

    return Console(highlight=False, markup=False)


def complain(message: str) -> None:
    """Report an error on stderr."""
    typer.echo(f"flangeway: {message}", err=True)
