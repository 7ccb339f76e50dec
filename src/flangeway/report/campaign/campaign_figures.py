"""Pictures of a campaign of a wheelset against the varied input: contact locus, maximum pressure, L/V, forces."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from flangeway.campaign import CampaignTable
from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.drawing import GREY, HALO, INK, SIDE_COLOURS, axis_name, named, new_figure
from flangeway.report.figures.plots import COLOURS as SHADES
from flangeway.types import Floats

LOCUS, PRESSURE_MAP, PRESSURE, RATIO, FORCES = (
    *("contact-locus.png", "max-pressure-map.png", "max-pressure.png", "lateral-over-vertical.png", "forces.png"),
)
NAMES = (LOCUS, PRESSURE_MAP, PRESSURE, RATIO, FORCES)

MAX_LABELLED = 8
ROUGH = "not reliable, see its remark"
MIN_POINT, MAX_POINT = 3.0, 40.0


def numeric_keys(table: CampaignTable) -> list[str]:
    """Inputs that are numbers and vary, in their order."""
    found = []
    for key in table.keys:
        values = {value for value in table.rows[key] if value is not None}
        if len(values) > 1 and not any(isinstance(value, str) for value in values):
            found.append(key)
    return found


def campaign_figures(table: CampaignTable) -> dict[str, Callable[[], Figure]]:
    """Functions that draw the figures of a campaign of wheelsets, by file name; none if no number varies."""
    if "left_max_pressure_MPa" not in table.rows and "right_max_pressure_MPa" not in table.rows:
        return {}
    keys = numeric_keys(table)
    if not keys or "converged" not in table.rows["status"]:
        return {}
    figures: dict[str, Callable[[], Figure]] = {
        LOCUS: lambda: locus_figure(table, keys[0]),
        PRESSURE: lambda: curves_figure(table, keys[0], "max_pressure_MPa", "maximum pressure in MPa"),
        RATIO: lambda: ratio_figure(table, "lateral_mm" if "lateral_mm" in table.rows else keys[0]),
        FORCES: lambda: forces_figure(table, keys[0]),
    }
    needed = {
        PRESSURE: "max_pressure_MPa", RATIO: "lateral_over_vertical", FORCES: "normal_force_kN",
    }  # fmt: skip
    figures = {
        name: draw
        for name, draw in figures.items()
        if name not in needed or all(f"{side}_{needed[name]}" in table.rows for side in SIDES)
    }
    if len(keys) > 1 and PRESSURE in figures and _spans_plane(table, keys[0], keys[1]):
        figures[PRESSURE_MAP] = lambda: pressure_map(table, keys[0], keys[1])
    return figures


def locus_figure(table: CampaignTable, key: str) -> Figure:
    """Draw the points of contact on wheels and rails over an input; dot size by force."""
    figure = new_figure(9.0, 6.4)
    axes = figure.subplots(2, 2, sharex=True)
    of_row = dict(zip(table.rows["row"], table.numbers(key), strict=True))
    patches = {name: np.array(values) for name, values in table.patches.items()}
    x = np.array([of_row[row] for row in table.patches["row"]])
    force = patches["normal_force_kN"].astype(float)
    size = MIN_POINT + (MAX_POINT - MIN_POINT) * force / max(force.max(initial=0.0), 1e-300)
    for column, side in enumerate(SIDES):
        mine = patches["side"] == side
        for line, (body, where) in enumerate((("wheel", "tape line"), ("rail", "centre line"))):
            panel = axes[line, column]
            y = patches[f"{body}_position_x_mm"][mine].astype(float)
            panel.scatter(x[mine], y, s=size[mine], color=SIDE_COLOURS[side], alpha=0.6, lw=0)
            panel.grid(color="#dddddd", lw=0.5)
            axes[line, 0].set_ylabel(f"{body}: x from its {where} in mm")
        axes[0, column].set_title(f"{side} side", fontsize=9)
        axes[1, column].set_xlabel(axis_name(key))
    figure.suptitle(f"{table.name}: points of contact; size of the dots by force", fontsize=10)
    return figure


def pressure_map(table: CampaignTable, first: str, second: str) -> Figure:
    """Draw the maximum pressure over two inputs; the maximum over all other inputs."""
    figure = new_figure(9.4, 4.2)
    panels = figure.subplots(1, 2, sharey=True)
    places, groups = np.unique(
        np.column_stack((table.numbers(first), table.numbers(second))), axis=0, return_inverse=True
    )
    pressures = {side: _maximum(table.numbers(f"{side}_max_pressure_MPa"), groups.ravel()) for side in SIDES}
    every = np.concatenate(list(pressures.values()))
    limits = float(np.nanmin(every)), float(np.nanmax(every))
    for panel, side in zip(panels, SIDES, strict=True):
        values = pressures[side]
        drawn = _draw_map(panel, places, values, limits)
        failed = ~np.isfinite(values)
        label = "no contact, or no result" if failed.any() else None
        panel.plot(*places[failed].T, "x", color=INK, ms=4, label=label, path_effects=[HALO])
        rough = np.unique(groups.ravel()[_remarked(table, f"{side}_max_pressure_MPa")])
        panel.plot(*places[rough].T, "+", color=INK, ms=5, label=ROUGH if len(rough) else None, path_effects=[HALO])
        panel.set_title(f"{side} side", fontsize=9)
        panel.set_xlabel(axis_name(first))
    panels[0].set_ylabel(axis_name(second))
    figure.colorbar(drawn, ax=list(panels), label="maximum pressure in MPa")
    _legend(figure)
    figure.suptitle(f"{table.name}: maximum pressure", fontsize=10)
    return figure


def _maximum(values: Floats, groups: NDArray[np.intp]) -> Floats:
    maximum = np.full(groups.max() + 1, -np.inf)
    np.maximum.at(maximum, groups, np.where(np.isfinite(values), values, -np.inf))
    return np.where(np.isfinite(maximum), maximum, np.nan)


def _draw_map(axes: Axes, places: Floats, values: Floats, limits: tuple[float, float]) -> mpl.cm.ScalarMappable:
    """Colour the cells of a full grid, or triangles between scattered places."""
    x, y = np.unique(places[:, 0]), np.unique(places[:, 1])
    if len(x) * len(y) == len(values):  # places are sorted by the first, then the second
        field = np.ma.masked_invalid(values.reshape(len(x), len(y)).T)
        return axes.pcolormesh(x, y, field, shading="nearest", cmap=SHADES, vmin=limits[0], vmax=limits[1])
    known = np.isfinite(values)
    if _is_flat(places[known]):
        return axes.scatter(
            places[known, 0], places[known, 1], c=values[known], cmap=SHADES, vmin=limits[0], vmax=limits[1]
        )
    scale = np.ptp(places, axis=0)
    triangles = Triangulation(*(places[known] / scale).T).triangles
    return axes.tripcolor(
        places[known, 0], places[known, 1], values[known], triangles=triangles, shading="gouraud", cmap=SHADES,
        vmin=limits[0], vmax=limits[1],
    )  # fmt: skip


def _spans_plane(table: CampaignTable, first: str, second: str) -> bool:
    return not _is_flat(np.column_stack((table.numbers(first), table.numbers(second))))


def _is_flat(places: Floats) -> bool:
    """Whether places lie on one line."""
    centred = (places - places.mean(axis=0)) / np.maximum(np.ptp(places, axis=0), 1e-300)
    return bool(len(places) < 3 or np.linalg.svd(centred, compute_uv=False)[-1] < 1e-9 * len(places))


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
    for place, (values, members) in enumerate(groups.items()):
        rows = np.array(members)
        label = ", ".join(map(_valued, others, values)) if few else None
        yield _Series(label, place / max(len(groups) - 1, 1), rows[np.argsort(along[rows], kind="stable")])


def _valued(key: str, value: object) -> str:
    words, unit = named(key)
    return f"{words} {value} {unit}".rstrip()


def _legend(figure: Figure) -> None:
    """One legend of all panels below them, each name once."""
    found = dict(
        reversed(pair) for panel in figure.axes for pair in zip(*panel.get_legend_handles_labels(), strict=True)
    )
    if found:
        figure.legend(list(found.values()), list(found), loc="outside lower center", ncols=4, frameon=False, fontsize=8)


def _remarked(table: CampaignTable, column: str) -> NDArray[np.bool_]:
    """Rows whose value in a column is not reliable, shape (n_rows,)."""
    remarks = table.rows.get(f"{column.removesuffix('_MPa')}_remark", [None] * len(table.rows["row"]))
    return np.array([remark is not None for remark in remarks], dtype=np.bool_)


def _draw_series(axes: Axes, table: CampaignTable, x: str, column: str) -> None:
    """Draw a line for each series; rows without a result leave a gap."""
    along, values = table.numbers(x), table.numbers(column)
    for each in _series(table, x):
        y = values[each.rows]
        marker = "o" if len(y) <= 40 else None
        colour = mpl.colormaps["viridis"](0.85 * each.shade)
        axes.plot(along[each.rows], y, color=colour, lw=1.2, marker=marker, ms=3, label=each.label)
    rough = _remarked(table, column)
    if rough.any():
        axes.plot(along[rough], values[rough], "x", color=INK, ms=5, label=ROUGH)
    axes.grid(color="#dddddd", lw=0.5)


def curves_figure(table: CampaignTable, key: str, quantity: str, name: str) -> Figure:
    """Draw a quantity of both sides over an input, a line for each combination of the others."""
    figure = new_figure(9.0, 4.0)
    panels = figure.subplots(1, 2, sharey=True)
    for panel, side in zip(panels, SIDES, strict=True):
        _draw_series(panel, table, key, f"{side}_{quantity}")
        panel.set_title(f"{side} side", fontsize=9)
        panel.set_xlabel(axis_name(key))
    panels[0].set_ylabel(name)
    _legend(figure)
    figure.suptitle(f"{table.name}: {name.partition(' in ')[0]}", fontsize=10)
    return figure


def ratio_figure(table: CampaignTable, x: str) -> Figure:
    """Draw L/V of both wheels over the lateral shift of the wheelset."""
    figure = curves_figure(table, x, "lateral_over_vertical", "L/V, positive outwards")
    for panel in figure.axes:
        panel.axhline(0.0, color=GREY, lw=0.6)
    return figure


def forces_figure(table: CampaignTable, key: str) -> Figure:
    """Draw normal, lateral and vertical force on both wheels over an input."""
    figure = new_figure(9.0, 7.6)
    kinds = ("normal", "lateral", "vertical")
    rows = figure.subplots(3, 2, sharex=True, sharey="row")
    for line, kind in zip(rows, kinds, strict=True):
        for panel, side in zip(line, SIDES, strict=True):
            _draw_series(panel, table, key, f"{side}_{kind}_force_kN")
        line[0].set_ylabel(f"{kind} force in kN")
    for top, bottom, side in zip(rows[0], rows[-1], SIDES, strict=True):
        top.set_title(f"{side} wheel", fontsize=9)
        bottom.set_xlabel(axis_name(key))
    _legend(figure)
    figure.suptitle(f"{table.name}: forces of the rails on the wheels; lateral to the right, vertical up", fontsize=10)
    return figure
