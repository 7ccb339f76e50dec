"""Errors of a discrete function against an exact one, through the elements' reconstruction."""

from dataclasses import dataclass

import numpy as np

from flangeway.elements import Function
from flangeway.space import Space
from flangeway.space.functions import at_points, cell_quadrature, quadrature_degree
from flangeway.types import Floats


@dataclass(frozen=True)
class ErrorNorms:
    """Norms of an error and of the exact function over the mesh.

    - `l2`, `h1`: L2 norm of the error, and of the gradient's error (a seminorm).
    - `exact_l2`, `exact_h1`: the same of the exact function.
    """

    l2: float
    h1: float
    exact_l2: float
    exact_h1: float

    @property
    def relative_l2(self) -> float:
        """Error over the exact function, in L2."""
        return self.l2 / self.exact_l2

    @property
    def relative_h1(self) -> float:
        """Error over the exact function, in the H1 seminorm."""
        return self.h1 / self.exact_h1


def error_norms(
    space: Space, dofs: Floats, exact: Function, exact_gradient: Function, *, degree: int | None = None
) -> ErrorNorms:
    """Compare the L2 projections of a discrete function and of its gradient with an exact function.

    - `dofs`: unknowns, shape (n_dofs,).
    - `exact`: takes points (n, 2), gives values (n,).
    - `exact_gradient`: takes points (n, 2), gives gradients (n, 2).
    - `degree`: degree of the quadrature, ``2 k + 2`` by default.
    """
    degree = quadrature_degree(space) if degree is None else degree
    totals = np.zeros(4)
    for batch in space.batches():
        reconstruction = batch.element.reconstruct(batch.vertices)
        points, weights = cell_quadrature(batch, degree)
        monomials = reconstruction.at(points)
        local = dofs[batch.dofs]
        value = np.einsum("ame,me->ae", reconstruction.projected_value, local)
        gradient = np.einsum("aime,me->iae", reconstruction.gradient, local)
        wanted, wanted_gradient = at_points(exact, points), at_points(exact_gradient, points)
        error = wanted - np.einsum("ae,aqe->qe", value, monomials)
        gradient_error = wanted_gradient - np.einsum("iae,aqe->iqe", gradient, monomials[: gradient.shape[1]])
        totals += [
            float(np.sum(weights * square))
            for square in (error**2, (gradient_error**2).sum(axis=0), wanted**2, (wanted_gradient**2).sum(axis=0))
        ]
    return ErrorNorms(*np.sqrt(totals).tolist())
