"""Compliance of a surface in three dimensions: plane problems at many wavenumbers, condensed and summed.

A contact surface is a row of cells across, each some edges of the plane mesh with a frame of its own (tangent, outward
normal, z). At each wavenumber the prism is condensed once to the surface's nodes; C(k) are the mean displacements of
the cells by uniform loads on them. The inverse transform over strips of a width dz gives the mean displacement of a
cell by a force on a cell at the distance z; ``w = sinc^2(k dz / 2)`` averages over both strips:

    g(z) = (1 / pi) int_0^inf C(k) w(k) cos kz dk          among t and n, and z by z
    g(z) = -+ (1 / pi) int_0^inf C(k) w(k) sin kz dk       t or n by z (-), z by t or n (+)
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import cho_factor, cho_solve

from flangeway._core import NotPositiveDefiniteError, n_threads
from flangeway.elements.quadrature import gauss
from flangeway.errors import InputError
from flangeway.problems.edges import edge_shapes
from flangeway.problems.harmonic import Harmonic, at_wavenumber
from flangeway.solve.linear import cholesky
from flangeway.space import SymmetricMatrix
from flangeway.types import Floats, Ints

PER_DECADE = 4
"""Wavenumbers for each decade before their number is doubled where the interpolation is not good enough."""
MOST_DOUBLINGS = 4
"""Times that an interval between wavenumbers is halved at most."""
TAIL = 4.0
"""Factor on the largest wavenumber up to which C ~ 1 / k continues the table."""
SAME = 1e-9
"""Length over that of a surface that is round-off."""
PHASE = np.pi / 2.0
"""Largest phase k z of an interval of six Gauss points."""


@dataclass(frozen=True, eq=False)
class SurfaceCells:
    """A row of cells on a prism's surface.

    Parameters
    ----------
    problem
        The prism with its supports.
    edges
        Boundary edges one after the other, body on their left, shape (n_edges, 2).
    bounds
        Ends of the cells as lengths along the edges, rising, shape (n_cells + 1,); left out: each edge is a cell. Cells
        of two edges have half the error of a cell's own coefficient.

    """

    problem: Harmonic
    edges: Ints
    bounds: Floats | None = None

    def __post_init__(self) -> None:
        edges = np.asarray(self.edges)
        if edges.ndim != 2 or len(edges) == 0 or (edges[1:, 0] != edges[:-1, 1]).any():
            raise InputError(
                f"cells on edges of shape {edges.shape}", "edges that follow each other", "order them along the surface"
            )
        if self.problem.revolution:
            raise InputError("surface cells of a body of revolution", "a prism", "take the prism of its section")
        first, last = self.limits[0], self.limits[-1]
        length = self._stations[-1]
        if not (np.diff(self.limits) > 0.0).all() or first < -SAME * length or last > (1.0 + SAME) * length:
            raise InputError(
                f"cells from {first:g} to {last:g} along a surface of the length {length:g}",
                "rising lengths within the surface",
                "take a smaller window, or more edges",
            )

    @cached_property
    def _stations(self) -> Floats:
        """Lengths at the ends of the edges, shape (n_edges + 1,)."""
        points = self.problem.elasticity.space.mesh.points[self.edges]
        return np.concatenate(([0.0], np.cumsum(np.linalg.norm(points[:, 1] - points[:, 0], axis=1))))

    @property
    def limits(self) -> Floats:
        """Ends of the cells as lengths along the edges, shape (n_cells + 1,)."""
        return self._stations if self.bounds is None else self.bounds

    @property
    def longest_edge(self) -> float:
        """Maximum length of the mesh's edges below the cells."""
        below = (self._stations[1:] > self.limits[0]) & (self._stations[:-1] < self.limits[-1])
        return float(np.diff(self._stations)[below].max())

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.limits) - 1

    @cached_property
    def ends(self) -> Floats:
        """Ends of the cells, shape (n_cells + 1, 2)."""
        points = self.problem.elasticity.space.mesh.points
        chain = np.concatenate((points[self.edges[:, 0]], points[self.edges[-1:, 1]]))
        return np.stack([np.interp(self.limits, self._stations, chain[:, axis]) for axis in range(2)], axis=1)

    @cached_property
    def widths(self) -> Floats:
        """Widths of the cells along the surface, shape (n_cells,)."""
        return np.diff(self.limits)

    @property
    def middles(self) -> Floats:
        """Middles of the cells' chords, shape (n_cells, 2)."""
        middles: Floats = (self.ends[1:] + self.ends[:-1]) / 2.0
        return middles

    @cached_property
    def frames(self) -> Floats:
        """Axes tangent, outward normal and z of the cells, rows of (n_cells, 3, 3)."""
        chords = np.diff(self.ends, axis=0)
        tangents = chords / np.linalg.norm(chords, axis=1)[:, None]
        frames = np.zeros((self.n_cells, 3, 3))
        frames[:, 0, :2] = tangents
        frames[:, 1, 0], frames[:, 1, 1] = tangents[:, 1], -tangents[:, 0]
        frames[:, 2, 2] = 1.0
        return frames

    @cached_property
    def _nodes_and_loads(self) -> tuple[Ints, Floats]:
        """Surface nodes, and their forces by unit forces on the cells: (3 n_nodes, 3 n_cells)."""
        space = self.problem.elasticity.space
        inside = self._stations[(self._stations > self.limits[0]) & (self._stations < self.limits[-1])]
        cuts = np.unique(np.concatenate((self.limits, inside)))
        middles, lengths = (cuts[1:] + cuts[:-1]) / 2.0, np.diff(cuts)
        edge = np.clip(np.searchsorted(self._stations, middles) - 1, 0, len(self.edges) - 1)
        cell = np.clip(np.searchsorted(self.limits, middles) - 1, 0, self.n_cells - 1)
        abscissae, weights = gauss(space.order + 1)
        # places of the Gauss points of each piece on its edge, in [0, 1]
        places = (cuts[:-1, None] + lengths[:, None] * abscissae - self._stations[edge, None]) / np.diff(
            self._stations
        )[edge, None]
        shapes = edge_shapes(space.order, places.ravel()).reshape(*places.shape, -1)
        # a unit force on a cell is spread evenly over its width
        shares = np.einsum("pq,pqm->pm", lengths[:, None] * weights, shapes) / self.widths[cell, None]
        of_edges = space.edge_nodes(self.edges)[edge]
        nodes, numbers = np.unique(of_edges, return_inverse=True)
        on_nodes = np.zeros((len(nodes), self.n_cells))
        np.add.at(on_nodes, (numbers.reshape(of_edges.shape), cell[:, None]), shares)
        # P_(n i)(c a) = share of node n in cell c times axis a of the cell along i
        loads = np.einsum("nc,cai->nica", on_nodes, self.frames)
        return nodes.astype(np.int64), loads.reshape(3 * len(nodes), 3 * self.n_cells)

    @cached_property
    def _reduced(self) -> tuple[tuple[SymmetricMatrix, ...], Ints, Ints]:
        """K0, K1, K2 of the free unknowns, the unknown of each, and those of the surface nodes (-1: held)."""
        free = self.problem.free(1.0).ravel()
        numbers = np.where(free, np.cumsum(free) - 1, -1)
        nodes, _ = self._nodes_and_loads
        surface = numbers[(3 * nodes[:, None] + np.arange(3)).ravel()]
        return tuple(part.restricted(free) for part in self.problem.parts), np.flatnonzero(free), surface

    def compliance(self, wavenumber: float) -> Floats:
        """Mean displacements of the cells by unit forces per length on them at a wavenumber, in their frames.

        Parameters
        ----------
        wavenumber
            k > 0.

        Returns
        -------
        Floats
            Amplitudes, shape (3 n_cells, 3 n_cells), symmetric; of ``cos kz`` along t and n, of ``sin kz`` along z.

        Raises
        ------
        InputError
            If the prism can move without strain.

        """
        parts, unknowns, surface = self._reduced
        _, loads = self._nodes_and_loads
        loose = surface >= 0
        try:
            factor = cholesky(
                at_wavenumber(parts, wavenumber),
                (unknowns // 3).astype(np.int32),
                surface[loose].astype(np.int32),
            )
            condensed = cho_factor(factor.schur(), lower=True)
        except (NotPositiveDefiniteError, np.linalg.LinAlgError) as error:
            raise InputError(
                f"body `{self.problem.elasticity.name}` at wavenumber {wavenumber:g}: it can move without strain",
                "a prism that is held, or on a foundation, along x, y and z",
                "give held=... or foundations=...",
            ) from error
        found: Floats = loads[loose].T @ cho_solve(condensed, loads[loose])
        return (found + found.T) / 2.0


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
        Largest difference of the interpolation from a value that was left out, over the largest k C.

    """

    cells: SurfaceCells
    wavenumbers: Floats
    values: Floats
    error: float

    def influence(self, strip: float, n_strips: int, axes: Sequence[int] = (0, 1, 2)) -> Floats:
        """Mean displacement of cells by unit forces on cells of strips at distances along z.

        Parameters
        ----------
        strip
            Width dz of the strips.
        n_strips
            Number of distances 0, dz, 2 dz, ...
        axes
            Which of t, n, z.

        Returns
        -------
        Floats
            Shape (n_strips, m n_cells, m n_cells) for m axes, by displacement and force. At negative distances it is
            the transpose.

        """
        distances = strip * np.arange(n_strips, dtype=np.float64)
        n, m = self.cells.n_cells, len(axes)
        chosen = self.values.reshape(len(self.values), n, 3, n, 3)[:, :, axes][..., axes]
        even, odd = inverse_weights(self.wavenumbers, distances, strip)
        longitudinal = np.array(axes) == 2
        result = np.empty((n_strips, n, m, n, m))
        for i in range(m):
            for j in range(m):
                mixed = longitudinal[i] != longitudinal[j]
                weights = (odd if longitudinal[i] else -odd) if mixed else even
                result[:, :, i, :, j] = np.einsum("zk,kab->zab", weights, chosen[:, :, i, :, j], optimize=True)
        return result.reshape(n_strips, n * m, n * m)


def compliance_table(
    cells: SurfaceCells,
    least: float,
    maximum: float,
    tolerance: float = 1e-4,
    progress: Callable[[str], None] = lambda _: None,
) -> ComplianceTable:
    """Compliance at as many wavenumbers as the interpolation between them needs.

    Parameters
    ----------
    cells
        The surface.
    least, maximum
        Range of the wavenumbers. Below, the compliance is taken as constant; above, it falls with 1 / k. The largest
        one should be 2 pi / dz or more for strips of the width dz.
    tolerance
        Error of the interpolation of k C, over the largest k C.
    progress
        Called with a sentence at each stage.

    """
    if not 0.0 < least < maximum:
        raise InputError(f"wavenumbers from {least} to {maximum}", "0 < least < maximum", "give per length")
    count = max(int(np.ceil(PER_DECADE * np.log10(maximum / least))), 3) + 1
    logs = np.linspace(np.log(least), np.log(maximum), count)
    values = _at_all(cells, logs)
    open_intervals = np.ones(count - 1, dtype=np.bool_)
    error = np.inf
    for _ in range(MOST_DOUBLINGS):
        middles = (logs[:-1] + logs[1:])[open_intervals] / 2.0
        new = _at_all(cells, middles)
        scaled = values * np.exp(logs)[:, None, None]
        predicted = CubicSpline(logs, scaled, bc_type="natural")(middles)
        errors = np.abs(predicted - new * np.exp(middles)[:, None, None]).max(axis=(1, 2)) / np.abs(scaled).max()
        error = float(errors.max())
        rough = dict(zip(middles.tolist(), errors > tolerance, strict=True))
        order = np.argsort(np.concatenate((logs, middles)))
        logs = np.concatenate((logs, middles))[order]
        values = np.concatenate((values, new))[order]
        progress(f"{len(logs)} wavenumbers, interpolation to {error:.1e}")
        # both halves of an interval whose middle was not met are halved again
        bad = np.array([rough.get(each, False) for each in logs.tolist()])
        open_intervals = bad[:-1] | bad[1:]
        if not open_intervals.any():
            break
    return ComplianceTable(cells, np.exp(logs), values, error)


def _at_all(cells: SurfaceCells, logs: Floats) -> Floats:
    """Compliances at wavenumbers exp(logs), side by side on all cores."""
    _ = cells._reduced, cells._nodes_and_loads
    with ThreadPoolExecutor(min(n_threads(), len(logs))) as pool:
        return np.stack(list(pool.map(cells.compliance, np.exp(logs).tolist())))


def inverse_weights(wavenumbers: Floats, distances: Floats, strip: float) -> tuple[Floats, Floats]:
    """Weights of values C at wavenumbers in the integrals with cosine and sine over all wavenumbers, each (n_z, n_k).

    k C is a natural cubic spline over log k, C is constant below the least wavenumber, and falls with 1 / k above the
    largest one.
    """
    logs = np.log(wavenumbers)
    cardinal = CubicSpline(logs, np.eye(len(logs)), bc_type="natural")
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
    basis *= (dk * np.sinc(k * strip / (2.0 * np.pi)) ** 2 / np.pi)[:, None]
    phase = distances[:, None] * k
    return np.cos(phase) @ basis, np.sin(phase) @ basis
