"""Boundary value problems: from a space and data to stiffness and load."""

from flangeway.problems.body import Body
from flangeway.problems.elasticity_problem import ElasticField, Elasticity
from flangeway.problems.harmonic import Foundation, Harmonic, LongitudinalTraction
from flangeway.problems.loads import (
    AppliedLoad,
    BodyForce,
    Gravity,
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
    "AppliedLoad",
    "Body",
    "BodyForce",
    "ElasticField",
    "Elasticity",
    "Foundation",
    "Gravity",
    "Harmonic",
    "LinearBody",
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
