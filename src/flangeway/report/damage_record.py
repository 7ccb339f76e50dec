"""What an evolution of profiles found, of one strategy or of several side by side."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.damage_file import DamageInputs
from flangeway.cases.summary import plain_numbers
from flangeway.errors import InputError
from flangeway.quantities import Quantity, measured
from flangeway.railway.damage.evolution import Evolution, EvolutionStep, StateDamage, limit_positions
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.report.figures.drawing import HALF_IN, PAGE_IN, SERIES, legend_below, name_axes, new_figure
from flangeway.report.page.record import Again, Picture, Report, SummaryTable, named, table_across, table_of
from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer, text_writer, versions
from flangeway.system.templates import sentences
from flangeway.units import Units

# --- What an evolution of profiles found: profiles over distance, where they wear and crack, and their limits.


STEPS_CSV = "steps.csv"
PROFILES_PNG = "profiles.png"
MAX_PROFILES = 6
PROFILES_TEXT = (
    "Depth of wear along the running surfaces, new to worn; below it net T-gamma damage at the end: above 0 cracks "
    "grow, below 0 they are worn off. Over the distance: equivalent conicity at 3 mm, maximum pressure, mean T-gamma "
    "of all states."
)
LOST_TEXT = "where a state has no equilibrium, the mean of the others is taken for its share of the line"
CONICITY_MM = 3.0
"""Amplitude of the equivalent conicity, as EN 15302 reports it."""
OVER_DISTANCE = {
    "conicity": ("conicity at 3 mm", ""),
    "max_pressure_MPa": ("p0", "MPa"),
    "t_gamma_N": ("T-gamma", "N"),
}


def damage_record(
    inputs: DamageInputs, steps: Sequence[EvolutionStep], command: str, seconds: float, units: Units = "metric"
) -> Report:
    """Return what was found.

    - `command`: runs it again.
    - `seconds`: how long it took.
    """
    evolution, last, unit = inputs.evolution, steps[-1], inputs.evolution.unit
    unconverged = [text for step in steps for text in step.unconverged]
    positions = limit_positions(steps, evolution.settings.limits.written)
    limits = [f"{name} after {position:.6g} {unit}" for name, position in positions.items()]
    ended = f"limit {', '.join(limits)}; " if limits else ""
    rows = numbers_over_distance(evolution, steps)
    row = rows[-1]
    facts = [(measured(position, unit, units, ".6g"), f"to the limit {name}") for name, position in positions.items()]
    facts = facts or [(measured(last.position, unit, units, ".6g"), "to the end")]
    for role, side in last.surfaces:
        facts.append(
            (
                measured(row[f"{side}_{role}_depth_mm"], "mm", units, ".3f"),
                f"deepest wear of the {_whose(evolution, role, side)}",
            )
        )
    return Report(
        name=inputs.name,
        title=f"{inputs.name}: wear over distance",
        subtitle=f"States: {len(evolution.collective.states)}; steps: {len(steps) - 1}",
        converged=not unconverged,
        message=f"{ended}{last.position:.6g} {unit} in {len(steps) - 1} steps",
        success="finished",
        facts=facts,
        results=table_across(
            "Profiles, first and last", ("new", "worn"), (rows[0], row), row_quantities(row, unit), units=units
        ),
        summary={
            "name": inputs.name,
            "unit": unit,
            "position": last.position,
            "reached": positions,
            "steps": rows,
            "unconverged": unconverged,
            "laws": {role: law.name for role, law in evolution.laws.items()},
            "versions": versions(),
        },
        again=Again(
            command, files="`steps.csv` has all numbers, `worn-*.csv` the worn profiles, `damage.sqlite` all steps."
        ),
        units=units,
        warnings=[*dict.fromkeys(unconverged), *([LOST_TEXT] if unconverged else [])],
        assumptions=_assumptions(inputs),
        pictures=lambda: [
            Picture(PROFILES_PNG, lambda: profiles_figure(steps, rows, unit, units), PROFILES_TEXT),
        ],
        tables=[_states(steps, units)],
        timings_s={"total": seconds},
        files=lambda: _files(steps, rows, units),
    )


def row_quantities(keys: Iterable[str], distance: str) -> list[Quantity[Mapping[str, float]]]:
    """Quantities of rows of numbers over the distance, by their keys; None where a row has not the key.

    - `distance`: unit of the position.
    """
    words_of_keys = {
        "position": ("distance", distance, ".6g"),
        "t_gamma_N": ("mean T-gamma", "N", ".4g"),
        "conicity": ("equivalent conicity at 3 mm", "", ".4g"),
    }
    return [
        Quantity(key, words, partial(_number, key), unit, form[0] if form else ".3f" if "mm" in unit else ".4g")
        for key in keys
        for words, unit, *form in (words_of_keys.get(key) or named(key),)
    ]


def _number(key: str, row: Mapping[str, float]) -> float | None:
    number: float | None = plain_numbers(row.get(key))
    return number


def _whose(evolution: Evolution, role: str, side: str) -> str:
    return f"{side} {role}" if evolution.collective.separate else f"{role}s"


def _assumptions(inputs: DamageInputs) -> list[str]:
    rolling = [state.problem.rolling for state in inputs.evolution.collective.states]
    return sentences(
        "flangeway.report",
        "damage_assumptions.txt",
        collective=inputs.collective,
        evolution=inputs.evolution,
        theories=sorted({motion.theory for motion in rolling if motion}),
    )


def _states(steps: Sequence[EvolutionStep], units: Units) -> SummaryTable:
    """Maximum pressure and T-gamma of each state on new and worn profiles."""
    quantities: list[Quantity[Sequence[StateDamage]]] = [Quantity("state", "state", lambda states: states[0].name)]
    for number, word in enumerate(("new", "worn")):
        pressure = partial(_max_pressure, number)
        energy = partial(_t_gamma, number)
        quantities.append(Quantity(f"p0_{word}", f"p0 {word}", pressure, "MPa", ".0f"))
        quantities.append(Quantity(f"t_gamma_{word}", f"T-gamma {word}", energy, "N", ".2f"))
    both = zip(steps[0].states, steps[-1].states, strict=True)
    return table_of("States on new and worn profiles", both, quantities, units=units)


def _max_pressure(number: int, states: Sequence[StateDamage]) -> float | None:
    return max((patch.max_pressure_MPa for patch in states[number].patches), default=None)


def _t_gamma(number: int, states: Sequence[StateDamage]) -> float:
    return sum(patch.t_gamma_N for patch in states[number].patches)


def numbers_over_distance(evolution: Evolution, steps: Sequence[EvolutionStep]) -> list[dict[str, float]]:
    """Numbers of each step, with the equivalent conicity on the median gauge of the states; nan where there is none."""
    lateral = np.linspace(-2.0, 2.0, 401) * CONICITY_MM
    states, rows = sorted(evolution.collective.states, key=lambda state: state.problem.track.gauge_mm), []
    for step in steps:
        worn = {key: surface.worn for key, surface in step.surfaces.items()}
        problem = evolution.collective.problem_with(states[len(states) // 2], worn)
        try:
            locus = RigidGeometry.of(problem.track, problem.wheels, 0.0).locus(lateral)
            conicity = float(equivalent_conicity(RollingRadiusDifference.of(locus), CONICITY_MM)[0])
        except InputError:
            conicity = float("nan")
        rows.append(step.row | {"conicity": conicity})
    return rows


def _files(steps: Sequence[EvolutionStep], rows: Sequence[dict[str, float]], units: Units) -> dict[str, Writer]:
    table = ResultTable({key: [float(row[key]) for row in rows] for key in rows[0]})
    worn = {
        f"worn-{side}-{role}.csv": text_writer(surface.csv()) for (role, side), surface in steps[-1].surfaces.items()
    }
    return {STEPS_CSV: text_writer(table.in_units(units).csv(17)), **worn}


def profiles_figure(
    steps: Sequence[EvolutionStep], rows: Sequence[dict[str, float]], unit: str, units: Units = "metric"
) -> Figure:
    """Draw the depth of each surface at some distances, the damage of the last step, and numbers over the distance."""
    keys = list(steps[0].surfaces)
    figure = new_figure(PAGE_IN, 4.2, units)
    grid = figure.add_gridspec(2, 1, height_ratios=(5, 2))
    profiles, distance = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    axes = profiles.subplots(2, len(keys), squeeze=False, sharex="col", height_ratios=(2, 1))
    shown = np.unique(np.linspace(0, len(steps) - 1, min(len(steps), MAX_PROFILES)).round().astype(int))
    for (above, below), (role, side) in zip(axes.T, keys, strict=True):
        for index in shown[shown > 0]:
            surface = steps[index].surfaces[role, side]
            x = surface.worn_points[:-1, 0] + np.diff(surface.worn_points[:, 0]) / 2.0
            above.plot(x, surface.depth, label=measured(steps[index].position, unit, units, ".0f"), lw=1.2)
        x = steps[-1].surfaces[role, side].worn_points[:-1, 0]
        below.plot(x, steps[-1].damage[role, side], color=SERIES[1], lw=1.2)
        above.invert_yaxis()
        above.set_title(role, fontsize=9)
        name_axes(above, ("", "mm"), ("depth", "mm"))
        name_axes(below, ("lateral position", "mm"), "net damage")
        above.legend(fontsize=8)
    positions = [row["position"] for row in rows]
    for panel, (key, name) in zip(distance.subplots(1, len(OVER_DISTANCE)), OVER_DISTANCE.items(), strict=True):
        panel.plot(positions, [row[key] for row in rows], ".-", color=SERIES[0])
        name_axes(panel, ("distance", unit), name)
    return figure


# --- Strategies side by side: how far each goes, what it wears, and the profiles that it ends with.


PICTURE = "strategies.png"
CAPTION = "Depth of wear at the end of each strategy, and worn area against the distance."


def strategies_record(
    strategies: Mapping[str, DamageInputs],
    runs: Mapping[str, tuple[Sequence[EvolutionStep], Report]],
    command: str,
    units: Units,
) -> Report:
    """Return the comparison of strategies.

    - `strategies`: inputs of each by its name, the first those of the file as it is.
    - `runs`: steps and record of each.
    - `command`: runs it again.
    """
    name = next(iter(strategies))
    records = {strategy: record for strategy, (_, record) in runs.items()}
    unit = next(iter(records.values())).summary["unit"]
    rows = [record.summary["steps"][-1] for record in records.values()]
    steps = [{"strategy": strategy} | row for strategy, record in records.items() for row in record.summary["steps"]]
    keys = dict.fromkeys(key for row in rows for key in row)
    return Report(
        name=name,
        title=f"{name}: strategies side by side",
        subtitle=f"{len(runs)} strategies",
        converged=all(record.converged for record in records.values()),
        message=f"{len(runs)} strategies, {name} the file as it is",
        success="done",
        given={strategy: ", ".join(inputs.changes) or "the file as it is" for strategy, inputs in strategies.items()},
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
        assumptions=_all_assumptions(records),
        pictures=lambda: [
            Picture(
                PICTURE,
                lambda: _figure({strategy: steps for strategy, (steps, _) in runs.items()}, unit, units),
                CAPTION,
            )
        ],
        files=lambda: {STEPS_CSV: text_writer(ResultTable.of_rows(steps).in_units(units).csv(17))},
    )


def _all_assumptions(records: Mapping[str, Report]) -> list[str]:
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
    figure = new_figure(PAGE_IN, min(1.0 + 1.85 * len(keys), HALF_IN), units)
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
        profile.set_title(role, fontsize=9)
        name_axes(profile, ("lateral position", "mm"), ("depth", "mm"))
        name_axes(distance, ("distance", unit), ("worn area", "mm²"))
    legend_below(figure, len(steps))
    return figure
