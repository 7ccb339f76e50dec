"""A wheelset whose bodies are condensed once and for all its positions."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.contact.overlap import body_overlaps
from flangeway.railway.positions.running_pair import RunningPair
from flangeway.railway.positions.surface_positions import SidePose
from flangeway.railway.track.placements import SIDES, WheelsetPosition, mirrored
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import Equilibrium, search_equilibrium
from flangeway.railway.wheelset.plane_contact import PlaneContact
from flangeway.railway.wheelset.wheelset_checks import overlap_error
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, build_model
from flangeway.solve import CondensedBodies, ContactState, Status
from flangeway.system.disk_cache import Cache


@dataclass(frozen=True, eq=False)
class PreparedWheelset:
    """Whole running surfaces and heads, meshed and condensed: each further position needs only its contact.

    - `response`: flexibilities of its surfaces.
    """

    model: WheelsetModel
    response: CondensedBodies

    def solve(
        self,
        load: WheelsetLoad | None = None,
        prescribed: Prescribed | None = None,
        start: WheelsetPosition | None = None,
    ) -> Equilibrium[ContactState]:
        """Find one position by the full search.

        - `load`, `prescribed`: what differs from the problem that was prepared.
        - `start`: a rigid equilibrium; that of the prepared problem if left out. That is the second try if nothing is
          found from the first: rigid flanges climb where elastic rails deflect.
        """
        changed = replace(self.model, problem=self.problem_with(load, prescribed))
        found = self._without_overlap(search_equilibrium(PlaneContact(changed, self.response), start=start))
        if start is None or found.status.converged:
            return found
        second = self._without_overlap(search_equilibrium(PlaneContact(changed, self.response)))
        return second if second.status.converged else found

    def _without_overlap(self, found: Equilibrium[ContactState]) -> Equilibrium[ContactState]:
        """Return an equilibrium; it is not converged where the bodies overlap, anywhere."""
        overlaps = body_overlaps(self.model.system, self.response, found.state) if found.status.converged else ()
        errors = [overlap_error(each) for each in overlaps if not each.is_explained]
        status = Status(False, "; ".join(errors), found.status.iterations) if errors else found.status
        return replace(found, status=status)

    def problem_with(self, load: WheelsetLoad | None, prescribed: Prescribed | None) -> WheelsetProblem:
        """Return the problem that was prepared, with another load and prescribed position."""
        problem = self.model.problem
        return replace(problem, load=load or problem.load, prescribed=prescribed or problem.prescribed)

    @cached_property
    def poses(self) -> tuple[SidePose, ...]:
        """Both sides in the form for many positions. An `InputError`: see `RunningPair.of`."""
        track, wheelset = self.model.problem.track, self.model.problem.wheelset
        pairs: dict[tuple[int, int], RunningPair] = {}
        poses = []
        for side in SIDES:
            key = id(self.model.parts[f"wheel-{side}"].body), id(self.model.parts[f"rail-{side}"].body)
            if key not in pairs:
                pairs[key] = RunningPair.of(self.model.system, self.model.contact(side), self.response)
            placements = [track.placement(side), wheelset.placement(side)]
            rail, wheel = placements if side == "right" else [mirrored(each) for each in placements]
            poses.append(
                SidePose(
                    side,
                    pairs[key],
                    rail.rotation_rad,
                    np.array(rail.translation),
                    wheel.rotation_rad,
                    np.array(wheel.translation),
                    wheelset.tape_radius_mm,
                )
            )
        return tuple(poses)


def prepare(
    problem: WheelsetProblem, progress: Callable[[str], None] = lambda _: None, cache: Cache | None = None
) -> PreparedWheelset:
    """Mesh and condense a wheelset for many positions.

    An `InputError` as `build_model`.

    - `problem`: the wheelset; its load and what it prescribes are those of one of the positions.
    - `progress`: called with a sentence at each stage.
    - `cache`: where meshes and flexibilities are kept, as ``Cache.of_user()``; None: nowhere.
    """
    model = build_model(problem, progress, whole=True, cache=cache)
    progress("condensing the bodies to their whole running surfaces")
    return PreparedWheelset(model, CondensedBodies(model.system.surface_nodes, cache))
