"""Sparse factorisation with errors that name the body, in the memory that there is."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway._core import Cholesky, FactorTooLargeError, Ldlt, NotPositiveDefiniteError
from flangeway.errors import InputError, short
from flangeway.problems import Body, LinearBody
from flangeway.solve.free_motions import refuse_floating
from flangeway.solve.status import Status
from flangeway.space import SymmetricMatrix
from flangeway.system.memory_limits import memory_left, out_of_memory
from flangeway.types import Floats

SMALL_RESIDUAL = 1e-8
"""Residual over the forces that it is the difference of, above which a solution is not accepted."""

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


def solve_linear(matrix: SymmetricMatrix, groups: NDArray[np.int32], rhs: Floats) -> tuple[Floats, Status]:
    """Solve with a positive definite matrix; the status reports the residual. Arguments and errors as of `cholesky`."""
    if matrix.n == 0:
        return np.empty(0), Status(True, "every unknown is prescribed", 0)
    values = cholesky(matrix, groups).solve(rhs)
    forces = np.abs(rhs).max(initial=0.0) + np.abs(matrix.values).max() * np.abs(values).max(initial=0.0)
    residual = float(np.abs(matrix.times(values) - rhs).max(initial=0.0) / forces) if forces > 0.0 else 0.0
    converged = residual <= SMALL_RESIDUAL
    advice = "" if converged else "; the mesh has cells of very different sizes or the materials very different moduli"
    return values, Status(converged, f"the residual is {residual:.1e} of the maximum force{advice}", 1)


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
        unknown = int(error.args[1])
        if not isinstance(body, Body):
            raise indefinite(body) from error
        raise InputError(
            f"body {body.name!r} can move without strain: nothing holds {body.named(unknown)}",
            "a body whose held edges fix both translations and the rotation",
            f"hold at least one edge of the body (now {short(body.held)}) and check that its mesh is one piece",
        ) from error


def indefinite(body: LinearBody) -> InputError:
    """Error of a stiffness that is not positive definite, with the motion of least energy."""
    stiffness = body.stiffness.full()
    most = float(stiffness.diagonal().max())
    start = np.ones(stiffness.shape[0])
    energies, motions = sp.linalg.eigsh(stiffness, k=1, sigma=-JUST_BELOW * most, v0=start)
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
        "assemble without pressures, multipliers and mechanisms such as hourglass modes, or hold what moves freely",
    )
