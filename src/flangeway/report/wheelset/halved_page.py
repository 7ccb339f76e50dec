"""Report of ``flangeway converge``: a wheelset on its mesh and on the mesh halved."""

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from flangeway.cases import Convergence
from flangeway.cases.wheelset.wheelset_case import MAX_APPROACH_CHANGE, MAX_POSITION_CHANGE_MM
from flangeway.cases.wheelset.wheelset_quantities import APPROACH, HALF_WIDTH, ON_RAIL, ON_WHEEL, PRESSURE
from flangeway.quantities import Quantity
from flangeway.report.figures.drawing import GREY, INK, SERIES, Room, figure_with_room
from flangeway.report.page.record import REPORT, Again, Picture, Record
from flangeway.report.page.tables import SummaryTable
from flangeway.report.page.us_record import UNIT_COLUMN

PICTURE, SUMMARY = "halved.png", "converge.json"
NAMES = (PICTURE, REPORT, SUMMARY)
SHOWN = "Relative changes of approach, maximum pressure and half width when the mesh is halved"


def convergence_record(name: str, convergence: Convergence, command: str) -> Record:
    """Return what changed when the mesh was halved, and whether that is within the limits."""
    coarse = convergence.runs[0]
    scales = [run.case.model_dump()["size_scale"] for run in convergence.runs]
    stopped = [run.status.message for run in convergence.runs if not run.status.converged]
    limits = f"approach {100.0 * MAX_APPROACH_CHANGE:g} %, positions {MAX_POSITION_CHANGE_MM:g} mm"
    verdict = "within" if convergence.within else "NOT within"
    return Record(
        name=name,
        title=f"{coarse.case.name}: the mesh halved",
        subtitle=f"Size scale {scales[0]:g} beside {scales[1]:g}",
        converged=convergence.within,
        message="; ".join([*stopped, f"the changes are {verdict} the limits: {limits}"]),
        facts=_convergence_facts(convergence) if convergence.converged else [],
        results=_convergence_table(convergence),
        summary=convergence.to_json(),
        summary_file=SUMMARY,
        again=Again(command, files=f"The same numbers, for programs, are in `{SUMMARY}`."),
        versions=coarse.summary["versions"],
        warnings=[
            f"size scale {scale:g}: {text}"
            for run, scale in zip(convergence.runs, scales, strict=True)
            for text in run.warnings
        ],
        assumptions=coarse.case.assumptions(coarse.result),
        pictures=[Picture(PICTURE, lambda: halved_figure(convergence), f"{SHOWN}.")] if convergence.converged else [],
        timings_s={f"size scale {scale:g}": run.total_s for run, scale in zip(convergence.runs, scales, strict=True)},
    )


def _convergence_facts(convergence: Convergence) -> list[tuple[str, str]]:
    changes = convergence.changes()
    return [
        (f"{100.0 * changes['approach_change']:.2f} %", f"change of the approach, limit {MAX_APPROACH_CHANGE:.0%}"),
        (f"{changes['position_change_mm']:.3f} mm", f"change of positions, limit {MAX_POSITION_CHANGE_MM:g} mm"),
        (f"{100.0 * changes['max_pressure_change']:.2f} %", "change of the maximum pressure"),
        (f"{100.0 * changes['half_width_change']:.2f} %", "change of the half width"),
    ]


def _convergence_table(convergence: Convergence) -> SummaryTable:
    """One row a number of a contact, with both meshes and the change; the last column has the limit."""
    runs, rows = convergence.runs, []

    def row(name: str, quantity: Quantity[Any], of: Sequence[Any], limit: str = "–") -> tuple[str, ...]:
        one, other = (quantity.value(each) for each in of)
        texts = (quantity.texts(each)[0] for each in of)
        return (f"{name}{quantity.labels()[0]}", *texts, f"{100.0 * (other / one - 1.0):+.3f}", "%", limit)

    rows.append(row("", APPROACH, [run.result for run in runs], f"{100.0 * MAX_APPROACH_CHANGE:g}"))
    for pair in convergence.pairs() if convergence.converged else ():
        side = pair[0].patch.side
        for quantity in (ON_RAIL, ON_WHEEL):
            (one, _), (other, _) = (quantity.value(each) for each in pair)
            texts = (quantity.texts(each)[0] for each in pair)
            name = f"{side}: {quantity.labels()[0]}"
            rows.append((name, *texts, f"{other - one:+.3f}", "mm", f"{MAX_POSITION_CHANGE_MM:g}"))
        rows += [row(f"{side}: ", quantity, pair) for quantity in (PRESSURE, HALF_WIDTH)]
    unknowns = [sum(body.stiffness.n for body in run.plane.model.bodies) for run in runs]
    rows.append(("unknowns", *(f"{n:,}" for n in unknowns), "", "", ""))
    scales = [f"size scale {run.case.model_dump()['size_scale']:g}" for run in runs]
    return SummaryTable("The mesh halved", ("", *scales, "change", UNIT_COLUMN, "limit"), tuple(rows))


def halved_figure(convergence: Convergence) -> Figure:
    """Draw the relative changes as bars, beside the limit of the approach."""
    changes = convergence.changes()
    names = {
        "approach_change": "approach",
        "max_pressure_change": "maximum pressure",
        "half_width_change": "half width",
    }
    figure, ((axes,),) = figure_with_room(9.0, 2.2, Room(left=1.6, top=0.15))
    values = [100.0 * changes[key] for key in names]
    axes.barh(list(names.values()), values, color=SERIES[0], height=0.55)
    for place, value in enumerate(values):
        axes.annotate(f"{value:.3g} %", (value, place), (4.0, 0.0), textcoords="offset points", va="center", color=INK)
    axes.plot([100.0 * MAX_APPROACH_CHANGE] * 2, [-0.4, 0.4], color=INK, lw=1.5, label="limit of the approach")
    axes.set_xlim(0.0, 1.2 * max(*values, 100.0 * MAX_APPROACH_CHANGE))
    axes.invert_yaxis()
    axes.set_xlabel("change in %")
    axes.grid(axis="x", color=GREY, lw=0.3)
    axes.legend(loc="lower right", fontsize=8, frameon=False)
    return figure
