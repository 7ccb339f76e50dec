"""Parts of running surfaces that are meshed finely and can be in contact."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError
from flangeway.geometry import Contour
from flangeway.mesh import PolyMesh
from flangeway.types import Floats


@dataclass(frozen=True)
class Zone:
    """A stretch of a curve about some places.

    Parameters
    ----------
    places
        Points on or near the curve in its frame, at least one.
    reach
        Length of the stretch beyond the first and the last of them, along the curve; infinite: all of it.

    """

    places: tuple[tuple[float, float], ...]
    reach: float

    def points(self, curve: Contour) -> Floats:
        """Points of the curve inside of the zone, shape (n, 2)."""
        points = curve.sampled(spacing=0.25)
        return points[self._inside(points)]

    def edges(self, mesh: PolyMesh, names: tuple[str, ...], body: str) -> NDArray[np.int32]:
        """Edges of a mesh inside of the zone, along the named edge sets, shape (n, 2)."""
        chain = mesh.chain(*names)
        inside = np.flatnonzero(self._inside(mesh.points[chain]))
        if len(inside) < 3:
            raise InputError(
                f"a mesh with {max(len(inside) - 1, 0)} edges in the contact zone of the {body}",
                "at least two",
                "lower size_scale or contact_size_mm",
            )
        nodes = chain[inside[0] : inside[-1] + 1]
        return np.stack((nodes[:-1], nodes[1:]), axis=1).astype(np.int32)

    def _inside(self, points: Floats) -> NDArray[np.bool_]:
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        along = np.concatenate(([0.0], np.cumsum(steps)))
        at = [along[np.argmin(np.linalg.norm(points - place, axis=1))] for place in self.places]
        inside: NDArray[np.bool_] = (along >= min(at) - self.reach) & (along <= max(at) + self.reach)
        return inside
