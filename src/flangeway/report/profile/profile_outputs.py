"""Record and files of ``flangeway profile``."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from flangeway.cases.profile.profile_folder import FOLDER_QUANTITIES, FolderProfile, ProfileFolder
from flangeway.cases.profile.profile_run import MEASURES, QUANTITIES, ProfileRun, converted
from flangeway.errors import InputError
from flangeway.quantities import Quantity, columns, measured, values
from flangeway.railway.profiles.formats.raw_profile import KINDS, Kind
from flangeway.railway.profiles.joining import joined
from flangeway.report.page.record import Again, Picture, Record
from flangeway.report.page.tables import SummaryTable, table_across, table_of
from flangeway.report.profile.profile_figures import curvature_figure, join_figure, overlay_figure, shape_figure
from flangeway.system.output_folder import refuse_unwritable
from flangeway.units import Units, in_us_units

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


def profile_record(run: ProfileRun, command: str, units: Units = "metric") -> Record:
    """Return what was read and measured of a profile; `command` reads it again."""
    summary, join = run.summary, run.join
    pictures = [
        Picture("profile.png", lambda: shape_figure(run, units), "The profile with its points, lines and arcs."),
        Picture("curvature.png", lambda: curvature_figure(run, units), "Curvature along the profile."),
    ]
    if join is not None:
        pictures.insert(
            1,
            Picture(
                "joined.png", lambda: join_figure(join, units), "The profile joined to the body of the nominal one."
            ),
        )
    there = [quantity for quantity in QUANTITIES if quantity.value(run) is not None]
    return Record(
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
        pictures=pictures,
    )


def profiles_record(runs: Sequence[ProfileRun], command: str, units: Units = "metric") -> Record:
    """Return the measures of several profiles side by side; `command` reads them again."""
    title: Quantity[ProfileRun] = Quantity("title", "profile", "profile.title")
    kind: Quantity[ProfileRun] = Quantity("kind", "kind", "profile.kind")
    chosen = [quantity for quantity in QUANTITIES if quantity.key in BATCH]
    shown = [quantity for quantity in MEASURES[:4] if any(quantity.value(run) is not None for run in runs)]
    return Record(
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
        pictures=[Picture(OVERLAY, lambda: overlay_figure(runs, units), OVERLAY_SHOWN)],
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


def folder_record(folder: ProfileFolder, name: str, command: str, units: Units = "metric") -> Record:
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
    notices = [
        ("\n".join(names), " ".join(map(in_us_units, of_files) if units == "us" else of_files))
        for of_files, names in files.items()
        if of_files
    ]
    n_noticed = sum(bool(row.notices) for row in rows)
    compared = f"{folder.nominal} or the nearest" if folder.nominal else "the nearest"
    return Record(
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
        pictures=[
            Picture(OVERLAY, lambda: overlay_figure(runs, units), OVERLAY_SHOWN),
            *(picture for kind in KINDS for picture in _joined_pictures(rows, kind, units)),
        ],
        files=lambda: {TABLE: folder.table.in_units(units).to_csv},
    )


def _joined_pictures(rows: Sequence[FolderProfile], kind: Kind, units: Units) -> list[Picture]:
    """Return pictures of the most worn profiles of a kind on the bodies of their nominal ones, as far as they fit."""
    pictures: list[Picture] = []
    for row in rows:
        if row.run.profile.kind != kind or row.nominal is None or len(pictures) == MAX_JOINED:
            continue
        try:
            found = joined(replace(row.run.profile, title=row.file), row.nominal)
        except InputError:  # a whole outline, or a surface too short for contact
            continue
        file = f"worn-{kind}-{len(pictures) + 1}.png"
        caption = f"{row.file} on the nominal {row.nominal}."
        pictures.append(Picture(file, partial(join_figure, found, units), caption, "Pictures"))
    return pictures
