"""The readable summary on the terminal."""

import re
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from flangeway.cases import CaseRun, Convergence
from flangeway.cases.convergence import MAX_APPROACH_CHANGE, MAX_POSITION_CHANGE_MM
from flangeway.cases.wheelset.wheelset_summary import ContactSummary
from flangeway.report.page.console import plain_table, print_files, print_notices, print_status
from flangeway.report.page.page_tables import (
    SummaryTable,
    bending_table,
    bodies_table,
    contacts_table,
    marked,
    number,
    position_table,
    stresses_table,
)


def print_summary(console: Console, run: CaseRun, files: list[Path]) -> None:
    """Print status, position, contacts, stresses, warnings, assumptions in short, and the files."""
    summary = run.summary
    print_status(console, run.case.name, run.status)
    contacts = (contacts_table,) if summary.contacts else ()
    for table in (position_table, *contacts):
        _print_table(console, table(summary))
    _print_table(console, bending_table(summary, short=True))
    for table in (stresses_table, bodies_table):
        _print_table(console, table(summary))
    print_notices(console, summary.warnings, "Warning")
    short = [re.split(r"[:;.](?: |$)", sentence)[0] for sentence in summary.assumptions]
    console.print(f"Assumptions: {'; '.join(short)}.", markup=False)
    print_files(console, files, summary.timings_s["total"])


def print_convergence(console: Console, convergence: Convergence, file: Path) -> None:
    """Print what changed when the mesh was halved, and whether that is within the limits."""
    for summary in convergence.summaries:
        if not summary.status.converged:
            print_status(console, summary.case["name"], summary.status)
    if convergence.converged:
        _print_table(console, _convergence_table(convergence))
    verdict = "within" if convergence.within else "NOT within"
    console.print(
        f"The changes are {verdict} the limits: approach {100.0 * MAX_APPROACH_CHANGE:g} %, "
        f"positions {MAX_POSITION_CHANGE_MM:g} mm.",
        style="green" if convergence.within else "red",
        markup=False,
    )
    console.print(f"File: {file}", markup=False, soft_wrap=True)


def _convergence_table(convergence: Convergence) -> SummaryTable:
    both, changes = convergence.summaries, convergence.changes()

    def row(name: str, text: Callable[[ContactSummary], str], change: str) -> tuple[str, ...]:
        return name, *(" / ".join(text(c) for c in each.contacts) for each in both), change

    shift = f"{changes['position_change_mm']:.3f} mm"
    percent = {key: f"{100.0 * change:.3f} %" for key, change in changes.items()}
    rows = (
        ("approach, mm", *(number(each.position.approach_mm, 5) for each in both), percent["approach_change"]),
        row("x on the rail, mm", lambda c: number(c.rail_position_mm[0], 3), shift),
        row("x on the wheel, mm", lambda c: number(c.wheel_position_mm[0], 3), shift),
        row(
            "maximum pressure, MPa",
            lambda c: marked(number(c.max_pressure_MPa, 1), c.max_pressure_remark),
            percent["max_pressure_change"],
        ),
        row("half width, mm", lambda c: number(c.half_width_mm, 3), percent["half_width_change"]),
        ("unknowns", *(f"{sum(body.unknowns for body in each.bodies):,}" for each in both), ""),
    )
    scales = [f"size scale {each.case['size_scale']:g}" for each in both]
    return SummaryTable("The mesh halved (left / right)", ("", *scales, "maximum change"), rows)


def _print_table(console: Console, table: SummaryTable) -> None:
    # a single column of values needs no header
    shown = plain_table()
    shown.show_header = any(table.header[2:])
    for place, name in enumerate(table.header):
        shown.add_column(name, justify="left" if place == 0 else "right")
    for row in table.rows:
        shown.add_row(*row)
    console.print(table.caption, style="bold")
    console.print(shown)
    console.print()
