"""Report of ``flangeway converge``: a case with its sizes and with half of them."""

from flangeway.cases import Convergence
from flangeway.report.page.record import Again, Record
from flangeway.report.page.tables import SummaryTable
from flangeway.results import ResultTable
from flangeway.units import joined, sentence, shown, unit_in, with_unit

SUMMARY = "converge.json"


def convergence_record(name: str, convergence: Convergence, command: str) -> Record:
    """Return how much each number of a case changes when its sizes are halved."""
    case, runs = convergence.case, convergence.runs
    stopped = [run.status.message for run in runs if not run.status.converged]
    sizes = joined(
        ", ",
        (
            sentence("{} {} and {}", key, *(with_unit(size, f"({unit_in(key)})") for size in both))
            for key, both in convergence.sizes.items()
        ),
    )
    parts = ("given sizes", "half of the sizes")
    return Record(
        name=name,
        title=f"{case.report_title or case.name}: the sizes halved",
        subtitle="Two runs: " + sizes,
        converged=convergence.converged,
        message=joined("; ", stopped),
        results=_changes(convergence),
        summary=convergence.to_json(),
        summary_file=SUMMARY,
        again=Again(command, files=f"The same numbers, for programs, are in `{SUMMARY}`."),
        units=case.units,
        warnings=[f"{part}: " + text for part, run in zip(parts, runs, strict=True) for text in case.warnings_of(run)],
        timings_s={part: sum(run.summary["timings_s"].values()) for part, run in zip(parts, runs, strict=True)},
    )


def _changes(convergence: Convergence) -> SummaryTable:
    """One row for each number: both values, the change, and that over the first value where it is not above it."""
    both = {key: list(values) for key, values in convergence.numbers.items()}
    table = ResultTable(both).in_units(convergence.case.units)
    rows = []
    for key, (coarse, fine) in table.columns.items():
        over = f"{100.0 * (fine - coarse) / abs(coarse):+.2f}" if abs(fine - coarse) < abs(coarse) else "–"
        rows.append((key, shown(coarse), shown(fine), f"{fine - coarse:+.2g}", over))
    return SummaryTable("Sizes halved", ("", "given", "half", "change", "change, %"), tuple(rows))
