"""Meshes of the bodies of a case file, and positions on their boundaries."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.bodies.bodies_tables import BodyTable, DiscTable, FineTable, PlaceTable
from flangeway.cases.case import Box, require_known
from flangeway.errors import InputError
from flangeway.formats import read_mesh, read_section
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.formats.outline_files import ENDINGS
from flangeway.formats.outline_toml import outline_region
from flangeway.geometry import Arc, Contour, Line, Outline, Placement, circle, rectangle
from flangeway.geometry.arrays import norms
from flangeway.geometry.region import Region
from flangeway.mesh import PolyMesh, Refinement, dual, edges_halved, triangulate
from flangeway.problems import LinearBody
from flangeway.units import assigned, sentence

SHAPES = ("rectangle", "disc", "outline", "file")
DIAGONAL_PER_SIZE = 20.0  # diagonal of a shape per default edge length of its triangles
MAX_EDGES = 100_000  # along a side of an outline: more is a mistake in a size
RIM, ARC, CUT = "rim", "arc", "cut"
POINTS = ("start", "end", "centre")
"""Points of segments."""


@dataclass(frozen=True, eq=False)
class BodyShape:
    """A meshed shape in mm, in its initial position."""

    mesh: PolyMesh  # the mesh
    loops: tuple[Outline, ...] = ()  # its outlines; none of a mesh file

    def curve(self, names: str | Sequence[str] | None, points: NDArray[np.float64]) -> Contour | None:
        """Drawn curve along points (n, 2) of one outline; of named sides alone where these are one chain."""
        if not self.loops:
            return None
        loop = min(self.loops, key=lambda outline: float(outline.closest(points)[2].max()))
        try:
            return loop if names is None else loop.part([name for name in _listed(names) if name in loop.names])
        except InputError:
            return loop


def body_shape(body: BodyTable, key: str, notices: list[str]) -> BodyShape:
    """Mesh of a body in mm, in its initial position.

    It is an `InputError` if there is not one shape, a key does not go with it, or the shape or the mesh is wrong.
    - `key`: how messages call its table.
    - `notices`: receives a notice for each repair.
    """
    given = [shape for shape in SHAPES if getattr(body, shape) is not None]
    if len(given) != 1:
        raise InputError(
            f"{key}.{given[1] if given else 'name'} = {body.name!r} with {' and '.join(given) or 'no shape'}",
            f"one of {', '.join(SHAPES)}",
            "keep one" if given else "add one, such as rectangle = { width_mm = 10.0, height_mm = 5.0 }",
        )
    placement = Placement(np.deg2rad(body.rotation_deg), body.shift_mm)
    if body.file is not None and Path(body.file).suffix.lower() not in ENDINGS:
        return BodyShape(_mesh_of_file(body, key, notices).placed(placement))
    for name, value in (("cells", body.cells), ("materials", body.materials or None)):
        if value is not None:
            raise InputError(f"{key}.{name} = {value!r} of an outline", "cell sets of a mesh file", f"leave {name} out")
    region = _region(body, key, notices)
    diagonal = float(norms(np.ptp(region.outer.bounds(), axis=0)))
    fine = [_refinement(table, f"{key}.fine[{n}]", region) for n, table in enumerate(body.fine, 1)]
    size = body.size_mm or diagonal / DIAGONAL_PER_SIZE
    mesh = triangulate(region.outer, size=size, holes=region.holes, refinements=fine)
    mesh = dual(mesh) if body.method == "vem" else mesh
    if body.halved_side is not None:
        require_known(f"{key}.halved_side", body.halved_side, sorted(mesh.edge_sets))
        mesh = edges_halved(mesh, body.halved_side)
    return BodyShape(mesh.placed(placement), region.transformed(placement).loops)


def _region(body: BodyTable, key: str, notices: list[str]) -> Region:
    """Region in mm."""
    if body.file is not None:
        drawn = read_section(body.file, unit=body.unit)
        if len(drawn.section.regions) != 1:
            raise InputError(
                f"{key}.file = {body.file!r} with {len(drawn.section.regions)} parts", "one part", "make each a body"
            )
        notices += [f"{body.name}: {notice}" for notice in drawn.notices]
        outer, *holes = [_in_mm(loop, UNITS_MM[drawn.unit]) for loop in drawn.section.regions[0].loops]
        return Region(outer, tuple(holes))
    if body.unit is not None:
        raise InputError(f"{key}.unit = {body.unit!r} without file", "a file's unit", "leave it out, and give mm")
    if body.rectangle is not None:
        shape = body.rectangle
        return Region(rectangle(shape.width_mm, shape.height_mm, shape.centre_mm))
    if body.disc is not None:
        return Region(disc_outline(body.disc))
    return outline_region(body.outline or {}, f"{key}.outline: ", notices)


def disc_outline(disc: DiscTable) -> Outline:
    """Outline of a disc or a half disc."""
    x, y = disc.centre_mm
    if disc.half is None:
        segments = circle(disc.radius_mm, disc.centre_mm).segments
        return Outline.from_segments(segments, [RIM] * len(segments))
    sign = 1.0 if disc.half == "upper" else -1.0
    first, last = (x + sign * disc.radius_mm, y), (x - sign * disc.radius_mm, y)
    if disc.arc_deg is None:
        corners, names = [(x, y + sign * disc.radius_mm)], [RIM, RIM]
    else:
        angles = np.pi / 2.0 + np.deg2rad(disc.arc_deg) / 2.0 * np.array([-1.0, 1.0])
        ends = disc.centre_mm + sign * disc.radius_mm * np.column_stack((np.cos(angles), np.sin(angles)))
        corners, names = [(float(a), float(b)) for a, b in ends], [RIM, ARC, RIM]
    pairs = itertools.pairwise([first, *corners, last])
    arcs = [Arc(a, b, disc.centre_mm, counter_clockwise=True) for a, b in pairs]
    return Outline.from_segments([Line(last, first), *arcs], [CUT, *names])


def _refinement(fine: FineTable, key: str, region: Region) -> Refinement:
    """Where a mesh is finer: along a polyline, or along sides of the outline by points four edges apart."""
    given = [name for name in ("edges", "at_mm") if getattr(fine, name) is not None]
    if len(given) != 1:
        raise InputError(f"{key} with {' and '.join(given) or 'no position'}", "edges, or at_mm", "give one of both")
    if not (fine.at_mm or fine.edges):
        raise InputError(f"{key}.{given[0]} = []", "one position or more", f"give positions, or remove {key}")
    if fine.at_mm is not None:
        return Refinement(np.array(fine.at_mm).reshape(-1, 2), fine.size_mm, fine.growth)
    sides = [(name, side) for loop in region.loops for name, side in zip(loop.names, loop.segments, strict=True)]
    wanted = _listed(fine.edges)
    for name in wanted:
        require_known(f"{key}.edges", name, sorted({name for name, _ in sides}))
    chosen = [side for name, side in sides if name in wanted]
    longest = max(side.length for side in chosen)
    if longest > MAX_EDGES * fine.size_mm:
        raise InputError(
            sentence("{}.{size_mm = :g} along {:g mm}", key, fine.size_mm, longest),
            f"at most {MAX_EDGES} edges along a side",
            "take a larger size",
        )
    points = [
        side.point(np.linspace(0.0, 1.0, int(np.ceil(side.length / (4.0 * fine.size_mm))) + 1)) for side in chosen
    ]
    return Refinement(np.vstack(points), fine.size_mm, fine.growth)


def _mesh_of_file(body: BodyTable, key: str, notices: list[str]) -> PolyMesh:
    for name, value in (("size_mm", body.size_mm), ("fine", body.fine or None), ("halved_side", body.halved_side)):
        if value is not None:
            raise InputError(f"{key}.{name} with the mesh {body.file}", "the file's mesh as it is", f"leave {name} out")
    # bodies that touch must stay apart
    read = read_mesh(str(body.file), merge_points=body.cells is None)
    repairs, mesh = list(read.notices), read.mesh
    if body.cells is not None:
        wanted = _listed(body.cells)
        what = "cell sets of the file"
        if not wanted:
            raise InputError(f"{key}.cells = []", f"{what}: {', '.join(sorted(mesh.cell_sets))}", "leave cells out")
        for name in wanted:
            require_known(f"{key}.cells", name, sorted(mesh.cell_sets), what)
        joined = read.part(*wanted)
        repairs += [f"body {body.name}: {notice}" for notice in joined.notices]
        mesh = joined.mesh
    repairs = [f"{Path(str(body.file)).name}: {notice}" for notice in repairs]
    notices += [notice for notice in repairs if notice not in notices]
    if body.method == "fem" and (mesh.cell_sizes > 3).any():
        raise InputError(
            f"{key}.method = 'fem' for {body.file}, whose cells have up to {mesh.cell_sizes.max()} corners",
            'triangles for "fem", any polygons for "vem"',
            'set method = "vem"',
        )
    factor = UNITS_MM[body.unit or "mm"]
    return replace(mesh, points=mesh.points * factor)


def _in_mm(outline: Outline, factor: float) -> Outline:
    """Outline times the length of its unit in mm."""

    def scaled(segment: Line | Arc) -> Line | Arc:
        points: dict[str, Any] = {
            name: tuple(factor * x for x in value) for name, value in vars(segment).items() if name in POINTS
        }
        return replace(segment, **points)

    return Outline.from_segments([scaled(segment) for segment in outline.segments], outline.names)


def _listed(names: str | Sequence[str] | None) -> list[str]:
    return [names] if isinstance(names, str) else list(names or ())


Ints = NDArray[np.int32]

Where = str | tuple[float, float]

ON_LINE = 1e-6  # distance over the size of the mesh up to which a point lies on a line or in a box


def keys_of_place(table: PlaceTable) -> list[str]:
    """Keys of a table that say where, but for a point."""
    return [name for name in ("edges", "at_x_mm", "at_y_mm", "box_mm") if getattr(table, name) is not None]


def point_at(mesh: PolyMesh, order: int, body: str, point: tuple[float, float], key: str) -> tuple[float, float]:
    """Exact position of a point of a mesh, for order 2 also of the middle of an edge; an error names the nearest."""
    spots = mesh.points if order == 1 else np.vstack((mesh.points, mesh.points[mesh.edges].mean(axis=1)))
    apart = norms(spots - point)
    nearest = spots[apart.argmin()]
    if apart.min() > ON_LINE * float(norms(np.ptp(mesh.points, axis=0))):
        raise InputError(
            assigned(f"{key}.point_mm", list(point), "g"),
            sentence("a point of the mesh of {!r}; the nearest is [{:.9g (mm)}, {:.9g (mm)}]", body, *nearest),
            "give a corner of the outline or a point of the mesh",
        )
    return float(nearest[0]), float(nearest[1])


def edges_at(
    mesh: PolyMesh,
    body: str,
    names: str | Sequence[str] | None,
    box: Box | None,
    lines: tuple[float | None, float | None],
    key: str,
    which: str,
) -> Ints:
    """Boundary edges at a position, pairs of points (n, 2).

    - `body`: its name, for messages.
    - `names`: edge sets, or None for the whole boundary.
    - `box`: corners x_min, y_min, x_max, y_max of a box that contains them.
    - `lines`: the x and the y of lines on which they lie.
    - `key`, `which`: table and key, for messages.
    """
    pairs = mesh.boundary_edges
    if names is not None:
        chosen, what = _listed(names), f"edge sets of {body!r}"
        known = sorted(name for name in mesh.edge_sets if "[" not in name)
        if not chosen:
            raise InputError(f"{key}.{which} = []", f"{what}: {', '.join(known) or 'none'}", f"leave {which} out")
        for name in chosen:
            require_known(f"{key}.{which}", name, known, what)
        pairs = np.vstack([mesh.edge_sets[name] for name in chosen])
    slack = ON_LINE * float(norms(np.ptp(mesh.points, axis=0)))
    ends = mesh.points[pairs]
    inside = np.ones(len(pairs), dtype=np.bool_)
    for axis, value in enumerate(lines):
        if value is not None:
            inside &= (np.abs(ends[:, :, axis] - value) <= slack).all(axis=1)
    if box is not None:
        low, high = np.array(box[:2]) - slack, np.array(box[2:]) + slack
        inside &= ((ends >= low) & (ends <= high)).all(axis=(1, 2))
    if not inside.any():
        (x0, y0), (x1, y1) = mesh.points.min(axis=0), mesh.points.max(axis=0)
        raise InputError(
            f"{key}: no boundary edge of {body!r} is there",
            f"positions on its boundary, which reaches from ({x0:g}, {y0:g}) to ({x1:g}, {y1:g})",
            "correct the numbers; a box must contain whole edges",
        )
    return pairs[inside]


def free_edges(body: LinearBody, pairs: Ints) -> Ints:
    """Edges without a point that is fixed in both components, where no contact force could act."""
    nodes = body.edge_nodes(pairs)
    loose: NDArray[np.bool_] = np.logical_not(body.supported.all(axis=1))
    return pairs[loose[nodes].all(axis=1)]
