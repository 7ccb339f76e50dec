"""The mathematics of one cell, for whole batches of cells, element index last."""

from flangeway.elements.lagrange import Lagrange
from flangeway.elements.reconstruction import Element, Reconstruction
from flangeway.elements.virtual import Virtual

__all__ = ["Element", "Lagrange", "Reconstruction", "Virtual"]
