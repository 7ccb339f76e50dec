"""Rail and wheel profiles that come with the package, as outlines in mm, and rails as sections."""

import difflib
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, ClassVar

from flangeway.errors import InputError
from flangeway.formats import DrawnSection
from flangeway.formats.drawn_section import parse_segment, parse_table
from flangeway.geometry import Arc, Contour, Line, Outline, Placement, Region, Section, Segment
from flangeway.records import ByInstance
from flangeway.results import Shown
from flangeway.system.file_content import packaged_text

DATA = "flangeway.railway.profiles"

RAILS: tuple[str, ...] = ("136RE", "60E1", "60E2", "54E1", "49E1")  # names of the bundled rails
_CROWNS = {"136RE": (10.0, 8.0, 14.0)}
"""Radii of the crown in inches of a rail that has several, the default first."""

_OTHER_NAMES = {"UIC60": "60E1", "60KG": "60E1", "UIC54": "54E1", "S49": "49E1", "RE136": "136RE", "136LB": "136RE"}
"""Other names of bundled rails, in capital letters without blanks and hyphens (EN 13674-1, table A.1)."""

WHEELS = ("AAR-1B", "S1002", "heavy-haul")  # names of the bundled wheels
IDENTIFIED = "AAR-1B (identified)"
"""Name of the AAR-1B with the root that was identified from a published position. The reproduction of Tables 15 and 16
uses it, and nothing by default."""
IDENTIFIED_RADIUS_MM = 49.2
"""Radius of its wide arc, with which elements VO2, on the published kind of mesh, have the published lateral
translation of the curve, 0.7309 cm (Moherdaui 2021, Table 16). `flangeway reproduce wheel-rail` finds it again."""
REFERENCE_WHEELS = ("R-519-A", "R-519-B", "R-519-C", "R-519-H", "R-519-I")
REFERENCE_RAIL = "S-519-A"
"""REFERENCE_WHEELS, REFERENCE_RAIL: names of the reference profiles of EN 15302, which give no bodies to files."""

SECTIONS: Mapping[str, tuple[str, float | None]] = {
    "136RE": ("136RE", None),
    **{f"136RE-{radius:g}": ("136RE", radius) for radius in sorted(_CROWNS["136RE"])},
    **{name: (name, None) for name in RAILS[1:]},
}
"""Rail and radius of its crown in inches by the name of the section; None for the usual one."""

CUT_HEIGHT_MM = 50.0  # height above the tape line of the straight cut that closes a rim


@dataclass(frozen=True)
class RailProfile(Shown, ByInstance):
    """Cross-section of the right-hand rail, seen with the centre of the track at the left.

    Origin at the middle of the base: x lateral with the gauge side at negative x, y up; mm.

    - `outline`: whole section. Names of segments beside the middle end with ``_gauge`` or ``_field``.
    - `running_names`: segments of the running surface from the gauge side to the field side. (The outline, being
      counter-clockwise, passes them from the field side to the gauge side.)
    - `held_names`: segments of the base's underside.
    - `certainty`: accuracy of the contour.
    - `notices`: sentences on what was left out, bridged, smoothed or assumed when its file was read.
    - `placing_head`: head that is placed at the gauge, with its top at zero; None: the rail's own. Sections of a rail
      that varies along the track, and heads that wear in a computation, have that of the first section, or the head
      from which the wear began.
    - `unworn`: head of the rail when it was new, in the same frame; None: not known.
    - `fine`: the head for contact where it differs from the outline, as when it is worn a little; None: as drawn.
    """

    title: str
    outline: Outline
    running_names: tuple[str, ...]
    held_names: tuple[str, ...]
    certainty: str
    source: str
    notices: tuple[str, ...] = ()
    placing_head: Contour | None = None
    fine: Contour | None = None
    unworn: Contour | None = None

    @property
    def running_surface(self) -> Contour:
        """The head as one chain, from the field side to the gauge side: `fine` if there is one."""
        return self.fine or self.outline.part(self.running_names)


@dataclass(frozen=True)
class WheelProfile(Shown, ByInstance):
    """Lower part of the right-hand wheel's rim, in the wheel's own frame.

    Origin on the tape line: x lateral, the flange at negative x (towards the centre of the track);
    y up towards the axle, the tip of the flange at negative y; mm.

    - `outline`: region below the straight segment ``cut``.
    - `running_names`: segments from the flange's back to the rim's edge, in the direction of the outline.
    - `flange_height_mm`: depth of the flange's tip below the tape line.
    - `flange_back_mm`: distance of the flange's back face from the tape line.
    - `certainty`: accuracy of the contour.
    - `notices`: sentences on what was left out, bridged, smoothed or assumed when its file was read.
    - `fine`: the running surface where it is known better than the outline has it, with as smooth a curvature as is
      known, or worn a little: contact takes it, the elastic body keeps the outline. None: as drawn.
    """

    title: str
    outline: Outline
    running_names: tuple[str, ...]
    flange_height_mm: float
    flange_back_mm: float
    certainty: str
    source: str
    notices: tuple[str, ...] = ()
    fine: Contour | None = None
    held_names: ClassVar[tuple[str, ...]] = ("cut",)

    @property
    def running_surface(self) -> Contour:
        """The running surface as one chain, from the flange's back to the rim: `fine` if there is one."""
        return self.fine or self.outline.part(self.running_names)


def bundled_name(name: str) -> str:
    """Return the bundled name that one is another spelling of, such as 60E1 for ``"UIC 60"``; else the name itself."""
    name = str(name)  # None and numbers are names that there are not
    plain = _plain(name)
    plain = _OTHER_NAMES.get(plain, plain)
    names = (*SECTIONS, REFERENCE_RAIL, *WHEELS, *REFERENCE_WHEELS)
    return next((known for known in names if _plain(known) == plain), name)


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]", "", name).upper()


def _refuse_unknown(kind: str, name: str, known: Sequence[str], file: str = "of a profile") -> None:
    """Refuse a name that is not among the known ones; `file` is what a file in its place is."""
    if name not in known:
        near = difflib.get_close_matches(name.upper(), known, n=1, cutoff=0.75)
        raise InputError(
            f"{kind} {name!r}",
            f"one of {', '.join(known)}, or a file {file}",
            f"did you mean {near[0]}?" if near else f"give one of these, or the {kind}'s profile in a file",
        )


def rail(name: str = "136RE", *, crown_radius_in: float | None = None) -> RailProfile:
    """Return a rail section.

    Parameters
    ----------
    name
        One of `RAILS`, or `REFERENCE_RAIL`; other spellings are understood, see `bundled_name`.
    crown_radius_in
        Radius of the crown of a 136RE in inches: 8, 10 (the default) or 14. The others have one crown.

    Raises
    ------
    InputError
        If the name or the radius is unknown; the message lists those there are.
    """
    name = bundled_name(name)
    _refuse_unknown("rail", name, (*RAILS, REFERENCE_RAIL))
    radii = _CROWNS.get(name, ())
    radius = crown_radius_in if crown_radius_in is None else float(crown_radius_in)
    if radius is not None and radius not in radii:
        known = ", ".join(f"{radius:g}" for radius in sorted(radii))
        raise InputError(
            f"crown_radius_in = {crown_radius_in:g} for {name}",
            f"one of {known}" if known else "no crown radius: this rail has one crown",
            "choose a radius that is there" if known else "leave it out",
        )
    if name == REFERENCE_RAIL:
        # the body of a 60E1
        nominal, outline = rail("60E1"), Outline.named(_read_segments(name))
        return replace(nominal, outline=outline, unworn=outline.part(nominal.running_names), **_words(name))
    section = f"{name}-{radius or radii[0]:g}" if radii else name
    half = dict(_read_segments(section))
    below_crown = list(half)[1:]
    side = below_crown[: next(i for i, part in enumerate(below_crown, 1) if part.startswith("head_side"))]
    outline = _mirrored_and_joined(half)
    running = (*(f"{part}_gauge" for part in side[::-1]), "crown", *(f"{part}_field" for part in side))
    return RailProfile(
        outline=outline,
        running_names=running,
        held_names=("base",),
        unworn=outline.part(running),
        **_words(section, "EN 13674-1"),
    )


@cache  # of one small file, for each rail and wheel that is made
def _words(name: str, standard: str = "") -> dict[str, Any]:
    """Title, certainty and source of a profile, or of all those of a standard."""
    words = tomllib.loads(packaged_text(DATA, "words.toml"))
    return {"title": name, **words[name if name in words else standard]}


def wheel(name: str = "AAR-1B") -> WheelProfile:
    """Return the lower part of a wheel's rim.

    Parameters
    ----------
    name
        One of `WHEELS` or `REFERENCE_WHEELS`; other spellings are understood, see `bundled_name`.

    Raises
    ------
    InputError
        If the name is unknown.
    """
    name = bundled_name(name)
    if name != IDENTIFIED:
        _refuse_unknown("wheel", name, (*WHEELS, *REFERENCE_WHEELS))
    return _wheel(name)


@cache
def _wheel(name: str) -> WheelProfile:
    """Close a running surface by vertical faces and a straight cut."""
    running = Contour.named(_read_segments(name))
    back, outer = running.ends
    cut = [(outer[0], CUT_HEIGHT_MM), (back[0], CUT_HEIGHT_MM)]
    outline = Outline.closed(running.segments, cut, [*running.names, "outer_face", "cut", "back_face"])
    segments, names = outline.segments, outline.names
    if name.startswith("AAR-1B"):
        # from its cut on: meshes depend a little on where an outline begins, and recorded positions are those of this
        outline = Outline(segments[-2:] + segments[:-2], names[-2:] + names[:-2])
    return WheelProfile(
        outline=outline,
        running_names=tuple(dict.fromkeys(running.names)),
        flange_height_mm=-outline.bottom,
        flange_back_mm=-float(running.bounds()[0, 0]),
        fine=Contour.named(_read_segments("S1002_fine")) if name == "S1002" else None,
        **_words(name, "EN 15302"),
    )


def _read_segments(profile: str) -> list[tuple[str, Segment]]:
    """Return the named segments of a profile's data file."""
    rows, _ = parse_table(packaged_text(DATA, f"{profile}_arcs.csv"))
    return [(row["name"], parse_segment(row, number).checked()) for number, row in rows]


def _mirrored_and_joined(field_side: Mapping[str, Segment]) -> Outline:
    """Return the whole section: crown and base across the middle, both sides between them."""
    mirror = Placement(mirrored=True)
    sides = {k: v for k, v in field_side.items() if k not in ("crown", "base_bottom")}
    gauge_side = {part: segment.transformed(mirror) for part, segment in sides.items()}
    crown, bottom = field_side["crown"], field_side["base_bottom"]
    if not isinstance(crown, Arc):
        raise TypeError("the crown of a rail file is an arc")
    left_crown, left_bottom = crown.transformed(mirror), bottom.transformed(mirror)
    chain: list[tuple[str, Segment]] = [
        ("base", Line(left_bottom.start, bottom.start)),
        *((f"{part}_field", segment.reversed()) for part, segment in reversed(sides.items())),
        ("crown", Arc(crown.end, left_crown.end, (0.0, crown.centre[1]), True)),
        *((f"{part}_gauge", segment) for part, segment in gauge_side.items()),
    ]
    return Outline.named(chain)


def bundled_section(name: str) -> DrawnSection:
    """Return a bundled section; capital and small letters are the same.

    An `InputError` if there is none of that name; the message lists those there are.
    """
    key = bundled_name(name)
    _refuse_unknown("section", key, [*SECTIONS], "that ends with .toml, .csv or .dxf")
    rail_name, radius = SECTIONS[key]
    profile = rail(rail_name, crown_radius_in=radius)
    return DrawnSection(profile.title, Section({"section": Region(profile.outline)}), "mm", certainty=profile.certainty)
