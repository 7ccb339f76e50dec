"""Materials."""

from flangeway.materials.elastic import Elastic, Hypothesis, Material, Orthotropic
from flangeway.materials.nonlinear_material import J2Plasticity, NeoHooke, NonlinearMaterial, Response

__all__ = [
    "Elastic",
    "Hypothesis",
    "J2Plasticity",
    "Material",
    "NeoHooke",
    "NonlinearMaterial",
    "Orthotropic",
    "Response",
]
