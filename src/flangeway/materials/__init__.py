"""Materials."""

from flangeway.materials.elastic import Elastic

__all__ = ["Elastic"]
