"""What rolling with friction gives: creep forces, and tractions, slip and power of the cells."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.friction_solver import FrictionProblem, FrictionState
from flangeway.contact.rolling.rolling_contact import BEYOND, RollingContact
from flangeway.solve import Status
from flangeway.types import Bools, Floats, Ints

NO_CONTACT, STICKS, SLIPS = 0, 1, 2
"""Values of `Rolling.states`."""


@dataclass(frozen=True, eq=False, kw_only=True)
class CreepForces:
    """Forces on the second body by friction, about the patch's origin in the axes t, n and z of `Creepages`.

    In Kalker's and CONTACT's axes, rolling to +z, ``F_x = along``, ``F_y = across`` and ``M_z = -moment``.

    Parameters
    ----------
    motion
        Creepages, also where they were found for prescribed forces.
    along, across
        Longitudinal (z) and lateral (t) force.
    moment
        Spin moment about n.
    theory
        Its name.
    status
        How the computation ended.
    notices
        What is unusual about the input.

    """

    motion: Creepages
    along: float
    across: float
    moment: float
    theory: str
    status: Status
    notices: tuple[str, ...] = ()

    @property
    def t_gamma(self) -> float:
        """Energy that friction dissipates over the distance rolled, its power over the speed.

        Of theories with tractions it is the integral of tractions times slip, of the others forces times creepages.
        """
        return sum(self.products(self.motion))

    def products(self, centre: Creepages) -> tuple[float, float]:
        """Forces times creepages, and spin moment times spin, both positive where they dissipate.

        The first one is T-gamma without spin, their sum T-gamma with spin, for creepages at the patch's origin: one
        number each.
        """
        translation = self.along * centre.along + self.across * centre.across
        return -float(np.sum(translation)), -float(np.sum(self.moment * centre.spin))

    @property
    def frictional_power(self) -> float:
        """Power that friction dissipates."""
        return abs(self.motion.speed) * self.t_gamma


@dataclass(frozen=True, eq=False, kw_only=True)
class Rolling(CreepForces):
    """Creep forces with the fields of the cells.

    Parameters
    ----------
    contact
        The patch, with the pressures that were found where normal and tangential contact are coupled.
    tractions
        Mean tangential tractions (t, z) on the second body, shape (n_cells, n_strips, 2).
    slip_velocities
        Slip of the second body on the first one (t, z): velocities, or displacements for a shift, same shape.
    states
        `NO_CONTACT`, `STICKS` or `SLIPS`, shape (n_cells, n_strips).
    flash_temperatures
        Temperature of the cells above that without friction, K, by frictional power and `Heating`, (n_cells, n_strips);
        of steady rolling. None without thermal properties.
    rolling_power
        Power of the pressures as tractions move the surfaces along their normals: with a part of them ahead of the
        middle they resist rolling. 0 between half-spaces of one material.
    raised
        Displacements along the normals by tractions, shape (n_cells, n_strips).
    slope
        Factor of `Friction.slope`.
    past
        Displacements of the state before, in transient rolling.
    steady
        Whether it is steady rolling.

    """

    contact: RollingContact
    tractions: Floats
    slip_velocities: Floats
    states: Ints
    flash_temperatures: Floats | None = None
    rolling_power: float = 0.0
    raised: Floats
    slope: float = 1.0
    past: tuple[Floats, ...] = ()
    steady: bool = False
    problem: FrictionProblem | None = None
    state: FrictionState | None = None

    @cached_property
    def displacements(self) -> tuple[Floats, ...]:
        """Those of the second body less the first one's, `RollingContact.displacements`, of this state and the past."""
        forces = (self.tractions * self.contact.areas[:, :, None]).swapaxes(1, 2)
        moved = self.contact.displacements(forces) / self.slope + self.contact.pressing
        return moved, *((moved,) if self.steady else self.past)

    @cached_property
    def power_density(self) -> Floats:
        """Frictional power over area (work of a shift), shape (n_cells, n_strips).

        In steady rolling it is that of slip by central differences: its sum is the power of the creepages exactly,
        single cells beside the edge of slip may be slightly negative.
        """
        slips = self.slip_velocities
        if self.steady:
            velocity, moved = self.motion.speed, self.displacements[0]
            gradients = (moved[..., BEYOND + 1 : 1 - BEYOND] - moved[..., BEYOND - 1 : -1 - BEYOND]) / 2.0
            rigid = abs(velocity) * self.motion.rigid(*self.contact.places)
            slips = (rigid - velocity * gradients / self.contact.grid.strip).swapaxes(1, 2)
        return -np.sum(self.tractions * slips, axis=2)

    @property
    def frictional_power(self) -> float:
        """Sum of the power of the cells."""
        return float(np.sum(self.power_density * self.contact.areas))

    @cached_property
    def t_gamma(self) -> float:
        """See `CreepForces.t_gamma`; creepages of each row count with its forces, and pressures that resist rolling."""
        s, z = self.contact.places
        rigid = self.motion.rigid(s, z).swapaxes(1, 2)
        of_creepages = -float(np.sum(self.tractions * self.contact.areas[:, :, None] * rigid))
        return of_creepages + self.rolling_power / (abs(self.motion.speed) or 1.0)

    def part(self, inside: Bools) -> Self:
        """The forces of some of the cells, (n_cells, n_strips), about the centre of their own pressure.

        What pressures do as tractions raise the surfaces is shared by the normal force.
        """
        contact = self.contact.under(np.where(inside, self.contact.pressures, 0.0))
        s, z = contact.places
        forces = np.where(inside[..., None], self.tractions * self.contact.areas[..., None], 0.0)
        part = replace(
            self,
            motion=self.motion.about(self.contact.places[0][0] - s[0], self.contact.places[1][0] - z[0]),
            contact=contact,
            along=float(forces[..., 1].sum()),
            across=float(forces[..., 0].sum()),
            moment=float(np.sum(s[:, None] * forces[..., 1]) - np.sum(z * forces[..., 0])),
            tractions=forces / contact.areas[..., None],
            slip_velocities=np.where(inside[..., None], self.slip_velocities, 0.0),
            states=np.where(inside, self.states, NO_CONTACT),
            flash_temperatures=None
            if self.flash_temperatures is None
            else np.where(inside, self.flash_temperatures, 0.0),
            rolling_power=self.rolling_power * contact.force / self.contact.force,
        )
        vars(part)["power_density"] = np.where(inside, self.power_density, 0.0)
        return part

    @property
    def coefficient(self) -> float:
        """Resultant tangential force over the normal one: the utilised friction."""
        return float(np.hypot(self.along, self.across)) / self.contact.force

    @cached_property
    def residuals(self) -> dict[str, float]:
        """How well the law of friction holds, all 0 for an exact solution.

        ``cone``: traction above its limit over the maximum limit; ``complementarity``: slip times what is missing to
        the limit; ``opposition``: traction times slip plus their scalar product; both over the maximum limit times the
        maximum rigid slip.
        """
        state, problem = self.state, self.problem
        if state is None or problem is None or not problem.limits.any():
            return dict.fromkeys(("cone", "complementarity", "opposition"), 0.0)
        force, slip = np.linalg.norm(state.forces, axis=1), np.linalg.norm(state.slips, axis=1)
        inside = problem.limits > 0.0
        most = float(problem.limits.max())
        unit = most * max(float(np.linalg.norm(problem.rigid, axis=1)[inside].max()), np.finfo(float).tiny)
        against = force * slip + np.sum(state.forces * state.slips, axis=1)
        return {
            "cone": float((force - state.limits).max()) / most if inside.any() else 0.0,
            "complementarity": float((slip * np.abs(state.limits - force))[inside].max()) / unit,
            "opposition": float(against[inside].max()) / unit,
        }
