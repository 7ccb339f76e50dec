"""The mesh refined in the contact zones alone: what forces, pressure and shear below the surface still change."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.railway.wheelset.subsurface import maximum_shear
from flangeway.railway.wheelset.wheel_rail_patch import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult

DIVISORS = (1, 2, 4)
"""What the element size in contact is divided by."""


def contact_name(result: WheelsetResult, patch: WheelRailPatch) -> str:
    """Side of a contact and the part of the wheel that touches: ``tread`` or ``flange root``.

    The wheel is one whose tread is a segment of that name.
    """
    wheel = result.model.problem.wheelset.wheel_of(patch.side)
    tread = [name for name in wheel.running_names if name.startswith("tread")]
    in_root = float(patch.wheel_point_mm[0]) < float(wheel.outline.bounds(tread)[0, 0])
    return f"{patch.side} {'flange root' if in_root else 'tread'}"


@dataclass(frozen=True, eq=False)
class RefinedContact:
    """A wheelset with a finer mesh in contact.

    Parameters
    ----------
    divisor
        What the size in contact is divided by.
    result
        The solution.

    """

    divisor: int
    result: WheelsetResult

    @property
    def quantities(self) -> dict[tuple[str, str], float]:
        """Force in N, maximum pressure and maximum shear stresses below in MPa, by patch and quantity."""
        found = {}
        for patch in self.result.patches:
            name = contact_name(self.result, patch)
            found[name, "force"] = float(np.hypot(*patch.force_on_wheel_N))
            found[name, "maximum pressure"] = float(patch.pressure.pressures.max())
            found[name, "maximum shear in the rail"] = maximum_shear(self.result, patch, "rail").value_MPa
            found[name, "maximum shear in the wheel"] = maximum_shear(self.result, patch, "wheel").value_MPa
        return found


def refine_contact(
    case: WheelsetCase, divisors: Sequence[int] = DIVISORS, progress: Callable[[str], None] = lambda _: None
) -> Iterator[RefinedContact]:
    """Solve a case with finer meshes in contact; the size elsewhere stays.

    Parameters
    ----------
    case
        The inputs.
    divisors
        What `contact_size_mm` is divided by.
    progress
        Called with a sentence at each stage.

    """
    values = case.model_dump(exclude_unset=True)
    for divisor in divisors:
        progress(f"element size in contact over {divisor}")
        finer = type(case).from_values({**values, "contact_size_mm": case.contact_size_mm / divisor})
        yield RefinedContact(divisor, finer.run(cold=True).result)
