"""Pictures of the wheelset computed again: rigid limit, refinement in contact, and positions beside the published."""

import numpy as np
from matplotlib.figure import Figure

from flangeway.report.drawing import new_figure
from flangeway.study.reproductions.wheel_rail import WheelRailReproduction


def rigid_limit_figure(found: WheelRailReproduction) -> Figure:
    """Draw distances of positions and contact points from the rigid ones over the factor on Young's modulus."""
    figure = new_figure(7.0, 5.0)
    axes = figure.subplots()
    factors = [each.factor for each in found.limit]
    positions = np.abs([each.position_differences_mm for each in found.limit])
    for values, name in zip(positions.T, ("lateral", "vertical", "roll x 750 mm"), strict=True):
        axes.loglog(factors, values, marker="o", label=name)
    points = [each.point_distances_mm.max() for each in found.limit]
    axes.loglog(factors, points, marker="s", ls="--", label="farthest contact point")
    axes.set_xlabel("factor on Young's modulus")
    axes.set_ylabel("distance from the rigid wheelset in mm")
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend()
    return figure


def refinement_figure(found: WheelRailReproduction) -> Figure:
    """Draw what changes from one mesh in contact to the next finer one."""
    figure = new_figure(8.0, 5.0)
    axes = figure.subplots()
    for name in found.refined[0].quantities:
        values = [each.quantities.get(name, np.nan) for each in found.refined]
        change = 100.0 * (np.array(values) / values[0] - 1.0)
        axes.plot([each.divisor for each in found.refined], change, marker="o", label=", ".join(name))
    axes.set_xlabel("element size in contact divided by")
    axes.set_ylabel("change in %")
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend(fontsize=7)
    return figure


def positions_figure(found: WheelRailReproduction) -> Figure:
    """Draw computed positions beside the published ones, a panel for each component."""
    figure = new_figure(12.0, 4.5)
    panels = figure.subplots(1, 3)
    for axes, quantity in zip(panels, ("vertical translation", "horizontal translation", "rotation"), strict=True):
        mine = [number for number in found.numbers if number.quantity == quantity]
        places = np.arange(len(mine))
        axes.bar(places - 0.2, [number.published for number in mine], 0.4, label="published")
        axes.bar(places + 0.2, [number.computed for number in mine], 0.4, label="computed")
        axes.set_xticks(places, [number.code for number in mine], rotation=60, fontsize=8)
        axes.set_title(f"{quantity} in {mine[0].unit}", fontsize=10)
        axes.axhline(0.0, color="black", lw=0.6)
    panels[0].legend(fontsize=8)
    return figure


def pressures_figure(found: WheelRailReproduction, situation: str) -> Figure:
    """Draw the pressures of all rows of a situation, a panel for each contact, with Hertz's ellipse of its force."""
    rows = [row for row in found.rows if row.situation == situation]
    n_patches = max(len(row.result.patches) for row in rows)
    figure = new_figure(4.0 * n_patches, 2.6 * len(rows))
    panels = figure.subplots(len(rows), n_patches, squeeze=False)
    for row, line in zip(rows, panels, strict=True):
        for patch, axes in zip(row.result.patches, line, strict=False):
            pressure = patch.pressure
            axes.plot(pressure.along, pressure.pressures, ".-", ms=3, lw=0.8, label=row.code)
            if patch.hertz is not None:
                places = np.linspace(-patch.hertz.half_width, patch.hertz.half_width, 201)
                axes.plot(places, patch.hertz.pressure(places), lw=0.8, color="black", label="Hertz")
            axes.set_title(f"{row.code}, {patch.side} {patch.region}", fontsize=9)
            axes.grid(color="#dddddd", linewidth=0.6)
        line[0].set_ylabel("pressure in MPa")
    for axes in panels[-1]:
        axes.set_xlabel("length along the surface in mm")
    panels[0, 0].legend(fontsize=8)
    return figure
