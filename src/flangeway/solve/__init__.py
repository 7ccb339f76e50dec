"""Linear solvers, condensation, handles, laws of contact, and adaptive steps."""

from flangeway.solve.body_response import BodyResponse, SurfaceNodes
from flangeway.solve.condensed import CondensedBodies, condensed_bytes
from flangeway.solve.elasticity_solution import ElasticitySolution, solve_elasticity
from flangeway.solve.handles import Handle
from flangeway.solve.harmonic_solution import HarmonicSolution, solve_harmonic
from flangeway.solve.nonlinear_solution import NonlinearSolution, solve_nonlinear
from flangeway.solve.sparse import SparseBodies
from flangeway.solve.status import Checks, Iteration, NewtonSettings, Status
from flangeway.solve.steps import StepSettings, follow
from flangeway.solve.surface_cells import SurfaceCells
from flangeway.solve.surface_compliance import ComplianceTable, compliance_table
from flangeway.solve.torsion_solution import TorsionSolution, solve_torsion

__all__ = [
    "BodyResponse",
    "Checks",
    "ComplianceTable",
    "CondensedBodies",
    "ElasticitySolution",
    "Handle",
    "HarmonicSolution",
    "Iteration",
    "NewtonSettings",
    "NonlinearSolution",
    "SparseBodies",
    "Status",
    "StepSettings",
    "SurfaceCells",
    "SurfaceNodes",
    "TorsionSolution",
    "compliance_table",
    "condensed_bytes",
    "follow",
    "solve_elasticity",
    "solve_harmonic",
    "solve_nonlinear",
    "solve_torsion",
]
