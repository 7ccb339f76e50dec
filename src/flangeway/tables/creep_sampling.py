"""Creep forces of one patch over all creepages: computed at some, filled between them, and checked at others."""

from collections import deque
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from flangeway.contact.rolling.exact_rolling import derivatives, roll
from flangeway.contact.rolling.fast_theories import fastsim_forces
from flangeway.contact.rolling.rolling_contact import Creepages, CreepForces, Rolling, RollingContact
from flangeway.geometry.arrays import angles_of, norms
from flangeway.tables.creep_table import SATURATED, ForceAxes, direction
from flangeway.types import Floats

PADDING = 3


SLIPS: Floats = np.array([0.0, 0.12, 0.24, 0.34, 0.42, 0.5, 0.6, 0.7, 0.82, 1.0])
"""Reduced sizes of creepages: 0 is linear theory, at 1 everything slides."""
ANGLES = 24
"""Intervals of 180 degrees of both angles in a table."""
DIRECTIONS = (4, 6, 8, 12, 24)
"""Intervals between exact solutions, from coarse to fine: 104, 248, 456, 1,064 and 4,424 of these for each patch, less
those that a coarser one has."""
AIM = 1.0 / 6.0
"""Root mean square of the errors of a patch relative to the tolerance, up to which it gets more exact solutions: few
points find their mean size, but not the largest."""
SOLVED = 0.01
"""Tolerance of the law of friction for the exact solutions of a table: forces change by less than 0.001 mu N."""
ORDER = 2.0
"""Power of the intervals with which errors fall at least."""
CREEPS: Floats = np.linspace(0.0, np.pi, ANGLES + 1)
AXES = (SLIPS, CREEPS - np.pi / 2.0, CREEPS)
"""Axes of a table: slip, angle of spin, angle of creepage."""


@dataclass(frozen=True, eq=False)
class SampledPatch:
    """A patch with reduced creepages: over those at which linear theory reaches the limit of friction.

    Where its bodies are coupled, a table has displacements along the surface by pressures as the creepages of free
    rolling only, and leaves out those along the normals by friction: forces over the limit of friction are then odd
    functions of further creepages over it. Checks have them.

    - `bodies`: the patch.
    - `rays`: exact forces over the limit of friction and over slip along directions that were asked for, (n_slips, 3),
      by angles of spin and creepage, and how many of them did not converge.
    """

    bodies: RollingContact
    rays: dict[tuple[float, float], tuple[Floats, int]] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def contact(self) -> RollingContact:
        """The patch without that coupling."""
        if not self.bodies.coupled:
            return self.bodies
        normal = np.arange(3 * len(self.bodies.grid.widths)) % 3 == 1
        coefficients = self.bodies.coefficients * (normal == normal[:, None])
        return replace(self.bodies, coefficients=coefficients, pressed=None)

    @cached_property
    def free(self) -> Floats:
        """Creepages (along, across) at which the pressed patch rolls without creep force and spin, (2,).

        The top of a rail that bends under a wheel is shorter, the wheel's surface is stretched in another way.
        """
        if not self.bodies.coupled:
            return np.zeros(2)
        motion = roll(self.bodies, Creepages(), force_along=0.0, force_across=0.0).motion
        return np.array([motion.along, motion.across], dtype=np.float64)

    @cached_property
    def slopes(self) -> Floats:
        """Derivatives of (along, across, moment) by (along, across, spin) of a patch that sticks, (3, 3)."""
        return derivatives(roll(self.contact, Creepages()))

    @cached_property
    def limits(self) -> Floats:
        """Limits of friction of the cells, (n_cells, n_strips)."""
        limits: Floats = self.contact.friction.limits[0][:, None] * self.contact.normal_forces
        return limits

    @cached_property
    def limit(self) -> float:
        """Limit of friction."""
        return float(self.limits.sum())

    @cached_property
    def radius(self) -> float:
        """Radius of gyration of the normal forces."""
        s, z = self.contact.places
        forces = self.contact.normal_forces
        return float(np.sqrt((forces.sum(axis=1) @ s**2 + forces.sum(axis=0) @ z**2) / forces.sum()))

    @cached_property
    def stiffness(self) -> Floats:
        """Loss of force by longitudinal and by lateral creepage, (2,)."""
        return -np.diag(self.slopes)[:2]

    @cached_property
    def _scale(self) -> Floats:
        """Reduced creepages over creepages."""
        return np.append(self.stiffness, self.stiffness[1] * self.radius) / self.limit

    def direction(self, spin: float, creep: float) -> Floats:
        """Creepages of unit size."""
        return direction(np.array(spin), np.array(creep)) / self._scale

    def motion(self, slip: float, spin: float, creep: float) -> Creepages:
        """Creepages of reduced ones, slip below 1."""
        return Creepages(*(SATURATED * slip / (1.0 - slip) * self.direction(spin, creep)).tolist())

    def over_limit(self, forces: CreepForces) -> Floats:
        """Forces over the limit of friction, the moment also over the radius."""
        return np.array([forces.along, forces.across, forces.moment / self.radius]) / self.limit

    def linear(self, spin: float, creep: float) -> Floats:
        """Forces over slip where it vanishes."""
        forces = SATURATED * (self.slopes @ self.direction(spin, creep)) / self.limit
        return forces / np.array([1.0, 1.0, self.radius])

    def sliding(self, spin: float, creep: float) -> Floats:
        """Forces where everything slides."""
        s, z = self.contact.places
        slip = Creepages(*self.direction(spin, creep).tolist()).rigid(s, z)
        size = np.maximum(np.linalg.norm(slip, axis=1, keepdims=True), np.finfo(float).tiny)
        forces = -slip / size * self.limits[:, None]
        return self.contact.resultants(forces) / [1.0, 1.0, self.radius] / self.limit

    def simplified(self, slips: Floats, spins: Floats, creeps: Floats) -> Floats:
        """Forces over slip by FASTSIM at all combinations, exactly at both ends of slip, shape (..., 3)."""
        ends = [np.array([[by(a, b) for b in creeps] for a in spins]) for by in (self.linear, self.sliding)]
        unit = np.array([[self.direction(a, b) for b in creeps] for a in spins])
        inner: list[Floats] = []
        for slip in slips[1:-1].tolist():
            creepages = SATURATED * slip / (1.0 - slip) * unit.reshape(-1, 3)
            forces = fastsim_forces(self.contact, creepages) / [1.0, 1.0, self.radius] / (slip * self.limit)
            inner.append(forces.reshape(unit.shape))
        return np.stack((ends[0], *inner, ends[1]))

    def exact(self, slip: float, spin: float, creep: float, start: Rolling | None = None) -> Rolling:
        """The exact theory, from a neighbouring result and, where it does not converge from there, without one."""
        rolling = roll(self.contact, self.motion(slip, spin, creep), start=start, tolerance=SOLVED)
        if start is not None and not rolling.status.converged:
            return roll(self.contact, rolling.motion, tolerance=SOLVED)
        return rolling

    def ray(self, slips: Floats, spin: float, creep: float) -> Floats:
        """Exact forces over slip along a direction, (n_slips, 3); each is computed once."""
        if (spin, creep) not in self.rays:
            rollings: list[Rolling] = []
            for slip in slips.tolist():
                rollings.append(self.exact(slip, spin, creep, rollings[-1] if rollings else None))
            forces = np.array([self.over_limit(rolling) for rolling in rollings]) / slips[:, None]
            self.rays[spin, creep] = forces, sum(not rolling.status.converged for rolling in rollings)
        return self.rays[spin, creep][0]

    @property
    def n_exact(self) -> int:
        """Number of exact solutions of the rays."""
        return sum(len(forces) for forces, _ in self.rays.values())

    @property
    def n_failed(self) -> int:
        """How many of them did not converge."""
        return sum(failed for _, failed in self.rays.values())

    def coupled(self, slip: float, spin: float, creep: float) -> Rolling:
        """The exact theory with the coupling of the bodies, creepages from those of free rolling."""
        return roll(self.bodies, self.motion(slip, spin, creep).moved(*self.free.tolist()))


@dataclass(frozen=True, eq=False)
class SampledForces:
    """Forces of a patch over those of friction and over slip, at the points of its axes.

    - `forces`: (slips, spin angles, creep angles, 3).
    - `beyond`: the same less those of FASTSIM.
    """

    forces: Floats
    beyond: Floats


def sample(
    patch: SampledPatch,
    directions: int,
    near: Floats | float = 0.0,
) -> SampledForces:
    """Forces at all points of a table: exact ones less simple ones are interpolated by cubics, simple ones added again.

    - `directions`: intervals of both angles between exact solutions, even and a divisor of the table's; 0: none at all.
    - `near`: `SampledForces.beyond` of a similar patch, which with FASTSIM's forces are the simple ones.
    """
    slips, spins, creeps = AXES
    fast = patch.simplified(slips, spins, creeps)
    simple = fast + near
    if directions == 0:
        return SampledForces(simple, simple - fast)
    step = (len(spins) - 1) // directions
    missing = np.zeros((len(slips), directions + 1, directions + 1, 3))
    for row, spin in enumerate(spins[::step].tolist()):
        for column, creep in enumerate(creeps[:-step:step].tolist()):
            pole = abs(row - directions / 2) == directions / 2
            if pole and column:  # pure spin, whatever the other angle
                missing[:, row, column] = missing[:, row, 0]
            elif row or not pole:
                exact = patch.ray(slips[1:-1], spin, creep)
                missing[1:-1, row, column] = exact - simple[1:-1, step * row, step * column]
    missing[:, 0] = -missing[:, -1, :1]
    # forces are opposite at opposite creepages
    missing[:, :, -1] = -missing[:, ::-1, 0]
    forces = simple + _between(missing, (spins[::step], creeps[::step]), (spins, creeps))
    return SampledForces(forces, forces - fast)


def _between(values: Floats, coarse: tuple[Floats, Floats], fine: tuple[Floats, Floats]) -> Floats:
    """Cubics in both angles, which go on over the poles and around: (slips, spin angles, creep angles, 3)."""
    around = np.concatenate((values[:, :, :-1], -values[:, ::-1, :-1]), axis=2)
    n = around.shape[2]
    low, high = (np.roll(part, n // 2, axis=2) for part in (around[:, PADDING:0:-1], around[:, -2 : -PADDING - 2 : -1]))
    whole = np.concatenate((low, around, high), axis=1)
    whole = np.concatenate((whole[:, :, -PADDING:], whole, whole[:, :, : n // 2 + PADDING + 1]), axis=2)
    step = float(coarse[0][1] - coarse[0][0])
    spins = coarse[0][0] + step * (np.arange(whole.shape[1]) - PADDING)
    creeps = step * (np.arange(whole.shape[2]) - PADDING)
    surface = RegularGridInterpolator((spins, creeps), np.moveaxis(whole, 0, 2), method="cubic")
    return np.moveaxis(surface(np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1)), 2, 0)


@dataclass(frozen=True, eq=False)
class CreepErrors:
    """Errors of a table at points between its own, over the limit of friction.

    - `points`: slip, angle of spin, angle of creepage, (n, 3).
    - `force`, `moment`: sizes of the errors of the force, and of the moment over the radius, (n,).
    """

    points: Floats
    force: Floats
    moment: Floats

    @property
    def size(self) -> float:
        """Root mean square of the errors of the force."""
        return float(np.sqrt((self.force**2).mean())) if len(self.force) else 0.0


def refined(
    patch: SampledPatch, points: Floats, tolerance: float, near: Floats | None
) -> tuple[SampledForces, CreepErrors, int]:
    """Forces, errors at reduced creepages (n, 3) and intervals of both angles, as many as the tolerance needs.

    - `near`: `SampledForces.beyond` of a similar patch, which often serve without exact solutions of its own.

    A loop of its own: the errors at one level tell which levels may be left out.
    """
    exact, wanted = exact_forces(patch, points), AIM * tolerance
    levels = deque((*(() if near is None else (0,)), *DIRECTIONS))
    while True:
        directions = levels.popleft()
        sampled = sample(patch, directions, 0.0 if near is None else near)
        errors = check(sampled, points, exact)
        if errors.size <= wanted or not levels:
            return sampled, errors, directions
        while len(levels) > 1 and errors.size * (directions / levels[0]) ** ORDER > wanted:
            levels.popleft()


def random_points(number: int, random: np.random.Generator) -> Floats:
    """Reduced creepages, even over slip and over all directions: (n, 3)."""
    unit = random.normal(size=(number, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    creep = angles_of(unit)
    return np.stack((random.uniform(0.0, 1.0, number), np.arcsin(unit[:, 2]), creep), axis=1)


def exact_forces(patch: SampledPatch, points: Floats) -> Floats:
    """Exact forces over the limit of friction at reduced creepages (n, 3), of the same shape."""
    return np.array([patch.over_limit(patch.coupled(*point)) for point in points.tolist()]).reshape(-1, 3)


def check(sampled: SampledForces, points: Floats, exact: Floats) -> CreepErrors:
    """Compare with exact forces at reduced creepages, both (n, 3)."""
    error = ForceAxes.of(sampled.forces, AXES).at((), tuple(points.T)) - exact
    return CreepErrors(points, norms(error), np.abs(error[:, 2]))
