"""Plane elasticity: from a space and a material to stiffness (seed 3.2.6 and 3.3.7)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.elements import Reconstruction
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.space import CellBatch, Space, SymmetricMatrix

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Elasticity:
    """A linear elastic plane body; unknowns are displacements, numbered ``2 * dof + component``.

    Parameters
    ----------
    space
        Space of one displacement component.
    material
        Material of all cells.
    thickness
        Length out of the plane; forces are then forces, not forces per length.

    """

    space: Space
    material: Elastic
    thickness: float = 1.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.thickness) and self.thickness > 0.0):
            raise InputError(
                f"Elasticity(thickness={self.thickness})",
                "a positive length",
                "take 1 for forces per length",
            )

    def stiffness(self) -> SymmetricMatrix:
        """Stiffness matrix of the whole body, no unknown held."""
        return self.space.assemble(self.cell_stiffness, n_components=2)

    def cell_stiffness(self, batch: CellBatch) -> Floats:
        """Stiffness of cells: consistency (seed 3.93) plus stabilisation, (2 n_local, 2 n_local, n_cells)."""
        reconstruction = batch.element.reconstruct(batch.vertices)
        by_component = self._consistency(reconstruction)
        stabilisation = batch.element.stabilise(reconstruction, by_component)
        if stabilisation is not None:
            by_component[0, 0] += stabilisation
            by_component[1, 1] += stabilisation
        n = 2 * reconstruction.n_local
        return self.thickness * by_component.transpose(2, 0, 3, 1, 4).reshape(n, n, -1)

    def _consistency(self, reconstruction: Reconstruction) -> Floats:
        gradient = reconstruction.gradient
        weighted = np.einsum("abe,bqne->aqne", reconstruction.mass, gradient)
        products = np.einsum("apme,aqne->pqmne", gradient, weighted)
        moduli = self.material.stiffness.transpose(0, 2, 1, 3)
        result: Floats = np.einsum("ijpq,pqmne->ijmne", moduli, products)
        return result

    def cell_stresses(self, batch: CellBatch, displacement: Floats) -> tuple[Reconstruction, Floats]:
        """Stresses inside cells as polynomials of degree k - 1, from the reconstruction.

        Parameters
        ----------
        batch
            The cells.
        displacement
            All unknowns, shape (2 n_dofs,).

        Returns
        -------
        tuple
            The reconstruction, whose frame the polynomials are written in, and the coefficients of the components
            xx, yy, xy, zz, shape (4, n_monomials(k - 1), n_cells).

        """
        reconstruction = batch.element.reconstruct(batch.vertices)
        local = displacement.reshape(-1, 2)[batch.dofs]
        gradient = np.einsum("ajme,mei->ijae", reconstruction.gradient, local)
        stress = np.einsum("ijkl,klae->ijae", self.material.stiffness, gradient)
        normal = np.einsum("kl,klae->ae", self.material.out_of_plane, gradient)
        return reconstruction, np.stack((stress[0, 0], stress[1, 1], stress[0, 1], normal))
