"""Sparse factorisation with errors that name the body."""

import numpy as np
from numpy.typing import NDArray

from flangeway._core import Cholesky, NotPositiveDefiniteError
from flangeway.errors import InputError
from flangeway.problems import Body


def factorise(body: Body, trailing: NDArray[np.int32]) -> Cholesky:
    """Factorise the stiffness of a body's free unknowns.

    Parameters
    ----------
    body
        The body.
    trailing
        Free unknowns that are kept last, in this order, for their Schur complement.

    Raises
    ------
    InputError
        If the body is not held, or its material or mesh leaves a motion without stiffness.

    """
    stiffness = body.stiffness
    try:
        return Cholesky(stiffness.indptr, stiffness.indices, stiffness.values, body.free_nodes, trailing)
    except NotPositiveDefiniteError as error:
        unknown = int(error.args[1])
        node, component = body.free_nodes[unknown], np.flatnonzero(body.free)[unknown] % 2
        x, y = body.space.nodes[node]
        raise InputError(
            f"body {body.name!r} can move without strain: nothing holds node {node} at ({x:g}, {y:g}) "
            f"in {'xy'[component]}",
            "a body whose held edges fix both translations and the rotation",
            f"hold at least one edge of the body (now {body.held!r}) and check that its mesh is one piece",
        ) from error
