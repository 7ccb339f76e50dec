"""Sections from DXF drawings: LINE, ARC, CIRCLE, and polylines with bulges.

Closed polylines and circles are loops; lines, arcs and open polylines are joined at their ends. Loops inside others are
holes, loops inside holes are further parts. Needs nothing of the drawing's layers.
"""

import io
import itertools
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from flangeway.errors import InputError
from flangeway.formats.drawn_section import (
    DrawnSection,
    DrawnSegment,
    agreed_unit,
    drawn_circle,
    repaired_outline,
    section_of,
)
from flangeway.geometry.arrays import Point, norms, point_text
from flangeway.geometry.contour import JOINT_TOLERANCE

UNITS = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m"}  # $INSUNITS of the DXF reference
CURVED_ENTITIES = ("SPLINE", "ELLIPSE", "INSERT", "REGION", "MLINE", "HELIX", "3DSOLID", "BODY", "MESH", "3DFACE")
_HOW = "a drawing with $INSUNITS of inches, feet, mm, cm or m, or the input unit"


def dxf_section(content: bytes, *, unit: str | None = None) -> DrawnSection:
    """Return the section that the model space of a DXF drawing shows; the unit is needed if the drawing names none.

    An `InputError` if it is no drawing, holds curves that are neither lines nor arcs, or an outline is wrong.
    """
    drawing = open_drawing(content)
    if not len(drawing.modelspace()):
        raise InputError(
            "no drawing in the model space of a DXF file",
            "lines and arcs in model space",
            "check the format of the file, or draw the outline in model space",
        )
    agreed = agreed_unit(unit_of(drawing), unit, _HOW)
    with damage_reported():
        loops, chains, ignored = pieces_of(drawing)
        loops += joined_chains(chains)
    if not loops:
        raise InputError("a drawing without a closed outline in its model space", "lines and arcs", "draw the outline")
    left_out = [f"Left out: {count} {kind}." for kind, count in sorted(ignored.items())]
    named = [(f"loop {number} of {len(loops)} (layer {loop[0].name!r})", loop) for number, loop in enumerate(loops, 1)]
    repaired = [repaired_outline(loop, what, direction_matters=False) for what, loop in named]
    return section_of(repaired, agreed, left_out)


def pieces_of(drawing: Any) -> tuple[list[list[DrawnSegment]], list[list[DrawnSegment]], Counter[str]]:
    """Return the closed loops and open chains of a drawing, and how many entities of other kinds there are."""
    loops: list[list[DrawnSegment]] = []
    chains: list[list[DrawnSegment]] = []
    ignored: Counter[str] = Counter()
    for entity in drawing.modelspace():
        kind = entity.dxftype()
        if kind in CURVED_ENTITIES:
            raise InputError(
                f"a {kind} on layer {entity.dxf.layer!r}",
                "LINE, ARC, CIRCLE, LWPOLYLINE and POLYLINE",
                "explode it, or turn it into lines and arcs",
            )
        if kind == "CIRCLE":
            centre = _flat(entity, entity.dxf.center)
            loops.append(drawn_circle(centre, float(entity.dxf.radius), entity.dxf.layer))
        elif kind in ("LINE", "ARC"):
            chains.append([drawn_entity(entity)])
        elif kind == "LWPOLYLINE" or (kind == "POLYLINE" and entity.is_2d_polyline):
            pieces = [drawn_entity(piece) for piece in entity.virtual_entities()]
            if pieces:
                (loops if entity.is_closed else chains).append(in_order(pieces))
        else:
            ignored[kind] += 1
    return loops, chains, ignored


@contextmanager
def damage_reported(what: str = "a damaged drawing") -> Iterator[None]:
    """Turn what the library raises about damaged entities, of whatever kind, into an InputError."""
    from ezdxf.lldxf.const import DXFError  # noqa: PLC0415  (slow to import, and few programs read drawings)

    faults = AttributeError, TypeError, ValueError, LookupError, ArithmeticError, AssertionError, OSError, DXFError
    try:
        # a doubled corner with a bulge has no centre; it is refused later
        with np.errstate(all="ignore"):
            yield
    except faults as reason:
        raise InputError(f"{what}: {reason}", "DXF without errors", "save the drawing as DXF again") from reason


def unit_of(drawing: Any) -> str | None:
    """Return the unit of length that the drawing names, if any."""
    number = drawing.header.get("$INSUNITS", 0)
    return UNITS.get(number) if isinstance(number, int) else None


def open_drawing(content: bytes) -> Any:
    """Return the ezdxf document of a file's bytes; an InputError if it is none or damaged."""
    from ezdxf import recover  # noqa: PLC0415  (slow to import, and few programs read drawings)

    with damage_reported("a file that is no DXF drawing"):
        drawing, auditor = recover.read(io.BytesIO(content))
    if auditor.has_errors:
        raise InputError(
            f"a damaged drawing: {auditor.errors[0].message}", "DXF without errors", "save the drawing as DXF again"
        )
    return drawing


def _flat(entity: Any, point: Any) -> Point:
    """Return a point of the entity's own axes in the plane of the drawing."""
    upwards = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    if not math.isclose(abs(upwards[2]), math.hypot(*upwards), rel_tol=1e-9):
        raise InputError(
            f"a {entity.dxftype()} on layer {entity.dxf.layer!r} that is not parallel to the x-y plane",
            "a plane drawing",
            "flatten the drawing",
        )
    place = point if entity.dxftype() == "LINE" else entity.ocs().to_wcs(point)
    return float(place[0]), float(place[1])


def drawn_entity(entity: Any) -> DrawnSegment:
    """Return a LINE or ARC with its layer as name."""
    layer = str(entity.dxf.layer)
    if entity.dxftype() == "LINE":
        return DrawnSegment(_flat(entity, entity.dxf.start), _flat(entity, entity.dxf.end), name=layer)
    centre = _flat(entity, entity.dxf.center)
    start, end = entity.start_point, entity.end_point
    # an extrusion downwards shows the arc from below
    upwards = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))[2] > 0.0
    return DrawnSegment(
        (float(start[0]), float(start[1])),
        (float(end[0]), float(end[1])),
        centre,
        counter_clockwise=upwards,
        name=layer,
    )


def reversed_segment(segment: DrawnSegment) -> DrawnSegment:
    """Return the segment from its end to its start."""
    return DrawnSegment(segment.end, segment.start, segment.centre, not segment.counter_clockwise, segment.name)


def in_order(pieces: Sequence[DrawnSegment]) -> list[DrawnSegment]:
    """Turn the pieces of a polyline, whose arcs all run counter-clockwise, so that each follows the one before."""
    if len(pieces) == 1:
        return list(pieces)
    first, second = pieces[0], pieces[1]

    def gap(point: Point) -> float:
        return min(math.dist(point, second.start), math.dist(point, second.end))

    ordered = [first if gap(first.end) <= gap(first.start) else reversed_segment(first)]
    for piece in pieces[1:]:
        place = ordered[-1].end
        forward = math.dist(place, piece.start) <= math.dist(place, piece.end)
        ordered.append(piece if forward else reversed_segment(piece))
    return ordered


def joined_chains(chains: Sequence[list[DrawnSegment]], *, closed: bool = True) -> list[list[DrawnSegment]]:
    """Join chains at their ends, each of which must meet exactly one other, or none where they need not be closed."""
    if not chains:
        return []
    ends = np.array([point for chain in chains for point in (chain[0].start, chain[-1].end)])
    tolerance = JOINT_TOLERANCE * max(float(norms(np.ptp(ends, axis=0))), np.finfo(float).tiny)
    near = cKDTree(ends).query_ball_point(ends, tolerance)
    for number, group in enumerate(near):
        if len(group) != 2 and (closed or len(group) > 2):
            word = "an open end" if len(group) == 1 else f"{len(group)} ends that meet"
            raise InputError(
                f"{word} at {point_text(ends[number])}, layer {chains[number // 2][0].name!r}",
                f"ends that meet one other each, to {tolerance:.3g}",
                "close the gap, or draw parts that touch as closed polylines",
            )
    partner = {number: other for number, group in enumerate(near) for other in group if other != number}
    left = set(range(len(chains)))
    joined = []
    # open chains are entered at a free end, closed ones at one of their ends
    for place in (*(n for n in range(len(ends)) if n not in partner), *range(0, len(ends), 2)):
        if place // 2 not in left:
            continue
        chain: list[DrawnSegment] = []
        at: int | None = place
        while at is not None and at // 2 in left:
            piece = chains[at // 2]
            left.remove(at // 2)
            chain += piece if at % 2 == 0 else [reversed_segment(s) for s in reversed(piece)]
            at = partner.get(at ^ 1)
        joined.append(_exact_joints(chain) if place in partner else chain)
    return joined


def _exact_joints(loop: list[DrawnSegment]) -> list[DrawnSegment]:
    """Move every start onto the end before it, within the tolerance of joining."""
    return [
        DrawnSegment(before.end, s.end, s.centre, s.counter_clockwise, s.name)
        for before, s in itertools.pairwise([loop[-1], *loop])
    ]
