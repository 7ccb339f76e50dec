"""Inputs of the general case as tables, and from them the meshes of its bodies and positions on their boundaries."""

# ruff: noqa: N815 (units in names)
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from flangeway.cases.case import Case
from flangeway.contact import (
    AugmentedLagrange,
    Barrier,
    Enforcement,
    Multiplier,
    NodeToNode,
    NodeToSegment,
    Penalty,
    SegmentToSegment,
)
from flangeway.contact.node_to_segment import OPEN_SLACK
from flangeway.errors import InputError, located
from flangeway.formats import read_mesh, read_section
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.formats.mesh_repair import with_arcs
from flangeway.formats.outline_files import ENDINGS, outline_region
from flangeway.geometry import Arc, Contour, Line, Outline, Placement, circle, half_disc, rectangle
from flangeway.geometry.arrays import IntArray, norms
from flangeway.geometry.region import Region
from flangeway.materials import Elastic, Hypothesis
from flangeway.mesh import PolyMesh, Refinement, dual, edges_halved, triangulate
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

# --- Inputs of the general case: tables of bodies, supports, loads, motions, contacts, steps.


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


class SegmentPairing(Record):
    """Gaps averaged over the secondary surface."""

    kind: Literal["segment-to-segment"]
    """gaps averaged over the secondary surface"""
    weighting: Literal["standard", "dual"] = "standard"
    """weights of the gap: hat functions, or their biorthogonal ones"""

    @property
    def pairing(self) -> SegmentToSegment:
        """As contacts take it."""
        return SegmentToSegment(weighting=self.weighting)


class NodePairing(Record):
    """Gaps of the secondary nodes to the primary edges."""

    kind: Literal["node-to-segment"]
    """gaps of the secondary nodes to the primary edges"""
    slack: float = Field(NodeToSegment.slack, gt=0.0, le=OPEN_SLACK)
    """how far beyond its edge, in parts of the edge, a node stays paired with it"""

    @property
    def pairing(self) -> NodeToSegment:
        """As contacts take it."""
        return NodeToSegment(slack=self.slack)


class MatchedPairing(Record):
    """Gaps of nodes to nodes; the boundaries get each other's nodes."""

    kind: Literal["node-to-node"]
    """gaps of nodes to nodes: the boundaries get each other's nodes, for small displacements"""

    @property
    def pairing(self) -> NodeToNode:
        """As contacts take it."""
        return NodeToNode()


class MultiplierLaw(Record):
    """Forces as unknowns."""

    kind: Literal["multiplier"]
    """forces as unknowns, which leave no penetration"""

    def law(self, penalty: float) -> Enforcement:  # noqa: ARG002 (others need one)
        """As contacts take it; a penalty that is left out is the suggested one."""
        return Multiplier()


class PenaltyLaw(Record):
    """Pressure in proportion to the penetration."""

    kind: Literal["penalty"]
    """pressure in proportion to the penetration"""
    penalty_MPa_mm: Positive | None = None
    """pressure per penetration (default: from stiffness and edges of the bodies)"""
    nodal_penalty_N_per_mm: Positive | None = None
    """force per penetration at a node of node-to-segment, instead of penalty_MPa_mm"""

    exclusive = (("penalty_MPa_mm", "nodal_penalty_N_per_mm"),)

    def law(self, penalty: float) -> Enforcement:
        """See `MultiplierLaw.law`."""
        return Penalty(*_penalty(self, penalty))


class AugmentedLaw(Record):
    """A penalty about forces that are corrected."""

    kind: Literal["augmented-lagrange"]
    """a penalty about forces that are corrected until the penetration is tolerated"""
    penalty_MPa_mm: Positive | None = None
    """pressure per penetration (default: from stiffness and edges of the bodies)"""
    nodal_penalty_N_per_mm: Positive | None = None
    """force per penetration at a node of node-to-segment, instead of penalty_MPa_mm"""
    penetration_mm: Positive = 1e-5
    """tolerated penetration"""

    exclusive = PenaltyLaw.exclusive

    def law(self, penalty: float) -> Enforcement:
        """See `MultiplierLaw.law`."""
        return AugmentedLagrange(*_penalty(self, penalty), self.penetration_mm)


class BarrierLaw(Record):
    """Forces of a logarithmic barrier."""

    kind: Literal["barrier"]
    """forces of a logarithmic barrier, which keeps the surfaces apart"""
    barrier_N_per_mm: Positive
    """pressure times gap: a thousandth of the expected pressure times the approach to begin with"""
    reach_mm: Positive
    """gap from which there is no pressure: the approach to begin with"""

    def law(self, penalty: float) -> Enforcement:  # noqa: ARG002 (others need one)
        """See `MultiplierLaw.law`."""
        return Barrier(self.barrier_N_per_mm, self.reach_mm)


def _penalty(law: PenaltyLaw | AugmentedLaw, suggested: float) -> tuple[float, Literal["node", "length"]]:
    """Value of a penalty, and what it is per."""
    if law.nodal_penalty_N_per_mm is not None:
        return law.nodal_penalty_N_per_mm, "node"
    return law.penalty_MPa_mm or suggested, "length"


Pairing = Annotated[
    SegmentPairing | NodePairing | MatchedPairing,
    Field(
        default_factory=lambda: SegmentPairing(kind="segment-to-segment"),
        discriminator="kind",
        description="contact discretisation",
    ),
]
Law = Annotated[
    AugmentedLaw | MultiplierLaw | PenaltyLaw | BarrierLaw,
    Field(
        default_factory=lambda: AugmentedLaw(kind="augmented-lagrange"),
        discriminator="kind",
        description="constraint enforcement",
    ),
]


class RectangleTable(Record):
    """A rectangle with the sides ``bottom``, ``right``, ``top``, ``left``."""

    width_mm: Positive
    """extent in x"""
    height_mm: Positive
    """extent in y"""
    centre_mm: Pair = (0.0, 0.0)
    """its middle"""


class DiscTable(Record):
    """A disc with the edge set ``rim``; a half disc has its straight side as ``cut``, and an ``arc`` about its apex."""

    radius_mm: Positive
    """radius"""
    centre_mm: Pair = (0.0, 0.0)
    """centre of the circle"""
    half: Literal["upper", "lower"] | None = None
    """the half above or below the centre alone"""
    arc_deg: float | None = Field(default=None, gt=0.0, lt=180.0)
    """angle of the side arc about the apex of a half (default: none, all is rim)"""


class FineTable(Record):
    """Where a mesh is finer."""

    size_mm: ElementSize
    """edge length of the triangles there"""
    edges: str | list[str] | None = None
    """sides of the outline along which the mesh is finer"""
    at_mm: list[Pair] | None = None
    """points of a polyline along which the mesh is finer"""
    growth: Fraction = 0.15
    """growth of the edge length per distance"""


class MaterialTable(Record):
    """Isotropic linear elastic material."""

    young_MPa: Positive = 210e3
    """Young's modulus"""
    poisson: float = Field(default=0.3, gt=-1.0, le=0.5)
    """Poisson's ratio; 0.5 in plane stress only"""
    density_kg_m3: Positive | None = None
    """density, for gravity_m_s2"""
    expansion_per_K: float | None = None
    """thermal strain per kelvin, for temperature_K"""


def elastic(table: MaterialTable, hypothesis: HypothesisName) -> Elastic:
    """Material of a table under a hypothesis on the direction out of the plane."""
    density = None if table.density_kg_m3 is None else T_PER_MM3 * table.density_kg_m3
    return Elastic(
        table.young_MPa, table.poisson, HYPOTHESES[hypothesis], density=density, expansion=table.expansion_per_K
    )


class ShapeTable(Record):
    """A body's shape, mesh and elements."""

    name: str = Field(min_length=1, max_length=60)
    """name of the body, used by the other tables"""
    rectangle: RectangleTable | None = None
    """shape: a rectangle"""
    disc: DiscTable | None = None
    """shape: a disc or a half disc"""
    outline: dict[str, Any] | None = None
    """shape: lines and arcs with points, path or circle, and holes, as in outline files"""
    file: str | None = None
    """shape from a file: outline .toml, .csv, .dxf; or mesh .msh, .inp, .vtu and others"""
    unit: LengthUnit | None = None
    """unit of the file's coordinates (default: that in the file, or mm)"""
    layers: list[str] = Field([])
    """layers of a .dxf file, shown or not (default: what is visible)"""
    cells: str | list[str] | None = None
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


class BodyTable(MaterialTable, ShapeTable):
    """An elastic body: its shape, mesh, elements and material."""

    materials: dict[str, MaterialTable] = Field({})
    """materials by the names of cell sets of the mesh"""


class PlaceTable(Record):
    """A part of a body's boundary: the edges that all the given keys allow, or a point."""

    body: str
    """name of the body"""
    point_mm: Pair | None = None
    """a point of the mesh instead of edges"""
    edges: str | list[str] | None = None
    """names of edge sets"""
    at_x_mm: float | None = None
    """boundary edges on the line of this x"""
    at_y_mm: float | None = None
    """boundary edges on the line of this y"""
    box_mm: Box | None = None
    """boundary edges inside x_min, y_min, x_max, y_max"""


class SupportTable(PlaceTable):
    """A support, with or without a prescribed displacement."""

    hold: Literal["x", "y", "xy"] = "xy"
    """fixed components"""
    x_mm: float = 0.0
    """prescribed displacement of a fixed x component"""
    y_mm: float = 0.0
    """prescribed displacement of a fixed y component"""


class SpringTable(PlaceTable):
    """An elastic support, whose other end is fixed, or moves with the body's supports."""

    x_MPa_mm: NotNegative | None = None
    """stiffness of edges in x, pressure per displacement"""
    y_MPa_mm: NotNegative | None = None
    """the same in y"""
    x_N_mm: NotNegative | None = None
    """stiffness of a point in x, force per displacement"""
    y_N_mm: NotNegative | None = None
    """the same in y"""


class LoadTable(PlaceTable):
    """A load: one of the last seven keys."""

    cells: str | None = None
    """cell set for body_force_N_mm3 and temperature_K (default: the whole body)"""
    pressure_MPa: float | None = None
    """pressure on edges, positive into the body"""
    traction_MPa: Pair | None = None
    """force per area of edges, x and y"""
    force_N: Pair | None = None
    """force at a point, or spread evenly over edges"""
    body_force_N_mm3: Pair | None = None
    """force per volume"""
    gravity_m_s2: Pair | None = None
    """acceleration of the weight of the whole body: [0.0, -9.81]"""
    temperature_K: float | None = None
    """rise of the temperature"""


class MotionTable(Record):
    """Rigid motion of all supports of a body, or a force on them."""

    body: str
    """name of the body"""
    leg: int = Field(default=1, ge=1, le=100)
    """leg of the path: motions of 2 follow those of 1; forces act from 1 on"""
    shift_mm: Pair = (0.0, 0.0)
    """shift of the body's supports"""
    rotation_deg: float = Field(default=0.0, ge=-90.0, le=90.0)
    """rotation of the supports, counter-clockwise"""
    centre_mm: Pair = (0.0, 0.0)
    """centre of this rotation"""
    push_N: Pair | None = None
    """force on the supports: they move along it until the contact carries it"""


class ContactTable(Record):
    """A pair of surfaces that may touch; the secondary surface is better the finer one."""

    secondary: str
    """body with the secondary surface, whose nodes or edges carry the constraints"""
    secondary_edges: str | list[str] | None = None
    """its edge sets (default: all free edges)"""
    secondary_box_mm: Box | None = None
    """only its edges inside x_min, y_min, x_max, y_max"""
    primary: str
    """body with the primary surface"""
    primary_edges: str | list[str] | None = None
    """its edge sets (default: all free edges)"""
    primary_box_mm: Box | None = None
    """only its edges inside x_min, y_min, x_max, y_max"""
    curved: bool | None = None
    """whether gaps are measured between the drawn arcs, not between straight edges of the mesh (default: yes for
    bodies with an outline)"""
    interference: bool = False
    """whether an overlap before any motion is intended: no warning then"""
    pairing: Pairing
    enforcement: Law
    friction: float = Field(default=0.0, ge=0.0, le=10.0)
    """coefficient of Coulomb's friction"""


class StepsTable(Record):
    """How loads and motions are applied."""

    number: int | None = Field(default=None, ge=1, le=1000)
    """number of equal steps of each leg; a step that does not converge is halved (default: 1, and with friction as
    many as the error of the steps needs)"""


class BodiesInputs(Case):
    """Bodies in the plane with supports, loads, motions and contacts; common axes, x to the right and y up."""

    thickness_mm: Positive = 1.0
    """length of all bodies out of the plane"""
    hypothesis: HypothesisName = "plane-strain"
    """no strain, or no stress, out of the plane; or bodies of revolution about y, x the radius"""
    bodies: list[BodyTable]
    """the bodies: shape, mesh, elements and material of each"""
    supports: list[SupportTable] = Field([])
    """supports, with or without a prescribed displacement"""
    springs: list[SpringTable] = Field([])
    """elastic supports of edges and points"""
    loads: list[LoadTable] = Field([])
    """pressures, tractions, forces, weight and changes of temperature"""
    motions: list[MotionTable] = Field([])
    """rigid motions of bodies in contact, or forces on supports"""
    contacts: list[ContactTable] = Field([])
    """pairs of surfaces that may touch"""
    steps: StepsTable = Field(default_factory=lambda: StepsTable(number=None))
    """how loads and motions are applied"""


# --- Meshes of the bodies of a case file, and positions on their boundaries.


SHAPES = ("rectangle", "disc", "outline", "file")
DIAGONAL_PER_SIZE = 20.0  # diagonal of a shape per default edge length of its triangles
MAX_EDGES = 100_000  # along a side of an outline: more is a mistake in a size


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
    for name in ("cells", "materials"):
        if value := getattr(body, name):
            raise InputError(f"{key}.{name} = {value!r} of an outline", "cell sets of a mesh file", f"leave {name} out")
    region = _region(body, key, notices)
    diagonal = float(norms(np.ptp(region.outer.bounds(), axis=0)))
    fine = [_refinement(table, f"{key}.fine[{n}]", region) for n, table in enumerate(body.fine, 1)]
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
    for name in ("unit", "layers"):
        if value := getattr(body, name):
            raise InputError(f"{key}.{name} = {value!r} without file", f"{name} of a file", "leave it out, and give mm")
    if body.rectangle is not None:
        shape = body.rectangle
        return Region(rectangle(shape.width_mm, shape.height_mm, shape.centre_mm))
    if body.disc is not None:
        disc = body.disc
        if disc.half is None:
            return Region(circle(disc.radius_mm, disc.centre_mm, name="rim"))
        arc = None if disc.arc_deg is None else float(np.deg2rad(disc.arc_deg))
        return Region(half_disc(disc.radius_mm, disc.centre_mm, disc.half, arc))
    return outline_region(body.outline or {}, f"{key}.outline: ", notices)


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
    wanted = listed(fine.edges)
    for name in wanted:
        require_known(f"{key}.edges", name, sorted({name for name, _ in sides}))
    chosen = [side for name, side in sides if name in wanted]
    longest = max(side.length for side in chosen)
    if longest > MAX_EDGES * fine.size_mm:
        raise InputError(
            f"{key}.size_mm = {fine.size_mm:g} along {longest:g} mm",
            f"at most {MAX_EDGES} edges along a side",
            "take a larger size",
        )
    points = [
        side.point(np.linspace(0.0, 1.0, int(np.ceil(side.length / (4.0 * fine.size_mm))) + 1)) for side in chosen
    ]
    return Refinement(np.vstack(points), fine.size_mm, fine.growth)


def _mesh_of_file(body: BodyTable, key: str, notices: list[str]) -> PolyMesh:
    for name in ("size_mm", "fine", "halved_side", "layers"):
        if getattr(body, name) not in (None, []):
            raise InputError(f"{key}.{name} with the mesh {body.file}", "the file's mesh as it is", f"leave {name} out")
    # bodies that touch must stay apart
    read = read_mesh(str(body.file), merge_points=body.cells is None)
    repairs, mesh = list(read.notices), read.mesh
    if body.cells is not None:
        wanted = listed(body.cells)
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


Where = str | tuple[float, float]

ON_LINE = 1e-6  # distance relative to the size of the mesh up to which a point lies on a line or in a box


def keys_of_place(table: PlaceTable) -> list[str]:
    """Keys of a table that say where, but for a point."""
    return [name for name in ("edges", "at_x_mm", "at_y_mm", "box_mm") if getattr(table, name) is not None]


def edges_at(mesh: PolyMesh, table: PlaceTable, key: str) -> IntArray:
    """Boundary edges at the position of a table, pairs of points (n, 2)."""
    with located(f"{key}{'' if table.edges is None else '.edges'}: "):
        return mesh.edge_set(table.edges, within=table.box_mm, at_x=table.at_x_mm, at_y=table.at_y_mm)


def point_at(mesh: PolyMesh, order: int, body: str, point: tuple[float, float], key: str) -> tuple[float, float]:
    """Exact position of a point of a mesh, for order 2 also of the middle of an edge; an error names the nearest."""
    spots = mesh.points if order == 1 else np.vstack((mesh.points, mesh.points[mesh.edges].mean(axis=1)))
    apart = norms(spots - point)
    nearest = spots[apart.argmin()]
    if apart.min() > ON_LINE * float(norms(np.ptp(mesh.points, axis=0))):
        raise InputError(
            f"{key}.point_mm = [{point[0]:g}, {point[1]:g}]",
            f"a point of the mesh of {body!r}; the nearest is [{nearest[0]:.9g}, {nearest[1]:.9g}]",
            "give a corner of the outline or a point of the mesh",
        )
    return float(nearest[0]), float(nearest[1])
