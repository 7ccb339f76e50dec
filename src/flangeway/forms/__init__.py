"""One's own problem: forms in a few lines on any space, solved by SciPy, with norms of the error and their rates."""

from flangeway.forms.assembled import load, mass, modes, solve, stiffness
from flangeway.forms.convergence import convergence
from flangeway.post import error_norms
from flangeway.space import interpolate

__all__ = ["convergence", "error_norms", "interpolate", "load", "mass", "modes", "solve", "stiffness"]
