"""Spaces of discrete functions on a mesh."""

from flangeway.space.space import CellBatch, Space
from flangeway.space.symmetric import SymmetricMatrix

__all__ = ["CellBatch", "Space", "SymmetricMatrix"]
