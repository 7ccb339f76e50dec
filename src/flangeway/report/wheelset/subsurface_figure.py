"""Stresses below the contacts over depth: picture and table."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.exact.hertz_line_contact import DEPTH_OF_MAX_SHEAR
from flangeway.post import RecoveredStresses, Stresses, recovered_stresses
from flangeway.problems import ElasticField
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.wheelset.subsurface import (
    SEARCHED,
    SubsurfaceExtreme,
    by_normal,
    hertz_below,
    maximum_on,
    stresses_below,
)
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.drawing import INK, Room, draw_title, figure_with_room
from flangeway.results import ResultTable
from flangeway.types import Floats

CURVES = (
    ("across the surface", "#0b5394"),
    ("along the surface", "#9a6a00"),
    ("von Mises", "#8b1a8b"),
    ("maximum in-plane shear", INK),
)
ROOM = Room(bottom=0.85, between=0.45)
COLUMNS = (
    "side", "region", "body", "depth_mm", "x_mm", "y_mm", "along_surface_MPa", "across_surface_MPa", "shear_MPa",
    "out_of_plane_MPa", "von_mises_MPa", "in_plane_shear_MPa", "hertz_along_surface_MPa", "hertz_across_surface_MPa",
    "hertz_von_mises_MPa", "hertz_in_plane_shear_MPa",
)  # fmt: skip
"""Columns of the table; places are those of the undeformed profile, in its frame."""


@dataclass(frozen=True, eq=False)
class SubsurfaceLine:
    """Stresses below a contact in one of its bodies, in the axes of the surface's normal."""

    patch: WheelRailPatch
    body: Role  # patch, body: the contact, and which body
    depths: Floats  # depths below the undeformed surface in mm, shape (n,)
    points: Floats  # places on the undeformed profile, in its frame, shape (n, 2)
    found: Stresses
    hertz: Stresses | None
    """found, hertz: stresses at the points, recovered, and those of Hertz's theory, None where it has none."""
    top: SubsurfaceExtreme  # maximum in-plane shear, as in the summary


def subsurface_lines(result: WheelsetResult) -> list[SubsurfaceLine]:
    """Stresses below all contacts, each in the rail first."""
    sides = {patch.side for patch in result.patches}
    recovered = {
        name: recovered_stresses(ElasticField(part.body.elasticity, result.displacements[name]))
        for name, part in result.model.parts.items()
        if name.partition("-")[2] in sides
    }
    return [
        _line(result, patch, body, recovered[f"{body}-{patch.side}"])
        for patch in result.patches
        for body in ROLES[::-1]
    ]


def _line(result: WheelsetResult, patch: WheelRailPatch, body: Role, recovered: RecoveredStresses) -> SubsurfaceLine:
    line = stresses_below(result, patch, body)
    top = maximum_on(line.distances, line.stresses.in_plane_shear, SEARCHED)
    line = replace(line, stresses=recovered.at(line.points))
    hertz = None
    if patch.hertz is not None:
        hertz = hertz_below(patch.hertz, line.distances, result.model.problem.material_of(body).poisson)
    return SubsurfaceLine(patch, body, line.distances, line.points, by_normal(line), hertz, top)


def subsurface_figure(lines: Sequence[SubsurfaceLine]) -> Figure:
    """Draw stresses over depth, a row for each contact, rail and wheel beside each other, Hertz's dashed."""
    n_rows = max(len(lines) // len(ROLES), 1)
    figure, rows = figure_with_room(13.0, 0.9 + 3.4 * n_rows, ROOM, n_rows, len(ROLES), sharex=True)
    for axes, line in zip(rows.ravel(), lines, strict=False):
        alone = sum((other.patch.side, other.body) == (line.patch.side, line.body) for other in lines) == 1
        where = line.patch.side if alone else f"{line.patch.side}, {line.patch.region}"
        draw_title(axes, f"{line.body}: {where}".capitalize())
        _draw(axes, line)
    for axes in rows[-1]:
        axes.set_xlabel("stress in MPa, tension positive")
    if not lines:
        draw_title(rows[0, 0], "no contact")
        return figure
    figure.legend(*rows[0, 0].get_legend_handles_labels(), loc="lower center", ncols=5, fontsize=9, frameon=False)
    return figure


def _draw(axes: Axes, line: SubsurfaceLine) -> None:
    depths, theory = line.depths, line.patch.hertz
    for (name, colour), values in zip(CURVES, _curves(line.found), strict=True):
        axes.plot(values, depths, color=colour, lw=1.4, label=name)
    if line.hertz is not None:
        for (_, colour), values in zip(CURVES, _curves(line.hertz), strict=True):
            axes.plot(values, depths, color=colour, lw=1.0, ls=(0, (4, 2)))
        axes.plot([], [], color=INK, lw=1.0, ls=(0, (4, 2)), label="Hertz, half plane, same force")
    top = line.top
    axes.plot([top.value_MPa], [top.depth_mm], marker="o", color=INK, mfc="white", ms=5, zorder=4)
    text = f"maximum in-plane shear\n{top.value_MPa:.0f} MPa at {top.depth_mm:.1f} mm"
    if theory is not None:
        text += f"\nHertz: {theory.max_shear:.0f} MPa at {DEPTH_OF_MAX_SHEAR * theory.half_width:.1f} mm"
    axes.text(0.02, 0.04, text, transform=axes.transAxes, fontsize=9, va="bottom")
    axes.set_ylim(float(depths[-1]), 0.0)
    axes.axvline(0.0, color="#999999", lw=0.6)
    axes.grid(color="#dddddd", lw=0.5)
    axes.set_ylabel("depth in mm")


def _curves(stresses: Stresses) -> tuple[Floats, ...]:
    """Values of `CURVES`."""
    along, across, _, _ = stresses.components.T
    return across, along, stresses.von_mises, stresses.in_plane_shear


def subsurface_table(lines: Sequence[SubsurfaceLine]) -> str:
    """Return the stresses below all contacts as CSV, its columns `COLUMNS`; empty where there is no number."""
    rows = [(line.patch.side, line.patch.region, line.body, *row) for line in lines for row in _rows(line)]
    columns = zip(*rows, strict=True) if rows else ((),) * len(COLUMNS)
    return ResultTable(dict(zip(COLUMNS, columns, strict=True))).csv(6)


def _rows(line: SubsurfaceLine) -> list[list[float]]:
    found, hertz = line.found, line.hertz
    table = [line.depths, *line.points.T, *found.components.T, found.von_mises, found.in_plane_shear]
    if hertz is None:
        table += [np.full(len(line.depths), np.nan)] * 4
    else:
        table += [*hertz.components.T[:2], hertz.von_mises, hertz.in_plane_shear]
    rows: list[list[float]] = np.column_stack(table).tolist()
    return rows
