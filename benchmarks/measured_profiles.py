"""Public measured profiles in the default case, each with a nominal partner: what converges, and why others do not.

The files are those of the program CONTACT (github.com/eve70a/CONTACT, testbank and examples); none is copied here.
``python -m benchmarks.measured_profiles FOLDER [LATERAL_MM...]`` prints two tables in Markdown: a line for each file,
or for three sections of a file of slices, with a nominal partner; and one for each measured wheel on a measured rail.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flangeway.cases.profile_run import run_profile
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.errors import InputError
from flangeway.railway.profiles.formats.slice_files import SLICES
from flangeway.railway.profiles.formats.two_column import Kind
from flangeway.railway.profiles.named import RailFile, WheelFile, profile_of
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import sections_of

ENDINGS = (".prr", ".prw", ".ban", ".whl", *SLICES)
LATERAL_MM = (-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0)
PAIRS_MM = (-6.0, -3.0, 0.0, 3.0, 6.0)
MEASURED = {
    "wheel": (
        *(f"Car{number}_0001r.whl" for number in (7216, 7358, 7422, 7813)),
        *("avg_wheel.whl", "whl_left_iter288.whl", "whl_left_iter795.whl", "worn_high_mileage.prw"),
    ),
    "rail": ("avg_HR.BAN", "avg_low2.ban", "rail_left_iter288.ban", "rail_left_iter795.ban", "site_b_hr.prr"),
}
"""Files of vehicles and tracks that instruments measured, or that were worn by computation."""
AMERICAN = ("136RE", "AAR-1B", "heavy-haul")
PARTNERS = {"rail": ("S1002", "AAR-1B"), "wheel": ("60E1", "136RE")}
"""Nominal partner of a profile on a European body, and on an American one."""

PLACES: dict[Kind, tuple[type[RailFile | WheelFile], str, str]] = {
    "rail": (RailFile, "track", "position_mm"),
    "wheel": (WheelFile, "wheelset", "angle_deg"),
}
"""Record of a file with options, table of the case that names it, and its input of the section in a file of slices."""


@dataclass(frozen=True)
class MeasuredRow:
    """A file in the default case at one lateral position, or free for None.

    - `end`: ``"converged"``, ``"refused"`` or ``"not converged"``.
    - `words`: refusal or message.
    - `warnings`: of the result.
    """

    file: str
    partner: str
    lateral_mm: float | None
    end: str
    words: str
    warnings: tuple[str, ...] = ()


def profile_files(folder: Path) -> list[tuple[Path, float | None]]:
    """Files of profiles in a folder, with a first, a middle and a last position of those of slices."""
    found: list[tuple[Path, float | None]] = []
    for file in sorted(each for each in folder.iterdir() if each.suffix.lower() in ENDINGS):
        places = sections_of(file)
        chosen = [places[i] for i in sorted({0, len(places) // 2, len(places) - 1})] if places else [None]
        found += [(file, place) for place in chosen]
    return found


def rows_of(file: Path, position: float | None, lateral_mm: Sequence[float | None]) -> Iterator[MeasuredRow]:
    """Run a file in the default case, free and at lateral positions; after a refusal of the file itself no more."""
    name = file.name if position is None else f"{file.name} at {position:g}"
    try:
        measured = run_profile(str(file), ReadOptions(position=position)).profile
        kind, table, at = PLACES[measured.kind]
        named = kind.from_values({"file": str(file), at: position})
        body = profile_of(named, measured.kind).title
    except InputError as reason:
        yield MeasuredRow(name, "", None, "refused", str(reason))
        return
    american = any(word in body.rpartition(" on ")[2] for word in AMERICAN)
    partner = PARTNERS[measured.kind][american]
    other: Kind = "wheel" if measured.kind == "rail" else "rail"
    values = {table: {measured.kind: named}, PLACES[other][1]: {other: partner}}
    yield from pair_rows(name, partner, values, lateral_mm)


def pair_rows(
    name: str, partner: str, values: dict[str, Any], lateral_mm: Sequence[float | None]
) -> Iterator[MeasuredRow]:
    """Run a wheel and a rail in the default case, free for None, and at lateral positions."""
    for lateral in lateral_mm:
        try:
            run = Wheelset.from_values({**values, "position": {"lateral_mm": lateral}}).run()
        except InputError as reason:
            yield MeasuredRow(name, partner, lateral, "refused", str(reason))
            continue
        end = "converged" if run.status.converged else "not converged"
        yield MeasuredRow(name, partner, lateral, end, run.status.message, tuple(run.warnings))


def table(folder: Path, lateral_mm: Sequence[float | None] = (None, *LATERAL_MM)) -> Iterator[str]:
    """Lines of the table of each file with a nominal partner."""
    yield from ("| file | partner | converged at, mm | otherwise |", "|---|---|---|---|")
    for file, position in profile_files(folder):
        yield _line(list(rows_of(file, position, lateral_mm)), folder)


def pairs_table(folder: Path, lateral_mm: Sequence[float | None] = PAIRS_MM) -> Iterator[str]:
    """Lines of the table of measured wheels on measured rails."""
    yield from ("| wheel | rail | converged at, mm | otherwise |", "|---|---|---|---|")
    for wheel in MEASURED["wheel"]:
        for rail in MEASURED["rail"]:
            values = {"wheelset": {"wheel": str(folder / wheel)}, "track": {"rail": str(folder / rail)}}
            yield _line(list(pair_rows(wheel, rail, values, lateral_mm)), folder)


def _line(rows: list[MeasuredRow], folder: Path) -> str:
    """Line of a table: where a pair converges, and why it does not elsewhere."""
    other: dict[str, list[str]] = {}
    for row in rows:
        if row.end != "converged":
            words = row.words.replace(f"{folder}/", "").splitlines()
            place = "free" if row.lateral_mm is None else f"{row.lateral_mm:g}"
            reason = (words[1] if "lateral disp" in words[0] else words[0]).strip()
            other.setdefault(f"{row.end}: {reason}", []).append(place)
    good = ", ".join("free" if row.lateral_mm is None else f"{row.lateral_mm:g}" for row in rows if _good(row))
    reasons = "; ".join(f"{', '.join(places)}: {words}" for words, places in other.items())
    mirrored = " (mirrored)" if any("left-hand" in warning for row in rows for warning in row.warnings) else ""
    return f"| {rows[0].file}{mirrored} | {rows[0].partner} | {good} | {reasons} |"


def _good(row: MeasuredRow) -> bool:
    return row.end == "converged"


if __name__ == "__main__":
    given = Path(sys.argv[1])
    positions = [*map(float, sys.argv[2:])]
    for lines in (table(given, [None, *(positions or LATERAL_MM)]), [""], pairs_table(given, positions or PAIRS_MM)):
        for line in lines:
            print(line, flush=True)
