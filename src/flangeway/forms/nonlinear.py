"""Newton's method for one's own nonlinear forms."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers
from flangeway.errors import InputError
from flangeway.forms.weak import (
    Field,
    Form,
    FormRegion,
    PointValues,
    Values,
    assembled_form,
    assembled_vector,
    bilinear,
    integrand,
    unit_fields,
)
from flangeway.solve.factor import Factor
from flangeway.solve.status import Status
from flangeway.space import Space
from flangeway.types import Bools, Floats, Indices

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
"""Step fractions down to 1/1024; then the step is taken as it is and the iteration ends."""


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
    the tangent at ``start``, which is kept, so that the equations do not change during the iteration.

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
        Norm of the residual of the free unknowns, relative to that of the first one or of its terms, that ends it.
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
        If the tangent is not the derivative, a linear system is singular, or the start or the load is not real.

    """
    first = as_numbers("first unknowns", start, "real numbers")
    problem = _Problem(space, form, first, fields or {}, boundary or {}, tangent, degree)
    u, given = problem.start.copy(), np.broadcast_to(as_numbers("a load", load, "real numbers"), problem.start.shape)
    residual, norms = problem.residual(u) - given, []
    for iteration in range(max_iterations + 1):
        matrix = problem.tangent(u)
        factor = Factor(matrix, fixed, problem.m)
        norms.append(float(np.linalg.norm(residual.ravel()[factor.free])))
        # round-off of the residual is relative to the forces that balance in it
        scale = max(norms[0], float(np.linalg.norm(abs(matrix) @ np.abs(u).ravel())) * 1e-5)
        if norms[-1] <= tolerance * scale:
            return NewtonSolution(u, Status(True, f"the residual is {norms[-1]:.1e}", iteration), tuple(norms))
        if iteration == max_iterations:
            break
        if iteration == 1:
            problem.check_tangent(u, matrix)
        step = factor.solve(-residual)
        step.ravel()[~factor.free] = 0.0
        fraction = 1.0
        for _ in range(MAX_HALVINGS):
            trial = problem.residual(u + fraction * step) - given
            size = float(np.linalg.norm(trial.ravel()[factor.free]))
            if size <= (1.0 - SUFFICIENT_DECREASE * fraction) * norms[-1]:
                break
            fraction *= 0.5
        u, residual = u + fraction * step, trial
    reason = f"the residual is {norms[-1]:.1e} after {max_iterations} iterations"
    return NewtonSolution(u, Status(False, reason, max_iterations), tuple(norms))


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
        self.space, self.fields, self.start = space, dict(fields), start
        self.given_tangent, self.degree = tangent, degree
        self.m = 1 if start.ndim == 1 else start.shape[1]
        self.forms: list[tuple[str | None, Form]] = [(None, form), *boundary.items()]
        self.stabilisation = sp.csr_array((start.size, start.size))
        whole, plain = (self._cells_tangent(start, stabilise) for stabilise in (True, False))
        self.stabilisation = whole - plain

    def _region(self, u: Floats, on: str | None) -> FormRegion:
        return FormRegion((self.space, self.space), self.fields | {UNKNOWN: Field(self.space, u)}, on, self.degree)

    def residual(self, u: Floats) -> Floats:
        """Integrals of the form by all functions v, shape of u."""
        total = (self.stabilisation @ u.ravel()).reshape(u.shape)
        for on, form in self.forms:
            region = self._region(u, on)

            def vector(w: SimpleNamespace, form: Form = form, n_jets: int = region.n_jets) -> Values:
                n = len(w.points)
                tests = unit_fields(n, self.m, n_jets)
                return np.array([integrand(form(getattr(w, UNKNOWN), v, w), n) for v in tests])

            total = total + assembled_vector(region, vector, self.m)
        return total

    def tangent(self, u: Floats) -> sp.csr_array:
        """Derivative of `residual`, shape (m n_dofs, m n_dofs)."""
        total = self.stabilisation + self._cells_tangent(u, stabilise=False)
        for on, form in self.forms[1:]:
            total = total + self._derived(self._region(u, on), form, stabilise=False)
        return sp.csr_array(total)

    def _cells_tangent(self, u: Floats, stabilise: bool) -> sp.csr_array:
        if self.given_tangent is None:
            return self._derived(self._region(u, None), self.forms[0][1], stabilise)
        fields = self.fields | {"u": Field(self.space, u)}
        return bilinear(
            self.space,
            self.given_tangent,
            components=self.m,
            fields=fields,
            degree=self.degree,
            stabilise=stabilise,
        )

    def _derived(self, region: FormRegion, form: Form, stabilise: bool) -> sp.csr_array:
        def tensor(w: SimpleNamespace) -> Values:
            n = len(w.points)
            u = getattr(w, UNKNOWN)
            units = unit_fields(n, self.m, region.n_jets)
            rows = []
            for unit in units:
                moved = PointValues(
                    u.value + 1j * COMPLEX_STEP * unit.value,
                    None if u.gradients is None else u.gradients + 1j * COMPLEX_STEP * unit.gradient,
                )
                rows.append([integrand(form(moved, v, w), n).imag / COMPLEX_STEP for v in units])
            return np.array(rows).transpose(1, 0, 2)

        return assembled_form(region, tensor, self.m, self.m, stabilise)

    def check_tangent(self, u: Floats, matrix: sp.csr_array) -> None:
        """Raise `InputError` if the tangent's product with a direction is not the difference of residuals."""
        size = float(np.abs(u).max(initial=0.0)) or 1.0
        direction = np.random.default_rng(0).uniform(0.5, 1.0, u.shape) * size
        step = DIFFERENCE * direction
        difference = (self.residual(u + step) - self.residual(u - step)) / (2.0 * DIFFERENCE)
        product = (matrix @ direction.ravel()).reshape(u.shape)
        error = float(np.abs(product - difference).max() / max(np.abs(difference).max(), np.abs(product).max()))
        if error > MAX_TANGENT_ERROR:
            raise InputError(
                f"a tangent that differs from the differences of the residual by {error:.1e}",
                "the derivative of the form; without `tangent`, forms of analytic functions of u (no abs, no maximum)",
                "correct the tangent, or give tangent=... by hand",
            )
