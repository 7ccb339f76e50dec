"""Sections from DXF drawings: what is visible in model space, as loops and chains of lines and arcs.

Closed polylines, circles and ellipses are loops; lines, arcs, splines and open polylines are joined at their ends.
Loops inside others are holes, loops inside holes are further parts. Blocks are exploded: an affine map of a line,
an ellipse's conjugate radii and a spline's control points is the same of the image.
"""

import io
import itertools
import logging
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree
from shapely import Polygon

from flangeway.errors import InputError, located, short
from flangeway.formats.drawn_section import (
    DrawnSection,
    DrawnSegment,
    agreed_unit,
    drawn_circle,
    repaired_outline,
    section_of,
)
from flangeway.geometry.arrays import as_point, cross_product, extent, norms, point_text
from flangeway.geometry.biarcs import biarcs
from flangeway.geometry.outline import JOINT_TOLERANCE, Outline
from flangeway.geometry.segments import Segment
from flangeway.types import Floats

MILLIMETRES = 4
UNITS = {1: "in", 2: "ft", MILLIMETRES: "mm", 5: "cm", 6: "m"}  # $INSUNITS of the DXF reference
MAX_OBJECTS = 20_000  # in blocks, as often as these are inserted
MAX_DEPTH = 20  # blocks inside of each other
CURVE_TOLERANCE = 1e-5
"""Maximum distance of the arcs that replace an ellipse or a spline from the curve, relative to the curve's extent."""
ONE_SIDED = 1e-7  # of a span, how far inside of it a curve has the direction of its end: it may have a corner there
MAX_HEIGHT = 1e-6  # range of an object's third coordinate, relative to its coordinates, up to which it is plane
MIN_BULGE = 1e-9  # bulge of a side of a polyline, the tangent of a quarter of its angle, below which it is a line
SAME_HATCH = 0.01  # difference of areas, and of centroids, relative, up to which a hatched loop is a drawn one
_HOW_IN_DXF = "a drawing with $INSUNITS of inches, feet, mm, cm or m, or the input unit"
_READ = "LINE, ARC, CIRCLE, ELLIPSE, SPLINE, LWPOLYLINE, POLYLINE, and blocks of these"
_DRAWN = ("LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE")
_HATCHES = ("HATCH", "MPOLYGON")
logging.getLogger("ezdxf").addHandler(logging.NullHandler())  # what it repairs is no concern of the terminal
_ANNOTATIONS = {
    *("TEXT", "MTEXT", "ATTRIB", "ATTDEF", "DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION", "LEADER"),
    *("MULTILEADER", "MLEADER", "TOLERANCE", "POINT", "VIEWPORT", "IMAGE", "WIPEOUT", "RAY", "XLINE", "SHAPE"),
    *("ACAD_TABLE", "LIGHT", "SUN", "OLEFRAME", "OLE2FRAME", "PDFUNDERLAY", "DWFUNDERLAY", "DGNUNDERLAY"),
    *("GEODATA", "RTEXT", "ARCALIGNEDTEXT"),
}
"""Objects that bound no area."""


@dataclass(frozen=True, eq=False)
class _Object:
    """An object with the matrix (4, 4) that takes its axes, points as rows, to those of model space.

    - `label`: what messages call it; the handle of an object of a block is that of the inserted block.
    """

    entity: Any
    layer: str
    label: str
    matrix: Floats

    def in_space(self, points: Any) -> Floats:
        """Return points (n, 3) of its axes in those of model space (n, 3)."""
        rows = np.reshape([tuple(point) for point in points], (-1, 3))
        return (np.column_stack((rows, np.ones(len(rows)))) @ self.matrix)[:, :3]

    def placed(self, points: Any) -> Floats:
        """Return points (n, 3) of its axes in the plane of the drawing (n, 2)."""
        space = self.in_space(points)
        if not np.isfinite(space).all() or np.ptp(space[:, 2]) > MAX_HEIGHT * np.abs(space).max():
            raise InputError(
                f"{self.label}, which is not parallel to the x-y plane", "a plane drawing", "flatten the drawing"
            )
        return space[:, :2]


@dataclass(eq=False)
class Drawing:
    """Closed loops and open chains of the visible objects of a drawing, its unit, and notices of what is not read.

    - `hatched`: outlines (n, 2) of hatches by the label of these.
    - `ignored`, `curves`: counts of what is left out, and of what is replaced by arcs; `off` is the distance of these.
    """

    unit: str | None
    loops: list[list[DrawnSegment]] = field(default_factory=list)
    chains: list[list[DrawnSegment]] = field(default_factory=list)
    hatched: list[tuple[str, Floats]] = field(default_factory=list)
    left_out: list[tuple[str, Floats]] = field(default_factory=list)
    ignored: Counter[str] = field(default_factory=Counter)
    curves: Counter[str] = field(default_factory=Counter)
    off: float = 0.0

    @property
    def notices(self) -> list[str]:
        """A sentence for each kind of object that is left out or replaced."""
        notices = [f"Left out: {count} {kind}." for kind, count in sorted(self.ignored.items())]
        notices += [
            f"{count} {kind}: lines and arcs that are at most {self.off:.2g} from the curve take its place."
            for kind, count in sorted(self.curves.items())
        ]
        return notices

    def refuse_unread(self) -> None:
        """Raise `InputError` for an object that is not read and lies where something is drawn."""
        drawn = [np.array([p for s in chain for p in (s.start, s.end)]) for chain in self.loops + self.chains]
        for label, points in self.left_out:
            if _lies_in(points, [(ends.min(axis=0), ends.max(axis=0)) for ends in drawn]):
                raise InputError(
                    f"{label}, which is not read and lies in the section",
                    _READ,
                    "explode it or draw its outline, or leave its layer out",
                )


def read_drawing(content: bytes, layers: Sequence[str] = ()) -> Drawing:
    """Return what the model space of a DXF file shows: objects that are visible, or all those of some layers.

    An `InputError` if the file is no drawing or damaged, a layer is unknown, or an object lies in what is drawn and is
    not read, or is not plane.
    """
    from ezdxf import bbox, recover  # noqa: PLC0415  (slow to import, and few programs read drawings)

    with damage_reported("a file that is no DXF drawing"):
        document, auditor = recover.read(io.BytesIO(content))
    if auditor.has_errors:
        raise InputError(
            f"a damaged drawing: {auditor.errors[0].message}", "DXF without errors", "save the drawing as DXF again"
        )
    number = document.header.get("$INSUNITS", 0)
    drawing = Drawing(UNITS.get(number) if isinstance(number, int) else None)
    with damage_reported():
        for item in _visible(document, layers, drawing.ignored):
            kind = item.entity.dxftype()
            is_mesh = kind == "POLYLINE" and not (item.entity.is_2d_polyline or item.entity.is_3d_polyline)
            if kind in _DRAWN and not is_mesh:
                _draw(item, drawing)
                continue
            drawing.ignored[kind] += 1
            if kind in _HATCHES:
                drawing.hatched += _hatched(item)
            elif kind not in _ANNOTATIONS:
                box = bbox.extents([item.entity], fast=True)
                # an object of which the library knows no extent may lie anywhere
                extremes = (
                    item.in_space(box.cube_vertices()) if box.has_data else np.outer([-np.inf, np.inf], np.ones(2))
                )
                drawing.left_out.append((item.label, extremes[:, :2]))
        drawing.refuse_unread()
    return drawing


def dxf_section(content: bytes, *, unit: str | None = None, layers: Sequence[str] = ()) -> DrawnSection:
    """Return the section that a DXF drawing shows, see `read_drawing`; the unit is needed if the drawing names none.

    An `InputError` as of `read_drawing`, or if an outline is wrong or only hatched.
    """
    drawing = read_drawing(content, layers)
    loops = drawing.loops + joined_chains(drawing.chains)
    if not loops:
        raise InputError(
            " ".join(["a drawing without a closed outline in its model space.", *drawing.notices]),
            "visible lines and arcs in model space",
            "draw the outline, or show its layer",
        )
    agreed = agreed_unit(drawing.unit, unit, _HOW_IN_DXF)
    repaired = [
        repaired_outline(loop, f"loop {number} of {len(loops)} (layer {loop[0].name!r})", direction_matters=False)
        for number, loop in enumerate(loops, 1)
    ]
    _refuse_hatched(drawing.hatched, [outline for outline, _ in repaired])
    return section_of(repaired, agreed, drawing.notices)


@contextmanager
def damage_reported(what: str = "a damaged drawing") -> Iterator[None]:
    """Turn what the library raises about damaged entities, of whatever kind, into an InputError."""
    from ezdxf.lldxf.const import DXFError  # noqa: PLC0415  (slow to import, and few programs read drawings)

    faults = AttributeError, TypeError, ValueError, LookupError, ArithmeticError, AssertionError, OSError, DXFError
    try:
        # a doubled corner with a bulge has no centre; it is refused later
        with np.errstate(all="ignore"):
            yield
    except (*faults, RecursionError) as reason:
        raise InputError(f"{what}: {reason}", "DXF without errors", "save the drawing as DXF again") from reason


# --- What is visible: layers, and blocks inside of blocks.


def _visible(document: Any, layers: Sequence[str], ignored: Counter[str]) -> Iterator[_Object]:
    """Objects of model space and of its blocks that are visible; of the others `ignored` counts those on each layer.

    Objects of a block on layer 0 are on that of the inserted block. A frozen layer hides inserted blocks as a whole.
    """
    from ezdxf.xclip import XClip  # noqa: PLC0415  (slow to import, and few programs read drawings)

    states = {layer.dxf.name.lower(): (layer.is_off(), layer.is_frozen()) for layer in document.layers}
    chosen = {name.lower() for name in layers}
    for name in layers:
        if name.lower() not in states:
            raise InputError(
                f"layer {short(name)}", ", ".join(sorted(layer.dxf.name for layer in document.layers)), "choose one"
            )
    n_objects = 0

    def inside(entities: Any, above: str, handle: str, matrix: Floats, depth: int) -> Iterator[_Object]:
        nonlocal n_objects
        n_objects += 1 + len(entities) if depth else 0
        if n_objects > MAX_OBJECTS or depth > MAX_DEPTH:
            raise InputError(
                f"blocks of more than {MAX_OBJECTS} objects, or inside of each other more than {MAX_DEPTH} times",
                "a drawing of a section",
                "leave the section alone in the drawing",
            )
        for entity in entities:
            layer = above if above and entity.dxf.layer == "0" else str(entity.dxf.layer)
            off, frozen = states.get(layer.lower(), (False, False))
            kind, name = entity.dxftype(), handle or str(entity.dxf.handle)
            label = f"a {kind} with the handle {name} on layer {layer!r}"
            is_block = kind == "INSERT"
            if entity.dxf.get("invisible", 0) or (not chosen and (frozen or (off and not is_block))):
                ignored[f"{kind}, hidden, on layer {layer!r}"] += 1
            elif not is_block:
                if not chosen or layer.lower() in chosen:
                    yield _Object(entity, layer, label, matrix)
            else:
                block = entity.block()
                if block is None or block.block.is_xref or XClip(entity).has_clipping_path:
                    raise InputError(
                        f"{label}, which is clipped, or whose block {short(entity.dxf.name)} is not in the file",
                        "whole blocks of the same file",
                        "bind or explode it, or leave its layer out",
                    )
                for single in entity.multi_insert() if entity.mcount > 1 else (entity,):
                    own = np.reshape(list(single.matrix44()), (4, 4)) @ matrix
                    yield from inside(block, layer, name, own, depth + 1)

    return inside(document.modelspace(), "", "", np.eye(4), 0)


# --- Objects as lines and arcs.


def _draw(item: _Object, drawing: Drawing) -> None:
    """Add what an object draws to the loops or chains of a drawing."""
    entity, kind, dxf = item.entity, item.entity.dxftype(), item.entity.dxf
    if kind in ("LWPOLYLINE", "POLYLINE"):
        pieces, closed = _polyline(item, drawing)
    elif kind == "LINE":
        pieces, closed = _line(item, [dxf.start, dxf.end]), False
    elif kind == "SPLINE":
        pieces, closed = _spline(item, drawing), False
    else:
        centre, first, last = dxf.center, 0.0, 2.0 * math.pi
        if kind == "ELLIPSE":
            first, last = dxf.start_param, dxf.end_param
            points = [centre, centre + dxf.major_axis, centre + entity.minor_axis]
        else:
            if kind == "ARC":
                first, last = math.radians(dxf.start_angle), math.radians(dxf.end_angle)
            points = _radii(item, complex(centre.x, centre.y), dxf.radius, centre.z)
        turn = (last - first) % (2.0 * math.pi)
        closed = min(turn, 2.0 * math.pi - turn) <= JOINT_TOLERANCE
        pieces = _ellipse(item, points, first, 2.0 * math.pi if closed else turn, drawing)
    if pieces:
        (drawing.loops if closed else drawing.chains).append(pieces)
    else:
        drawing.ignored[f"{kind} without length"] += 1


def _line(item: _Object, ends: Any) -> list[DrawnSegment]:
    """A line between two points of the object's axes, or nothing if it has no length."""
    start, end = item.placed(ends)
    return [DrawnSegment(as_point(start), as_point(end), name=item.layer)] if (start != end).any() else []


def _polyline(item: _Object, drawing: Drawing) -> tuple[list[DrawnSegment], bool]:
    """Lines and arcs of a polyline in order, and whether it is closed."""
    entity, axes = item.entity, item.entity.ocs()
    if entity.dxftype() == "LWPOLYLINE":
        closed, height, corners = entity.closed, entity.dxf.elevation, entity.get_points("xyb")
    else:
        # the control polygon of a smoothed polyline, flag 16, is not drawn
        drawn = [vertex.dxf for vertex in entity.vertices if not vertex.dxf.flags & 16]
        closed, height = entity.is_closed, entity.dxf.elevation.z
        corners = [(*v.location.vec2, v.get("bulge", 0.0)) for v in drawn]
        if entity.is_3d_polyline:
            sides = _sides([v.location for v in drawn], closed)
            return [piece for side in sides for piece in _line(item, side)], closed
    pieces = []
    for (x, y, bulge), (end_x, end_y, _) in _sides(corners, closed):
        start, end = complex(x, y), complex(end_x, end_y)
        if abs(bulge) < MIN_BULGE or start == end:
            pieces += _line(item, axes.points_to_wcs([(x, y, height), (end_x, end_y, height)]))
            continue
        centre = (start + end) / 2.0 + 1j * (end - start) * (1.0 - bulge * bulge) / (4.0 * bulge)
        pieces += _ellipse(item, _radii(item, centre, start - centre, height), 0.0, 4.0 * math.atan(bulge), drawing)
    return pieces, closed


def _radii(item: _Object, centre: complex, radius: complex, height: float) -> Any:
    """Centre of a circle, and the ends of a radius and of the one a quarter of a turn ahead, (3, 3), from its plane."""
    spots = (centre, centre + radius, centre + 1j * radius)
    return item.entity.ocs().points_to_wcs([(spot.real, spot.imag, height) for spot in spots])


def _sides(corners: Any, closed: bool) -> list[tuple[Any, Any]]:
    """Pairs of corners that follow each other; of closed ones the last and the first too."""
    return list(zip(corners, [*corners[1:], *corners[: int(closed)]], strict=False))


def _ellipse(item: _Object, points: Any, first: float, turn: float, drawing: Drawing) -> list[DrawnSegment]:
    """Part of an ellipse, or the whole; one arc where it is a part of a circle.

    - `points`: its centre, and the ends of two conjugate radii, (3, 3).
    - `first`, `turn`: parameter at its start, 0 at the first radius, and its change.
    """
    centre, *ends = item.placed(points)
    radii = ends - centre
    sizes = norms(radii)
    if not sizes.max() > 0.0:
        return []

    def trace(at: Floats, _: Floats) -> tuple[Floats, Floats]:
        cosine, sine = np.cos(at), np.sin(at)
        return centre + np.column_stack((cosine, sine)) @ radii, np.column_stack((-sine, cosine)) @ radii

    spans = first + turn * np.linspace(0.0, 1.0, 9)
    if max(abs(np.diff(sizes)[0]), abs(radii[0] @ radii[1]) / sizes.max()) > 1e-9 * sizes.max():
        return _arcs(trace, spans, extent(centre + np.vstack((radii, -radii))), item, drawing)
    if abs(turn) >= 2.0 * math.pi - JOINT_TOLERANCE:
        return drawn_circle(as_point(centre), float(sizes[0]), item.layer)
    start, end = trace(spans[[0, -1]], spans)[0]
    forward = bool(cross_product(radii[0], radii[1]) * turn > 0.0)
    return [DrawnSegment(as_point(start), as_point(end), as_point(centre), forward, item.layer)]


def _spline(item: _Object, drawing: Drawing) -> list[DrawnSegment]:
    """Arcs and lines along a rational B-spline."""
    tool = item.entity.construction_tool()
    knots, degree = np.array(tool.knots()), tool.order - 1
    weights = np.reshape(tool.weights() or np.ones(tool.count), (-1, 1))
    controls = item.placed(tool.control_points)
    curve = BSpline(knots, np.column_stack((weights * controls, weights)), degree)
    slope = curve.derivative()

    def trace(at: Floats, inside: Floats) -> tuple[Floats, Floats]:
        (x, y, weight), (along_x, along_y, growth) = curve(at).T, slope(inside).T
        points = np.column_stack((x, y)) / weight[:, None]
        return points, np.column_stack((along_x, along_y)) - growth[:, None] * points

    return _arcs(trace, np.unique(knots[degree : tool.count + 1]), extent(controls), item, drawing)


def _arcs(
    trace: Callable[[Floats, Floats], tuple[Floats, Floats]],
    spans: Floats,
    size: float,
    item: _Object,
    drawing: Drawing,
) -> list[DrawnSegment]:
    """Arcs and lines within `CURVE_TOLERANCE` of a curve that is smooth between parameters.

    - `trace`: points of the curve at parameters, and directions at parameters inside of the same span.
    """
    tolerance = CURVE_TOLERANCE * size
    if not tolerance > 0.0:
        return []
    drawing.curves[item.entity.dxftype()] += 1
    drawing.off = max(drawing.off, tolerance)

    def within(ends: Floats, at: Floats) -> tuple[Floats, Floats]:
        return trace(at, np.clip(at, *ends))

    pieces: list[Segment] = []
    for span in itertools.pairwise(spans):
        ends = np.average([span, span[::-1]], axis=1, weights=(1.0, ONE_SIDED))
        with located(f"{item.label}: "):
            pieces += biarcs(partial(within, ends), np.array(span), tolerance)
    return [
        DrawnSegment(s.start, s.end, getattr(s, "centre", None), getattr(s, "counter_clockwise", True), item.layer)
        for s in pieces
    ]


def _hatched(item: _Object) -> list[tuple[str, Floats]]:
    """Outlines of a hatch (n, 2) behind its label, without those about texts."""
    from ezdxf.path import from_hatch  # noqa: PLC0415  (slow to import, and few programs read drawings)

    return [
        (item.label, item.placed(path.flattening(SAME_HATCH / 10.0 * extent(np.array(path.control_vertices())[:, :2]))))
        for path in from_hatch(item.entity)
        if not getattr(path.user_data, "textbox", False)
    ]


def _refuse_hatched(hatched: Sequence[tuple[str, Floats]], drawn: Sequence[Outline]) -> None:
    """Refuse hatches with an outline in the section that is not drawn besides: it may be that of a hole."""
    for label, points in hatched:
        shape = Polygon(points)
        middle, size = (shape.centroid.x, shape.centroid.y), math.sqrt(shape.area)
        is_drawn = any(
            abs(outline.area - shape.area) <= SAME_HATCH * shape.area
            and math.dist(outline.centroid, middle) <= SAME_HATCH * size
            for outline in drawn
        )
        if not is_drawn and _lies_in(points, [outline.bounds() for outline in drawn]):
            raise InputError(
                f"{label} with an outline about {point_text(middle)} that is not drawn",
                "hatches whose outlines are drawn",
                "draw the outline, or leave the layer of the hatch out",
            )


def _lies_in(points: Floats, boxes: Sequence[Any]) -> bool:
    """Whether the box about points (n, 2) meets one of some boxes, pairs of the lowest and the highest coordinates."""
    return any((points.min(axis=0) <= high).all() and (points.max(axis=0) >= low).all() for low, high in boxes)


# --- Lines and arcs joined at their ends.


def reversed_segment(segment: DrawnSegment) -> DrawnSegment:
    """Return the segment from its end to its start."""
    return DrawnSegment(segment.end, segment.start, segment.centre, not segment.counter_clockwise, segment.name)


def joined_chains(chains: Sequence[list[DrawnSegment]], *, closed: bool = True) -> list[list[DrawnSegment]]:
    """Join chains at their ends, each of which must meet exactly one other, or none where they need not be closed."""
    if not chains:
        return []
    ends = np.array([point for chain in chains for point in (chain[0].start, chain[-1].end)])
    size = extent(np.array([segment.start for chain in chains for segment in chain]))
    tolerance = JOINT_TOLERANCE * max(size, np.finfo(float).tiny)
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
    for index in (*(n for n in range(len(ends)) if n not in partner), *range(0, len(ends), 2)):
        if index // 2 not in left:
            continue
        chain: list[DrawnSegment] = []
        at: int | None = index
        while at is not None and at // 2 in left:
            piece = chains[at // 2]
            left.remove(at // 2)
            chain += piece if at % 2 == 0 else [reversed_segment(s) for s in reversed(piece)]
            at = partner.get(at ^ 1)
        joined.append(_exact_joints(chain) if index in partner else chain)
    return joined


def _exact_joints(loop: list[DrawnSegment]) -> list[DrawnSegment]:
    """Move every start onto the end before it, within the tolerance of joining."""
    return [replace(segment, start=before.end) for before, segment in itertools.pairwise([loop[-1], *loop])]
