"""The case of one contact patch between half-spaces on which two bodies roll, or shift, with friction."""

# ruff: noqa: N815 (units in names)
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import annotated_types as at
import numpy as np
from pydantic import Field, model_validator

from flangeway.cases.case import RunnableCase
from flangeway.cases.patch_quantities import (
    BY_THEORY,
    CREEPAGES,
    FIELDS,
    FORCES,
    ON_SURFACE,
    POWER,
    SHIFT,
    T_GAMMAS,
    THEORY,
    TRACTION,
    Creep,
)
from flangeway.cases.summary import RunResult
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.contact.rolling.elliptic_contact import EllipticContact
from flangeway.contact.rolling.exact_rolling import creep_curve, roll
from flangeway.contact.rolling.fast_theories import FAST, WITH_TRACTIONS, Theory
from flangeway.contact.rolling.friction import Friction, FrictionCoefficient, FrictionInputs, Heating, SlopeReduction
from flangeway.contact.rolling.rolling_contact import Creepages, CreepForces, Rolling, RollingContact
from flangeway.errors import InputError
from flangeway.exact import PointContact, contact_modulus
from flangeway.materials import Elastic
from flangeway.quantities import Quantities, Quantity, values
from flangeway.records import TAG, NotNegative, Positive, Record, refused_by_check
from flangeway.solve import Status
from flangeway.system.file_content import number_table
from flangeway.types import Floats, Ints, Progress

# --- Pressures of a contact patch from a CSV file, as ``cells.csv`` of a patch that rolls has them.


COLUMNS = ("right_mm", "ahead_mm", "pressure_MPa")
WANTED = f"a CSV file with the columns {', '.join(COLUMNS)}: middles of even cells, and mean pressures"
OFF_GRID = 0.02
"""Distance of a place from the regular grid, relative to the size of the cells, that digits explain."""
MAX_CELLS = 120


def read_pressures(path: Path) -> tuple[PatchGrid, Floats]:
    """Return the cells of a file and their pressures, shape (n_cells, n_strips); those that it leaves out have none.

    Raises
    ------
    InputError
        If it cannot be read, lacks a column, has what is no number, or its places are on no regular grid.

    """
    values = number_table(path, COLUMNS, WANTED)
    (row, bounds), (strip, ends) = (_on_grid(path, name, values[:, axis]) for axis, name in enumerate(COLUMNS[:2]))
    pressures = np.full((len(bounds) - 1, len(ends) - 1), np.nan)
    pressures[row, strip] = values[:, 2]
    if np.isfinite(pressures).sum() < len(values):
        raise InputError(f"{path}: a cell for the second time", "each cell once", "leave the other one out")
    width = float(ends[1] - ends[0])
    return PatchGrid(bounds, width, len(ends) - 1, float(ends[0] + ends[-1]) / 2.0), np.nan_to_num(pressures)


def _on_grid(path: Path, name: str, values: Floats) -> tuple[Ints, Floats]:
    """Numbers of the cells in which places are, and the ends of these cells."""
    different = np.unique(values)
    if len(different) < 2 or not np.ptp(values) < MAX_CELLS * np.diff(different).min():
        raise _uneven(path, name, different)
    # digits are lost in single differences, not in the whole length
    n = round(float(np.ptp(values) / np.diff(different).min())) + 1
    step = float(np.ptp(values)) / (n - 1)
    exact = (values - different[0]) / step
    cells = np.rint(exact).astype(np.int64)
    if np.abs(exact - cells).max() > OFF_GRID:
        raise _uneven(path, name, different)
    return cells, different[0] + step * (np.arange(n + 1, dtype=np.float64) - 0.5)


def _uneven(path: Path, name: str, different: Floats) -> InputError:
    steps = f" in steps from {np.diff(different).min():g} mm" if len(different) > 1 else ""
    return InputError(
        f"{path}: {len(different)} different {name}{steps}",
        f"places on a regular grid of 2 to {MAX_CELLS} cells",
        "interpolate them to even cells",
    )


# --- The case of one contact patch between half-spaces on which two bodies roll, or shift, with friction.


COMPONENTS = {"longitudinal": "along", "lateral": "across", "spin": "spin"}
"""Components of creepages by the names of creep curves."""
MARGIN = 1
"""Cells beyond the ellipse on each side, where pressures are found by contact."""


@dataclass(frozen=True, eq=False)
class RollingPatchRun(RunResult):
    """A patch that rolls and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    timings_s
        Seconds by stage.
    contact
        The patch.
    state
        What the chosen theory gives; t of the patch is to the right, z ahead, the speed is in m/s.
    theories
        What all theories give; none for a shift.
    curve
        Points of the creep curve by theories; none without one.
    notices
        What the reader should know.

    """

    main_table = "theories"

    case: "RollingPatchCase"
    timings_s: Mapping[str, float]
    contact: RollingContact
    state: CreepState
    theories: Sequence[CreepState]
    curve: Mapping[Theory, Sequence[CreepState]]
    notices: Sequence[str]

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.state.forces.status

    @cached_property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes along and across of the ellipse with the second moments of the pressures, mm."""
        ellipse = EllipticContact.of(self.contact, self.state.creepages if self.state.rolls else Creepages())
        return ellipse.along, ellipse.across

    @property
    def residuals(self) -> dict[str, float]:
        """See `flangeway.contact.rolling.rolling_contact.Rolling.residuals`; none of the fast theories."""
        forces = self.state.forces
        return forces.residuals if isinstance(forces, Rolling) else {}

    @property
    def energy_error(self) -> float | None:
        """Frictional power less that of forces times creepages, over the power; of the exact theory."""
        forces = self.state.forces
        if not self.state.rolls or not isinstance(forces, Rolling):
            return None
        power = abs(forces.motion.speed) * forces.t_gamma
        return abs(forces.frictional_power - power) / (abs(power) + abs(forces.rolling_power) or 1.0)

    def parts(self) -> dict[str, Any]:
        """See `RunResult.parts`."""
        return {
            **values(PATCH, self),
            **values(STATE, self.state),
            **values([ENERGY_ERROR], self),
            "residuals": self.residuals,
            "theories": [values(BY_THEORY, theory) for theory in self.theories],
            "notices": self.notices,
        }


MAX_PRESSURE: Quantity[RollingPatchRun] = Quantity(
    "max_pressure", "maximum pressure", lambda run: run.contact.pressures.max(), "MPa", ".1f"
)
PATCH: Quantities[RollingPatchRun] = (
    Quantity("force", "normal force", lambda run: run.contact.force, "kN", ".3f", factor=1e-3),
    Quantity("semi_axis_along", "semi-axis along", lambda run: run.semi_axes[0], "mm", ".3f"),
    Quantity("semi_axis_across", "semi-axis across", lambda run: run.semi_axes[1], "mm", ".3f"),
    MAX_PRESSURE,
    Quantity("cells", "", lambda run: [part.stop - part.start for part in run.contact.box], parts=ON_SURFACE),
)
ENERGY_ERROR: Quantity[RollingPatchRun] = Quantity(
    "energy_error", "frictional power less forces times creepages, relative", lambda run: run.energy_error, form=".1e"
)
STATE: tuple[Creep, ...] = (THEORY, *CREEPAGES, *SHIFT, *FORCES, TRACTION, *T_GAMMAS, POWER, *FIELDS)


class TangentialForces(Record):
    """Tangential forces on the upper body, in the place of the motions that are then found."""

    longitudinal_force_kN: float | None = None
    """tangential force on the upper body ahead, instead of the creepage or shift, which is found"""
    lateral_force_kN: float | None = None
    """the same to the right"""

    @property
    def forces(self) -> list[float | None]:
        """Both in N."""
        return [None if force is None else 1e3 * force for force in (self.longitudinal_force_kN, self.lateral_force_kN)]


class RollingOver(FrictionInputs, TangentialForces):
    """The upper body rolls over the lower one."""

    kind: Literal["rolling"] = "rolling"
    """rolling"""
    speed_km_h: float = 72.0
    """speed of rolling ahead, negative: backwards"""
    longitudinal_creepage: float = 0.001
    """slip of the upper body on the lower one ahead, divided by the speed"""
    lateral_creepage: float = 0.0
    """slip to the right, divided by the speed"""
    spin_creepage_per_m: float = 0.0
    """rotation of the upper body, counter-clockwise from above, divided by the speed"""
    theory: Theory = "exact"
    """exact theory, fastsim, fastrip, polach or linear theory"""
    curve: Literal["longitudinal", "lateral", "spin", "none"] = "longitudinal"
    """creepage of the creep curve by all theories; the others are those of the case"""
    curve_end: Annotated[float, at.Gt(0.0), at.Le(1e3)] = 3.0
    """its end relative to the creepage at which linear theory reaches the limit of friction"""
    curve_points: Annotated[int, at.Ge(3), at.Le(1000)] = 25
    """number of its points"""

    exclusive = (("longitudinal_creepage", "longitudinal_force_kN"), ("lateral_creepage", "lateral_force_kN"))

    @model_validator(mode="after")
    def _goes_together(self) -> "RollingOver":
        if self.speed_km_h == 0.0:
            raise refused_by_check("speed_km_h = 0", "a speed other than 0", 'give kind = "shift" without rolling')
        if self.theory != "exact" and self.forces != [None, None]:
            raise refused_by_check(f"forces with theory = {self.theory}", "theory = exact", "give creepages")
        return self

    @property
    def creepages(self) -> Creepages:
        """Creepages with spin in 1/mm and the speed in m/s."""
        spin = 1e-3 * self.spin_creepage_per_m
        return Creepages(self.longitudinal_creepage, self.lateral_creepage, spin, self.speed_km_h / 3.6)

    @property
    def words(self) -> str:
        """How it moves."""
        return f"at {self.speed_km_h:g} km/h"


class ShiftedOver(TangentialForces):
    """The upper body is shifted and does not roll."""

    kind: Literal["shift"] = "shift"
    """a shift without rolling"""
    shift_ahead_mm: float = 0.0
    """shift of the upper body ahead"""
    shift_right_mm: float = 0.0
    """shift to the right"""
    shift_rotation_mrad: float = 0.0
    """rotation, counter-clockwise from above"""
    kinetic: FrictionCoefficient | None = None
    """coefficient of friction as soon as surfaces slip (default: friction)"""
    slope: SlopeReduction = SlopeReduction()
    """reduction of the initial slope of creep forces by layers on the surfaces"""

    exclusive = (("shift_ahead_mm", "longitudinal_force_kN"), ("shift_right_mm", "lateral_force_kN"))
    theory: ClassVar[Theory] = "exact"
    curve: ClassVar[str] = "none"
    words: ClassVar[str] = "shifted"

    @property
    def creepages(self) -> Creepages:
        """The shift, with the rotation in rad, without a speed."""
        return Creepages(self.shift_ahead_mm, self.shift_right_mm, 1e-3 * self.shift_rotation_mrad, 0.0)

    def law(self, static: float) -> Friction:
        """See `FrictionInputs.law`."""
        return Friction(static, self.kinetic, heating=Heating(), slope=self.slope)


class PressedBodies(Record):
    """Two bodies that a force presses together, on cells."""

    force_kN: Positive = 80.0
    """normal force"""
    cells_along: Annotated[int, at.Ge(4), at.Le(MAX_CELLS)] = 30
    """number of cells along the patch"""
    cells_across: Annotated[int, at.Ge(4), at.Le(MAX_CELLS)] = 30
    """number of cells across"""


class RadiiPatch(PressedBodies):
    """A patch by the curvatures of the gap."""

    kind: Literal["radii"] = "radii"
    """contact by the radii"""
    radius_along_mm: Positive = 460.0
    """relative radius of curvature ahead, 1 / (1 / R_upper + 1 / R_lower)"""
    radius_across_mm: Positive = 300.0
    """relative radius of curvature across"""
    upper_young_MPa: Positive | None = None
    """Young's modulus of the upper body (default: young_MPa)"""
    upper_poisson: Annotated[float, at.Ge(0.0), at.Lt(0.5)] | None = None
    """Poisson's ratio of the upper body (default: poisson)"""

    def contact(self, friction: Friction, steel: Elastic) -> RollingContact:
        """Return the patch, with the material of the lower body."""
        young, poisson = self.upper_young_MPa or steel.young, self.upper_poisson
        materials = steel, Elastic(young, steel.poisson if poisson is None else poisson)
        modulus = contact_modulus(*(material.plane_modulus for material in materials))
        force, cells = 1e3 * self.force_kN, (self.cells_across, self.cells_along)
        hertz = PointContact(force, self.radius_across_mm, self.radius_along_mm, modulus)
        n_rows, n_strips = (n + 2 * MARGIN for n in cells)
        half, strip = hertz.semi_axes[0] * n_rows / cells[0], 2.0 * hertz.semi_axes[1] / cells[1]
        grid = PatchGrid(half * np.linspace(-1.0, 1.0, n_rows + 1), strip, n_strips)
        gaps = grid.stations[:, None] ** 2 / (2.0 * self.radius_across_mm) + grid.along**2 / (
            2.0 * self.radius_along_mm
        )
        return RollingContact.of_half_spaces(grid, gaps, friction, materials, force=force)


class EllipsePatch(PressedBodies):
    """An ellipse under Hertz's pressure."""

    kind: Literal["ellipse"] = "ellipse"
    """Hertz's pressure on an ellipse"""
    semi_axis_along_mm: Positive
    """semi-axis ahead"""
    semi_axis_across_mm: Positive
    """semi-axis across"""

    def contact(self, friction: Friction, steel: Elastic) -> RollingContact:
        """See `RadiiPatch.contact`."""
        axes, cells = (self.semi_axis_across_mm, self.semi_axis_along_mm), (self.cells_across, self.cells_along)
        return RollingContact.under_hertz(axes, 1e3 * self.force_kN, cells, friction, (steel, steel))


class PressureFile(Record):
    """Pressures of a file."""

    kind: Literal["file"] = "file"
    """pressures of a file"""
    file: str
    """CSV file of pressures: right_mm, ahead_mm, pressure_MPa of cells"""

    def contact(self, friction: Friction, steel: Elastic) -> RollingContact:
        """See `RadiiPatch.contact`."""
        grid, pressures = read_pressures(Path(self.file))
        return RollingContact.between_half_spaces(grid, pressures, friction, (steel, steel))


class RollingPatchCase(RunnableCase):
    """Two half-spaces pressed together by a force that roll over each other; all results are those on the upper one."""

    name = "rolling-patch"
    title = "One contact patch that rolls with friction"
    essential = (
        *("patch.force_kN", "patch.radius_along_mm", "patch.radius_across_mm", "motion.longitudinal_creepage"),
        *("motion.lateral_creepage", "motion.spin_creepage_per_m", "motion.speed_km_h", "friction"),
    )

    patch: RadiiPatch | EllipsePatch | PressureFile = Field(RadiiPatch(), discriminator=TAG)
    """pressures of the patch"""
    young_MPa: Positive = 210e3
    """Young's modulus"""
    poisson: Annotated[float, at.Ge(0.0), at.Lt(0.5)] = 0.3
    """Poisson's ratio"""
    motion: RollingOver | ShiftedOver = Field(RollingOver(), discriminator=TAG)
    """how the upper body moves on the lower one"""
    friction: NotNegative = 0.3
    """coefficient of friction, 0: without friction"""

    def check(self) -> None:
        """See `RunnableCase.check`."""
        if isinstance(self.patch, PressureFile):
            read_pressures(Path(self.patch.file))
        _ = self._friction

    def run(self, progress: Progress = lambda _: None) -> RollingPatchRun:
        """See `RunnableCase.run`."""
        self.check()
        start = time.perf_counter()
        contact = self.contact()
        pressed = time.perf_counter()
        progress("rolling")
        along, across = self.motion.forces
        creepages, theory = self.creepages, self.motion.theory
        exact = roll(contact, creepages, force_along=along, force_across=across)
        forces = exact if theory == "exact" else FAST[theory](contact, creepages)
        states = [exact, *(fast(contact, exact.motion) for fast in self._theories.values())] if self.rolls else []
        rolled = time.perf_counter()
        curve, notices = self._curve(contact, exact.motion, progress)
        total = time.perf_counter()
        timings = {"pressures": pressed - start, "rolling": rolled - pressed, "curve": total - rolled}
        notices = [*dict.fromkeys((*exact.motion.notices, *self._friction.notices, *forces.notices, *notices))]
        state, *theories = (CreepState(result, contact) for result in (forces, *states))
        return RollingPatchRun(self, timings | {"total": total - start}, contact, state, theories, curve, notices)

    @property
    def rolls(self) -> bool:
        """Whether the bodies roll; otherwise the upper one is shifted."""
        return self.motion.kind == "rolling"

    def contact(self) -> RollingContact:
        """Return the patch: pressures of the file, Hertz's on the ellipse, or those of contact by the radii."""
        return self.patch.contact(self._friction, Elastic(self.young_MPa, self.poisson))

    @property
    def creepages(self) -> Creepages:
        """Creepages with spin in 1/mm and the speed in m/s, or the shift; 0 where a force is given."""
        motion, (along, across) = self.motion.creepages, self.motion.forces
        ahead, right = (
            0.0 if force is not None else way for way, force in ((motion.along, along), (motion.across, across))
        )
        return replace(motion, along=ahead, across=right)

    @cached_property
    def _friction(self) -> Friction:
        return self.motion.law(self.friction)

    @property
    def _theories(self) -> dict[Theory, Callable[[RollingContact, Creepages], CreepForces]]:
        """Fast theories that can be computed."""
        warm = self._friction.by_temperature
        return {name: theory for name, theory in FAST.items() if name in WITH_TRACTIONS or not warm}

    def _curve(
        self, contact: RollingContact, motion: Creepages, progress: Progress
    ) -> tuple[dict[Theory, list[CreepState]], Iterable[str]]:
        """Points of the creep curve by theories, and what is to be said about it."""
        if not isinstance(self.motion, RollingOver) or self.motion.curve == "none" or not self.friction:
            return {}, ()
        progress("creep curve")
        ellipse, name = EllipticContact.of(contact, motion), COMPONENTS[self.motion.curve]
        c, size = ellipse.coefficients, float(np.sqrt(ellipse.along * ellipse.across))
        rate = {"along": c.c11, "across": c.c22, "spin": c.c23 * size}[name]
        end = self.motion.curve_end * ellipse.friction * ellipse.force / (ellipse.unit * rate)
        points: Floats = np.linspace(0.0, end, self.motion.curve_points)
        motions = [replace(motion, **{name: point}) for point in points.tolist()]
        exact = creep_curve(contact, motions)
        states: dict[Theory, Sequence[CreepForces]] = {"exact": exact}
        states |= {theory: [compute(contact, step) for step in motions] for theory, compute in self._theories.items()}
        failed = sum(not point.status.converged for point in exact)
        notices = [f"{failed} of {len(exact)} points of the creep curve by the exact theory did not converge"]
        curve = {theory: [CreepState(point, contact) for point in forces] for theory, forces in states.items()}
        return curve, notices[:failed]
