"""Spaces of discrete functions on a mesh."""

from flangeway.space.cell_condensation import CondensedMatrix, InnerUnknowns, assemble_condensed
from flangeway.space.coefficients import CellCoefficient, Coefficient
from flangeway.space.form_matrix import FormMatrix
from flangeway.space.functions import interpolate, load_vector
from flangeway.space.spaces import CellBatch, Space
from flangeway.space.symmetric import DifferenceProduct, SymmetricMatrix

__all__ = [
    "CellBatch",
    "CellCoefficient",
    "Coefficient",
    "CondensedMatrix",
    "DifferenceProduct",
    "FormMatrix",
    "InnerUnknowns",
    "Space",
    "SymmetricMatrix",
    "assemble_condensed",
    "interpolate",
    "load_vector",
]
