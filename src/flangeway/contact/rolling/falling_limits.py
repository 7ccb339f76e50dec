"""Limits of friction that fall with the slip velocity and with the flash temperature, and their derivatives.

The limit of a cell under the normal force N, with tangential force f, slip S and the trial force ``t = f - r S`` of the
law of friction, falls with the slip ``(|t| - m) / r``, see `Friction.fallen`; so it depends on the trial force alone.
Its temperature is that of the heat of all cells ahead in the row,

    T_i = T_0 + sum over j of H_ij c (n_j . f_j) (-n_j . S_j) / A_j

where c is velocity over slip, n the direction of t, and A areas.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.contact.rolling.friction import Friction
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class LimitSlopes:
    """Derivatives of limits at a state.

    - `directions`: of the trial forces, (n_cells, 2, n_strips); `scale`: r, (n_cells, 1, n_strips).
    - `by_trial`, `by_rise`: of the limits by the trial force and by the temperature, (n_cells, n_strips).
    - `heat_by_force`, `heat_by_slip`: of the heat of the cells by force and slip, (n_cells, n_strips).
    - `warming`: temperatures by heat of cells ahead, (n_strips, n_strips), or None.
    """

    directions: Floats
    scale: Floats
    by_trial: Floats
    by_rise: Floats
    heat_by_force: Floats
    heat_by_slip: Floats
    warming: Floats | None

    def change(self, forces: Floats, slips: Floats) -> Floats:
        """Change of the limits (..., n_cells, n_strips) by changes of forces and slip, (..., n_cells, 2, n_strips)."""
        change = self.by_trial * np.sum(self.directions * (forces - self.scale * slips), axis=-2)
        if self.warming is not None:
            heat = self.heat_by_force * np.sum(self.directions * forces, axis=-2)
            heat = heat - self.heat_by_slip * np.sum(self.directions * slips, axis=-2)
            change = change + self.by_rise * (heat @ self.warming.T)
        return change

    def transposed(self, values: Floats) -> tuple[Floats, Floats]:
        """Derivatives of the sum of limits times values (..., n_cells, n_strips) by forces and slip."""
        by_force = (self.by_trial * values)[..., None, :]
        by_slip = -self.scale * by_force
        if self.warming is not None:
            heat = (self.by_rise * values) @ self.warming
            by_force = by_force + (self.heat_by_force * heat)[..., None, :]
            by_slip = by_slip - (self.heat_by_slip * heat)[..., None, :]
        return self.directions * by_force, self.directions * by_slip


@dataclass(frozen=True, eq=False)
class FallingLimits:
    """Limits of the cells that a state needs.

    - `friction`: of the rows of cells, (n_cells,) or one number.
    - `normal`: normal forces of the cells, (n_cells, n_strips).
    - `areas`: of the cells, (n_cells, 1).
    - `velocity`: slip velocity over slip.
    - `warming`: temperatures by the heat of cells ahead, K over power density, (n_strips, n_strips), or None.
    """

    friction: Friction
    normal: Floats
    areas: Floats
    velocity: float
    warming: Floats | None

    @property
    def steepest(self) -> Floats:
        """Twice the fall of the limits with slip at rest, (n_cells, 1, n_strips): with r above it they are smooth."""
        static, kinetic = self._limits
        rate = self.velocity / self.friction.decay if self.friction.decay > 0.0 else 0.0
        return 2.0 * rate * (static - kinetic)[:, None]

    def under(self, forces: Floats, slips: Floats) -> Floats:
        """Limits (n_cells, n_strips) at the velocities and temperatures of forces and slip (n_cells, 2, n_strips)."""
        force, slip = np.linalg.norm(forces, axis=1), np.linalg.norm(slips, axis=1)
        rise = self._rise(self.velocity / self.areas * force * slip)
        static, kinetic = self._limits
        return kinetic + (static - kinetic) * self.friction.share(self.velocity * slip, rise)

    @cached_property
    def _limits(self) -> tuple[Floats, Floats]:
        """At rest and at high slip velocities, (n_cells, n_strips) each."""
        static, kinetic = (np.asarray(each[:, None] * self.normal) for each in self.friction.limits)
        return static, kinetic

    def _rise(self, heat: Floats) -> Floats | float:
        return 0.0 if self.warming is None else heat @ self.warming.T

    def at(self, scale: Floats, trial: Floats, forces: Floats, slips: Floats) -> tuple[Floats, LimitSlopes]:
        """Limits (n_cells, n_strips) of a state, and their derivatives.

        - `scale`: r, (n_cells, 1, n_strips).
        - `trial`, `forces`, `slips`: (n_cells, 2, n_strips).
        """
        length = np.linalg.norm(trial, axis=1)
        n = trial / np.maximum(length, np.finfo(float).tiny)[:, None]
        force, slip = np.sum(n * forces, axis=1).clip(min=0.0), -np.sum(n * slips, axis=1).clip(max=0.0)
        rate = self.velocity / self.areas
        rise = self._rise(rate * force * slip)
        limits, by_trial, by_rise = self.friction.fallen(*self._limits, length, self.velocity / scale[:, 0], rise)
        return limits, LimitSlopes(n, scale, by_trial, by_rise, rate * slip, rate * force, self.warming)
