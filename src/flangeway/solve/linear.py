"""Sparse factorisation with errors that name the body, in the memory that there is; of bodies, and of any forms."""

import warnings
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import LinAlgWarning
from scipy.sparse.linalg import splu

from flangeway._core import Cholesky, FactorTooLargeError, Ldlt, NotPositiveDefiniteError, SingularMatrixError
from flangeway.checks import check_integer
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import frozen, max_magnitude
from flangeway.problems import LinearBody
from flangeway.solve.constraints import refuse_floating
from flangeway.solve.status import Status
from flangeway.space import DifferenceProduct, SymmetricMatrix
from flangeway.space.symmetric import EPS
from flangeway.system.memory_limits import memory_left, out_of_memory
from flangeway.types import Bools, Floats

# --- Sparse factorisation with errors that name the body, in the memory that there is.


SMALL_RESIDUAL = 1e-8
"""Residual relative to the forces that it is the difference of, above which a solution is not accepted."""

SMALL_CORRECTION = 1e-9
"""Relative correction of a solution below which no further one is made: no input has more than nine digits."""

MAX_CORRECTIONS = 30
"""Solutions with one factor; a factor without a correct digit needs about ten."""

SAMPLES = 4
"""Samples of round-off with random signs: one alone was too small by a factor of 4 in one of 1,000 hostile polygons."""

MAX_BACKWARD_ERROR = 16.0 * EPS
"""Residual of a refined solution, relative to the maximum row sum and solution (Rigal and Gaches, 1967), that is
round-off; the compiled core has the same limit."""

MAX_DIGITS = 16.0
"""Decimal digits of double precision."""

RAISED_DIAGONAL = 1e-12
"""Relative increase of diagonal entries: above round-off of pivots, below all but a slender body's softest modes."""

INVERSE_ITERATIONS = 3
"""Iterations until the softest motion has 1e-6 of other ones, if these are a hundred times as stiff."""

ZERO_ENERGY = 1e-14
"""Energy relative to that of the terms' magnitudes that is round-off.

It is about the third power of height over length where a body bends.
"""

MAX_ZERO_ENERGY = 1e-7
"""Energy relative to the maximum entry, within which it counts as zero in an error about a stiffness."""

NO_UNKNOWNS = frozen(np.empty(0, dtype=np.int32))


def cholesky(
    matrix: SymmetricMatrix,
    groups: NDArray[np.int32],
    trailing: NDArray[np.int32] = NO_UNKNOWNS,
    max_bytes: int | None = None,
) -> Cholesky:
    """Factorise a positive definite matrix, given the number of the node of each unknown, shape (n,).

    The trailing unknowns are kept last, in this order, for their Schur complement. Memory to use is what is left,
    which takes a millisecond to ask for, or given as `max_bytes`. Raises `NotPositiveDefiniteError` for a pivot that
    is not positive, `OutOfMemoryError` if the factor needs more memory.
    """
    max_bytes = memory_left() if max_bytes is None else max_bytes
    try:
        return Cholesky(matrix.indptr, matrix.indices, matrix.values, groups, trailing, max_bytes)
    except FactorTooLargeError as error:
        raise out_of_memory(f"the factorisation of {matrix.n} unknowns", error.args[1]) from error


Product = SymmetricMatrix | DifferenceProduct
"""What multiplies vectors by a stiffness: its entries, or more accurately differences of displacements."""


def solve_linear(
    matrix: SymmetricMatrix, groups: NDArray[np.int32], rhs: Floats, product: Product | None = None
) -> tuple[Floats, Status]:
    """Solve with a positive definite matrix; the status reports the residual, and the digits that round-off leaves.

    The factor preconditions conjugate gradients for the product, which may be more accurate than the matrix: slender
    bodies then lose digits by the product's round-off alone. Where the matrix is well-conditioned the first solution
    is the last one. Further arguments and errors as of `cholesky`.
    """
    if matrix.n == 0:
        return np.empty(0), Status(True, "every unknown is prescribed", 0, MAX_DIGITS)
    factor = cholesky(matrix, groups) if product is None else _preconditioner(matrix, groups, product)
    product = matrix if product is None else product
    unit = max_magnitude(rhs) or 1.0  # of forces, whose squares must neither underflow nor overflow
    rhs = rhs / unit
    values, direction, residual, power = np.zeros(matrix.n), np.zeros(matrix.n), rhs, 1.0
    for iteration in range(MAX_CORRECTIONS):  # noqa: B007 (used after the loop)
        correction = factor.solve(residual)
        change = relative_maximum(correction, values)
        if change <= SMALL_CORRECTION:
            break
        power, previous = float(residual @ correction), power
        direction = correction + direction * (power / previous)
        forces = product.times(direction)
        step = power / float(direction @ forces)
        values = values + step * direction
        residual = residual - step * forces
    else:
        change = 1.0
    if iteration > 1:  # what the iteration has carried along is not the residual of the values
        residual = rhs - product.times(values)
        change = max(change, relative_maximum(factor.solve(residual), values))
    scale = max_magnitude(rhs) + np.abs(matrix.values).max() * max_magnitude(values)
    ratio = max_magnitude(residual) / scale if scale > 0.0 else 0.0
    digits = digits_left(factor, product, values, change)
    status = Status(ratio <= SMALL_RESIDUAL, f"the residual is {ratio:.1e} of the maximum force", 1)
    return values * unit, status.with_digits(digits)


def relative_maximum(correction: Floats, values: Floats) -> float:
    """Maximum of a correction relative to that of the values: 1 if they are zero, 0 if both are."""
    change, maximum = max_magnitude(correction), max_magnitude(values)
    return change / maximum if maximum > 0.0 else float(change > 0.0)


def digits_left(factor: Cholesky, product: Product, values: Floats, change: float) -> float:
    """Decimal digits of displacements with a last relative change.

    Entries of the stiffness are off by round-off, forces by that of the terms ``|K| |u|`` that are balanced. With one
    sign everywhere it changes the energy, and the displacement of the load, by its fraction of the energy. With signs
    drawn at random it moves what is softest, also where the load does not: samples of the componentwise bound
    ``|K^-1| |K| |u| eps`` (Higham, 2002, Accuracy and Stability, eq. 7.8). Round-off of the projections of virtual
    elements is in it where the product measures it by translations, see `DifferenceProduct`.
    """
    terms = EPS * product.magnitudes(values)
    energy, change_of_energy = float(values @ product.times(values)), float(np.abs(values) @ terms)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (len(values), SAMPLES))
    spread = factor.solve(terms[:, None] * signs)
    systematic = change_of_energy / energy if energy > change_of_energy else float(change_of_energy > 0.0)
    error = max(change, systematic, relative_maximum(spread, values), EPS)
    return max(0.0, -float(np.log10(error)))


def _preconditioner(matrix: SymmetricMatrix, groups: NDArray[np.int32], product: Product) -> Cholesky:
    """Factor of a matrix, with its diagonal raised by `RAISED_DIAGONAL` where round-off leaves no positive pivot.

    If the softest motion then has no energy beyond round-off, the matrix is singular: `NotPositiveDefiniteError`.
    """
    try:
        return cholesky(matrix, groups)
    except NotPositiveDefiniteError:
        factor = cholesky(_raised(matrix), groups)
        motion = np.random.default_rng(0).standard_normal(matrix.n)
        for _ in range(INVERSE_ITERATIONS):
            motion = factor.solve(motion / np.abs(motion).max())
        if motion @ product.times(motion) <= ZERO_ENERGY * (np.abs(motion) @ product.magnitudes(motion)):
            raise
        return factor


def _raised(matrix: SymmetricMatrix) -> SymmetricMatrix:
    values = matrix.values.copy()
    values[matrix.indptr[:-1]] *= 1.0 + RAISED_DIAGONAL  # rows are sorted: a column begins with its diagonal
    return replace(matrix, values=values)


def ldlt(matrix: SymmetricMatrix, groups: NDArray[np.int32]) -> "IndefiniteFactor":
    """Factorise a symmetric indefinite matrix; arguments and errors as of `cholesky`."""
    try:
        return IndefiniteFactor(matrix, Ldlt(matrix.indptr, matrix.indices, matrix.values, groups, memory_left()))
    except FactorTooLargeError as error:
        raise out_of_memory(f"the factorisation of {matrix.n} unknowns", error.args[1]) from error


class IndefiniteFactor:
    """Factor of a symmetric indefinite matrix: LDLT, replaced by LU where its residual is not round-off.

    LDLT looks for pivots within the dense blocks of the factor, which keeps it sparse and is enough for stiffnesses
    with multipliers. Of other matrices, such as those of graphs, a block may have no stable pivot: LU looks for it in
    the whole column.
    """

    def __init__(self, matrix: SymmetricMatrix, factor: Ldlt) -> None:
        self._matrix = matrix
        self._factor: Ldlt | ScaledLU = factor
        self.kind = "LDLT"

    def solve(self, rhs: NDArray[Any]) -> NDArray[Any]:
        """Solve for right-hand sides (n,) or (n, m); `SingularMatrixError` if the residual is no round-off."""
        try:
            return self._factor.solve(rhs)
        except SingularMatrixError:
            if self.kind == "LU":
                raise
            self._factor, self.kind = ScaledLU(self._matrix.full()), "LU"
            return self._factor.solve(rhs)


class ScaledLU:
    """LU factors by SuperLU of a matrix with rows and columns scaled by powers of two, and refined solutions.

    Where the diagonal has no zero, the order is the minimum degree of ``A + A^T`` and pivots stay on the diagonal
    unless another entry of the column is ten times larger, which suits matrices of a symmetric pattern (Li, 2005, ACM
    TOMS 31). Otherwise it is COLAMD, with partial pivoting and twice the fill.
    """

    kind = "LU"

    def __init__(self, matrix: sp.csr_array) -> None:
        self._scale = np.exp2(np.round(np.log2(_unit_scale(matrix))))
        self._matrix = sp.csc_array(sp.diags_array(self._scale) @ matrix @ sp.diags_array(self._scale))
        self._matrix.eliminate_zeros()
        self._row_sum = float(abs(self._matrix).sum(axis=1).max(initial=0.0))
        if sp.csgraph.structural_rank(self._matrix) < matrix.shape[0]:  # SuperLU would write beyond its memory
            raise SingularMatrixError("the matrix is singular: its nonzero entries are too few")
        symmetric = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.1, "options": {"SymmetricMode": True}}
        try:
            self._factor = splu(self._matrix, **(symmetric if self._matrix.diagonal().all() else {}))
        except RuntimeError as error:  # an exact zero
            raise SingularMatrixError("the matrix is singular: a pivot is zero") from error

    def solve(self, rhs: NDArray[Any]) -> NDArray[Any]:
        """See `IndefiniteFactor.solve`."""
        scaled = (self._scale * rhs.T).T
        solution = self._factor.solve(scaled)
        solution = solution + self._factor.solve(scaled - self._matrix @ solution)
        residual, size = (np.abs(array).max(axis=0) for array in (scaled - self._matrix @ solution, solution))
        if not (residual <= MAX_BACKWARD_ERROR * (self._row_sum * size + np.abs(scaled).max(axis=0))).all():
            raise SingularMatrixError("the matrix is singular to working precision: the residual is not round-off")
        return np.asarray((self._scale * solution.T).T)


def factorise(body: LinearBody, trailing: NDArray[np.int32]) -> Cholesky:
    """Factorise the stiffness of a body's free unknowns, the trailing ones last for their Schur complement.

    An `InputError` if the body is not held, or its material or mesh leaves a motion without stiffness.
    """
    refuse_floating(body)
    try:
        return cholesky(body.stiffness, body.free_nodes, trailing)
    except NotPositiveDefiniteError as error:
        raise indefinite(body) from error


def indefinite(body: LinearBody) -> InputError:
    """Error of a stiffness that is not positive definite, with the motion of least energy."""
    stiffness = body.stiffness.full()
    most = float(stiffness.diagonal().max())
    start = np.ones(stiffness.shape[0])
    energies, motions = sp.linalg.eigsh(stiffness, k=1, sigma=-MAX_ZERO_ENERGY * most, v0=start, tol=1e-2)
    energy = float(energies[0]) / most
    if energy > MAX_ZERO_ENERGY:  # a negative one is further away
        energies, motions = sp.linalg.eigsh(stiffness, k=1, which="SA", v0=start, tol=1e-3)
        energy = float(energies[0]) / most
    words = "negative" if energy < -MAX_ZERO_ENERGY else "zero"
    most_moved = body.named(int(np.abs(motions[:, 0]).argmax()))
    return InputError(
        f"body {body.name!r}: its stiffness has {words} energy ({energy:.1e} of its maximum entry) in a motion that "
        f"is largest at {most_moved}",
        "a positive definite matrix of the unknowns that are not held",
        "hold what moves freely, leave out pressures, multipliers and mechanisms such as hourglass modes, and shorten "
        "bodies that are so slender that round-off hides what bends them",
    )


# --- A factorisation of any sparse matrix of forms, chosen by the matrix and kept, and an estimate of its condition.


ASYMMETRY = 1e-13
"""Difference of the products of a matrix and of its transpose with a vector, relative to their terms and to the maximum
entry, that is round-off of the assembly."""
SINGULAR = 0.05
"""Relative error of the solution above which a matrix counts as singular: round-off of a zero gives 0.2 or more."""
FEW_DIGITS = 4.0
"""Decimal digits of a solution below which a warning says so."""
REFINED_BELOW = 8.0
"""Digits below which a solution by Cholesky's method is corrected once with its residual; others always are."""
SHIFT = 1e-9
"""Relative increase of the diagonal with which the motions that make a matrix singular are computed."""
PROBES = 4
"""Random right-hand sides of the estimate of a condition: all together miss the softest motion by a factor of three in
two of 100 matrices, by a factor of ten in one of 5,000."""
MAX_SCALINGS = 5
MAX_SCALING_RATIO = 2.0
"""Ratio of the largest to the smallest of the rows' maxima that need no further scaling."""
LEADING = 40
"""One in so many unknowns is surely a value at a point of the mesh, which are numbered first (`Space`)."""


class Factor:
    """Factorisation of the free part of a matrix, to be solved with as often as wanted.

    A symmetric positive definite matrix is factorised by Cholesky's method and another symmetric one as LDLT, both by
    the compiled core with approximate minimum degree; any other, real or complex, by SuperLU, and so is a symmetric one
    in whose LDLT pivots within dense blocks are not stable.

    Parameters
    ----------
    matrix
        Sum of forms, shape (m n_dofs, m n_dofs); real or complex, symmetric or not.
    fixed
        Unknowns whose values are prescribed: numbers of unknowns of one field (all their components), or truth values
        (n_dofs,) or (n_dofs, m).
    components
        Number m of components of the field.

    Raises
    ------
    InputError
        If the matrix is not square or not finite, or ``fixed`` does not fit; at the first solution if the matrix is
        singular: the message names the motion without energy.

    """

    def __init__(
        self, matrix: sp.sparray, fixed: NDArray[np.integer] | Bools | None = None, components: int = 1
    ) -> None:
        check_integer("Factor", "components", components, 1)
        self.matrix = _checked_matrix(matrix, components)
        n = self.matrix.shape[0] // components
        self._shape = (n,) if components == 1 else (n, components)
        self.free = free_unknowns(fixed, self._shape)
        self._round_off = np.broadcast_to(getattr(matrix, "round_off", 1.0), self.matrix.shape[0])[self.free]
        groups = (np.flatnonzero(self.free) // components).astype(np.int32)
        self._symmetric = _symmetric(self.matrix)
        self._inner = self.matrix if self.free.all() else sp.csr_array(self.matrix[self.free][:, self.free])
        try:
            self._factor = self._factorised(groups)
        except SingularMatrixError as error:
            raise self._singular() from error

    def _factorised(self, groups: NDArray[np.int32]) -> Cholesky | IndefiniteFactor | ScaledLU | None:
        if not len(groups):  # every unknown is prescribed
            return None
        if not self._symmetric or np.iscomplexobj(self._inner.data):
            return ScaledLU(self._inner)
        lower = _with_diagonal(self._inner)
        if (self._inner.diagonal() > 0.0).all():
            with suppress(NotPositiveDefiniteError):
                return cholesky(lower, groups, NO_UNKNOWNS)
        return ldlt(lower, groups)

    @property
    def kind(self) -> str:
        """Method: Cholesky, LDLT or LU, or none where every unknown is prescribed."""
        return "none" if self._factor is None else getattr(self._factor, "kind", "Cholesky")

    @cached_property
    def condition(self) -> float:
        """Estimate of the condition number of the matrix B with rows and columns scaled to unit diagonal.

        It is ``max_i sum_j |B_ij|`` times the Frobenius norm of the inverse, whose square is the mean of
        ``|B^-1 z|^2`` over vectors z of normally distributed numbers (Kenney and Laub, 1994, SIAM J. Sci. Comput. 15).
        Rows of a `FormMatrix` whose entries are off by more than the last bit have as many times larger numbers.
        """
        n = self._inner.shape[0]
        if self._factor is None:
            return 1.0
        # of a positive matrix with unit diagonal no entry is larger
        scale = _unit_scale(self._inner, 0 if self.kind == "Cholesky" else MAX_SCALINGS)
        probes = np.random.default_rng(0).standard_normal((n, PROBES)).astype(self._inner.dtype)
        try:
            solved = self._factor.solve(probes * (self._round_off / scale)[:, None]) / scale[:, None]
        except SingularMatrixError:
            return np.inf
        norm = (scale * (abs(self._inner) @ scale)).max()
        condition = float(norm * np.linalg.norm(solved) / np.sqrt(PROBES))
        return condition if np.isfinite(condition) else np.inf

    @property
    def digits(self) -> float:
        """Decimal digits of a solution that round-off of the matrix leaves, by the condition."""
        return float(np.clip(-np.log10(EPS * self.condition), 0.0, MAX_DIGITS))

    @cached_property
    def _checked_digits(self) -> float:
        if not EPS * self.condition < SINGULAR:
            raise self._singular()
        if self.digits < FEW_DIGITS:
            warnings.warn(
                f"the matrix is nearly singular (condition {self.condition:.0e}): about {self.digits:.0f} digits of "
                "the solution are right",
                LinAlgWarning,
                stacklevel=4,
            )
        return self.digits

    def solve_free(self, rhs: NDArray[Any]) -> NDArray[Any]:
        """Solve for the free unknowns alone, (n_free,)."""
        digits = self._checked_digits
        if np.iscomplexobj(rhs) and not np.iscomplexobj(self._inner.data):
            return self.solve_free(rhs.real) + 1j * self.solve_free(rhs.imag)
        rhs = np.ascontiguousarray(rhs, dtype=self._inner.dtype)
        if self._factor is None:
            return rhs
        try:
            solution = self._factor.solve(rhs)
        except SingularMatrixError as error:
            raise self._singular() from error
        if digits < REFINED_BELOW and self.kind == "Cholesky":
            solution = solution + self._factor.solve(rhs - self._inner @ solution)
        return solution

    def solve(self, load: ArrayLike, values: ArrayLike = 0.0) -> NDArray[Any]:
        """Solve with prescribed values of the fixed unknowns.

        Parameters
        ----------
        load
            Right-hand side, shape (n_dofs,) or (n_dofs, m).
        values
            Prescribed values: a number, or an array of the load's shape, of which only the fixed unknowns are read.

        Returns
        -------
        Floats, or complex numbers if the matrix, the load or a value is complex
            All unknowns, shape of the load.

        """
        given = finite_numbers("a load", load)
        if given.size != self.matrix.shape[0]:
            raise InputError(
                f"a matrix of shape {self.matrix.shape} and a load of shape {given.shape}",
                "as many rows as the load has numbers",
                "use the same space and the same number of components for both",
            )
        try:
            prescribed = np.broadcast_to(np.asarray(values), given.shape)
        except ValueError:
            prescribed = np.empty(0, dtype=object)
        if prescribed.dtype.kind not in "biufc":
            raise InputError(
                f"prescribed values {short(values)} of shape {np.shape(values)}",
                f"a number, or numbers of the load's shape {given.shape}",
                "take interpolate(space, ...); only values of fixed unknowns are read",
            )
        kind = np.result_type(self.matrix, given, prescribed, np.float64)
        solution = prescribed.astype(kind).ravel()
        solution[self.free] = 0.0
        if not np.isfinite(solution).all():
            raise InputError("prescribed values that are not finite", "finite numbers", "correct the values")
        if self.free.any():
            solution[self.free] = self.solve_free((given.ravel() - self.matrix @ solution)[self.free])
        return solution.reshape(given.shape)

    def _singular(self) -> InputError:
        """Error that describes the motions without energy: the null space of the matrix, by inverse iteration."""
        scale = _unit_scale(self._inner)
        scaled = sp.csc_array(sp.diags_array(scale) @ self._inner @ sp.diags_array(scale))
        round_off = EPS * float(self._round_off.max()) * abs(scaled).sum(axis=1).max()
        n = scaled.shape[0]
        motions = np.random.default_rng(0).standard_normal((n, min(4, n))).astype(scaled.dtype)
        try:
            raised = splu(scaled + SHIFT * sp.eye_array(n, format="csc"), permc_spec="MMD_AT_PLUS_A")
            for _ in range(4):
                motions = np.linalg.qr(raised.solve(motions))[0]
        except RuntimeError:  # of nonsymmetric matrices the shift may change nothing beyond round-off
            motions = motions[:, :0]
        _, energies, turned = np.linalg.svd(scaled @ motions, full_matrices=False)
        null = (motions @ turned.conj().T)[:, energies < round_off / SINGULAR]
        whole = np.zeros((self.matrix.shape[0], null.shape[1]), dtype=scaled.dtype)
        whole[self.free] = scale[:, None] * null
        return InputError(
            f"a singular matrix: {self._described(whole)}",
            "forms and fixed unknowns that leave no motion without energy",
            "fix unknowns with space.boundary_dofs(...), or add a mass",
        )

    def _described(self, null: NDArray[np.inexact]) -> str:
        """Words for the columns (m n_dofs, n_motions) of a null space."""
        n_motions = null.shape[1]
        if n_motions == 0:
            return "it is so close to singular that round-off may leave no digit of the solution"
        m = 1 if len(self._shape) == 1 else self._shape[1]
        leading = null.reshape(self._shape[0], m, -1)[: max(3, self._shape[0] // LEADING)]
        units = leading / np.abs(null).max(axis=0)
        # constants in the null space: combinations of the motions that do not differ between the mesh's first points
        differences = (units - units[:1]).reshape(-1, n_motions)
        _, values, turned = np.linalg.svd(differences, full_matrices=True)
        values = np.concatenate((values, np.zeros(n_motions - len(values))))
        constants = units[0] @ turned.conj().T[:, values < 1e-5 * np.sqrt(len(differences))]
        if m == 1 and n_motions == constants.shape[1] == 1 and np.abs(constants).max() > 1e-3:
            return "a constant can be added to the solution"
        if m == 2 and n_motions == 3 and constants.shape[1] == 2:
            return "nothing holds the body: it can slide in x and y and turn (rigid motions)"
        if m > 1 and n_motions == constants.shape[1] == 1 and np.abs(constants).max() > 1e-3:
            direction = np.real(constants[:, 0] / constants[np.abs(constants[:, 0]).argmax(), 0])
            return f"a constant displacement along {short(np.round(direction, 6) + 0.0)} has no energy"
        at = int(np.abs(null[:, 0]).argmax()) // m
        number = "one motion has" if n_motions == 1 else f"{n_motions} motions have"
        shape = "" if m == 1 or constants.shape[1] == n_motions else ", not constant (such as a rotation)"
        return f"{number} no energy beyond round-off{shape}; the largest value is at unknown {at}"


def finite_numbers(name: str, values: ArrayLike) -> NDArray[Any]:
    """Return real or complex numbers in an array; what is not finite or no number is an `InputError`."""
    numbers = np.asarray(values)
    if numbers.dtype.kind not in "iufc" or not np.isfinite(numbers).all():
        raise InputError(
            f"{name} {short(values)} of type {numbers.dtype}, or not finite", "finite numbers", "correct them"
        )
    return numbers


def _checked_matrix(matrix: Any, components: int) -> sp.csr_array:
    """Return a square matrix of finite numbers, in double precision, with whole nodes of so many components."""
    try:
        checked = sp.csr_array(matrix)
        shape = checked.shape
        fits = (
            checked.dtype.kind in "iufc" and len(shape) == 2 and shape[0] == shape[1] > 0 and shape[0] % components == 0
        )
    except (TypeError, ValueError):
        shape, fits = short(matrix), False
    if not fits or not np.isfinite(checked.data).all():
        raise InputError(
            f"a matrix of shape {shape} for {components} components, or one that is not finite",
            "a square matrix of finite numbers, with as many rows as unknowns",
            "use the same space and the same number of components for all forms",
        )
    return checked.astype(np.result_type(checked.dtype, np.float64), copy=False)


def free_unknowns(fixed: NDArray[np.integer] | Bools | None, shape: tuple[int, ...]) -> Bools:
    """Which unknowns are free, for all components one after the other."""
    free = np.ones(shape, dtype=np.bool_)
    chosen = np.asarray([] if fixed is None else fixed)
    if chosen.size and not (
        (chosen.dtype == bool and chosen.shape in (shape, shape[:1]))
        or (chosen.dtype.kind in "iu" and chosen.ndim == 1 and chosen.min() >= 0 and chosen.max() < shape[0])
    ):
        raise InputError(
            f"fixed unknowns {short(chosen)}",
            f"numbers below {shape[0]}, or truth values of shape {shape[:1]} or {shape}",
            "take space.boundary_dofs(...)",
        )
    if chosen.size:
        free[chosen] = False
    return free.ravel()


def _symmetric(matrix: sp.csr_array) -> bool:
    """Whether ``A x`` and ``A^T x`` differ by round-off alone for a random vector x, which is cheaper than ``A^T``."""
    x = np.random.default_rng(0).uniform(1.0, 2.0, matrix.shape[0])
    magnitudes = np.maximum(abs(matrix) @ x, max_magnitude(matrix.data))
    return bool((np.abs(matrix @ x - matrix.T @ x) <= ASYMMETRY * magnitudes).all())


def _with_diagonal(matrix: sp.csr_array) -> SymmetricMatrix:
    """Lower triangle of a symmetric matrix in which every diagonal entry is stored, zeros too."""
    if np.count_nonzero(matrix.diagonal()) < matrix.shape[0]:
        every, entries = np.arange(matrix.shape[0]), sp.coo_array(matrix)
        rows, columns = np.concatenate((entries.row, every)), np.concatenate((entries.col, every))
        values = np.concatenate((entries.data, np.zeros(len(every))))
        matrix = sp.csr_array((values, (rows, columns)), shape=matrix.shape)
    return SymmetricMatrix.from_full(matrix)


def _unit_scale(matrix: sp.csr_array, scalings: int = MAX_SCALINGS) -> Floats:
    """Scale of rows and columns after which the largest entry of every row is about one (Ruiz, 2001)."""
    size = np.abs(matrix.diagonal())
    scale = 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0))
    magnitudes, filled = np.abs(matrix.data), np.diff(matrix.indptr) > 0
    for _ in range(scalings):  # each takes the square root of what a row's maximum differs from one
        # max over j of s_i |A_ij| s_j
        maxima = np.maximum.reduceat(magnitudes * scale[matrix.indices], matrix.indptr[:-1][filled]) * scale[filled]
        if maxima.max(initial=1.0) <= MAX_SCALING_RATIO * maxima.min(initial=1.0):
            break
        scale[filled] /= np.sqrt(np.where(maxima > 0.0, maxima, 1.0))
    return scale
