"""The readable summary on the terminal."""

import re
from pathlib import Path
from typing import Any

from rich.console import Console

from flangeway.cases import Convergence
from flangeway.report.page.console import plain_table, print_files, print_notices, print_status
from flangeway.report.page.page_tables import (
    Table,
    bending_table,
    bodies_table,
    contacts_table,
    marked,
    motion_table,
    number,
    stresses_table,
)


def print_summary(console: Console, summary: dict[str, Any], files: list[Path]) -> None:
    """Print status, position, contacts, stresses, warnings, assumptions in short, and the files."""
    print_status(console, summary["case"]["name"], summary["status"])
    contacts = (contacts_table,) if summary["contacts"] else ()
    for table in (motion_table, *contacts):
        _print_table(console, table(summary))
    _print_table(console, bending_table(summary, short=True))
    for table in (stresses_table, bodies_table):
        _print_table(console, table(summary))
    print_notices(console, summary["warnings"], "Warning")
    short = [re.split(r"[:;.](?: |$)", sentence)[0] for sentence in summary["assumptions"]]
    console.print(f"Assumed: {'; '.join(short)}.", markup=False)
    print_files(console, files, summary["timings_s"]["total"])


def print_convergence(console: Console, convergence: Convergence, file: Path) -> None:
    """Print what changed when the mesh was halved, and whether it is little enough."""
    for summary in convergence.summaries:
        if not summary["status"]["converged"]:
            print_status(console, summary["case"]["name"], summary["status"])
    if convergence.converged:
        _print_table(console, _convergence_table(convergence))
    verdict = "within" if convergence.within else "NOT within"
    limits = convergence.to_json()["limits"]
    console.print(
        f"The changes are {verdict} the limits: approach {100.0 * limits['approach_change']:g} %, "
        f"positions {limits['position_change_mm']:g} mm.",
        style="green" if convergence.within else "red",
        markup=False,
    )
    console.print(f"File: {file}", markup=False, soft_wrap=True)


def _convergence_table(convergence: Convergence) -> Table:
    coarse, fine = convergence.summaries
    changes = convergence.changes()

    def percent(key: str) -> str:
        return f"{100.0 * changes[key]:.3f} %"

    def contact(summary: dict[str, Any], key: str, digits: int) -> str:
        return " / ".join(number(c[key], digits) for c in summary["contacts"])

    def place(summary: dict[str, Any], key: str) -> str:
        return " / ".join(number(c[key][0], 3) for c in summary["contacts"])

    shift = f"{changes['position_change_mm']:.3f} mm"
    rows = [
        (
            "approach, mm",
            *(number(s["motion"]["approach_mm"], 5) for s in (coarse, fine)),
            percent("approach_change"),
        ),
        *(
            (f"x on the {body}, mm", place(coarse, key), place(fine, key), shift)
            for body, key in (("rail", "rail_position_mm"), ("wheel", "wheel_position_mm"))
        ),
        (
            "maximum pressure, MPa",
            *(
                " / ".join(marked(number(c["max_pressure_MPa"], 1), c["max_pressure_remark"]) for c in s["contacts"])
                for s in (coarse, fine)
            ),
            percent("max_pressure_change"),
        ),
        (
            "half width, mm",
            *(contact(s, "half_width_mm", 3) for s in (coarse, fine)),
            percent("half_width_change"),
        ),
        ("unknowns", *(f"{sum(b['unknowns'] for b in s['bodies']):,}" for s in (coarse, fine)), ""),
    ]
    scales = [f"size scale {s['case']['size_scale']:g}" for s in (coarse, fine)]
    return Table("The mesh halved (left / right)", ("", *scales, "maximum change"), tuple(rows))


def _print_table(console: Console, table: Table) -> None:
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
