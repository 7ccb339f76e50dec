"""Pictures of a contact in three dimensions: patches from above, pressure along both axes, stresses below."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from flangeway.cases.spatial.spatial_case import SpatialRun
from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.figures.plots import COLOURS
from flangeway.types import Bools, Floats

CURVES = (
    ("across, x", "#0b5394", "-"), ("normal, y", INK, "-"), ("along, z", "#9a6a00", "-"),
    ("von Mises", "#8b1a8b", "--"), ("Tresca", "#2e7d32", "-."),
)  # fmt: skip
N_PROFILE = 241
HIGHEST, LOWEST, WIDE = 1.6, 0.45, 0.8
"""Height over width of the picture from above, at most and at least, and where the scale is below it."""


def patch_figure(run: SpatialRun) -> Figure:
    """Draw the pressures from above, y towards the reader, with the outline of the patches and Hertz's ellipses."""
    found = run.contact
    grid, pressures = found.pair.grid, found.pressures
    s, middle = _across(run, grid.bounds), grid.along
    z = np.append(middle - grid.strip / 2.0, middle[-1] + grid.strip / 2.0)
    ratio = float(np.clip(np.ptp(z) / np.ptp(s), LOWEST, HIGHEST))
    figure = new_figure(7.0, 1.2 + 5.0 * ratio)
    axes = figure.subplots()
    shown = np.where(pressures > 0.0, pressures, np.nan)
    drawn = axes.pcolormesh(s, z, shown.T, cmap=COLOURS, vmin=0.0, rasterized=True)
    centres = (s[1:] + s[:-1]) / 2.0
    axes.contour(centres, middle, pressures.T > 0.0, levels=[0.5], colors=[INK], linewidths=1.0)
    for number, patch in enumerate(found.patches):
        hertz = found.hertz(patch)
        if hertz is None:
            continue
        place = _across_of(run, patch.inside), float(patch.centre[2])
        # the longer semi-axis is turned from z towards rising lengths, which run to the left
        turned = 90.0 + float(np.rad2deg(patch.angle_rad))
        axes.add_patch(
            Ellipse(
                place, 2.0 * hertz.semi_axes[0], 2.0 * hertz.semi_axes[1], angle=turned,
                fill=False, ec=GREY, ls="--", lw=1.2, label="" if number else "Hertz",
            )
        )  # fmt: skip
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("length along the surface, across z, in mm")
    axes.set_ylabel("z in mm")
    side = "bottom" if ratio < WIDE else "right"
    figure.colorbar(drawn, ax=axes, label="contact pressure in MPa", shrink=0.9, location=side)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", fontsize=8)
    return figure


def pressure_figure(run: SpatialRun) -> Figure:
    """Draw the pressure across and along z through the cell of the maximum pressure, beside Hertz's."""
    found = run.contact
    grid, pressures, patch = found.pair.grid, found.pressures, found.patches[0]
    row, strip = np.unravel_index(int(np.where(patch.inside, pressures, 0.0).argmax()), pressures.shape)
    hertz = found.hertz(patch)
    bounds = _across(run, grid.bounds)
    s, z = (bounds[1:] + bounds[:-1]) / 2.0, grid.along
    centre = np.array([_across_of(run, patch.inside), patch.centre[2]])
    figure = new_figure(9.0, 3.6)
    lines = ((s, pressures[:, strip], "across z"), (z, pressures[row], "along z"))
    for axis, (axes, (along, values, name)) in enumerate(zip(figure.subplots(1, 2, sharey=True), lines, strict=True)):
        axes.plot(along, values, color=INK, lw=1.0, marker="o", ms=2.5, mfc="white", label="computed")
        if hertz is not None:
            fine: Floats = np.linspace(along.min(), along.max(), N_PROFILE)
            offset = np.tile(np.array([s[row], z[strip]]) - centre, (N_PROFILE, 1))
            offset[:, axis] = fine - centre[axis]
            cosine, sine = np.cos(patch.angle_rad), np.sin(patch.angle_rad)
            long, short = offset[:, 1] * cosine - offset[:, 0] * sine, offset[:, 1] * sine + offset[:, 0] * cosine
            inside = 1.0 - (long / hertz.semi_axes[0]) ** 2 - (short / hertz.semi_axes[1]) ** 2
            axes.plot(
                fine, hertz.max_pressure * np.sqrt(np.maximum(inside, 0.0)), color=GREY, lw=1.6, ls="--", zorder=1,
                label=f"Hertz: maximum {hertz.max_pressure:.4g} MPa",
            )  # fmt: skip
        axes.set_xlabel(f"length {name} in mm")
        axes.set_ylim(bottom=0.0)
        axes.grid(color="#dddddd", linewidth=0.6)
    figure.axes[0].set_ylabel("contact pressure in MPa")
    figure.axes[0].legend(loc="lower center", fontsize=8)
    return figure


def depth_figure(run: SpatialRun) -> Figure:
    """Draw the stresses below the centre of the first patch in both bodies over the depth."""
    figure = new_figure(9.0, 4.6)
    pair = run.contact.pair
    names = (pair.first.name, pair.second.name)
    for axes, name, profile in zip(figure.subplots(1, 2, sharey=True), names, run.profiles, strict=True):
        stresses = profile.stresses
        xx, yy, zz = stresses.components[:, :3].T
        for (label, colour, style), values in zip(
            CURVES, (xx, yy, zz, stresses.von_mises, stresses.tresca), strict=True
        ):
            axes.plot(values, profile.depths, color=colour, ls=style, lw=1.3, label=label)
        axes.axvline(0.0, color=GREY, lw=0.8)
        axes.set_title(name, fontsize=10)
        axes.set_xlabel("stress in MPa")
        axes.grid(color="#dddddd", linewidth=0.6)
    figure.axes[0].set_ylabel("depth in mm")
    figure.axes[0].set_ylim(float(run.profiles[0].depths[-1]), 0.0)
    figure.axes[0].legend(loc="lower left", fontsize=8)
    return figure


def _across(run: SpatialRun, stations: Floats) -> Floats:
    """Lengths along the first body's surface from the first patch's centre to the right."""
    contact = run.contact
    return _station(run, contact.patches[0].inside) - stations


def _across_of(run: SpatialRun, inside: Bools) -> float:
    """The same of the centre of pressure of some cells."""
    return float(_across(run, np.array([_station(run, inside)]))[0])


def _station(run: SpatialRun, inside: Bools) -> float:
    grid = run.contact.pair.grid
    forces = np.where(inside, run.contact.contact.forces, 0.0).sum(axis=1)
    return float(forces @ (grid.bounds[1:] + grid.bounds[:-1])) / (2.0 * float(forces.sum()))
