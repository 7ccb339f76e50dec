"""Linear solvers, condensation, handles, laws of contact, and adaptive steps."""

from flangeway.solve.body_response import BodyResponse, SurfaceNodes
from flangeway.solve.condensed import CondensedBodies, SparseBodies, condensed_bytes
from flangeway.solve.handles import Handle
from flangeway.solve.nonlinear_solution import NonlinearSolution, solve_nonlinear
from flangeway.solve.solutions import (
    ElasticitySolution,
    HarmonicSolution,
    TorsionSolution,
    solve_elasticity,
    solve_harmonic,
    solve_torsion,
)
from flangeway.solve.status import Checks, Iteration, NewtonSettings, Status, StepSettings, follow
from flangeway.solve.surface_compliance import ComplianceTable, SurfaceCells, compliance_table

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
