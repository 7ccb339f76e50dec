"""Run a case: from its inputs to a solved problem and the summary of it."""

import time
from dataclasses import dataclass
from typing import Any

from flangeway.cases.case import Progress
from flangeway.cases.wheelset.summary import summarise
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset
from flangeway.solve import Status


@dataclass(frozen=True, eq=False)
class CaseRun:
    """A case and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    result
        The solution.
    summary
        What ``summary.json`` holds; see `flangeway.cases.summarise`.

    """

    case: WheelsetCase
    result: WheelsetResult
    summary: dict[str, Any]

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.result.status


def run_case(case: WheelsetCase, progress: Progress = lambda _: None, *, cold: bool = False) -> CaseRun:
    """Solve a case.

    Parameters
    ----------
    case
        The inputs.
    progress
        Called with a sentence at each stage.
    cold
        See `flangeway.railway.wheelset.wheelset_result.solve_wheelset`.

    Raises
    ------
    InputError
        If the inputs make no problem that can be solved.
    MissingLibraryError
        If the mesh generator lacks a shared library of the system.

    """
    start = time.perf_counter()
    result = solve_wheelset(case.problem(), progress, cold=cold)
    return CaseRun(case, result, summarise(case, result, time.perf_counter() - start))
