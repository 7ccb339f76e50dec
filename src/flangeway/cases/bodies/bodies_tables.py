"""Inputs of the general case: tables of bodies, supports, loads, motions, contacts, steps."""

from typing import Annotated, Any, Literal

from pydantic import Field

from flangeway.cases.case import Box, Case, ElementOrder, ElementSize, Fraction, NotNegative, Pair, Positive, Table
from flangeway.contact import NodeToSegment
from flangeway.contact.node_to_segment import OVERHANG
from flangeway.materials import Elastic, Hypothesis

# ruff: noqa: N815 (units in names)

HypothesisName = Literal["plane-strain", "plane-stress", "axisymmetric"]

HYPOTHESES: dict[HypothesisName, Hypothesis] = {
    "plane-strain": "plane_strain",
    "plane-stress": "plane_stress",
    "axisymmetric": "axisymmetric",
}

T_PER_MM3 = 1e-12
"""Density of 1 kg/m3 in t/mm3, which goes with forces in N and lengths in mm."""

MethodName = Literal["fem", "vem", "vem-triangles"]
EnforcementName = Literal["multiplier", "augmented-lagrange", "penalty", "barrier"]
Stabilisation = Annotated[
    Literal["default", "trace"],
    Field(description="stabilisation of virtual elements; trace: half of the trace (Moherdaui 2021, 3.96)"),
]
PairingName = Literal["segment-to-segment", "node-to-segment", "node-to-node"]
Pairing = Annotated[
    PairingName,
    Field(
        description="contact discretisation; node-to-node gives the boundaries each other's nodes, for small "
        "displacements"
    ),
]
Weighting = Annotated[
    Literal["standard", "dual"],
    Field(description="weights of the gap of segment-to-segment: hat functions, or their biorthogonal ones"),
]
NodalPenalty = Annotated[
    Positive | None,
    Field(description="penalty of node-to-segment as force per penetration at a node, instead of penalty_MPa_mm"),
]
Slack = Annotated[
    float,
    Field(
        gt=0.0,
        le=OVERHANG,
        description="how far beyond its edge, in parts of the edge, node-to-segment keeps a node paired with it",
    ),
]


class RectangleTable(Table):
    """A rectangle with the sides ``bottom``, ``right``, ``top``, ``left``."""

    width_mm: Positive
    """extent in x"""
    height_mm: Positive
    """extent in y"""
    centre_mm: Pair = (0.0, 0.0)
    """its middle"""


class DiscTable(Table):
    """A disc with the edge set ``rim``; a half disc has its straight side as ``cut``, and an ``arc`` about its apex."""

    radius_mm: Positive
    """radius"""
    centre_mm: Pair = (0.0, 0.0)
    """centre of the circle"""
    half: Literal["upper", "lower"] | None = None
    """the half above or below the centre alone"""
    arc_deg: float | None = Field(None, gt=0.0, lt=180.0)
    """angle of the side arc about the apex of a half (default: none, all is rim)"""


class FineTable(Table):
    """Where a mesh is finer."""

    size_mm: ElementSize
    """edge length of the triangles there"""
    edges: str | list[str] | None = None
    """sides of the outline along which the mesh is finer"""
    at_mm: list[Pair] | None = None
    """points of a polyline along which the mesh is finer"""
    growth: Fraction = 0.15
    """growth of the edge length per distance"""


class MaterialTable(Table):
    """Isotropic linear elastic material."""

    young_MPa: Positive = 210e3
    """Young's modulus"""
    poisson: float = Field(0.3, gt=-1.0, le=0.5)
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


class ShapeTable(Table):
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
    unit: Literal["mm", "cm", "m", "in", "ft"] | None = None
    """unit of the file's coordinates (default: that in the file, or mm)"""
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


class PlaceTable(Table):
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


class MotionTable(Table):
    """Rigid motion of all supports of a body, or a force on them."""

    body: str
    """name of the body"""
    leg: int = Field(1, ge=1, le=100)
    """leg of the path: motions of 2 follow those of 1; forces act from 1 on"""
    shift_mm: Pair = (0.0, 0.0)
    """shift of the body's supports"""
    rotation_deg: float = Field(0.0, ge=-90.0, le=90.0)
    """rotation of the supports, counter-clockwise"""
    centre_mm: Pair = (0.0, 0.0)
    """centre of this rotation"""
    push_N: Pair | None = None
    """force on the supports: they move along it until the contact carries it"""


class ContactTable(Table):
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
    pairing: Pairing = "segment-to-segment"
    enforcement: EnforcementName = "augmented-lagrange"
    """constraint enforcement"""
    friction: float = Field(0.0, ge=0.0, le=10.0)
    """coefficient of Coulomb's friction"""
    barrier_N_per_mm: Positive | None = None
    """pressure times gap of a barrier, needed for it"""
    barrier_reach_mm: Positive | None = None
    """gap from which a barrier has no pressure"""
    penalty_MPa_mm: Positive | None = None
    """pressure per penetration (default: from stiffness and edges of the bodies)"""
    nodal_penalty_N_per_mm: NodalPenalty = None
    penetration_mm: Positive = 1e-5
    """tolerated penetration of augmented-lagrange"""
    weighting: Weighting = "standard"
    slack: Slack = NodeToSegment.slack


class StepsTable(Table):
    """How loads and motions are applied."""

    number: int | None = Field(None, ge=1, le=1000)
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
