"""Pictures of a profile: its shape with measured points, curvature and deviation along it, and its joints to a body."""

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.profile.profile_run import ProfileRun
from flangeway.geometry import Contour, Outline, Placement
from flangeway.railway.profiles.formats.raw_profile import KINDS
from flangeway.railway.profiles.joining import Joined
from flangeway.report.figures.drawing import GREY, INK, SERIES, new_figure
from flangeway.types import Floats

BLUE, ORANGE = SERIES[:2]
TITLE_LETTERS = 70
OVERLAY_SPACING_MM, MOST_NAMED = 0.25, 8
DRAWN_DEVIATION_MM = 0.01
MAX_CURVATURE_PER_MM = 0.2


def shape_figure(run: ProfileRun) -> Figure:
    """Draw the profile with one scale: points and curve."""
    profile = run.profile
    figure = new_figure(8.5, 6.0)
    figure.set_layout_engine("compressed")
    axes = figure.subplots()
    body = run.body
    if body is not None and run.join is None:
        axes.plot(*_closed(body.outline).T, color=GREY, lw=0.9, label="whole outline")
        axes.plot(*_line(body.running_surface).T, color=BLUE, lw=1.8, label="running surface")
    else:
        axes.plot(*_line(profile.surface).T, color=BLUE, lw=1.6, label="curve", zorder=3)
    if profile.smoothing is not None:
        axes.plot(*profile.points.T, ".", ms=2.0, color=INK, label=f"{len(profile.points)} points", zorder=4)
    axes.plot(0.0, 0.0, "+", color=ORANGE, ms=12, mew=1.6, label="origin", zorder=5)
    axes.set_title(f"{_title(profile.title)}\n{profile.kind}, {profile.format}", fontsize=10)
    _equal(axes)
    axes.legend(loc="best", fontsize=8, frameon=False)
    return figure


def curvature_figure(run: ProfileRun) -> Figure:
    """Draw curvature along the running surface, and below it the points' distances from the curve."""
    smoothing = run.profile.smoothing
    figure = new_figure(8.5, 6.0 if smoothing is not None else 3.6)
    rows = figure.subplots(2 if smoothing is not None else 1, 1, sharex=True, squeeze=False)[:, 0]
    surface = run.running
    lengths = np.concatenate([[0.0], np.cumsum([segment.length for segment in surface.segments])])
    curvatures = np.array([segment.curvature for segment in surface.segments])
    rows[0].stairs(curvatures, lengths, color=BLUE, lw=1.0, baseline=None)
    rows[0].axhline(0.0, color=GREY, lw=0.6)
    low, high = float(curvatures.min(initial=0.0)), float(curvatures.max(initial=0.0))
    margin = 0.05 * max(high - low, 1e-4)
    rows[0].set(
        ylim=(max(low - margin, -MAX_CURVATURE_PER_MM), min(high + margin, MAX_CURVATURE_PER_MM)),
        ylabel="curvature in 1/mm, convex positive",
    )
    start = "from the field side to the gauge side" if run.profile.kind == "rail" else "from the flange to the rim"
    rows[-1].set_xlabel(f"length along the profile in mm, {start}")
    title = f"{_title(run.profile.title)}: curvature of the {surface.n_segments} lines and arcs"
    rows[0].set_title(title, fontsize=10)
    if smoothing is not None:
        _draw_residuals(rows[1], run)
    return figure


def join_figure(joined: Joined) -> Figure:
    """Draw the measured surface on the nominal outline with both transitions, and deviations along the normal."""
    figure = new_figure(8.5, 8.6)
    whole, below = figure.subplots(2, 1, height_ratios=(2.2, 1.0))
    whole.plot(*_closed(joined.nominal.outline).T, color=GREY, lw=1.0, ls=(0, (5, 3)), label="nominal")
    whole.plot(*_closed(joined.profile.outline).T, color=INK, lw=1.0, label="joined")
    whole.plot(*_line(joined.measured).T, color=BLUE, lw=2.0, label="measured", zorder=3)
    for joint, label in zip(joined.joints, ("transition", None), strict=True):
        whole.plot(*np.array([joint.end, joint.landing]).T, color=ORANGE, lw=2.0, label=label, zorder=4)
    _equal(whole)
    whole.legend(fontsize=8, frameon=False, loc="best")
    whole.set_title(_title(joined.profile.title), fontsize=10)
    _draw_wear(below, joined)
    return figure


def _draw_wear(axes: Axes, joined: Joined) -> None:
    """Draw how far the measured surface is off the nominal outline along its normal."""
    points = _line(joined.measured)
    off = deviations(joined.nominal.outline, points)
    x, most = points[:, 0], int(off.argmin())
    axes.fill_between(x, off, 0.0, where=off < 0.0, color=BLUE, alpha=0.25, lw=0.0)
    axes.plot(x, off, color=BLUE, lw=1.4)
    axes.axhline(0.0, color=GREY, lw=1.0, ls=(0, (5, 3)))
    if off[most] < 0.0:
        axes.plot(x[most], off[most], "o", ms=5, mfc="white", mec=INK)
    worn = f"; at most {-off[most]:.3g} mm below it at x = {x[most]:.3g} mm" if off[most] < 0.0 else ""
    axes.set_title(f"measured surface off the nominal outline along its normal{worn}", fontsize=9)
    axes.set(xlabel="x in mm", ylabel="deviation in mm\n(below zero: worn)")
    axes.grid(color="#dddddd", lw=0.5)


def overlay_figure(runs: Sequence[ProfileRun]) -> Figure:
    """Draw profiles over each other, rails and wheels apart, and below the distance of each from the first."""
    kinds = [kind for kind in KINDS if any(run.profile.kind == kind for run in runs)]
    figure = new_figure(4.0 + 4.5 * len(kinds), 7.0)
    panels = figure.subplots(2, len(kinds), squeeze=False, height_ratios=(1.4, 1.0))
    for (shapes, apart), kind in zip(panels.T, kinds, strict=True):
        chosen = [run for run in runs if run.profile.kind == kind]
        shades = sequence_colours(len(chosen))
        first = _running(chosen[0])
        for run, shade in zip(chosen, shades, strict=True):
            surface = _running(run)
            title = _title(run.profile.title)
            shapes.plot(*_line(surface).T, color=shade, lw=1.2, label=title)
            if run is not chosen[0]:
                at = surface.sampled(spacing=OVERLAY_SPACING_MM)
                apart.plot(at[:, 0], deviations(first, at), color=shade, lw=1.0, label=title)
        _equal(shapes)
        shapes.set_title(f"{len(chosen)} {kind}{'s' * (len(chosen) > 1)}", fontsize=10)
        where = "tape line" if kind == "wheel" else "origin"
        apart.set(xlabel=f"from the {where} in mm", ylabel="off the first along its normal, in mm")
        apart.axhline(0.0, color=GREY, lw=0.6)
        apart.grid(color="#e4e4e4", linewidth=0.5)
        # of many profiles the first and the last
        handles, labels = shapes.get_legend_handles_labels()
        kept = range(len(labels)) if len(labels) <= MOST_NAMED else (0, len(labels) - 1)
        apart.legend(
            [handles[i] for i in kept], [labels[i] for i in kept],
            fontsize=8, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=2,
        )  # fmt: skip
    return figure


def sequence_colours(count: int) -> list[tuple[float, ...]]:
    """Colours of curves in their order, apart in grey too; the first is dark."""
    return [tuple(each) for each in colormaps["viridis"](np.linspace(0.0, 0.88, max(count, 2))[:count])]


def _running(run: ProfileRun) -> Contour:
    """The running surface of a profile, as its file has it; of a whole rail from its top."""
    if run.body is None or run.join is not None:
        return run.profile.surface
    surface = run.body.running_surface
    if run.profile.kind == "wheel":
        return surface
    return surface.transformed(Placement(translation=(0.0, -float(surface.bounds()[1, 1]))))


def deviations(reference: Contour, points: Floats) -> Floats:
    """Distances (n,) of points from a contour along its normals, outwards positive; nan beyond its ends."""
    numbers, parameters, _ = reference.closest(points)
    off = np.empty(len(points))
    for number in np.unique(numbers):
        here, segment = numbers == number, reference.segments[number]
        apart = points[here] - segment.point(parameters[here])
        off[here] = np.einsum("ni,ni->n", apart, segment.normal(parameters[here]))
    if not isinstance(reference, Outline):
        last = reference.n_segments - 1
        off[((numbers == 0) & (parameters <= 0.0)) | ((numbers == last) & (parameters >= 1.0))] = np.nan
    return off


def _draw_residuals(axes: Axes, run: ProfileRun) -> None:
    smoothing = run.profile.smoothing
    if smoothing is None:
        return
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(run.profile.points, axis=0).T))])
    axes.plot(lengths, smoothing.deviations_um, ".", ms=2.5, color=INK)
    if smoothing.wavelength_mm > 0.0:
        for sign in (-1.0, 1.0):
            axes.axhline(sign * smoothing.limit_um, color=ORANGE, lw=0.8, ls="--")
        text = (
            f"smoothed by {smoothing.wavelength_mm:g} mm; root mean square {smoothing.rms_um:.2f} μm, "
            f"maximum {smoothing.maximum_um:.2f} μm, limit {smoothing.limit_um:.3g} μm"
        )
    else:
        text = "curve through all points"
    axes.set_title(text, fontsize=9)
    axes.set_ylabel("points off the curve in μm")


def _equal(axes: Axes) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x in mm", ylabel="y in mm")


def _line(contour: Contour) -> Floats:
    return contour.sampled(max_deviation=DRAWN_DEVIATION_MM)


def _closed(outline: Contour) -> Floats:
    points = _line(outline)
    return np.vstack([points, points[:1]])


def _title(text: str) -> str:
    return textwrap.shorten(text, TITLE_LETTERS, placeholder=" ...")
