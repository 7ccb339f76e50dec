"""Stokes' equations and incompressible elasticity by the divergence-free virtual element.

Beirao da Veiga, Lovadina and Vacca (2017, ESAIM: M2AN 51): velocities whose divergence is a polynomial of degree k - 1
and pressures that are all such polynomials, cell by cell. So the velocity has no divergence at any point, the pressure
disturbs it not, and nothing locks. Values are projected in the enhanced space of the same authors (2018, SIAM J. Numer.
Anal. 56, section 3), so that the velocity has the order k + 1 in L2.

Local unknowns: the two components at vertices and Gauss-Lobatto points of edges, then the moments inside:
``int div v m_b / h`` for monomials of degree 1 to k - 1, and ``int v . (A^T x_perp m_c) / h`` of degree up to k - 3,
where A is the cell's frame, x_perp = (eta, -xi), and h the root of the area.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.checks import check_integer, check_positive
from flangeway.elements import Function, Virtual, batched, monomials
from flangeway.elements.monomials import Frame, exponents, index, n_monomials
from flangeway.elements.projection import Polygons, principal_frame
from flangeway.elements.quadrature import edge_shapes, edge_unknowns, gauss
from flangeway.errors import InputError
from flangeway.forms.weak import load, scattered
from flangeway.geometry.arrays import steps_around
from flangeway.mesh import PolyMesh
from flangeway.solve.linear import Factor
from flangeway.space import CellBatch, FormMatrix, Space
from flangeway.space.functions import at_points, function_of
from flangeway.space.spaces import component_dofs
from flangeway.types import Bools, Floats, Indices, Ints

HIGHEST_ORDER = 6
"""Monomials are not orthogonalised here: above, too many digits go."""
MAX_FLOW = 1e-2
"""Net flow through the boundary, relative to the sum of all, that interpolation explains; it is spread over the
cells."""


@dataclass(frozen=True, eq=False)
class DivergenceFree:
    """Polynomials of a batch of cells as linear maps of the local unknowns, which are on the axis before the last."""

    frame: Frame
    moments: Floats  # of monomials up to degree 2 k
    divergence: Floats  # int div v m_b, (n_monomials(k - 1), n_local, n_cells)
    gradient: Floats  # coefficients, (n_monomials(k - 1), 2 components, 2 derivatives, n_local, n_cells)
    value: Floats  # L2 projection, (n_monomials(k), 2, n_local, n_cells)
    missed: Floats  # (I - D Pi)^T (I - D Pi), (n_local, n_local, n_cells)
    constant: Floats  # unknowns of constant velocities, (n_local, 2, n_cells)


@cache
def _decomposition(degree: int) -> Floats:
    """Vector monomials ``e_j m_d`` as sums of ``grad m_a`` (a from 1) and ``x_perp m_c``: (rows a and c, 2 n_d)."""
    n, n_perp = n_monomials(degree), n_monomials(degree - 1)
    gradients = np.concatenate(monomials.derivatives(degree + 1)[:, :, 1:])
    perp = np.zeros((2 * n, n_perp))
    columns = np.arange(n_perp)
    perp[index(exponents(degree)[:n_perp] + np.array([0, 1])), columns] = 1.0
    perp[n + index(exponents(degree)[:n_perp] + np.array([1, 0])), columns] = -1.0
    return np.linalg.inv(np.hstack((gradients, perp)))


def _flux(order: int, cells: Polygons) -> Floats:
    """``int_boundary v n_j m_a`` of one component, (2 j, n_boundary, n_monomials(k + 1), n_cells).

    By Gauss points, exact to degree 2 k + 1.
    """
    abscissae, weights = gauss(order + 1)
    shapes = edge_shapes(order, abscissae)
    along = steps_around(cells.local)
    at = monomials.evaluate(order + 1, cells.local[:, None] + abscissae[:, None, None] * along[:, None])
    on_edges = np.einsum("avqe,q,qs->avse", at, weights, shapes)
    with_normals = np.einsum("avse,vje->jvsae", on_edges, cells.normals)
    flux = np.zeros((2, cells.n_boundary, *at.shape[::3]))
    for edge, unknowns in enumerate(edge_unknowns(order, len(cells.local))):
        flux[:, unknowns] += with_normals[:, edge]
    return flux


def divergence_free(order: int, vertices: Floats) -> DivergenceFree:
    """Reconstruct on polygons with counter-clockwise vertices (n_vertices, 2, n_cells)."""
    k, frame = order, principal_frame(vertices)
    cells = Polygons.of(vertices, k, frame)
    n_cells, area = vertices.shape[-1], cells.moments[0]
    h, n_b = np.sqrt(area), cells.n_boundary
    n_low, n_full = n_monomials(k - 1), n_monomials(k)
    n_div, n_perp, n_values = n_low - 1, n_monomials(k - 3), 2 * n_b
    n_local = n_values + n_div + n_perp

    low_mass = monomials.mass(k - 1, cells.moments)
    flux = _flux(k, cells)
    divergence = np.zeros((n_low, n_local, n_cells))
    divergence[0, :n_values] = flux[:, :, 0].swapaxes(0, 1).reshape(n_values, n_cells)
    divergence[np.arange(1, n_low), n_values + np.arange(n_div)] = h
    coefficients = batched.solve(low_mass, divergence)
    # int v . grad m_a = -int div v m_a + int_boundary v . n m_a
    products = cells.moments[index(exponents(k + 1)[:, None] + exponents(k - 1))]
    on_gradients = -np.einsum("abe,bme->ame", products, coefficients)
    on_gradients[:, :n_values] += flux.transpose(2, 1, 0, 3).reshape(-1, n_values, n_cells)
    on_perp = np.zeros((n_low, n_local, n_cells))
    on_perp[np.arange(n_perp), n_values + n_div + np.arange(n_perp)] = h

    def vector_moments(degree: int) -> Floats:
        """``int v_i m_d``, (n_d, 2, n_local, n_cells): e_i = A^T (A^-T e_i) and the decomposition in the frame."""
        n, n_gradients = n_monomials(degree), n_monomials(degree + 1) - 1
        parts = np.concatenate((on_gradients[1 : n_gradients + 1], on_perp[: n_monomials(degree - 1)]))
        in_frame = np.einsum("rd,rme->dme", _decomposition(degree), parts).reshape(2, n, n_local, n_cells)
        return np.einsum("ije,jdme->dime", frame.inverse, in_frame)

    # int d_j v_i m_b = -int v_i d_j m_b + int_boundary v_i n_j m_b
    slopes = np.einsum("lje,ldb->jdbe", frame.map, monomials.derivatives(k - 1))
    gradient = -np.einsum("jdbe,dime->bijme", slopes, vector_moments(k - 2))
    for i in range(2):
        gradient[:, i, :, i:n_values:2] += flux[:, :, :n_low].transpose(2, 0, 1, 3)
    gram, rhs = cells.energy_matrices(gradient.swapaxes(1, 2).reshape(n_low, 2, -1, n_cells))
    energetic = np.empty((n_full, 2 * n_local, n_cells))
    energetic[1:] = batched.solve(gram, rhs)
    n_vertices = len(vertices)  # their mean fixes the constant
    means = np.zeros((2, n_local, n_cells))
    for i in range(2):
        means[i, i : 2 * n_vertices : 2] = 1.0 / n_vertices
    boundary = cells.boundary_values()
    at_vertices = boundary[1:, :n_vertices].mean(axis=1)
    energetic[0] = means.reshape(-1, n_cells) - np.einsum("ae,ame->me", at_vertices, energetic[1:])
    polynomials = energetic.reshape(n_full, 2, n_local, n_cells)

    # int m_a (A^T x_perp)_i m_c: what monomials are on x_perp
    powers = exponents(k)
    turned = np.stack(
        [cells.moments[index(powers[:, None] + powers[:n_low] + shift)] for shift in ([0, 1], [1, 0])]
    ) * np.array([1.0, -1.0]).reshape(2, 1, 1, 1)
    monomials_on_perp = np.einsum("jie,jace->iace", frame.map, turned)
    on_perp[n_perp:] = np.einsum("iace,aime->cme", monomials_on_perp[:, :, n_perp:], polynomials)
    value = batched.solve(monomials.mass(k, cells.moments), vector_moments(k).reshape(n_full, -1, n_cells))

    dofs = _monomial_dofs(cells, monomials_on_perp[:, :, :n_perp], low_mass[1:])
    missed = np.eye(n_local)[:, :, None] - np.einsum("nase,asme->nme", dofs, polynomials, optimize=True)
    return DivergenceFree(
        frame,
        cells.moments,
        divergence,
        batched.solve(low_mass, gradient.reshape(n_low, -1, n_cells)).reshape(gradient.shape),
        value.reshape(n_full, 2, n_local, n_cells),
        batched.symmetric_product(missed, missed),
        dofs[:, 0],
    )


def _monomial_dofs(cells: Polygons, on_perp: Floats, mass: Floats) -> Floats:
    """Unknowns of vector monomials ``e_i m_a``, matrix D, (n_local, n_monomials(k), 2, n_cells)."""
    _, n_full, n_perp, n_cells = on_perp.shape
    n_values, n_div, h = 2 * cells.n_boundary, len(mass), np.sqrt(cells.moments[0])
    dofs = np.zeros((n_values + n_div + n_perp, n_full, 2, n_cells))
    derivatives = np.einsum("lie,ldb->idbe", cells.frame.map, monomials.derivatives(cells.order))
    for i in range(2):
        dofs[i:n_values:2, :, i] = cells.boundary_values().swapaxes(0, 1)
        dofs[n_values : n_values + n_div, :, i] = np.einsum("bde,dae->bae", mass, derivatives[i]) / h
        dofs[n_values + n_div :, :, i] = on_perp[i].swapaxes(0, 1) / h
    return dofs


@dataclass(frozen=True, eq=False)
class StokesSolution:
    """Velocity and pressure.

    Parameters
    ----------
    space
        Scalar virtual elements of the same order, whose nodes carry the velocity.
    velocity
        At ``space.nodes``, (n_nodes, 2).
    inside
        Moments inside cells, (n_cells, n_moments).
    pressure
        Coefficients of the pressure in each cell, by the monomials of its frame, (n_cells, n_monomials(k - 1)).

    """

    space: Space
    velocity: Floats
    inside: Floats
    pressure: Floats

    def at_quadrature(self, degree: int) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Points (n, 2), weights (n,), velocity (n, 2), its gradient (n, 2, 2), pressure (n,), by projections."""
        parts = []
        for batch in self.space.batches():
            cells = divergence_free(self.space.order, batch.vertices)
            points, weights = batch.quadrature(degree)
            at = monomials.evaluate(self.space.order, cells.frame.local(points))
            low = at[: cells.divergence.shape[0]]
            nodal = self.velocity[batch.outer_dofs]
            local = np.concatenate((nodal.swapaxes(1, 2).reshape(-1, len(batch.cells)), self.inside[batch.cells].T))
            value = np.einsum("aqe,aime,me->qei", at, cells.value, local, optimize=True)
            gradient = np.einsum("aqe,aijme,me->qeij", low, cells.gradient, local, optimize=True)
            pressure = np.einsum("aqe,ea->qe", low, self.pressure[batch.cells])
            parts.append((points.swapaxes(1, 2), weights, value, gradient, pressure))
        shapes = (-1, 2), (-1,), (-1, 2), (-1, 2, 2), (-1,)
        columns = zip(zip(*parts, strict=True), shapes, strict=True)
        at, weight, u, slope, p = (np.concatenate([a.reshape(shape) for a in row]) for row, shape in columns)
        return at, weight, u, slope, p


def stokes(
    mesh: PolyMesh,
    order: int,
    force: Function | ArrayLike = (0.0, 0.0),
    *,
    viscosity: float = 1.0,
    bulk_modulus: float = np.inf,
    velocity: Function | ArrayLike = (0.0, 0.0),
    held: Indices | Bools | None = None,
    tractions: dict[str, Function | ArrayLike] | None = None,
) -> StokesSolution:
    """Solve ``-div(2 mu eps(u) - p I) = f`` with ``div u = -p / K``.

    Parameters
    ----------
    mesh
        Any polygons with straight edges.
    order
        Order k, 2 to 6.
    force
        Force per area, two numbers or a function of points (n, 2) with values (n, 2).
    viscosity
        Viscosity mu, or shear modulus where u is a displacement.
    bulk_modulus
        Lame's second constant K; infinite for an incompressible fluid or solid.
    velocity
        Prescribed values of the held nodes.
    held
        Nodes of ``Space(mesh, Virtual(order))`` whose velocity is prescribed, from its `boundary_dofs`, or truth values
        (n_nodes, 2). None: the whole boundary; then the mean of the pressure is zero.
    tractions
        Force per length along edge sets, by their names.

    Raises
    ------
    InputError
        If the order is not 2 to 6, edges are curved, values are wrong, or prescribed velocities change the volume.

    """
    check_integer("stokes", "order", order, 2, HIGHEST_ORDER)
    check_positive("stokes", "viscosity", viscosity, advice="give a number > 0")
    if mesh.curves is not None:
        raise InputError("stokes on curved edges", "straight edges", "take mesh.straight()")
    if not bulk_modulus > 0.0:
        raise InputError(f"stokes: bulk_modulus={bulk_modulus}", "a number > 0, or infinity", "leave it out")
    space, one = Space(mesh, Virtual(order)), mesh.points[:1]
    forces, velocities = (
        function_of(f"stokes: {name}", given, one, (2,)) for name, given in (("force", force), ("velocity", velocity))
    )
    n_nodes, n_low = space.n_nodes, n_monomials(order - 1)
    parts = list(_parts(space))
    matrix = _assembled(parts, viscosity, bulk_modulus)
    n, first = matrix.shape[0], matrix.shape[0] - n_low * mesh.n_cells
    rhs, means = np.zeros(n), np.zeros(n)  # means: integrals of the pressure
    for batch, cells, numbers, pressures in parts:
        points, weights = batch.quadrature(2 * order + 2)
        given = at_points(forces, points)
        products = np.einsum("aqe,iqe->aie", monomials.evaluate(order, cells.frame.local(points)), given * weights)
        np.add.at(rhs, numbers, np.einsum("aie,aime->me", products, cells.value))
        means[pressures] = cells.moments[:n_low]
    for name, traction in (tractions or {}).items():
        rhs[: 2 * n_nodes] += load(space, traction, on=name)[:n_nodes].ravel()
    fixed, closed = np.zeros(n, dtype=bool), held is None and np.isinf(bulk_modulus)
    nodes = np.zeros((n_nodes, 2), dtype=bool)
    nodes[space.boundary_dofs() if held is None else np.asarray(held)] = True
    fixed[: 2 * n_nodes] = nodes.ravel()
    values = np.zeros(n)
    values[: 2 * n_nodes] = np.reshape(velocities(space.nodes), -1)
    if closed:  # a constant pressure does no work
        fixed[first] = True
        flows = matrix[first::n_low] @ values
        if abs(flows.sum()) > MAX_FLOW * (abs(matrix[first::n_low]) @ np.abs(values)).sum():
            raise InputError("a velocity along the whole boundary that changes the volume", "no net flow", "correct it")
        rhs[first::n_low] = flows.sum() * mesh.cell_areas / mesh.cell_areas.sum()
    solution = Factor(matrix, fixed).solve(rhs, values)
    if closed:
        solution[first::n_low] -= means @ solution / mesh.cell_areas.sum()
    inside = solution[2 * n_nodes : first].reshape(mesh.n_cells, -1)
    return StokesSolution(space, solution[: 2 * n_nodes].reshape(-1, 2), inside, solution[first:].reshape(-1, n_low))


_Part = tuple[CellBatch, DivergenceFree, Ints, Ints]


def _parts(space: Space) -> Iterator[_Part]:
    """Batches with their reconstruction and the numbers of velocities (n_local, n_cells) and pressures.

    Unknowns are numbered: velocities at nodes, moments inside cells, then pressures.
    """
    n_nodes, n_cells, n_low = space.n_nodes, space.mesh.n_cells, n_monomials(space.order - 1)
    n_inside = n_low - 1 + n_monomials(space.order - 3)
    for batch in space.batches():
        nodal = component_dofs(batch.outer_dofs, 2)
        inside = 2 * n_nodes + n_inside * batch.cells + np.arange(n_inside)[:, None]
        pressures = 2 * n_nodes + n_inside * n_cells + n_low * batch.cells + np.arange(n_low)[:, None]
        yield batch, divergence_free(space.order, batch.vertices), np.concatenate((nodal, inside)), pressures


def stokes_matrix(space: Space, viscosity: float = 1.0, bulk_modulus: float = np.inf) -> sp.csr_array:
    """Matrix of `stokes` on all unknowns, symmetric: velocities at nodes, moments inside cells, pressures."""
    return _assembled(list(_parts(space)), viscosity, bulk_modulus)


def _assembled(parts: list[_Part], viscosity: float, bulk_modulus: float) -> sp.csr_array:
    size = 1 + max(int(pressures.max()) for *_, pressures in parts)
    matrices, constant = [], np.zeros((size, 2))
    for _, cells, numbers, pressures in parts:
        n_low, n = len(pressures), len(numbers)
        powers = exponents(HIGHEST_ORDER)[:n_low]
        mass = cells.moments[index(powers[:, None] + powers)]
        strain = (cells.gradient + cells.gradient.swapaxes(1, 2)) / 2.0
        whole = np.zeros((n + n_low, n + n_low, numbers.shape[1]))
        whole[:n, :n] = viscosity * cells.missed
        for i, j in np.ndindex(2, 2):
            weighted = np.einsum("abe,bme->ame", 2.0 * viscosity * mass, strain[:, i, j])
            whole[:n, :n] += batched.symmetric_product(strain[:, i, j], weighted)
        whole[n:, :n] = -cells.divergence
        whole[:n, n:] = -cells.divergence.swapaxes(0, 1)
        whole[n:, n:] = -mass / bulk_modulus
        both = np.concatenate((numbers, pressures))
        matrices.append((both, both, whole))
        constant[numbers] = cells.constant.swapaxes(1, 2)
    return FormMatrix.measured(scattered(matrices, (size, size)), constant)
