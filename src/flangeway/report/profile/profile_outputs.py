"""Record and files of ``flangeway profile``."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flangeway.cases.profile.profile_run import ProfileRun, converted
from flangeway.errors import InputError
from flangeway.report.page.record import REPORT, Again, Picture, Record
from flangeway.report.page.tables import SummaryTable, number
from flangeway.report.profile.profile_figures import curvature_figure, join_figure, overlay_figure, shape_figure
from flangeway.results import ResultTable
from flangeway.system.output_folder import refuse_unwritable

SUMMARY, SHAPE, CURVATURE, JOIN = "profile.json", "profile.png", "curvature.png", "joined.png"
NAMES = (SHAPE, CURVATURE, JOIN, REPORT, SUMMARY)
TABLE, OVERLAY, BATCH_SUMMARY = "profiles.csv", "profiles.png", "profiles.json"
BATCH_NAMES = (TABLE, OVERLAY, REPORT, BATCH_SUMMARY)
MEASURES = {
    "flange_height_mm": "flange height Sh, mm",
    "flange_thickness_mm": "flange thickness Sd, 10 mm from the tread, mm",
    "flange_slope_mm": "flange slope measure qR, mm",
    "head_width_mm": "width of the head 14 mm below its top, mm",
    "gauge_drop_mm": "drop 25 mm from the middle, gauge side, mm",
    "field_drop_mm": "  field side, mm",
    "gauge_half_width_mm": "half width 14 mm below the top, gauge side, mm",
    "field_half_width_mm": "  field side, mm",
}

TILES = {
    "flange_height_mm": "flange height Sh",
    "flange_thickness_mm": "flange thickness Sd",
    "flange_slope_mm": "flange slope measure qR",
    "head_width_mm": "width of the head, 14 mm below its top",
    "gauge_drop_mm": "drop 25 mm from the middle, gauge side",
}
SHAPE_SHOWN = "The profile with its points, lines and arcs."
CURVATURE_SHOWN = "Curvature along the profile."
SHORT = {
    "flange_height_mm": "Sh", "flange_thickness_mm": "Sd", "flange_slope_mm": "qR",
    "head_width_mm": "width", "gauge_drop_mm": "gauge drop", "field_drop_mm": "field drop",
}  # fmt: skip
SHORT_NOTE = (
    "Sh, Sd, qR: height, thickness and slope measure of the flange; width of the head 14 mm below its top; drop 25 mm "
    "from its middle."
)
OVERLAY_SHOWN = "All profiles, and the distance of each from the first."
JOIN_SHOWN = "The profile joined to the body of the nominal one."


def check_profile_folder(run: ProfileRun, folder: Path, to: Path | None) -> str:
    """Refuse what cannot be written, before anything is; return the text of the conversion.

    It is an `InputError` if the folder or the conversion's file cannot be written, its format is unknown, of the other
    kind, or holds no whole outline, or the file has no name.
    """
    text = ""
    if to is not None:
        if not to.name:
            raise InputError(f"--to {to}", "the name of a file", "give a file with an ending")
        text = converted(run, to.suffix.lower())
    refuse_unwritable(folder, NAMES)
    if to is not None:
        refuse_unwritable(to.parent, (to.name,))
    return text


def profile_record(run: ProfileRun, command: str) -> Record:
    """Return what was read and measured of a profile; `command` reads it again."""
    found, join = run.summary, run.join
    pictures = [
        Picture(SHAPE, lambda: shape_figure(run), SHAPE_SHOWN),
        Picture(CURVATURE, lambda: curvature_figure(run), CURVATURE_SHOWN),
    ]
    if join is not None:
        pictures.insert(1, Picture(JOIN, lambda: join_figure(join), JOIN_SHOWN))
    facts = [(f"{value:.2f} mm", TILES[key]) for key, value in found["measures"].items() if key in TILES]
    if found["area_mm2"] is not None:
        facts.append((f"{found['area_mm2']:.0f} mm²", "area of the whole section"))
    return Record(
        name=found["title"],
        title=found["title"],
        subtitle=f"{found['kind']}, {found['format']}; {found['frame']}",
        converged=True,
        success="read",
        message=f"{found['points']} points, {found['lines']} lines and {found['arcs']} arcs",
        facts=facts,
        results=SummaryTable("Profile", ("", "value", "how"), tuple(profile_rows(found)), of_words=True),
        summary=found,
        summary_file=SUMMARY,
        again=Again(command, files=f"The same numbers, for programs, are in `{SUMMARY}`."),
        versions=found["versions"],
        notes=[
            *found["notices"],
            *(f"{key.capitalize()}: {found[key]}" for key in ("certainty", "source") if found[key]),
        ],
        pictures=pictures,
    )


def profiles_record(runs: Sequence[ProfileRun], command: str) -> Record:
    """Return the measures of several profiles side by side; `command` reads them again."""
    found = [run.summary for run in runs]
    rows = [
        {
            **{key: summary[key] for key in ("title", "kind", "format", "points", "length_mm")},
            **summary["measures"],
            **{f"{key}_radius_mm": summary[f"{key}_radius_mm"] for key in ("smallest_convex", "smallest_hollow")},
            "noise_um": (summary["smoothing"] or {}).get("noise_um"),
        }
        for summary in found
    ]
    keys = [key for key in SHORT if any(key in summary["measures"] for summary in found)]
    cells = [
        (summary["title"], *(number(summary["measures"].get(key), 3) for key in keys), f"{summary['length_mm']:.2f}")
        for summary in found
    ]
    return Record(
        name=f"{len(runs)} profiles",
        title=f"{len(runs)} profiles",
        subtitle="measures of each profile alone",
        converged=True,
        success="read",
        message="",
        results=SummaryTable(
            "Profiles", ("", *(f"{SHORT[key]}, mm" for key in keys), "length, mm"), tuple(cells), note=SHORT_NOTE
        ),
        summary={"profiles": found},
        summary_file=BATCH_SUMMARY,
        again=Again(command, files=f"The table is in `{TABLE}`, all numbers of each profile are in `{BATCH_SUMMARY}`."),
        versions=found[0]["versions"],
        notes=_notes(found),
        pictures=[Picture(OVERLAY, lambda: overlay_figure(runs), OVERLAY_SHOWN)],
        files=lambda: {TABLE: ResultTable.of_rows(rows).to_csv},
    )


def _notes(found: Sequence[dict[str, Any]]) -> list[str]:
    """Return the notices of several profiles, each once, with the titles of those that have it unless all do."""
    by_notice: dict[str, list[str]] = {}
    for summary in found:
        for notice in summary["notices"]:
            by_notice.setdefault(notice, []).append(summary["title"])
    return [
        notice if len(titles) == len(found) else f"{notice} ({', '.join(titles)})"
        for notice, titles in by_notice.items()
    ]


def profile_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Name with unit, value, and where it comes from, of everything that is shown."""
    taken = summary["read_as"]
    how = taken["how"]
    rows = [
        ("what", f"{summary['kind']}, {summary['format']}", how["kind"]),
        ("unit of the file", taken["unit"], how["unit"]),
        ("vertical axis in the file", f"positive {'up' if taken['second_coordinate_up'] else 'down'}", how["up"]),
        ("mirrored", "yes" if taken["mirrored"] else "no", how["side"]),
        ("its origin", taken["origin"], how["origin"]),
    ]
    if taken["tape_line_from_flange_back_mm"] is not None:
        tape = f"{taken['tape_line_from_flange_back_mm']:g}"
        rows.append(("tape line from the flange's back, mm", tape, how["tape line"]))
    if any(taken["shift_mm"]):
        rows += _point("moved by {}, mm", taken["shift_mm"])
    rows += [
        ("points", f"{summary['points']}", "in reverse" if taken["order_reversed"] else ""),
        ("lines", f"{summary['lines']}", ""),
        ("arcs", f"{summary['arcs']}", ""),
        ("arc length, mm", f"{summary['length_mm']:.3f}", ""),
        *_point("{} min, mm", summary["lower_left_mm"]),
        *_point("{} max, mm", summary["upper_right_mm"]),
    ]
    for key, name in (("convex", "minimum convex radius, mm"), ("hollow", "minimum concave radius, mm")):
        value = summary[f"smallest_{key}_radius_mm"]
        rows.append((name, "none" if value is None else f"{value:.4g}", ""))
    rows += [
        (name, f"{summary['measures'][key]:.3f}", "") for key, name in MEASURES.items() if key in summary["measures"]
    ]
    if summary["kind"] == "rail":
        side = summary["worn_side"]
        rows.append(("worn more at", *_worn(side, summary["only_face"])))
    return rows + _smoothing_rows(summary) + _join_rows(summary)


def _point(name: str, point: Sequence[float]) -> list[tuple[str, str, str]]:
    return [(name.format(axis), f"{value:z.3f}", "") for axis, value in zip("xy", point, strict=True)]


def _worn(side: dict[str, Any] | None, only_face: str | None) -> tuple[str, str]:
    if only_face is not None:
        return "not seen", f"only the face of the {only_face} is measured"
    return ("neither", "") if side is None else (side["name"], f"by {side['more_mm']:.2f} mm: {side['measure']}")


def _smoothing_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    smoothing = summary["smoothing"]
    if smoothing is None:
        return []
    rows = [("noise of the points, μm", f"{smoothing['noise_um']:.3g}", "estimated")]
    if not smoothing["wavelength_mm"]:
        return [*rows, ("smoothing", "none", "the curve goes through all points")]
    n_held = smoothing["points_held_to_limit"]
    return [
        *rows,
        ("smoothed by a wavelength of, mm", f"{smoothing['wavelength_mm']:g}", ""),
        ("  deviation, root mean square, μm", f"{smoothing['rms_deviation_um']:.2f}", ""),
        (
            "  deviation, maximum, μm",
            f"{smoothing['maximum_deviation_um']:.2f}",
            f"limit {smoothing['limit_um']:.3g}"
            + (f", {n_held} of {summary['points']} points at the limit" if n_held else ""),
        ),
    ]


def _join_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    rows = []
    if summary["join"] is not None:
        rows.append(("joined to", summary["join"]["nominal"], ""))
        rows += [
            (f"  {joint['name'].replace('_', ', ')}, gap, mm", f"{joint['gap_mm']:.3f}", f"at x = {x:.3f}, y = {y:.3f}")
            for joint in summary["join"]["joints"]
            for x, y in [joint["end_mm"]]
        ]
        lost = summary["join"]["area_less_than_nominal_mm2"]
        rows.append(("  worn area, mm²", f"{lost:.1f}", ""))
    if summary["area_mm2"] is not None:
        rows.append(("area of the whole section, mm²", f"{summary['area_mm2']:.1f}", ""))
    return rows
