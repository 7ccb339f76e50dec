"""Normal contact on a grid of cells, and the compliance of a running surface on any grid."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from flangeway.errors import InputError
from flangeway.geometry.arrays import middles_of, run_of
from flangeway.materials import Elastic
from flangeway.solve import Status, SurfaceCells, compliance_table
from flangeway.solve.surface_compliance import half_spaces_on
from flangeway.system.disk_cache import Arrays, Cache, cached
from flangeway.types import Bools, Floats, Ints

# --- Normal contact on a grid of cells: dense across, a convolution along z.


MAX_ITERATIONS = 500
MIN_RESIDUAL_RATIO = 1e-20
"""Square of the residual over another one that is round-off."""
MAX_CHANGE = 1e-9
"""Change of the forces, relative to their sum, at which `Pressing` ends: single pressures are then within 1e-7."""


Components = tuple[bool, ...]


class Convolution:
    """Product of influence coefficients with forces on a grid of cells across and strips along z, by Fourier sums.

    Of bodies that are symmetric about planes across z, as prisms and bodies of revolution are: coefficients at the
    distances dz and -dz are equal, or opposite where one of displacement and force lies along z.

    Parameters
    ----------
    coefficients
        At the distances 0, dz, 2 dz, ... of all strips, shape (n_strips, m, n), by displacement and force.
    odd
        Which components of the displacement of a cell, and which of its force, lie along z. Rows of m and n are the
        components of the first cell, then those of the second one. Left out: one component of each, not along z.

    """

    def __init__(self, coefficients: Floats, odd: tuple[Components, Components] = ((False,), (False,))) -> None:
        n_strips, self._odd = len(coefficients), odd
        # F_tw = exp(-2 pi i t w / 2n) to the wavenumbers w = 0 ... n, and back: on so few strips as patches have,
        # products with matrices take half of the time of fast transforms. Real and imaginary parts are rows of their
        # own. Even functions have a real spectrum, odd ones an imaginary one: with i times what is along z, the second
        # one of each pair of matrices, all is real
        sums = scipy.fft.rfft(np.eye(n_strips), 2 * n_strips).T
        self._forward = [_parts(sums), _parts(1j * sums)]
        waves = np.eye(n_strips + 1)
        back = np.stack((waves, 1j * waves), axis=1).reshape(-1, n_strips + 1)
        self._back = [scipy.fft.irfft(turn * back, 2 * n_strips)[:, :n_strips] for turn in (1.0, -1j)]
        # S_w = c_0 + 2 sum over t of c_t cos(pi t w / n) + c_n cos(pi w), with sines for odd functions; the one at
        # the distance n is not used, but a gap there would make the inverse rough
        angles = np.pi / n_strips * np.outer(np.arange(n_strips + 1), np.arange(n_strips))
        cosines, sines = 2.0 * np.cos(angles), 2.0 * np.sin(angles)
        cosines[:, 0] /= 2.0
        cosines[:, -1] += np.cos(np.pi * np.arange(n_strips + 1))
        # S_wcjdi by force j of the component c and displacement i of the component d
        moved, by = odd
        kernels = coefficients.reshape(n_strips, -1, len(moved), coefficients.shape[2] // len(by), len(by))
        kernels = kernels.transpose(0, 4, 3, 2, 1)
        spectrum = np.empty((n_strips + 1, *kernels.shape[1:]))
        for (c, of_force), (d, of_move) in product(enumerate(by), enumerate(moved)):
            wave = cosines if of_force == of_move else sines if of_move else -sines
            spectrum[:, c, :, d] = np.tensordot(wave, kernels[:, c, :, d], axes=1)
        self._spectrum = spectrum.reshape(n_strips + 1, coefficients.shape[2], -1)

    def inverted(self) -> "Convolution":
        """The inverse on twice the strips without ends: near the inverse of this one, and in single precision."""
        inverse = copy(self)
        inverse._spectrum, inverse._odd = np.linalg.inv(self._spectrum).astype(np.float32), self._odd[::-1]
        return inverse

    def transposed(self) -> "Convolution":
        """The transposed product."""
        other = copy(self)
        other._spectrum, other._odd = self._spectrum.swapaxes(1, 2), self._odd[::-1]
        return other

    def between(self, onto: Floats, back: Floats) -> "Convolution":
        """Forces are spread on strips by one matrix (m, n), and displacements taken from them by another (n, k)."""
        other = copy(self)
        other._forward = [forward @ onto.T for forward in self._forward]
        other._back = [backward @ back for backward in self._back]
        return other

    def __call__(self, forces: Floats) -> Floats:
        """Displacements (..., m, n_strips) by forces (..., n, n_strips)."""
        moved, by = self._odd
        at_once = forces.reshape(-1, forces.shape[-2] // len(by), len(by), forces.shape[-1])
        rows = slice(None)
        if len(by) == 1:  # rows without forces are left out
            loaded = at_once.any(axis=(0, 2, 3))
            rows = run_of(loaded) if loaded.any() else slice(0, 1)
        k, n = at_once[:, rows].shape[:2]
        waves = np.empty((len(self._forward[0]), k, len(by), n))
        for component, odd in enumerate(by):
            on_strips = at_once[:, rows, component].swapaxes(1, 2)
            np.matmul(self._forward[odd], on_strips, out=waves[:, :, component].swapaxes(0, 1))
        waves = waves.astype(self._spectrum.dtype, copy=False)
        # u_wki = sum over j of f_wkj S_wji for each wavenumber w, real and imaginary parts and all k at once
        spectrum = self._spectrum[:, rows]
        moved_waves = waves.reshape(len(spectrum), -1, spectrum.shape[1]) @ spectrum
        moved_waves = moved_waves.reshape(len(waves), k, len(moved), -1)
        result = np.empty((k, moved_waves.shape[3], len(moved), self._back[0].shape[1]))
        for component, odd in enumerate(moved):
            np.matmul(moved_waves[:, :, component].transpose(1, 2, 0), self._back[odd], out=result[:, :, component])
        return result.reshape(*forces.shape[:-2], -1, result.shape[-1])


def _parts(values: NDArray[np.complex128]) -> Floats:
    """Real and imaginary parts of rows (n, m), one after the other: (2 n, m)."""
    return np.stack((values.real, values.imag), axis=1).reshape(-1, values.shape[1])


@dataclass(frozen=True, eq=False)
class NormalContact:
    """Forces of normal contact on a grid.

    Parameters
    ----------
    forces
        Normal forces on the cells, >= 0, shape (n_cells, n_strips).
    approach
        Rigid approach along the direction of the load.
    gaps
        Gaps of the deformed surfaces, shape as the forces.
    status
        How the iteration ended.

    """

    forces: Floats
    approach: float
    gaps: Floats
    status: Status


def solve_normal(
    influence: Convolution,
    gaps: Floats,
    *,
    force: float | None = None,
    approach: float | None = None,
    share: Floats | float = 1.0,
    start: Floats | None = None,
    tolerance: float = 1e-7,
) -> NormalContact:
    """Find forces >= 0 so that the gap is closed under them and open elsewhere (Polonsky and Keer, 1999, Wear 231).

    Conjugate gradients on ``1/2 f' A f + h' f`` within the cells that are in contact. A loop of its own: it needs
    products with A alone, and no tangent.

    Parameters
    ----------
    influence
        Mean normal displacement of both surfaces together by forces on the cells.
    gaps
        Gaps h before any approach and deformation, positive where open, shape (n_cells, n_strips).
    force, approach
        The resultant along the direction of the load, or the rigid approach: one of them.
    share
        Component of each cell's normal along the direction of the load, as the gaps or one number.
    start
        Forces to start from, as from a neighbouring position.
    tolerance
        Change of the forces over their sum, and gap under force over the approach, at which the iteration ends.

    Raises
    ------
    InputError
        If neither or both of force and approach are given, or the force is not positive.

    """
    if (force is None) == (approach is None) or (force is not None and not force > 0.0):
        raise InputError(f"force={force} and approach={approach}", "a force > 0 or an approach", "give one of them")
    shares = np.broadcast_to(np.asarray(share, dtype=np.float64), gaps.shape)
    if approach is not None and not (gaps < approach * shares).any():
        return NormalContact(np.zeros(gaps.shape), approach, gaps - approach * shares, Status(True, "no contact", 0))
    if start is None:
        start = np.maximum(gaps.min() + _depth(gaps) - gaps, 0.0)
    forces = start if force is None else start * force / float((shares * start).sum())

    def unbalanced(deformed: Floats, touching: Bools) -> tuple[float, Floats, float]:
        """Rigid approach of deformed surfaces, gaps after it, and the square of those that touch."""
        rigid = _along(deformed, shares, touching) if approach is None else approach
        left = deformed - rigid * shares
        return rigid, left, float((left[touching] ** 2).sum())

    direction = np.zeros(gaps.shape)
    old_norm, restart, done = 1.0, True, False
    change, iteration, moved = np.inf, 0, influence(forces)
    while not done and iteration < MAX_ITERATIONS:
        iteration += 1
        touching = forces > 0.0
        deformed = gaps + moved
        _, residual, norm = unbalanced(deformed, touching)
        entering = norm <= MIN_RESIDUAL_RATIO * float((residual[residual < 0.0] ** 2).sum())
        if entering:
            # what touches is in equilibrium: the step is found with the cells that overlap
            touching, restart = touching | (residual < 0.0), True
            _, residual, norm = unbalanced(deformed, touching)
        direction = np.where(touching, residual + (0.0 if restart else norm / old_norm) * direction, 0.0)
        old_norm = norm
        if force is not None:  # no part of it may be undone by the scaling to the load
            direction = np.where(touching, direction - _along(direction, shares, touching) * shares, 0.0)
        bent = influence(direction)
        curvature = float((direction * bent)[touching].sum())
        step = float((residual * direction)[touching].sum()) / curvature if curvature > 0.0 else 0.0
        before, forces = forces, forces - step * direction
        cut = bool((forces < 0.0).any())
        forces = np.maximum(forces, 0.0)
        closed = (forces == 0.0) & (residual < 0.0)
        forces = np.where(closed, forces - step * residual, forces)
        scale = 1.0 if force is None else force / float((shares * forces).sum())
        forces *= scale
        # a whole step moves as its direction does
        moved = influence(forces) if cut or closed.any() else scale * (moved - step * bent)
        total = float(forces.sum())
        change = float(np.abs(forces - before).sum()) / total if total > 0.0 else np.inf
        # a small change counts if its direction was that of the residual
        small = change < tolerance and not closed.any()
        done, restart = small and restart, small or entering or bool(closed.any())
    rigid, deformed, _ = unbalanced(gaps + influence(forces), forces > 0.0)
    status = Status(done, f"forces change by {change:.1e} after {iteration} iterations", iteration)
    return NormalContact(forces, rigid, deformed, status)


@dataclass(frozen=True, eq=False)
class Pressing:
    """Two surfaces that are pressed together again as their gaps change; see `solve_normal`."""

    influence: Convolution
    gaps: Floats
    share: Floats | float = 1.0
    force: float | None = None
    approach: float | None = None

    def __call__(self, change: Floats | float = 0.0, start: Floats | None = None) -> NormalContact:
        """Normal contact by changes of the gaps and forces to start from."""
        return solve_normal(
            self.influence,
            self.gaps + change,
            force=self.force,
            approach=self.approach,
            share=self.share,
            start=start,
            tolerance=MAX_CHANGE,
        )


def _along(values: Floats, shares: Floats, touching: Bools) -> float:
    """Rigid displacement along the load that fits normal displacements of the cells in contact best."""
    return float((values * shares)[touching].sum() / (shares**2)[touching].sum())


def _depth(gaps: Floats) -> float:
    """A depth at which some of the cells overlap."""
    return float(np.quantile(gaps, 0.1) - gaps.min()) + np.finfo(float).tiny


# --- Compliance of a running surface on any grid: that of a half-space, and what the body adds to it.
#
# Near a load every body moves as a half-space, in closed form. What it moves more, by its curvature, its width and its
# supports, is smooth. It is tabulated once on cells of some millimetres over the whole surface, and interpolated to the
# fine grid of a contact patch wherever that is.


MIN_WAVENUMBER = 2e-5
"""Per mm: a wave of 300 m, beyond which bodies that are held or on a foundation no longer change, along z either."""
TABLE_TOLERANCE = 1e-3
"""Error of the compliance between wavenumbers, see `flangeway.solve.compliance_table`."""
CORRECTED_DISTANCE = 1.0
"""Distance up to which the table's own nearest cells are corrected, relative to a cell."""
N_DISTANCES = 40
"""Distances along z at which the remainder is tabulated, the last of them `REACH` away."""
REACH = 160.0
"""Longest distance along z relative to a cell; beyond, the remainder hardly changes within a patch."""


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
    def on_splines(self) -> Floats:
        """`remainder` on the m B-splines of `interpolation`, shape (3, m, n_z, 3, m).

        By axis and spline of displacement, distance, axis and spline of force. At a place four splines are not zero;
        values at the stations would all have a weight.
        """
        to_splines = make_interp_spline(self.stations, np.eye(len(self.stations)), bc_type="natural").c
        # T_kxzly = sum over stations i, j of S_ki R_zixjy S_lj
        table = to_splines @ self.remainder.transpose(2, 4, 0, 1, 3) @ to_splines.T
        return np.ascontiguousarray(table.transpose(0, 3, 2, 1, 4))

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
    cache: Cache | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> ElasticSurface:
    """Tabulate what a prism's surface moves more than a half-space.

    Parameters
    ----------
    cells
        Even cells on the surface of a prism, isotropic below it.
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
        return {"remainder": _remainder(cells, strip, numbers)}

    settings = numbers, TABLE_TOLERANCE, CORRECTED_DISTANCE, MIN_WAVENUMBER
    remainder = cached(cache, make, "remainder", *cells.content, *settings)
    stations = middles_of(cells.limits)
    return ElasticSurface(
        cells.material,
        stations,
        cells.middles,
        cells.frames,
        strip * numbers.astype(np.float64),
        remainder["remainder"],
    )


def _remainder(cells: SurfaceCells, strip: float, numbers: Ints) -> Floats:
    """Compliance less that of a half-space at multiples of a strip, in the axes x, y, z."""
    assert cells.material is not None
    n, n_strips = cells.n_cells, int(numbers[-1]) + 1
    table = compliance_table(cells, MIN_WAVENUMBER, 2.0 * np.pi / strip, TABLE_TOLERANCE)
    remainder = table.influence(strip, n_strips, nearest=CORRECTED_DISTANCE).reshape(n_strips, n, 3, n, 3)[numbers]
    remainder -= half_spaces_on((cells.material,), cells.limits, cells.frames, strip, n_strips)[numbers]
    return np.einsum("iax,ziajb,jby->zixjy", cells.frames, remainder, cells.frames, optimize=True)
