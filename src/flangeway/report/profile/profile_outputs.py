"""All files of ``flangeway profile``, and its summary on the terminal."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console

from flangeway.cases import write_summary
from flangeway.cases.profile.profile_run import ProfileRun, converted
from flangeway.errors import InputError
from flangeway.report.figures.drawing import picture_writers
from flangeway.report.page.tables import print_files, print_notices, print_rows
from flangeway.report.profile.profile_figures import curvature_figure, join_figure, shape_figure
from flangeway.system.output_folder import refuse_unwritable, text_writer, write_together

SUMMARY, SHAPE, CURVATURE, JOIN = "profile.json", "profile.png", "curvature.png", "joined.png"
NAMES = (SHAPE, CURVATURE, JOIN, SUMMARY)
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


def check_profile_folder(folder: Path, to: Path | None) -> None:
    """Refuse a folder or file that cannot be written (`flangeway.system.output_folder.refuse_unwritable`)."""
    refuse_unwritable(folder, NAMES)
    if to is not None:
        refuse_unwritable(to.parent, (to.name,))


def write_profile(
    run: ProfileRun, folder: Path, to: Path | None, progress: Callable[[str], None] = lambda _: None
) -> list[Path]:
    """Write pictures and summary into a folder, and the conversion to its file; each together or not at all.

    It is an `InputError` if something cannot be written, or the format of the conversion cannot hold the profile.
    """
    text = None if to is None else converted(run, to.suffix.lower())
    progress("drawing the pictures and writing the files")
    figures = {SHAPE: shape_figure(run), CURVATURE: curvature_figure(run)}
    if run.join is not None:
        figures[JOIN] = join_figure(run.join)
    writers = picture_writers(figures)
    writers[SUMMARY] = lambda path: write_summary(path, run.summary)
    files = write_together(folder, writers)
    if to is not None and text is not None:
        files += write_together(to.parent, {to.name: text_writer(text)})
    return files


def print_profile(console: Console, summary: dict[str, Any], files: list[Path]) -> None:
    """Print what was read, measures, repairs, assumptions, and the files."""
    console.print(summary["title"], style="bold", markup=False)
    print_rows(console, profile_rows(summary))
    console.print(f"Frame: {summary['frame']}; mm.", markup=False, soft_wrap=True)
    print_notices(console, summary["notices"])
    for key in ("certainty", "source"):
        if summary[key]:
            console.print(f"{key.capitalize()}: {summary[key]}", markup=False, soft_wrap=True)
    print_files(console, files)


def profile_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Name with unit, value, and where it comes from, of everything that is shown."""
    taken = summary["read_as"]
    how = taken["how"]
    rows = [
        ("what", f"{summary['kind']}, {summary['format']}", how["kind"]),
        ("unit of the file", taken["unit"], how["unit"]),
        ("its second coordinate", "up" if taken["second_coordinate_up"] else "down", how["up"]),
        ("mirrored", "yes" if taken["mirrored"] else "no", how["side"]),
        ("its origin", taken["origin"], how["origin"]),
    ]
    if taken["tape_line_from_flange_back_mm"] is not None:
        tape = f"{taken['tape_line_from_flange_back_mm']:g}"
        rows.append(("tape line from the flange's back, mm", tape, how["tape line"]))
    if any(taken["shift_mm"]):
        rows.append(("moved by (x, y), mm", _pair(taken["shift_mm"]), ""))
    rows += [
        ("points", f"{summary['points']}", "in reverse" if taken["order_reversed"] else ""),
        ("lines and arcs", f"{summary['lines']} and {summary['arcs']}", ""),
        ("length along it, mm", f"{summary['length_mm']:.3f}", ""),
        ("from (x, y), mm", _pair(summary["lower_left_mm"]), ""),
        ("to (x, y), mm", _pair(summary["upper_right_mm"]), ""),
    ]
    for key, name in (("convex", "smallest convex radius, mm"), ("hollow", "smallest hollow radius, mm")):
        value = summary[f"smallest_{key}_radius_mm"]
        rows.append((name, "none" if value is None else f"{value:.4g}", ""))
    rows += [
        (name, f"{summary['measures'][key]:.3f}", "") for key, name in MEASURES.items() if key in summary["measures"]
    ]
    if summary["kind"] == "rail":
        side = summary["worn_side"]
        rows.append(("worn more at", "neither" if side is None else side["name"], _more(side)))
    return rows + _smoothing_rows(summary) + _join_rows(summary)


def _more(side: dict[str, Any] | None) -> str:
    return "" if side is None else f"by {side['more_mm']:.2f} mm: {side['measure']}"


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
            f"limit {smoothing['limit_um']:.3g}" + (f", {n_held} points held to it" if n_held else ""),
        ),
    ]


def _join_rows(summary: dict[str, Any]) -> list[tuple[str, str, str]]:
    rows = []
    if summary["join"] is not None:
        rows.append(("joined to", summary["join"]["nominal"], ""))
        rows += [
            (f"  {joint['name'].replace('_', ', ')}, gap, mm", f"{joint['gap_mm']:.3f}", f"at {_pair(joint['end_mm'])}")
            for joint in summary["join"]["joints"]
        ]
        lost = summary["join"]["area_less_than_nominal_mm2"]
        rows.append(("  area less than the nominal one, mm²", f"{lost:.1f}", ""))
    if summary["area_mm2"] is not None:
        rows.append(("area of the whole section, mm²", f"{summary['area_mm2']:.1f}", ""))
    return rows


def _pair(values: list[float]) -> str:
    return f"({values[0]:.3f}, {values[1]:.3f})"


def refuse_conversion(run: ProfileRun, to: Path | None) -> None:
    """Refuse a conversion that its format cannot hold, before anything is written.

    It is an `InputError` if the format is unknown, of the other kind, or holds no whole outline, or the file has no
    name.
    """
    if to is None:
        return
    if not to.name:
        raise InputError(f"--to {to}", "the name of a file", "give a file with an ending")
    converted(run, to.suffix.lower())
