"""Solve a wheelset on a track and gather what engineers ask for."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np

from flangeway.exact import LineContact
from flangeway.geometry import Placement
from flangeway.post import PressurePatch, pressure_patches
from flangeway.railway.track.placements import Side, WheelsetMotion
from flangeway.railway.wheelset.cached_equilibria import CachedEquilibria
from flangeway.railway.wheelset.equilibrium import Equilibrium, find_equilibrium
from flangeway.railway.wheelset.missed_overlap import missed_contact
from flangeway.railway.wheelset.wheelset_checks import checked
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, WheelsetProblem, build_model
from flangeway.solve import CondensedBodies, Status
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

SAME_MM = 1e-3
"""Distance of two balances, in mm and rad, below which they are one."""

GAUGE_SIDE = np.tan(np.deg2rad(15.0))
"""Slope of the contact from which it is named after the gauge corner."""


@dataclass(frozen=True, eq=False)
class WheelRailPatch:
    """One region of contact between a wheel and a rail.

    Parameters
    ----------
    side
        Side of the track.
    pressure
        Nodes, forces and pressures in space; forces are those on the secondary side.
    force_on_wheel_N
        Resultant on the wheel, axes of the track, shape (2,).
    wheel_point_mm, rail_point_mm
        Centre of pressure on the undeformed profiles, in their frames (both sides in the right-hand form).
    hertz
        Hertz's contact with the same force and the profiles' curvatures at the centre, None where these have none.

    """

    side: Side
    pressure: PressurePatch
    force_on_wheel_N: Floats  # noqa: N815 (the unit newton)
    wheel_point_mm: Floats
    rail_point_mm: Floats
    hertz: LineContact | None

    @property
    def region(self) -> str:
        """Part of the rail that is touched: ``crown``, ``gauge corner`` or ``field corner``."""
        lateral, vertical = self.force_on_wheel_N
        return region_of(self.side, float(lateral), float(vertical))


def region_of(side: Side, lateral: float, vertical: float) -> str:
    """Part of the rail that is touched by the force on a wheel in the track's axes; see `WheelRailPatch.region`."""
    inward = -lateral if side == "right" else lateral
    if abs(inward) < GAUGE_SIDE * vertical:
        return "crown"
    return "gauge corner" if inward > 0.0 else "field corner"


@dataclass(frozen=True, eq=False)
class WheelsetResult:
    """A wheelset in balance on its track.

    Parameters
    ----------
    status
        How the computation ended.
    model
        Meshed parts.
    equilibrium
        Position, balance and contact forces.
    patches
        Regions of contact, left side first.
    placements
        Where each part stands, by name.
    displacements
        Of all nodes of each part in its own frame, by name, each (n_dofs, 2).
    timings_s
        Seconds for meshing, condensation (assembly and factorisation), contact, and post-processing.
    warnings
        Sentences about what limits the result.
    others
        Further balances, if more than one was found.

    """

    status: Status
    model: WheelsetModel
    equilibrium: Equilibrium
    patches: tuple[WheelRailPatch, ...]
    placements: dict[str, Placement]
    displacements: dict[str, Floats]
    timings_s: dict[str, float]
    warnings: tuple[str, ...]
    others: tuple[Equilibrium, ...] = ()

    @property
    def approach_mm(self) -> float:
        """How far the axle's middle sinks from the place where the rigid wheelset first touches or rests to balance."""
        return self.model.start_motion.vertical_mm - self.equilibrium.motion.vertical_mm

    @property
    def motion_in_space(self) -> WheelsetMotion:
        """The motion along horizontal and vertical."""
        motion = self.equilibrium.motion
        lateral, vertical = self.model.problem.load.to_space(motion.lateral_mm, motion.vertical_mm)
        return WheelsetMotion(lateral, vertical, motion.roll_rad)

    def force_on_wheel_N(self, side: Side) -> Floats:  # noqa: N802
        """Contact force on the wheel of a side, axes of the track, shape (2,)."""
        forces = [patch.force_on_wheel_N for patch in self.patches if patch.side == side]
        return np.sum(forces, axis=0) if forces else np.zeros(2)

    def lateral_over_vertical(self, side: Side) -> float:
        """Ratio L/V of a wheel's contact force, positive where it pushes the rail outwards; nan without contact."""
        lateral, vertical = self.force_on_wheel_N(side)
        if not vertical > 0.0:
            return float("nan")
        return float(lateral / vertical) * (-1.0 if side == "right" else 1.0)


def solve_wheelset(
    problem: WheelsetProblem, progress: Callable[[str], None] = lambda _: None, *, cold: bool = False
) -> WheelsetResult:
    """Mesh, condense, and bring the wheelset into balance.

    Parameters
    ----------
    problem
        What stands where.
    progress
        Called with a sentence at each stage.
    cold
        Compute everything anew, without what earlier runs left in the user's cache.

    """
    timings: dict[str, float] = {}
    cache = None if cold else Cache.of_user()
    for whole in (False, True):
        with _timed(timings, "meshing"):
            model = build_model(problem, progress, whole=whole, cache=cache)
        n_unknowns = sum(int(body.free.sum()) for body in model.bodies)
        with _timed(timings, "condensation"):
            progress(f"condensing {n_unknowns} unknowns to the surfaces")
            response = CondensedBodies(model.system.surface_nodes, cache)
        with _timed(timings, "contact"):
            starts = model.rigid_start.starts if whole else (model.start_motion,)
            known = CachedEquilibria(cache, model, response, starts)
            equilibrium, *others = known.get(partial(_equilibria, model, response, progress, starts))
            state = equilibrium.state
            patches = tuple(wheel_rail_patch(model, patch) for patch in pressure_patches(model.system, state))
            missed = missed_contact(model, response, state)
        is_whole = not missed and not any(patch.pressure.at_edge for patch in patches)
        if equilibrium.status.converged and equilibrium.stable is not False and is_whole and not problem.all_equilibria:
            break
        if not whole:
            progress("once more with contact anywhere on the running surfaces")
    with _timed(timings, "post-processing"):
        progress("recovering the fields")
        turned = response.rotations(state.placements)
        fields = known.fields(state, partial(response.fields, turned, state.nodal_forces))
    names = [part.name for part in model.system.parts]
    displacements = dict(zip(names, fields, strict=True))
    status, warnings = checked(model, equilibrium, patches, missed, displacements)
    return WheelsetResult(
        status,
        model,
        equilibrium,
        patches,
        dict(zip(names, state.placements, strict=True)),
        displacements,
        timings,
        warnings,
        tuple(others),
    )


def _equilibria(
    model: WheelsetModel,
    response: CondensedBodies,
    progress: Callable[[str], None],
    starts: tuple[WheelsetMotion, ...],
) -> list[Equilibrium]:
    """Balances from some starts, those that are stable first."""
    found: list[Equilibrium] = []
    for start in starts:
        new = find_equilibrium(model, response, progress, start)
        if not any(_is_same(new, other) for other in found):
            found.append(new)
        if new.status.converged and new.stable is not False and not model.problem.all_equilibria:
            break
    found.sort(key=lambda each: (not each.status.converged, each.stable is False))
    return [found[0], *(each for each in found[1:] if each.status.converged)]


def _is_same(one: Equilibrium, other: Equilibrium) -> bool:
    if not (one.status.converged and other.status.converged):
        return False
    return bool(np.allclose(one.motion.components, other.motion.components, rtol=0.0, atol=SAME_MM))


@contextmanager
def _timed(timings: dict[str, float], stage: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    timings[stage] = timings.get(stage, 0.0) + time.perf_counter() - start


def wheel_rail_patch(model: WheelsetModel, patch: PressurePatch) -> WheelRailPatch:
    """Return a region of contact of the model's system as one of a wheel and a rail."""
    contact = model.system.contacts[patch.contact]
    side: Side = "left" if patch.contact == 0 else "right"
    wheel_is_secondary = contact.secondary.part.name.startswith("wheel")
    on_wheel, on_rail = patch.secondary_point, patch.primary_point
    if not wheel_is_secondary:
        on_wheel, on_rail = on_rail, on_wheel
    hertz = model.hertz_at(side, on_wheel, on_rail, float(patch.normal_forces.sum()))
    return WheelRailPatch(side, patch, patch.force if wheel_is_secondary else -patch.force, on_wheel, on_rail, hertz)
