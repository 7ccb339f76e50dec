"""Forms written as functions of values and gradients at points, and their arrays on any space."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from flangeway.elements import Function, Reconstruction, missed_mass, monomials
from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, joined_columns
from flangeway.post.stress import cells_of, polynomials_at
from flangeway.problems.elasticity_problem import add_consistency, strain_operators
from flangeway.problems.loads import EdgeQuadrature, edge_quadrature
from flangeway.space import CellBatch, CellCoefficient, Coefficient, FormMatrix, Space, load_vector
from flangeway.space.functions import function_of, quadrature_degree
from flangeway.space.spaces import component_dofs
from flangeway.space.symmetric import over_last_bit
from flangeway.types import Floats, Indices, floats

# --- Forms written as functions of values and gradients at points: any bilinear, linear and nonlinear form.
#
# A form ``form(u, v, w)`` gets three records of arrays at points: of the unknown u, of the test function v, and w with
# ``w.points`` (n, 2), along edges ``w.normals`` (n, 2), and further fields by their names. ``u.value`` has the shape
# (n,) or (n, m), ``u.gradient`` (n, 2) or (n, m, 2), derivatives last. It returns the integrand, (n,).


Values = NDArray[np.inexact]
JETS = 3
"""Numbers of one component at a point on which a form may depend: the value and two derivatives."""


@dataclass(frozen=True, eq=False)
class PointValues:
    """A field at points: ``value`` (n,) or (n, m), and ``gradient`` (n, 2) or (n, m, 2), derivatives last."""

    value: Values
    gradients: Values | None = None

    @property
    def gradient(self) -> Values:
        """The gradient; an `InputError` along edges, where virtual functions have none."""
        if self.gradients is None:
            raise InputError(
                "a form along edges that takes a gradient", "forms of values", "integrate gradients over cells"
            )
        return self.gradients


@dataclass(frozen=True, eq=False)
class Field:
    """A discrete function: unknowns of a space, and its values anywhere.

    Parameters
    ----------
    space
        The space.
    dofs
        Unknowns, (n_dofs,) or (n_dofs, m), real or complex.

    """

    space: Space
    dofs: Values

    def __post_init__(self) -> None:
        if self.dofs.shape[:1] != (self.space.n_dofs,) or self.dofs.ndim > 2:
            raise InputError(
                f"unknowns of shape {self.dofs.shape} for a space with {self.space.n_dofs}",
                "shape (n_dofs,) or (n_dofs, m)",
                "use the space of the solution",
            )

    def at(self, points: ArrayLike) -> Values:
        """Values at points (n, 2), shape (n,) or (n, m): those of the projection of a virtual function.

        An `InputError` if a point lies outside of the mesh.
        """
        return self._evaluated(points, 0, ())

    def gradient_at(self, points: ArrayLike) -> Values:
        """Gradients at points (n, 2), shape (n, 2) or (n, m, 2), derivatives last."""
        return self._evaluated(points, 1, (2,))

    def at_quadrature(self, degree: int | None = None) -> tuple[Floats, Floats, PointValues]:
        """Points (n, 2) of quadrature in all cells, weights (n,), and the field there; degree ``2 k + 2`` by default.

        The integral of a function of the field is the sum of weights times its values.
        """
        degree = quadrature_degree(self.space) if degree is None else degree
        parts = []
        for batch in self.space.batches():
            points, weights = batch.quadrature(degree)
            values = self.on(batch, points)
            parts.append((points.swapaxes(1, 2).reshape(-1, 2), weights.ravel(), values.value, values.gradient))
        points, weights, value, gradient = joined_columns(parts)
        return points, weights, PointValues(value, gradient)

    def on(self, batch: CellBatch, points: Floats) -> PointValues:
        """Values at points (n_points, 2, n_cells) of cells, points of one number in all cells after each other."""
        same_batch = self.space.batch_like(batch)
        jets = evaluated(local_functions(same_batch, points), self.dofs.reshape(len(self.dofs), -1)[same_batch.dofs])
        return _point_values(jets.reshape(JETS, -1, jets.shape[-1]), self.dofs.ndim == 1)

    def along(self, pairs: Indices, n_points: int) -> PointValues:
        """Values at Gauss points of edges, points of one number on all edges after each other."""
        rule = edge_quadrature(self.space, pairs, n_points)
        value = np.einsum("qm,em...->qe...", rule.shapes, self.dofs[rule.nodes])
        return PointValues(value.reshape(-1, *self.dofs.shape[1:]))

    def _evaluated(self, points: ArrayLike, derivative: int, tail: tuple[int, ...]) -> Values:
        cells = cells_of(self.space.mesh, points, "the mesh")
        given = np.asarray(points, dtype=np.float64)
        if np.iscomplexobj(self.dofs):
            real, imaginary = (Field(self.space, part) for part in (self.dofs.real, self.dofs.imag))
            return real._evaluated(points, derivative, tail) + 1j * imaginary._evaluated(points, derivative, tail)
        dofs = self.dofs.reshape(len(self.dofs), -1)
        count = dofs.shape[1] * int(np.prod(tail))

        def polynomials(batch: CellBatch) -> tuple[Reconstruction, Floats]:
            reconstruction = batch.reconstruction
            coefficients = reconstruction.gradient if derivative else reconstruction.projected_value
            combined = np.einsum("a...me,mec->c...ae", coefficients, dofs[batch.dofs])
            return reconstruction, combined.reshape(count, combined.shape[-2], -1)

        values = polynomials_at(self.space, given, cells, polynomials, count)
        return values.reshape(len(given), *self.dofs.shape[1:], *tail)


Functions = list[tuple[Floats, Floats]]
"""Local functions at points: of the value and of each derivative polynomials (p, q, e) and coefficients (p, n, e)."""


def local_functions(batch: CellBatch, points: Floats) -> Functions:
    """Value and two derivatives of the local functions at points (q, 2, e), by monomials."""
    reconstruction = batch.reconstruction
    energetic = reconstruction.for_energy
    values = monomials.evaluate(max(reconstruction.order, energetic.order - 1), reconstruction.frame.local(points))
    coefficients = reconstruction.projected_value, *energetic.gradient.swapaxes(0, 1)
    return [(values[: len(coefficient)], coefficient) for coefficient in coefficients]


def evaluated(functions: Functions, dofs: Values) -> Values:
    """Sums of local functions times unknowns (n, e, c), shape (number of jets, q, e, c)."""
    return np.array(
        [np.einsum("pqe,pec->qec", at, np.einsum("pne,nec->pec", shapes, dofs)) for at, shapes in functions]
    )


def integrals(functions: Functions, fields: Values) -> Values:
    """Sums over points of fields (number of jets, q, e), times weights, times local functions, (n, e)."""
    parts = zip(functions, fields, strict=True)
    return np.asarray(
        sum(np.einsum("pne,pe->ne", shapes, np.einsum("pqe,qe->pe", at, field)) for (at, shapes), field in parts)
    )


def _products(tests: Functions, weighted: Values, functions: Functions) -> NDArray[Any]:
    """Sums over points of test functions times fields (m', jets, m, jets, q, e) times functions, (n', m', n, m, e)."""
    m_test, _, m, _, _, n_cells = weighted.shape
    n_test, n = (side[0][1].shape[1] for side in (tests, functions))
    symmetric = tests is functions and np.array_equal(weighted, weighted.transpose(2, 3, 0, 1, 4, 5))
    result = np.zeros((n_test, m_test, n, m, n_cells), dtype=weighted.dtype)
    for i, x, j, y in np.argwhere(weighted.any(axis=(-2, -1))):
        if symmetric and (j, y) < (i, x):
            continue
        (left, rows), (right, columns) = tests[x], functions[y]
        block = between(rows, np.einsum("pqe,rqe->pre", left, right * weighted[i, x, j, y]), columns)
        if symmetric and (i, x) == (j, y):  # each half of it once more
            block = block / 2.0
        result[:, i, :, j] += block
        if symmetric:
            result[:, j, :, i] += block.swapaxes(0, 1)
    return result


def _point_values(jets: Values, scalar: bool) -> PointValues:
    """Record of value and derivatives (3, n, m)."""
    value, gradient = jets[0], np.moveaxis(jets[1:], 0, -1)
    return PointValues(value[:, 0], gradient[:, 0]) if scalar else PointValues(value, gradient)


def between(left: Floats, matrices: Any, right: Floats) -> Any:
    """``L^T A R`` of each cell: functions' coefficients (p, n, n_cells), matrices (p, p, n_cells)."""
    return np.einsum("pme,pne->mne", left, np.einsum("pqe,qne->pne", matrices, right))


def value_products(reconstruction: Reconstruction) -> Floats:
    """Integrals of products of values and of what projections miss of them, (n_local, n_local, n_cells)."""
    value, mass = reconstruction.projected_value, monomials.mass(reconstruction.order, reconstruction.moments)
    projected: Floats = between(value, mass, value)
    return projected + missed_mass(reconstruction) if is_stabilised(reconstruction) else projected


def is_stabilised(reconstruction: Reconstruction) -> bool:
    """Whether products of values get what projections miss."""
    return not reconstruction.exact and reconstruction.for_energy is reconstruction


def products_round_off(reconstruction: Reconstruction, products: Floats, constant: Floats) -> Floats:
    """Round-off of `value_products` over the last bit, from those of unknowns (n_local, n_cells) of a constant.

    They are integrals of the local functions, of which the first moment inside is one. Shape (n_local, n_cells).
    """
    n_inner, known = reconstruction.n_interior, reconstruction.value_moments
    if reconstruction.exact or reconstruction.order < 3 or not n_inner:  # no projection is solved for, or none known
        return np.ones_like(constant)
    errors = np.einsum("mne,ne->me", products, constant)
    if known is None:
        errors[-n_inner:] -= reconstruction.inner_moments[0]
    else:
        errors -= known[0]
    return over_last_bit(errors, np.einsum("mne,ne->me", np.abs(products), np.abs(constant)))


def unit_fields(n: int, m: int, n_jets: int) -> list[PointValues]:
    """Fields at n points whose value or derivative of one component is one, the others zero; component by component."""
    result = []
    for component in range(m):
        for jet in range(n_jets):
            jets = np.zeros((JETS, n, m))
            jets[jet, :, component] = 1.0
            whole = _point_values(jets, m == 1)
            result.append(whole if n_jets == JETS else PointValues(whole.value))
    return result


class NotFiniteError(InputError):
    """A form that is not finite somewhere."""


def integrand(values: ArrayLike, n: int) -> Values:
    """Values of a form at n points, checked."""
    result, allowed = np.asarray(values), f"({n},) finite numbers: one for each of the points"
    if result.shape not in ((), (n,)):
        raise InputError(f"a form with an integrand of shape {result.shape}", allowed, "sum over components, axis=-1")
    if not np.isfinite(result).all():
        raise NotFiniteError("a form that is not finite", allowed, "change it, or its first unknowns")
    return np.broadcast_to(result, (n,))


Form = Callable[[PointValues, PointValues, SimpleNamespace], ArrayLike]
LinearForm = Callable[[PointValues, SimpleNamespace], ArrayLike]
EdgeSet = str | Indices
"""Name of an edge set, or pairs of points (n, 2)."""


class FormRegion:
    """Cells or edges over which a form is integrated: points, weights, given fields and local functions by batches."""

    def __init__(
        self, spaces: tuple[Space, Space], fields: Mapping[str, Field], on: EdgeSet | None, degree: int | None
    ) -> None:
        mesh = spaces[0].mesh
        for other in (spaces[1].mesh, *(field.space.mesh for field in fields.values())):
            same = np.array_equal(mesh.points, other.points) and np.array_equal(mesh.cell_points, other.cell_points)
            if not same:
                raise InputError("spaces of different meshes in one form", "one mesh", "make the spaces on one mesh")
        self.spaces, self.fields, self.on = spaces, fields, on
        self.degree = max(quadrature_degree(space) for space in spaces) if degree is None else degree
        self.chosen = degree is not None
        self.n_jets = JETS if on is None else 1

    def parts(self) -> Any:
        """For each batch: what forms get as w, weights (q, e), and for both spaces local functions and unknowns."""
        trial, test = self.spaces
        if self.on is not None:
            pairs = trial.mesh.edge_set(self.on) if isinstance(self.on, str) else np.asarray(self.on)
            n_points = self.degree // 2 + 1
            rules = [edge_quadrature(space, pairs, n_points) for space in self.spaces]
            given = {name: field.along(pairs, n_points) for name, field in self.fields.items()}
            points, normals = (a.swapaxes(0, 1).reshape(-1, 2) for a in (rules[0].points, rules[0].normals))
            w = SimpleNamespace(points=points, normals=normals, **given)
            yield w, rules[0].weights.T, [_edge_functions(rule) for rule in rules], None
            return
        for batch in trial.batches():
            degree = self.degree
            if not self.chosen:  # products of gradients, which elements without stabilisation have of higher degree
                degree = max(degree, 2 * (batch.reconstruction.for_energy.order - 1))
            points, weights = batch.quadrature(degree)
            w = SimpleNamespace(
                points=points.swapaxes(1, 2).reshape(-1, 2),
                **{name: field.on(batch, points) for name, field in self.fields.items()},
            )
            batches = [batch] if test is trial else [batch, test.batch_like(batch)]
            functions = [(local_functions(batch, points), batch.dofs) for batch in batches]
            yield w, weights, (functions * 2)[:2], batch


def _edge_functions(rule: EdgeQuadrature) -> tuple[Functions, IntArray]:
    n, n_edges = rule.shapes.shape[1], len(rule.nodes)
    at = np.broadcast_to(rule.shapes.T[:, :, None], (*rule.shapes.T.shape, n_edges))
    return [(at, np.broadcast_to(np.eye(n)[:, :, None], (n, n, n_edges)))], rule.nodes.T


def bilinear(
    space: Space,
    form: Form,
    *,
    components: int = 1,
    test: Space | None = None,
    test_components: int | None = None,
    on: EdgeSet | None = None,
    fields: Mapping[str, Field] | None = None,
    degree: int | None = None,
    stabilise: bool = True,
) -> sp.csr_array:
    """Assemble ``integral of form(u, v, w)``, linear in u and in v.

    It need not be symmetric, may be complex, and may depend on the place and on other fields: convection is
    ``(beta * u.gradient).sum(axis=-1) * v.value``, with ``fields={"old": Field(space, dofs)}`` a coefficient is a
    function of ``w.old.value``. Values and gradients of virtual functions are projections. What these miss is
    stabilised as in `stiffness` and `mass`, with the parts of the form that multiply gradients with gradients and
    values with values.

    Parameters
    ----------
    space
        Space of the unknown u.
    form
        Integrand, see `flangeway.forms.weak`.
    components
        Number of components of u; one makes arrays without this axis.
    test
        Space of v on the same mesh, of any order (mixed methods); None takes that of u.
    test_components
        Number of components of v; None takes that of u.
    on
        Integrals along edges, of values only: the name of an edge set, or directed pairs of points (n, 2), which may
        lie inside the mesh (interfaces).
    fields
        Further fields by the names that the form reads.
    degree
        Degree of the quadrature, ``2 k + 2`` by default.
    stabilise
        False leaves out what projections miss, as for a geometric stiffness.

    Returns
    -------
    scipy.sparse.csr_array
        Rows of v, columns of u: shape (m' n_dofs', m n_dofs).

    Raises
    ------
    InputError
        If the integrand is not a finite number for each point, or spaces have different meshes.

    """
    other = space if test is None else test
    m, m_test = components, components if test_components is None else test_components
    stabilise = stabilise and on is None and other is space and m == m_test
    region = FormRegion((space, other), fields or {}, on, degree)

    def tensor(w: SimpleNamespace) -> Values:
        n = len(w.points)
        trials, tests = (unit_fields(n, number, region.n_jets) for number in (m, m_test))
        return np.array([[integrand(form(u, v, w), n) for u in trials] for v in tests])

    return assembled_form(region, tensor, m, m_test, stabilise)


def assembled_form(
    region: FormRegion, tensor: Callable[[SimpleNamespace], Values], m: int, m_test: int, stabilise: bool
) -> sp.csr_array:
    """Assemble what multiplies the numbers of v (rows) and u at each point, (3 m', 3 m, n)."""
    trial, test = region.spaces
    jets, parts = region.n_jets, []
    forces = np.zeros((test.n_dofs, m_test))  # maximum ones of the gradients of constants, which are round-off
    least = np.ones((test.n_dofs, m_test))  # round-off of products of values
    for w, weights, ((functions, dofs), (tests, test_dofs)), batch in region.parts():
        weighted = tensor(w).reshape(m_test, jets, m, jets, *weights.shape) * weights
        local = _products(tests, weighted, functions)
        constant = trial.constant[dofs]
        slopes = evaluated(functions, constant[..., None])[1:, ..., 0]
        for i, j in np.ndindex(m_test, m):
            stresses = np.einsum("xyqe,yqe->xqe", weighted[i, :, j, 1:], slopes)
            np.add.at(forces, (test_dofs, i), np.abs(integrals(tests, stresses)))
        if test is trial and batch is not None and weighted[:, 0, :, 0].any():
            reconstruction = batch.reconstruction
            np.maximum.at(
                least, dofs, products_round_off(reconstruction, value_products(reconstruction), constant)[..., None]
            )
        if stabilise:
            added = np.zeros_like(local)
            _add_stabilisation(added, weighted, functions, batch)
            local += added
            np.add.at(forces, test_dofs, np.abs(np.einsum("minje,ne->mei", added, constant)))
        rows, columns = component_dofs(test_dofs, m_test), component_dofs(dofs, m)
        parts.append((rows, columns, local.reshape(len(rows), len(columns), -1)))
    matrix = scattered(parts, (m_test * test.n_dofs, m * trial.n_dofs))
    return FormMatrix.measured(matrix, np.repeat(trial.constant, m), forces.ravel(), least.ravel())


def scattered(parts: Iterable[tuple[Indices, Indices, Values]], shape: tuple[int, int]) -> sp.csr_array:
    """Add up matrices of batches of cells: numbers of rows (n, n_cells) and columns (m, n_cells), (n, m, n_cells)."""
    rows, columns, entries = [], [], []
    for row, column, local in parts:
        rows.append(np.broadcast_to(row[:, None], local.shape).ravel())
        columns.append(np.broadcast_to(column, local.shape).ravel())
        entries.append(local.ravel())
    coordinates = np.concatenate(rows), np.concatenate(columns)
    return sp.csr_array((np.concatenate(entries), coordinates), shape=shape)


def _add_stabilisation(local: Values, weighted: Values, functions: Functions, batch: CellBatch) -> None:
    """Add stiffness and mass of what projections miss, with the sign of the form's parts, real and imaginary."""
    reconstruction = batch.reconstruction
    if reconstruction.exact:
        return
    m, slopes = local.shape[1], functions[1:]
    parts = [(1.0, weighted.real)] + ([(1j, weighted.imag)] if np.iscomplexobj(weighted) else [])
    for unit, blocks in parts:
        gradients = blocks[:, 1:, :, 1:]
        trace = np.einsum("iaiaqe->", gradients)
        if trace != 0.0:
            sign = np.sign(trace)
            symmetric = 0.5 * sign * (gradients + gradients.transpose(2, 3, 0, 1, 4, 5))
            consistency = _products(slopes, symmetric, slopes).transpose(1, 3, 0, 2, 4)
            added = batch.element.stabilise(reconstruction, consistency)
            for i in range(m if added is not None else 0):
                local[:, i, :, i] += unit * sign * added
        if blocks[:, 0, :, 0].any() and is_stabilised(reconstruction):
            # mean over the cell of what multiplies values
            mean = blocks[:, 0, :, 0].sum(axis=2) / reconstruction.areas
            missed = missed_mass(reconstruction)
            for i, j in np.ndindex(m, m):
                local[:, i, :, j] += unit * missed * mean[i, j]


def stabilisation_matrix(region: FormRegion, tensor: Callable[[SimpleNamespace], Values], m: int) -> sp.csr_array:
    """Stabilisation alone of `assembled_form`, one space for both, shape (m n_dofs, m n_dofs)."""
    parts = []
    for w, weights, ((functions, dofs), _), batch in region.parts():
        local = np.zeros((dofs.shape[0], m, dofs.shape[0], m, dofs.shape[1]))
        if not batch.reconstruction.exact:
            weighted = tensor(w).reshape(m, JETS, m, JETS, *weights.shape) * weights
            _add_stabilisation(local, weighted, functions, batch)
        numbers = component_dofs(dofs, m)
        parts.append((numbers, numbers, local.reshape(len(numbers), len(numbers), -1)))
    n = m * region.spaces[0].n_dofs
    return scattered(parts, (n, n))


def linear(
    space: Space,
    form: LinearForm,
    *,
    components: int = 1,
    on: EdgeSet | None = None,
    fields: Mapping[str, Field] | None = None,
    degree: int | None = None,
) -> Values:
    """Assemble ``integral of form(v, w)``, linear in v; arguments as of `bilinear`.

    Returns
    -------
    Floats or complex numbers
        Shape (n_dofs,), or (n_dofs, m) for more components than one.

    """
    region = FormRegion((space, space), fields or {}, on, degree)

    def vector(w: SimpleNamespace) -> Values:
        n = len(w.points)
        return np.array([integrand(form(v, w), n) for v in unit_fields(n, components, region.n_jets)])

    return assembled_vector(region, vector, components)


def assembled_vector(region: FormRegion, vector: Callable[[SimpleNamespace], Values], m: int) -> Values:
    """Assemble what multiplies the numbers of v at each point, (3 m, n)."""
    result: Values | None = None
    for w, weights, (_, (functions, dofs)), _ in region.parts():
        fields = vector(w).reshape(m, region.n_jets, *weights.shape) * weights
        local = np.stack([integrals(functions, field) for field in fields], axis=-1)
        if result is None or (np.iscomplexobj(local) and not np.iscomplexobj(result)):
            result = np.zeros((region.spaces[1].n_dofs, m), dtype=local.dtype) + (0.0 if result is None else result)
        np.add.at(result, dofs, local)
    assert result is not None  # a mesh has a cell
    return result[:, 0] if m == 1 else result


# --- Bilinear and linear forms on any space as SciPy arrays.
#
# Unknowns of a field of m components are numbered ``m * dof + component``: arrays (n_dofs, m), row by row.


def stiffness(space: Space, coefficient: Coefficient = 1.0, *, degree: int | None = None) -> sp.csr_array:
    """Integrals of ``grad v : C : grad u``.

    Gradients of virtual functions are their L2 projections onto polynomials of degree k - 1, which keeps the order for
    coefficients that vary (Beirao da Veiga, Brezzi, Marini and Russo, 2016, "Virtual element method for general
    second-order elliptic problems on polygonal meshes"); the element's stabilisation is added.

    Parameters
    ----------
    space
        The space.
    coefficient
        A number, or a matrix (2, 2) for anisotropy: one field. A matrix (3, 3) of plane elasticity, stresses xx, yy, xy
        per strain xx, yy, 2 xy: a displacement. Any tensor (m, 2, m, 2), such as ``Elastic(...).stiffness``: m fields.
        The same for each cell (one more axis in front), by the names of cell sets, or as a function of points (n, 2)
        with one more axis in front. Symmetric and positive.
    degree
        Degree of the quadrature with a function, ``2 k + 2`` by default.

    Returns
    -------
    scipy.sparse.csr_array
        Shape (m n_dofs, m n_dofs).

    Raises
    ------
    InputError
        If the coefficient has another shape, is not symmetric or not positive.

    """
    given = CellCoefficient.on(space, coefficient, "gradients")
    if given.function is not None:
        return _at_points(given, None, degree)

    def matrices(batch: CellBatch, reconstruction: Reconstruction, blocks: Floats) -> Floats | None:
        strains = strain_operators(batch, reconstruction.for_energy, axisymmetric=False)
        add_consistency(blocks, given.at(batch, np.empty((1, 2, 0)))[..., 0, :], strains)
        return batch.element.stabilise(reconstruction, blocks)

    matrix = _assembled(space, given.n_components, matrices)
    return FormMatrix.measured(matrix, np.repeat(space.constant, given.n_components))


def mass(
    space: Space, coefficient: Coefficient = 1.0, *, on: str | None = None, degree: int | None = None
) -> sp.csr_array:
    """Integrals of ``v . c u``: mass, reaction, or springs along edges.

    Values of virtual functions inside cells are their L2 projections (Ahmad et al., 2013, "Equivalent projectors for
    virtual element methods"); what these miss is added with equal shares of the area, but for elements without
    stabilisation: the energy of what is missed may be near zero there, and such motions would be slow modes.

    Parameters
    ----------
    space
        The space.
    coefficient
        A number for one field, or a symmetric matrix (m, m) for m components; the same for each cell, by the names of
        cell sets, or as a function, see `stiffness`.
    on
        Name of an edge set: integrals along it, of a coefficient that is the same everywhere or a function.
    degree
        Degree of the quadrature with a function, ``2 k + 2`` by default.

    Returns
    -------
    scipy.sparse.csr_array
        Shape (m n_dofs, m n_dofs).

    Raises
    ------
    InputError
        If the coefficient has another shape or is not symmetric.

    """
    given = CellCoefficient.on(space, coefficient, "values")
    if on is not None and given.values is not None and len(given.values) > 1:
        raise InputError("a coefficient of cells along edges", "a number, a matrix or a function", "give one of these")
    if on is not None or given.function is not None:
        return _at_points(given, on, degree)
    round_off = np.ones(space.n_dofs)

    def matrices(batch: CellBatch, reconstruction: Reconstruction, blocks: Floats) -> None:
        products = value_products(reconstruction)
        of_cells = products_round_off(reconstruction, products, space.constant[batch.dofs])
        np.maximum.at(round_off, batch.dofs, of_cells)
        tensor = given.at(batch, np.empty((1, 2, 0)))[..., 0, :]
        for i, j in np.argwhere(np.abs(tensor).any(axis=-1)):
            blocks[i, j] = products * tensor[i, j]

    matrix = _assembled(space, given.n_components, matrices)  # fills the round-off too
    return FormMatrix(matrix, round_off=np.repeat(round_off, given.n_components))


def _at_points(given: CellCoefficient, on: str | None, degree: int | None) -> sp.csr_array:
    """Integrals by values of the coefficient at points of cells or edges."""
    m, region = given.n_components, FormRegion((given.space, given.space), {}, on, degree)

    def tensor(w: SimpleNamespace) -> Floats:
        values = given.along(w.points)
        whole = np.zeros((m, region.n_jets, m, region.n_jets, len(w.points)))
        if values.ndim == 3:
            whole[:, 0, :, 0] = values
        else:
            whole[:, 1:, :, 1:] = values
        return whole.reshape(m * region.n_jets, m * region.n_jets, -1)

    return assembled_form(region, tensor, m, m, on is None)


def _assembled(
    space: Space, m: int, matrices: Callable[[CellBatch, Reconstruction, Floats], Floats | None]
) -> sp.csr_array:
    """Add up matrices of cells, whose blocks of components a function fills, returning what is added to each field."""

    def of_cells(batch: CellBatch) -> Floats:
        reconstruction = batch.reconstruct()
        n = reconstruction.n_local
        result = np.zeros((n, m, n, m, len(batch.cells)))
        blocks = result.transpose(1, 3, 0, 2, 4)
        added = matrices(batch, reconstruction, blocks)
        if added is not None:
            for i in range(m):
                blocks[i, i] += added
        return result.reshape(m * n, m * n, -1)

    return space.assemble(of_cells, m).full()


def load(space: Space, function: Function | ArrayLike, *, on: str | None = None, degree: int | None = None) -> Floats:
    """Integrals of ``v . f`` over the cells, or along edges (a flux or a traction).

    Parameters
    ----------
    space
        The space.
    function
        Function of points (n, 2) with values (n,), or (n, m) for m components; or a number, or m numbers.
    on
        Name of an edge set; None takes the cells.
    degree
        Degree of the quadrature over cells, ``2 k + 2`` by default.

    Returns
    -------
    Floats
        Shape (n_dofs,) or (n_dofs, m).

    """
    given = function_of("a load", function)
    if on is None:
        return load_vector(space, given, degree)
    shape = np.shape(given(space.nodes[:1]))[1:]
    m = int(np.prod(shape, dtype=np.int64))

    def traction(v: PointValues, w: SimpleNamespace) -> Floats:
        return (np.reshape(given(w.points), (-1, m)) * v.value.reshape(-1, m)).sum(axis=1)

    return floats(linear(space, traction, components=m, on=on)).reshape(-1, *shape)
