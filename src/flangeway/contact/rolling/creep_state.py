"""Creep forces of a patch as they are reported: on its second body, ahead and to the right, by any theory."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.contact.rolling.fast_theories import TITLES, SimplifiedRolling
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, Creepages, CreepForces, Rolling, RollingContact
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class CreepState:
    """Creep forces of a patch on its second body.

    - `forces`: in the patch's axes, of any theory; `Rolling` and `SimplifiedRolling` have tractions, slip and states on
      the cells of the patch.
    - `contact`: cells and coefficients.
    - `sign`: 1 where t of the patch is to the right, -1 where it is to the left.
    - `speed_m_s`: speed of rolling; None: that of the forces' motion.
    """

    forces: CreepForces
    contact: RollingContact
    sign: float = 1.0
    speed_m_s: float | None = None

    @property
    def speed(self) -> float:
        """Speed of rolling, m/s; 0 of a shift."""
        return abs(self.forces.motion.speed) if self.speed_m_s is None else self.speed_m_s

    @property
    def scale(self) -> float:
        """Speed over the speed of the forces' motion."""
        return 1.0 if self.speed_m_s is None else self.speed_m_s / abs(self.forces.motion.speed)

    @cached_property
    def creepages(self) -> Creepages:
        """Creepages at the origin of `contact` in the patch's axes: means of the rows, weighted by their forces."""
        motion = self.forces.motion
        if any(map(np.ndim, (motion.along, motion.across, motion.spin))):
            return motion.mean(self.contact.places[0], self.contact.row_shares)
        return motion

    @property
    def rolls(self) -> bool:
        """Whether the bodies roll; otherwise the second one is shifted, and creepages are shifts."""
        return self.forces.motion.rolls

    @property
    def theory(self) -> str:
        """The theory's name."""
        return TITLES["exact"] if isinstance(self.forces, Rolling) else self.forces.theory

    @property
    def longitudinal_creepage(self) -> float:
        """Slip of the second body ahead over the speed, or its shift, mm."""
        return float(self.creepages.along)

    @property
    def lateral_creepage(self) -> float:
        """Slip of the second body along the surface to the right over the speed, or its shift, mm."""
        return self.sign * float(self.creepages.across)

    @property
    def spin_creepage_per_m(self) -> float:
        """Rotation of the second body about the normal over the speed, 1/m, or its rotation, mrad.

        Counter-clockwise seen from above.
        """
        return 1e3 * self.sign * float(self.creepages.spin)

    @property
    def lateral_force_N(self) -> float:  # noqa: N802
        """Creep force along the surface to the right, N."""
        return self.sign * self.forces.across

    @property
    def spin_moment_Nm(self) -> float:  # noqa: N802
        """Moment about the normal at the origin of `contact`, N m, counter-clockwise from above."""
        return 1e-3 * self.sign * self.forces.moment

    @property
    def used_friction(self) -> float:
        """Ratio of creep force to normal force."""
        return float(np.hypot(self.forces.along, self.forces.across)) / self.contact.force

    @property
    def t_gamma_N(self) -> float:  # noqa: N802
        """Energy that friction dissipates over the distance rolled, its power over the speed, N = J/m."""
        return self.forces.t_gamma

    @property
    def products(self) -> tuple[float, float]:
        """Creep forces times creepages, and spin moment times spin, N."""
        return self.forces.products(self.creepages)

    @property
    def power_W(self) -> float:  # noqa: N802
        """Power that friction dissipates, W."""
        return self.speed * self.forces.t_gamma

    @property
    def cells(self) -> Rolling | SimplifiedRolling | None:
        """Tractions, slip and states, which only some theories have."""
        return self.forces if isinstance(self.forces, Rolling | SimplifiedRolling) else None

    @property
    def slip_fraction(self) -> float | None:
        """Cells that slip over those in contact."""
        cells = self.cells
        return None if cells is None else float((cells.states[cells.states != NO_CONTACT] == SLIPS).mean())

    def maximum(self, values: Callable[[Rolling | SimplifiedRolling], Floats]) -> float | None:
        """Maximum magnitude over the cells; None of theories without tractions."""
        cells = self.cells
        return None if cells is None else float(np.linalg.norm(np.atleast_3d(values(cells)), axis=2).max())

    @property
    def max_slip(self) -> float | None:
        """Maximum slip velocity, m/s, of a shift the slip, mm."""
        slip = self.maximum(lambda cells: cells.slip_velocities)
        return None if slip is None else self.scale * slip

    @property
    def flash_temperature(self) -> float | None:
        """Maximum temperature of the cells above that without friction, K; None without temperatures."""
        cells = self.cells
        if cells is None or cells.flash_temperatures is None:
            return None
        return float(cells.flash_temperatures[cells.states != NO_CONTACT].max())

    @property
    def power_density(self) -> float | None:
        """Maximum power over area, W/mm²; None for a shift."""
        power = self.maximum(lambda cells: cells.power_density.clip(min=0.0))
        return self.scale * power if self.rolls and power is not None else None
