"""Linear solvers, condensation, Newton's method for contact, and adaptive steps."""

from flangeway.solve.bodies import BodyResponse, SurfaceNodes
from flangeway.solve.cache import Cache, CacheWarning
from flangeway.solve.condensed import CondensedBodies
from flangeway.solve.elasticity import ElasticitySolution, solve_elasticity
from flangeway.solve.linearisation import Constraints, Linearisation
from flangeway.solve.newton import ContactState, Iteration, NewtonSettings, solve_contact
from flangeway.solve.sparse import SparseBodies
from flangeway.solve.status import Status
from flangeway.solve.steps import StepSettings, follow
from flangeway.solve.torsion import TorsionSolution, solve_torsion

__all__ = [
    "BodyResponse",
    "Cache",
    "CacheWarning",
    "CondensedBodies",
    "Constraints",
    "ContactState",
    "ElasticitySolution",
    "Iteration",
    "Linearisation",
    "NewtonSettings",
    "SparseBodies",
    "Status",
    "StepSettings",
    "SurfaceNodes",
    "TorsionSolution",
    "follow",
    "solve_contact",
    "solve_elasticity",
    "solve_torsion",
]
