"""What is computed from a solution: stresses, contact pressure, section constants, error norms."""

from flangeway.post.contact_doubts import ContactDoubts, contact_doubts, cut_zones
from flangeway.post.lines import CutForce, StressLine, displacements_at, force_through_cut, stresses_along, stresses_at
from flangeway.post.location import locate
from flangeway.post.nodal_balance import nodal_imbalance, nodal_residual
from flangeway.post.norms import ErrorNorms, error_norms
from flangeway.post.overlap import Overlap, deepest_overlap
from flangeway.post.pressure import PressurePatch, pressure_patches
from flangeway.post.reactions import Reaction, reactions
from flangeway.post.recovery import RecoveredStresses, recovered_stresses
from flangeway.post.section import SectionConstants, section_constants
from flangeway.post.stress import Stresses, cell_stresses, corner_stresses, nodal_stresses
from flangeway.post.torsion import corner_shear_stresses, shear_stresses

__all__ = [
    "ContactDoubts",
    "CutForce",
    "ErrorNorms",
    "Overlap",
    "PressurePatch",
    "Reaction",
    "RecoveredStresses",
    "SectionConstants",
    "StressLine",
    "Stresses",
    "cell_stresses",
    "contact_doubts",
    "corner_shear_stresses",
    "corner_stresses",
    "cut_zones",
    "deepest_overlap",
    "displacements_at",
    "error_norms",
    "force_through_cut",
    "locate",
    "nodal_imbalance",
    "nodal_residual",
    "nodal_stresses",
    "pressure_patches",
    "reactions",
    "recovered_stresses",
    "section_constants",
    "shear_stresses",
    "stresses_along",
    "stresses_at",
]
