"""The cases that can be run, by name."""

from flangeway.cases.bodies.contact_patch_case import ContactPatchCase
from flangeway.cases.bodies.cook_case import CookCase
from flangeway.cases.bodies.hertz_case import HertzCase
from flangeway.cases.bodies.two_bodies import TwoBodiesCase
from flangeway.cases.case import RunnableCase, closest
from flangeway.cases.section.torsion_case import TorsionCase
from flangeway.cases.wheelset.wheelset_curve import WheelsetCurveCase
from flangeway.cases.wheelset.wheelset_tangent import WheelsetTangentCase
from flangeway.errors import InputError

CASES: dict[str, type[RunnableCase]] = {
    case.name: case
    for case in (
        *(WheelsetTangentCase, WheelsetCurveCase),
        *(HertzCase, ContactPatchCase, CookCase, TorsionCase, TwoBodiesCase),
    )
}
"""Types of the cases by name."""


def find_case(name: str) -> type[RunnableCase]:
    """Return the type of the case with a name.

    Raises
    ------
    InputError
        If there is none; the message lists those there are and names the nearest.

    """
    if name not in CASES:
        raise InputError(f"a case called {name!r}", f"one of: {', '.join(CASES)}", closest(name, list(CASES)))
    return CASES[name]
