"""A contact patch on which bodies roll: motion, cells under pressure, friction, and the forces that result."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from flangeway.checks import are_finite, as_numbers, check_finite, check_integer, check_kind, check_positive, refused
from flangeway.contact.patch.normal_contact import Convolution, Pressing
from flangeway.contact.patch.patch_contact import PatchContact
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.friction_solver import (
    FrictionProblem,
    FrictionState,
    SlipOperator,
    tangential_convolution,
)
from flangeway.errors import InputError
from flangeway.geometry.arrays import max_magnitude, run_of
from flangeway.materials import Elastic
from flangeway.solve import Status
from flangeway.solve.surface_compliance import half_spaces_on
from flangeway.types import Bools, Floats, Ints

# --- Motion of two bodies over each other: creepages and spin, or a shift.


PERCENT = 0.1
"""Creepage above which a notice is given."""


@dataclass(frozen=True, eq=False)
class Creepages:
    """Rigid slip of the second body on the first one, over the speed of rolling.

    The axes of a patch are t (along the first body's surface across, as the grid's bounds rise), n (outwards from the
    first body into the second one) and z (along), with ``n x t = z``. At the place (s, z) from the patch's origin
    the second body slips on the first one by ``across - spin z`` along t and ``along + spin s`` along z. Kalker's and
    CONTACT's axes for rolling to +z are x = z, y = t and z = -n: their creepages are ``xi = along``, ``eta = across``,
    ``phi = -spin``.

    Parameters
    ----------
    along, across
        Longitudinal and lateral creepage; each a number, or one for each row of cells where contact angles differ.
    spin
        Relative rotation about n over the speed of rolling, per length; again a number, or one for each row.
    speed
        Velocity of the patch along z; negative: it rolls to -z. At 0 the bodies do not roll but shift: along and across
        are then displacements, spin is an angle.

    Raises
    ------
    InputError
        If a value is no finite number.

    """

    along: float | Floats = 0.0
    across: float | Floats = 0.0
    spin: float | Floats = 0.0
    speed: float = 1.0

    def __post_init__(self) -> None:
        for name in ("along", "across", "spin"):
            values = as_numbers("creepages", getattr(self, name))
            if not np.isfinite(values).all() or values.size == 0:
                raise InputError(f"Creepages({name}={getattr(self, name)})", "finite numbers", "correct the value")
        check_finite("Creepages", "speed", self.speed, "a finite speed, 0 for a shift")

    @property
    def rolls(self) -> bool:
        """Whether the bodies roll; otherwise they shift."""
        return self.speed != 0.0

    @property
    def notices(self) -> tuple[str, ...]:
        """What is unusual about the numbers."""
        most = float(max(np.abs(self.along).max(), np.abs(self.across).max()))
        if self.rolls and most > PERCENT:
            return (f"a creepage of {most:g} is above {PERCENT:g}: creepages are ratios, not percent",)
        return ()

    def moved(self, along: float, across: float) -> Self:
        """The same with changes of the creepages."""
        return replace(self, along=self.along + along, across=self.across + across)

    def about(self, s: float, z: float) -> Self:
        """The same motion about a place at (s, z) from the origin, which becomes the origin."""
        return replace(self, along=self.along + self.spin * s, across=self.across - self.spin * z)

    def mean(self, s: Floats, weights: Floats) -> Self:
        """Numbers for all rows at places s with weights whose sum is 1."""
        along, across, spin = (np.broadcast_to(creepage[:, 0], s.shape) for creepage in self._rows(len(s)))
        turning = float(spin @ weights)
        ahead = float((along + spin * s) @ weights) - turning * float(s @ weights)
        return replace(self, along=ahead, across=float(across @ weights), spin=turning)

    def rigid(self, s: Floats, z: Floats) -> Floats:
        """Rigid slip (t, z) at places s (n_cells,) and z (n_strips,) from the origin, (n_cells, 2, n_strips)."""
        motion = np.empty((len(s), 2, len(z)))
        along, across, spin = self._rows(len(s))
        motion[:, 0] = across - spin * z
        motion[:, 1] = along + spin * s[:, None]
        return motion

    def _rows(self, n_rows: int) -> list[Floats]:
        """Columns of along, across and spin, one number or one for each row of cells; an `InputError` if it is not."""
        creepages = [
            np.reshape(np.asarray(creepage, dtype=np.float64), (-1, 1))
            for creepage in (self.along, self.across, self.spin)
        ]
        for values in creepages:
            if len(values) not in (1, n_rows):
                raise InputError(
                    f"{len(values)} creepages for {n_rows} rows of cells",
                    "one number, or one for each row",
                    "give as many as the grid has cells across",
                )
        return creepages


# --- A contact patch on which bodies roll: cells under pressure, friction, and influence coefficients in three axes.


STRIPS_BEYOND = 2
"""Strips beyond the grid at each end, whose displacements are needed."""
MAX_COUPLING = 1e-9
"""Coupling of normal and tangential coefficients, relative to the others, that is none."""


@dataclass(frozen=True, eq=False)
class RollingContact:
    """A patch between two bodies.

    Use `under_hertz`, `between_half_spaces`, `of_half_spaces` or `of_bodies`.

    Parameters
    ----------
    grid
        The cells.
    pressures
        Mean pressures of the cells, >= 0, shape (n_cells, n_strips).
    friction
        Coefficients of friction.
    materials
        Isotropic materials of the first and the second body.
    coefficients
        Displacements of the second body less those of the first one by unit forces on cells of the second one, both
        along t, n and z, at n_strips + 4 distances or more along z, shape (n_distances, 3 n_cells, 3 n_cells).
    pressed
        Finds normal forces anew where gaps change; needed for bodies of different materials.
    origin
        Length s along the surface and z of the place that creepages and moments are of; left out: the centre of
        pressure.
    operators
        Cache of what depends on the grid and the coefficients alone, shared with contacts that are made from this one.

    Raises
    ------
    InputError
        If there is no pressure, or a pressure is negative or of another shape.

    """

    grid: PatchGrid
    pressures: Floats
    friction: Friction
    materials: tuple[Elastic, Elastic]
    coefficients: Floats = field(repr=False)
    pressed: Pressing | None = field(default=None, repr=False)
    origin: tuple[float, float] | None = None
    operators: dict[object, Any] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        shape = len(self.grid.widths), self.grid.n_strips
        advice = "give Friction(0.3) for a coefficient of 0.3"
        check_kind("RollingContact", "friction", self.friction, Friction, "Friction(...)", advice)
        pressures = as_numbers("pressures", self.pressures)
        if pressures.shape != shape or not np.isfinite(pressures).all() or pressures.min() < 0.0 or not pressures.any():
            raise InputError(
                f"pressures of shape {pressures.shape} on {shape[0]} x {shape[1]} cells, or none, or negative ones",
                "finite pressures >= 0 on all cells, some of them > 0",
                "press the bodies together first",
            )
        for n_rows in {limit.size for limit in self.friction.limits} - {1, shape[0]}:
            raise InputError(
                f"{n_rows} coefficients of friction for {shape[0]} rows of cells",
                "one number, or one for each row",
                "give as many as the grid has cells across",
            )

    @classmethod
    def between_half_spaces(
        cls, grid: PatchGrid, pressures: Floats, friction: Friction, materials: tuple[Elastic, Elastic]
    ) -> "RollingContact":
        """Known pressures between half-spaces."""
        return cls(grid, pressures, friction, materials, _half_spaces(grid, materials))

    @classmethod
    def under_hertz(
        cls,
        semi_axes: tuple[float, float],
        force: float,
        cells: tuple[int, int],
        friction: Friction,
        materials: tuple[Elastic, Elastic],
    ) -> "RollingContact":
        """Half-spaces under Hertz's pressure on an ellipse: semi-axes and numbers of cells along t and along z."""
        for name, pair in (("semi_axes", semi_axes), ("cells", cells)):
            if not are_finite(pair, 2):
                raise refused("RollingContact.under_hertz", name, pair, "two numbers, along t and along z", "give both")
        for name, value in zip(("semi_axes", "semi_axes", "force"), (*semi_axes, force), strict=True):
            check_positive("RollingContact.under_hertz", name, value)
        for number in cells:
            check_integer("RollingContact.under_hertz", "cells", number, 1)
        (across, along), (n_rows, n_strips) = semi_axes, cells
        grid = PatchGrid(across * np.linspace(-1.0, 1.0, n_rows + 1), 2.0 * along / n_strips, n_strips)
        s = np.linspace(-1.0, 1.0, 2 * n_rows + 1)[1::2]
        pressures = np.sqrt(np.maximum(1.0 - s[:, None] ** 2 - (grid.along / along) ** 2, 0.0))
        pressures *= force / float((pressures * grid.areas).sum())
        return cls.between_half_spaces(grid, pressures, friction, materials)

    @classmethod
    def of_half_spaces(
        cls,
        grid: PatchGrid,
        gaps: Floats,
        friction: Friction,
        materials: tuple[Elastic, Elastic],
        *,
        force: float | None = None,
        approach: float | None = None,
    ) -> "RollingContact":
        """Half-spaces pressed together: gaps (n_cells, n_strips), and the force or the approach."""
        given = as_numbers("gaps", gaps)
        if given.shape != (len(grid.widths), grid.n_strips) or not np.isfinite(given).all():
            raise InputError(
                f"gaps of shape {given.shape} on {len(grid.widths)} x {grid.n_strips} cells, or infinite ones",
                "a finite gap for each cell",
                "give the gaps on the grid's cells",
            )
        coefficients = _half_spaces(grid, materials)
        influence = Convolution(np.ascontiguousarray(coefficients[: grid.n_strips, 1::3, 1::3]))

        pressed = Pressing(influence, given, force=force, approach=approach)
        return cls(grid, pressed().forces / grid.areas, friction, materials, coefficients, pressed)

    @classmethod
    def of_bodies(cls, contact: PatchContact, friction: Friction) -> "RollingContact":
        """Bodies that were pressed together.

        Raises
        ------
        InputError
            If a material is not isotropic.

        """
        pair, grid = contact.pair, contact.pair.grid
        materials = [_isotropic(body.problem.elasticity.materials[0]) for body in (pair.first, pair.second)]
        pressed = pair.pressing(float(contact.force[1]))
        coefficients = pair.coefficients(grid.n_strips + 2 * STRIPS_BEYOND)
        return cls(grid, contact.pressures, friction, (materials[0], materials[1]), coefficients, pressed)

    @property
    def notices(self) -> tuple[str, ...]:
        """What is unusual about friction, and pressures that the edge of the grid may cut off."""
        ends = [self.pressures[:, [0, -1]], *([self.pressures[[0, -1]]] if len(self.pressures) > 1 else [])]
        if self.pressed is None or not any(end.any() for end in ends):
            return self.friction.notices
        return (
            *self.friction.notices,
            "pressures reach the edge of the grid: take a larger one, unless a body ends there",
        )

    @cached_property
    def areas(self) -> Floats:
        """Areas of the cells, shape (n_cells, 1)."""
        return self.grid.areas

    def forces_of(self, tractions: Floats) -> Floats:
        """Forces (t, z) of the cells (n_cells, 2, n_strips) by tractions (n_cells, n_strips, 2)."""
        return (tractions * self.areas[:, :, None]).swapaxes(1, 2)

    @cached_property
    def normal_forces(self) -> Floats:
        """Normal forces of the cells, shape (n_cells, n_strips)."""
        return self.pressures * self.areas

    @property
    def force(self) -> float:
        """Sum of the normal forces."""
        return float(self.normal_forces.sum())

    @property
    def row_shares(self) -> Floats:
        """Shares of the rows of cells in the normal force, shape (n_cells,)."""
        return self.normal_forces.sum(axis=1) / self.force

    @cached_property
    def places(self) -> tuple[Floats, Floats]:
        """Lengths s (n_cells,) and z (n_strips,) of the cells from the origin."""
        (across, along), forces = self.grid.middles, self.normal_forces
        s, z = self.origin or (forces.sum(axis=1) @ across / self.force, forces.sum(axis=0) @ along / self.force)
        return across - s, along - z

    def resultants(self, forces: Floats) -> Floats:
        """Forces along and across, and the moment about n, of forces (t, z) of the cells (n_cells, 2, n_strips)."""
        s, z = self.places
        moment = np.sum(s[:, None] * forces[:, 1]) - np.sum(z * forces[:, 0])
        return np.array([forces[:, 1].sum(), forces[:, 0].sum(), moment])

    @cached_property
    def box(self) -> tuple[slice, slice]:
        """Rows and strips of the cells under pressure."""
        return box_of(self.pressures > 0.0)

    def under(
        self, pressures: Floats, near: "RollingContact | None" = None, friction: Friction | None = None
    ) -> "RollingContact":
        """The same cells under other pressures; operators are shared, and the box holds that of a near contact too."""
        contact = replace(self, pressures=pressures, friction=friction or self.friction)
        if near is not None:
            pairs = zip(near.box, contact.box, strict=True)
            vars(contact)["box"] = tuple(slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in pairs)
        vars(contact)["coupled"] = self.coupled
        return contact

    def operator(self, weights: tuple[float, ...]) -> SlipOperator:
        """Slip of the cells in the box by their forces, for rolling to +z or, mirrored, to -z."""
        rows, strips = self.box
        n_strips, n_rows = strips.stop - strips.start, rows.stop - rows.start

        def make() -> SlipOperator:
            part = self._blocks[: n_strips + len(weights) - 1, rows, ::2, rows, ::2]
            return SlipOperator(part.reshape(-1, 2 * n_rows, 2 * n_rows), weights, n_strips)

        return self._shared((n_strips, rows.start, rows.stop, weights), make)

    def _shared(self, key: object, make: Callable[[], Any]) -> Any:
        if key not in self.operators:
            self.operators[key] = make()
        return self.operators[key]

    @property
    def _blocks(self) -> Floats:
        """Coefficients by distance, displaced cell, its axis, cell under force, and its axis."""
        n_cells = len(self.pressures)
        return self.coefficients.reshape(-1, n_cells, 3, n_cells, 3)

    @cached_property
    def coupled(self) -> bool:
        """Whether tangential forces move the surfaces along the normals too: the materials or sections differ."""
        blocks = self._blocks
        mixed = max(max_magnitude(blocks[:, :, 1, :, axis]) for axis in (0, 2))
        return mixed > MAX_COUPLING * max_magnitude(blocks[:, :, 1, :, 1])

    @property
    def _normal_by_tangential(self) -> Convolution:
        def make() -> Convolution:
            blocks, n_cells = self._blocks[: self.grid.n_strips + 2 * STRIPS_BEYOND], len(self.pressures)
            by_tangential = blocks[:, :, 1, :, ::2].reshape(-1, n_cells, 2 * n_cells)
            return Convolution(by_tangential, odd=((False,), (False, True)))

        return self._shared("normal", make)

    @cached_property
    def pressing(self) -> Floats:
        """Displacements (t, z) by the normal forces, as `displacements`."""
        if not self.coupled:
            return np.zeros((len(self.pressures), 2, self.grid.n_strips + 2 * STRIPS_BEYOND))
        moved = self._normal_by_tangential.transposed()(_with_ends(self.normal_forces))
        return moved.reshape(len(self.pressures), 2, -1)

    def displacements(self, tangential: Floats) -> Floats:
        """Displacements (t, z) of the second body less the first one's, on `STRIPS_BEYOND` more strips at each end.

        Parameters
        ----------
        tangential
            Forces (t, z) on the cells of the second body, shape (n_cells, 2, n_strips).

        Returns
        -------
        Floats
            Shape (n_cells, 2, n_strips + 2 STRIPS_BEYOND).

        """

        def make() -> Convolution:
            part = self._blocks[: self.grid.n_strips + 2 * STRIPS_BEYOND, :, ::2, :, ::2]
            return tangential_convolution(part.reshape(len(part), 2 * len(self.pressures), -1))

        padded = _with_ends(tangential)
        convolution: Convolution = self._shared("tangential", make)
        return convolution(padded.reshape(-1, padded.shape[-1])).reshape(padded.shape)

    def gap_increase(self, tangential: Floats) -> Floats:
        """Displacements (..., n_cells, n_strips) along n by forces (t, z), (..., n_cells, 2, n_strips).

        Both on the cells and on `STRIPS_BEYOND` more strips at each end.
        """
        shape = tangential.shape
        if not self.coupled:
            return np.zeros((*shape[:-2], shape[-1]))
        return self._normal_by_tangential(tangential.reshape(*shape[:-3], -1, shape[-1]))


def _with_ends(forces: Floats) -> Floats:
    """Forces (..., n_strips) on `STRIPS_BEYOND` more strips at each end, where there are none."""
    return np.pad(forces, [(0, 0)] * (forces.ndim - 1) + [(STRIPS_BEYOND, STRIPS_BEYOND)])


def box_of(cells: Bools) -> tuple[slice, slice]:
    """Rows and strips of the smallest box about cells, of truth values of shape (n_cells, n_strips)."""
    return run_of(cells.any(axis=1)), run_of(cells.any(axis=0))


def _half_spaces(grid: PatchGrid, materials: tuple[Elastic, Elastic]) -> Floats:
    n_distances = grid.n_strips + 2 * STRIPS_BEYOND
    influence = half_spaces_on(materials, grid.bounds, None, grid.strip, n_distances)
    return influence.reshape(n_distances, 3 * len(grid.widths), -1)


def _isotropic(material: object) -> Elastic:
    if not isinstance(material, Elastic):
        raise InputError(
            f"a body of {type(material).__name__}", "bodies of isotropic materials", "give them a material Elastic"
        )
    return material


# --- What rolling with friction gives: creep forces, and tractions, slip and power of the cells.


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
    gap_increase
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
    gap_increase: Floats
    slope: float = 1.0
    past: tuple[Floats, ...] = ()
    steady: bool = False
    problem: FrictionProblem | None = None
    state: FrictionState | None = None

    @cached_property
    def displacements(self) -> tuple[Floats, ...]:
        """Those of the second body less the first one's, `RollingContact.displacements`, of this state and the past."""
        moved = self.contact.displacements(self.contact.forces_of(self.tractions)) / self.slope + self.contact.pressing
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
            gradients = (
                moved[..., STRIPS_BEYOND + 1 : 1 - STRIPS_BEYOND] - moved[..., STRIPS_BEYOND - 1 : -1 - STRIPS_BEYOND]
            ) / 2.0
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
        rigid = self.motion.rigid(*self.contact.places)
        of_creepages = -float(np.sum(self.contact.forces_of(self.tractions) * rigid))
        return of_creepages + self.rolling_power / (abs(self.motion.speed) or 1.0)

    def part(self, inside: Bools) -> Self:
        """The forces of some of the cells, (n_cells, n_strips), about the centre of their own pressure.

        What pressures do as tractions raise the surfaces is shared by the normal force.
        """
        contact = self.contact.under(np.where(inside, self.contact.pressures, 0.0))
        forces = np.where(inside[..., None], self.tractions * self.contact.areas[..., None], 0.0)
        along, across, moment = contact.resultants(forces.swapaxes(1, 2)).tolist()
        part = replace(
            self,
            motion=self.motion.about(*(a[0] - b[0] for a, b in zip(self.contact.places, contact.places, strict=True))),
            contact=contact,
            along=along,
            across=across,
            moment=moment,
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
