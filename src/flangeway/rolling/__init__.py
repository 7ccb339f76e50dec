"""One contact patch that rolls with friction: cells and pressures, creepages, and creep forces by five theories."""

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.exact_rolling import creep_curve, roll
from flangeway.contact.rolling.fast_theories import fastrip, fastsim, linear_theory, polach
from flangeway.contact.rolling.friction import Friction, Heat, Heating, SlopeReduction
from flangeway.contact.rolling.rolling_contact import Creepages, RollingContact

__all__ = [
    "Creepages",
    "EllipticContact",
    "Friction",
    "Heat",
    "Heating",
    "PatchGrid",
    "RollingContact",
    "SlopeReduction",
    "creep_curve",
    "fastrip",
    "fastsim",
    "linear_theory",
    "polach",
    "roll",
]
