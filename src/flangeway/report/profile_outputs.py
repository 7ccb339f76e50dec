"""Pictures, record and files of ``flangeway profile``."""

import textwrap
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.cases.profile_run import (
    FOLDER_QUANTITIES,
    MEASURES,
    QUANTITIES,
    FolderProfile,
    ProfileFolder,
    ProfileRun,
    converted,
    nearest_nominal,
)
from flangeway.errors import InputError
from flangeway.geometry import Contour, Outline, Placement
from flangeway.geometry.arrays import chain_lengths
from flangeway.quantities import Quantity, columns, measured, values
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.profiles.formats.two_column import KINDS, Kind
from flangeway.railway.profiles.joining import Joined, joined
from flangeway.railway.profiles.profile_file import MeasuredProfile
from flangeway.report.figures.drawing import (
    GREY,
    INK,
    PAGE_IN,
    SERIES,
    name_axes,
    new_figure,
    panels,
    sequence_colours,
    units_of,
)
from flangeway.report.page.record import Again, Picture, Report, SummaryTable, table_across, table_of
from flangeway.system.output_folder import refuse_unwritable
from flangeway.types import Floats
from flangeway.units import Units

# --- Pictures of a profile: its shape with measured points, curvature and deviation along it, and its joints to a body.


BLUE, ORANGE = SERIES[:2]
NOMINAL = (0, (5, 3))
TITLE_LETTERS = 70
OVERLAY_SPACING_MM, MAX_NAMED = 0.25, 8
DRAWN_DEVIATION_MM = 0.01
SHOWN_BEYOND_MM = 8.0
"""Height that is drawn above and below a measured surface on its nominal body."""
MAX_CURVATURE_PER_MM = 0.2


def shape_figure(run: ProfileRun, units: Units = "metric") -> Figure:
    """Draw the profile with one scale: points and curve."""
    profile, body = run.profile, run.body
    axes = new_figure(PAGE_IN, 3.8, units, compressed=True).subplots()
    if body is not None and run.join is None:
        _draw_body(axes, body)
    else:
        axes.plot(*_line(profile.surface).T, color=BLUE, lw=1.6, label="curve", zorder=3)
    if profile.smoothing is not None:
        axes.plot(*profile.points.T, ".", ms=2.0, color=INK, label=f"{len(profile.points)} points", zorder=4)
    axes.plot(0.0, 0.0, "+", color=ORANGE, ms=12, mew=1.6, label="origin", zorder=5)
    axes.set_title(f"{_title(profile.title)}\n{profile.kind}, {profile.format}", fontsize=9)
    return _shape(axes)


def profile_figure(profile: RailProfile | WheelProfile) -> Figure:
    """Draw the outline of a profile and its running surface with one scale."""
    axes = new_figure(PAGE_IN, 4.2, compressed=True).subplots()
    _draw_body(axes, profile)
    axes.set_title(_title(profile.title), fontsize=9)
    return _shape(axes)


def _draw_body(axes: Axes, profile: RailProfile | WheelProfile) -> None:
    axes.plot(*_closed(profile.outline).T, color=GREY, lw=0.9, label="whole outline")
    axes.plot(*_line(profile.running_surface).T, color=BLUE, lw=1.8, label="running surface")


def _shape(axes: Axes) -> Figure:
    """Give axes one scale, names and a legend; return their figure."""
    axes.set_aspect("equal", adjustable="datalim")
    name_axes(axes, ("x", "mm"), ("y", "mm"))
    axes.legend(loc="best", fontsize=8, frameon=False)
    return axes.get_figure(root=True)  # type: ignore[return-value]


def curvature_figure(run: ProfileRun, units: Units = "metric") -> Figure:
    """Draw curvature along the running surface, and below it the points' distances from the curve."""
    smoothing, surface = run.profile.smoothing, run.running
    n_rows = 1 if smoothing is None else 2
    figure, rows = panels(PAGE_IN, 0.8 + 1.8 * n_rows, n_rows, 1, units, sharex=True)
    axes = rows[0, 0]
    lengths = surface.offsets
    curvatures = np.array([segment.curvature for segment in surface.segments])
    axes.stairs(curvatures, lengths, color=BLUE, lw=1.0, baseline=None)
    axes.axhline(0.0, color=GREY, lw=0.6)
    low, high = float(curvatures.min(initial=0.0)), float(curvatures.max(initial=0.0))
    margin = 0.05 * max(high - low, 1e-4)
    axes.set_ylim(max(low - margin, -MAX_CURVATURE_PER_MM), min(high + margin, MAX_CURVATURE_PER_MM))
    start = "field side to gauge side" if run.profile.kind == "rail" else "flange to rim"
    name_axes(rows[-1, 0], (f"length along the profile, {start}", "mm"))
    name_axes(axes, y=("curvature, convex positive", "1/mm"))
    title = f"{_title(run.profile.title)}: curvature of the {surface.n_segments} lines and arcs"
    axes.set_title(title, fontsize=9)
    if smoothing is not None:
        _draw_residuals(rows[1, 0], run)
    return figure


def join_figure(joined: Joined, units: Units = "metric") -> Figure:
    """Draw the measured surface on the nominal outline with both transitions, and deviations along the normal."""
    _, ((whole,), (below,)) = panels(PAGE_IN, 4.2, 2, 1, units, height_ratios=(1.7, 1.0))
    whole.plot(*_closed(joined.nominal.outline).T, color=GREY, lw=1.0, ls=NOMINAL, label="nominal")
    whole.plot(*_closed(joined.profile.outline).T, color=INK, lw=1.0, label="joined")
    whole.plot(*_line(joined.measured).T, color=BLUE, lw=2.0, label="measured", zorder=3)
    for joint, label in zip(joined.joints, ("transition", None), strict=True):
        whole.plot(*np.array([joint.end, joint.landing]).T, color=ORANGE, lw=2.0, label=label, zorder=4)
    whole.set_title(_title(joined.profile.title), fontsize=9)
    points = _line(joined.measured)
    ends = points[:, 1].min() - SHOWN_BEYOND_MM, points[:, 1].max() + SHOWN_BEYOND_MM
    whole.set_ylim(*ends, auto=True)  # the scale of both axes may widen it
    off = deviations(joined.nominal.outline, points)
    x, lowest, worn = points[:, 0], int(off.argmin()), ""
    below.fill_between(x, off, 0.0, where=off < 0.0, color=BLUE, alpha=0.25, lw=0.0)
    below.plot(x, off, color=BLUE, lw=1.4)
    below.axhline(0.0, color=GREY, lw=1.0, ls=NOMINAL)
    if off[lowest] < 0.0:
        below.plot(x[lowest], off[lowest], "o", ms=5, mfc="white", mec=INK)
        depth, position = (measured(value, "mm", units, ".3g") for value in (-off[lowest], x[lowest]))
        worn = f"; at most {depth} below it at x = {position}"
    below.set_title(f"measured surface off the nominal outline along its normal{worn}", fontsize=9)
    name_axes(below, ("x", "mm"), ("off the nominal", "mm"))
    return _shape(whole)


def overlay_figure(runs: Sequence[ProfileRun], units: Units = "metric") -> Figure:
    """Draw profiles over each other, rails and wheels apart, and below the distance of each from the first."""
    kinds = [kind for kind in KINDS if any(run.profile.kind == kind for run in runs)]
    figure, rows = panels(PAGE_IN, 4.2, 2, len(kinds), units, height_ratios=(1.4, 1.0))
    for (shapes, apart), kind in zip(rows.T, kinds, strict=True):
        chosen = [run for run in runs if run.profile.kind == kind]
        first = _running(chosen[0])
        for run, shade in zip(chosen, sequence_colours(len(chosen)), strict=True):
            surface, title = _running(run), _title(run.profile.title)
            shapes.plot(*_line(surface).T, color=shade, lw=1.2, label=title)
            if run is not chosen[0]:
                at = surface.sampled(spacing=OVERLAY_SPACING_MM)
                apart.plot(at[:, 0], deviations(first, at), color=shade, lw=1.0)
        if len(chosen) > MAX_NAMED:  # of many profiles the first and the last
            for line in shapes.lines[1:-1]:
                line.set_label("")
        _shape(shapes)
        shapes.set_title(f"{len(chosen)} {kind}{'s' * (len(chosen) > 1)}", fontsize=9)
        name_axes(apart, (f"from the {'tape line' if kind == 'wheel' else 'origin'}", "mm"), ("off the first", "mm"))
        apart.axhline(0.0, color=GREY, lw=0.6)
    return figure


def _running(run: ProfileRun) -> Contour:
    """The running surface of a profile, as its file has it; of a whole rail from its top."""
    if run.body is None or run.join is not None:
        return run.profile.surface
    surface = run.body.running_surface
    if run.profile.kind == "wheel":
        return surface
    return surface.transformed(Placement(translation=(0.0, -surface.top)))


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
    smoothing, units = run.profile.smoothing, units_of(axes)
    assert smoothing is not None
    lengths = chain_lengths(run.profile.points)
    axes.plot(lengths, smoothing.deviations_um, ".", ms=2.5, color=INK)
    text = "curve through all points"
    if smoothing.wavelength_mm > 0.0:
        for sign in (-1.0, 1.0):
            axes.axhline(sign * smoothing.limit_um, color=ORANGE, lw=0.8, ls="--")
        sizes = (smoothing.rms_um, smoothing.maximum_um, smoothing.limit_um)
        rms, maximum, limit = (measured(size, "µm", units, ".3g") for size in sizes)
        wavelength = measured(smoothing.wavelength_mm, "mm", units)
        text = f"smoothed by {wavelength}; root mean square {rms}, maximum {maximum}, limit {limit}"
    axes.set_title(text, fontsize=9)
    name_axes(axes, y=("points off the curve", "µm"))


def _line(contour: Contour) -> Floats:
    return contour.sampled(max_deviation=DRAWN_DEVIATION_MM)


def _closed(outline: Contour) -> Floats:
    points = _line(outline)
    return np.vstack([points, points[:1]])


def _title(text: str) -> str:
    return textwrap.shorten(text, TITLE_LETTERS, placeholder=" ...")


# --- Report and files of ``flangeway profile``.


SUMMARY = "profile.json"
TABLE, OVERLAY, BATCH_SUMMARY = "profiles.csv", "profiles.png", "profiles.json"
BATCH = ("format", "points", "length", "minimum_convex_radius", "minimum_concave_radius", "noise")  # of all in CSV
MAX_WORST, MAX_JOINED = 40, 2  # profiles of a kind in the table that is not folded, and in pictures
OVERLAY_SHOWN = "All profiles, and the distance of each from the first."


def checked_conversion(run: ProfileRun, to: Path | None) -> str:
    """Return the text of a profile's file in the format of another one, if there is one, before anything is written.

    It is an `InputError` if the file cannot be written or has no name, its format is unknown, of the other kind, or
    holds no whole outline.
    """
    if to is None:
        return ""
    if not to.name:
        raise InputError(f"--to {to}", "the name of a file", "give a file with an ending")
    text = converted(run, to.suffix.lower())
    refuse_unwritable(to.parent, (to.name,))
    return text


def profile_record(run: ProfileRun, command: str, units: Units = "metric", nominal: str | None = None) -> Report:
    """Return what was read and measured of a profile.

    - `command`: reads it again.
    - `nominal`: bundled profile that it was when new, the nearest one if left out.
    """
    summary, join = run.summary, run.join
    pictures = [
        Picture("profile.png", lambda: shape_figure(run, units), "The profile with its points, lines and arcs."),
        Picture("curvature.png", lambda: curvature_figure(run, units), "Curvature along the profile."),
    ]
    if join is not None:
        caption = "The profile joined to the body of the nominal one."
        pictures.insert(1, Picture("joined.png", partial(join_figure, join, units), caption))
    elif run.body is None:  # measured, a running surface alone
        pictures[1:1] = _on_nominal(run.profile, nearest_nominal(run.profile, nominal), "worn.png", units)
    there = [quantity for quantity in QUANTITIES if quantity.value(run) is not None]
    return Report(
        name=run.profile.title,
        title=run.profile.title,
        subtitle=f"{run.profile.kind}, {run.profile.format}; {run.frame}",
        converged=True,
        success="read",
        message=f"{len(run.profile.points)} points, {run.profile.surface.n_segments} lines and arcs",
        facts=[quantity.fact(run, units) for quantity in there if quantity in MEASURES[:5] or quantity.key == "area"],
        results=replace(table_across("Profile", ("value",), [run], there, units=units), of_words=True),
        summary=summary,
        summary_file=SUMMARY,
        again=Again(command, files=f"The same numbers, for programs, are in `{SUMMARY}`."),
        units=units,
        notes=[
            *run.notices,
            *(f"{key.capitalize()}: " + summary[key] for key in ("certainty", "source") if summary[key]),
        ],
        pictures=lambda: pictures,
    )


def profiles_record(runs: Sequence[ProfileRun], command: str, units: Units = "metric") -> Report:
    """Return the measures of several profiles side by side; `command` reads them again."""
    title: Quantity[ProfileRun] = Quantity("title", "profile", lambda run: run.profile.title)
    kind: Quantity[ProfileRun] = Quantity("kind", "kind", lambda run: run.profile.kind)
    chosen = [quantity for quantity in QUANTITIES if quantity.key in BATCH]
    shown = [quantity for quantity in MEASURES[:4] if any(quantity.value(run) is not None for run in runs)]
    return Report(
        name=f"{len(runs)} profiles",
        title=f"{len(runs)} profiles",
        subtitle="measures of each profile alone",
        converged=True,
        success="read",
        message="",
        results=table_of("Profiles", runs, [title, *shown], units=units),
        summary={"profiles": [run.summary for run in runs]},
        summary_file=BATCH_SUMMARY,
        again=Again(command, files=f"The table is in `{TABLE}`, all numbers of each profile are in `{BATCH_SUMMARY}`."),
        units=units,
        notes=_notes(runs),
        pictures=lambda: [Picture(OVERLAY, lambda: overlay_figure(runs, units), OVERLAY_SHOWN)],
        files=lambda: {TABLE: columns((title, kind, *chosen, *MEASURES), runs, units).to_csv},
    )


def _notes(runs: Sequence[ProfileRun]) -> list[str]:
    """Return the notices of several profiles, each once, with the titles of those that have it unless all do."""
    by_notice: dict[str, list[str]] = {}
    for run in runs:
        for notice in run.notices:
            by_notice.setdefault(notice, []).append(run.profile.title)
    return [
        notice if len(titles) == len(runs) else notice + f" ({', '.join(titles)})"
        for notice, titles in by_notice.items()
    ]


def folder_record(folder: ProfileFolder, name: str, command: str, units: Units = "metric") -> Report:
    """Return wear, measures and conicity of the profiles of a folder, the most worn first, and notices on its files."""
    rows = folder.profiles
    runs = [replace(row.run, profile=replace(row.run.profile, title=row.file)) for row in rows]
    worst, whole, facts = [], [], []
    for kind in dict.fromkeys(row.run.profile.kind for row in rows):
        chosen = [row for row in rows if row.run.profile.kind == kind]
        there = [q for q in FOLDER_QUANTITIES if q.key != "kind" and any(q.value(row) is not None for row in chosen)]
        few = (
            f"The {MAX_WORST} most worn {kind}s"
            if len(chosen) > MAX_WORST
            else f"{kind.capitalize()}s, the most worn first"
        )
        worst.append(table_of(few, chosen[:MAX_WORST], there, units=units))
        if len(chosen) > MAX_WORST:
            whole.append(table_of(f"All {kind}s, the most worn first", chosen, there, units=units))
        facts.append((measured(chosen[0].worst_mm, "mm", units, ".2f"), f"largest wear of a {kind}: {chosen[0].file}"))
    files: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        files.setdefault(row.notices, []).append(row.file)
    notices = [("\n".join(names), " ".join(of_files)) for of_files, names in files.items() if of_files]
    n_noticed = sum(bool(row.notices) for row in rows)
    compared = f"{folder.nominal} or the nearest" if folder.nominal else "the nearest"
    return Report(
        name=name,
        title=f"{len(rows)} profiles of {name}",
        subtitle=f"wear against {compared} bundled profile, measures, and conicity in standard gauge with a partner",
        converged=True,
        success="read",
        message=f"{len(rows)} profiles; refused files: {len(folder.refused)}; files with notices: {n_noticed}",
        facts=facts,
        results=worst[0],
        tables=whole,
        chapters={
            **{table.caption: [table] for table in worst[1:]},
            "Pictures": [],  # behind all tables
            "Notices": [SummaryTable("How files were read", ("files", ""), tuple(notices), of_words=True)]
            * bool(notices),
        },
        summary={
            "profiles": [{**values(FOLDER_QUANTITIES, row), "notices": row.notices} for row in rows],
            "refused": folder.refused,
        },
        summary_file=BATCH_SUMMARY,
        again=Again(command, files=f"The table is in `{TABLE}`, the notices on each file also in `{BATCH_SUMMARY}`."),
        units=units,
        warnings=folder.refused,
        pictures=lambda: [
            Picture(OVERLAY, lambda: overlay_figure(runs, units), OVERLAY_SHOWN),
            *(picture for kind in KINDS for picture in _joined_pictures(rows, kind, units)),
        ],
        files=lambda: {TABLE: folder.table.in_units(units).to_csv},
    )


def _joined_pictures(rows: Sequence[FolderProfile], kind: Kind, units: Units) -> list[Picture]:
    """Return pictures of the most worn profiles of a kind on the bodies of their nominal ones, as far as they fit."""
    pictures: list[Picture] = []
    for row in rows:
        if row.run.profile.kind == kind and len(pictures) < MAX_JOINED:
            profile, file = replace(row.run.profile, title=row.file), f"worn-{kind}-{len(pictures) + 1}.png"
            pictures += _on_nominal(profile, row.nominal, file, units)
    return pictures


def _on_nominal(profile: MeasuredProfile, nominal: str | None, file: str, units: Units) -> list[Picture]:
    """Return the picture of a measured profile on the body of its nominal one, if it fits."""
    try:
        join = joined(profile, nominal) if nominal is not None else None
    except InputError:  # a whole outline, or a surface too short for contact
        join = None
    caption = f"{profile.title} on the nominal {nominal}; below, how far its surface is off along the normal."
    return [Picture(file, partial(join_figure, join, units), caption)] if join is not None else []
