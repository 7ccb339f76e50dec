"""Boundary value problems: from a space and data to stiffness and load."""

from flangeway.problems.body import Body, Part
from flangeway.problems.elasticity_problem import Elasticity
from flangeway.problems.field import ElasticField
from flangeway.problems.harmonic import Foundation, Harmonic, LongitudinalTraction
from flangeway.problems.linear_body import LinearBody
from flangeway.problems.loads import BodyForce, Gravity, Load, PointForce, Pressure, TemperatureChange, Traction
from flangeway.problems.stiffness_body import StiffnessBody
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
    "LinearBody",
    "Load",
    "LongitudinalTraction",
    "Part",
    "PointForce",
    "PrescribedDisplacement",
    "Pressure",
    "RigidHandle",
    "Spring",
    "StiffnessBody",
    "Support",
    "TemperatureChange",
    "Torsion",
    "Traction",
    "fixed",
]
