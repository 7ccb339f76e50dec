"""Spaces of discrete functions on a mesh."""

from flangeway.space.functions import interpolate, load_vector
from flangeway.space.space import CellBatch, Space
from flangeway.space.symmetric import SymmetricMatrix

__all__ = ["CellBatch", "Space", "SymmetricMatrix", "interpolate", "load_vector"]
