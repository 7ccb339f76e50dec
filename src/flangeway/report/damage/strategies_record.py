"""Strategies side by side: how far each goes, what it wears, and the profiles that it ends with."""

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from flangeway.cases.damage.damage_file import DamageInputs
from flangeway.railway.damage.evolution import EvolutionStep
from flangeway.report.damage.damage_record import STEPS_CSV, row_quantities
from flangeway.report.figures.drawing import legend_below, name_axes, new_figure
from flangeway.report.page.record import Again, Picture, Record
from flangeway.report.page.tables import table_across
from flangeway.results import ResultTable
from flangeway.system.output_folder import text_writer
from flangeway.system.versions import versions
from flangeway.units import Units

PICTURE = "strategies.png"
CAPTION = "Depth of wear at the end of each strategy, and worn area over the distance."


def strategies_record(
    strategies: Mapping[str, DamageInputs],
    runs: Mapping[str, tuple[Sequence[EvolutionStep], Record]],
    command: str,
    units: Units,
) -> Record:
    """Return the comparison of strategies.

    - `strategies`: inputs of each by its name, the first those of the file as it is.
    - `runs`: steps and record of each.
    - `command`: runs it again.
    """
    name = next(iter(strategies))
    records = {strategy: record for strategy, (_, record) in runs.items()}
    unit = next(iter(records.values())).summary["unit"]
    rows = [record.summary["steps"][-1] for record in records.values()]
    steps = [{"strategy": each} | row for each, record in records.items() for row in record.summary["steps"]]
    keys = dict.fromkeys(key for row in rows for key in row)
    return Record(
        name=name,
        title=f"{name}: strategies side by side",
        subtitle=f"{len(runs)} strategies",
        converged=all(record.converged for record in records.values()),
        message=f"{len(runs)} strategies, {name} the file as it is",
        success="done",
        given={each: ", ".join(inputs.changes) or "the file as it is" for each, inputs in strategies.items()},
        facts=[(record.facts[0][0], f"{strategy}, {record.facts[0][1]}") for strategy, record in records.items()],
        results=table_across("Strategies at their ends", records, rows, row_quantities(keys, unit), units=units),
        summary={
            "name": name,
            "unit": unit,
            "strategies": {
                strategy: {key: record.summary[key] for key in ("reached", "unconverged", "laws")} | row
                for (strategy, record), row in zip(records.items(), rows, strict=True)
            },
            "versions": versions(),
        },
        again=Again(command, files=f"`{STEPS_CSV}` has all steps; the folder of a strategy has its own report."),
        units=units,
        warnings=[f"{strategy}: {text}" for strategy, record in records.items() for text in record.warnings],
        assumptions=_assumptions(records),
        pictures=[
            Picture(PICTURE, lambda: _figure({each: steps for each, (steps, _) in runs.items()}, unit, units), CAPTION)
        ],
        files=lambda: {STEPS_CSV: text_writer(ResultTable.of_rows(steps).in_units(units).csv(17))},
    )


def _assumptions(records: Mapping[str, Record]) -> list[str]:
    """Assumptions of all strategies once, then those of single ones."""
    first, *others = records.values()
    common = [text for text in first.assumptions if all(text in record.assumptions for record in others)]
    return common + [
        f"{strategy}: {text}"
        for strategy, record in records.items()
        for text in record.assumptions
        if text not in common
    ]


def _figure(steps: Mapping[str, Sequence[EvolutionStep]], unit: str, units: Units) -> Figure:
    """Draw the last depth of each surface, and its worn area over the distance, a line for each strategy."""
    keys = dict.fromkeys(key for run in steps.values() for key in run[-1].surfaces)
    figure = new_figure(11.0, 1.0 + 3.5 * len(keys), units)
    axes = figure.subplots(len(keys), 2, squeeze=False)
    for (profile, distance), (role, side) in zip(axes, keys, strict=True):
        for strategy, run in steps.items():
            if (role, side) not in run[-1].surfaces:
                continue
            worn = run[-1].surfaces[role, side]
            profile.plot(worn.worn_points[:-1, 0], worn.depth, label=strategy, lw=1.2)
            areas = [step.surfaces[role, side].worn_area_mm2 for step in run]
            distance.plot([step.position for step in run], areas, ".-", label=strategy)
        profile.invert_yaxis()
        profile.set_title(role)
        name_axes(profile, ("lateral position", "mm"), ("depth", "mm"))
        name_axes(distance, ("distance", unit), ("worn area", "mm²"))
    legend_below(figure, len(steps))
    return figure
