"""``flangeway run``, ``check``, ``init``, ``schema``, ``converge``, ``compare`` and ``cases``."""

import inspect
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flangeway.cli.app import app
from flangeway.cli.common import (
    PROFILE_FILES,
    Out,
    Set,
    Show,
    Units,
    case_names,
    choices,
    command_typed,
    completion,
    errors_as_exit_status,
    path_given,
    profile_names,
    progress_shown,
    results_folder,
    settings_of,
    shows_results,
    stdout,
    units_given,
)
from flangeway.errors import InputError

if TYPE_CHECKING:
    from flangeway.cases.case import RunnableCase

CaseWork = Callable[..., bool]
"""Work on the case of a name or file, with a folder for the results, shown in some way; whether it ended well.

It takes the name, the case, the folder and how it is shown, and has options of its own as keywords."""


def _command_on_a_case(work: CaseWork) -> CaseWork:
    """Add a command that takes a case with its options and those of its work, whose exit status it has."""

    def command(
        case: Annotated[
            str,
            typer.Argument(
                metavar="CASE_OR_FILE",
                help="Name of a case (`flangeway cases` lists them), or a case file.",
                autocompletion=completion(case_names, ".toml"),
            ),
        ],
        # text, not numbers or choices: the case checks all values, with one kind of message
        wheel: Annotated[
            str | None,
            typer.Option(
                "--wheel",
                metavar="NAME_OR_FILE",
                help="Wheel of a wheelset: bundled, or a measured profile.",
                autocompletion=completion(lambda: profile_names("wheel"), *PROFILE_FILES),
            ),
        ] = None,
        rail: Annotated[
            str | None,
            typer.Option(
                "--rail",
                metavar="NAME_OR_FILE",
                help="Rail of a wheelset: bundled, or a measured profile.",
                autocompletion=completion(lambda: profile_names("rail"), *PROFILE_FILES),
            ),
        ] = None,
        method: Annotated[
            str | None,
            typer.Option("--method", help="Triangles, or polygons with virtual elements.", **choices("fem", "vem")),
        ] = None,
        order: Annotated[
            str | None,
            typer.Option("--order", help="Order of the elements of a case.", **choices("1", "2")),
        ] = None,
        size_scale: Annotated[
            str | None,
            typer.Option("--size-scale", metavar="NUMBER", help="Factor on all element sizes; 0.5 halves them."),
        ] = None,
        primary: Annotated[
            str | None,
            typer.Option("--primary", help="Bodies with the primary surface.", **choices("auto", "rail", "wheel")),
        ] = None,
        set_: Set = None,
        out: Out = None,
        *,
        show: Show,
        **further: bool,
    ) -> bool:
        named = {
            "wheel": wheel,
            "rail": rail,
            "method": method,
            "order": order,
            "size_scale": size_scale,
            "primary": primary,
        }
        inputs = _case(case, set_, **named, units=show.units)
        return work(case, inputs, out, replace(show, units=inputs.units), **further)

    shared, own = inspect.signature(command), inspect.signature(work).parameters.values()
    options = [option for option in own if option.kind is option.KEYWORD_ONLY]
    shared = shared.replace(parameters=[*list(shared.parameters.values())[:-1], *options])
    command.__signature__ = shared  # type: ignore[attr-defined]
    app.command(work.__name__, help=work.__doc__)(shows_results(command))
    return work


@_command_on_a_case
def run(
    name: str,
    case: "RunnableCase",
    out: Path | None,
    show: Show,
    *,
    whole_sections: Annotated[
        bool,
        typer.Option("--whole-sections", help="Write stresses in whole sections of rails and wheels too (VTU)."),
    ] = False,
) -> bool:
    """Run a case or a case file: results here; report, JSON, pictures and ParaView files in a folder (out/CASE)."""
    from flangeway.report.case_outputs import case_record  # noqa: PLC0415

    if whole_sections:
        case.check_sections()
    folder = results_folder(out, Path(name).stem)
    with show.progress() as progress:
        done = case.run(progress)
    return show.record(case_record(done), folder, whole_sections=whole_sections)


@_command_on_a_case
def converge(name: str, case: "RunnableCase", out: Path | None, show: Show) -> bool:
    """Run a case with its sizes of elements and cells and with half of them, and compare (out/CASE-converge)."""
    from flangeway.cases import run_halved  # noqa: PLC0415
    from flangeway.report.page.html_page import convergence_record  # noqa: PLC0415

    stem = Path(name).stem
    folder = results_folder(out, f"{stem}-converge")
    with show.progress() as progress:
        convergence = run_halved(case, progress)
    return show.record(convergence_record(stem, convergence, command_typed()), folder)


@app.command()
@shows_results
def compare(
    first: Annotated[Path, typer.Argument(metavar="RESULTS", help="Folder of results, such as out/wheelset.")],
    second: Annotated[Path, typer.Argument(metavar="OTHERS", help="Folder of the results to compare with.")],
    out: Out = None,
    *,
    show: Show,
) -> bool:
    """Compare two runs: inputs and results that differ, with their changes (out/compare)."""
    from flangeway.report.comparison import comparison_record  # noqa: PLC0415

    return show.record(comparison_record(first, second, command_typed()), results_folder(out, "compare"))


@app.command()
def cases(
    case: Annotated[
        str | None,
        typer.Argument(
            metavar="[CASE]",
            help="The one to explain; all if left out.",
            autocompletion=completion(case_names),
        ),
    ] = None,
    units: Units = None,
) -> None:
    """List the cases, or the inputs of one, with defaults and what is allowed."""
    with errors_as_exit_status():
        from rich.table import Column, Table  # noqa: PLC0415

        from flangeway.cases import CASES, find_case  # noqa: PLC0415
        from flangeway.cases.case_file import CASE_FILES, file_title  # noqa: PLC0415
        from flangeway.cases.rigid_run import GeometryCase  # noqa: PLC0415

        console = stdout()
        if case is None:
            titles = {kind.name: kind.title for kind in CASES.values()} | {
                name: file_title(name) for name in CASE_FILES
            }
            width = max(map(len, titles)) + 1
            for name, title in titles.items():
                console.print(f"{name:{width}}{title}", soft_wrap=True)
            console.print("`flangeway cases NAME` lists the inputs of one of them.")
            return
        kind = GeometryCase if case == GeometryCase.name else find_case(case)
        system = units_given(units) or "metric"
        if case in CASE_FILES:
            note = f"a case file of {kind.name}, `flangeway init {case}` writes it"
            console.print(f"{case}: {file_title(case)}; {note}", soft_wrap=True)
        console.print(f"{kind.name}: {kind.title}", style="bold")
        for path, rows in kind.tables_of_inputs(system):
            console.print(f"\n{path}" if path else "", style="bold")
            table = Table(Column(no_wrap=True), "", box=None, pad_edge=False, show_header=False)
            for key, default, allow, meaning in rows:
                given = "" if default == "none" else f" [default: {default}]" * (default != "needed")
                table.add_row(key, f"{meaning}; {allow}{given}", style="bold" if default == "needed" else None)
            console.print(table)


@app.command()
def init(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="Name of a case; `flangeway cases` lists them. With --python also a case file.",
            autocompletion=completion(case_names, ".toml"),
        ),
    ],
    to: Annotated[
        Path | None,
        typer.Option(
            "--to", metavar="FILE", help="The file; NAME.toml if left out, with --python NAME.py.", parser=path_given
        ),
    ] = None,
    units: Units = None,
    python: Annotated[
        bool, typer.Option("--python", help="Write a Python script with the inputs of the case that are no defaults.")
    ] = False,
) -> None:
    """Write a case file to begin with: every key with its meaning, unit, range and default; or a Python script."""
    with errors_as_exit_status():
        from flangeway.cases import find_case, load_case, write_template  # noqa: PLC0415
        from flangeway.cases.case_file import CASE_FILES, CASES, write_python  # noqa: PLC0415
        from flangeway.system.output_folder import write_text  # noqa: PLC0415

        system = units_given(units) or "metric"
        if python:
            if system == "us":
                raise InputError("--units us with --python", "scripts in metric units", "leave --units out")
            case = CASES[name].from_values(CASES[name].example) if name in CASES else load_case(name)
            text = f"{write_python(case)}\nprint(case.run())\n"
        elif name in CASE_FILES:
            if system == "us":
                raise InputError(
                    f"--units us with {name}, a file with metric keys",
                    "--units us with the cases of `flangeway cases` that are no files",
                    f"leave it out; `flangeway run {name} --units us` shows results in US units",
                )
            text = CASE_FILES[name].read_text(encoding="utf-8")
        else:
            text = write_template(find_case(name), system)
        file = to or (Path(f"{Path(name).stem}.py") if python else Path(f"{name}.toml"))
        if os.path.lexists(file):
            raise InputError(
                f"file {file}, which is there already",
                "the name of a new file",
                "choose another name with --to, or remove it",
            )
        write_text(file, text)
        stdout().print(f"{file}: edit it, then {'python' if python else 'flangeway run'} {file}", soft_wrap=True)


@app.command()
def check(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A case file (.toml), or the name of a case.",
            autocompletion=completion(case_names, ".toml"),
        ),
    ],
    set_: Set = None,
) -> None:
    """Check a case file without computing: keys, values, ranges, files, shapes; mistakes are named with their line."""
    with errors_as_exit_status():
        inputs = _case(str(file), set_)
        given = len(inputs.model_fields_set)
        stdout().print(
            f"{file}: a case {inputs.name} with {given} input{'s' * (given != 1)}; nothing is wrong. Compute it with "
            f"flangeway run {file}",
            soft_wrap=True,
        )


@app.command()
def schema(
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="Name of a case.", autocompletion=completion(case_names)),
    ] = "wheelset",
    to: Annotated[
        Path | None,
        typer.Option("--to", metavar="FILE", help="Write it to this file.", parser=path_given),
    ] = None,
) -> None:
    """Print the JSON Schema of the files of a case, with which editors complete keys and mark mistakes."""
    with errors_as_exit_status():
        import json  # noqa: PLC0415

        from flangeway.cases.case_file import find_case  # noqa: PLC0415
        from flangeway.cases.case_file import schema as case_schema  # noqa: PLC0415
        from flangeway.system.output_folder import write_text  # noqa: PLC0415

        text = json.dumps(case_schema(find_case(name)), indent=2, ensure_ascii=False) + "\n"
        if to is None:
            typer.echo(text, nl=False)
            return
        write_text(to, text)
        stdout().print(f"{to}: name it in the first line of a case file, #:schema {to}", soft_wrap=True)


def _case(name: str, settings: list[str] | None, **options: str | None) -> "RunnableCase":
    """Return the case with the options that are given, by key, checked as far as possible before computing."""
    from flangeway.cases.case_file import check_case, is_case_file, read_case  # noqa: PLC0415
    from flangeway.records import GivenText  # noqa: PLC0415

    given: dict[str, Any] = {key: GivenText(value) for key, value in options.items() if value is not None}
    given |= settings_of(settings, f"`flangeway cases{'' if is_case_file(name) else f' {name}'}` lists the keys")
    case = read_case(name, given)
    with progress_shown():  # of long meshes of shapes
        check_case(case, name if is_case_file(name) else None)
    return case
