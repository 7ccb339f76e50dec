"""What engineers ask for of a wheelset in three dimensions: its patches, and the stresses below them."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact.rolling.creep_state import CreepState
from flangeway.contact.rolling.rolling_contact import Rolling
from flangeway.errors import InputError
from flangeway.exact.shakedown import ABOVE_SHAKEDOWN
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
from flangeway.railway.track.wheelset_problem import ROLES, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.rolling.patch_rolling import rows_of, strips_of
from flangeway.railway.wheelset.rolling.wheelset_creep import SideCreep
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.side_contact import SideState, tangents_of
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.supported_rail import LoadedRail, RailAlongTrack, rails_along_track, supported_rail
from flangeway.railway.wheelset.wheel_patch import WheelPatch
from flangeway.railway.wheelset.wheelset_checks import yield_strength
from flangeway.railway.wheelset.wheelset_newton import RollingPlace, SpatialState
from flangeway.results import Shown
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
class SpatialResult(Shown):
    """A wheelset in equilibrium on its track, in three dimensions.

    - `equilibrium`: position, residuals and contact of both sides.
    - `patches`: left side first, each side by falling force.
    - `timings_s`: seconds of the stages.
    - `warnings`: what limits the result.
    - `cache`: where solutions of the sections are kept from one process to the next.
    """

    status: Status
    wheelset: SpatialWheelset
    equilibrium: Equilibrium[SpatialState]
    patches: tuple[WheelPatch, ...]
    timings_s: dict[str, float]
    warnings: tuple[str, ...]
    cache: Cache | None = None

    @property
    def problem(self) -> WheelsetProblem:
        """Wheelset, track and load."""
        return self.wheelset.problem

    @property
    def yield_MPa(self) -> float | None:  # noqa: N802
        """See `yield_strength`."""
        return yield_strength(self.problem, *ROLES)

    @property
    def rolling(self) -> list[tuple[WheelPatch, CreepState]]:
        """Patches and their creep forces, empty without friction."""
        return [(patch, patch.creep) for patch in self.patches if patch.creep is not None]

    @property
    def approach_mm(self) -> float:
        """Vertical displacement of the axle's middle, down, from the rigid position to the equilibrium."""
        return self.wheelset.start.motion.vertical_mm - self.equilibrium.position.vertical_mm

    @cached_property
    def lateral_uncertainty_mm(self) -> float | None:
        """Uncertainty of a lateral position that is sought with friction, by the size of the cells; None otherwise.

        See `flangeway.railway.wheelset.spatial_wheelset.SpatialWheelset.lateral_uncertainty`.
        """
        is_sought = self.problem.position.lateral_mm is None and self.equilibrium.state.rolled is not None
        return self.wheelset.lateral_uncertainty(self.equilibrium) if is_sought and self.status.converged else None

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
        """Wavelength of the rigid wheelset's kinematic motion (Klingel, 1883).

        None if its conicity is not positive, or its wheels are independent.
        For the equivalent conicity (EN 15302) at an amplitude of 3 mm.
        """
        geometry, problem = self.wheelset.geometry, self.problem
        lateral = np.linspace(-2.0, 2.0, 401) * KLINGEL_MM
        try:
            conicity = float(equivalent_conicity(RollingRadiusDifference.of(geometry.locus(lateral)), KLINGEL_MM)[0])
        except InputError:
            return None
        if not conicity > 0.0 or problem.wheelset.wheels == "independent":
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
    start: SpatialResult | None = None,
) -> SpatialResult:
    """Find a wheelset's equilibrium in three dimensions, and its patches.

    - `cold`: compute everything anew, without the user's cache.
    - `start`: result under a similar load, from whose place the search begins.
    """
    timings: dict[str, float] = {}
    begun, cache = time.perf_counter(), None if cold else Cache.of_user()
    rigid = SpatialWheelset(problem, {})
    _ = rigid.start  # what rigid wheels cannot do is refused before the bodies are meshed
    surfaces = running_surfaces(problem, cache=cache, progress=progress)
    timings["compliance"] = time.perf_counter() - begun
    near = None if start is None else RollingPlace.of(start.equilibrium)
    return replace(solve_position(replace(rigid, surfaces=surfaces), timings, progress, near), cache=cache)


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
    patches = _patches(wheelset, equilibrium.state) if equilibrium.status.converged else ()
    timings["contact"] = time.perf_counter() - begun
    status = _status_on_rails(wheelset, equilibrium, touches=bool(patches))
    warnings = equilibrium.warnings(equilibrium.status, {patch.side for patch in patches})
    warnings += [
        f"{patch.side} side, {patch.region}: {patch.remark} on a narrow patch, its maximum pressure is rough"
        for patch in patches
        if patch.remark
    ]
    warnings += [
        f"{patch.side} side, {patch.region}: the patch is no ellipse; its semi-axes are those of its second moments"
        for patch in patches
        if patch.area < NO_ELLIPSE * np.pi * np.prod(patch.semi_axes)
    ]
    result = SpatialResult(status, wheelset, equilibrium, patches, timings, tuple(warnings))
    further = (*_of_mirror_image(result), *_of_yielding(result), *_of_rolling(result))
    return replace(result, warnings=(*warnings, *further))


def _status_on_rails(wheelset: SpatialWheelset, equilibrium: Equilibrium[SpatialState], *, touches: bool) -> Status:
    """Status of a search that is not converged where wheels are on a flange or below the rails, or cannot stand at all.

    - `touches`: whether it found a patch.
    """
    status, lateral = equilibrium.status, wheelset.problem.position.lateral_mm
    rise, reached = wheelset.rise(equilibrium.position), wheelset.start.motion.lateral_mm
    if rise > CLIMBED_MM and (status.converged or lateral is not None):
        reason = f"derailed, at {equilibrium.position.lateral_mm:.1f} mm the axle is {rise:.1f} mm higher than in the "
        reason += "middle of the track, a flange on its rail"
    elif rise < 0.0 and not touches and status.converged:
        reason = f"nothing touches, though the axle is {-rise:.3g} mm lower than on rigid rails: it lies below them"
    # where rigid wheels stand at the lateral position, what is not balanced says more
    elif lateral is not None and abs(lateral - reached) > RIGID_MM and not status.converged:
        reason = "no equilibrium; rigid wheels derail there, or stand on the end of a running surface"
    else:
        return status
    advice = "check what is prescribed and the load"
    if lateral is not None:
        reason = f"lateral_mm = {lateral:g}: {reason}"
        advice = f"rigid wheels stand up to {reached:.1f} mm, give a smaller lateral_mm"
    return Status(False, f"{reason}; {advice}", status.iterations)


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


def _patches(wheelset: SpatialWheelset, state: SpatialState) -> tuple[WheelPatch, ...]:
    """Patches of both sides, left side first, each side by falling force, with their creep forces."""
    strength, patches = yield_strength(wheelset.problem, *ROLES), list[WheelPatch]()
    for side in SIDES:
        side_state = state.sides[side]
        of_side = [
            WheelPatch(patch.cells, patch.inside, side, side_state, yield_MPa=strength)
            for patch in side_state.cells.patches(state.interiors(side))
        ]
        if state.rolled is not None:
            of_side = _with_creep(of_side, state.rolled.creep[side], wheelset.problem.speed_m_s)
        patches += of_side
    return tuple(patches)


def _with_creep(patches: Sequence[WheelPatch], creep: SideCreep, speed_m_s: float) -> list[WheelPatch]:
    """Patches of a side with their creep forces, and the tractions of all of them."""
    states, tractions = list[CreepState | None](), None
    for patch in patches:
        state = None
        most = max(creep.patches, key=lambda of_patch: int((of_patch.inside & patch.inside).sum()))
        if (most.inside & patch.inside).any():
            forces, contact = most.forces, most.contact
            if isinstance(forces, Rolling):
                forces = forces.part(patch.inside[rows_of(patch.state, contact), strips_of(patch.state, contact)])
                contact = forces.contact
            state = CreepState(forces, contact, -SIDE_SIGN[patch.side], speed_m_s)
            if state.cells is not None:
                on_side = patch.on_side(state, state.cells.tractions)
                tractions = on_side if tractions is None else tractions + on_side
        states.append(state)
    return [replace(patch, creep=state, tractions=tractions) for patch, state in zip(patches, states, strict=True)]


def _of_yielding(result: SpatialResult) -> list[str]:
    """Warnings on patches under which steel yields in each passage."""
    return [
        f"{patch.side} side, {patch.region}: p0/k = {patch.load_factor:.2f} is above the shakedown limits: "
        "steel yields in each passage, which is not modelled"
        for patch in result.patches
        if patch.shakedown_state == ABOVE_SHAKEDOWN
    ]


def _of_rolling(result: SpatialResult) -> list[str]:
    """Warnings on creep forces."""
    warnings = [
        f"{patch.side} side, {patch.region}: {notice}"
        for patch, creep in result.rolling
        for notice in creep.forces.notices
    ]
    for side in SIDES if result.rolling else ():
        ratio = result.lateral_over_vertical(side)
        if result.flange_touches(side) and ratio > (limit := result.nadal_limit(side)):
            warnings.append(
                f"{side} wheel: L/V of {ratio:.2f} above Nadal's limit of {limit:.2f}: its flange may climb"
            )
    return warnings
