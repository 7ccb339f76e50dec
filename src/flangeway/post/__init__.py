"""What is computed from a solution: stresses and contact pressure."""

from flangeway.post.pressure import PressurePatch, pressure_patches
from flangeway.post.stress import Stresses, cell_stresses, corner_stresses

__all__ = ["PressurePatch", "Stresses", "cell_stresses", "corner_stresses", "pressure_patches"]
