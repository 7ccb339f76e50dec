"""Tables of the general case file: bodies, supports, loads, motions, contacts, steps."""

from typing import Any, Literal

from pydantic import Field

from flangeway.cases.case import Box, Pair, Table
from flangeway.materials import Elastic

HypothesisName = Literal["plane-strain", "plane-stress"]


class RectangleTable(Table):
    """A rectangle with the sides ``bottom``, ``right``, ``top``, ``left``."""

    width_mm: float = Field(gt=0.0, description="extent in x")
    height_mm: float = Field(gt=0.0, description="extent in y")
    centre_mm: Pair = Field((0.0, 0.0), description="its middle")


class DiscTable(Table):
    """A disc with the edge set ``rim``; a half disc has its straight side as ``cut``."""

    radius_mm: float = Field(gt=0.0, description="radius")
    centre_mm: Pair = Field((0.0, 0.0), description="centre of the circle")
    half: Literal["upper", "lower"] | None = Field(None, description="the half above or below the centre alone")


class FineTable(Table):
    """Where a mesh is finer."""

    size_mm: float = Field(ge=1e-6, description="edge length of the triangles there")
    edges: str | list[str] | None = Field(None, description="sides of the outline along which they are small")
    at_mm: list[Pair] | None = Field(None, description="points of a polyline along which they are small")
    growth: float = Field(0.15, gt=0.0, le=1.0, description="growth of the edges per distance")


class MaterialTable(Table):
    """Isotropic linear elastic material."""

    young_MPa: float = Field(210e3, gt=0.0, description="Young's modulus")  # noqa: N815 (the unit megapascal)
    poisson: float = Field(0.3, gt=-1.0, le=0.5, description="Poisson's ratio; 0.5 in plane stress only")


def elastic(table: "MaterialTable | BodyTable", hypothesis: HypothesisName) -> Elastic:
    """Material of a table under a hypothesis on the direction out of the plane."""
    return Elastic(table.young_MPa, table.poisson, "plane_strain" if hypothesis == "plane-strain" else "plane_stress")


class BodyTable(Table):
    """An elastic body: its shape, mesh, elements and material."""

    name: str = Field(min_length=1, max_length=60, description="name of the body, by which the other tables know it")
    rectangle: RectangleTable | None = Field(None, description="shape: a rectangle")
    disc: DiscTable | None = Field(None, description="shape: a disc or a half disc")
    outline: dict[str, Any] | None = Field(
        None, description="shape: lines and arcs with points, path or circle, and holes, as in outline files"
    )
    file: str | None = Field(
        None, description="shape from a file: outline .toml, .csv, .dxf; or mesh .msh, .inp, .vtu and others"
    )
    unit: Literal["mm", "cm", "m", "in", "ft"] | None = Field(
        None, description="unit of the file's coordinates; that in the file, or mm, if left out"
    )
    cells: str | list[str] | None = Field(
        None, description="cell sets of a mesh that are this body; all cells if left out"
    )
    shift_mm: Pair = Field((0.0, 0.0), description="shift of the shape, after its rotation")
    rotation_deg: float = Field(0.0, description="rotation of the shape about its origin, counter-clockwise")
    method: Literal["fem", "vem"] = Field(
        "fem", description="fem: Lagrange triangles; vem: virtual elements on polygons (a file's cells as they are)"
    )
    order: int = Field(1, ge=1, le=2, description="order of the elements")
    size_mm: float | None = Field(
        None, ge=1e-6, description="edge length of the triangles; a twentieth of the shape's diagonal if left out"
    )
    fine: list[FineTable] = Field([], description="places with smaller triangles")
    young_MPa: float = Field(210e3, gt=0.0, description="Young's modulus")  # noqa: N815
    poisson: float = Field(0.3, gt=-1.0, le=0.5, description="Poisson's ratio; 0.5 in plane stress only")
    materials: dict[str, MaterialTable] = Field({}, description="materials by the cell sets of a mesh, for several")


class PlaceTable(Table):
    """A part of a body's boundary: the edges that all the given keys allow, or a point."""

    body: str = Field(description="name of the body")
    edges: str | list[str] | None = Field(None, description="names of edge sets")
    at_x_mm: float | None = Field(None, description="boundary edges on the line of this x")
    at_y_mm: float | None = Field(None, description="boundary edges on the line of this y")
    box_mm: Box | None = Field(None, description="boundary edges inside x_min, y_min, x_max, y_max")


class SupportTable(PlaceTable):
    """What is held, or moved by a given displacement."""

    point_mm: Pair | None = Field(None, description="a point of the mesh instead of edges")
    hold: Literal["x", "y", "xy"] = Field("xy", description="components that are held")
    x_mm: float = Field(0.0, description="displacement of a held x component")
    y_mm: float = Field(0.0, description="displacement of a held y component")


class LoadTable(PlaceTable):
    """A load: one of the last five keys."""

    point_mm: Pair | None = Field(None, description="a point of the mesh, for force_N")
    cells: str | None = Field(None, description="cell set for body_force_N_mm3; the whole body if left out")
    pressure_MPa: float | None = Field(None, description="pressure on edges, positive into the body")  # noqa: N815
    traction_MPa: Pair | None = Field(None, description="force per area of edges, x and y")  # noqa: N815
    force_N: Pair | None = Field(None, description="force at a point, or spread evenly over edges")  # noqa: N815
    body_force_N_mm3: Pair | None = Field(None, description="force per volume")  # noqa: N815


class MotionTable(Table):
    """Rigid motion of all supports of a body, or a force behind them."""

    body: str = Field(description="name of the body")
    shift_mm: Pair = Field((0.0, 0.0), description="shift of the body's supports")
    rotation_deg: float = Field(0.0, ge=-90.0, le=90.0, description="rotation of the supports, counter-clockwise")
    centre_mm: Pair = Field((0.0, 0.0), description="centre of this rotation")
    push_N: Pair | None = Field(  # noqa: N815 (the unit newton)
        None, description="force behind the supports: they move along it until the contact bears it"
    )


class ContactTable(Table):
    """A pair of surfaces that may touch; the secondary one, better the finer, is kept off the primary one."""

    secondary: str = Field(description="name of the body whose nodes, or averages over whose edges, are kept off")
    secondary_edges: str | list[str] | None = Field(None, description="its edge sets; all that is free if left out")
    secondary_box_mm: Box | None = Field(None, description="its edges inside x_min, y_min, x_max, y_max only")
    primary: str = Field(description="name of the other body")
    primary_edges: str | list[str] | None = Field(None, description="its edge sets; all that is free if left out")
    primary_box_mm: Box | None = Field(None, description="its edges inside x_min, y_min, x_max, y_max only")
    curved: bool | None = Field(
        None,
        description="whether gaps are measured between the drawn arcs, not between the meshes' straight edges; if "
        "left out, yes for bodies whose outlines are given",
    )
    pairing: Literal["segment-to-segment", "node-to-segment"] = Field(
        "segment-to-segment", description="how the surfaces are compared"
    )
    enforcement: Literal["multiplier", "augmented-lagrange", "penalty"] = Field(
        "augmented-lagrange", description="how penetration is kept off"
    )
    penalty_MPa_mm: float | None = Field(  # noqa: N815 (the unit)
        None, gt=0.0, description="pressure per penetration; from stiffness and edges of the bodies if left out"
    )
    penetration_mm: float = Field(1e-5, gt=0.0, description="penetration that augmented-lagrange tolerates")


class StepsTable(Table):
    """How loads and motions are applied."""

    number: int = Field(1, ge=1, le=1000, description="equal steps; halved where one does not converge")
