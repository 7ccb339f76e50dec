"""Boundary value problems: from a space and data to stiffness and load."""

from flangeway.problems.body import Body
from flangeway.problems.elasticity import Elasticity
from flangeway.problems.part import Part
from flangeway.problems.torsion import Torsion

__all__ = ["Body", "Elasticity", "Part", "Torsion"]
