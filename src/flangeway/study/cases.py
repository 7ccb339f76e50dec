"""The cases that can be run, by name."""

from flangeway.errors import InputError
from flangeway.study.case import closest
from flangeway.study.wheelset_case import WheelsetCase
from flangeway.study.wheelset_curve import WheelsetCurveCase
from flangeway.study.wheelset_tangent import WheelsetTangentCase

CASES: dict[str, type[WheelsetCase]] = {case.name: case for case in (WheelsetTangentCase, WheelsetCurveCase)}
"""Types of the cases by name."""


def find_case(name: str) -> type[WheelsetCase]:
    """Return the type of the case with a name.

    Raises
    ------
    InputError
        If there is none; the message lists those there are and names the nearest.

    """
    if name not in CASES:
        raise InputError(f"a case called {name!r}", f"one of: {', '.join(CASES)}", closest(name, list(CASES)))
    return CASES[name]
