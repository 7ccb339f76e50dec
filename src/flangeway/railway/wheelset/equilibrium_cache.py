"""Equilibria of earlier runs in the user's cache: found by content, solved once more, and used if in equilibrium."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.railway.track.placements import WheelsetPosition
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.plane_contact import PlaneContact
from flangeway.railway.wheelset.residual import TOLERANCE
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import BodyResponse, ContactState, Status, solve_contact
from flangeway.system.disk_cache import Arrays, Cache, content_key
from flangeway.types import Floats

SAME_FORCES = 1e-10  # difference of nodal forces over their maximum up to which stored fields are theirs


@dataclass(frozen=True)
class EquilibriumCache:
    """Stored equilibria of one model from some starts.

    - `cache`: the user's cache, or None.
    - `starts`: positions from which the searches start.
    """

    cache: Cache | None
    model: WheelsetModel
    response: BodyResponse
    starts: tuple[WheelsetPosition, ...]

    @cached_property
    def _key(self) -> str | None:
        """Key of all that determines them; None without a cache, or where there is no such key."""
        model, problem = self.model, self.model.problem
        bodies = [content_key("equilibrium", *part.body.content) for part in model.system.parts]
        if self.cache is None or any(key is None for key in bodies):
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

    def load(self) -> list[Equilibrium[ContactState]] | None:
        """Stored equilibria, if all of them still are."""
        arrays = None if self.cache is None or self._key is None else self.cache.load(self._key)
        if arrays is None:
            return None
        found = [self._restored(arrays, number) for number in range(len(arrays["positions"]))]
        return None if any(each is None for each in found) else [each for each in found if each is not None]

    def store(self, found: Sequence[Equilibrium[ContactState]]) -> None:
        """Keep equilibria that converged."""
        if self.cache is not None and self._key is not None and all(each.status.converged for each in found):
            self.cache.store(self._key, _packed(found))

    def fields(self, state: ContactState) -> list[Floats]:
        """Displacements of all bodies under the contact forces of a state, stored or solved for."""
        key = self._key if state.status.converged else None
        key = None if key is None else key.replace("equilibrium", "fields", 1)
        arrays = None if self.cache is None or key is None else self.cache.load(key)
        if arrays is not None:
            forces = np.asarray(arrays["forces"], dtype=np.float64)
            size = float(np.abs(state.nodal_forces).max(initial=0.0))
            if forces.shape == state.nodal_forces.shape and np.abs(forces - state.nodal_forces).max() <= (
                SAME_FORCES * size
            ):
                return [np.asarray(arrays[str(number)], dtype=np.float64) for number in range(len(arrays) - 1)]
        found = self.response.fields(self.response.rotations(state.placements), state.nodal_forces)
        if self.cache is not None and key is not None:
            self.cache.store(key, {"forces": state.nodal_forces} | {str(i): each for i, each in enumerate(found)})
        return found

    def _restored(self, arrays: Arrays, number: int) -> Equilibrium[ContactState] | None:
        """One of them, solved once more from where it was; None if that is no equilibrium."""
        if f"history_{number}" not in arrays:
            return None
        model, response = self.model, self.response
        position = WheelsetPosition(*(float(each) for each in arrays["positions"][number]))
        placements = model.placements(position)
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
        residual, residuals = PlaneContact(model, response).residuals_of(position, state)
        if not state.status.converged or residuals.equilibrium_residual > TOLERANCE:
            return None
        stable = int(arrays["stable"][number])
        status = Status(True, str(arrays["messages"][number]), int(arrays["iterations"][number]))
        history = tuple(
            replace(residuals, vertical_residual=vertical, lateral_residual=lateral, moment_residual=moment)
            for vertical, lateral, moment in arrays[f"history_{number}"].tolist()
        )
        return Equilibrium(status, position, residuals, state, residual, None if stable < 0 else bool(stable), history)


def _packed(found: Sequence[Equilibrium[ContactState]]) -> Arrays:
    arrays: dict[str, NDArray[Any]] = {
        "positions": np.array([each.position.components for each in found]),
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
