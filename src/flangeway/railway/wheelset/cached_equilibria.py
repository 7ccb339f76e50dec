"""Equilibria that were found before: looked up by content, checked, and taken only if they still are in balance."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.railway.track.placements import WheelsetMotion
from flangeway.railway.wheelset.equilibrium import ACCEPTED, Equilibrium
from flangeway.railway.wheelset.residual import RelativeResiduals, residuals_of
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import BodyResponse, ContactState, Status, solve_contact
from flangeway.solve.condensed import body_key
from flangeway.system.disk_cache import Arrays, Cache, content_key
from flangeway.types import Floats

SAME = 1e-10
"""Difference of nodal forces over their largest up to which fields that are kept are theirs."""


@dataclass(frozen=True, eq=False)
class CachedEquilibria:
    """Equilibria of one model from some starts.

    Parameters
    ----------
    cache
        Where they are kept; None: nowhere.
    model, response
        The wheelset and its bodies.
    starts
        Where the searches start.

    """

    cache: Cache | None
    model: WheelsetModel
    response: BodyResponse
    starts: tuple[WheelsetMotion, ...]

    @property
    def key(self) -> str | None:
        """Key of all that determines them; None where that cannot be told."""
        model, problem = self.model, self.model.problem
        bodies = [body_key("equilibrium", part.body) for part in model.system.parts]
        if any(key is None for key in bodies):
            return None
        contacts = [
            (each.secondary.part.name, each.secondary.edges, each.primary.part.name, each.primary.edges,
             each.pairing, each.enforcement) for each in model.system.contacts
        ]  # fmt: skip
        wheelset = problem.wheelset
        return content_key(
            "equilibrium",
            bodies,
            [(part.name, part.placement) for part in model.system.parts],
            [surface.points for surface in model.system.surface_nodes],
            contacts,
            (wheelset.tape_radius_mm, wheelset.centre_of_gravity_height_mm, wheelset.back_to_back_mm),
            problem.load,
            problem.prescribed,
            problem.all_equilibria,
            self.starts,
        )

    def get(self, find: Callable[[], list[Equilibrium]]) -> list[Equilibrium]:
        """Equilibria that are kept and still in balance; else those that ``find`` finds, which are then kept."""
        key = self.key if self.cache is not None else None
        if self.cache is None or key is None:
            return find()
        arrays = self.cache.load(key)
        known = None if arrays is None else self._checked(arrays)
        if known is not None:
            return known
        found = find()
        if all(each.status.converged for each in found):
            self.cache.store(key, _packed(found))
        return found

    def fields(self, state: ContactState, find: Callable[[], list[Floats]]) -> list[Floats]:
        """Displacements of all bodies under the contact forces of a state, kept or found."""
        key = self.key if self.cache is not None else None
        if self.cache is None or key is None or not state.status.converged:
            return find()
        key = key.replace("equilibrium", "fields", 1)
        arrays = self.cache.load(key)
        if arrays is not None:
            kept = np.asarray(arrays["forces"], dtype=np.float64)
            size = float(np.abs(state.nodal_forces).max(initial=0.0))
            if kept.shape == state.nodal_forces.shape and np.abs(kept - state.nodal_forces).max() <= SAME * size:
                return [np.asarray(arrays[str(number)], dtype=np.float64) for number in range(len(arrays) - 1)]
        found = find()
        self.cache.store(key, {"forces": state.nodal_forces} | {str(i): each for i, each in enumerate(found)})
        return found

    def _checked(self, arrays: Arrays) -> list[Equilibrium] | None:
        found = [self._restored(arrays, number) for number in range(len(arrays["motions"]))]
        return None if any(each is None for each in found) else [each for each in found if each is not None]

    def _restored(self, arrays: Arrays, number: int) -> Equilibrium | None:
        """One of them, solved once more from where it was; None if that is not in balance."""
        if f"history_{number}" not in arrays:
            return None
        model, response = self.model, self.response
        motion = WheelsetMotion(*(float(each) for each in arrays["motions"][number]))
        placements = model.placements(motion)
        nodal = np.asarray(arrays[f"nodal_{number}"], dtype=np.float64)
        rotations, reference = response.rotations(placements), response.reference(placements)
        displacements = response.displacements(rotations, np.arange(response.n_nodes), nodal)
        lin = model.system.linearise(reference + displacements, None)
        keys = np.asarray(arrays[f"keys_{number}"])
        if not np.isin(keys, lin.keys).all():
            return None
        forces = np.zeros(len(lin.keys))
        forces[np.searchsorted(lin.keys, keys)] = arrays[f"forces_{number}"]
        before = ContactState(
            Status(True, "", 0), placements, displacements, reference + displacements, lin, forces, nodal
        )
        state = solve_contact(response, model.system, placements, start=before)
        _, balance = residuals_of(model, response, motion, state)
        if not state.status.converged or balance.equilibrium_residual > ACCEPTED:
            return None
        stable = int(arrays["stable"][number])
        status = Status(True, str(arrays["messages"][number]), int(arrays["iterations"][number]))
        errors = np.asarray(arrays[f"history_{number}"], dtype=np.float64).tolist()
        history = tuple(
            RelativeResiduals(vertical, lateral, moment, balance.free) for vertical, lateral, moment in errors
        )
        return Equilibrium(status, motion, balance, state, None if stable < 0 else bool(stable), history)


def _packed(found: Sequence[Equilibrium]) -> Arrays:
    arrays: dict[str, NDArray[Any]] = {
        "motions": np.array([each.motion.components for each in found]),
        "stable": np.array([-1 if each.stable is None else int(each.stable) for each in found]),
        "messages": np.array([each.status.message for each in found], dtype=np.str_),
        "iterations": np.array([each.status.iterations for each in found]),
    }
    for number, each in enumerate(found):
        loaded = each.state.forces > 0.0
        arrays[f"keys_{number}"] = each.state.linearisation.keys[loaded]
        arrays[f"forces_{number}"] = each.state.forces[loaded]
        arrays[f"nodal_{number}"] = each.state.nodal_forces
        arrays[f"history_{number}"] = np.array(
            [(past.vertical_residual, past.lateral_residual, past.moment_residual) for past in each.history]
        )
    return arrays
