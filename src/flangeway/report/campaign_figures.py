"""Pictures of a campaign of a wheelset against the varied input: contact locus, maximum pressure, L/V, forces."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flangeway.campaign import CampaignTable
from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.drawing import (
    COLOURS,
    GREY,
    HALO,
    INK,
    PAGE_IN,
    SIDE_COLOURS,
    Style,
    colour_bar,
    legend_below,
    name_axes,
    panels,
)
from flangeway.report.page.record import Figures, named
from flangeway.types import Bools, Floats
from flangeway.units import Units

LOCUS, PRESSURE_MAP, PRESSURE, RATIO, FORCES = (
    *("contact-locus.png", "max-pressure-map.png", "max-pressure.png", "lateral-over-vertical.png", "forces.png"),
)
Column = tuple[str, str, str]
"""Name of a result behind that of the side, words and unit."""
OF_SIDES: dict[str, tuple[str, tuple[Column, ...]]] = {
    PRESSURE: ("maximum pressure", (("max_pressure_MPa", "maximum pressure", "MPa"),)),
    RATIO: ("L/V", (("lateral_over_vertical", "L/V, positive outwards", ""),)),
    FORCES: (
        "forces of the rails on the wheels; lateral to the right, vertical up",
        tuple((f"{kind}_force_kN", f"{kind} force", "kN") for kind in ("normal", "lateral", "vertical")),
    ),
}
"""Title and rows of the pictures of results of both sides against an input."""

MAX_LABELLED = 8
ROUGH = "mesh too coarse"
MIN_POINT, MAX_POINT = 3.0, 40.0


def numeric_keys(table: CampaignTable) -> list[str]:
    """Inputs that are numbers and vary, in their order."""
    keys = []
    for key in table.keys:
        values = {value for value in table.rows[key] if value is not None}
        if len(values) > 1 and not any(isinstance(value, str) for value in values):
            keys.append(key)
    return keys


def campaign_figures(table: CampaignTable, units: Units = "metric") -> Figures:
    """Functions that draw the figures of a campaign of wheelsets, by file name; none if no number varies."""
    keys, there = numeric_keys(table), [f"{side}_max_pressure_MPa" in table.rows for side in SIDES]
    if not any(there) or not keys or "converged" not in table.rows["status"]:
        return {}
    figures: Figures = {LOCUS: partial(locus_figure, table, keys[0], units)}
    for name, (_, columns) in OF_SIDES.items():
        if all(f"{side}_{column}" in table.rows for side in SIDES for column, *_ in columns):
            over = "lateral_mm" if name == RATIO and "lateral_mm" in table.rows else keys[0]
            figures[name] = partial(sides_figure, table, over, name, units)
    if len(keys) > 1 and all(there):
        figures[PRESSURE_MAP] = partial(pressure_map, table, keys[0], keys[1], units)
    return figures


def locus_figure(table: CampaignTable, key: str, units: Units = "metric") -> Figure:
    """Draw the points of contact on wheels and rails over an input; dot size by force."""
    figure, axes = panels(PAGE_IN, 4.2, 2, 2, units, sharex=True)
    of_row = dict(zip(table.rows["row"], table.numbers(key), strict=True))
    patches = {name: np.array(values) for name, values in table.patches.items()}
    x = np.array([of_row[row] for row in table.patches["row"]])
    force = patches["normal_force_kN"].astype(float)
    size = MIN_POINT + (MAX_POINT - MIN_POINT) * force / max(force.max(initial=0.0), 1e-300)
    for column, side in zip(axes.T, SIDES, strict=True):
        rows = patches["side"] == side
        for panel, (body, where) in zip(column, (("wheel", "tape line"), ("rail", "centre line")), strict=True):
            y = patches[f"{body}_position_x_mm"][rows].astype(float)
            panel.scatter(x[rows], y, s=size[rows], color=SIDE_COLOURS[side], alpha=0.6, lw=0)
            name_axes(panel, y=(f"{body}: x from its\n{where}" if side == SIDES[0] else "", "mm"))
        column[0].set_title(f"{side} side", fontsize=9)
        name_axes(column[1], named(key))
    figure.suptitle(f"{table.name}: points of contact; size of the dots by force", fontsize=9)
    return figure


def pressure_map(table: CampaignTable, first: str, second: str, units: Units = "metric") -> Figure:
    """Draw the maximum pressure over two inputs; the maximum over all other inputs."""
    figure, (both,) = panels(PAGE_IN, 3.3, 1, 2, units, sharey=True)
    points, groups = np.unique(
        np.column_stack((table.numbers(first), table.numbers(second))), axis=0, return_inverse=True
    )
    pressures = {side: np.full(len(points), np.nan) for side in SIDES}
    for side, highest in pressures.items():
        np.fmax.at(highest, groups.ravel(), table.numbers(f"{side}_max_pressure_MPa"))
    every = np.concatenate(list(pressures.values()))
    limits = float(np.nanmin(every)), float(np.nanmax(every))
    for panel, side in zip(both, SIDES, strict=True):
        panel.grid(visible=False)
        values = pressures[side]
        drawn = _draw_map(panel, points, values, limits)
        failed = ~np.isfinite(values)
        rough = np.unique(groups.ravel()[_remarked(table, f"{side}_max_pressure_MPa")])
        for chosen, marker, label in ((failed, "x", "no contact, or no result"), (rough, "+", ROUGH)):
            if len(points[chosen]):
                panel.plot(*points[chosen].T, marker, color=INK, ms=5, label=label, path_effects=[HALO])
        panel.set_title(f"{side} side", fontsize=9)
        name_axes(panel, named(first))
    name_axes(both[0], y=named(second))
    colour_bar(drawn, list(both), "maximum pressure", "MPa")
    legend_below(figure, 4)
    figure.suptitle(f"{table.name}: maximum pressure", fontsize=9)
    return figure


def _draw_map(axes: Axes, points: Floats, values: Floats, limits: tuple[float, float]) -> mpl.cm.ScalarMappable:
    """Colour the cells of a full grid, or scattered points."""
    x, y = (np.unique(along) for along in points.T)
    style: Style = {"cmap": COLOURS, "vmin": limits[0], "vmax": limits[1]}
    if len(x) * len(y) == len(values):  # points are sorted by the first, then the second
        field = np.ma.masked_invalid(values.reshape(len(x), len(y)).T)
        return axes.pcolormesh(x, y, field, shading="nearest", **style)
    return axes.scatter(points[:, 0], points[:, 1], c=values, **style)


@dataclass(frozen=True, eq=False)
class _Series:
    """Rows along one input with all others the same."""

    label: str | None
    shade: float
    rows: NDArray[np.intp]


def _series(table: CampaignTable, x: str) -> Iterator[_Series]:
    """Rows with the same other inputs, sorted along `x`."""
    others = [key for key in table.keys if key != x and len(set(table.rows[key])) > 1]
    if x not in table.keys:  # a result, such as the shift that a lateral force gives: along the last input
        others = others[:-1]
    along = table.numbers(x)
    groups: dict[tuple[object, ...], list[int]] = {}
    for number in range(len(along)):
        groups.setdefault(tuple(table.rows[key][number] for key in others), []).append(number)
    few = 1 < len(groups) <= MAX_LABELLED
    for index, (values, members) in enumerate(groups.items()):
        rows = np.array(members)
        label = ", ".join(map(_valued, others, values)) if few else None
        yield _Series(label, index / max(len(groups) - 1, 1), rows[np.argsort(along[rows], kind="stable")])


def _valued(key: str, value: object) -> str:
    words, unit = named(key)
    return f"{words} {value} {unit}".rstrip()


def _remarked(table: CampaignTable, column: str) -> Bools:
    """Rows whose value in a column is not reliable, shape (n_rows,)."""
    remarks = table.rows.get(f"{column.removesuffix('_MPa')}_remark", [None] * len(table.rows["row"]))
    return np.array([remark is not None for remark in remarks], dtype=np.bool_)


def _draw_series(axes: Axes, table: CampaignTable, x: str, column: str) -> None:
    """Draw a line for each series; rows without a result leave a gap."""
    along, values = table.numbers(x), table.numbers(column)
    for series in _series(table, x):
        y = values[series.rows]
        marker = "o" if len(y) <= 40 else None
        colour = mpl.colormaps["viridis"](0.85 * series.shade)
        axes.plot(along[series.rows], y, color=colour, lw=1.2, marker=marker, ms=3, label=series.label)
    rough = _remarked(table, column)
    if rough.any():
        axes.plot(along[rough], values[rough], "x", color=INK, ms=5, label=ROUGH)
    if values.min(initial=0.0) < 0.0 < values.max(initial=0.0):
        axes.axhline(0.0, color=GREY, lw=0.6)


def sides_figure(table: CampaignTable, key: str, name: str, units: Units = "metric") -> Figure:
    """Draw results of both sides over an input or a result, a line for each combination of the other inputs."""
    title, columns = OF_SIDES[name]
    figure, rows = panels(PAGE_IN, 1.1 + 1.1 * len(columns), len(columns), 2, units, sharex=True, sharey="row")
    for row, (column, words, unit) in zip(rows, columns, strict=True):
        for panel, side in zip(row, SIDES, strict=True):
            _draw_series(panel, table, key, f"{side}_{column}")
        name_axes(row[0], y=(words, unit))
    for top, bottom, side in zip(rows[0], rows[-1], SIDES, strict=True):
        top.set_title(f"{side} side", fontsize=9)
        name_axes(bottom, named(key))
    legend_below(figure, 4)
    figure.suptitle(f"{table.name}: {title}", fontsize=9)
    return figure
