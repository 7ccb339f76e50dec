"""An equilibrium of a wheelset (Moherdaui 2021, 7.2.1)."""

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from flangeway.railway.track.placements import SIDES, Side, WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.solve import Status
from flangeway.types import Floats

LATERAL_REFERENCE_N = 28.4e3
"""Reference of the lateral residual in both situations: the centrifugal force of the curve (Moherdaui 2021, 7.2.2)."""

TOLERANCE = 1e-9
"""Equilibrium residual up to which a position is in equilibrium; a single one is iterated further, to round-off."""

MAX_STEP = np.array([0.6, 0.6, 6e-4])
"""Step limits in mm, mm and rad: the lateral stiffness jumps when a flange touches."""


def load_on_axle(problem: WheelsetProblem, roll: float) -> Floats:
    """Load in the track's axes, and its moment about the axle's middle at a roll, shape (3,).

    It acts at the centre of gravity: to the right in the track's plane, and onto it.
    """
    load, (along, onto), sine, cosine = problem.forces, problem.forces.in_track, np.sin(roll), np.cos(roll)
    moment = load.height_mm * (sine * onto - cosine * along) - load.offset_mm * (cosine * onto + sine * along)
    return np.array([along, -onto, moment])


def moment_by_roll(problem: WheelsetProblem, roll: float) -> float:
    """Derivative of that moment by the roll."""
    load, (along, onto), sine, cosine = problem.forces, problem.forces.in_track, np.sin(roll), np.cos(roll)
    return float(load.height_mm * (cosine * onto + sine * along) + load.offset_mm * (sine * onto - cosine * along))


@dataclass(frozen=True)
class RelativeResiduals:
    """Relative residuals of the equilibrium (Moherdaui 2021, 7.2.2).

    - `vertical_residual`: residual of the vertical force over the weight.
    - `lateral_residual`: residual of the lateral force over 28.4 kN.
    - `moment_residual`: residual of the moment about the axle's middle over the weight times half of the distance
      between the wheels.
    - `free`: which of lateral and vertical displacement and roll are found; the others are prescribed, and their
      residuals are what holds the wheelset.
    - `torque_residual`: with friction, residual of the torque about the axle over the weight times the wheel's radius.
    - `yaw_residual`: with friction and a yaw that is found, residual of the yaw moment over the weight times half of
      the distance between the wheels.
    """

    vertical_residual: float
    lateral_residual: float
    moment_residual: float
    free: tuple[bool, bool, bool] = (True, True, True)
    torque_residual: float = 0.0
    yaw_residual: float = 0.0

    @property
    def equilibrium_residual(self) -> float:
        """Root of the sum of squares of the residuals of what is free."""
        relative = self.lateral_residual, self.vertical_residual, self.moment_residual
        of_free = (residual for residual, free in zip(relative, self.free, strict=True) if free)
        return math.hypot(*of_free, self.torque_residual, self.yaw_residual)


def with_loads(
    problem: WheelsetProblem, position: WheelsetPosition, on_axle: Floats
) -> tuple[Floats, RelativeResiduals]:
    """Residual and relative residuals by the contact's force on the wheels and moment about the axle's middle (3,)."""
    weight, arm = problem.forces.vertical_N, problem.wheels.distance_mm / 2.0
    residual: Floats = on_axle + load_on_axle(problem, position.roll_rad)
    lateral, vertical, moment = residual / (LATERAL_REFERENCE_N, weight, weight * arm)
    free = tuple(value is None for value in problem.position.components)
    return residual, RelativeResiduals(float(vertical), float(lateral), float(moment), (free[0], free[1], free[2]))


def is_stable(problem: WheelsetProblem, jacobian: Floats) -> bool:
    """Whether a wheelset in equilibrium comes back after a small push: contact and load have a potential.

    - `problem`: the wheelset, nothing prescribed.
    - `jacobian`: derivatives of the residual at the equilibrium.
    """
    # in units of one length, so that the roll has the weight of the translations
    scale = np.diag([1.0, 1.0, 1.0 / problem.wheels.distance_mm])
    stiffness = -scale @ jacobian @ scale
    return bool(np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).min() > 0.0)


MAX_WAY = np.array([30.0, 30.0, 0.05])
"""Displacement in mm, mm and rad from where the search started, beyond which the wheelset has left the track."""


State = TypeVar("State")


@dataclass(frozen=True, eq=False)
class Equilibrium(Generic[State]):
    """A position of the wheelset and its contact forces.

    - `status`: how the search ended.
    - `residuals`: relative residuals of the equilibrium in the current configuration.
    - `state`: contact forces and displacements of the surfaces.
    - `residual`: forces in the track's axes and moment about the axle's middle that are left, shape (3,).
    - `stable`: whether the wheelset comes back after a small push; None where that has no meaning: no equilibrium, or
      held.
    """

    status: Status
    position: WheelsetPosition
    residuals: RelativeResiduals
    state: State
    residual: Floats
    stable: bool | None = None

    def warnings(self, status: Status, touching: Collection[Side]) -> list[str]:
        """Sentences about an unstable equilibrium, and about wheels in the air where a final status is good.

        - `touching`: sides that touch.
        """
        warnings = []
        if self.stable is False:
            warnings.append("the equilibrium is unstable: a small push moves the wheelset away from it")
        lost = [side for side in SIDES if side not in touching]
        if lost and status.converged:
            warnings.append(f"the {' and '.join(lost)} wheel does not touch its rail")
        return warnings
