"""Cells cut into small triangles for display, with the elements' own reconstruction evaluated at their points."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

from flangeway.elements.quadrature import gauss_lobatto
from flangeway.errors import InputError
from flangeway.mesh import PolyMesh
from flangeway.mesh.kernel import cell_centres, kernel_centre, star_parts
from flangeway.post import Stresses, corner_stresses
from flangeway.post.lines import polynomials_at, stress_polynomials, value_polynomials
from flangeway.problems import ElasticField
from flangeway.space import Space
from flangeway.types import Floats, Ints

_Fans: TypeAlias = tuple[Floats, Ints, Ints, Ints, Ints]

NO_EDGE = -1


@dataclass(frozen=True, eq=False)
class Display:
    """Small triangles that fill the cells; the points of each cell are its own, so that fields may jump between cells.

    Each cell is divided into triangles between a centre that sees it whole and its sides (a cell without such a centre
    first into parts that have one), and each of these into `pieces` squared.
    """

    space: Space  # whose cells are shown
    pieces: int  # number of pieces of each side
    points: Floats  # shape (n, 2)
    cells: Ints  # cell of each point, shape (n,)
    triangles: Ints  # counter-clockwise triangles of points (m, 3)
    edge: Ints  # edge of the mesh on which a point lies, `NO_EDGE` for points inside, shape (n,)
    step: Ints  # place on that edge, from 0 at its lower point to `pieces`, shape (n,)

    @property
    def mesh(self) -> PolyMesh:
        """The mesh whose cells are shown."""
        return self.space.mesh

    @cached_property
    def places(self) -> Ints:
        """Number of the place of each point, the same for points of several cells there, shape (n,)."""
        mesh = self.mesh
        numbers = mesh.n_points + mesh.n_edges * (self.pieces - 1) + np.arange(len(self.points))
        on_edge = self.edge != NO_EDGE
        inner = on_edge & (self.step > 0) & (self.step < self.pieces)
        numbers[inner] = mesh.n_points + self.edge[inner] * (self.pieces - 1) + self.step[inner] - 1
        for end, step in enumerate((0, self.pieces)):
            mine = on_edge & (self.step == step)
            numbers[mine] = mesh.edges[self.edge[mine], end]
        return numbers

    def function(self, dofs: Floats) -> Floats:
        """Values (n, m) of a continuous function with unknowns (n_dofs, m): on edges its own, inside the projection."""
        values = polynomials_at(self.space, self.points, self.cells, value_polynomials(dofs), dofs.shape[1])
        on_edge = np.flatnonzero(self.edge != NO_EDGE)
        nodes = self.space.edge_nodes(self.mesh.edges[self.edge[on_edge]])
        weights = edge_weights(self.space.order, self.pieces)[self.step[on_edge]]
        values[on_edge] = np.einsum("pn,pni->pi", weights, dofs[nodes])
        return values


def edge_weights(order: int, pieces: int) -> Floats:
    """Weights of an edge's nodes at its equal pieces' ends, (pieces + 1, order + 1): Lagrange's polynomials."""
    lagrange = BarycentricInterpolator(gauss_lobatto(order + 1)[0], np.eye(order + 1))
    return np.asarray(lagrange(np.arange(pieces + 1) / pieces))


def display(space: Space, pieces: int | None = None) -> Display:
    """Cut the elements of a space into small triangles, each side into `pieces`.

    By default these are the order, on meshes with curved edges twice the order.
    """
    if pieces is None:
        pieces = space.order if space.mesh.curves is None else 2 * space.order
    if pieces < 1:
        raise InputError(f"pieces={pieces}", "1 or more", "leave it out for the order of the elements")
    mesh = space.mesh
    parts = []
    for n_vertices, cells in mesh.batches():
        centres, seen = cell_centres(mesh, cells)
        places = mesh.batch_places(n_vertices, cells)
        if seen.any():
            parts.append(_fans(space, pieces, cells[seen], places[seen], centres[seen], mesh.cell_edges[places[seen]]))
        for row in np.flatnonzero(~seen).tolist():
            parts += _star_fans(space, pieces, int(cells[row]), places[row])
    starts = np.cumsum([0, *(len(part[0]) for part in parts[:-1])])
    triangles = np.concatenate([part[2] + start for part, start in zip(parts, starts, strict=True)])
    points = np.concatenate([part[0] for part in parts])
    owner, edge, step = (np.concatenate([part[i] for part in parts]) for i in (1, 3, 4))
    return Display(space, pieces, points, owner, triangles, edge, step)


def _star_fans(space: Space, pieces: int, cell: int, places: Ints) -> list[_Fans]:
    fans, mesh = [], space.mesh
    for part in star_parts(np.arange(len(places), dtype=np.int32), mesh.points[mesh.cell_points[places]]):
        whole = (np.roll(part, -1) - part) % len(places) == 1  # a side of the cell, not a diagonal
        edges = np.where(whole, mesh.cell_edges[places[part]], NO_EDGE)
        centre = kernel_centre(mesh.points[mesh.cell_points[places[part]]])[0]
        fans.append(_fans(space, pieces, np.array([cell]), places[part][None], centre[None], edges[None]))
    return fans


def _fans(
    space: Space, pieces: int, cells: NDArray[np.integer], places: Ints, centres: Floats, edges: NDArray[np.integer]
) -> _Fans:
    """What makes a `Display`, from its points on, of star-shaped polygons (n_cells, n_vertices) of one size.

    The points of a cell lie on rings about its centre, ring j with j points to each side; the last ring is the rim.
    """
    mesh, (n_cells, n) = space.mesh, places.shape
    corners = mesh.points[mesh.cell_points[places]]
    along = np.roll(corners, -1, axis=1) - corners
    bent = (edges != NO_EDGE) & (mesh.curve_rows[edges] >= 0) & (space.order > 1)
    numbers = mesh.cell_points[places]
    nodes = space.nodes[space.edge_nodes(np.stack((numbers, np.roll(numbers, -1, axis=1)), axis=-1)[bent])]
    layers = [centres[:, None]]
    for j in range(1, pieces + 1):
        on_rim = corners[:, :, None] + (np.arange(j) / j)[:, None] * along[:, :, None]
        on_rim[bent] = np.einsum("tn,eni->eti", edge_weights(space.order, j)[:-1], nodes)
        ring = centres[:, None, None] + (j / pieces) * (on_rim - centres[:, None, None])
        layers.append((on_rim if j == pieces else ring).reshape(n_cells, -1, 2))
    points = np.concatenate(layers, axis=1)
    n_each = points.shape[1]
    local = _ring_triangles(n, pieces)
    triangles = (np.arange(n_cells)[:, None, None] * n_each + local).reshape(-1, 3)
    forward = mesh.cell_points[places] < np.roll(mesh.cell_points[places], -1, axis=1)
    t = np.arange(pieces)
    steps = np.where(forward[..., None], t, pieces - t)
    edge = np.full((n_cells, n_each), NO_EDGE, dtype=np.int64)
    step = np.zeros((n_cells, n_each), dtype=np.int64)
    edge[:, n_each - n * pieces :] = np.repeat(edges, pieces, axis=1)
    step[:, n_each - n * pieces :] = steps.reshape(n_cells, -1)
    # a corner between a diagonal and a side belongs to the side
    for corner in np.flatnonzero((edges == NO_EDGE).any(axis=0) & (np.roll(edges, 1, axis=1) != NO_EDGE).any(axis=0)):
        place = n_each - n * pieces + corner * pieces
        edge[:, place] = edges[:, corner - 1]
        step[:, place] = np.where(forward[:, corner - 1], pieces, 0)
    return (
        points.reshape(-1, 2),
        np.repeat(cells.astype(np.int64), n_each),
        triangles,
        edge.ravel(),
        step.ravel(),
    )


def _ring_triangles(n: int, pieces: int) -> Ints:
    """Triangles (n pieces^2, 3) between the rings about a centre, counter-clockwise."""

    def number(j: int, side: int, t: int) -> int:
        return 0 if j == 0 else 1 + n * j * (j - 1) // 2 + (side * j + t) % (n * j)

    rows = []
    for side in range(n):
        for j in range(1, pieces + 1):
            rows += [[number(j - 1, side, t), number(j, side, t), number(j, side, t + 1)] for t in range(j)]
            rows += [[number(j - 1, side, t), number(j, side, t + 1), number(j - 1, side, t + 1)] for t in range(j - 1)]
    return np.array(rows, dtype=np.int64)


def displayed_stresses(solution: ElasticField, shown: Display) -> Stresses:
    """Stresses at the points of a display, each from its own cell."""
    return Stresses(polynomials_at(shown.space, shown.points, shown.cells, stress_polynomials(solution), 4))


@dataclass(frozen=True, eq=False)
class ShownCells:
    """Cells for files and the page, each with points of its own: as they are, or cut into triangles."""

    mesh: PolyMesh  # what is shown
    cells: Ints  # cell of the space that each shown cell is a piece of
    places: Ints  # number of each point's place, the same for the points of several cells there, shape (n_points,)
    n_rim_places: int  # places below this number are on the rims of the cells of the space, the others inside
    space: Space
    display: Display | None  # how the cells were cut, None where they are shown as they are

    def values(self, field: ElasticField) -> tuple[Floats, Stresses]:
        """Displacements (n_points, 2) and stresses at the points, in the axes of the field, each from its own cell."""
        if self.display is not None:
            return self.display.function(field.displacements), displayed_stresses(field, self.display)
        corners = self.space.mesh.cell_points
        return field.displacements[corners], corner_stresses(field.problem, field.displacements)


def shown_cells(space: Space, pieces: int | None = None) -> ShownCells:
    """Cut the cells' sides into some pieces, see `display`; with one piece the cells are shown as they are."""
    mesh = space.mesh
    if pieces == 1 or (pieces is None and space.order == 1):
        used, places = np.unique(mesh.cell_points, return_inverse=True)
        return ShownCells(mesh.apart(), np.arange(mesh.n_cells), places, len(used), space, None)
    shown = display(space, pieces)
    numbers, places = np.unique(shown.places, return_inverse=True)
    n_rim = int(np.searchsorted(numbers, mesh.n_points + mesh.n_edges * (shown.pieces - 1)))
    cut = PolyMesh.from_cells(shown.points, shown.triangles)
    return ShownCells(cut, shown.cells[shown.triangles[:, 0]], places, n_rim, space, shown)
