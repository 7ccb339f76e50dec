"""Cases by name, their inputs, their runs, and what these leave for programs to read."""

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult, TwoBodiesCase
from flangeway.cases.case import Case, Convergence, RunnableCase, run_halved
from flangeway.cases.case_file import CASES, find_case, load_case, schema, write_template
from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.wheelset_case import Wheelset, WheelsetRun

__all__ = [
    "CASES",
    "BodiesRun",
    "BodyResult",
    "Case",
    "Convergence",
    "RunResult",
    "RunnableCase",
    "TwoBodiesCase",
    "Wheelset",
    "WheelsetRun",
    "find_case",
    "load_case",
    "run_halved",
    "schema",
    "write_template",
]
