"""Report of ``flangeway converge``: a wheelset on its mesh and on the mesh halved."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from flangeway.cases import Convergence
from flangeway.cases.wheelset.wheelset_case import MAX_APPROACH_CHANGE, MAX_POSITION_CHANGE_MM
from flangeway.report.figures.drawing import GREY, INK, SERIES, Room, figure_with_room
from flangeway.report.page.record import REPORT, Again, Picture, Record
from flangeway.report.page.tables import SummaryTable, number
from flangeway.report.page.us_record import UNIT_COLUMN

PICTURE, SUMMARY = "halved.png", "converge.json"
NAMES = (PICTURE, REPORT, SUMMARY)
SHOWN = "Relative changes of approach, maximum pressure and half width when the mesh is halved"


def convergence_record(name: str, convergence: Convergence, command: str) -> Record:
    """Return what changed when the mesh was halved, and whether that is within the limits."""
    coarse, fine = convergence.summaries
    stopped = [each.status.message for each in convergence.summaries if not each.status.converged]
    limits = f"approach {100.0 * MAX_APPROACH_CHANGE:g} %, positions {MAX_POSITION_CHANGE_MM:g} mm"
    verdict = "within" if convergence.within else "NOT within"
    return Record(
        name=name,
        title=f"{coarse.case['name']}: the mesh halved",
        subtitle=f"Size scale {coarse.case['size_scale']:g} beside {fine.case['size_scale']:g}",
        converged=convergence.within,
        message="; ".join([*stopped, f"the changes are {verdict} the limits: {limits}"]),
        facts=_convergence_facts(convergence) if convergence.converged else [],
        results=_convergence_table(convergence),
        summary=convergence.to_json(),
        summary_file=SUMMARY,
        again=Again(command, files=f"The same numbers, for programs, are in `{SUMMARY}`."),
        versions=coarse.versions,
        warnings=[
            text if text in coarse.warnings and text in fine.warnings else f"size scale {scale:g}: {text}"
            for text, scale in {
                text: each.case["size_scale"] for each in (fine, coarse) for text in each.warnings
            }.items()
        ],
        assumptions=coarse.assumptions,
        pictures=[Picture(PICTURE, lambda: halved_figure(convergence), f"{SHOWN}.")] if convergence.converged else [],
        timings_s={
            f"size scale {each.case['size_scale']:g}": each.timings_s["total"] for each in convergence.summaries
        },
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
    both = convergence.summaries

    def row(
        name: str, values: Sequence[float], digits: int, limit: str = "–", *, relative: bool = True
    ) -> tuple[str, ...]:
        change = values[1] / values[0] - 1.0 if relative else values[1] - values[0]
        change *= 100.0 if relative else 1.0
        return (name, *(number(value, digits) for value in values), f"{change:+.3f}", "%" if relative else "mm", limit)

    shift = f"{MAX_POSITION_CHANGE_MM:g}"
    approach = [each.position.approach_mm for each in both]
    rows = [row("approach, mm", approach, 5, f"{100.0 * MAX_APPROACH_CHANGE:g}")]
    for coarse, fine in convergence.pairs() if convergence.converged else ():
        pair, name = (coarse, fine), coarse.side
        rows += [
            row(f"{name}: x on the rail, mm", [each.rail_position_mm[0] for each in pair], 3, shift, relative=False),
            row("  x on the wheel, mm", [each.wheel_position_mm[0] for each in pair], 3, shift, relative=False),
            row("  maximum pressure, MPa", [each.max_pressure_MPa for each in pair], 1),
            row("  half width, mm", [each.half_width_mm for each in pair], 3),
        ]
    rows.append(("unknowns", *(f"{sum(body.unknowns for body in each.bodies):,}" for each in both), "", "", ""))
    scales = [f"size scale {each.case['size_scale']:g}" for each in both]
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
