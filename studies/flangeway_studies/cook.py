"""Cook's membrane (Moherdaui 2021, 5.2.2): its meshes, its solutions, and numbers that are known of it."""

from dataclasses import dataclass, replace

import numpy as np

from flangeway.elements import Lagrange, TraceStabilisation, Virtual
from flangeway.errors import InputError
from flangeway.geometry import polygon
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, dual, edges_halved, rectangle_grid, refined, triangulate
from flangeway.post import displacements_at
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space
from flangeway.types import Floats

YOUNG, TRACTION = 70.0, 6.25
CORNERS = ((0.0, 0.0), (48.0, 44.0), (48.0, 60.0), (0.0, 44.0))
SIDES = ("bottom", "right", "top", "left")
MIDDLE, CORNER = (48.0, 52.0), (48.0, 60.0)
"""Where displacements are compared: the middle and the upper end of the loaded side."""

ENERGY = 1542.1595
"""Strain energy of the exact solution: orders 3 and 4 on adaptively refined meshes agree on it to 1e-8."""

NEARLY_INCOMPRESSIBLE = 0.4999
NEARLY_INCOMPRESSIBLE_WORK = 2652.4  # work of the load for that Poisson's ratio: orders 3 and 4 agree on it to 5e-5

SIZE = 10.0
FINER_AT_CORNERS = (4.0, 4.0, 8.0, 10.0)
"""Edges of the coarsest mesh, and how many times shorter they are at the corners: at the last one stresses grow without
limit, and at the last but one the shear of the loaded side does not fit the free one."""

MAX_LEVEL = 6
MAX_PUBLISHED_ORDER = 2
PUBLISHED_POISSON = 1.0 / 3.0


@dataclass(frozen=True)
class CookCode:
    """One configuration, such as ``VCM3O2`` (Moherdaui 2021, Figure 52).

    Parameters
    ----------
    method
        ``"F"`` for Lagrange triangles, ``"V"`` for virtual elements on their dual polygons, ``"H"`` for both: triangles
        inside, and at the boundary triangles whose outer edge is halved, as virtual quadrilaterals (Moherdaui 2021,
        Figure 68).
    level
        Refinement, 1 to 4 for the published ones.
    order
        Order of the elements.

    """

    method: str
    level: int
    order: int

    def __post_init__(self) -> None:
        if self.method not in ("F", "V", "H"):
            raise InputError(f"CookCode(method={self.method!r})", "'F', 'V' or 'H'", "choose one of these")
        if not 1 <= self.level <= MAX_LEVEL:
            raise InputError(f"CookCode(level={self.level})", f"1 to {MAX_LEVEL}", "choose one of these")

    def __str__(self) -> str:
        return f"{self.method}CM{self.level}O{self.order}"

    def space(self) -> Space:
        """Mesh and elements."""
        return method_space(cook_triangles(self.level), self.method, self.order)


def cook_triangles(level: int) -> PolyMesh:
    """Delaunay triangles, finer towards the corners; each level has the triangles of the one before cut into four."""
    refinements = [
        Refinement(np.array([corner]), SIZE / finer, 0.25)
        for corner, finer in zip(CORNERS, FINER_AT_CORNERS, strict=True)
    ]
    mesh = triangulate(polygon(CORNERS, names=SIDES), size=SIZE, refinements=refinements)
    for _ in range(level - 1):
        mesh = refined(mesh)
    return mesh


def published_virtual(order: int) -> Virtual:
    """Virtual element with the published stabilisation, half of the trace; above order 2, unpublished, the default."""
    return Virtual(order, TraceStabilisation() if order <= MAX_PUBLISHED_ORDER else None)


def method_space(triangles: PolyMesh, method: str, order: int) -> Space:
    """Space of a method, see `CookCode`, on triangles whose boundary is in edge sets."""
    if method == "F":
        return Space(triangles, Lagrange(order))
    if method == "V":
        return Space(dual(triangles), published_virtual(order))
    mesh = triangles
    for name in triangles.edge_sets:
        mesh = edges_halved(mesh, name)
    polygons = mesh.cell_sizes > 3
    mesh = mesh.with_cell_set("triangles", ~polygons).with_cell_set("polygons", polygons)
    return Space(mesh, {"triangles": Lagrange(order), "polygons": published_virtual(order)})


def cook_grid(n: int) -> PolyMesh:
    """The membrane in n by n equal quadrilaterals, as a first mesh to refine."""
    grid = rectangle_grid(1.0, 1.0, n, n, cells="quadrilaterals")
    return replace(grid, points=of_unit_square(grid.points))


def of_unit_square(points: Floats) -> Floats:
    """Return the points (n, 2) of the membrane that points of the unit square are mapped to."""
    s, t = points.T
    return np.stack((48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s)), axis=1)


def solve_cook(space: Space, poisson: float = 1.0 / 3.0) -> ElasticitySolution:
    """Plane strain, held on the left, with a shear traction upwards on the right."""
    material = Elastic(YOUNG, poisson)
    load = Traction("right", (0.0, TRACTION))
    return solve_elasticity(Elasticity(space, material, 1.0, [load], [fixed("left")], "membrane"))


def vertical_displacements(solution: ElasticitySolution) -> tuple[float, float]:
    """Vertical displacements at `MIDDLE` and `CORNER`."""
    middle, corner = displacements_at(solution, [MIDDLE, CORNER])[:, 1].tolist()
    return middle, corner
