"""Profiles that vary along the track or around a wheel: files of slices of CONTACT, ``.slcs`` and ``.slcw``.

Numbers one after the other, words behind them and comments after ``%`` are skipped: offset and scale of the positions;
number of slices; number of features, kinks and accelerations; method of interpolation and form of a perturbation. Then
a line for each slice, its position and its file in quotation marks; with two features or more a line for each slice,
its position and the lengths along it at which its parts begin and end, negative where it does not have this feature;
with a perturbation the number of its waves and a line for each. ``position = scale (offset + value)``, in mm along the
track or in rad around the wheel.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry import FloatArray
from flangeway.geometry.arrays import chain_lengths
from flangeway.railway.profiles.formats.two_column import Kind, RawProfile, leading_numbers

SLICES: dict[str, Kind] = {".slcs": "rail", ".slcw": "wheel"}
"""Kinds by the ending of the file's name."""
UNITS: dict[Kind, str] = {"rail": "mm", "wheel": "degrees"}
"""Units of positions along the track and around a wheel."""
MAX_SLICES, MAX_FEATURES, MAX_TERMS = 100_000, 1000, 1000
_APART = 1e-3
_WHOLE = 1e6
_SPACING_MM = 0.25
_SLICE = re.compile(r"\s*(\S+)\s+['\"]([^'\"]+)['\"]")
_TURN = 360.0


@dataclass(frozen=True, eq=False)
class ProfileSlices:
    """Sections of a rail along the track, or of a wheel around its axle.

    - `positions`: increasing, in mm along the track, or in degrees around the wheel, (n,).
    - `files`: file of each slice.
    - `features`: lengths along the slices at which parts begin and end, in mm, negative for missing ones, (n, m).
    - `waves`: amplitude in mm, positive downwards, radians in a unit of position, and phase in radians of each wave
      that is added to the heights, (k, 3).
    """

    file: Path
    kind: Kind
    positions: FloatArray
    files: tuple[Path, ...]
    features: FloatArray
    waves: FloatArray

    def wanted(self, position: float | None) -> float:
        """Return a position inside of the slices; around a wheel the last slice is followed by the first one.

        An `InputError` if there is none, or it is beyond the ends of a rail.
        """
        first, last = float(self.positions[0]), float(self.positions[-1])
        option = f"--position in {UNITS[self.kind]}"
        where = f"{first:g} to {last:g} {UNITS[self.kind]}, {len(self.files)} slices"
        if position is None:
            raise InputError(f"{len(self.files)} slices without a position", f"{option}: " + where, "add it")
        if self.kind == "wheel" and math.isfinite(position):
            turned = [math.remainder(position, _TURN) + _TURN * turns for turns in (0, -1, 1)]
            return next((angle for angle in turned if first <= angle <= last), min(max(turned[0], first), last))
        if len(self.files) > 1 and not first - _APART <= position <= last + _APART:
            raise InputError(f"--position {position:g}", where, "give a position between the slices")
        return position

    def section(self, position: float, read: Callable[[Path], RawProfile]) -> RawProfile:
        """Return the section at a position: a slice, or between two of them points at the same part of each part.

        An `InputError` if a slice cannot be read, or both have no part in common.

        - `position`: of `wanted`.
        - `read`: reads the file of a slice.
        """
        after = int(np.clip(np.searchsorted(self.positions, position), 1, max(len(self.files) - 1, 1)))
        low, high = (float(self.positions[min(i, len(self.files) - 1)]) for i in (after - 1, after))
        part = min(max((position - low) / (high - low), 0.0), 1.0) if high > low else 0.0
        near = [i for i, weight in ((after - 1, 1.0 - part), (after, part)) if weight * (high - low) > _APART]
        near = near or [0]
        raws = [self.slice(i, read) for i in near]
        if len(raws) == 1:
            trimmed = _trimmed(raws[0], self.features[near[0]])
        else:
            trimmed = _between(raws, self.features[near], part, f"{self.file}: slices {near[0] + 1} and {near[1] + 1}")
        amplitude, waves, phase = self.waves.T
        depth = float(amplitude @ np.sin(waves * position + phase))
        sign = -1.0 if trimmed.upwards else 1.0
        return replace(trimmed, points=trimmed.points + np.array([0.0, sign * depth])) if depth else trimmed

    def slice(self, number: int, read: Callable[[Path], RawProfile]) -> RawProfile:
        """Return a slice as its file has it, of this kind."""
        raw = read(self.files[number])
        if raw.contour is not None:
            raise InputError(f"{self.files[number]}: lines and arcs as a slice", "points", "convert it with --to")
        if raw.kind not in (None, self.kind):
            raise InputError(f"{self.files[number]}: a {raw.kind}", f"slices of a {self.kind}", "correct the list")
        # of texts without a statement CONTACT takes mm and heights downwards
        sure = raw.unit is not None and raw.unit_is_sure
        return replace(raw, kind=self.kind, unit=raw.unit or "mm", unit_is_sure=sure, upwards=bool(raw.upwards))


def read_slices(file: Path, text: str) -> ProfileSlices:
    """Return the slices that a file lists; their own files are read when a section is wanted.

    An `InputError` if a number is missing or wrong, or positions do not increase; the message names the line.
    """
    kind = SLICES[file.suffix.lower()]
    lines = [(n, line.partition("%")[0]) for n, line in enumerate(text.splitlines(), 1)]
    rest = [(n, line) for n, line in lines if line.strip()][::-1]

    def row(what: str, least: int, most: int | None = None) -> tuple[int, list[float]]:
        if not rest:
            raise InputError(f"the end of the file before {what}", what, "the file was cut off")
        number, line = rest.pop()
        values = leading_numbers(line)
        if len(values) < least or not all(map(math.isfinite, values)):
            raise InputError(f"line {number}: {line.strip()[:60]!r}", what, "correct this line")
        return number, values[:most]

    def counted(what: str, allowed: tuple[int, int], values: list[float], number: int) -> int:
        low, high = allowed
        if values[0] != int(values[0]) or not low <= values[0] <= high:
            raise InputError(f"line {number}: {what} = {values[0]:g}", f"{low} to {high}", "correct this line")
        return int(values[0])

    number, (offset, scale) = row("two numbers: offset and scale of the positions", 2, 2)
    if scale <= 0.0:
        raise InputError(f"line {number}: scale = {scale:g}", "a positive scale", "1000 for positions in m")
    number, values = row("the number of slices", 1, 1)
    n_slices = counted("slices", (1, MAX_SLICES), values, number)
    number, values = row("the numbers of features, kinks and accelerations", 1, 3)
    n_features, n_kinks, n_jumps = (
        counted(what, (0, MAX_FEATURES), values[i : i + 1] or [0.0], number)
        for i, what in enumerate(("features", "kinks", "accelerations"))
    )
    number, values = row("the method of interpolation", 1, 2)
    counted("interpolation", (0, 2), values, number)
    perturbation = counted("perturbation", (0, 2), values[1:] or [0.0], number)
    positions: list[float] = []
    files: list[Path] = []
    for _ in range(n_slices):
        if not rest:
            raise InputError(f"{len(files)} slices", f"{n_slices}, as the file states", "the file was cut off")
        number, line = rest.pop()
        match = _SLICE.match(line)
        value = leading_numbers(match[1])[:1] if match else []
        if match is None or not value:
            allowed = f"a position and the name of a file in quotation marks, {n_slices} lines"
            raise InputError(f"line {number}: {line.strip()[:60]!r}", allowed, "correct this line")
        positions.append(scale * (offset + value[0]))
        files.append(file.parent / match[2].replace("\\", "/"))  # of lists from Windows
        if len(positions) > 1 and not positions[-1] - positions[-2] >= _APART:
            raise InputError(
                f"line {number}: position {value[0]:g}", "positions that increase by 0.001 or more", "sort the slices"
            )
    for _ in range(sum(n > 0 for n in (n_kinks, n_jumps))):
        row("numbers of the parts with kinks or accelerations", 1)
    features = _features(n_slices, n_features, row)
    waves = _waves(perturbation, row, counted)
    if kind == "wheel":
        positions = [math.degrees(angle) for angle in positions]
        waves[:, 1] *= math.pi / 180.0
    return ProfileSlices(file, kind, np.array(positions), tuple(files), features, waves)


def _features(n_slices: int, n_features: int, row: Callable) -> FloatArray:  # type: ignore[type-arg]
    """Lengths along the slices at which their parts begin and end, (n_slices, n)."""
    if n_features < 2:
        return np.tile([0.0, _WHOLE], (n_slices, 1))
    what = f"a position and {n_features} lengths along its slice"
    table = []
    for _ in range(n_slices):
        number, values = row(what, n_features + 1, n_features + 1)
        lengths = np.array(values[1:])
        if (np.diff(lengths[lengths >= 0.0]) <= 0.0).any():
            raise InputError(f"line {number}: lengths that do not increase", what, "correct this line")
        table.append(lengths)
    return np.array(table)


def files_of(file: Path) -> tuple[Path, ...]:
    """Return a file and those of its slices; the file alone if it is no list of slices."""
    if file.suffix.lower() not in SLICES:
        return (file,)
    return (file, *read_slices(file, file.read_text(encoding="utf-8", errors="replace")).files)


def _waves(form: int, row: Callable, counted: Callable) -> FloatArray:  # type: ignore[type-arg]
    """Amplitudes, radians in a mm or rad, and phases of a perturbation by wavelengths (1) or orders (2), (k, 3)."""
    if not form:
        return np.zeros((0, 3))
    number, values = row("the number of waves", 1, 1)
    terms = [
        row(f"amplitude, {'wavelength' if form == 1 else 'order'} and phase", 3, 3)
        for _ in range(counted("waves", (1, MAX_TERMS), values, number))
    ]
    for number, (_, length, _) in terms:
        if length <= 0.0:
            raise InputError(f"line {number}: {length:g}", "a positive wavelength or order", "correct this line")
    table = np.array([values for _, values in terms])
    table[:, 1] = 2.0 * math.pi / table[:, 1] if form == 1 else table[:, 1]
    table[:, 2] *= table[:, 1]
    return table


def _part(points: FloatArray, lengths: FloatArray, at: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(at, lengths, column) for column in points.T])


def _trimmed(raw: RawProfile, features: FloatArray) -> RawProfile:
    """A slice from its first to its last feature."""
    lengths, known = chain_lengths(raw.points), features[features >= 0.0]
    inside = (lengths >= known.min(initial=_WHOLE)) & (lengths <= known.max(initial=0.0))
    return replace(raw, points=raw.points[inside], lines=raw.lines[inside])


def _between(raws: list[RawProfile], features: FloatArray, part: float, which: str) -> RawProfile:
    """Points between those of two slices at the same share of the length of each part that both have."""
    if len({(raw.upwards, raw.mirrored) for raw in raws}) > 1 or any(raw.unit != "mm" for raw in raws):
        raise InputError(f"{which} in different axes, or not in mm", "slices in mm", "convert them with --to")
    lengths = [chain_lengths(raw.points) for raw in raws]
    pieces: list[FloatArray] = []
    for number in range(features.shape[1] - 1):
        ends = features[:, number : number + 2]
        if (ends < 0.0).any():
            continue
        limits = [np.minimum(ends_of_part, along[-1]) for ends_of_part, along in zip(ends, lengths, strict=True)]
        count = max(int(max(np.ptp(limit) for limit in limits) / _SPACING_MM), 2)
        share = np.linspace(0.0, 1.0, count)
        first, second = (
            _part(raw.points, along, low + share * (high - low))
            for raw, along, (low, high) in zip(raws, lengths, limits, strict=True)
        )
        joined = (1.0 - part) * first + part * second
        meets = pieces and math.dist(pieces[-1][-1], joined[0]) < _APART
        pieces.append(joined[1:] if meets else joined)
    if not pieces:
        raise InputError(f"{which} without a part in common", "a part between two features of both", "add a slice")
    points = np.concatenate(pieces)
    return replace(raws[0], points=points, lines=np.zeros(len(points), dtype=np.int64))
