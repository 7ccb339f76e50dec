"""Spaces of discrete functions on a mesh."""

from flangeway.space.cell_condensation import CondensedMatrix, InnerUnknowns, assemble_condensed
from flangeway.space.functions import CellCoefficient, Coefficient, interpolate, load_vector
from flangeway.space.spaces import CellBatch, Mesh, Space
from flangeway.space.symmetric import DifferenceProduct, FormMatrix, SymmetricMatrix, block_array

__all__ = [
    "CellBatch",
    "CellCoefficient",
    "Coefficient",
    "CondensedMatrix",
    "DifferenceProduct",
    "FormMatrix",
    "InnerUnknowns",
    "Mesh",
    "Space",
    "SymmetricMatrix",
    "assemble_condensed",
    "block_array",
    "interpolate",
    "load_vector",
]
