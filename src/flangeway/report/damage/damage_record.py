"""What an evolution of profiles found: profiles over distance, where they wear and crack, and their limits."""

import csv
import io
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.damage.damage_file import DamageInputs
from flangeway.errors import InputError
from flangeway.railway.damage.evolution import Evolution, EvolutionStep
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.report.figures.drawing import SERIES, axis_name, new_figure
from flangeway.report.page.record import Again, Picture, Record
from flangeway.report.page.tables import SummaryTable
from flangeway.system.output_folder import Writer, text_writer
from flangeway.system.versions import versions

STEPS_CSV = "steps.csv"
PROFILES_PNG = "profiles.png"
MAX_PROFILES = 6
PROFILES_TEXT = (
    "Depth of wear along the running surfaces, new to worn; below it net T-gamma damage at the end: above 0 cracks "
    "grow, below 0 they are worn off. Over the distance: equivalent conicity at 3 mm, maximum pressure, mean T-gamma "
    "of all states."
)
CONICITY_MM = 3.0
"""Amplitude of the equivalent conicity, as EN 15302 reports it."""
OVER_DISTANCE = {"conicity": "conicity at 3 mm", "max_pressure_MPa": "p0 in MPa", "t_gamma_N": "T-gamma in N"}


def damage_record(inputs: DamageInputs, steps: Sequence[EvolutionStep], command: str, seconds: float) -> Record:
    """Return what was found.

    - `command`: runs it again.
    - `seconds`: how long it took.
    """
    evolution, last, unit = inputs.evolution, steps[-1], inputs.evolution.unit
    unconverged = [text for step in steps for text in step.unconverged]
    ended = f"limit {', '.join(last.reached)}" if last.reached else "the end"
    rows = numbers_over_distance(evolution, steps)
    row = rows[-1]
    facts = [(f"{last.position:.6g} {unit}", f"to {ended}")]
    for role, side in last.surfaces:
        facts.append(
            (f"{row[f'{side}_{role}_depth_mm']:.3f} mm", f"deepest wear of the {_whose(evolution, role, side)}")
        )
    return Record(
        name=inputs.name,
        title=f"{inputs.name}: profiles over {unit}",
        subtitle=f"{len(evolution.collective.states)} states, {len(steps) - 1} steps",
        converged=not unconverged,
        message=f"{ended} after {last.position:.6g} {unit}, {len(steps) - 1} steps",
        success="done",
        facts=facts,
        results=SummaryTable(
            "Profiles, first and last",
            ("", "new", "worn"),
            tuple((_label(key, unit), f"{rows[0][key]:.5g}", f"{value:.5g}") for key, value in row.items()),
        ),
        summary={
            "name": inputs.name,
            "unit": unit,
            "position": last.position,
            "reached": list(last.reached),
            "steps": rows,
            "unconverged": unconverged,
            "laws": {role: law.name for role, law in evolution.laws.items()},
            "versions": versions(),
        },
        again=Again(
            command, files="`steps.csv` has all numbers, `worn-*.csv` the worn profiles, `damage.sqlite` all steps."
        ),
        versions=versions(),
        warnings=list(dict.fromkeys(unconverged)),
        assumptions=_assumptions(inputs),
        pictures=[
            Picture(PROFILES_PNG, lambda: profiles_figure(steps, rows, unit), PROFILES_TEXT),
        ],
        tables=[_states(steps)],
        timings_s={"total": seconds},
        files=lambda: _files(steps, rows),
    )


def _label(key: str, unit: str) -> str:
    own = {
        "position": f"distance in {unit}",
        "t_gamma_N": "mean T-gamma in N",
        "conicity": "equivalent conicity at 3 mm",
    }
    return own.get(key) or axis_name(key)


def _whose(evolution: Evolution, role: str, side: str) -> str:
    return f"{side} {role}" if evolution.collective.separate else f"{role}s"


def _assumptions(inputs: DamageInputs) -> list[str]:
    evolution, settings = inputs.evolution, inputs.evolution.settings
    found = [f"Wear of the {role}: {law.name}." for role, law in evolution.laws.items()]
    if inputs.collective:
        found.insert(
            0,
            f"The bundled collective {inputs.collective} is assumed: its shares, radii and speeds are no measurements.",
        )
    theories = {state.model.rolling.theory for state in evolution.collective.states if state.model.rolling}
    found += [
        f"Creep forces by the theory {', '.join(sorted(theories))}; T-gamma and wear depend on it.",
        "Each wheel wears alike around its circumference, each rail alike under all axles.",
        f"Increments of the depth are filtered by a Gaussian of {settings.filter_mm:g} mm; a step is "
        f"{settings.max_depth_mm:g} mm deep at most.",
        "T-gamma damage is that of the Whole Life Rail Model; steel does not yield in the contact.",
    ]
    if not evolution.collective.separate:
        found.append("Wheels of both sides wear alike, and so do both rails: the mean of both sides.")
    return found


def _states(steps: Sequence[EvolutionStep]) -> SummaryTable:
    rows = []
    for first, last in zip(steps[0].states, steps[-1].states, strict=True):
        numbers = []
        for state in (first, last):
            numbers.append(f"{max((each.max_pressure_MPa for each in state.patches), default=float('nan')):.0f}")
            numbers.append(f"{sum(each.t_gamma_N for each in state.patches):.2f}")
        rows.append((first.name, *numbers))
    header = ("state", "p0 new, MPa", "T-gamma new, N", "p0 worn, MPa", "T-gamma worn, N")
    return SummaryTable("States on new and worn profiles", header, tuple(rows))


def numbers_over_distance(evolution: Evolution, steps: Sequence[EvolutionStep]) -> list[dict[str, float]]:
    """Numbers of each step, with the equivalent conicity on the track of the first state; nan where there is none."""
    lateral = np.linspace(-2.0, 2.0, 401) * CONICITY_MM
    rows = []
    for step in steps:
        worn = {key: surface.worn for key, surface in step.surfaces.items()}
        problem = evolution.collective.problem_with(evolution.collective.states[0], worn)
        try:
            locus = RigidGeometry.of(problem.track, problem.wheelset, 0.0).locus(lateral)
            conicity = float(equivalent_conicity(RollingRadiusDifference.of(locus), CONICITY_MM)[0])
        except InputError:
            conicity = float("nan")
        rows.append(step.row | {"conicity": conicity})
    return rows


def _files(steps: Sequence[EvolutionStep], rows: Sequence[dict[str, float]]) -> dict[str, Writer]:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(rows[0])
    writer.writerows([list(map(float, row.values())) for row in rows])
    worn = {f"worn-{side}-{role}.csv": text_writer(each.csv()) for (role, side), each in steps[-1].surfaces.items()}
    return {STEPS_CSV: text_writer(text.getvalue()), **worn}


def profiles_figure(steps: Sequence[EvolutionStep], rows: Sequence[dict[str, float]], unit: str) -> Figure:
    """Draw the depth of each surface at some distances, the damage of the last step, and numbers over the distance."""
    keys = list(steps[0].surfaces)
    figure = new_figure(max(5.0 * len(keys), 8.0), 7.0)
    grid = figure.add_gridspec(2, 1, height_ratios=(5, 2))
    profiles, distance = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    axes = profiles.subplots(2, len(keys), squeeze=False, sharex="col", height_ratios=(2, 1))
    shown = np.unique(np.linspace(0, len(steps) - 1, min(len(steps), MAX_PROFILES)).round().astype(int))
    for column, (role, side) in enumerate(keys):
        above, below = axes[:, column]
        for number, index in enumerate(shown[shown > 0]):
            surface = steps[index].surfaces[role, side]
            x = surface.worn_points[:-1, 0] + np.diff(surface.worn_points[:, 0]) / 2.0
            label = f"{steps[index].position:.0f} {unit}"
            above.plot(x, surface.depth, color=SERIES[number % len(SERIES)], label=label, lw=1.2)
        x = steps[-1].surfaces[role, side].worn_points[:-1, 0]
        below.plot(x, steps[-1].damage[role, side], color=SERIES[1], lw=1.2)
        above.invert_yaxis()
        above.set_title(role)
        above.set_ylabel("depth in mm")
        below.set_ylabel("net damage")
        below.set_xlabel("lateral position in mm")
        above.legend(fontsize=7)
    positions = [row["position"] for row in rows]
    for panel, (key, label) in zip(distance.subplots(1, len(OVER_DISTANCE)), OVER_DISTANCE.items(), strict=True):
        panel.plot(positions, [row[key] for row in rows], ".-", color=SERIES[0])
        panel.set_xlabel(unit)
        panel.set_ylabel(label)
    return figure
