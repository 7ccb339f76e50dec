"""What is computed from a solution: stresses, contact pressure, section constants, error norms."""

from flangeway.post.adaptive import (
    AdaptiveRun,
    AdaptiveStep,
    adapt,
    stress_errors,
)
from flangeway.post.contact_checks import ContactChecks, check_contact, cut_zones
from flangeway.post.lines import (
    CutForce,
    StressLine,
    displacements_at,
    force_through_cut,
    locate,
    stresses_along,
    stresses_at,
)
from flangeway.post.norms import ErrorNorms, error_norms
from flangeway.post.pressure import ContactLine, PressurePatch, contact_lines, pressure_patches
from flangeway.post.reactions import Reaction, nodal_residual, reactions, relative_nodal_residual
from flangeway.post.recovery import RecoveredStresses, recovered_stresses
from flangeway.post.section_constants import SectionConstants, section_constants
from flangeway.post.stress import (
    Stresses,
    cell_stresses,
    corner_shear_stresses,
    corner_stresses,
    nodal_stresses,
    shear_stresses,
)

__all__ = [
    "AdaptiveRun",
    "AdaptiveStep",
    "ContactChecks",
    "ContactLine",
    "CutForce",
    "ErrorNorms",
    "PressurePatch",
    "Reaction",
    "RecoveredStresses",
    "SectionConstants",
    "StressLine",
    "Stresses",
    "adapt",
    "cell_stresses",
    "check_contact",
    "contact_lines",
    "corner_shear_stresses",
    "corner_stresses",
    "cut_zones",
    "displacements_at",
    "error_norms",
    "force_through_cut",
    "locate",
    "nodal_residual",
    "nodal_stresses",
    "pressure_patches",
    "reactions",
    "recovered_stresses",
    "relative_nodal_residual",
    "section_constants",
    "shear_stresses",
    "stress_errors",
    "stresses_along",
    "stresses_at",
]
