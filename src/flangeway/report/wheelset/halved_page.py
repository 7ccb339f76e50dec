"""Report of ``flangeway converge``: a wheelset on its mesh and on the mesh halved."""

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from flangeway.cases import Convergence
from flangeway.cases.wheelset.wheelset_case import MAX_APPROACH_CHANGE, MAX_POSITION_CHANGE_MM
from flangeway.cases.wheelset.wheelset_quantities import APPROACH, HALF_WIDTH, ON_RAIL, ON_WHEEL, PRESSURE
from flangeway.quantities import Quantity, measured
from flangeway.report.figures.drawing import INK, SERIES, name_axes, panels
from flangeway.report.page.record import REPORT, Again, Picture, Record
from flangeway.report.page.tables import SummaryTable

PICTURE, SUMMARY = "halved.png", "converge.json"
NAMES = (PICTURE, REPORT, SUMMARY)
SHOWN_CHANGES = ("approach", "max pressure", "half width")
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
        units=coarse.case.units,
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
    changes, units = convergence.changes(), convergence.runs[0].case.units
    position, limit = (
        measured(value, "mm", units, ".3f") for value in (changes["position_change_mm"], MAX_POSITION_CHANGE_MM)
    )
    return [
        (f"{100.0 * changes['approach_change']:.2f} %", f"change of the approach, limit {MAX_APPROACH_CHANGE:.0%}"),
        (position, f"change of positions, limit {limit}"),
        (f"{100.0 * changes['max_pressure_change']:.2f} %", "change of the maximum pressure"),
        (f"{100.0 * changes['half_width_change']:.2f} %", "change of the half width"),
    ]


def _convergence_table(convergence: Convergence) -> SummaryTable:
    """One row a number of a contact, with both meshes and the change; the last column has the limit."""
    runs, units = convergence.runs, convergence.runs[0].case.units
    rows: list[tuple[str, ...]] = []

    def add(side: str, quantity: Quantity[Any], of: Sequence[Any], limit: str = "–") -> None:
        one, other = (quantity.each(source)[0] for source in of)
        change, texts = f"{100.0 * (other / one - 1.0):+.3f} %", (quantity.texts(source, units)[0] for source in of)
        if quantity.parts:
            change, limit = (
                measured(value, "mm", units, form)
                for value, form in ((other - one, "+.3f"), (MAX_POSITION_CHANGE_MM, ".3f"))
            )
        rows.append((f"{side}{quantity.labels(units)[0]}", *texts, change, limit))

    add("", APPROACH, [run.result for run in runs], f"{100.0 * MAX_APPROACH_CHANGE:g} %")
    for pair in convergence.pairs() if convergence.converged else ():
        for quantity in (ON_RAIL, ON_WHEEL, PRESSURE, HALF_WIDTH):
            add(f"{pair[0].patch.side}: ", quantity, pair)
    unknowns = [sum(body.stiffness.n for body in run.plane.model.bodies) for run in runs]
    rows.append(("unknowns", *(f"{n:,}" for n in unknowns), "", ""))
    scales = [f"size scale {run.case.model_dump()['size_scale']:g}" for run in runs]
    return SummaryTable("The mesh halved", ("", *scales, "change", "limit"), tuple(rows))


def halved_figure(convergence: Convergence) -> Figure:
    """Draw the relative changes as bars, beside the limit of the approach."""
    changes = convergence.changes()
    values = [100.0 * changes[f"{name.replace(' ', '_')}_change"] for name in SHOWN_CHANGES]
    figure, ((axes,),) = panels(9.0, 2.2)
    axes.barh([name.replace("max ", "maximum ") for name in SHOWN_CHANGES], values, color=SERIES[0], height=0.55)
    for place, value in enumerate(values):
        axes.annotate(f"{value:.3g} %", (value, place), (4.0, 0.0), textcoords="offset points", va="center", color=INK)
    axes.plot([100.0 * MAX_APPROACH_CHANGE] * 2, [-0.4, 0.4], color=INK, lw=1.5, label="limit of the approach")
    axes.set_xlim(0.0, 1.2 * max(*values, 100.0 * MAX_APPROACH_CHANGE))
    axes.invert_yaxis()
    name_axes(axes, ("change", "%"))
    axes.legend(loc="lower right", fontsize=8, frameon=False)
    return figure
