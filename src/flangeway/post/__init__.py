"""What is computed from a solution: stresses, contact pressure, section constants, error norms."""

from flangeway.post.norms import ErrorNorms, error_norms
from flangeway.post.pressure import PressurePatch, pressure_patches
from flangeway.post.section import SectionConstants, section_constants
from flangeway.post.stress import Stresses, cell_stresses, corner_stresses
from flangeway.post.torsion import corner_shear_stresses, shear_stresses

__all__ = [
    "ErrorNorms",
    "PressurePatch",
    "SectionConstants",
    "Stresses",
    "cell_stresses",
    "corner_shear_stresses",
    "corner_stresses",
    "error_norms",
    "pressure_patches",
    "section_constants",
    "shear_stresses",
]
