"""Sparse factorisation with errors that name the body, in the memory that there is."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway._core import Cholesky, FactorTooLargeError, Ldlt, NotPositiveDefiniteError
from flangeway.errors import InputError
from flangeway.problems import LinearBody
from flangeway.solve.free_motions import refuse_floating
from flangeway.solve.status import Status
from flangeway.space import DifferenceProduct, SymmetricMatrix
from flangeway.space.symmetric import EPS
from flangeway.system.memory_limits import memory_left, out_of_memory
from flangeway.types import Floats

SMALL_RESIDUAL = 1e-8
"""Residual over the forces that it is the difference of, above which a solution is not accepted."""

SMALL_CORRECTION = 1e-9
"""Relative correction of a solution below which no further one is made: no input has more than nine digits."""

MAX_CORRECTIONS = 30
"""Solutions with one factor; a factor without a correct digit needs about ten."""

SAMPLES = 4
"""Samples of round-off with random signs: one alone was too small by a factor of 4 in one of 1,000 hostile polygons."""

MAX_DIGITS = 16.0
"""Decimal digits of double precision."""

RAISED_DIAGONAL = 1e-12
"""Relative increase of diagonal entries: above round-off of pivots, below all but a slender body's softest modes."""

INVERSE_ITERATIONS = 3
"""Iterations until the softest motion has 1e-6 of other ones, if these are a hundred times as stiff."""

ZERO_ENERGY = 1e-14
"""Energy over that of the terms' magnitudes that is round-off.

It is about the third power of height over length where a body bends.
"""

JUST_BELOW = 1e-7
"""Energy over the maximum entry, within which it counts as zero in an error about a stiffness."""

NO_UNKNOWNS = np.empty(0, dtype=np.int32)
NO_UNKNOWNS.setflags(write=False)


def cholesky(matrix: SymmetricMatrix, groups: NDArray[np.int32], trailing: NDArray[np.int32] = NO_UNKNOWNS) -> Cholesky:
    """Factorise a positive definite matrix, given the number of the node of each unknown, shape (n,).

    The trailing unknowns are kept last, in this order, for their Schur complement. Raises `NotPositiveDefiniteError`
    for a pivot that is not positive, `OutOfMemoryError` if the factor needs more memory than may be used.
    """
    try:
        return Cholesky(matrix.indptr, matrix.indices, matrix.values, groups, trailing, memory_left())
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
    unit = float(np.abs(rhs).max()) or 1.0  # of forces, whose squares must neither underflow nor overflow
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
    scale = np.abs(rhs).max(initial=0.0) + np.abs(matrix.values).max() * np.abs(values).max(initial=0.0)
    ratio = float(np.abs(residual).max() / scale) if scale > 0.0 else 0.0
    digits = digits_left(factor, product, values, change)
    status = Status(ratio <= SMALL_RESIDUAL, f"the residual is {ratio:.1e} of the maximum force", 1)
    return values * unit, status.with_digits(digits)


def relative_maximum(correction: Floats, values: Floats) -> float:
    """Maximum of a correction relative to that of the values: 1 if they are zero, 0 if both are."""
    change, maximum = float(np.abs(correction).max()), float(np.abs(values).max())
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


def ldlt(matrix: SymmetricMatrix, groups: NDArray[np.int32]) -> Ldlt:
    """Factorise a symmetric indefinite matrix; arguments and errors as of `cholesky`."""
    try:
        return Ldlt(matrix.indptr, matrix.indices, matrix.values, groups, memory_left())
    except FactorTooLargeError as error:
        raise out_of_memory(f"the factorisation of {matrix.n} unknowns", error.args[1]) from error


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
    energies, motions = sp.linalg.eigsh(stiffness, k=1, sigma=-JUST_BELOW * most, v0=start, tol=1e-2)
    energy = float(energies[0]) / most
    if energy > JUST_BELOW:  # a negative one is further away
        energies, motions = sp.linalg.eigsh(stiffness, k=1, which="SA", v0=start, tol=1e-3)
        energy = float(energies[0]) / most
    words = "negative" if energy < -JUST_BELOW else "zero"
    most_moved = body.named(int(np.abs(motions[:, 0]).argmax()))
    return InputError(
        f"body {body.name!r}: its stiffness has {words} energy ({energy:.1e} of its maximum entry) in a motion that "
        f"is largest at {most_moved}",
        "a positive definite matrix of the unknowns that are not held",
        "hold what moves freely, leave out pressures, multipliers and mechanisms such as hourglass modes, and shorten "
        "bodies that are so slender that round-off hides what bends them",
    )
