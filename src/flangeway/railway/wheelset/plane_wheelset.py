"""A plane wheelset: bodies in contact of which the wheels share one handle, and its solution."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from flangeway.contact import ContactState, solve_contact
from flangeway.contact.solution_checks import BodyOverlap, body_overlaps
from flangeway.geometry import Placement
from flangeway.post import pressure_patches
from flangeway.railway.rigid.rigid_equilibrium import rigid_start
from flangeway.railway.track.placements import Side, WheelsetPosition, lateral_over_vertical
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.equilibrium import MAX_WAY, Equilibrium, with_loads
from flangeway.railway.wheelset.plane_patch import WheelRailPatch
from flangeway.railway.wheelset.wheelset_checks import checked
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, build_model
from flangeway.solve import BodyResponse, CondensedBodies, Handle, Status
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

# --- A plane wheelset: bodies in contact of which the wheels share one handle, the axle.
#
# The cuts of the wheels move with the axle, which slides and turns about its middle; the load acts at the centre of
# gravity, and the rails are held (Moherdaui 2021, 7.2.1). `solve_contact` finds forces and position together.


PlaneEquilibrium = Equilibrium[ContactState]


@dataclass(frozen=True, eq=False)
class PlaneWheelset:
    """Meshed and condensed bodies of a wheelset and its track, for any load and prescribed position.

    - `model`: the bodies and their contacts, and the problem that they were meshed for.
    - `response`: flexibilities of their surfaces.
    """

    model: WheelsetModel
    response: BodyResponse

    @classmethod
    def of(
        cls, model: WheelsetModel, progress: Callable[[str], None] = lambda _: None, cache: Cache | None = None
    ) -> "PlaneWheelset":
        """Condense the bodies of a model; `cache`: where flexibilities are kept; None: nowhere."""
        n_unknowns = sum(int(body.free.sum()) for body in model.bodies)
        progress(f"condensing {n_unknowns} unknowns to the surfaces")
        return cls(model, CondensedBodies(model.system.surface_nodes, cache))

    def at(self, problem: WheelsetProblem) -> "PlaneWheelset":
        """The same bodies under another load or at another prescribed position."""
        start = rigid_start(problem, self.model.rigid_start.geometry)
        return replace(self, model=replace(self.model, problem=problem, rigid_start=start))

    def equilibrium(self, before: PlaneEquilibrium | None = None) -> PlaneEquilibrium:
        """Find the position in which contact forces and load are in equilibrium, where it is not prescribed.

        Newton's method starts in the equilibrium of the rigid wheelset, or in the one before, of the same bodies under
        another load.
        """
        model = self.model
        prescribed = model.problem.position.components
        begin = model.rigid_position if before is None else before.position
        begin = WheelsetPosition(
            *(now if given is None else given for now, given in zip(begin.components, prescribed, strict=True))
        )
        placements, axle = model.placements(begin), self._axle(begin)
        handles = [axle if moves else None for moves in model.moving]
        motions = np.zeros(0 if axle is None else axle.n_motions)
        start = None if before is None else replace(before.state, motions=motions)
        state = solve_contact(self.response, model.system, placements, handles=handles, start=start)
        wheel = int(np.argmax(model.moving))
        position = self._moved(begin, state.placements[wheel].after(placements[wheel].inverse()))
        residual, relative = with_loads(model.problem, position, self._on_axle(position, state))
        status, n = state.status, state.status.iterations
        if status.converged and not state.nodal_forces.any():
            status = Status(False, "no wheel touches its rail; check what is prescribed and the profiles", n)
        elif status.converged and axle is None:
            status = Status(True, f"contact forces at the prescribed position in {n} iterations", n)
        elif status.converged and (np.abs(np.subtract(position.components, begin.components)) > MAX_WAY).any():
            status = Status(False, "the wheels left the rails; check what is prescribed, the load and the profiles", n)
        elif status.converged:
            error = relative.equilibrium_residual
            status = Status(True, f"contact forces and load are in equilibrium to {error:.1e} in {n} iterations", n)
        else:
            message = "no equilibrium: " + status.message + "; check that these profiles can carry the load"
            status = Status(False, message, n)
        stable = state.stable if status.converged and all(relative.free) else None
        return Equilibrium(status, position, relative, state, residual, stable)

    def _axle(self, position: WheelsetPosition) -> Handle | None:
        """The handle of both wheels at a position; None where all of it is prescribed."""
        model, problem = self.model, self.model.problem
        lateral, vertical, roll = (value is None for value in problem.position.components)
        if not (lateral or vertical or roll):
            return None
        along, onto = problem.forces.in_track
        wheels = tuple(part for part, moves in zip(model.system.parts, model.moving, strict=True) if moves)
        axle = np.array(position.axle(problem.wheels))
        centre_of_gravity = axle + problem.forces.centre_of_gravity(position.roll_rad)
        load = np.array([along, -onto, 0.0])
        return Handle(wheels, axle, np.eye(2)[[lateral, vertical]], roll, load, load_point=centre_of_gravity)

    def _moved(self, begin: WheelsetPosition, motion: Placement) -> WheelsetPosition:
        """Position of the wheelset after a motion in space from a position."""
        axle = np.array(begin.axle(self.model.problem.wheels))
        x, y = (motion.points([axle])[0] - axle).tolist()
        return begin.moved(WheelsetPosition(x, y, motion.rotation_rad))

    def _on_axle(self, position: WheelsetPosition, state: ContactState) -> Floats:
        """Contact forces on the wheels, and their moment about the axle's middle, axes of the track, shape (3,)."""
        forces = np.where(self.model.moving[self.response.body_of_node][:, None], state.nodal_forces, 0.0)
        arms = state.positions - position.axle(self.model.problem.wheels)
        moment = float(arms[:, 0] @ forces[:, 1] - arms[:, 1] @ forces[:, 0])
        return np.array([*forces.sum(axis=0), moment])


# --- Solve a wheelset on a track and gather what engineers ask for.


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
        return self.equilibrium.position.turned(self.model.problem.forces.tilt_rad)

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
        complete = all(overlap.is_explained for overlap in result.overlaps)
        complete = complete and not any(patch.at_edge for patch in result.patches)
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
    with _timed(timings, "post-processing"):
        progress("recovering the fields")
        rotations = wheelset.response.rotations(state.placements)
        fields = wheelset.response.fields(rotations, state.nodal_forces)
        overlaps = body_overlaps(model.system, wheelset.response, state, fields)
    names = [part.name for part in model.system.parts]
    displacements = dict(zip(names, fields, strict=True))
    patches = tuple(
        WheelRailPatch(**vars(patch), model=model, displacements=displacements)
        for patch in pressure_patches(model.system, state)
    )
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
