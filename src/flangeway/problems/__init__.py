"""Boundary value problems: from a space and data to stiffness and load."""

from flangeway.problems.body import Body
from flangeway.problems.elasticity_problem import ElasticField, Elasticity
from flangeway.problems.harmonic import Foundation, Harmonic, LongitudinalTraction
from flangeway.problems.loads import (
    BodyForce,
    Gravity,
    Load,
    PointForce,
    PrescribedDisplacement,
    Pressure,
    RigidHandle,
    Spring,
    Support,
    TemperatureChange,
    Traction,
    fixed,
)
from flangeway.problems.stiffness_body import LinearBody, Part, StiffnessBody
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
