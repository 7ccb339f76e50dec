"""Boundary value problems: from a space and data to stiffness and load."""

from flangeway.problems.body import Body, Part
from flangeway.problems.elasticity_problem import Elasticity
from flangeway.problems.field import ElasticField
from flangeway.problems.harmonic import Foundation, Harmonic, LongitudinalTraction
from flangeway.problems.loads import BodyForce, Gravity, Load, PointForce, Pressure, TemperatureChange, Traction
from flangeway.problems.supports import PrescribedDisplacement, RigidHandle, Spring, Support, fixed
from flangeway.problems.torsion_problem import Torsion

__all__ = [
    "Body",
    "BodyForce",
    "ElasticField",
    "Elasticity",
    "Foundation",
    "Gravity",
    "Harmonic",
    "Load",
    "LongitudinalTraction",
    "Part",
    "PointForce",
    "PrescribedDisplacement",
    "Pressure",
    "RigidHandle",
    "Spring",
    "Support",
    "TemperatureChange",
    "Torsion",
    "Traction",
    "fixed",
]
