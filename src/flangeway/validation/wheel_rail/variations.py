"""Variations of a wheelset: ever stiffer material beside the rigid wheelset, and finer meshes in contact."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.errors import InputError
from flangeway.railway.rigid.rigid_equilibrium import RigidPosition
from flangeway.railway.wheelset.subsurface import maximum_shear
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.types import Floats

FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
"""Factors on Young's modulus."""
DIVISORS = (1, 2, 4)
"""Divisors of the element size in contact."""
ROLL_ARM_MM = 750.0
"""Half the distance of the contacts: turns a roll into a length."""


@dataclass(frozen=True, eq=False)
class StiffenedWheelset:
    """A wheelset of raised Young's modulus, and its distance from the rigid one.

    Parameters
    ----------
    factor
        Factor on Young's modulus.
    result
        Elastic solution.

    """

    factor: float
    result: WheelsetResult

    @cached_property
    def rigid(self) -> RigidPosition:
        """Rigid equilibrium of the same inputs, from which the elastic search started."""
        equilibrium = self.result.model.rigid_start.equilibrium
        if equilibrium is None:
            raise InputError("a prescribed lateral displacement", "a wheelset in equilibrium", "leave lateral_mm out")
        return equilibrium.reached()

    @cached_property
    def position_differences_mm(self) -> Floats:
        """Lateral and vertical displacement in the track's axes, and roll times `ROLL_ARM_MM`, elastic less rigid."""
        one, other = self.result.equilibrium.position, self.rigid.motion
        return np.array(
            (
                one.lateral_mm - other.lateral_mm,
                one.vertical_mm - other.vertical_mm,
                ROLL_ARM_MM * (one.roll_rad - other.roll_rad),
            )
        )

    @cached_property
    def point_distances_mm(self) -> Floats:
        """Distance on the rail of each rigid contact point from the nearest elastic centre of pressure of its side."""
        distances = []
        for contact in self.rigid.contacts:
            mine = [patch.rail_point_mm for patch in self.result.patches if patch.side == contact.side]
            apart = [float(np.hypot(*(point - np.array(contact.rail_point_mm)))) for point in mine]
            distances.append(min(apart, default=np.inf))
        return np.array(distances)


def extrapolated_differences_mm(stiffened: Sequence[StiffenedWheelset]) -> Floats:
    """Position differences extrapolated as 1/E to an infinite Young's modulus E, from the last two."""
    one, other = stiffened[-2:]
    share = other.factor / (other.factor - one.factor)
    return share * other.position_differences_mm + (1.0 - share) * one.position_differences_mm


def rigid_limit(
    case: WheelsetCase, factors: Sequence[float] = FACTORS, progress: Callable[[str], None] = lambda _: None
) -> Iterator[StiffenedWheelset]:
    """Solve a case with the Young's modulus of all bodies multiplied by factors."""
    values = case.model_dump(exclude_unset=True)
    for factor in factors:
        progress(f"Young's modulus times {factor:g}")
        raised = type(case).from_values({**values, "young_MPa": factor * case.young_MPa})
        yield StiffenedWheelset(factor, raised.run(cold=True).result)


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
        Divisor of the element size in contact.
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
    """Solve a case with `contact_size_mm` divided by divisors; the size elsewhere is unchanged."""
    values = case.model_dump(exclude_unset=True)
    for divisor in divisors:
        progress(f"element size in contact over {divisor}")
        finer = type(case).from_values({**values, "contact_size_mm": case.contact_size_mm / divisor})
        yield RefinedContact(divisor, finer.run(cold=True).result)
