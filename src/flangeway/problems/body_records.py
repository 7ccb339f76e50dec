"""Bodies as records: shapes, meshes, elements and materials, and supports, springs and loads on their boundaries."""

# ruff: noqa: N815 (units in names)
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import annotated_types as at
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from flangeway.elements import Element, Lagrange, TraceStabilisation, Virtual
from flangeway.errors import InputError, located, short
from flangeway.formats import read_mesh, read_section
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.formats.mesh_repair import with_arcs
from flangeway.formats.outline_files import ENDINGS, OutlineTable
from flangeway.geometry import Arc, Contour, Line, Outline, Placement, circle, half_disc, rectangle
from flangeway.geometry.arrays import IntArray, norms
from flangeway.geometry.region import Region
from flangeway.materials import Elastic, Hypothesis
from flangeway.mesh import PolyMesh, Refinement, dual, edges_halved, triangulate
from flangeway.problems.loads import (
    AppliedLoad,
    BodyForce,
    Gravity,
    PointForce,
    PrescribedDisplacement,
    Pressure,
    Spring,
    TemperatureChange,
    Traction,
)
from flangeway.records import (
    Box,
    ElementOrder,
    ElementSize,
    Fraction,
    LengthUnit,
    NotNegative,
    Pair,
    Positive,
    Record,
    require_known,
)

# --- Bodies, and what holds and loads them.


HypothesisName = Literal["plane-strain", "plane-stress", "axisymmetric"]

HYPOTHESES: dict[HypothesisName, Hypothesis] = {
    "plane-strain": "plane_strain",
    "plane-stress": "plane_stress",
    "axisymmetric": "axisymmetric",
}

T_PER_MM3 = 1e-12
"""Density of 1 kg/m3 in t/mm3, which goes with forces in N and lengths in mm."""

MethodName = Literal["fem", "vem", "vem-triangles"]
Stabilisation = Annotated[
    Literal["default", "trace"],
    Field(description="stabilisation of virtual elements; trace: half of the trace (Moherdaui 2021, 3.96)"),
]


Names = str | Annotated[list[str], Field(min_length=1)]
"""One name or several."""
Where = str | tuple[float, float]
"""Name of an edge set, or a point."""
MAX_EDGES = 100_000  # points of a refinement along a side: no mesh can be as fine
MM_PER_M = 1e3


class RectangleTable(Record):
    """A rectangle with the sides ``bottom``, ``right``, ``top``, ``left``."""

    width_mm: Positive
    """extent in x"""
    height_mm: Positive
    """extent in y"""
    centre_mm: Pair = (0.0, 0.0)
    """its middle"""

    def region(self) -> Region:
        """The shape."""
        return Region(rectangle(self.width_mm, self.height_mm, self.centre_mm))


class DiscTable(Record):
    """A disc with the edge set ``rim``; a half disc has its straight side as ``cut``, and an ``arc`` about its apex."""

    radius_mm: Positive
    """radius"""
    centre_mm: Pair = (0.0, 0.0)
    """centre of the circle"""
    half: Literal["upper", "lower"] | None = None
    """the half above or below the centre alone"""
    arc_deg: Annotated[float, at.Gt(0.0), at.Lt(180.0)] | None = None
    """angle of the side arc about the apex of a half (default: none, all is rim)"""

    needs = (("arc_deg", "half"),)

    def region(self) -> Region:
        """The shape."""
        if self.half is None:
            return Region(circle(self.radius_mm, self.centre_mm, name="rim"))
        arc = None if self.arc_deg is None else float(np.deg2rad(self.arc_deg))
        return Region(half_disc(self.radius_mm, self.centre_mm, self.half, arc))


class FineTable(Record):
    """Where a mesh is finer."""

    size_mm: ElementSize
    """edge length of the triangles there"""
    edges: Names | None = None
    """sides of the outline along which the mesh is finer"""
    at_mm: Annotated[list[Pair], at.MinLen(1)] | None = None
    """points of a polyline along which the mesh is finer"""
    growth: Fraction = 0.15
    """growth of the edge length per distance"""

    exclusive = needed = (("edges", "at_mm"),)

    def refinement(self, key: str, region: Region) -> Refinement:
        """Along the polyline, or along sides of the outline by points four edges apart."""
        points = np.array(self.at_mm or ())
        if self.edges is not None:
            sides = [pair for loop in region.loops for pair in zip(loop.names, loop.segments, strict=True)]
            for name in listed(self.edges):
                require_known(f"{key}.edges", name, sorted({name for name, _ in sides}))
            counts = [
                (side, math.ceil(min(side.length / (4.0 * self.size_mm), MAX_EDGES)) + 1)
                for name, side in sides
                if name in listed(self.edges)
            ]
            points = np.vstack([side.point(np.linspace(0.0, 1.0, n)) for side, n in counts])
        return Refinement(points, self.size_mm, self.growth)


class MaterialTable(Record):
    """Isotropic linear elastic material."""

    young_MPa: Positive = 210e3
    """Young's modulus"""
    poisson: Annotated[float, at.Gt(-1.0), at.Le(0.5)] = 0.3
    """Poisson's ratio; 0.5 in plane stress only"""
    density_kg_m3: Positive | None = None
    """density, for gravity_m_s2"""
    expansion_per_K: float | None = None
    """thermal strain per kelvin, for temperature_K"""

    def elastic(self, hypothesis: HypothesisName) -> Elastic:
        """Material under a hypothesis on the direction out of the plane."""
        density = None if self.density_kg_m3 is None else T_PER_MM3 * self.density_kg_m3
        return Elastic(
            self.young_MPa, self.poisson, HYPOTHESES[hypothesis], density=density, expansion=self.expansion_per_K
        )


class ShapeTable(Record):
    """A body's shape, mesh and elements."""

    name: Annotated[str, at.MinLen(1), at.MaxLen(60)]
    """name of the body, used by the other tables"""
    rectangle: RectangleTable | None = None
    """shape: a rectangle"""
    disc: DiscTable | None = None
    """shape: a disc or a half disc"""
    outline: OutlineTable | None = None
    """shape: lines and arcs with points, path or circle, and holes, as in outline files"""
    file: str | None = None
    """shape from a file: outline .toml, .csv, .dxf; or mesh .msh, .inp, .vtu and others"""
    unit: LengthUnit | None = None
    """unit of the file's coordinates (default: that in the file, or mm)"""
    layers: list[str] = Field([])
    """layers of a .dxf file, shown or not (default: what is visible)"""
    cells: Names | None = None
    """cell sets of a mesh that form this body (default: all cells)"""
    shift_mm: Pair = (0.0, 0.0)
    """shift of the shape, after its rotation"""
    rotation_deg: float = 0.0
    """rotation of the shape about its origin, counter-clockwise"""
    method: MethodName = "fem"
    """fem: Lagrange triangles; vem: virtual elements on polygons (a file's cells as they are); vem-triangles:
    virtual elements on the triangles"""
    order: ElementOrder = 1
    """order of the elements"""
    stabilisation: Stabilisation = "default"
    halved_side: str | None = None
    """side of the outline whose edges are halved; its triangles become virtual quadrilaterals"""
    size_mm: ElementSize | None = None
    """edge length of the triangles (default: a twentieth of the shape's diagonal)"""
    fine: list[FineTable] = Field([])
    """regions with smaller triangles"""

    exclusive = needed = (("rectangle", "disc", "outline", "file"),)


class BodyTable(MaterialTable, ShapeTable):
    """An elastic body: its shape, mesh, elements and material."""

    materials: dict[str, MaterialTable] = Field({})
    """materials by the names of cell sets of the mesh"""

    needs: ClassVar[tuple[tuple[str, str], ...]] = (
        ("unit", "file"),
        ("layers", "file"),
        ("cells", "file"),
        ("materials", "file"),
    )

    def material(self, hypothesis: HypothesisName) -> Elastic | dict[str, Elastic]:
        """Material under a hypothesis, by cell set where there are several."""
        by_cells = {cells: material.elastic(hypothesis) for cells, material in self.materials.items()}
        return by_cells or self.elastic(hypothesis)

    def element(self, mesh: PolyMesh) -> Element | dict[str, Element]:
        """Elements on a mesh, by cell set where halved edges or inserted nodes made polygons of some triangles."""
        virtual = Virtual(self.order, TraceStabilisation() if self.stabilisation == "trace" else None)
        lagrange = Lagrange(self.order)
        mixed = (mesh.cell_sizes > 3).any()
        finite = {"triangles": lagrange, "polygons": virtual} if mixed else lagrange
        return finite if self.method == "fem" else virtual


class EdgesTable(Record):
    """A part of a body's boundary: the edges that all the given keys allow."""

    body: str
    """name of the body"""
    edges: Names | None = None
    """names of edge sets"""
    at_x_mm: float | None = None
    """boundary edges on the line of this x"""
    at_y_mm: float | None = None
    """boundary edges on the line of this y"""
    box_mm: Box | None = None
    """boundary edges inside x_min, y_min, x_max, y_max"""

    needed = (("edges", "at_x_mm", "at_y_mm", "box_mm"),)

    def edges_on(self, mesh: PolyMesh, key: str) -> IntArray:
        """Return the edges on a mesh, pairs of points (n, 2)."""
        with located(f"{key}{'' if self.edges is None else '.edges'}: "):
            return mesh.edge_set(self.edges, within=self.box_mm, at_x=self.at_x_mm, at_y=self.at_y_mm)

    def where(self, key: str) -> Where:
        """Position for supports and loads: the edges have the name of their table."""
        return key


class PointTable(Record):
    """A point of a body's mesh, with order 2 also the middle of an edge."""

    body: str
    """name of the body"""
    point_mm: Pair
    """a point of the mesh instead of edges"""

    def where(self, key: str) -> Where:  # noqa: ARG002 (see `EdgesTable.where`)
        """The point."""
        return self.point_mm


class _Support(Record):
    """Held components of what supports hold."""

    hold: Literal["x", "y", "xy"] = "xy"
    """fixed components"""
    x_mm: float | None = None
    """prescribed displacement in x, which it then holds (default: 0 where x is fixed)"""
    y_mm: float | None = None
    """prescribed displacement in y, which it then holds (default: 0 where y is fixed)"""

    def support(self, where: Where) -> PrescribedDisplacement:
        """As problems take it."""
        given = {"x": self.x_mm, "y": self.y_mm}
        x, y = (0.0 if axis in self.hold and value is None else value for axis, value in given.items())
        return PrescribedDisplacement(where, x, y)


class EdgesSupport(_Support, EdgesTable):
    """A support of edges, with or without a prescribed displacement."""


class PointSupport(_Support, PointTable):
    """A support of a point."""


class EdgesSpring(EdgesTable):
    """An elastic support of edges, whose other end is fixed, or moves with the body's supports."""

    x_MPa_mm: NotNegative = 0.0
    """stiffness of edges in x, pressure per displacement"""
    y_MPa_mm: NotNegative = 0.0
    """the same in y"""

    def support(self, where: Where) -> Spring:
        """See `EdgesSupport.support`."""
        return Spring(where, self.x_MPa_mm, self.y_MPa_mm)


class PointSpring(PointTable):
    """An elastic support of a point."""

    x_N_mm: NotNegative = 0.0
    """stiffness of a point in x, force per displacement"""
    y_N_mm: NotNegative = 0.0
    """the same in y"""

    def support(self, where: Where) -> Spring:
        """See `EdgesSupport.support`."""
        return Spring(where, self.x_N_mm, self.y_N_mm)


class PressureLoad(EdgesTable):
    """A pressure on edges."""

    pressure_MPa: float
    """pressure on edges, positive into the body"""

    def load(self, where: Any, area: float) -> AppliedLoad:  # noqa: ARG002 (of forces)
        """As problems take it.

        - `where`: name of its edges, or the point.
        - `area`: of its edges.
        """
        return Pressure(where, self.pressure_MPa)


class TractionLoad(EdgesTable):
    """A force per area of edges."""

    traction_MPa: Pair
    """force per area of edges, x and y"""

    def load(self, where: Any, area: float) -> AppliedLoad:  # noqa: ARG002
        """See `PressureLoad.load`."""
        return Traction(where, self.traction_MPa)


class EdgesForce(EdgesTable):
    """A force that is spread evenly over edges."""

    force_N: Pair
    """force at a point, or spread evenly over edges"""

    def load(self, where: Any, area: float) -> AppliedLoad:
        """See `PressureLoad.load`."""
        return Traction(where, (self.force_N[0] / area, self.force_N[1] / area))


class NodeForce(PointTable):
    """A force at a point."""

    force_N: Pair
    """force at a point, or spread evenly over edges"""

    def load(self, where: Any, area: float) -> AppliedLoad:  # noqa: ARG002
        """See `PressureLoad.load`."""
        return PointForce(where, self.force_N)


class CellsTable(Record):
    """Cells of a body."""

    body: str
    """name of the body"""
    cells: str | None = None
    """cell set for body_force_N_mm3 and temperature_K (default: the whole body)"""

    def where(self, key: str) -> str | None:  # noqa: ARG002 (see `EdgesTable.where`)
        """The cells."""
        return self.cells


class VolumeForce(CellsTable):
    """A force per volume."""

    body_force_N_mm3: Pair
    """force per volume"""

    def load(self, where: Any, area: float) -> AppliedLoad:  # noqa: ARG002
        """See `PressureLoad.load`."""
        return BodyForce(self.body_force_N_mm3, where)


class TemperatureRise(CellsTable):
    """A rise of the temperature."""

    temperature_K: float
    """rise of the temperature"""

    def load(self, where: Any, area: float) -> AppliedLoad:  # noqa: ARG002
        """See `PressureLoad.load`."""
        return TemperatureChange(self.temperature_K, where)


class Weight(Record):
    """The weight of a whole body."""

    body: str
    """name of the body"""
    gravity_m_s2: Pair
    """acceleration of the weight of the whole body: [0.0, -9.81]"""

    def where(self, key: str) -> None:
        """The whole body."""

    def load(self, where: Any, area: float) -> AppliedLoad:  # noqa: ARG002
        """See `PressureLoad.load`."""
        x, y = self.gravity_m_s2
        return Gravity((MM_PER_M * x, MM_PER_M * y))


# --- Meshes of the bodies of a case file, and positions on their boundaries.


OF_MESHES, OF_OUTLINES = ("cells", "materials"), ("size_mm", "fine", "halved_side", "layers")
"""Keys that a shape has no use for where it is the other one of both."""
DIAGONAL_PER_SIZE = 20.0  # diagonal of a shape per default edge length of its triangles


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
            return loop if names is None else loop.part([name for name in listed(names) if name in loop.names])
        except InputError:
            return loop


def body_shape(body: BodyTable, key: str, notices: list[str]) -> BodyShape:
    """Mesh of a body in mm, in its initial position.

    It is an `InputError` if there is not one shape, a key does not go with it, or the shape or the mesh is wrong.
    - `key`: how messages call its table.
    - `notices`: receives a notice for each repair.
    """
    placement = Placement(np.deg2rad(body.rotation_deg), body.shift_mm)
    is_mesh = body.file is not None and Path(body.file).suffix.lower() not in ENDINGS
    for name in OF_OUTLINES if is_mesh else OF_MESHES:
        if value := getattr(body, name):
            what = "an outline" if is_mesh else "a mesh file"
            raise InputError(f"{key}.{name} = {short(value)} of {body.file}", f"{name} of {what}", f"leave {name} out")
    if is_mesh:
        return BodyShape(_mesh_of_file(body, key, notices).placed(placement))
    region = _region(body, key, notices)
    diagonal = float(norms(np.ptp(region.outer.bounds(), axis=0)))
    fine = [table.refinement(f"{key}.fine[{n}]", region) for n, table in enumerate(body.fine, 1)]
    size = body.size_mm or diagonal / DIAGONAL_PER_SIZE
    mesh = triangulate(region, size=size, refinements=fine)
    mesh = dual(mesh) if body.method == "vem" else mesh
    if body.halved_side is not None:
        require_known(f"{key}.halved_side", body.halved_side, sorted(mesh.edge_sets))
        mesh = edges_halved(mesh, body.halved_side)
    return BodyShape(mesh.placed(placement), region.transformed(placement).loops)


def _region(body: BodyTable, key: str, notices: list[str]) -> Region:
    """Region in mm."""
    if body.file is not None:
        drawn = read_section(body.file, unit=body.unit, layers=body.layers)
        if len(drawn.section.regions) != 1:
            raise InputError(
                f"{key}.file = {body.file!r} with {len(drawn.section.regions)} parts", "one part", "make each a body"
            )
        notices += [f"{body.name}: {notice}" for notice in drawn.notices]
        outer, *holes = [_in_mm(loop, UNITS_MM[drawn.unit]) for loop in drawn.section.regions[0].loops]
        return Region(outer, tuple(holes))
    if body.outline is not None:
        return body.outline.region(f"{key}.outline: ", notices)
    return (body.rectangle or body.disc).region()  # type: ignore[union-attr]  # one of all is written


def _mesh_of_file(body: BodyTable, key: str, notices: list[str]) -> PolyMesh:
    # bodies that touch must stay apart
    read = read_mesh(str(body.file), merge_points=body.cells is None)
    repairs, mesh = list(read.notices), read.mesh
    if body.cells is not None:
        wanted = listed(body.cells)
        what = "cell sets of the file"
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
    in_mm, curves = replace(mesh, points=mesh.points * factor, curves=None), mesh.curves
    return in_mm if curves is None else with_arcs(in_mm, curves.pairs, curves.points([0.5])[:, 0] * factor)


def _in_mm(outline: Outline, factor: float) -> Outline:
    """Outline times the length of its unit in mm."""

    def scaled(x: float, y: float) -> tuple[float, float]:
        return factor * x, factor * y

    segments = [
        replace(side, start=scaled(*side.start), end=scaled(*side.end), centre=scaled(*side.centre))
        if isinstance(side, Arc)
        else Line(scaled(*side.start), scaled(*side.end))
        for side in outline.segments
    ]
    return Outline.from_segments(segments, outline.names)


def listed(names: str | Sequence[str] | None) -> list[str]:
    """Names of which one, or a list, or none is given."""
    return [names] if isinstance(names, str) else list(names or ())
