"""Errors of a discrete function against an exact one, through the elements' reconstruction."""

from dataclasses import dataclass

import numpy as np

from flangeway.elements import Function
from flangeway.space import CellCoefficient, Coefficient, Space
from flangeway.space.functions import at_points, cell_quadrature, quadrature_degree
from flangeway.types import Floats


@dataclass(frozen=True)
class ErrorNorms:
    """Norms of an error and of the exact function over the mesh.

    - `l2`, `h1`: L2 norm of the error, and of the gradient's error (a seminorm), over all components.
    - `exact_l2`, `exact_h1`: the same of the exact function.
    - `energy`, `exact_energy`: roots of ``int grad e : C : grad e`` with the coefficient given, zero without.
    """

    l2: float
    h1: float
    exact_l2: float
    exact_h1: float
    energy: float = 0.0
    exact_energy: float = 0.0

    @property
    def relative_l2(self) -> float:
        """Error over the exact function, in L2."""
        return self.l2 / self.exact_l2

    @property
    def relative_h1(self) -> float:
        """Error over the exact function, in the H1 seminorm."""
        return self.h1 / self.exact_h1

    @property
    def relative_energy(self) -> float:
        """Error over the exact function, in energy."""
        return self.energy / self.exact_energy

    @property
    def errors(self) -> dict[str, float]:
        """The errors by their names; energy where a coefficient was given."""
        return {"l2": self.l2, "h1": self.h1} | ({"energy": self.energy} if self.exact_energy else {})


def error_norms(
    space: Space,
    dofs: Floats,
    exact: Function,
    exact_gradient: Function,
    *,
    coefficient: Coefficient | None = None,
    degree: int | None = None,
) -> ErrorNorms:
    """Compare the L2 projections of a discrete function and of its gradient with an exact function.

    - `dofs`: unknowns, shape (n_dofs,), or (n_dofs, m) for m components.
    - `exact`: takes points (n, 2), gives values (n,) or (n, m).
    - `exact_gradient`: takes points (n, 2), gives gradients (n, 2) or (n, m, 2), derivatives last.
    - `coefficient`: for the energy, as of `flangeway.forms.stiffness`.
    - `degree`: degree of the quadrature, ``2 k + 2`` by default.
    """
    degree = quadrature_degree(space) if degree is None else degree
    given = None if coefficient is None else CellCoefficient.on(space, coefficient, "gradients")
    fields = dofs.reshape(space.n_dofs, -1)
    totals = np.zeros(6)
    for batch in space.batches():
        reconstruction = batch.element.reconstruct(batch.outline)
        points, weights = cell_quadrature(batch, degree)
        monomials = reconstruction.at(points)
        local = fields[batch.dofs]
        value = np.einsum("ame,mec->cae", reconstruction.projected_value, local)
        gradient = np.einsum("aime,mec->ciae", reconstruction.gradient, local)
        wanted = at_points(exact, points).reshape(-1, *weights.shape)
        wanted_gradient = at_points(exact_gradient, points).reshape(-1, 2, *weights.shape)
        error = wanted - np.einsum("cae,aqe->cqe", value, monomials)
        gradient_error = wanted_gradient - np.einsum("ciae,aqe->ciqe", gradient, monomials[: gradient.shape[2]])
        densities = [(field**2).sum(axis=axes) for field, axes in
                     ((error, 0), (gradient_error, (0, 1)), (wanted, 0), (wanted_gradient, (0, 1)))]  # fmt: skip
        if given is not None:
            tensor = np.broadcast_to(given.at(batch, points), (*gradient.shape[:2] * 2, *weights.shape))
            densities += [np.einsum("iaqe,iajbqe,jbqe->qe", g, tensor, g) for g in (gradient_error, wanted_gradient)]
        totals[: len(densities)] += [float(np.sum(weights * density)) for density in densities]
    return ErrorNorms(*np.sqrt(totals).tolist())
