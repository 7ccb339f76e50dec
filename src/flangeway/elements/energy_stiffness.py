"""Stiffness of one scalar field on a batch of cells, from the energy of its reconstruction."""

from flangeway.elements.reconstruction import Element, Reconstruction
from flangeway.types import Floats


def energy_stiffness(element: Element, reconstruction: Reconstruction, moduli: Floats) -> Floats:
    """Consistency (Moherdaui 2021, 3.69) plus stabilisation.

    Parameters
    ----------
    element
        Element of the cells.
    reconstruction
        Their reconstruction.
    moduli
        Modulus of each cell, shape (n_cells,).

    Returns
    -------
    Floats
        Shape (n_local, n_local, n_cells).

    """
    consistency = reconstruction.value_energy(moduli)
    added = element.stabilise(reconstruction, consistency[None, None])
    return consistency if added is None else consistency + added
