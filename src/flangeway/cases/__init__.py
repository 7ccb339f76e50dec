"""Cases by name, their inputs, their runs, and what these leave for programs to read."""

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult, TwoBodiesCase
from flangeway.cases.bodies.presets import NEARLY_INCOMPRESSIBLE_WORK, CookCode, cook_grid, solve_cook
from flangeway.cases.case import Case, Convergence, RunnableCase, run_halved
from flangeway.cases.case_file import CASES, find_case, load_case, schema, write_template
from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.wheelset_case import Wheelset, WheelsetRun

__all__ = [
    "CASES",
    "NEARLY_INCOMPRESSIBLE_WORK",
    "BodiesRun",
    "BodyResult",
    "Case",
    "Convergence",
    "CookCode",
    "RunResult",
    "RunnableCase",
    "TwoBodiesCase",
    "Wheelset",
    "WheelsetRun",
    "cook_grid",
    "find_case",
    "load_case",
    "run_halved",
    "schema",
    "solve_cook",
    "write_template",
]
