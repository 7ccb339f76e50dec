"""Cases by name, their inputs, their runs, and what these leave for programs to read."""

from flangeway.study.case import Case
from flangeway.study.cases import CASES, find_case
from flangeway.study.convergence import Convergence, run_halved
from flangeway.study.output import refuse_unwritable, write_together
from flangeway.study.runner import CaseRun, run_case
from flangeway.study.summary import summarise, write_summary
from flangeway.study.wheelset_tangent import WheelsetTangentCase

__all__ = [
    "CASES",
    "Case",
    "CaseRun",
    "Convergence",
    "WheelsetTangentCase",
    "find_case",
    "refuse_unwritable",
    "run_case",
    "run_halved",
    "summarise",
    "write_summary",
    "write_together",
]
