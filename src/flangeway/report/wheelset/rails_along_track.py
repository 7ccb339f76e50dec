"""Rails along the track: picture, table and CSV file."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.quantities import Quantity
from flangeway.railway.wheelset.rail_along_track import REGIONS, RailAlongTrack
from flangeway.report.figures.drawing import GREY, INK, SIDE_COLOURS, Style, name_axes, panels
from flangeway.report.page.tables import SummaryTable, table_across
from flangeway.results import ResultTable
from flangeway.types import Floats
from flangeway.units import us_unit

STYLES = {"left": "-", "right": "--"}  # of symmetric wheelsets both are one line


def _foot(rail: RailAlongTrack) -> Floats:
    """Normal stress along the track in the middle of the base, MPa, shape (n_z,)."""
    points = rail.stresses.points_mm
    foot = np.flatnonzero(rail.stresses.regions == "foot")
    lowest = foot[points[foot, 1] <= points[foot, 1].min() + 1e-6]
    middle = lowest[np.argmin(np.abs(points[lowest, 0] - points[lowest, 0].mean()))]
    found: Floats = rail.stresses.along_MPa[:, middle]
    return found


LINES: tuple[tuple[str, str, Callable[[RailAlongTrack], Floats]], ...] = (
    ("top of the rail down", "mm", lambda rail: -rail.head[:, 1]),
    ("gauge-face deflection, outwards", "mm", lambda rail: rail.gauge_outward_mm),
    ("stress under the foot", "MPa", _foot),
)
"""What is drawn along the track, one panel each."""


def rails_figure(run: WheelsetRun) -> Figure:
    """Draw deflection, gauge face and stress under the foot of both rails along the track, and sleepers with forces."""
    rails, units = run.space.rails, run.case.units
    figure, rows = panels(9.0, 7.0, len(LINES), 1, units, sharex=True)
    for axes, (words, unit, values) in zip(rows[:, 0], LINES, strict=True):
        for side, rail in rails.items():
            style: Style = {"color": SIDE_COLOURS[side], "ls": STYLES[side], "lw": 1.5, "label": f"{side} rail"}
            axes.plot(rail.z_mm / 1e3, values(rail), **style)
        axes.axhline(0.0, color=GREY, lw=0.8)
        name_axes(axes, y=(words, unit))
    top = rows[0, 0]
    top.invert_yaxis()
    first = next(iter(rails.values()))
    kip = us_unit("kN") if units == "us" else None
    for number, z in enumerate(first.sleepers_mm):
        if abs(z) <= np.abs(first.z_mm).max():
            top.axvline(z / 1e3, color=GREY, lw=0.6, ls=":")
            seats = (rail.reactions[number, 1] / 1e3 for rail in rails.values())
            forces = " / ".join(f"{kip.of(seat):z.1f}" if kip else f"{seat:z.0f}" for seat in seats)
            place: Style = {"xycoords": ("data", "axes fraction"), "ha": "center"}
            top.annotate(forces, (z / 1e3, 1.02), fontsize=7, color=INK, **place)
    if len(first.sleepers_mm):
        words = f"forces of the sleepers on the left / right rail, {kip.name if kip else 'kN'}"
        top.set_title(words, fontsize=9, pad=16, loc="left")
    top.legend(loc="lower right", fontsize=8)
    name_axes(rows[-1, 0], ("z ahead of the axle", "m"))
    return figure


def rails_table(run: WheelsetRun) -> SummaryTable:
    """Return maxima of both rails, with the places of the stresses."""
    rails, units = run.space.rails, run.case.units
    quantities: list[Quantity[RailAlongTrack]] = [
        Quantity("down", "top of the rail down", lambda rail: -rail.head[:, 1].min(), "mm", ".3f"),
        Quantity("gauge", "gauge-face deflection", lambda rail: rail.gauge_outward_mm.max(), "mm", ".3f"),
    ]
    if len(next(iter(rails.values())).sleepers_mm):
        force: Callable[[RailAlongTrack], float] = lambda rail: rail.reactions[:, 1].max() / 1e3  # noqa: E731
        quantities.append(Quantity("seat", "maximum force of a sleeper", force, "kN", ".2f"))
    for region in REGIONS:
        for name, kind in (("stress along the track", "along_MPa"), ("von Mises stress", "von_mises_MPa")):
            peak, place = (partial(_peak, region, kind, part) for part in (0, 1))
            quantities.append(Quantity(kind, f"{region}: {name}", peak, "MPa", ".1f"))
            quantities.append(Quantity(f"{kind}_at", "  at", place, "mm", ".0f", ("x", "y", "z")))
    caption = "Rails along the track: maximum values"
    return table_across(caption, rails, list(rails.values()), quantities, units=units)


def _peak(region: str, kind: str, part: int, rail: RailAlongTrack) -> Any:
    """Maximum of a stress in a region, and its place."""
    return rail.stresses.peak(region, getattr(rail.stresses, kind))[part]


def rails_csv(run: WheelsetRun) -> str:
    """Return both rails along the track as a CSV file, a row for each place."""
    names = "side,z_mm,base_x_mm,base_y_mm,base_roll_rad,head_x_mm,head_y_mm,head_roll_rad,gauge_outward_mm,foot_MPa"
    rows = []
    for side, rail in run.space.rails.items():
        table = np.column_stack((rail.z_mm, rail.base, rail.head, rail.gauge_outward_mm, _foot(rail)))
        rows += [(side, *row) for row in table.tolist()]
    columns = dict(zip(names.split(","), zip(*rows, strict=True), strict=True))
    return ResultTable(columns).in_units(run.case.units).csv(6)
