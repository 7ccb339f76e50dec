"""Compliance of a surface in three dimensions: plane problems at many wavenumbers, summed.

The inverse transform over strips of a width dz gives the mean displacement of a cell by a force on a cell at the
distance z from C(k), see `SurfaceCells`; ``w = sinc^2(k dz / 2)`` averages over both strips:

    g(z) = (1 / pi) int_0^inf C(k) w(k) cos kz dk          among t and n, and z by z
    g(z) = -+ (1 / pi) int_0^inf C(k) w(k) sin kz dk       t or n by z (-), z by t or n (+)

The mesh errs in g(z) between the nearest cells only. There the part of a half-space is replaced by its closed form.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from scipy.interpolate import CubicSpline

from flangeway._core import n_threads
from flangeway.errors import InputError
from flangeway.problems.harmonic import Harmonic, at_wavenumber
from flangeway.solve.half_spaces import half_spaces_on
from flangeway.solve.linear import cholesky
from flangeway.solve.surface_cells import SAME, SurfaceCells
from flangeway.system.disk_cache import Arrays, Cache, cached
from flangeway.system.memory_limits import memory_left, refuse_beyond_memory
from flangeway.types import Floats, Ints

PER_DECADE = 3
"""Wavenumbers for each decade before their number is doubled where the interpolation is not good enough."""
MOST_DOUBLINGS = 4
"""Times that an interval between wavenumbers is halved at most."""
HALVED = 8.0
"""Factor by which a cubic spline errs less with half the steps, at least (16 in the limit)."""
TAIL = 4.0
"""Factor on the largest wavenumber up to which C ~ 1 / k continues the table."""
PHASE = np.pi / 2.0
"""Largest phase k z of an interval of six Gauss points."""
NEAREST = 3.0
"""Distance up to which cells are corrected, over the largest of strip, cells' widths and edges below them."""


@dataclass(frozen=True, eq=False)
class ComplianceTable:
    """Compliance of a surface at wavenumbers from which it is interpolated: k C is a cubic spline over log k.

    Parameters
    ----------
    cells
        The surface.
    wavenumbers
        Rising, shape (n_k,).
    values
        `SurfaceCells.compliance` at each, shape (n_k, 3 n_cells, 3 n_cells).
    error
        Of the interpolation, over the largest k C: from the differences at wavenumbers that were left out, which then
        came in.

    """

    cells: SurfaceCells
    wavenumbers: Floats
    values: Floats
    error: float

    def influence(
        self, strip: float, n_strips: int, axes: Sequence[int] = (0, 1, 2), nearest: float = NEAREST
    ) -> Floats:
        """Mean displacement of cells by unit forces on cells of strips at distances along z.

        Parameters
        ----------
        strip
            Width dz of the strips.
        n_strips
            Number of distances 0, dz, 2 dz, ...
        axes
            Which of t, n, z.
        nearest
            Distance up to which cells are corrected on an isotropic material, over the largest of strip, cells' widths
            and edges below them.

        Returns
        -------
        Floats
            Shape (n_strips, m n_cells, m n_cells) for m axes, by displacement and force. At negative distances it is
            the transpose.

        """
        n, m, material = self.cells.n_cells, len(axes), self.cells.material
        refuse_beyond_memory(f"influence coefficients of {n} x {n_strips} cells", 4 * 8 * n_strips * (n * m) ** 2)
        reach = nearest * max(strip, float(self.cells.widths.max()), self.cells.longest_edge)
        last = int(np.ceil(reach / strip))
        n_distances = n_strips if material is None else max(n_strips, last + 3)
        distances = strip * np.arange(n_distances, dtype=np.float64)
        chosen = self.values.reshape(len(self.values), n, 3, n, 3)[:, :, axes][..., axes]
        even, odd = inverse_weights(self.wavenumbers, distances, strip)
        result = np.empty((n_distances, n, m, n, m))
        for i, j in product(range(m), repeat=2):
            weights = even if (axes[i] == 2) == (axes[j] == 2) else odd if axes[i] == 2 else -odd
            coefficients = chosen[:, :, i, :, j].reshape(len(chosen), n * n)
            result[:, :, i, :, j] = (weights @ coefficients).reshape(-1, n, n)
        if material is not None:
            self._correct(result, axes, strip, reach, last)
        return result[:n_strips].reshape(n_strips, n * m, n * m)

    def _correct(self, result: Floats, axes: Sequence[int], strip: float, reach: float, last: int) -> None:
        """Replace the coefficients of the nearest cells, up to the distance number `last`.

        They are those of a half-space and what the body adds to them, taken from the next two distances along z: it
        hardly changes there, or, where z is coupled with the plane, in proportion to z.
        """
        material, limits = self.cells.material, self.cells.limits
        assert material is not None
        exact = half_spaces_on((material,), limits, self.cells.frames, strip, last + 3, axes)
        longitudinal = np.array(axes) == 2
        mixed = (longitudinal[:, None] != longitudinal)[:, None]
        growth = np.where(mixed, np.arange(last + 3)[:, None, None, None, None], 1.0)
        beyond = ((result[: last + 3] - exact)[last + 1 :] / growth[last + 1 :]).mean(axis=0)
        middles = (limits[1:] + limits[:-1]) / 2.0
        near = (np.abs(middles[:, None] - middles) <= (1.0 + SAME) * reach)[:, None, :, None]
        result[: last + 1] = np.where(near, exact + growth * beyond, result[: last + 3])[: last + 1]


def compliance_table(
    cells: SurfaceCells,
    least: float,
    maximum: float,
    tolerance: float = 1e-4,
    progress: Callable[[str], None] = lambda _: None,
    cache: Cache | None = None,
) -> ComplianceTable:
    """Compliance at as many wavenumbers as the interpolation between them needs.

    Parameters
    ----------
    cells
        The surface.
    least, maximum
        Range of the wavenumbers. Below, the compliance is taken as constant; above, it falls with 1 / k. For strips of
        the width dz the largest one should be pi / dz or more, without the correction of the nearest cells 2 pi / dz.
    tolerance
        Error of the interpolation of k C, over the largest k C.
    progress
        Called with a sentence at each stage.
    cache
        Where tables are kept from one process to the next.

    Raises
    ------
    InputError
        If the range is wrong, or the prism can move without strain.
    OutOfMemoryError
        If there is too little memory.

    """
    if not 0.0 < least < maximum or not tolerance > 0.0:
        raise InputError(
            f"wavenumbers from {least} to {maximum} to {tolerance}",
            "0 < least < maximum, and a tolerance > 0",
            "give per length",
        )
    if cells.problem.revolution:
        raise InputError("surface cells of a body of revolution", "a prism", "take the prism of its section")
    settings = least, maximum, tolerance
    content = *cells.content, *settings, PER_DECADE, MOST_DOUBLINGS, HALVED
    found = cached(cache, lambda: _computed(cells, *settings, progress), "compliance", *content)
    return ComplianceTable(cells, found["wavenumbers"], found["values"], float(found["error"]))


def _computed(
    cells: SurfaceCells, least: float, maximum: float, tolerance: float, progress: Callable[[str], None]
) -> Arrays:
    count = max(int(np.ceil(PER_DECADE * np.log10(maximum / least))), 3) + 1
    size = 8 * (3 * cells.n_cells) ** 2
    refuse_beyond_memory(f"the compliance of {cells.n_cells} cells at {2 * count} wavenumbers", 6 * count * size)
    logs = np.linspace(np.log(least), np.log(maximum), count)
    values = compliances(cells, np.exp(logs))
    open_intervals = np.ones(count - 1, dtype=np.bool_)
    error = 0.0
    for stage in range(MOST_DOUBLINGS):
        middles = (logs[:-1] + logs[1:])[open_intervals] / 2.0
        new = compliances(cells, np.exp(middles))
        scaled = values * np.exp(logs)[:, None, None]
        missed = _spline(logs, scaled)(middles) - new * np.exp(middles)[:, None, None]
        errors = np.abs(missed).max(axis=(1, 2)) / np.abs(scaled).max() / HALVED
        rough = errors > tolerance if stage < MOST_DOUBLINGS - 1 else np.zeros(len(errors), dtype=np.bool_)
        error = max(error, float(errors[~rough].max(initial=0.0)))
        order = np.argsort(np.concatenate((logs, middles)))
        logs = np.concatenate((logs, middles))[order]
        values = np.concatenate((values, new))[order]
        progress(f"{len(logs)} wavenumbers, interpolation to {float(errors.max()):.1e}")
        if not rough.any():
            break
        # both halves of an interval whose middle was not met are halved again
        bad = np.isin(logs, middles[rough])
        open_intervals = bad[:-1] | bad[1:]
    return {"wavenumbers": np.exp(logs), "values": values, "error": np.array(error)}


def _spline(logs: Floats, values: Floats) -> CubicSpline:
    """The interpolation, of the fourth order up to both ends."""
    return CubicSpline(logs, values, bc_type="not-a-knot")


def compliances(cells: SurfaceCells, wavenumbers: Floats) -> Floats:
    """Compliances at wavenumbers, side by side on as many cores as there is memory for."""
    first, n_bytes = cells.compliance_and_bytes(wavenumbers[0])
    with ThreadPoolExecutor(max(1, min(n_threads(), memory_left() // n_bytes))) as pool:
        # where one raises, as where the user interrupts, those that have not begun are dropped
        return np.stack([first, *pool.map(cells.compliance, wavenumbers[1:].tolist())])


def inverse_weights(wavenumbers: Floats, distances: Floats, strip: float, averaged: int = 2) -> tuple[Floats, Floats]:
    """Weights of values C at wavenumbers in the integrals with cosine and sine over all wavenumbers, each (n_z, n_k).

    k C is a cubic spline over log k, C is constant below the least wavenumber, and falls with 1 / k above the
    largest one. Averaged over two strips, that of the force and that of the displacement, or over the first alone.
    """
    logs = np.log(wavenumbers)
    cardinal = _spline(logs, np.eye(len(logs)))
    bounds = np.concatenate(([0.0], wavenumbers, [TAIL * wavenumbers[-1]]))
    reach = max(float(distances.max()), strip)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    points, lengths = [], []
    for start, end in pairwise(bounds):
        pieces = np.linspace(start, end, int(np.ceil((end - start) * reach / PHASE)) + 2)
        half = np.diff(pieces)[:, None] / 2.0
        points.append((pieces[:-1, None] + half * (1.0 + nodes)).ravel())
        lengths.append((half * weights).ravel())
    k, dk = np.concatenate(points), np.concatenate(lengths)
    basis = cardinal(np.clip(np.log(k), logs[0], logs[-1])) * (wavenumbers / np.maximum(k, wavenumbers[0])[:, None])
    basis *= (dk * np.sinc(k * strip / (2.0 * np.pi)) ** averaged / np.pi)[:, None]
    phase = distances[:, None] * k
    return np.cos(phase) @ basis, np.sin(phase) @ basis


WAVES_PER_DECADE = 8
"""Wavenumbers for each decade; twice as many change no stress by more than 1e-3 of the maximum pressure."""


def amplitudes(problem: Harmonic, wavenumbers: Floats, rhs: Floats) -> Iterator[Floats]:
    """Amplitudes (3 n_dofs, m) at each wavenumber, by loads (3 n_dofs, n_k, m), or (3 n_dofs, 1, m) at all of them."""
    free = problem.free(1.0).ravel()
    parts = [part.restricted(free) for part in problem.parts]
    groups = (np.flatnonzero(free) // 3).astype(np.int32)
    loads = np.broadcast_to(rhs[free], (int(free.sum()), len(wavenumbers), rhs.shape[2]))

    def answer(number: int) -> Floats:
        found = np.zeros((len(free), rhs.shape[2]))
        factor = cholesky(at_wavenumber(parts, wavenumbers[number]), groups)
        found[free] = factor.solve(np.ascontiguousarray(loads[:, number]))
        return found

    with ThreadPoolExecutor(n_threads()) as pool:
        yield from pool.map(answer, range(len(wavenumbers)))


@dataclass(frozen=True, eq=False)
class StripForces:
    """Forces on cells of strips, whose amplitudes are summed at a section.

    Parameters
    ----------
    cells
        The cells.
    forces
        In the cells' frames, shape (n_cells, 3, n_strips).
    apart
        The section's z less those of the middles of the strips, shape (n_strips,).
    strip
        Width of the strips.

    """

    cells: SurfaceCells
    forces: Floats
    apart: Floats
    strip: float

    def at_waves(self, wavenumbers: Floats) -> tuple[Ints, Floats]:
        """Unknowns (n,), and their loads for cosine and sine (n, n_k, 2)."""
        even, odd = inverse_weights(wavenumbers, np.abs(self.apart), self.strip, averaged=1)
        odd *= np.sign(self.apart)[:, None]
        # f(c, a, i, cosine or sine): forces of the cells at the wavenumber i; those along z vary a quarter of a wave
        # later
        on_cells = np.stack((self.forces @ even, self.forces @ odd), axis=-1)
        on_cells[:, 2] = on_cells[:, 2, :, ::-1] * (-1.0, 1.0)
        nodes, loads = self.cells.nodes_and_loads
        on_nodes = np.einsum("ns,ski->nki", loads, on_cells.reshape(-1, len(wavenumbers), 2))
        return (3 * nodes[:, None] + np.arange(3)).ravel(), on_nodes


FurtherLoads = tuple[Floats, Sequence[Callable[[int, Floats], Floats]]]
"""Loads (3 n_dofs, m), and for each of the forces that are summed what gives the amounts (m, 2) for cosine and sine by
the number of a wavenumber and the amplitudes (3 n_dofs, 2 + m) of these forces and of the loads."""


def waves(least: float, strip: float) -> Floats:
    """Wavenumbers from a least one on for forces on strips of a width, shape (n_k,)."""
    top = 2.0 * np.pi / strip
    return np.geomspace(least, top, int(np.ceil(WAVES_PER_DECADE * np.log10(top / least))) + 1)


def wave_sums(
    loaded: Sequence[StripForces], wavenumbers: Floats, further: FurtherLoads | None = None
) -> list[tuple[Floats, Floats]]:
    """Sum the amplitudes of all wavenumbers at a section, and the amplitudes times their wavenumbers.

    Strains are linear in both, ``B0 u + k B1 u``: the sums give all stresses.

    Parameters
    ----------
    loaded
        Forces on one body, each summed by itself: they share its factorisations.
    wavenumbers
        See `waves`.
    further
        Loads whose amounts depend on what the forces cause.

    Returns
    -------
    list
        For each of the forces: amplitudes of what varies as the cosine, and as the sine, each (2, n_dofs, 3): sum, and
        sum times wavenumber.

    """
    problem = loaded[0].cells.problem
    others, amounts = further or (np.zeros((3 * problem.elasticity.space.n_dofs, 0)), [])
    first = others.shape[1]
    rhs = np.zeros((len(others), len(wavenumbers), first + 2 * len(loaded)))
    rhs[..., :first] = others[:, None]
    for number, each in enumerate(loaded):
        unknowns, loads = each.at_waves(wavenumbers)
        rhs[unknowns, :, first + 2 * number : first + 2 * number + 2] = loads
    sums = np.zeros((len(loaded), 2, len(others), 2))
    for i, (k, found) in enumerate(zip(wavenumbers.tolist(), amplitudes(problem, wavenumbers, rhs), strict=True)):
        by_others = found[:, :first]
        for number in range(len(loaded)):
            moved = found[:, first + 2 * number : first + 2 * number + 2]
            if first:
                moved = moved + by_others @ amounts[number](i, np.concatenate((moved, by_others), axis=1))
            sums[number] += np.stack((moved, k * moved))
    cosines, sines = np.moveaxis(sums.reshape(len(loaded), 2, -1, 3, 2), -1, 0)
    return list(zip(cosines, sines, strict=True))
