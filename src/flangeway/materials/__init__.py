"""Materials."""

from flangeway.materials.elastic import Elastic
from flangeway.materials.material import Hypothesis, Material
from flangeway.materials.nonlinear_material import J2Plasticity, NeoHooke, NonlinearMaterial, Response
from flangeway.materials.orthotropic import Orthotropic

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
