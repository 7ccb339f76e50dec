"""The mathematics of one cell, for whole batches of cells, element index last."""

from flangeway.elements.cell_matrices import CellMatrices, cell_matrices
from flangeway.elements.lagrange import Lagrange
from flangeway.elements.monomials import Frame
from flangeway.elements.polyhedra import Polyhedra, PolyhedralCells
from flangeway.elements.quadrature import polygon_quadrature
from flangeway.elements.reconstruction import (
    DiagonalStabilisation,
    Element,
    Function,
    IdentityStabilisation,
    NoStabilisation,
    Reconstruction,
    SpectralStabilisation,
    Stabilisation,
    TraceStabilisation,
    energy_stiffness,
    missed_mass,
)
from flangeway.elements.virtual import Serendipity, StabilisationFree, Virtual

__all__ = [
    "CellMatrices",
    "DiagonalStabilisation",
    "Element",
    "Frame",
    "Function",
    "IdentityStabilisation",
    "Lagrange",
    "NoStabilisation",
    "Polyhedra",
    "PolyhedralCells",
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
