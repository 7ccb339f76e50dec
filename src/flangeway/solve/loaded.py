"""Bodies under loads other than the contact forces."""

from collections.abc import Sequence

import scipy.sparse as sp

from flangeway.solve.body_response import BodyResponse, SurfaceNodes
from flangeway.types import Floats, Ints


class LoadedBodies(BodyResponse):
    """Placed bodies with displacements that are there before any contact force acts.

    The bodies are linear, so displacements by loads and by contact forces add: the contact meets surfaces that the
    loads have moved. The fields, displacements of each body under its loads and prescribed displacements without
    contact, in its own frame (n_dofs, 2), or None, are multiplied with `share`. Loads keep their direction in the
    bodies' frames.
    """

    def __init__(self, unloaded: BodyResponse, fields: Sequence[Floats | None], share: float = 1.0) -> None:
        super().__init__(
            [
                surface if field is None else _moved(surface, share * field)
                for surface, field in zip(unloaded.surfaces, fields, strict=True)
            ]
        )
        self._unloaded, self._fields, self._share = unloaded, tuple(fields), share

    @property
    def n_unknowns(self) -> int:
        """See `BodyResponse.n_unknowns`."""
        return self._unloaded.n_unknowns

    def displacements(self, rotations: Floats, touched: Ints, forces: Floats) -> Floats:
        """See `BodyResponse.displacements`; those by the loads are in the bodies' reference."""
        return self._unloaded.displacements(rotations, touched, forces)

    def respond(self, rotations: Floats, touched: Ints, geometric: sp.csr_array, loads: sp.csr_array) -> Floats:
        """See `BodyResponse.respond`."""
        return self._unloaded.respond(rotations, touched, geometric, loads)

    def fields(self, rotations: Floats, forces: Floats) -> list[Floats]:
        """See `BodyResponse.fields`; with the displacements by the loads."""
        return [
            found if field is None else found + self._share * field
            for found, field in zip(self._unloaded.fields(rotations, forces), self._fields, strict=True)
        ]


def _moved(surface: SurfaceNodes, field: Floats) -> SurfaceNodes:
    shifts = field[surface.nodes]
    return SurfaceNodes(surface.body, surface.nodes, shifts if surface.shifts is None else surface.shifts + shifts)
