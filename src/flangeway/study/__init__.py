"""Cases by name, their inputs, their runs, and what these leave for programs to read."""

from flangeway.study.adaptive import AdaptiveRun, AdaptiveStep, adapt
from flangeway.study.bodies_run import BodiesRun, BodyResult
from flangeway.study.case import Case, Run, RunnableCase
from flangeway.study.case_file import load_case
from flangeway.study.case_template import schema, write_template
from flangeway.study.cases import CASES, find_case
from flangeway.study.convergence import Convergence, run_halved
from flangeway.study.cook import CookCode, CookRow, cook_row, solve_cook
from flangeway.study.l_shape import l_shape, solve_l_shape
from flangeway.study.output import refuse_unwritable, write_together
from flangeway.study.refinement import RefinementRow, refine_adaptively, refine_uniformly, stress_errors
from flangeway.study.runner import CaseRun, run_case
from flangeway.study.summary import summarise, write_summary
from flangeway.study.wheelset_case import WheelsetCase
from flangeway.study.wheelset_curve import WheelsetCurveCase
from flangeway.study.wheelset_tangent import WheelsetTangentCase

__all__ = [
    "CASES",
    "AdaptiveRun",
    "AdaptiveStep",
    "BodiesRun",
    "BodyResult",
    "Case",
    "CaseRun",
    "Convergence",
    "CookCode",
    "CookRow",
    "RefinementRow",
    "Run",
    "RunnableCase",
    "WheelsetCase",
    "WheelsetCurveCase",
    "WheelsetTangentCase",
    "adapt",
    "cook_row",
    "find_case",
    "l_shape",
    "load_case",
    "refine_adaptively",
    "refine_uniformly",
    "refuse_unwritable",
    "run_case",
    "run_halved",
    "schema",
    "solve_cook",
    "solve_l_shape",
    "stress_errors",
    "summarise",
    "write_summary",
    "write_template",
    "write_together",
]
