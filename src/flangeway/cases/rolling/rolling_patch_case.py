"""The case of one contact patch between half-spaces on which two bodies roll, or shift, with friction."""

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from flangeway.cases.case import Progress, RunnableCase
from flangeway.cases.rolling.pressure_table import read_pressures
from flangeway.cases.rolling.rolling_patch_summary import RollingPatchSummary, ShiftSummary, TheoryForces
from flangeway.cases.summary import RunResult, StatusSummary
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.exact_rolling import creep_curve, roll
from flangeway.contact.rolling.fastsim import SimplifiedRolling
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.contact.rolling.rolling_result import NO_CONTACT, SLIPS, CreepForces, Rolling
from flangeway.contact.rolling.theories import FAST, TITLES, Theory
from flangeway.errors import InputError
from flangeway.exact import PointContact, contact_modulus
from flangeway.materials import Elastic
from flangeway.solve import Status
from flangeway.types import Floats

# ruff: noqa: N815 (units in names)

COMPONENTS = {"longitudinal": "along", "lateral": "across", "spin": "spin"}
"""Components of creepages by the names of creep curves."""
CREEPAGES = ("longitudinal_creepage", "lateral_creepage", "spin_creepage_per_m")
SHIFTS = ("shift_ahead_mm", "shift_right_mm", "shift_rotation_mrad")
FORCES = ("longitudinal_force_kN", "lateral_force_kN")
MARGIN = 1
"""Cells beyond the ellipse on each side, where pressures are found by contact."""


@dataclass(frozen=True, eq=False)
class RollingPatchRun(RunResult):
    """A patch that rolls and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    summary
        What ``summary.json`` holds.
    contact
        The patch.
    found
        What the chosen theory gives; t of the patch is to the right, z ahead, the speed is in m/s.
    curve
        Points of the creep curve of all theories, one theory after the other; none without one.

    """

    main_table: ClassVar[str] = "theories"

    case: "RollingPatchCase"
    summary: RollingPatchSummary
    contact: RollingContact
    found: CreepForces
    curve: Sequence[TheoryForces]

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.found.status

    @property
    def fields(self) -> Rolling | SimplifiedRolling | None:
        """Tractions, slip and states, which only some theories have."""
        return self.found if isinstance(self.found, Rolling | SimplifiedRolling) else None


class RollingPatchCase(RunnableCase):
    """Two half-spaces pressed together by a force that roll over each other; all results are those on the upper one."""

    name: ClassVar[str] = "rolling-patch"
    title: ClassVar[str] = "One contact patch that rolls with friction"
    essential: ClassVar[tuple[str, ...]] = (
        *("force_kN", "radius_along_mm", "radius_across_mm"),
        *(*CREEPAGES, "speed_km_h", "friction"),
    )

    force_kN: float = Field(80.0, gt=0.0, description="normal force")
    radius_along_mm: float = Field(
        460.0, gt=0.0, description="relative radius of curvature ahead, 1 / (1 / R_upper + 1 / R_lower)"
    )
    radius_across_mm: float = Field(300.0, gt=0.0, description="relative radius of curvature across")
    semi_axis_along_mm: float | None = Field(
        None, gt=0.0, description="semi-axis ahead of an ellipse under Hertz's pressure, instead of the radii"
    )
    semi_axis_across_mm: float | None = Field(None, gt=0.0, description="its semi-axis across")
    pressure_file: str | None = Field(
        None, description="CSV file of pressures, instead of force and shape: right_mm, ahead_mm, pressure_MPa of cells"
    )
    young_MPa: float = Field(210e3, gt=0.0, description="Young's modulus")
    poisson: float = Field(0.3, ge=0.0, lt=0.5, description="Poisson's ratio")
    upper_young_MPa: float | None = Field(
        None, gt=0.0, description="Young's modulus of the upper body (default: young_MPa)"
    )
    upper_poisson: float | None = Field(
        None, ge=0.0, lt=0.5, description="Poisson's ratio of the upper body (default: poisson)"
    )
    longitudinal_creepage: float = Field(
        0.001, description="slip of the upper body on the lower one ahead, over the speed"
    )
    lateral_creepage: float = Field(0.0, description="slip to the right over the speed")
    spin_creepage_per_m: float = Field(
        0.0, description="rotation of the upper body, counter-clockwise from above, over the speed"
    )
    speed_km_h: float = Field(
        72.0,
        description="speed of rolling ahead, negative: backwards, 0: the upper body is shifted and does not roll",
    )
    longitudinal_force_kN: float | None = Field(
        None, description="tangential force on the upper body ahead, instead of the creepage or shift, which is found"
    )
    lateral_force_kN: float | None = Field(None, description="the same to the right")
    shift_ahead_mm: float = Field(0.0, description="shift of the upper body ahead, with speed_km_h = 0")
    shift_right_mm: float = Field(0.0, description="shift to the right")
    shift_rotation_mrad: float = Field(0.0, description="rotation, counter-clockwise from above")
    friction: float = Field(0.3, ge=0.0, description="coefficient of friction, 0: without friction")
    kinetic_friction: float | None = Field(
        None, ge=0.0, description="coefficient at high slip velocity (default: friction)"
    )
    friction_decay_m_per_s: float = Field(
        0.0, ge=0.0, description="slip velocity in which the difference of both falls to 1/e"
    )
    rolling_theory: Theory = Field("exact", description="exact theory, fastsim, fastrip, polach or linear theory")
    curve: Literal["longitudinal", "lateral", "spin", "none"] = Field(
        "longitudinal", description="creepage of the creep curve by all theories; the others are those of the case"
    )
    curve_end: float = Field(
        3.0, gt=0.0, le=1e3,
        description="its end over the creepage at which linear theory reaches the limit of friction",
    )  # fmt: skip
    curve_points: int = Field(25, ge=3, le=1000, description="number of its points")
    cells_along: int = Field(30, ge=4, le=120, description="number of cells along the patch")
    cells_across: int = Field(30, ge=4, le=120, description="number of cells across")

    def check(self) -> None:
        """See `RunnableCase.check`."""
        one, other = self.semi_axis_along_mm, self.semi_axis_across_mm
        if (one is None) != (other is None):
            raise InputError("one of semi_axis_along_mm and semi_axis_across_mm", "both or none", "give both")
        radii = ("radius_along_mm", "radius_across_mm")
        given = "semi_axis_along_mm" if one is not None else None
        if self.pressure_file is not None:
            given, shape = "pressure_file", ("semi_axis_along_mm", "semi_axis_across_mm", "cells_along", "cells_across")
            self.refuse_without_effect(["force_kN", *shape], given, "none")
            read_pressures(Path(self.pressure_file))
        if given is not None:
            self.refuse_without_effect(radii, given, "none")
            if self._materials[0] != self._materials[1]:
                raise InputError(
                    f"upper_young_MPa or upper_poisson with {given}",
                    "one material under given pressures: between different ones friction changes the pressures",
                    "give radius_along_mm and radius_across_mm",
                )
        if self.rolls:
            self.refuse_without_effect(SHIFTS, "speed_km_h", "0")
        else:
            rolling = (*CREEPAGES, "rolling_theory", "friction_decay_m_per_s")
            self.refuse_without_effect(rolling, "speed_km_h", "a speed other than 0")
        if self.rolling_theory != "exact":
            self.refuse_without_effect(FORCES, "rolling_theory", "exact")
        if not self.friction:
            self.refuse_without_effect([*FORCES, "kinetic_friction"], "friction", "a coefficient above 0")
        if self.kinetic_friction is None:
            self.refuse_without_effect(["friction_decay_m_per_s"], "kinetic_friction", "a coefficient below friction")
        for force, *keys in zip(FORCES, CREEPAGES, SHIFTS, strict=False):
            if getattr(self, force) is not None:
                self.refuse_without_effect(keys, force, "none")
        _ = self._friction

    def run(self, progress: Progress = lambda _: None) -> RollingPatchRun:
        """See `RunnableCase.run`."""
        self.check()
        start = time.perf_counter()
        contact = self.contact()
        pressed = time.perf_counter()
        progress("rolling")
        along, across = (None if force is None else 1e3 * force for force in self._forces)
        exact = roll(contact, self.motion, force_along=along, force_across=across)
        found = exact if self.rolling_theory == "exact" else FAST[self.rolling_theory](contact, self.motion)
        states: dict[Theory, CreepForces] = {"exact": exact} if self.rolls else {}
        states |= {name: theory(contact, exact.motion) for name, theory in FAST.items()} if self.rolls else {}
        rolled = time.perf_counter()
        curve, notices = self._curve(contact, exact.motion, progress)
        total = time.perf_counter()
        timings = {"pressures": pressed - start, "rolling": rolled - pressed, "curve": total - rolled}
        notices = [*dict.fromkeys((*exact.motion.notices, *self._friction.notices, *found.notices, *notices))]
        summary = self._summary(contact, found, states, timings | {"total": total - start}, notices)
        return RollingPatchRun(self, summary, contact, found, curve)

    @property
    def rolls(self) -> bool:
        """Whether the bodies roll; otherwise the upper one is shifted."""
        return self.speed_km_h != 0.0

    @property
    def has_curve(self) -> bool:
        """Whether a run has a creep curve: a shift, and contact without friction, have none."""
        return self.curve != "none" and self.rolls and self.friction > 0.0

    def contact(self) -> RollingContact:
        """Return the patch: pressures of the file, Hertz's on the ellipse, or those of contact by the radii."""
        if self.pressure_file is not None:
            grid, pressures = read_pressures(Path(self.pressure_file))
            return RollingContact.between_half_spaces(grid, pressures, self._friction, self._materials)
        force, cells = 1e3 * self.force_kN, (self.cells_across, self.cells_along)
        if self.semi_axis_along_mm is not None and self.semi_axis_across_mm is not None:
            axes = self.semi_axis_across_mm, self.semi_axis_along_mm
            return RollingContact.under_hertz(axes, force, cells, self._friction, self._materials)
        modulus = contact_modulus(*(each.plane_modulus for each in self._materials))
        hertz = PointContact(force, self.radius_across_mm, self.radius_along_mm, modulus)
        n_rows, n_strips = (n + 2 * MARGIN for n in cells)
        half, strip = hertz.semi_axes[0] * n_rows / cells[0], 2.0 * hertz.semi_axes[1] / cells[1]
        grid = PatchGrid(half * np.linspace(-1.0, 1.0, n_rows + 1), strip, n_strips)
        across = (grid.bounds[1:] + grid.bounds[:-1]) / 2.0
        gaps = across[:, None] ** 2 / (2.0 * self.radius_across_mm) + grid.along**2 / (2.0 * self.radius_along_mm)
        return RollingContact.of_half_spaces(grid, gaps, self._friction, self._materials, force=force)

    @property
    def motion(self) -> Creepages:
        """Creepages with spin in 1/mm and the speed in m/s, or the shift; 0 where a force is given."""
        values = [getattr(self, key) for key in (CREEPAGES if self.rolls else SHIFTS)]
        for number, force in enumerate(self._forces):
            values[number] = 0.0 if force is not None else values[number]
        return Creepages(values[0], values[1], 1e-3 * values[2], self.speed_km_h / 3.6)

    @property
    def _forces(self) -> tuple[float | None, float | None]:
        return self.longitudinal_force_kN, self.lateral_force_kN

    @cached_property
    def _friction(self) -> Friction:
        return Friction(self.friction, self.kinetic_friction, self.friction_decay_m_per_s)

    @property
    def _materials(self) -> tuple[Elastic, Elastic]:
        young = self.young_MPa if self.upper_young_MPa is None else self.upper_young_MPa
        poisson = self.poisson if self.upper_poisson is None else self.upper_poisson
        return Elastic(self.young_MPa, self.poisson), Elastic(young, poisson)

    def _curve(
        self, contact: RollingContact, motion: Creepages, progress: Progress
    ) -> tuple[list[TheoryForces], Iterable[str]]:
        """Points of the creep curve of all theories, and what is to be said about it."""
        if not self.has_curve:
            return [], ()
        progress("creep curve")
        ellipse, name = EllipticContact.of(contact, motion), COMPONENTS[self.curve]
        c, size = ellipse.coefficients, float(np.sqrt(ellipse.along * ellipse.across))
        rate = {"along": c.c11, "across": c.c22, "spin": c.c23 * size}[name]
        end = self.curve_end * ellipse.friction * ellipse.force / (ellipse.unit * rate)
        values: Floats = np.linspace(0.0, end, self.curve_points)
        motions = [replace(motion, **{name: value}) for value in values.tolist()]
        exact = creep_curve(contact, motions)
        states: dict[Theory, Sequence[CreepForces]] = {"exact": exact}
        states |= {theory: [compute(contact, each) for each in motions] for theory, compute in FAST.items()}
        failed = sum(not each.status.converged for each in exact)
        notices = [f"{failed} of {len(exact)} points of the creep curve by the exact theory did not converge"]
        return [_forces_by(theory, each) for theory, all_of in states.items() for each in all_of], notices[:failed]

    def _summary(
        self,
        contact: RollingContact,
        found: CreepForces,
        states: dict[Theory, CreepForces],
        timings_s: dict[str, float],
        notices: Sequence[str],
    ) -> RollingPatchSummary:
        rolls, motion = self.rolls, found.motion
        ellipse = EllipticContact.of(contact, motion if rolls else Creepages())
        fields = found if isinstance(found, Rolling | SimplifiedRolling) else None
        inside = fields.states != NO_CONTACT if fields else None
        slip = float(np.linalg.norm(fields.slip_velocities, axis=2).max()) if fields else None
        error = None
        if rolls and isinstance(found, Rolling):
            power = abs(motion.speed) * found.t_gamma
            error = abs(found.frictional_power - power) / (abs(power) + abs(found.rolling_power) or 1.0)
        shift = None
        if slip is not None and not rolls:
            shift = ShiftSummary(
                longitudinal_mm=float(motion.along),
                lateral_mm=float(motion.across),
                rotation_mrad=1e3 * float(motion.spin),
                max_slip_mm=slip,
                dissipated_N_mm=found.frictional_power,
            )
        return RollingPatchSummary(
            status=StatusSummary(found.status.converged, found.status.message),
            case={"name": self.name, **self.model_dump()},
            timings_s=timings_s,
            theory=TITLES[self.rolling_theory],
            force_kN=contact.force / 1e3,
            semi_axis_along_mm=ellipse.along,
            semi_axis_across_mm=ellipse.across,
            max_pressure_MPa=float(contact.pressures.max()),
            cells=[part.stop - part.start for part in contact.box],
            longitudinal_force_kN=found.along / 1e3,
            lateral_force_kN=found.across / 1e3,
            spin_moment_Nm=found.moment / 1e3,
            traction_coefficient=float(np.hypot(found.along, found.across)) / contact.force,
            rolling=_forces_by(self.rolling_theory, found) if rolls else None,
            shift=shift,
            frictional_power_W=found.frictional_power if rolls else None,
            slipping_share=float((fields.states[inside] == SLIPS).mean()) if fields else None,
            max_traction_MPa=float(np.linalg.norm(fields.tractions, axis=2).max()) if fields else None,
            max_slip_velocity_m_s=slip if rolls else None,
            max_power_density_W_mm2=float(fields.power_density.max()) if fields and rolls else None,
            residuals=found.residuals if isinstance(found, Rolling) else {},
            energy_error=error,
            theories=[_forces_by(name, each) for name, each in states.items()],
            notices=notices,
        )


def _forces_by(theory: Theory, found: CreepForces) -> TheoryForces:
    motion = found.motion
    return TheoryForces(
        theory=TITLES[theory],
        longitudinal_creepage=float(motion.along),
        lateral_creepage=float(motion.across),
        spin_creepage_per_m=1e3 * float(motion.spin),
        longitudinal_force_kN=found.along / 1e3,
        lateral_force_kN=found.across / 1e3,
        spin_moment_Nm=found.moment / 1e3,
        t_gamma_N=found.t_gamma,
        t_gamma_without_spin_N=found.products(motion)[0],
        t_gamma_with_spin_N=sum(found.products(motion)),
    )
