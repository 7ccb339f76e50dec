"""The mathematics of one cell, for whole batches of cells, element index last."""

from flangeway.elements.cell_matrices import CellMatrices, cell_matrices
from flangeway.elements.energy_stiffness import energy_stiffness
from flangeway.elements.lagrange import Lagrange
from flangeway.elements.monomials import Frame
from flangeway.elements.polygon_quadrature import polygon_quadrature
from flangeway.elements.reconstruction import Element, Function, Reconstruction
from flangeway.elements.serendipity import Serendipity
from flangeway.elements.stabilisation import (
    DiagonalStabilisation,
    IdentityStabilisation,
    NoStabilisation,
    SpectralStabilisation,
    Stabilisation,
    TraceStabilisation,
    missed_mass,
)
from flangeway.elements.stabilisation_free import StabilisationFree
from flangeway.elements.virtual import Virtual

__all__ = [
    "CellMatrices",
    "DiagonalStabilisation",
    "Element",
    "Frame",
    "Function",
    "IdentityStabilisation",
    "Lagrange",
    "NoStabilisation",
    "Reconstruction",
    "Serendipity",
    "SpectralStabilisation",
    "Stabilisation",
    "StabilisationFree",
    "TraceStabilisation",
    "Virtual",
    "cell_matrices",
    "energy_stiffness",
    "missed_mass",
    "polygon_quadrature",
]
