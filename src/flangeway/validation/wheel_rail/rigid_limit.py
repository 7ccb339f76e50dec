"""Elastic wheelsets of ever stiffer material beside the rigid one, from the same inputs."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.errors import InputError
from flangeway.railway.rigid.rigid_equilibrium import RigidPosition
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.types import Floats

FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)
"""Factors on Young's modulus."""

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
        """Rigid balance of the same inputs, from which the elastic search started."""
        equilibrium = self.result.model.rigid_start.equilibrium
        if equilibrium is None:
            raise InputError("a prescribed lateral motion", "a wheelset in balance", "leave lateral_mm out")
        return equilibrium.reached()

    @cached_property
    def position_differences_mm(self) -> Floats:
        """Lateral and vertical motion in the track's axes, and roll times `ROLL_ARM_MM`, elastic less rigid."""
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
    """Position differences for an infinite Young's modulus E, from the last two: what is left falls as 1/E."""
    one, other = stiffened[-2:]
    share = other.factor / (other.factor - one.factor)
    return share * other.position_differences_mm + (1.0 - share) * one.position_differences_mm


def rigid_limit(
    case: WheelsetCase, factors: Sequence[float] = FACTORS, progress: Callable[[str], None] = lambda _: None
) -> Iterator[StiffenedWheelset]:
    """Solve a case with Young's modulus raised by factors.

    Parameters
    ----------
    case
        The inputs; both motions are measured from the same reference position.
    factors
        Factors on the Young's modulus of all bodies.
    progress
        Called with a sentence at each stage.

    """
    values = case.model_dump(exclude_unset=True)
    for factor in factors:
        progress(f"Young's modulus times {factor:g}")
        raised = type(case).from_values({**values, "young_MPa": factor * case.young_MPa})
        yield StiffenedWheelset(factor, raised.run(cold=True).result)
