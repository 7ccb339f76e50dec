"""Solve a wheelset on a track and gather what engineers ask for."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from flangeway.contact.overlap import BodyOverlap, body_overlaps
from flangeway.geometry import Placement
from flangeway.post import pressure_patches
from flangeway.railway.track.placements import Side, WheelsetPosition, lateral_over_vertical
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.plane_wheelset import PlaneEquilibrium, PlaneWheelset
from flangeway.railway.wheelset.wheelset_checks import checked
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch, WheelsetModel, build_model, wheel_rail_patch
from flangeway.solve import Status
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class WheelsetResult:
    """A wheelset in equilibrium on its track.

    - `status`: how the computation ended.
    - `equilibrium`: position, residuals and contact forces.
    - `patches`: regions of contact, left side first.
    - `placements`: placement of each part, by name.
    - `displacements`: of all nodes of each part in its own frame, by name, each (n_dofs, 2).
    - `timings_s`: seconds for meshing, condensation (assembly and factorisation), contact, and post-processing.
    - `warnings`: sentences about the limits of the result.
    - `overlaps`: where deformed bodies overlap.
    """

    status: Status
    model: WheelsetModel
    equilibrium: PlaneEquilibrium
    patches: tuple[WheelRailPatch, ...]
    placements: dict[str, Placement]
    displacements: dict[str, Floats]
    timings_s: dict[str, float]
    warnings: tuple[str, ...]
    overlaps: tuple[BodyOverlap, ...]

    @property
    def problem(self) -> WheelsetProblem:
        """Wheelset, track and load."""
        return self.model.problem

    @property
    def approach_mm(self) -> float:
        """Vertical displacement of the axle's middle, down, from the rigid position to the equilibrium."""
        return self.model.rigid_position.vertical_mm - self.equilibrium.position.vertical_mm

    @property
    def position_in_space(self) -> WheelsetPosition:
        """The position along horizontal and vertical."""
        return self.equilibrium.position.turned(self.model.problem.load.tilt_rad)

    def force_on_wheel_N(self, side: Side) -> Floats:  # noqa: N802
        """Contact force on the wheel of a side, axes of the track, shape (2,)."""
        forces = [patch.force_on_wheel_N for patch in self.patches if patch.side == side]
        return np.sum(forces, axis=0) if forces else np.zeros(2)

    def lateral_over_vertical(self, side: Side) -> float:
        """Ratio L/V of a wheel's contact force, see `flangeway.railway.track.placements.lateral_over_vertical`."""
        return lateral_over_vertical(self.force_on_wheel_N(side), side)


def solve_wheelset(
    problem: WheelsetProblem, progress: Callable[[str], None] = lambda _: None, *, cold: bool = False
) -> WheelsetResult:
    """Mesh, condense, and find the wheelset's equilibrium.

    - `problem`: bodies, loads and what is prescribed.
    - `progress`: called with a sentence at each stage.
    - `cold`: compute everything anew, without the user's cache.
    """
    timings: dict[str, float] = {}
    cache = None if cold else Cache.of_user()
    for whole in (False, True):
        with _timed(timings, "meshing"):
            model = build_model(problem, progress, whole=whole, cache=cache)
        with _timed(timings, "condensation"):
            wheelset = PlaneWheelset.of(model, progress, cache)
        result = solve_condensed(wheelset, progress, timings)
        complete = all(each.is_explained for each in result.overlaps)
        complete = complete and not any(each.pressure.at_edge for each in result.patches)
        if whole or (result.equilibrium.status.converged and complete):
            break
        progress("once more with contact anywhere on the running surfaces")
    return result


def solve_condensed(
    wheelset: PlaneWheelset,
    progress: Callable[[str], None] = lambda _: None,
    timings: dict[str, float] | None = None,
) -> WheelsetResult:
    """Find the equilibrium of a wheelset whose bodies are condensed, and check it.

    - `progress`: called with a sentence at each stage.
    - `timings`: seconds of the stages before.
    """
    timings, model = {} if timings is None else timings, wheelset.model
    with _timed(timings, "contact"):
        progress("finding forces and position")
        equilibrium = wheelset.equilibrium()
        state = equilibrium.state
        patches = tuple(wheel_rail_patch(model, patch) for patch in pressure_patches(model.system, state))
    with _timed(timings, "post-processing"):
        progress("recovering the fields")
        rotations = wheelset.response.rotations(state.placements)
        fields = wheelset.response.fields(rotations, state.nodal_forces)
        overlaps = body_overlaps(model.system, wheelset.response, state, fields)
    names = [part.name for part in model.system.parts]
    displacements = dict(zip(names, fields, strict=True))
    status, warnings = checked(model, equilibrium, patches, overlaps, displacements)
    placements = dict(zip(names, state.placements, strict=True))
    return WheelsetResult(
        status, model, equilibrium, patches, placements, displacements, timings, warnings, tuple(overlaps)
    )


@contextmanager
def _timed(timings: dict[str, float], stage: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    timings[stage] = timings.get(stage, 0.0) + time.perf_counter() - start
