"""Solution of one's own forms: linear systems, eigenproblems, steps in time, Newton's method, rates of convergence."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from flangeway.checks import MIN_POSITIVE, as_numbers, check_between, check_integer, check_positive
from flangeway.errors import InputError
from flangeway.forms.weak import (
    JETS,
    Field,
    Form,
    FormRegion,
    NotFiniteError,
    PointValues,
    Values,
    assembled_form,
    assembled_vector,
    integrand,
    stabilisation_matrix,
    unit_fields,
)
from flangeway.geometry.arrays import max_magnitude
from flangeway.mesh import PolyMesh
from flangeway.post import ErrorNorms
from flangeway.results import ResultTable
from flangeway.solve.linear import Factor, finite_numbers
from flangeway.solve.status import Status
from flangeway.space import Space
from flangeway.types import Bools, Floats, Indices

# --- Solution of linear systems and eigenproblems of forms, through one kept factorisation.


MAX_EIGEN_RESIDUAL = 1e-9
"""Residual of eigenvectors relative to the magnitudes of its terms, above their round-off."""
EIGEN_SHIFT = 1e-6
"""Shift of eigenvalues relative to the ratio of the traces, so that free bodies are no exception."""


class Unknowns(Protocol):
    """What eigenproblems ask of a `Space`, a `Plate` or an element of your own."""

    @property
    def n_dofs(self) -> int: ...  # noqa: D102


def solve(
    matrix: sp.sparray, load: ArrayLike, fixed: Indices | Bools | None = None, values: ArrayLike = 0.0
) -> NDArray[Any]:
    """Solve a linear system with some unknowns prescribed; `Factor` keeps the factorisation for more solutions.

    Parameters
    ----------
    matrix
        Sum of forms, shape (m n_dofs, m n_dofs), symmetric or not, real or complex.
    load
        Right-hand side, shape (n_dofs,) or (n_dofs, m).
    fixed
        Unknowns of one field that are prescribed, see `Space.boundary_dofs`: all their components. Or truth values of
        the load's shape.
    values
        Their values: a number, or an array of the load's shape, such as from `interpolate`; others are ignored.

    Returns
    -------
    Floats, or complex numbers if the matrix, the load or a value is complex
        All unknowns, shape of the load.

    Raises
    ------
    InputError
        If the matrix does not fit the load, or is singular: the message names the motion without energy.

    Warns
    -----
    scipy.linalg.LinAlgWarning
        If fewer than four digits of the solution are right.

    """
    given = finite_numbers("a load", load)
    if given.ndim not in (1, 2):
        raise InputError(f"a load of shape {given.shape}", "(n_dofs,) or (n_dofs, m)", "take load(space, ...)")
    return Factor(matrix, fixed, 1 if given.ndim == 1 else given.shape[1]).solve(given, values)


def modes(
    space: Unknowns,
    stiffness: sp.sparray,
    mass: sp.sparray,
    number: int = 6,
    fixed: Indices | Bools | None = None,
) -> tuple[Floats, Floats]:
    """Lowest eigenvalues of ``K u = lambda M u``: free vibration with the angular frequencies ``sqrt(lambda)``.

    Parameters
    ----------
    space
        The space, or a `Plate`.
    stiffness, mass
        Symmetric, the mass positive; see `stiffness` and `mass`.
    number
        Number of eigenvalues.
    fixed
        Unknowns that are zero, see `solve`.

    Returns
    -------
    tuple of Floats
        Eigenvalues (number,) in rising order, and modes (number, n_dofs) or (number, n_dofs, m), ``u . M u = 1``.

    Raises
    ------
    InputError
        If a matrix is complex or not symmetric, or the mass not positive.

    """
    shift = -EIGEN_SHIFT * stiffness.trace() / mass.trace()
    free, inverse, parts = _reduced(space, stiffness - shift * mass, (stiffness, mass), fixed, number, "modes")
    values, vectors = eigsh(
        parts[0], number, parts[1], sigma=shift, OPinv=inverse, v0=np.ones(len(parts[0].indptr) - 1)
    )
    _check_residuals(parts[0], parts[1], values, vectors)
    return _sorted(values, vectors, free, space)


def buckling(
    space: Unknowns,
    stiffness: sp.sparray,
    geometric: sp.sparray,
    number: int = 1,
    fixed: Indices | Bools | None = None,
) -> tuple[Floats, Floats]:
    """Lowest positive load factors of ``(K + lambda G) u = 0``: linear buckling.

    Parameters
    ----------
    space
        The space, or a `Plate`.
    stiffness
        Symmetric and, with the fixed unknowns, positive definite.
    geometric
        Geometric stiffness of the reference load, symmetric: of a stress sigma the form
        ``grad v_i : sigma : grad u_i``, negative under pressure; see `bilinear`.
    number
        Number of load factors.
    fixed
        Unknowns that are zero, see `solve`.

    Returns
    -------
    tuple of Floats
        Load factors (number,) in rising order, and modes with ``u . K u = 1``, shape as of `modes`.

    Raises
    ------
    InputError
        If the stiffness is singular, a matrix complex or not symmetric, or fewer load factors are positive.

    """
    given = stiffness, -1.0 * geometric
    free, inverse, (elastic, destabilising) = _reduced(space, stiffness, given, fixed, number, "buckling")
    start = np.random.default_rng(0).standard_normal(elastic.shape[0])
    # -G u = mu K u with mu = 1 / lambda: the largest mu first
    inverse_factors, vectors = eigsh(destabilising, number, elastic, Minv=inverse, which="LA", v0=start)
    if not inverse_factors.min() > 0.0:
        raise InputError(
            f"a geometric stiffness with {int((inverse_factors > 0.0).sum())} positive load factors of {number}",
            "stresses with as much pressure as buckling needs",
            "check the sign of the load, or ask for fewer",
        )
    _check_residuals(destabilising, elastic, inverse_factors, vectors)
    return _sorted(1.0 / inverse_factors, vectors, free, space)


def _reduced(
    space: Unknowns,
    factored: sp.sparray,
    matrices: tuple[sp.sparray, sp.sparray],
    fixed: Indices | Bools | None,
    number: int,
    where: str,
) -> tuple[Bools, LinearOperator, list[sp.csr_array]]:
    """Which unknowns are free, the inverse of a matrix on them, and matrices on them; checks the number of modes."""
    factor = Factor(factored, fixed, factored.shape[0] // space.n_dofs)
    check_integer(where, "number", number, 1, int(factor.free.sum()) - 1)
    parts = [sp.csr_array(matrix)[factor.free][:, factor.free] for matrix in matrices]
    inverse = LinearOperator(parts[0].shape, matvec=lambda x: factor.solve_free(np.ravel(x)), dtype=np.float64)
    return factor.free, inverse, parts


def _check_residuals(left: sp.csr_array, right: sp.csr_array, values: Floats, vectors: Floats) -> None:
    """Raise `InputError` unless ``left v = value right v``, as Lanczos' method finds of symmetric matrices only."""
    residuals = left @ vectors - (right @ vectors) * values
    terms = abs(left) @ np.abs(vectors) + (abs(right) @ np.abs(vectors)) * np.abs(values)
    if not (np.linalg.norm(residuals, axis=0) <= MAX_EIGEN_RESIDUAL * np.linalg.norm(terms, axis=0)).all():
        raise InputError(
            "an eigenproblem whose matrices are not real and symmetric, or whose mass is not positive",
            "symmetric matrices, a positive mass, and a positive stiffness for buckling",
            "take scipy.sparse.linalg.eigs for others",
        )


def _sorted(values: Floats, vectors: Floats, free: Bools, space: Unknowns) -> tuple[Floats, Floats]:
    order = np.argsort(values)
    result = np.zeros((len(values), len(free)))
    result[:, free] = vectors[:, order].T
    shape = (space.n_dofs,) if len(free) == space.n_dofs else (space.n_dofs, -1)
    return values[order], result.reshape(len(values), *shape)


# --- Equations in time, step by step with one kept factorisation: first order by theta, second by generalised alpha.


InTime = ArrayLike | Callable[[float], ArrayLike]
"""An array, or a function of the time that gives one."""


def theta_steps(
    mass: sp.sparray,
    stiffness: sp.sparray,
    start: ArrayLike,
    step: float,
    number: int,
    *,
    theta: float = 0.5,
    load: InTime = 0.0,
    fixed: Indices | Bools | None = None,
    values: InTime | None = None,
) -> Iterator[tuple[float, Values]]:
    """Integrate ``M u' + K u = f(t)``: yields the time and the unknowns after every step.

    ``(M + theta dt K) u1 = (M - (1 - theta) dt K) u0 + dt (theta f1 + (1 - theta) f0)``; 1/2 is Crank and Nicolson's
    method of second order, 1 the implicit Euler method.

    Parameters
    ----------
    mass, stiffness
        Matrices (m n_dofs, m n_dofs), symmetric or not, real or complex.
    start
        Unknowns at time zero, (n_dofs,) or (n_dofs, m), real or complex.
    step, number
        Length and number of the steps.
    theta
        From 1/2, without a limit of the step for stability, to 1.
    load
        Right-hand side, of the shape of ``start``, or a function of the time.
    fixed, values
        Prescribed unknowns and their values, which may be a function of the time; None keeps those of ``start``.

    Raises
    ------
    InputError
        If the step is not positive, theta out of its range, the start of another size, or the matrix singular.

    """
    (u,), m = _checked(step, number, mass, start)
    check_between("theta_steps", "theta", theta, 0.5, 1.0, advice="take 0.5 for second order")
    factor = Factor(mass + theta * step * stiffness, fixed, m)
    explicit = sp.csr_array(mass - (1.0 - theta) * step * stiffness)
    before = _at(load, 0.0, u)
    for i in range(number):
        time = (i + 1) * step
        after = _at(load, time, u)
        rhs = (explicit @ u.ravel()).reshape(u.shape) + step * (theta * after + (1.0 - theta) * before)
        u = factor.solve(rhs, u if values is None else _at(values, time, u))
        before = after
        yield time, u


def newmark_steps(
    mass: sp.sparray,
    stiffness: sp.sparray,
    start: ArrayLike,
    velocity: ArrayLike,
    step: float,
    number: int,
    *,
    damping: sp.sparray | None = None,
    radius: float | None = None,
    load: InTime = 0.0,
    fixed: Indices | Bools | None = None,
) -> Iterator[tuple[float, Values, Values]]:
    """Integrate ``M u'' + C u' + K u = f(t)``: yields time, unknowns and their velocities after every step.

    Newmark's method (1959) of average acceleration keeps the energy of a free vibration; the generalised alpha method
    (Chung and Hulbert, 1993, J. Appl. Mech. 60, eqs. 17, 18, 25) damps waves that the step does not resolve. Both are
    of second order and stable for any step.

    Parameters
    ----------
    mass, stiffness, damping
        Matrices (m n_dofs, m n_dofs), real or complex.
    start, velocity
        Unknowns and velocities at time zero, (n_dofs,) or (n_dofs, m), real or complex.
    step, number
        Length and number of the steps.
    radius
        Factor of the amplitude per step at infinite frequency, 0 to 1, of the generalised alpha method; None is
        Newmark's method.
    load
        Right-hand side, or a function of the time.
    fixed
        Unknowns that keep their values of ``start``.

    Raises
    ------
    InputError
        If the step is not positive, the radius out of its range, the start of another size, or a matrix singular.

    """
    (u, v), m = _checked(step, number, mass, start, velocity)
    if radius is not None:
        check_between("newmark_steps", "radius", radius, 0.0, 1.0, advice="leave it out for Newmark's method")
    of_mass, of_rest = (0.0, 0.0) if radius is None else ((2 * radius - 1) / (radius + 1), radius / (radius + 1))
    gamma, beta = 0.5 - of_mass + of_rest, 0.25 * (1.0 - of_mass + of_rest) ** 2
    shape = u.shape
    damping = sp.csr_array(mass.shape) if damping is None else damping
    implicit = (1.0 - of_mass) * mass + (1.0 - of_rest) * (gamma * step * damping + beta * step**2 * stiffness)
    factor = Factor(implicit, fixed, m)
    v = np.where(factor.free.reshape(shape), v, 0.0)

    def forces(displacements: Values, velocities: Values) -> Values:
        return np.asarray(stiffness @ displacements.ravel() + damping @ velocities.ravel()).reshape(shape)

    a = Factor(mass, fixed, m).solve(_at(load, 0.0, u) - forces(u, v))
    for i in range(number):
        time = (i + 1) * step
        at_load = _at(load, time - of_rest * step, u)
        predicted, rate = u + step * v + step**2 * (0.5 - beta) * a, v + step * (1.0 - gamma) * a
        inside = forces((1 - of_rest) * predicted + of_rest * u, (1 - of_rest) * rate + of_rest * v)
        a = factor.solve(at_load - inside - of_mass * (mass @ a.ravel()).reshape(shape))
        u, v = predicted + beta * step**2 * a, rate + gamma * step * a
        yield time, u, v


def _checked(step: float, number: int, mass: sp.sparray, *start: ArrayLike) -> tuple[list[Values], int]:
    """Arrays at time zero, real or complex, and their number of components."""
    check_positive("time steps", "step", step)
    check_integer("time steps", "number", number, 1)
    arrays: list[Values] = [np.asarray(given) for given in start]
    shapes = {array.shape for array in arrays}
    if len(shapes) > 1 or arrays[0].dtype.kind not in "iufc" or arrays[0].size != mass.shape[0] or arrays[0].ndim > 2:
        raise InputError(
            f"a mass of shape {mass.shape}, and a start of shape {' and '.join(map(str, shapes))}",
            "as many rows as the start has numbers: (n_dofs,) or (n_dofs, m)",
            "use the same space and the same number of components for all",
        )
    return arrays, 1 if arrays[0].ndim == 1 else arrays[0].shape[1]


def _at(given: InTime, time: float, like: Values) -> Values:
    return np.broadcast_to(np.asarray(given(time) if callable(given) else given), like.shape)


# --- Newton's method for one's own nonlinear forms.


UNKNOWN = "_unknown"
"""Name under which the current solution is evaluated with the given fields."""
COMPLEX_STEP = 1e-30
"""Imaginary increment of derivatives, relative to nothing: its square is below round-off of any number of a problem."""
DIFFERENCE = 1e-6
"""Increment of the differences that check a tangent, relative to the solution."""
MAX_TANGENT_ERROR = 1e-3
"""Difference of a tangent from that of differences, relative to its largest product, that round-off explains."""
SUFFICIENT_DECREASE = 1e-4
MAX_HALVINGS = 10
"""Step fractions down to 1/512; then the step is taken as it is and the iteration ends."""


@dataclass(frozen=True, eq=False)
class NewtonSolution:
    """Solution of a nonlinear problem: unknowns, whether they converged, and the residual norms of all iterations."""

    dofs: Floats
    status: Status
    residuals: tuple[float, ...]


def newton(
    space: Space,
    form: Form,
    start: ArrayLike,
    *,
    fixed: Indices | Bools | None = None,
    load: ArrayLike = 0.0,
    boundary: Mapping[str, Form] | None = None,
    fields: Mapping[str, Field] | None = None,
    tangent: Form | None = None,
    tolerance: float = 1e-10,
    max_iterations: int = 25,
    degree: int | None = None,
) -> NewtonSolution:
    """Solve ``integral of form(u, v, w) = load . v`` for all v, the form nonlinear in u and linear in v.

    Steps are halved until the norm of the residual falls. What projections of virtual elements miss is stabilised with
    the tangent at the current solution. The residual is that of this stabilisation, so the solution does not depend on
    ``start``; steps leave out how it changes, which is little where the mesh resolves the solution. A loop of its own:
    a form may have no value after a whole step, and its tangent, which the user writes, is checked on the way.

    Parameters
    ----------
    space
        The space.
    form
        Integrand over the cells, see `flangeway.forms.weak`.
    start
        First unknowns with the prescribed values, (n_dofs,) or (n_dofs, m); real.
    fixed
        Unknowns that keep the values of ``start``, see `solve`.
    load
        Further load of the shape of ``start``.
    boundary
        Forms along edge sets by their names, such as radiation.
    fields
        Further fields by names, as ``w.name``.
    tangent
        Integrand ``tangent(du, v, w)`` of the derivative, linear in du, with the current solution as ``w.u``. None:
        the derivative of the form at each point by complex steps, exact for forms of analytic functions. In the second
        iteration either is checked by differences of the residual.
    tolerance
        Norm of the residual of the free unknowns that ends it, relative to that of the first one or, if that is less,
        of the forces that balance in it.
    max_iterations
        Number of linear solutions.
    degree
        Degree of the quadrature, ``2 k + 2`` by default.

    Returns
    -------
    NewtonSolution
        Unknowns and status; without convergence the last ones.

    Raises
    ------
    InputError
        If the tangent is not the derivative or is singular at the start, or the start or the load is not real.

    """
    first = as_numbers("first unknowns", start, "real numbers")
    problem = _Problem(space, form, first, fields or {}, boundary or {}, tangent, degree)
    given = np.broadcast_to(as_numbers("a load", load, "real numbers"), first.shape)
    u, norms, failure = first.copy(), [], ""
    residual, matrix, stabilisation = problem.linearised(u)
    for iteration in range(max_iterations + 1):
        factor = Factor(matrix, fixed, problem.m)
        unbalanced = residual - given
        norms.append(float(np.linalg.norm(unbalanced.ravel()[factor.free])))
        # the forces of a first guess may be far larger than those that balance; these may be zero
        forces = float(np.linalg.norm(abs(matrix) @ np.abs(u).ravel()))
        scale = max(1e-5 * forces, min(norms[0], forces), 1e-3 * norms[-2] if iteration else 0.0)
        if (converged := norms[-1] <= tolerance * scale) or iteration == max_iterations:
            break
        if iteration == 1:
            problem.check_tangent(u, matrix - stabilisation)
        try:
            base, step = u, factor.solve(-unbalanced)
        except InputError as error:
            if iteration == 0:
                raise
            failure = f", where the tangent is {error.given}"
            break
        step.ravel()[~factor.free] = 0.0
        for fraction in 0.5 ** np.arange(MAX_HALVINGS):
            try:
                residual, matrix, stabilisation = problem.linearised(base + fraction * step)
            except NotFiniteError:  # the form has no value so far away
                continue
            u = base + fraction * step
            size = float(np.linalg.norm((residual - given).ravel()[factor.free]))
            if size <= (1.0 - SUFFICIENT_DECREASE * fraction) * norms[-1]:
                break
    works = [abs(float(u.ravel() @ (part @ u.ravel()))) for part in (stabilisation, matrix - stabilisation)]
    after = "" if converged else f" after {iteration} iterations"
    status = Status(converged, f"the residual is {norms[-1]:.1e}{after}{failure}", iteration)
    return NewtonSolution(u, status.with_stabilisation(works[0] / max(sum(works), MIN_POSITIVE)), tuple(norms))


class _Problem:
    """Residual and tangent of a form over cells and of forms along edges."""

    def __init__(
        self,
        space: Space,
        form: Form,
        start: Floats,
        fields: Mapping[str, Field],
        boundary: Mapping[str, Form],
        tangent: Form | None,
        degree: int | None,
    ) -> None:
        self.space, self.fields = space, dict(fields)
        self.given_tangent, self.degree = tangent, degree
        self.m = 1 if start.ndim == 1 else start.shape[1]
        self.forms: list[tuple[str | None, Form]] = [(None, form), *boundary.items()]

    def _region(self, u: Floats, on: str | None) -> FormRegion:
        fields = self.fields | {UNKNOWN: Field(self.space, u)}
        if self.given_tangent is not None and on is None:
            fields["u"] = fields[UNKNOWN]
        return FormRegion((self.space, self.space), fields, on, self.degree)

    def linearised(self, u: Floats) -> tuple[Floats, sp.csr_array, sp.csr_array]:
        """Integrals of the form by all functions v, shape of u, and their derivative with the stabilisation held.

        The stabilisation is that of the derivative at u, times u.
        """
        tensor = self._tensor(self.forms[0][1], JETS, self.given_tangent)
        stabilisation = stabilisation_matrix(self._region(u, None), tensor, self.m)
        matrix = stabilisation + assembled_form(self._region(u, None), tensor, self.m, self.m, stabilise=False)
        for on, form in self.forms[1:]:
            matrix = matrix + assembled_form(
                self._region(u, on), self._tensor(form, 1, None), self.m, self.m, stabilise=False
            )
        return self._integrals(u) + (stabilisation @ u.ravel()).reshape(u.shape), matrix, stabilisation

    def _integrals(self, u: Floats) -> Values:
        """Integrals of the form by all functions v without what projections miss, shape of u."""
        total: Values = np.zeros(u.shape)
        for on, form in self.forms:
            region = self._region(u, on)

            def vector(w: SimpleNamespace, form: Form = form, n_jets: int = region.n_jets) -> Values:
                n = len(w.points)
                tests = unit_fields(n, self.m, n_jets)
                return np.array([integrand(form(getattr(w, UNKNOWN), v, w), n) for v in tests])

            total = total + assembled_vector(region, vector, self.m)
        return total

    def _tensor(self, form: Form, n_jets: int, tangent: Form | None) -> Callable[[SimpleNamespace], Values]:
        """Derivative of a form by values and gradients of u at points, for those of v: (3 m, 3 m, n)."""

        def tensor(w: SimpleNamespace) -> Values:
            n, u = len(w.points), getattr(w, UNKNOWN)
            units, columns = unit_fields(n, self.m, n_jets), []
            for unit in units:
                if tangent is not None:
                    columns.append([integrand(tangent(unit, v, w), n) for v in units])
                    continue
                moved = PointValues(
                    u.value + 1j * COMPLEX_STEP * unit.value,
                    None if u.gradients is None else u.gradients + 1j * COMPLEX_STEP * unit.gradient,
                )
                columns.append([integrand(form(moved, v, w), n).imag / COMPLEX_STEP for v in units])
            return np.array(columns).transpose(1, 0, 2)

        return tensor

    def check_tangent(self, u: Floats, matrix: sp.csr_array) -> None:
        """Raise `InputError` if the tangent's product with a direction is not the difference of integrals."""
        size = max_magnitude(u) or 1.0
        direction = np.random.default_rng(0).uniform(0.5, 1.0, u.shape) * size
        step = DIFFERENCE * direction
        difference = (self._integrals(u + step) - self._integrals(u - step)) / (2.0 * DIFFERENCE)
        product = (matrix @ direction.ravel()).reshape(u.shape)
        error = max_magnitude(product - difference) / max(max_magnitude(difference), max_magnitude(product))
        if error > MAX_TANGENT_ERROR:
            raise InputError(
                f"a tangent that differs from the differences of the residual by {error:.1e}",
                "the derivative of the form; without `tangent`, forms of analytic functions of u (no abs, no maximum)",
                "correct the tangent, or give tangent=... by hand",
            )


# --- Errors on a sequence of meshes and their rates.


def convergence(
    problem: Callable[[PolyMesh], ErrorNorms | Mapping[str, float]], meshes: Iterable[PolyMesh]
) -> ResultTable:
    """Solve a problem on meshes and measure how fast its errors fall.

    Parameters
    ----------
    problem
        Takes a mesh, gives `ErrorNorms`, or errors by names.
    meshes
        Two or more, from coarse to fine.

    Returns
    -------
    ResultTable
        A row for each mesh: number of cells, h (root of the mean area of the cells), each error, and its rate: the
        exponent p of ``error ~ h^p`` from the mesh before, none for the first.

    """
    cells, sizes, errors = [], [], []
    for mesh in meshes:
        solution = problem(mesh)
        cells.append(mesh.n_cells)
        sizes.append(float(np.sqrt(mesh.cell_areas.mean())))
        errors.append(solution.errors if isinstance(solution, ErrorNorms) else dict(solution))
    if len(cells) < 2 or (np.diff(sizes) == 0.0).any():
        raise InputError(f"meshes with cells of sizes {sizes}", "two or more of different sizes", "give finer ones")
    columns: dict[str, Any] = {"cells": cells, "h": sizes}
    for name in errors[0]:
        values = [row[name] for row in errors]
        with np.errstate(divide="ignore", invalid="ignore"):
            rates = np.diff(np.log(values)) / np.diff(np.log(sizes))
        columns[name] = values
        columns[f"{name} rate"] = [None, *np.round(rates, 2).tolist()]
    return ResultTable(columns)
