"""A plane wheelset: bodies in contact of which the wheels share one handle, the axle.

The cuts of the wheels move with the axle, which slides and turns about its middle; the load acts at the centre of
gravity, and the rails are held (Moherdaui 2021, 7.2.1). `solve_contact` finds forces and position together.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flangeway.contact import ContactState, solve_contact
from flangeway.geometry import Placement
from flangeway.railway.rigid.elastic_start import rigid_start
from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.equilibrium import MAX_WAY, Equilibrium, with_loads
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import BodyResponse, CondensedBodies, Handle, Status
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

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
        prescribed = model.problem.prescribed.components
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
        lateral, vertical, roll = (value is None for value in problem.prescribed.components)
        if not (lateral or vertical or roll):
            return None
        along, onto = problem.load.in_track
        wheels = tuple(part for part, moves in zip(model.system.parts, model.moving, strict=True) if moves)
        axle, centre_of_gravity = position.axle(problem.wheelset), position.centre_of_gravity(problem.wheelset)
        load = np.array([along, -onto, 0.0])
        return Handle(
            wheels, np.array(axle), np.eye(2)[[lateral, vertical]], roll, load, load_point=np.array(centre_of_gravity)
        )

    def _moved(self, begin: WheelsetPosition, motion: Placement) -> WheelsetPosition:
        """Position of the wheelset after a motion in space from a position."""
        axle = np.array(begin.axle(self.model.problem.wheelset))
        x, y = (motion.points([axle])[0] - axle).tolist()
        return begin.moved(WheelsetPosition(x, y, motion.rotation_rad))

    def _on_axle(self, position: WheelsetPosition, state: ContactState) -> Floats:
        """Contact forces on the wheels, and their moment about the axle's middle, axes of the track, shape (3,)."""
        forces = np.where(self.model.moving[self.response.body_of_node][:, None], state.nodal_forces, 0.0)
        arms = state.positions - position.axle(self.model.problem.wheelset)
        moment = float(arms[:, 0] @ forces[:, 1] - arms[:, 1] @ forces[:, 0])
        return np.array([*forces.sum(axis=0), moment])
