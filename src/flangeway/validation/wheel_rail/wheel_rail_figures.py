"""Pictures of the wheelset computed again: rigid limit, refinement in contact, and positions beside the published."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from flangeway.railway.profiles.bundled import wheel
from flangeway.railway.profiles.flange_root import IDENTIFIED_RADIUS_MM, identified_wheel
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.drawing import new_figure
from flangeway.validation.wheel_rail.contact_refinement import contact_name
from flangeway.validation.wheel_rail.wheel_rail_reproduced import WheelRailReproduction
from flangeway.validation.wheel_rail.wheel_rail_tables import FAMILIES, MEMBER_CODE, TABLES


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
        mine = [n for n in found.numbers if n.quantity == quantity and n.table in TABLES.values()]
        places = np.arange(len(mine))
        axes.bar(places - 0.2, [number.published for number in mine], 0.4, label="published")
        axes.bar(places + 0.2, [number.computed for number in mine], 0.4, label="computed")
        axes.set_xticks(places, [number.code for number in mine], rotation=60, fontsize=8)
        axes.set_title(f"{quantity} in {mine[0].unit}", fontsize=10)
        axes.axhline(0.0, color="black", lw=0.6)
    panels[0].legend(fontsize=8)
    return figure


def root_figure(found: WheelRailReproduction) -> Figure:
    """Draw both flange roots, and rotation and vertical translation over the lateral one for both families of roots."""
    figure = new_figure(12.0, 4.2)
    shape, *panels = figure.subplots(1, 3)
    for profile, style in ((wheel("AAR-1B"), "k--"), (identified_wheel(), "C0-")):
        points = profile.running_surface.sampled(spacing=0.1)
        near = (points[:, 0] > -50.0) & (points[:, 0] < -5.0)
        shape.plot(*points[near].T, style, lw=1.2, label=profile.title)
    shape.set_aspect("equal")
    shape.set_xlabel("x of the wheel in mm")
    shape.set_ylabel("y of the wheel in mm")
    shape.legend(fontsize=7)
    numbers = {(each.code, each.quantity): each for each in found.numbers if each.table == TABLES["curve"]}
    codes = [row.code for row in found.rows if row.situation == "curve"]
    quantities = ("rotation", "vertical translation, curve less tangent")
    for axes, quantity, name in zip(panels, quantities, ("rotation_rad", "vertical_difference_cm"), strict=True):
        for family, style in zip(FAMILIES, ("C0.-", "C1.--"), strict=True):
            mine = sorted((each for each in found.members if each.family == family), key=lambda each: each.lateral_cm)
            label = f"{MEMBER_CODE}, {family}"
            axes.plot([m.lateral_cm for m in mine], [getattr(m, name) for m in mine], style, lw=1.0, label=label)
        for kind, mark in (("published", "ks"), ("computed", "C3x")):
            for place, code in enumerate(codes):
                at = numbers[f"curve {code}", "horizontal translation"], numbers[f"curve {code}", quantity]
                x, y = (getattr(each, kind) for each in at)
                axes.plot(x, y, mark, ms=5, mfc="none", label=None if place else f"{kind}, all rows")
        axes.set_xlabel("lateral translation in cm")
        axes.set_title(f"{quantity} in {numbers[f'curve {codes[0]}', quantity].unit}", fontsize=9)
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.legend(fontsize=7)
    shape.set_title(f"flange root; wide arc of {IDENTIFIED_RADIUS_MM:g} mm for 38.1 mm", fontsize=9)
    return figure


def pressures_figure(found: WheelRailReproduction, situation: str) -> Figure:
    """Draw the pressures of all rows of a situation, a panel for each contact, with Hertz's ellipse of its force."""
    return _pressures({row.code: row.result for row in found.rows if row.situation == situation})


def refined_pressures_figure(found: WheelRailReproduction) -> Figure:
    """Draw the pressures of the curve with segment-to-segment contact, as `pressures_figure`, a line for each mesh."""
    return _pressures({f"size over {each.divisor}": each.result for each in found.refined})


def _pressures(results: Mapping[str, WheelsetResult]) -> Figure:
    n_patches = max(len(result.patches) for result in results.values())
    figure = new_figure(4.0 * n_patches, 2.6 * len(results))
    panels = figure.subplots(len(results), n_patches, squeeze=False)
    for (name, result), line in zip(results.items(), panels, strict=True):
        for patch, axes in zip(result.patches, line, strict=False):
            pressure = patch.pressure
            axes.plot(pressure.along, pressure.pressures, ".-", ms=3, lw=0.8, label=name)
            if patch.hertz is not None:
                places = np.linspace(-patch.hertz.half_width, patch.hertz.half_width, 201)
                axes.plot(places, patch.hertz.pressure(places), lw=0.8, color="black", label="Hertz")
            axes.set_title(f"{name}, {contact_name(result, patch)}", fontsize=9)
            axes.grid(color="#dddddd", linewidth=0.6)
        line[0].set_ylabel("pressure in MPa")
    for axes in panels[-1]:
        axes.set_xlabel("length along the surface in mm")
    panels[0, 0].legend(fontsize=8)
    return figure
