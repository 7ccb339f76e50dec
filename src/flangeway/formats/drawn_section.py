"""A section as a file or a catalogue gives it, and closed outlines from what it draws: small faults are repaired."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from flangeway.checks import is_finite
from flangeway.errors import InputError, located, short
from flangeway.geometry.arrays import Point, norms, point_text, sides_of
from flangeway.geometry.contour import JOINT_TOLERANCE, _joined
from flangeway.geometry.outline import Outline
from flangeway.geometry.region import Section, nested_regions
from flangeway.geometry.segments import Segment, segment_of
from flangeway.units import sentence

UNITS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
UNITS = tuple(UNITS_MM)
"""UNITS_MM, UNITS: units of length that drawings and profiles may have, and their lengths in mm."""


@dataclass(frozen=True)
class PartMaterial:
    """Elastic material of a part.

    An `InputError` if a number is out of range.

    - `young_MPa`: Young's modulus, positive.
    - `poisson`: Poisson's ratio, above -1 and below 0.5.
    """

    young_MPa: float  # noqa: N815 (the unit megapascal)
    poisson: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not (is_finite(self.young_MPa) and self.young_MPa > 0.0):
            raise InputError(sentence("{young_MPa = }", short(self.young_MPa)), "a positive number", "correct it")
        if not (is_finite(self.poisson) and -1.0 < self.poisson < 0.5):
            raise InputError(f"poisson = {short(self.poisson)}", "a number above -1 and below 0.5", "correct it")

    @property
    def shear_modulus_MPa(self) -> float:  # noqa: N802 (the unit megapascal)
        """``G = E / (2 (1 + nu))``."""
        return self.young_MPa / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True)
class DrawnSection:
    """What was read.

    An `InputError` if the unit is unknown, or some parts have a material and others none.

    - `unit`: unit of length of all coordinates, one of `UNITS`.
    - `materials`: material of each part; empty for a section of one material.
    - `notices`: what was repaired or left out, in sentences.
    - `certainty`: how accurate the outline is, if its source says so.
    """

    title: str
    section: Section
    unit: str
    materials: Mapping[str, PartMaterial] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    certainty: str = ""

    def __post_init__(self) -> None:
        """Check unit and materials; keep a copy that cannot be changed."""
        refuse_unit(self.unit)
        missing = sorted(set(self.section.parts) - set(self.materials))
        if self.materials and missing:
            raise InputError(
                f"no material for {', '.join(missing)}",
                "young_MPa and poisson for every part, or for none",
                "add both for each part",
            )
        object.__setattr__(self, "materials", MappingProxyType(dict(self.materials)))


def refuse_unit(unit: str) -> None:
    """Raise `InputError` for an unknown unit of length."""
    if unit not in UNITS:
        raise InputError(f"unit of length {unit!r}", f"one of {', '.join(UNITS)}", "name the unit of the coordinates")


def agreed_unit(in_file: str | None, given: str | None, how: str) -> str:
    """Return the unit of a file, or the one given for a file that names none, which it can do as `how` says.

    An `InputError` if both differ, or there is neither.
    """
    if given is not None:
        refuse_unit(given)
    if in_file is not None and given is not None and in_file != given:
        raise InputError(
            f"unit {given} for a file in {in_file}",
            "the file's own unit",
            "leave the unit out; coordinates are never converted",
        )
    unit = in_file or given
    if unit is None:
        raise InputError(
            "coordinates without a unit of length",
            how,
            'add the unit to the file; or give unit = "mm" in the case, --unit mm to `flangeway section`',
        )
    refuse_unit(unit)
    return unit


MAX_COORDINATE = 1e30  # so that the sixth power of a length, and products of such, stay within floating-point numbers


@dataclass(frozen=True)
class DrawnSegment:
    """Line, or arc if it has a centre, as a file gives it: not checked yet."""

    start: Point
    end: Point
    centre: Point | None = None
    counter_clockwise: bool = True
    name: str = "side"

    def checked(self) -> Segment:
        """Return the segment; see `Line` and `Arc` for what is refused."""
        return segment_of(self.start, self.end, self.centre, self.counter_clockwise)


def drawn_polygon(points: Sequence[Point]) -> list[DrawnSegment]:
    """Return the sides ``side_1`` and so on, from each point to the next and from the last to the first."""
    return [DrawnSegment(a, b, name=f"side_{number}") for number, (a, b) in enumerate(sides_of(points), 1)]


def drawn_circle(centre: Point, radius: float, name: str = "circle") -> list[DrawnSegment]:
    """Return a circle of four arcs, counter-clockwise."""
    x, y = centre
    ends = [(x + radius, y), (x, y + radius), (x - radius, y), (x, y - radius)]
    return [DrawnSegment(a, b, centre, counter_clockwise=True, name=name) for a, b in sides_of(ends)]


def reach_of(drawn: Iterable[DrawnSegment]) -> float:
    """Return the largest coordinate, in size, of the ends of segments."""
    return max(abs(coordinate) for segment in drawn for coordinate in (*segment.start, *segment.end))


def repaired_outline(
    drawn: Sequence[DrawnSegment], what: str, *, direction_matters: bool = True
) -> tuple[Outline, tuple[str, ...]]:
    """Return a counter-clockwise outline of segments in order, and a notice of each thing that was repaired.

    Repaired are points given twice (lines shorter than `JOINT_TOLERANCE` of the whole) and a clockwise direction, with
    a notice if it matters. An `InputError` if a number is not finite, the loop is open, meets itself or has no area; it
    calls the loop `what` and names the position.
    """
    if not drawn:
        raise InputError(f"{what}: no segment", "two segments or more", "draw the loop")
    _refuse_not_finite(drawn, what)
    kept, notices = _without_duplicates(drawn, what)
    _refuse_flat(kept or drawn, what)
    with located(f"{what}: "):
        segments = tuple(segment.checked() for segment in kept)
        names = [segment.name for segment in kept]
        outline = Outline.from_segments(segments, names)
    if direction_matters and Outline._trusted(_joined(segments, closed=True), tuple(names))._signed_area < 0.0:
        notices.append(f"{what}: drawn clockwise; its direction is reversed.")
    return outline, tuple(notices)


def _refuse_not_finite(drawn: Sequence[DrawnSegment], what: str) -> None:
    for number, segment in enumerate(drawn):
        for kind, point in (("start", segment.start), ("end", segment.end), ("centre", segment.centre)):
            if point is not None and not all(abs(coordinate) <= MAX_COORDINATE for coordinate in point):
                raise InputError(
                    f"{what}: {kind} of segment {number} ({segment.name}) is ({point[0]}, {point[1]})",
                    f"finite coordinates up to {MAX_COORDINATE:g}",
                    "repair or remove this point",
                )


def _without_duplicates(drawn: Sequence[DrawnSegment], what: str) -> tuple[list[DrawnSegment], list[str]]:
    """Leave out lines without length, and say where they were."""
    ends = np.array([point for segment in drawn for point in (segment.start, segment.end)])
    tolerance = JOINT_TOLERANCE * float(norms(np.ptp(ends, axis=0)))
    kept, notices = [], []
    for segment in drawn:
        if segment.centre is None and math.dist(segment.start, segment.end) <= tolerance:
            notices.append(f"{what}: the point {point_text(segment.start)} is given twice; one of both is left out.")
        else:
            kept.append(segment)
    return kept, notices


def _refuse_flat(drawn: Sequence[DrawnSegment], what: str) -> None:
    """Refuse points on one line: they would be found as sides that overlap, which explains less."""
    points = np.array([point for segment in drawn for point in (segment.start, segment.end)])
    local = points - points[0]
    spread = np.linalg.svd(local, compute_uv=False)
    if any(segment.centre is not None for segment in drawn) or spread[-1] > 1e-12 * max(spread[0], 1e-300):
        return
    raise InputError(
        f"{what}: no area, since all of its points lie on one line through {point_text(points[0])}",
        "a loop that encloses an area",
        "check the points",
    )


def section_of(
    outlines: Sequence[tuple[Outline, tuple[str, ...]]], unit: str, notices: Sequence[str] = ()
) -> DrawnSection:
    """Return the section of outlines with their notices: loops inside others are holes, or parts inside of these."""
    regions = nested_regions([outline for outline, _ in outlines])
    names = ["section"] if len(regions) == 1 else [f"part_{i}" for i in range(1, len(regions) + 1)]
    every = (*notices, *(notice for _, repaired in outlines for notice in repaired))
    return DrawnSection("", Section(dict(zip(names, regions, strict=True))), unit, notices=every)
