"""An equilibrium of a wheelset (Moherdaui 2021, 7.2.1)."""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.wheelset.residual import RelativeResiduals
from flangeway.solve import Status
from flangeway.types import Floats

MAX_WAY = np.array([30.0, 30.0, 0.05])
"""Displacement in mm, mm and rad from where the search started, beyond which the wheelset has left the track."""


class AxleState(Protocol):
    """Contact of the wheelset at one position, plane or in three dimensions."""

    @property
    def status(self) -> Status:
        """Whether the contact forces were found."""

    @property
    def forces(self) -> Floats:
        """Contact forces, zero where there is no contact."""


State = TypeVar("State", bound=AxleState)


@dataclass(frozen=True, eq=False)
class Equilibrium(Generic[State]):
    """A position of the wheelset and its contact forces.

    - `status`: how the search ended.
    - `residuals`: relative residuals of the equilibrium in the current configuration.
    - `state`: contact forces and displacements of the surfaces.
    - `residual`: forces in the track's axes and moment about the axle's middle that are left, shape (3,).
    - `stable`: whether the wheelset comes back after a small push; None where that has no meaning: no equilibrium, or
      held.
    - `history`: residuals at each position that the search tried, in order.
    """

    status: Status
    position: WheelsetPosition
    residuals: RelativeResiduals
    state: State
    residual: Floats
    stable: bool | None = None
    history: tuple[RelativeResiduals, ...] = ()
