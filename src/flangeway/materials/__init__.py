"""Materials."""

from flangeway.materials.elastic import Elastic
from flangeway.materials.material import Hypothesis, Material
from flangeway.materials.orthotropic import Orthotropic

__all__ = [
    "Elastic",
    "Hypothesis",
    "Material",
    "Orthotropic",
]
