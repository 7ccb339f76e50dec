"""Compliance of a running surface on any grid: that of a half-space, and what the body adds to it.

Near a load every body moves as a half-space, in closed form. What it moves more, by its curvature, its width and its
supports, is smooth. It is tabulated once on cells of some millimetres over the whole surface, and interpolated to the
fine grid of a contact patch wherever that is.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.solve import SurfaceCells, compliance_table
from flangeway.solve.half_spaces import half_spaces_on
from flangeway.system.disk_cache import Arrays, Cache, cached
from flangeway.types import Floats, Ints

LEAST_WAVENUMBER = 2e-5
"""Per mm: a wave of 300 m, beyond which bodies that are held or on a foundation no longer change, along z either."""
CORRECTED = 1.0
"""Distance up to which the table's own nearest cells are corrected, over a cell."""
N_DISTANCES = 40
"""Distances along z at which the remainder is tabulated, the last of them `REACH` away."""
REACH = 160.0
"""Longest distance along z over a cell; beyond, the remainder hardly changes within a patch."""


@dataclass(frozen=True, eq=False)
class ElasticSurface:
    """A surface of a prism, and what it moves more than a half-space does.

    Parameters
    ----------
    material
        Isotropic material.
    stations
        Lengths along the surface, rising, body on the left, shape (n,).
    points, frames
        Points of the surface there, shape (n, 2), and its axes tangent, outward normal and z, rows of (n, 3, 3).
    distances
        Distances along z, from 0, shape (n_z,).
    remainder
        Displacements less those of a half-space, by unit forces, in the axes x, y, z of the section, by distance,
        displacement and force: shape (n_z, n, 3, n, 3). The displaced point is ahead of the force along z.

    """

    material: Elastic
    stations: Floats
    points: Floats
    frames: Floats
    distances: Floats
    remainder: Floats

    def plus(self, added: Floats) -> "ElasticSurface":
        """The same with a compliance added that hardly changes along z, in the frames of the stations, (n, 3, n, 3)."""
        turned_back = np.einsum("iax,iajb,jby->ixjy", self.frames, added, self.frames, optimize=True)
        return replace(self, remainder=self.remainder + turned_back)

    @cached_property
    def by_axes(self) -> Floats:
        """`remainder` on the m B-splines of `interpolation`, shape (3, 3, n_z, m, m).

        By axes of displacement and force, distance, splines of displacement and force. At a place four splines are not
        zero; values at the stations would all have a weight.
        """
        to_splines = make_interp_spline(self.stations, np.eye(len(self.stations)), bc_type="natural").c
        # T_xyzkl = sum over stations i, j of S_ki R_zixjy S_lj
        return np.ascontiguousarray(to_splines @ self.remainder.transpose(2, 4, 0, 1, 3) @ to_splines.T)

    @cached_property
    def in_section(self) -> Floats:
        """The same in the plane of the force, by spline and axis: (3 m, 3 m)."""
        table = self.by_axes[:, :, 0]
        return table.transpose(2, 0, 3, 1).reshape(3 * table.shape[2], -1)

    def interpolation(self, at: Floats, derivative: int = 0) -> Floats:
        """Weights of the cubic B-splines at places along the surface, or of their derivatives, shape (m, n + 2).

        Beyond the first and the last tabulated station those there.
        """
        return np.asarray(self._splines(np.clip(at, self.stations[0], self.stations[-1]), derivative))

    @cached_property
    def _splines(self) -> BSpline:
        knots = np.pad(self.stations, 3, mode="edge")
        return BSpline(knots, np.eye(len(self.stations) + 2), 3)

    @cached_property
    def _along(self) -> CubicSpline:
        # even in z: no slope at 0
        return CubicSpline(
            self.distances,
            np.eye(len(self.distances)),
            bc_type=((1, np.zeros(len(self.distances))), (2, np.zeros(len(self.distances)))),
        )

    def along(self, distances: Floats) -> Floats:
        """Weights of the tabulated distances along z at other ones, shape (m, n_z)."""
        return self._along(np.minimum(distances, self.distances[-1]))


def elastic_surface(
    cells: SurfaceCells,
    *,
    tolerance: float = 1e-3,
    cache: Cache | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> ElasticSurface:
    """Tabulate what a prism's surface moves more than a half-space.

    Parameters
    ----------
    cells
        Even cells on the surface of a prism, isotropic below it.
    tolerance
        See `flangeway.solve.compliance_table`.
    cache
        Where the compliances are kept from one process to the next.
    progress
        Called with a sentence at each stage.

    """
    body = cells.problem.elasticity.name
    if cells.material is None:
        raise InputError(
            f"a running surface of {body!r} of several or anisotropic materials",
            "one isotropic material",
            "give one material",
        )
    strip = float(np.ptp(cells.limits)) / cells.n_cells
    numbers = np.unique(
        np.concatenate((np.arange(16), np.round(np.geomspace(16, REACH, N_DISTANCES - 16)))).astype(int)
    )

    def make() -> Arrays:
        progress(f"compliance of the {body}")
        return {"remainder": _remainder(cells, strip, numbers, tolerance)}

    settings = numbers, tolerance, CORRECTED, LEAST_WAVENUMBER
    found = cached(cache, make, "remainder", *cells.content, *settings)
    stations = (cells.limits[1:] + cells.limits[:-1]) / 2.0
    return ElasticSurface(
        cells.material, stations, cells.middles, cells.frames, strip * numbers.astype(np.float64), found["remainder"]
    )


def _remainder(cells: SurfaceCells, strip: float, numbers: Ints, tolerance: float) -> Floats:
    """Compliance less that of a half-space at multiples of a strip, in the axes x, y, z."""
    assert cells.material is not None
    n, n_strips = cells.n_cells, int(numbers[-1]) + 1
    table = compliance_table(cells, LEAST_WAVENUMBER, 2.0 * np.pi / strip, tolerance)
    own = table.influence(strip, n_strips, nearest=CORRECTED).reshape(n_strips, n, 3, n, 3)[numbers]
    own -= half_spaces_on((cells.material,), cells.limits, cells.frames, strip, n_strips)[numbers]
    return np.einsum("iax,ziajb,jby->zixjy", cells.frames, own, cells.frames, optimize=True)
