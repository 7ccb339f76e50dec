"""One's own problem: forms in a few lines on any space, their solution, time steps, and rates of the error."""

from flangeway.forms.plate import Plate
from flangeway.forms.section import BeamSection
from flangeway.forms.solution import (
    NewtonSolution,
    buckling,
    convergence,
    modes,
    newmark_steps,
    newton,
    solve,
    theta_steps,
)
from flangeway.forms.stokes import StokesSolution, stokes, stokes_matrix
from flangeway.forms.weak import Field, bilinear, linear, load, mass, stiffness
from flangeway.post import error_norms
from flangeway.solve.linear import Factor
from flangeway.space import block_array, interpolate

__all__ = [
    "BeamSection",
    "Factor",
    "Field",
    "NewtonSolution",
    "Plate",
    "StokesSolution",
    "bilinear",
    "block_array",
    "buckling",
    "convergence",
    "error_norms",
    "interpolate",
    "linear",
    "load",
    "mass",
    "modes",
    "newmark_steps",
    "newton",
    "solve",
    "stiffness",
    "stokes",
    "stokes_matrix",
    "theta_steps",
]
