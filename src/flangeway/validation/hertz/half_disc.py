"""A half disc that is fine along an arc about its apex (Moherdaui 2021, Figure 66)."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from flangeway.elements import Element, Lagrange, Virtual
from flangeway.elements.stabilisation import Stabilisation
from flangeway.errors import InputError
from flangeway.geometry import Arc, Line, Outline
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, dual, edges_halved, triangulate
from flangeway.problems import Body

Ints = NDArray[np.int32]
Cells = Literal["triangles", "polygons", "edge-refined"]
Method = Literal["fem", "vem"]
Side = Literal["below", "above"]

ARC, FLANKS, CUT = "arc", "flanks", "cut"
"""Edge sets of the mesh: the fine arc, the rest of the circle, and the straight side that is held."""


@dataclass(frozen=True)
class HalfDisc:
    """A half disc, held along its cut and fine along an arc about its apex.

    Parameters
    ----------
    size
        Edge length of the triangles along the arc; the dual polygons' edges have half of it.
    cells
        ``"triangles"``; their dual ``"polygons"``; or ``"edge-refined"``: triangles whose edges on the arc are halved,
        so that they are quadrilaterals with two aligned edges (Moherdaui 2021, Figure 68).
    method
        Elements of the triangles, ``"fem"`` or ``"vem"``. Polygons and quadrilaterals are virtual elements always.
    order
        Order of the elements.
    radius
        Radius of the disc.
    material
        Material.
    opening_rad
        Angle that the fine arc subtends, with the apex in its middle.
    body_size
        Edge length of the triangles far from the arc.
    growth
        Growth of the edges per distance from the arc.
    stabilisation
        Stabilisation of virtual elements; their own if left out.

    """

    size: float
    cells: Cells = "triangles"
    method: Method = "fem"
    order: int = 2
    radius: float = 4.0
    material: Elastic = field(default_factory=lambda: Elastic(20e3, 1.0 / 3.0))
    opening_rad: float = 2.0 * np.pi / 11.0
    body_size: float = 0.5
    growth: float = 0.13
    stabilisation: Stabilisation | None = None

    def __post_init__(self) -> None:
        for name, allowed in (("cells", get_args(Cells)), ("method", get_args(Method))):
            if getattr(self, name) not in allowed:
                raise InputError(
                    f"HalfDisc({name}={getattr(self, name)!r})", " or ".join(map(repr, allowed)), "choose one of these"
                )
        if not (np.isfinite(self.radius) and self.radius > 0.0):
            raise InputError(f"HalfDisc(radius={self.radius})", "a positive length", "give the disc's radius")
        if not 0.0 < self.opening_rad < np.pi:
            raise InputError(
                f"HalfDisc(opening_rad={self.opening_rad})", "an angle between 0 and pi", "leave it out for 2 pi / 11"
            )
        if not 0.0 < self.size <= self.body_size:
            raise InputError(
                f"HalfDisc(size={self.size}, body_size={self.body_size})", "0 < size <= body_size", "make size smaller"
            )

    @property
    def element(self) -> Element | Mapping[str, Element]:
        """Elements of the cells, by cell set where they differ."""
        virtual = Virtual(self.order, self.stabilisation)
        if self.cells == "polygons" or self.method == "vem":
            return virtual
        lagrange = Lagrange(self.order)
        return {"triangles": lagrange, "quadrilaterals": virtual} if self.cells == "edge-refined" else lagrange

    def outline(self, side: Side) -> Outline:
        """Outline with its apex in the origin and its disc below or above."""
        sign = 1.0 if side == "below" else -1.0
        centre = np.array([0.0, -self.radius])
        angles = np.pi / 2.0 + np.array([-np.pi, -self.opening_rad, self.opening_rad, np.pi]) / 2.0
        rim = sign * (centre + self.radius * np.column_stack((np.cos(angles), np.sin(angles))))
        points = [(float(x), float(y)) for x, y in rim]
        middle = (0.0, -sign * self.radius)
        arcs = [Arc(a, b, middle, counter_clockwise=True) for a, b in itertools.pairwise(points)]
        return Outline.from_segments([Line(points[-1], points[0]), *arcs], [CUT, FLANKS, ARC, FLANKS])

    def mesh(self, side: Side) -> PolyMesh:
        """Mesh with edge sets for cut, arc and flanks."""
        outline = self.outline(side)
        fine = outline.segments[outline.names.index(ARC)]
        spacing = min(4.0 * self.size, self.opening_rad * self.radius / 16.0)
        along = np.linspace(0.0, 1.0, int(np.ceil(fine.length / spacing)) + 1)
        refinement = Refinement(fine.point(along), self.size, self.growth)
        mesh = triangulate(outline, size=self.body_size, refinements=(refinement,))
        if self.cells == "polygons":
            return dual(mesh)
        return edges_halved(mesh, ARC) if self.cells == "edge-refined" else mesh

    def body(self, name: str, side: Side, thickness: float) -> Body:
        """Meshed body in the axes of space."""
        return Body(name, self.mesh(side), self.element, self.material, CUT, thickness)

    def zone(self, mesh: PolyMesh, half_width: float) -> Ints:
        """Edges of the arc within a half width of the apex, one after the other.

        Raises
        ------
        InputError
            If the arc is narrower.

        """
        if half_width > self.radius * np.sin(self.opening_rad / 2.0):
            raise InputError(
                f"discs that may touch {half_width:.3g} beside the apex, with a fine arc of opening_rad="
                f"{self.opening_rad:.3g} about it",
                "a fine arc that holds the contact",
                "enlarge opening_rad, or make the approach or the size smaller",
            )
        edges = mesh.edge_sets[ARC]
        inside = (np.abs(mesh.points[edges][..., 0]) <= half_width).all(axis=1)
        return edges[inside]
