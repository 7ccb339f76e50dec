"""Stresses inside cells, from the elements' reconstruction, at points and along lines."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers, check_integer
from flangeway.elements import Reconstruction, monomials
from flangeway.elements.monomials import Frame
from flangeway.elements.quadrature import gauss
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import cross_product, diagonal, middles_of, norms
from flangeway.mesh import PolyMesh
from flangeway.mesh.curved import as_polylines
from flangeway.problems import ElasticField, Elasticity
from flangeway.results import Result, ResultTable
from flangeway.solve import TorsionSolution
from flangeway.space import CellBatch, Space
from flangeway.types import Floats, Ints, floats

# --- Stresses inside cells, from the elements' reconstruction, and what is derived from them.


Polynomials = Callable[[CellBatch], tuple[Reconstruction, Floats]]
"""Reconstruction of a batch, and coefficients of the field's components, shape (n_components, n, n_cells)."""


@dataclass(frozen=True, eq=False)
class Stresses:
    """Stress components at some places and the invariants that engineers ask for.

    Parameters
    ----------
    components
        Normal stresses xx, yy, the shear xy, and the normal stress zz out of the plane, shape (n, 4), tension positive.
    """

    components: Floats

    @property
    def tensors(self) -> Floats:
        """Stresses xx, yy, zz, xy, yz, xz, the last two zero, shape (n, 6)."""
        xx, yy, xy, zz = self.components.T
        return np.stack((xx, yy, zz, xy, np.zeros_like(xx), np.zeros_like(xx)), axis=1)

    @property
    def principal(self) -> Floats:
        """Principal stresses in three dimensions, zz included, descending, shape (n, 3)."""
        xx, yy, xy, zz = self.components.T
        middle, radius = (xx + yy) / 2.0, np.hypot((xx - yy) / 2.0, xy)
        return np.sort(np.stack((middle + radius, middle - radius, zz), axis=1), axis=1)[:, ::-1]

    @property
    def in_plane_shear(self) -> Floats:
        """Maximum shear stress in the plane, shape (n,)."""
        xx, yy, xy, _ = self.components.T
        return np.hypot((xx - yy) / 2.0, xy)

    @property
    def von_mises(self) -> Floats:
        """Von Mises stress, the root of three times the second invariant of the deviator, shape (n,)."""
        return von_mises(self.tensors)


def von_mises(tensors: Floats) -> Floats:
    """Von Mises stress (n,) of stresses xx, yy, zz, xy, yz, xz, shape (n, 6)."""
    xx, yy, zz, *shears = tensors.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(normal / 2.0 + 3.0 * np.sum(np.square(shears), axis=0))


def cell_stresses(elasticity: Elasticity, displacement: Floats) -> Stresses:
    """Mean stresses of the cells.

    - `displacement`: all unknowns, shape (n_dofs, 2).
    """
    return Stresses(_cell_means(elasticity.space, lambda batch: elasticity.cell_stresses(batch, displacement), 4))


def corner_stresses(elasticity: Elasticity, displacement: Floats) -> Stresses:
    """Stresses at the cells' corners, each from its own cell, in the order of ``mesh.cell_points``.

    - `displacement`: all unknowns, shape (n_dofs, 2).
    """
    return Stresses(corner_values(elasticity.space, lambda batch: elasticity.cell_stresses(batch, displacement), 4))


def corner_values(space: Space, polynomials: Polynomials, n_components: int) -> Floats:
    """Values (n_corners, n_components) of the cells' polynomials at their corners, ordered as `mesh.cell_points`."""
    values = np.empty((len(space.mesh.cell_points), n_components))
    for batch in space.batches():
        reconstruction, coefficients = polynomials(batch)
        basis = monomials.evaluate(reconstruction.order, reconstruction.frame.local(batch.vertices))
        entries = space.mesh.batch_places(len(batch.vertices), batch.cells)
        # v_evs = sum over monomials a of c_sae m_ave at the vertices v of the cells e
        values[entries] = np.einsum("sae,ave->evs", coefficients, basis[: coefficients.shape[1]])
    return values


def nodal_stresses(solution: ElasticField) -> Stresses:
    """Stresses at the mesh's points, averaged over the cells there with their areas as weights.

    Averages hide jumps between cells, which show how good a mesh is, and between materials, which are real; prefer
    `corner_stresses`, or `recovered_stresses`, which are more accurate.
    """
    return at_mesh_points(solution.space.mesh, corner_stresses(solution.problem, solution.displacements))


def at_mesh_points(mesh: PolyMesh, corners: Stresses) -> Stresses:
    """Means of values at the cells' corners over each point, weighted by the cells' areas; zero at unused points."""
    weights = np.repeat(mesh.cell_areas, mesh.cell_sizes)
    total = np.bincount(mesh.cell_points, weights, minlength=mesh.n_points)
    sums = [
        np.bincount(mesh.cell_points, weights * component, minlength=mesh.n_points)
        for component in corners.components.T
    ]
    return Stresses(np.stack(sums, axis=1) / np.maximum(total, np.finfo(np.float64).tiny)[:, None])


def shear_stresses(solution: TorsionSolution) -> Floats:
    """Mean shear stresses ``tau_zx, tau_zy`` of the cells for a rate of twist of one, shape (n_cells, 2).

    With a shear modulus of one they are stresses per ``G theta'``.
    """
    return _cell_means(solution.problem.space, _shear_polynomials(solution), 2)


def corner_shear_stresses(solution: TorsionSolution) -> Floats:
    """Shear stresses at the cells' corners, each from its own cell, shape (len(cell_points), 2).

    In the order of ``mesh.cell_points``, for a rate of twist of one.
    """
    return corner_values(solution.problem.space, _shear_polynomials(solution), 2)


def _shear_polynomials(solution: TorsionSolution) -> Polynomials:
    return lambda batch: solution.problem.cell_shear_stresses(batch, solution.function)


def _cell_means(space: Space, polynomials: Polynomials, n_components: int) -> Floats:
    """Means (n_cells, n_components) of the cells' polynomials."""
    means = np.empty((space.mesh.n_cells, n_components))
    for batch in space.batches():
        reconstruction, coefficients = polynomials(batch)
        weights = reconstruction.moments[: coefficients.shape[1]] / reconstruction.areas
        means[batch.cells] = np.einsum("sae,ae->es", coefficients, weights)
    return means


# --- Cells of points, fields at points, stresses along lines and forces through cuts, from the cells' reconstructions.


BOUNDARY_TOLERANCE = 1e-9
"""Distance from the boundary, relative to the size of the mesh, within which a point still belongs to the mesh."""
OUTSIDE = -1
PIECES = 32  # of a curved edge as a polyline

Point = Sequence[float]


@dataclass(frozen=True, eq=False)
class StressLine(Result):
    """Stresses along a straight line.

    - `points`: shape (n, 2).
    - `distances`: from the start of the line, shape (n,).
    - `stresses`: at the points; not-a-number where the line is outside of the body.
    """

    points: Floats
    distances: Floats
    stresses: Stresses

    @property
    def table(self) -> ResultTable:
        """Distances, places and stresses of its points."""
        x, y = self.points.T
        components = dict(zip(("xx", "yy", "xy", "zz"), self.stresses.components.T, strict=True))
        of_points = {"distance": self.distances, "x": x, "y": y, **components, "von_mises": self.stresses.von_mises}
        return ResultTable(of_points)


@dataclass(frozen=True, eq=False)
class CutForce:
    """Resultant of the stresses on a straight cut: what the right of its direction does to the left.

    - `force`: shape (2,), in a body of revolution all around the axis.
    - `moment`: moment about the origin, counter-clockwise.
    - `length`: length of the cut inside the body.
    """

    force: Floats
    moment: float
    length: float


def stresses_at(solution: ElasticField, points: ArrayLike) -> Stresses:
    """Stresses at points (n, 2) inside the body, each from the cell that it lies in.

    Raises
    ------
    InputError
        If a point lies outside of the body.
    """
    return Stresses(_at_points(solution, points, stress_polynomials(solution), 4))


def displacements_at(solution: ElasticField, points: ArrayLike) -> Floats:
    """Displacements (n, 2) at points (n, 2) inside the body, from the projection of each cell.

    An `InputError` if a point lies outside of the body.
    """
    return _at_points(solution, points, value_polynomials(solution.displacements), 2)


def stresses_along(solution: ElasticField, start: Point, end: Point, n_points: int = 101) -> StressLine:
    """Stresses at equally spaced points of a line, both ends included.

    Raises
    ------
    InputError
        If the ends are the same, there are fewer than two points, or none lies in the body.
    """
    first, along = _line(start, end)
    check_integer("stresses_along", "n_points", n_points, 2, advice="leave the default")
    share = np.linspace(0.0, 1.0, n_points)
    points = first + share[:, None] * along
    components = values_inside(solution.space, points, stress_polynomials(solution), 4)
    if np.isnan(components).all():
        raise _no_body("a line", start, end)
    return StressLine(points, share * float(np.linalg.norm(along)), Stresses(components))


def force_through_cut(solution: ElasticField, start: Point, end: Point) -> CutForce:
    """Integrate the stresses on the parts of a straight line that are inside the body, cell by cell.

    The integrals are exact; where the line crosses curved edges these are polylines, see `locate`. An
    `InputError` if the ends are the same, or the line does not cross the body.
    """
    first, along = _line(start, end)
    length = float(np.linalg.norm(along))
    breaks = _crossings(solution, first, along)
    middles = first + middles_of(breaks)[:, None] * along
    cells = locate(solution.space.mesh, middles)
    inside = cells != OUTSIDE
    if not inside.any():
        raise _no_body("a cut", start, end)
    shares = np.diff(breaks)[inside]
    abscissae, weights = gauss(solution.space.order // 2 + 1)
    parameters = breaks[:-1][inside, None] + shares[:, None] * abscissae
    points = (first + parameters[..., None] * along).reshape(-1, 2)
    at_cells = np.repeat(cells[inside], len(abscissae))
    xx, yy, xy, _ = polynomials_at(solution.space, points, at_cells, stress_polynomials(solution), 4).T
    normal = np.array([along[1], -along[0]]) / length
    traction = np.stack((xx * normal[0] + xy * normal[1], xy * normal[0] + yy * normal[1]), axis=1)
    lengths = (shares[:, None] * weights).ravel() * length
    forces = traction * (lengths * solution.problem.depth(points))[:, None]
    moment = float(np.sum(cross_product(points, forces)))
    return CutForce(forces.sum(axis=0), moment, float(shares.sum()) * length)


def _at_points(solution: ElasticField, points: ArrayLike, polynomials: Polynomials, n_components: int) -> Floats:
    given, space = floats(points), solution.space
    cells = cells_of(space.mesh, given, f"body `{solution.problem.name}`")
    return polynomials_at(space, given, cells, polynomials, n_components)


def _line(start: Point, end: Point) -> tuple[Floats, Floats]:
    ends = np.array([start, end], dtype=np.float64)
    if ends.shape != (2, 2) or not np.isfinite(ends).all() or (ends[0] == ends[1]).all():
        raise InputError(f"a line from {short(start)} to {short(end)}", "two different points (x, y)", "give its ends")
    return ends[0], ends[1] - ends[0]


def _no_body(what: str, start: Point, end: Point) -> InputError:
    return InputError(f"{what} from {short(start)} to {short(end)}", "one that crosses the body", "move its ends")


def _crossings(solution: ElasticField, first: Floats, along: Floats) -> Floats:
    """Shares of the line at its ends and where it meets edges, rising."""
    mesh = as_polylines(solution.space.mesh, PIECES)
    edges, line = shapely.linestrings(mesh.points[mesh.edges]), shapely.LineString((first, first + along))
    met = shapely.intersection(edges[shapely.intersects(edges, line)], line)
    shares = (shapely.get_coordinates(met) - first) @ along / (along @ along)
    shares = np.sort(np.concatenate(([0.0, 1.0], shares[(shares > 0.0) & (shares < 1.0)])))
    kept = np.concatenate(([True], np.diff(shares) > 1e-12))
    kept[-1] = True
    return shares[kept]


def cells_of(mesh: PolyMesh, points: ArrayLike, what: str) -> Ints:
    """Cell of each point (n, 2), shape (n,); an `InputError` if one is outside of the mesh, which is called `what`."""
    cells = locate(mesh, points)
    if (cells == OUTSIDE).any():
        x, y = np.asarray(points)[np.argmax(cells == OUTSIDE)]
        raise InputError(f"the point ({x:g}, {y:g}) outside of {what}", "points inside", "move the point")
    return cells


def values_inside(space: Space, points: Floats, polynomials: Polynomials, n_components: int) -> Floats:
    """Values (n, n_components) of polynomials at points (n, 2); not-a-number outside of the mesh."""
    cells = locate(space.mesh, points)
    values, inside = np.full((len(points), n_components), np.nan), cells != OUTSIDE
    values[inside] = polynomials_at(space, points[inside], cells[inside], polynomials, n_components)
    return values


def value_polynomials(dofs: Floats) -> Polynomials:
    """Return the function of a batch of cells that gives the projections of a function with unknowns (n_dofs, m)."""

    def polynomials(batch: CellBatch) -> tuple[Reconstruction, Floats]:
        reconstruction = batch.reconstruct()
        # coefficients (m, n_monomials, n_cells): sum over the nodes m of projection[a, m, e] dofs[m, e, i]
        return reconstruction, np.einsum("ame,mei->iae", reconstruction.projected_value, dofs[batch.dofs])

    return polynomials


def stress_polynomials(solution: ElasticField) -> Polynomials:
    """Return the function of a batch of cells that gives the stresses xx, yy, xy, zz of a solution."""
    return lambda batch: solution.problem.cell_stresses(batch, solution.displacements)


def polynomials_at(space: Space, points: Floats, cells: Ints, polynomials: Polynomials, n_components: int) -> Floats:
    """Values (n, n_components) of polynomials at points (n, 2) of cells (n,)."""
    values = np.empty((len(points), n_components))
    row_of_cell = np.full(space.mesh.n_cells, -1, dtype=np.int64)
    for batch in space.batches():
        row_of_cell[batch.cells] = np.arange(len(batch.cells))
        here = np.flatnonzero(row_of_cell[cells] >= 0)
        if len(here):
            used, columns = np.unique(row_of_cell[cells[here]], return_inverse=True)
            reconstruction, coefficients = polynomials(batch.part(used))
            frame = Frame(reconstruction.frame.origin[:, columns], reconstruction.frame.map[:, :, columns])
            monomial = monomials.evaluate(reconstruction.order, frame.local(points[here].T))
            chosen = coefficients[:, :, columns]
            values[here] = np.einsum("cae,ae->ec", chosen, monomial[: chosen.shape[1]])
        row_of_cell[batch.cells] = -1
    return values


def locate(mesh: PolyMesh, points: ArrayLike) -> Ints:
    """Cell of each point (n, 2), shape (n,); -1 outside of the mesh.

    A point on a common edge belongs to one of its cells. Curved edges are polylines of 32 pieces, and a point that is
    no further outside than these are from their curves belongs to the mesh: 1/500 of what its chord is. An
    `InputError` if the points have another shape or are not finite.
    """
    given = as_numbers("points", points)
    if given.ndim != 2 or given.shape[1:] != (2,) or not np.isfinite(given).all():
        raise InputError(f"points of shape {given.shape}", "finite numbers, shape (n, 2)", "give rows of x and y")
    cells = np.full(len(given), OUTSIDE, dtype=np.int64)
    near = BOUNDARY_TOLERANCE * diagonal(mesh.points)
    if mesh.curves is not None:
        depths = mesh.points[mesh.curves.pairs].mean(axis=1) - mesh.curves.points([0.5])[:, 0]
        near = max(near, 2.0 * float(norms(depths).max()) / PIECES**2)
        mesh = as_polylines(mesh, PIECES)
    tree, at = mesh.cell_tree, shapely.points(given)
    which, candidates = tree.query(at, predicate="dwithin", distance=near)
    # the last that is written stays: the nearest cell, of several that hold the point the one of the highest number
    order = np.lexsort((candidates, -shapely.distance(tree.geometries[candidates], at[which])))
    cells[which[order]] = candidates[order]
    return cells
