"""Record and files of ``flangeway geometry``."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from flangeway.cases.rigid.rigid_run import ConicityRun, GeometryRun
from flangeway.railway.track.placements import SIDES
from flangeway.report.page.record import REPORT, Again, Picture, Record
from flangeway.report.page.tables import Column, SummaryTable, number, table_across, with_whole
from flangeway.report.rigid.rigid_figures import (
    conicity_figure,
    flange_root_figure,
    locus_figure,
    pairs_figure,
    rolling_figure,
)
from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer

TABLE, CONICITY, SUMMARY = "table.csv", "conicity.csv", "geometry.json"
CONICITY_PICTURE, FLANGE_ROOT = "conicity.png", "flange_root_radius.png"
PICTURES: dict[str, tuple[Callable[[GeometryRun], Figure], str]] = {
    "contact_locus.png": (locus_figure, "Points of contact on rail and wheel over the lateral displacement"),
    "rolling_radius_difference.png": (rolling_figure, "Rolling radius difference over the lateral displacement"),
    CONICITY_PICTURE: (conicity_figure, "Equivalent conicity over the amplitude"),
}
FLANGE_ROOT_SHOWN = "Lateral displacement in equilibrium over the radii of the flange root"
NAMES = (*PICTURES, FLANGE_ROOT, TABLE, CONICITY, REPORT, SUMMARY)
CONICITY_NAMES = (CONICITY_PICTURE, CONICITY, REPORT, SUMMARY)
BATCH_TABLE, BATCH_PICTURE, BATCH_SUMMARY = "geometries.csv", "geometries.png", "geometries.json"
BATCH_NAMES = (BATCH_TABLE, BATCH_PICTURE, REPORT, BATCH_SUMMARY)
PAIRS_SHOWN = "Rolling radius difference and equivalent conicity of all pairs."
AXES = {
    "lateral, vertical": "of the axle in space, to the right and up, from the middle of the track",
    "x": "on the wheel from the tape line, on the rail from its middle, away from the middle of the track",
    "L/V": "lateral over vertical force of a wheel, positive where it pushes its rail outwards; without friction",
}
ASSUMPTIONS = (
    "Rigid wheels on rigid rails: the points of contact are those of the profiles as they are.",
    "Hertz's values are of a line contact of the rigid equilibrium's force and curvatures.",
)


def geometry_record(run: GeometryRun, command: str) -> Record:
    """Return what was found of the contact geometry; `command` computes it again."""
    found = run.summary
    pictures = [Picture(name, partial(draw, run), f"{words}.") for name, (draw, words) in PICTURES.items()]
    effect = run.flange_root
    if effect is not None:
        shown = f"{FLANGE_ROOT_SHOWN}."
        pictures.append(Picture(FLANGE_ROOT, lambda: flange_root_figure(effect), shown))
    position = found["equilibrium"]
    ratios = {} if position is None else position["lateral_over_vertical"]
    facts = [(f"{ratio:.3f}", f"L/V of the {side} wheel") for side, ratio in ratios.items() if ratio is not None]
    if position is not None:
        facts.append((f"{_clean(position['lateral_mm']):.3f} mm", "lateral position"))
    jumps = [
        (
            jump["side"],
            f"{jump['lateral_mm']:.3f}",
            f"{jump['rail_points_mm'][0][0]:.2f}",
            f"{jump['rail_points_mm'][1][0]:.2f}",
        )
        for jump in found["jumps"]
    ]
    head = ("side", "lateral displacement, mm", "x on the rail before, mm", "after, mm")
    return Record(
        **_common(found, command, (SUMMARY, TABLE, CONICITY)),
        subtitle=f"Rigid wheels {run.case.wheel} on rigid rails {run.case.rail}",
        converged=run.equilibrium.status.converged,
        message=run.equilibrium.status.message,
        facts=[*facts, *_conicity_facts(found)],
        results=_geometry_results(found),
        assumptions=ASSUMPTIONS,
        pictures=pictures,
        tables=[SummaryTable("Jumps of the point of contact", head, tuple(jumps))] if jumps else [],
        axes=AXES,
        inputs=[
            SummaryTable("Inputs", ("", "value"), tuple((k, str(v)) for k, v in found["inputs"].items()), of_words=True)
        ],
        files=lambda: {TABLE: run.table.to_csv, **_conicity_file(run)},
    )


def geometries_record(runs: Sequence[GeometryRun], command: str) -> Record:
    """Return conicity and equilibrium of several pairs of profiles side by side; `command` computes them again."""
    rows = [_pair_row(run.summary) for run in runs]
    head = ("wheel", "rail", "conicity at 3 mm", "lateral, mm", "L/V left", "L/V right", "jumps")
    keys = ("conicity_integration", "lateral_mm", *(f"{side}_lateral_over_vertical" for side in SIDES))
    cells = [
        (row["wheel"], row["rail"], *(number(row[k] and _clean(row[k]), 4) for k in keys), f"{row['jumps']}")
        for row in rows
    ]
    return Record(
        **_common(runs[0].summary, command, (BATCH_SUMMARY, BATCH_TABLE))
        | {
            "summary": {"pairs": [run.summary for run in runs]},
            "summary_file": BATCH_SUMMARY,
            "title": f"{len(runs)} pairs of profiles",
            "notes": list(dict.fromkeys(notice for run in runs for notice in run.summary["notices"])),
            "timings_s": {"total": sum(run.summary["timings_s"]["total"] for run in runs)},
        },
        subtitle=f"{len(runs)} pairs of rigid wheels and rails",
        converged=all(run.equilibrium.status.converged for run in runs),
        message="",
        results=SummaryTable("Pairs of profiles", head, tuple(cells)),
        assumptions=ASSUMPTIONS,
        pictures=[Picture(BATCH_PICTURE, lambda: pairs_figure(runs), PAIRS_SHOWN)],
        axes=AXES,
        files=lambda: {BATCH_TABLE: ResultTable.of_rows(rows).to_csv},
    )


def _pair_row(summary: dict[str, Any]) -> dict[str, Any]:
    """Numbers of one pair of profiles, by name with unit; None where they are not computed."""
    position, conicity = summary["equilibrium"] or {}, summary["equivalent_conicity"] or {}
    angles = {
        side: [e["contact_angle_deg"] for e in position.get("contacts", ()) if e["side"] == side] for side in SIDES
    }
    return {
        **{key: Path(summary["inputs"][key]).name for key in ("wheel", "rail")},
        **{f"conicity_{key}": conicity.get(key) for key in ("integration", "regression", "amplitude_mm")},
        **{key: position.get(key) for key in ("lateral_mm", "vertical_mm", "roll_rad")},
        **{f"{side}_lateral_over_vertical": position.get("lateral_over_vertical", {}).get(side) for side in SIDES},
        **{f"{side}_max_contact_angle_deg": max(angles[side], default=None) for side in SIDES},
        "jumps": len(summary["jumps"]),
        "status": "converged" if summary["status"]["converged"] else "not converged",
    }


def conicity_record(run: ConicityRun, command: str) -> Record:
    """Return what was found of a rolling radius difference from a file; `command` computes it again."""
    found, shown = run.summary, PICTURES[CONICITY_PICTURE][1]
    middle = found["lateral_without_difference_mm"]
    rows = [] if middle is None else [("lateral without a difference of the radii, mm", f"{_clean(middle):.3f}")]
    return Record(
        **_common(found, command, (SUMMARY, CONICITY)),
        subtitle=found["inputs"]["file"],
        converged=True,
        success="computed",
        message=f"at {len(run.conicities.amplitudes_mm)} amplitudes"
        if found["equivalent_conicity"]
        else "without a conicity at 3 mm, see the notes",
        facts=_conicity_facts(found),
        results=SummaryTable("Conicity", ("", "value"), (*rows, *_conicity_rows(found))),
        pictures=[Picture(CONICITY_PICTURE, lambda: conicity_figure(run), f"{shown}.")],
        files=lambda: _conicity_file(run),
    )


def _common(found: dict[str, Any], command: str, files: tuple[str, ...]) -> dict[str, Any]:
    """Return what both records have from their summaries."""
    return {
        "name": found["case"],
        "title": found["title"],
        "summary": found,
        "summary_file": SUMMARY,
        "again": Again(command, files=f"Numbers for programs and spreadsheets: {', '.join(f'`{f}`' for f in files)}."),
        "versions": found["versions"],
        "notes": found["notices"],
        "timings_s": found["timings_s"],
    }


def _conicity_facts(found: dict[str, Any]) -> list[tuple[str, str]]:
    at = found["equivalent_conicity"]
    return [] if at is None else [(f"{at['integration']:.4f}", f"equivalent conicity at {at['amplitude_mm']:g} mm")]


def _conicity_rows(found: dict[str, Any]) -> list[tuple[str, str]]:
    at = found["equivalent_conicity"]
    if at is None:
        return []
    name = f"equivalent conicity at {at['amplitude_mm']:g} mm"
    return [(f"{name}, by integration", f"{at['integration']:.4f}"), ("  by regression", f"{at['regression']:.4f}")]


def _conicity_file(run: GeometryRun | ConicityRun) -> dict[str, Writer]:
    return {CONICITY: run.conicities.table.to_csv}


def _geometry_results(found: dict[str, Any]) -> SummaryTable:
    """Position, conicity and points of contact, one column a point; what is of a side is in its first column."""
    position = found["equilibrium"]
    whole = dict(_conicity_rows(found))
    if position is None:
        return SummaryTable("Results", ("", "value"), tuple(whole.items()))
    contacts = position["contacts"]
    yawed = any(contact["ahead_of_axle_mm"] for contact in contacts)
    quantities: list[Column] = [
        ("force, kN", lambda c: c["normal_force_kN"], ".2f"),
        ("contact angle, degrees", lambda c: c["contact_angle_deg"], ".2f"),
        ("x on the wheel, mm", lambda c: c["wheel_point_mm"][0], "z.2f"),
        ("x on the rail, mm", lambda c: c["rail_point_mm"][0], "z.2f"),
        ("rolling radius, mm", lambda c: c["rolling_radius_mm"], ".2f"),
        *([("ahead of the axle, mm", lambda c: c["ahead_of_axle_mm"], "z.2f")] if yawed else []),
        ("Hertz: half width, mm", lambda c: _hertz(c["hertz_half_width_mm"]), ""),
        ("Hertz: maximum pressure, MPa", lambda c: _hertz(c["hertz_max_pressure_MPa"]), ""),
    ]
    sides = [contact["side"] for contact in contacts]
    whole = {
        "lateral position, mm": f"{_clean(position['lateral_mm']):.4f}",
        "vertical position, mm": f"{_clean(position['vertical_mm']):.4f}",
        "roll, mrad": f"{_clean(1e3 * position['roll_rad']):.5f}",
    } | whole
    ratios = {side: number(ratio, 3) for side, ratio in position["lateral_over_vertical"].items()}
    jumps = {side: [each["lateral_mm"] for each in found["jumps"] if each["side"] == side] for side in SIDES}
    first = {side: f"{min(values, key=abs):.3f}" if values else "none" for side, values in jumps.items()}
    return with_whole(
        table_across("Results", sides, contacts, quantities), whole, sides, {"L/V": ratios, "first jump at, mm": first}
    )


def _hertz(value: float | None) -> str:
    return "conforming" if value is None else f"{value:.4g}"


def _clean(value: float) -> float:
    """Zero for noise of rounding."""
    return 0.0 if abs(value) < 1e-7 else value
