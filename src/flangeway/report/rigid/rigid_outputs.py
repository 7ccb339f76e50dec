"""Record and files of ``flangeway geometry``."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flangeway.cases.rigid.rigid_run import (
    CONICITY_QUANTITIES,
    CONTACT_QUANTITIES,
    POSITION_QUANTITIES,
    ConicityRun,
    GeometryRun,
)
from flangeway.quantities import Quantities, Quantity, columns, of_part
from flangeway.railway.rigid.rigid_locus import ContactJump
from flangeway.report.page.case_text import input_rows
from flangeway.report.page.record import Again, Picture, Record
from flangeway.report.page.tables import SummaryTable, rows_of, table_across, table_of, with_whole
from flangeway.report.rigid.rigid_figures import conicity_figure, locus_figure, pairs_figure
from flangeway.units import Units, sentence

TABLE, CONICITY, SUMMARY = "table.csv", "conicity.csv", "geometry.json"
CONICITY_PICTURE = "conicity.png"
BATCH_TABLE, BATCH_SUMMARY = "geometries.csv", "geometries.json"
LOCUS_SHOWN = (
    "Contact points at each millimetre, rolling radius difference and contact angles over the lateral position"
)
CONICITY_SHOWN = "Equivalent conicity versus amplitude"
AXES = {
    "lateral, vertical": "of the axle in space, to the right and up, from the middle of the track",
    "x": "on the wheel from the tape line, on the rail from its middle, away from the middle of the track",
    "L/V": "lateral over vertical force of a wheel, positive where it pushes its rail outwards; without friction",
}
ASSUMPTIONS = (
    "Rigid wheels on rigid rails: the points of contact are those of the profiles as they are.",
    "Hertz's values are of a line contact of the rigid equilibrium's force and curvatures.",
)


PAIR_QUANTITIES: Quantities[Any] = (
    Quantity("wheel", "wheel", lambda run: Path(run.case.wheel).name),
    Quantity("rail", "rail", lambda run: Path(run.case.rail).name),
    *CONICITY_QUANTITIES,
    *(of_part("equilibrium.position", quantity) for quantity in POSITION_QUANTITIES),
    Quantity("jumps", "contact jumps", lambda run: len(run.jumps), form="d"),
    Quantity("status", "status", lambda run: "converged" if run.equilibrium.status.converged else "not converged"),
)
"""Numbers of a pair of profiles."""


JUMP: Quantities[ContactJump] = (
    Quantity("side", "side", "side"),
    Quantity("lateral", "lateral displacement", "motion.lateral_mm", "mm", ".3f"),
    Quantity(
        "rail_x", "x on the rail", lambda jump: [x for x, _ in jump.rail_points_mm], "mm", ".2f", ("before", "after")
    ),
)
"""Numbers of a jump of the point of contact."""


def geometry_record(run: GeometryRun, command: str) -> Record:
    """Return what was found of the contact geometry; `command` computes it again."""
    summary, position, units = run.summary, run.equilibrium.position, run.case.units
    facts = [quantity.fact(position, units) for quantity in POSITION_QUANTITIES[::3]] if position else []
    jumps = table_of("Jumps of the point of contact", run.jumps, JUMP, units=units)
    inputs = tuple(input_rows(summary["inputs"], units))
    return Record(
        **_common(summary, command, units, (SUMMARY, TABLE, CONICITY)),
        subtitle=f"Rigid wheels {run.case.wheel} on rigid rails {run.case.rail}",
        converged=run.equilibrium.status.converged,
        message=run.equilibrium.status.message,
        facts=[*facts, *_conicity_facts(run)],
        results=_results(run),
        assumptions=ASSUMPTIONS,
        pictures=[
            Picture("contact_locus.png", lambda: locus_figure(run), f"{LOCUS_SHOWN}."),
            Picture(CONICITY_PICTURE, lambda: conicity_figure(run, units), f"{CONICITY_SHOWN}."),
        ],
        tables=[jumps] if run.jumps else [],
        axes=AXES,
        inputs=[SummaryTable("Inputs", ("", "value"), inputs, of_words=True)],
        files=lambda: {TABLE: run.table.in_units(units).to_csv, CONICITY: run.conicities.table.in_units(units).to_csv},
    )


def geometries_record(runs: Sequence[GeometryRun], command: str) -> Record:
    """Return conicity and equilibrium of several pairs of profiles side by side; `command` computes them again."""
    units = runs[0].case.units
    return Record(
        **_common(runs[0].summary, command, units, (BATCH_SUMMARY, BATCH_TABLE))
        | {
            "summary": {"pairs": [run.summary for run in runs]},
            "summary_file": BATCH_SUMMARY,
            "title": f"{len(runs)} pairs of profiles",
            "notes": list(dict.fromkeys(notice for run in runs for notice in run.summary["notices"])),
            "timings_s": {"total": sum(run.summary["timings_s"]["total"] for run in runs)},
        },
        subtitle=f"{len(runs)} pairs of rigid wheels and rails",
        converged=all(run.equilibrium.status.converged for run in runs),
        message="",
        results=table_of("Pairs of profiles", runs, [PAIR_QUANTITIES[at] for at in (0, 1, 2, 4, 7, 8)], units=units),
        assumptions=ASSUMPTIONS,
        pictures=[
            Picture(
                "geometries.png",
                lambda: pairs_figure(runs),
                "Rolling radius difference and equivalent conicity of all pairs.",
            )
        ],
        axes=AXES,
        files=lambda: {BATCH_TABLE: columns(PAIR_QUANTITIES, runs, units).to_csv},
    )


def conicity_record(run: ConicityRun, command: str, units: Units = "metric") -> Record:
    """Return what was found of a rolling radius difference from a file; `command` computes it again."""
    summary = run.summary
    middle: Quantity[ConicityRun] = Quantity(
        "centred",
        "lateral position without a difference of the radii",
        lambda of: of.summary["lateral_without_difference_mm"],
        "mm",
        "z.3f",
    )
    return Record(
        **_common(summary, command, units, (SUMMARY, CONICITY)),
        subtitle=summary["inputs"]["file"],
        converged=True,
        success="computed",
        message=f"at {len(run.conicities.amplitudes_mm)} amplitudes"
        if summary["equivalent_conicity"]
        else sentence("without a conicity at {3 mm}, see the notes"),
        facts=_conicity_facts(run),
        results=table_across("Conicity", ("value",), [run], (middle, *CONICITY_QUANTITIES), units=units),
        pictures=[Picture(CONICITY_PICTURE, lambda: conicity_figure(run, units), f"{CONICITY_SHOWN}.")],
        files=lambda: {CONICITY: run.conicities.table.in_units(units).to_csv},
    )


def _common(summary: dict[str, Any], command: str, units: Units, files: tuple[str, ...]) -> dict[str, Any]:
    """Return what both records have from their summaries."""
    return {
        "name": summary["case"],
        "title": summary["title"],
        "summary": summary,
        "summary_file": SUMMARY,
        "again": Again(command, files=f"Numbers for programs and spreadsheets: {', '.join(f'`{f}`' for f in files)}."),
        "units": units,
        "notes": summary["notices"],
        "timings_s": summary["timings_s"],
    }


def _conicity_facts(run: GeometryRun | ConicityRun) -> list[tuple[str, str]]:
    return [CONICITY_QUANTITIES[0].fact(run)] if run.summary["equivalent_conicity"] else []


def _results(run: GeometryRun) -> SummaryTable:
    """Position and conicity, and the points of contact, one column each."""
    units, sides = run.case.units, [contact.point.side for contact in run.contacts]
    table = table_across("Results", sides, run.contacts, CONTACT_QUANTITIES[1:], units=units)
    return with_whole(table, dict(rows_of(PAIR_QUANTITIES[2:-1], run, units)), sides)
