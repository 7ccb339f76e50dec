"""What engineers ask for of a wheelset in three dimensions: its patches, and the stresses below them."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact.rolling.rolling_contact import Rolling
from flangeway.errors import InputError
from flangeway.exact.shakedown import ABOVE_SHAKEDOWN, shakedown_state
from flangeway.post.patch_stresses import StressField
from flangeway.railway.profiles.orientation import flange_angle_rad
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity, klingel_wavelength
from flangeway.railway.rigid.rigid_geometry import CLIMBED_MM
from flangeway.railway.track.placements import (
    RUNNING_CIRCLES_MM,
    SIDE_SIGN,
    SIDES,
    Side,
    WheelsetPosition,
    lateral_over_vertical,
)
from flangeway.railway.track.supports import Fixed
from flangeway.railway.track.wheelset_problem import ROLES, Role, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.rolling.patch_rolling import RollingPatch, rows_of, strips_of
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.side_contact import SideState, tangents_of
from flangeway.railway.wheelset.spatial_wheelset import RollingPlace, SpatialWheelset
from flangeway.railway.wheelset.supported_rail import LoadedRail, RailAlongTrack, rails_along_track, supported_rail
from flangeway.railway.wheelset.wheel_patch import SpatialPatch
from flangeway.railway.wheelset.wheelset_checks import yield_strength
from flangeway.railway.wheelset.wheelset_newton import SpatialState
from flangeway.solve import Status
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

RIGID_MM = 1e-6
"""Difference of lateral positions of rigid wheels that is round-off."""
KLINGEL_MM = 3.0
"""Amplitude of the kinematic motion."""
BESIDE_MM = 1e-2
"""Distance from the middle of the track below which a wheelset stands in it."""
NO_ELLIPSE = 0.8
"""Area of a patch relative to that of its equivalent ellipse below which it is none; single patches have 0.95 to
1.02."""


@dataclass(frozen=True, eq=False)
class SpatialResult:
    """A wheelset in equilibrium on its track, in three dimensions.

    - `equilibrium`: position, residuals and contact of both sides.
    - `patches`: left side first, each side by falling force.
    - `timings_s`: seconds of the stages.
    - `warnings`: what limits the result.
    - `cache`: where solutions of the sections are kept from one process to the next.
    - `rolling`: the patches with their creep forces, empty without friction.
    """

    status: Status
    wheelset: SpatialWheelset
    equilibrium: Equilibrium[SpatialState]
    patches: tuple[SpatialPatch, ...]
    timings_s: dict[str, float]
    warnings: tuple[str, ...]
    cache: Cache | None = None
    rolling: tuple[RollingPatch, ...] = ()

    @property
    def problem(self) -> WheelsetProblem:
        """Wheelset, track and load."""
        return self.wheelset.problem

    @property
    def yield_MPa(self) -> float | None:  # noqa: N802
        """See `yield_strength`."""
        return yield_strength(self.problem, *ROLES)

    def rolling_of(self, patch: SpatialPatch) -> RollingPatch | None:
        """Return a patch with its creep forces, None without friction."""
        return next((rolled_patch for rolled_patch in self.rolling if rolled_patch.patch is patch), None)

    def load_factor(self, patch: SpatialPatch) -> float | None:
        """Maximum pressure over the shear strength, p0 / k; None if the yield strength is not known."""
        return float(np.sqrt(3.0) * patch.ellipse.max_pressure / self.yield_MPa) if self.yield_MPa else None

    def shakedown_state(self, patch: SpatialPatch) -> str | None:
        """State of the steel under repeated rolling, see `flangeway.exact.shakedown.shakedown_state`."""
        factor, rolling = self.load_factor(patch), self.rolling_of(patch)
        return None if factor is None else shakedown_state(factor, rolling.used_friction if rolling else 0.0)

    def tractions_of(self, side: Side) -> Floats | None:
        """Tractions (t, z) by friction on the wheel's cells of a side, (n, n_z, 2); None: the theory has none."""
        tractions = [
            rolled_patch.tractions
            for rolled_patch in self.rolling
            if rolled_patch.patch.side == side and rolled_patch.tractions is not None
        ]
        return sum(tractions[1:], tractions[0]) if tractions else None

    @cached_property
    def stress_fields(self) -> dict[SpatialPatch, dict[Role, StressField]]:
        """Stresses in the volumes below the patches of both bodies, by the tractions of all cells of a side."""
        fields: dict[SpatialPatch, dict[Role, StressField]] = {}
        for patch in self.patches:
            tractions = self.tractions_of(patch.side)
            rail = patch.field("rail", tractions)
            # without tractions both bodies of one material have the same stresses
            alike = (
                tractions is None and len({material.poisson for material in patch.state.grid.surfaces.materials}) == 1
            )
            fields[patch] = {"rail": rail, "wheel": rail if alike else patch.field("wheel", tractions)}
        return fields

    @property
    def approach_mm(self) -> float:
        """Vertical displacement of the axle's middle, down, from the rigid position to the equilibrium."""
        return self.wheelset.start.motion.vertical_mm - self.equilibrium.position.vertical_mm

    @cached_property
    def rails(self) -> dict[Side, RailAlongTrack]:
        """Rails along the track under these contact forces; without those whose bases are fixed."""
        track, sides, rails_by_side = self.problem.track, self.equilibrium.state.sides, dict[Side, RailAlongTrack]()
        for side in SIDES:
            profile, support = track.rail_of(side), track.support_of(side)
            if side in rails_by_side or isinstance(support, Fixed):
                continue
            rail = supported_rail(profile, self.problem.material_of("rail"), support, cache=self.cache)
            same = [other for other in SIDES if track.rail_of(other) is profile and track.support_of(other) == support]
            rails = rails_along_track(rail, profile, [_on_rail(sides[other]) for other in same])
            rails_by_side |= dict(zip(same, rails, strict=True))
        return rails_by_side

    @property
    def position_in_space(self) -> WheelsetPosition:
        """The position along horizontal and vertical."""
        return self.equilibrium.position.turned(self.problem.forces.tilt_rad)

    def force_on_wheel_N(self, side: Side) -> Floats:  # noqa: N802
        """Contact force on the wheel of a side with creep forces, axes of the track, shape (2,)."""
        state = self.equilibrium.state
        force = state.sides[side].resultant[:2]
        if state.rolled is not None:
            force = force + state.rolled.creep[side].resultant[:2]
        return force * (SIDE_SIGN[side], 1.0)

    @property
    def kinematic_wavelength_mm(self) -> float | None:
        """Wavelength of the rigid wheelset's kinematic motion (Klingel, 1883), None if its conicity is not positive.

        For the equivalent conicity (EN 15302) at an amplitude of 3 mm.
        """
        geometry, problem = self.wheelset.geometry, self.problem
        lateral = np.linspace(-2.0, 2.0, 401) * KLINGEL_MM
        try:
            conicity = float(equivalent_conicity(RollingRadiusDifference.of(geometry.locus(lateral)), KLINGEL_MM)[0])
        except InputError:
            return None
        if not conicity > 0.0:
            return None
        distance = problem.track.gauge_mm + RUNNING_CIRCLES_MM
        return float(klingel_wavelength(conicity, distance, problem.wheels.tape_radius_mm))

    def nadal_limit(self, side: Side) -> float:
        """Nadal's limit of L/V (1908): ``(tan d - mu) / (1 + mu tan d)`` at the steepest angle d of a wheel's flange.

        mu is the static coefficient of friction there. nan without friction.
        """
        rolling = self.problem.friction
        if rolling is None:
            return float("nan")
        slope = float(np.tan(flange_angle_rad(self.problem.wheels.wheel_of(side).running_surface)))
        own = rolling.flange_friction
        friction = self.problem.friction_of(side) if own is None else own
        return (slope - friction) / (1.0 + friction * slope)

    def flange_touches(self, side: Side) -> bool:
        """Whether a wheel touches the gauge corner: with its flange or flange root."""
        return any(patch.side == side and patch.region == "gauge corner" for patch in self.patches)

    def head_motion(self, side: Side) -> tuple[float, float, float, float]:
        """Motion of a rail's head in the track's axes, lateral, vertical and roll, and that of its gauge face outwards.

        See `flangeway.railway.wheelset.side_contact.GriddedSide.rail_motion`.
        """
        state, sign = self.equilibrium.state.sides[side], SIDE_SIGN[side]
        (lateral, vertical, roll), outward = state.grid.rail_motion(state.forces, state.creep[:, 0])
        return sign * float(lateral), float(vertical), sign * float(roll), float(outward)

    def lateral_over_vertical(self, side: Side) -> float:
        """Ratio L/V of a wheel's contact force, see `flangeway.railway.track.placements.lateral_over_vertical`."""
        return lateral_over_vertical(self.force_on_wheel_N(side), side)


def _on_rail(state: SideState) -> LoadedRail:
    """Contact forces on a rail, in the frame of its profile."""
    grid, frame = state.grid.grid, state.grid.surfaces.rail_frame
    loaded = np.asarray(state.forces.any(axis=1))
    points = frame.inverse().points(state.grid.surfaces.rail_points(grid.stations[loaded])[0])
    normals = state.normals[loaded]
    forces = -state.forces.sum(axis=1)[loaded, None] * frame.inverse().vectors(normals)
    forces = forces - state.creep[loaded, :1] * frame.inverse().vectors(tangents_of(normals))
    return LoadedRail(points, np.column_stack((forces, -state.creep[loaded, 1])), frame)


def solve_spatial(
    problem: WheelsetProblem,
    *,
    cold: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> SpatialResult:
    """Find a wheelset's equilibrium in three dimensions, and its patches.

    - `cold`: compute everything anew, without the user's cache.
    """
    timings: dict[str, float] = {}
    start = time.perf_counter()
    cache = None if cold else Cache.of_user()
    rigid = SpatialWheelset(problem, {})
    _ = rigid.start  # what rigid wheels cannot do is refused before the bodies are meshed
    surfaces = running_surfaces(problem, cache=cache, progress=progress)
    timings["compliance"] = time.perf_counter() - start
    return replace(solve_position(rigid.on(surfaces), timings, progress), cache=cache)


def solve_position(
    wheelset: SpatialWheelset,
    timings: dict[str, float],
    progress: Callable[[str], None] = lambda _: None,
    near: RollingPlace | None = None,
) -> SpatialResult:
    """Find the equilibrium of a wheelset whose running surfaces are ready.

    - `near`: see `flangeway.railway.wheelset.spatial_wheelset.SpatialWheelset.solve`.
    """
    begun = time.perf_counter()
    equilibrium = wheelset.solve(progress, near)
    problem = wheelset.problem
    patches: list[SpatialPatch] = []
    for side in SIDES if equilibrium.status.converged else ():
        state = equilibrium.state.sides[side]
        rolled = equilibrium.state.rolled
        interiors = None if rolled is None else rolled.creep[side].interiors
        patches += [SpatialPatch(side, state, ellipse) for ellipse in state.cells.patches(interiors)]
    timings["contact"] = time.perf_counter() - begun
    status = equilibrium.status
    warnings = equilibrium.warnings(status, {patch.side for patch in patches})
    warnings += [
        f"{patch.side} side, {patch.region}: {patch.remark} on a narrow patch, its maximum pressure is rough"
        for patch in patches
        if patch.remark
    ]
    lateral, position = problem.position.lateral_mm, equilibrium.position
    rise = wheelset.rise(position)
    # where rigid wheels stand at the lateral position, what is not balanced says more
    beyond = lateral is not None and abs(lateral - wheelset.start.motion.lateral_mm) > RIGID_MM
    climbs = rise > CLIMBED_MM and (status.converged or lateral is not None)
    if climbs or (beyond and not status.converged):
        reason = f"derailed, at {position.lateral_mm:.1f} mm "
        reason += f"the axle is {rise:.1f} mm higher than in the middle of the track, a flange on its rail"
        if not climbs:
            reason = "no equilibrium; rigid wheels derail there, or stand on the end of a running surface"
        if lateral is not None:
            raise InputError(
                f"lateral_mm = {lateral:g}: {reason}",
                f"a position at which wheels stand, rigid ones up to {wheelset.start.motion.lateral_mm:.1f} mm",
                "give a smaller lateral_mm",
            )
        status = Status(False, reason + "; check what is prescribed and the load", status.iterations)
    warnings += [
        f"{patch.side} side, {patch.region}: the patch is no ellipse; its semi-axes are those of its second moments"
        for patch in patches
        if patch.ellipse.area < NO_ELLIPSE * np.pi * np.prod(patch.ellipse.semi_axes)
    ]
    rolling = _rolling(wheelset, equilibrium.state, patches) if status.converged else ()
    result = SpatialResult(status, wheelset, equilibrium, tuple(patches), timings, tuple(warnings), None, rolling)
    further = (*_of_mirror_image(result), *_of_yielding(result), *_of_rolling(result))
    return replace(result, warnings=(*warnings, *further))


def _of_mirror_image(result: SpatialResult) -> list[str]:
    """Say of a wheelset that stands beside the middle, though both sides are alike, where else it is in equilibrium.

    Its mirror image and the middle are equilibria by symmetry; whether it leaves the middle is computed beside it.
    """
    wheelset, lateral = result.wheelset, result.equilibrium.position.lateral_mm
    problem = wheelset.problem
    free = problem.position.lateral_mm is None and problem.position.roll_rad is None
    if not (result.status.converged and free and problem.is_symmetric and abs(lateral) > BESIDE_MM):
        return []
    near = 0.1 * lateral
    beside = solve_position(wheelset.at(problem.replaced(position={"lateral_mm": near})), {})
    force = math.copysign(1.0, lateral) * sum(float(beside.force_on_wheel_N(side)[0]) for side in SIDES)
    words = (
        f"the wheelset stands {abs(lateral):.2f} mm beside the middle of the track, though both sides are alike: "
        f"its mirror image, at {-lateral:.2f} mm, and the middle are equilibria as well"
    )
    if beside.status.converged:
        words += (
            f"; at {abs(near):.2f} mm from the middle, contact forces push it "
            f"{'outwards: it leaves the middle' if force > 0.0 else 'back: it stays in the middle if it starts there'} "
            f"by {abs(force):.3g} N"
        )
    return [words]


def _rolling(wheelset: SpatialWheelset, state: SpatialState, patches: list[SpatialPatch]) -> tuple[RollingPatch, ...]:
    """Patches with their creep forces."""
    rolled, rolled_patches = state.rolled, []
    if rolled is None:
        return ()
    for patch in patches:
        most = max(rolled.creep[patch.side].patches, key=lambda creep: int((creep.inside & patch.ellipse.inside).sum()))
        if (most.inside & patch.ellipse.inside).any():
            forces, contact = most.forces, most.contact
            if isinstance(forces, Rolling):
                forces = forces.part(
                    patch.ellipse.inside[rows_of(patch.state, contact), strips_of(patch.state, contact)]
                )
                contact = forces.contact
            rolled_patches.append(RollingPatch(patch, forces, contact, wheelset.problem.speed_m_s))
    return tuple(rolled_patches)


def _of_yielding(result: SpatialResult) -> list[str]:
    """Warnings on patches under which steel yields in each passage."""
    return [
        f"{patch.side} side, {patch.region}: p0/k = {result.load_factor(patch):.2f} is above the shakedown limits: "
        "steel yields in each passage, which is not modelled"
        for patch in result.patches
        if result.shakedown_state(patch) == ABOVE_SHAKEDOWN
    ]


def _of_rolling(result: SpatialResult) -> list[str]:
    """Warnings on creep forces."""
    warnings = []
    for rolled_patch in result.rolling:
        warnings += [
            f"{rolled_patch.patch.side} side, {rolled_patch.patch.region}: {notice}"
            for notice in rolled_patch.forces.notices
        ]
    for side in SIDES if result.rolling else ():
        ratio = result.lateral_over_vertical(side)
        if result.flange_touches(side) and ratio > (limit := result.nadal_limit(side)):
            warnings.append(
                f"{side} wheel: L/V of {ratio:.2f} above Nadal's limit of {limit:.2f}: its flange may climb"
            )
    return warnings
