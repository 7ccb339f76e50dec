"""The cases that can be run, by name."""

from flangeway.errors import InputError
from flangeway.study.case import closest
from flangeway.study.wheelset_tangent import WheelsetTangentCase

CASES = {case.name: case for case in (WheelsetTangentCase,)}
"""Types of the cases by name."""


def find_case(name: str) -> type[WheelsetTangentCase]:
    """Return the type of the case with a name.

    Raises
    ------
    InputError
        If there is none; the message lists those there are and names the nearest.

    """
    if name not in CASES:
        raise InputError(f"a case called {name!r}", f"one of: {', '.join(CASES)}", closest(name, list(CASES)))
    return CASES[name]
