"""Stresses below the contacts over depth: picture and table."""

import csv
import io
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flangeway.exact.hertz import DEPTH_OF_MAX_SHEAR
from flangeway.post import Stresses
from flangeway.railway.discretisation import ROLES, Role
from flangeway.railway.result import WheelRailPatch, WheelsetResult
from flangeway.railway.subsurface import by_normal, hertz_below, largest_on, stresses_below
from flangeway.report.drawing import INK, new_figure
from flangeway.study import CaseRun

Floats = NDArray[np.float64]

CURVES = (
    ("across the surface", "#0b5394"),
    ("along the surface", "#9a6a00"),
    ("von Mises", "#8b1a8b"),
    ("largest in-plane shear", INK),
)
COLUMNS = (
    "side", "region", "body", "depth_mm", "x_mm", "y_mm", "along_surface_MPa", "across_surface_MPa", "shear_MPa",
    "out_of_plane_MPa", "von_mises_MPa", "in_plane_shear_MPa", "hertz_along_surface_MPa", "hertz_across_surface_MPa",
    "hertz_von_mises_MPa", "hertz_in_plane_shear_MPa",
)  # fmt: skip
"""Columns of the table; places are those of the undeformed profile, in its frame."""


def subsurface_figure(run: CaseRun) -> Figure:
    """Draw stresses over depth, a row for each contact, rail and wheel beside each other, Hertz's dashed."""
    patches = run.result.patches
    figure = new_figure(13.0, 0.9 + 3.4 * max(len(patches), 1))
    rows = figure.subplots(max(len(patches), 1), 2, squeeze=False, sharex=True)
    for row, patch in zip(rows, patches, strict=False):
        for axes, body in zip(row, ROLES[::-1], strict=True):
            _draw(axes, run.result, patch, body)
    for axes in rows[-1]:
        axes.set_xlabel("stress in MPa, tension positive")
    if not patches:
        rows[0, 0].set_title("no contact", fontsize=10)
        return figure
    figure.legend(
        *rows[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=9, frameon=False
    )
    return figure


def _draw(axes: Axes, result: WheelsetResult, patch: WheelRailPatch, body: Role) -> None:
    depths, _, found, hertz = _stresses(result, patch, body)
    for (name, colour), values in zip(CURVES, _curves(found), strict=True):
        axes.plot(values, depths, color=colour, lw=1.4, label=name)
    if hertz is not None:
        for (_, colour), values in zip(CURVES, _curves(hertz), strict=True):
            axes.plot(values, depths, color=colour, lw=1.0, ls=(0, (4, 2)))
        axes.plot([], [], color=INK, lw=1.0, ls=(0, (4, 2)), label="Hertz, half plane, same force")
    top = largest_on(depths, found.in_plane_shear)
    axes.plot([top.value_MPa], [top.depth_mm], marker="o", color=INK, mfc="white", ms=5, zorder=4)
    said = f"largest in-plane shear\n{top.value_MPa:.0f} MPa at {top.depth_mm:.1f} mm"
    if patch.hertz is not None:
        depth = DEPTH_OF_MAX_SHEAR * patch.hertz.half_width
        said += f"\nHertz: {patch.hertz.max_shear:.0f} MPa at {depth:.1f} mm"
    axes.text(0.02, 0.04, said, transform=axes.transAxes, fontsize=9, va="bottom")
    axes.set_ylim(float(depths[-1]), 0.0)
    axes.axvline(0.0, color="#999999", lw=0.6)
    axes.grid(color="#dddddd", lw=0.5)
    axes.set_ylabel("depth in mm")
    alone = sum(other.side == patch.side for other in result.patches) == 1
    where = patch.side if alone else f"{patch.side}, {patch.region}"
    axes.set_title(f"{body}: {where}".capitalize(), fontsize=10)


def _stresses(
    result: WheelsetResult, patch: WheelRailPatch, body: Role
) -> tuple[Floats, Floats, Stresses, Stresses | None]:
    """Depths, points, stresses in the normal's axes, and Hertz's, None where he has none."""
    line = stresses_below(result, patch, body)
    hertz = None
    if patch.hertz is not None:
        hertz = hertz_below(patch.hertz, line.distances, result.model.problem.material_of(body).poisson)
    return line.distances, line.points, by_normal(line), hertz


def _curves(stresses: Stresses) -> tuple[Floats, ...]:
    """Values of `CURVES`."""
    along, across, _, _ = stresses.components.T
    return across, along, stresses.von_mises, stresses.in_plane_shear


def subsurface_table(result: WheelsetResult) -> str:
    """Return the stresses below all contacts as CSV, its columns `COLUMNS`; empty where there is no number."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for patch in result.patches:
        for body in ROLES[::-1]:
            names = [patch.side, patch.region, body]
            writer.writerows([*names, *map(_text, numbers)] for numbers in _rows(result, patch, body))
    return text.getvalue()


def _rows(result: WheelsetResult, patch: WheelRailPatch, body: Role) -> Iterator[list[float]]:
    depths, points, found, hertz = _stresses(result, patch, body)
    table = [depths, *points.T, *found.components.T, found.von_mises, found.in_plane_shear]
    if hertz is None:
        table += [np.full(len(depths), np.nan)] * 4
    else:
        table += [*hertz.components.T[:2], hertz.von_mises, hertz.in_plane_shear]
    yield from np.column_stack(table).tolist()


def _text(number: float) -> str:
    return f"{number:.6g}" if np.isfinite(number) else ""
