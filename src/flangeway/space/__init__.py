"""Spaces of discrete functions on a mesh."""

from flangeway.space.cell_condensation import CondensedMatrix, InnerUnknowns, assemble_condensed
from flangeway.space.coefficients import CellCoefficient, Coefficient
from flangeway.space.form_matrix import FormMatrix, block_array
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
    "block_array",
    "interpolate",
    "load_vector",
]
