"""Compliance of a surface in three dimensions: plane problems at many wavenumbers, summed; and its cells."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, product

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from flangeway._core import NotPositiveDefiniteError, n_threads
from flangeway.elements.quadrature import edge_shapes, gauss
from flangeway.errors import InputError
from flangeway.exact import half_space_blocks
from flangeway.geometry.arrays import (
    chain_lengths,
    chain_points,
    components_of,
    longest_step,
    max_magnitude,
    middles_of,
    vectors_at,
)
from flangeway.materials import Elastic
from flangeway.problems.harmonic import Harmonic, at_wavenumber
from flangeway.solve.linear import cholesky
from flangeway.space import InnerUnknowns, Space, SymmetricMatrix
from flangeway.system.disk_cache import Arrays, Cache, cached
from flangeway.system.memory_limits import memory_left, refuse_beyond_memory
from flangeway.types import Bools, Floats, Ints, Progress

# --- Influence among cells of a surface, as if there were half-spaces between each two of them.


def half_spaces_on(
    materials: Sequence[Elastic],
    bounds: Floats,
    frames: Floats | None,
    strip: float,
    n_strips: int,
    axes: Sequence[int] = (0, 1, 2),
) -> Floats:
    """Influence among cells of a curved surface, as if there were half-spaces between each two of them.

    Parameters
    ----------
    materials
        Of one body; or of two in contact: displacements of the second one less those of the first by forces on the
        second, whose cells are those of the first one.
    bounds
        Ends of the cells as lengths along the surface, rising, shape (n + 1,).
    frames
        Axes tangent, first body on the left, outward normal and z of the cells, rows of (n, 3, 3); None: the surface is
        a plane.
    strip, n_strips
        Width and number of the strips along z.
    axes
        Components of displacements and forces along the frames: 0 tangent, 1 normal, 2 z.

    Returns
    -------
    Floats
        By distance, displacement with its axis, and force with its axis: shape (n_strips, n, m, n, m) for m axes.

    """
    # for the second body, the other side of the surface, n and the angles change their signs: of equal bodies
    # displacements along n by forces along the surface are the opposite of each other
    signs = {
        (of, by): 1.0 if (of == 1) == (by == 1) else -1.0
        for of, by in product((0, 1, 2) if 2 in axes else (0, 1), repeat=2)
    }
    if len(materials) == 2 and materials[0] == materials[1]:
        signs = {pair: sign for pair, sign in signs.items() if sign > 0.0}
    flat = {
        material: half_space_blocks(material.young, material.poisson, bounds, strip, n_strips, list(signs))
        for material in dict.fromkeys(materials)
    }
    one = np.ones((len(bounds) - 1,) * 2)
    turn = {(0, 0): one, (1, 1): one, (2, 2): one}
    if frames is not None:
        # each frame is turned by half of the angle a between both from that of the plane: T E T for the first body
        tangents = frames[:, 0, :2] @ np.array([1.0, 1j])
        half = np.sqrt(tangents / tangents[:, None])  # exp(i a / 2)
        turn |= {(0, 0): half.real, (1, 1): half.real, (0, 1): half.imag, (1, 0): -half.imag}
    total = np.zeros((len(axes), len(axes), n_strips, *one.shape))
    for (row, column), sign in signs.items():
        both = flat[materials[0]][row, column]
        for other in materials[1:]:
            both = both + sign * flat[other][row, column]
        for (i, of), (j, by) in product(enumerate(axes), repeat=2):
            if (of, row) in turn and (column, by) in turn:
                total[i, j] += turn[of, row] * turn[column, by] * both
    return total.transpose(2, 3, 0, 4, 1)


# --- Rows of cells on the surface of a prism or a body of revolution, and their compliance at one wavenumber.
#
# A contact surface is a row of cells across, each some edges of the plane mesh with a frame of its own (tangent,
# outward
# normal, z). C(k) are the mean displacements of the cells by uniform loads on them. A wave of the number k reaches
# about
# 1/k into the body: where it is short, the mesh is cut off below the surface.


LENGTH_TOLERANCE = 1e-9
"""Length relative to that of a surface that is round-off."""
MAX_STRAIGHT_ANGLE = 1e-6
"""Angle between edges of one straight piece, in rad."""
WAVE_DEPTH = 10.0
"""Depth of a cut mesh times the wavenumber, at least: C(k) then changes by 1e-5 or less (at 5 it would be 1e-3)."""
CUTS = (1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0)
"""Depths of the cut meshes relative to the depth of the whole one."""
MIN_EDGES = 8.0
"""Depth of a cut mesh relative to the longest edge below the cells, at least."""


@dataclass(frozen=True, eq=False)
class _CutMesh:
    """What a factorisation at a wavenumber starts from, on the nodes down to a depth.

    Parameters
    ----------
    depth
        Largest distance of a node from the cells.
    parts
        K0, K1 and K2 of the free unknowns at nodes, each bordered: K0 by the loads P of the cells, ``[K, P; P', 0]``,
        the others by zeros. The Schur complement on the border is ``-P' K^-1 P``.
    inner
        The unknowns inside its cells.
    groups
        Number of the node of each unknown, (n,), and such numbers for the border.
    scale
        Factor of the loads in the border, which makes its entries as large as those of the stiffness.

    """

    depth: float
    parts: tuple[SymmetricMatrix, SymmetricMatrix, SymmetricMatrix]
    inner: InnerUnknowns
    groups: NDArray[np.int32]
    scale: float


def _depths(space: Space, nodes: Ints) -> Floats:
    """Distances of degrees of freedom from the nearest of some nodes, (n_dofs,); inside a cell that of its last one."""
    depths = np.empty(space.n_dofs)
    depths[: space.n_nodes] = cKDTree(space.nodes[nodes]).query(space.nodes)[0]
    for batch in space.batches():
        outer = len(batch.dofs) - batch.element.n_interior()
        depths[batch.dofs[outer:]] = depths[batch.dofs[:outer]].max(axis=0)
    return depths


def _cut_depths(depths: Floats, longest_edge: float) -> list[float]:
    """Depths of the whole mesh and of those cut below a surface with a longest edge, falling."""
    whole = float(depths.max())
    return [whole, *(share * whole for share in CUTS if share * whole >= MIN_EDGES * longest_edge)]


@dataclass(frozen=True, eq=False)
class SurfaceCells:
    """A row of cells on the surface of a prism, or of a body of revolution that does not reach its axis.

    Parameters
    ----------
    problem
        The body with its supports.
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
        if self.problem.revolution and len(self.problem.axis_nodes):
            raise InputError("surface cells of a section that reaches the axis", "a hole along it", "draw a small bore")
        first, last = self.limits[0], self.limits[-1]
        length = self._stations[-1]
        if (
            not (np.diff(self.limits) > 0.0).all()
            or first < -LENGTH_TOLERANCE * length
            or last > (1.0 + LENGTH_TOLERANCE) * length
        ):
            raise InputError(
                f"cells from {first:g} to {last:g} along a surface of the length {length:g}",
                "rising lengths within the surface",
                "take a smaller window, or more edges",
            )

    @cached_property
    def _stations(self) -> Floats:
        """Lengths at the ends of the edges, shape (n_edges + 1,)."""
        return chain_lengths(self.chain)

    @cached_property
    def chain(self) -> Floats:
        """Corners of the mesh along the edges, shape (n_edges + 1, 2)."""
        return self.problem.elasticity.space.mesh.points[chain_points(self.edges)]

    @property
    def limits(self) -> Floats:
        """Ends of the cells as lengths along the edges, shape (n_cells + 1,)."""
        return self._stations if self.bounds is None else self.bounds

    @property
    def longest_edge(self) -> float:
        """Maximum length of the mesh's edges below the cells."""
        return longest_step(self._stations, self.limits[0], self.limits[-1])

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return len(self.limits) - 1

    @cached_property
    def ends(self) -> Floats:
        """Ends of the cells, shape (n_cells + 1, 2)."""
        return vectors_at(self.limits, self._stations, self.chain)

    @cached_property
    def widths(self) -> Floats:
        """Widths of the cells along the surface, shape (n_cells,)."""
        return np.diff(self.limits)

    @property
    def middles(self) -> Floats:
        """Middles of the cells' chords, shape (n_cells, 2)."""
        return middles_of(self.ends)

    @cached_property
    def frames(self) -> Floats:
        """Axes tangent, outward normal and z of the cells, rows of (n_cells, 3, 3).

        The tangent turns evenly from the middle of one straight piece of the mesh to that of the next, as that of the
        curve does which they are chords of: edges of dual polygons are straight in pairs.
        """
        angles = np.unwrap(np.angle(np.diff(self.chain, axis=0) @ np.array([1.0, 1j])))
        first = np.flatnonzero(np.abs(np.diff(angles, prepend=np.inf)) > MAX_STRAIGHT_ANGLE)
        bounds = np.append(self._stations[first], self._stations[-1])
        at_cells = middles_of(self.limits)
        turned = np.interp(at_cells, middles_of(bounds), angles[first])
        frames = np.zeros((self.n_cells, 3, 3))
        frames[:, 0, :2] = np.stack((np.cos(turned), np.sin(turned)), axis=1)
        frames[:, 1, :2] = np.stack((np.sin(turned), -np.cos(turned)), axis=1)
        frames[:, 2, 2] = 1.0
        return frames

    @cached_property
    def nodes_and_loads(self) -> tuple[Ints, Floats]:
        """Surface nodes, and their forces by unit forces on the cells: (3 n_nodes, 3 n_cells)."""
        space = self.problem.elasticity.space
        inside = self._stations[(self._stations > self.limits[0]) & (self._stations < self.limits[-1])]
        cuts = np.unique(np.concatenate((self.limits, inside)))
        middles, lengths = middles_of(cuts), np.diff(cuts)
        edge = np.clip(np.searchsorted(self._stations, middles) - 1, 0, len(self.edges) - 1)
        cell = np.clip(np.searchsorted(self.limits, middles) - 1, 0, self.n_cells - 1)
        abscissae, weights = gauss(space.order + 1)
        # places of the Gauss points of each piece on its edge, in [0, 1]
        parameters = (cuts[:-1, None] + lengths[:, None] * abscissae - self._stations[edge, None]) / np.diff(
            self._stations
        )[edge, None]
        shapes = edge_shapes(space.order, parameters.ravel()).reshape(*parameters.shape, -1)
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
    def material(self) -> Elastic | None:
        """The isotropic material below the surface; None if it is another one, or there are several."""
        elasticity, mesh = self.problem.elasticity, self.problem.elasticity.space.mesh
        numbers = np.unique(elasticity.cell_material[mesh.edge_cells[mesh.edge_numbers(self.edges)].max(axis=1)])
        material = elasticity.materials[numbers[0]]
        return material if len(numbers) == 1 and isinstance(material, Elastic) else None

    @cached_property
    def _cut_meshes(self) -> tuple[_CutMesh, ...]:
        """The whole mesh, then those cut nearer and nearer to the cells."""
        space = self.problem.elasticity.space
        nodes, loads = self.nodes_and_loads
        depths = _depths(space, nodes)
        unknowns = components_of(nodes, 3).ravel()
        rows, columns = np.nonzero(loads)
        entries = loads[rows, columns], (columns, unknowns[rows])
        border = sp.csc_array(entries, shape=(loads.shape[1], 3 * space.n_dofs))
        free, at = self.problem.free(1.0), _cut_depths(depths, self.longest_edge)
        return tuple(self._cut(depth, (free & (depths <= depth)[:, None]).ravel(), border) for depth in at)

    def _cut(self, depth: float, kept: Bools, border: sp.csc_array) -> _CutMesh:
        space = self.problem.elasticity.space
        at_nodes = kept & (np.arange(len(kept)) < 3 * space.n_nodes)
        constant, linear, square = (part.restricted(at_nodes) for part in self.problem.parts)
        loads, scale = border[:, at_nodes], max_magnitude(constant.values)
        parts = constant.bordered(scale * loads), linear.bordered(0.0 * loads), square.bordered(0.0 * loads)
        groups = np.flatnonzero(at_nodes) // 3
        groups = np.concatenate((groups, groups[-1] + 1 + np.arange(loads.shape[0]) // 3))
        inner = InnerUnknowns.of(space, self.problem.parts, kept, parts[0])
        return _CutMesh(depth, parts, inner, groups.astype(np.int32), scale)

    def compliance(self, wavenumber: float) -> Floats:
        """Mean displacements of the cells by unit forces on them at a wavenumber, in their frames.

        Parameters
        ----------
        wavenumber
            k > 0 of a prism, the forces per length; n >= 0 of a body of revolution, the forces per radian.

        Returns
        -------
        Floats
            Amplitudes, shape (3 n_cells, 3 n_cells), symmetric; of ``cos kz`` along t and n, of ``sin kz`` along z.

        Raises
        ------
        InputError
            If the body can move without strain.

        """
        return self.compliance_and_bytes(wavenumber)[0]

    def compliance_and_bytes(self, wavenumber: float) -> tuple[Floats, int]:
        """Do the same, and say how many bytes the factorisation took."""
        whole, *cut = self._cut_meshes
        space = self.problem.elasticity.space
        per_length = wavenumber / np.max(self.problem.depth(space.nodes))
        mesh = min(
            [whole, *(mesh_cut for mesh_cut in cut if per_length * mesh_cut.depth >= WAVE_DEPTH)],
            key=lambda one: one.depth,
        )
        matrix = at_wavenumber(mesh.parts, wavenumber)
        matrix = replace(matrix, values=mesh.inner.eliminated(matrix.values, wavenumber))
        border = np.arange(matrix.n - 3 * self.n_cells, matrix.n, dtype=np.int32)
        try:
            factor = cholesky(matrix, mesh.groups, border)
        except NotPositiveDefiniteError as error:
            raise InputError(
                f"body `{self.problem.elasticity.name}` at wavenumber {wavenumber:g}: it can move without strain",
                "a body that is held, or on a foundation, along x, y and z",
                "give held=... or foundations=...",
            ) from error
        return factor.schur() / -(mesh.scale**2), factor.peak_bytes

    @property
    def content(self) -> tuple[object, ...]:
        """What determines the compliance, for `flangeway.system.disk_cache.cached`."""
        problem, mesh = self.problem, self.problem.elasticity.space.mesh
        held = problem.held or {}
        names = {foundation.edges for foundation in problem.foundations} | {
            name for name in held if isinstance(name, str)
        }
        return (
            (mesh.points, mesh.cell_offsets, mesh.cell_points, dict(mesh.cell_sets)),
            {name: mesh.edge_set(name) for name in sorted(names)},
            (problem.elasticity.space.element, problem.elasticity.material, tuple(problem.foundations), dict(held)),
            (self.edges, self.limits, WAVE_DEPTH, CUTS),
        )


# --- Compliance of a surface in three dimensions: plane problems at many wavenumbers, summed.
#
# The inverse transform over strips of a width dz gives the mean displacement of a cell by a force on a cell at the
# distance z from C(k), see `SurfaceCells`; ``w = sinc^2(k dz / 2)`` averages over both strips:
#
#     g(z) = (1 / pi) int_0^inf C(k) w(k) cos kz dk          among t and n, and z by z
#     g(z) = -+ (1 / pi) int_0^inf C(k) w(k) sin kz dk       t or n by z (-), z by t or n (+)
#
# The mesh errs in g(z) between the nearest cells only. There the part of a half-space is replaced by its closed form.


PER_DECADE = 3
"""Wavenumbers for each decade before their number is doubled where the interpolation is not good enough."""
MAX_DOUBLINGS = 4
"""Times that an interval between wavenumbers is halved at most."""
MIN_ERROR_RATIO = 8.0
"""Factor by which a cubic spline errs less with half the steps, at least (16 in the limit)."""
TAIL_FACTOR = 4.0
"""Factor on the largest wavenumber up to which C ~ 1 / k continues the table."""
MAX_PHASE = np.pi / 2.0
"""Largest phase k z of an interval of six Gauss points."""
NEAREST_CELLS = 3.0
"""Distance up to which cells are corrected, relative to the largest of strip, cells' widths and edges below them."""


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
        self, strip: float, n_strips: int, axes: Sequence[int] = (0, 1, 2), nearest: float = NEAREST_CELLS
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
        middles = middles_of(limits)
        near = (np.abs(middles[:, None] - middles) <= (1.0 + LENGTH_TOLERANCE) * reach)[:, None, :, None]
        result[: last + 1] = np.where(near, exact + growth * beyond, result[: last + 3])[: last + 1]


def compliance_table(
    cells: SurfaceCells,
    least: float,
    maximum: float,
    tolerance: float = 1e-4,
    progress: Progress = lambda _: None,
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
    content = *cells.content, *settings, PER_DECADE, MAX_DOUBLINGS, MIN_ERROR_RATIO
    table = cached(cache, lambda: _computed(cells, *settings, progress), "compliance", *content)
    return ComplianceTable(cells, table["wavenumbers"], table["values"], float(table["error"]))


def _computed(cells: SurfaceCells, least: float, maximum: float, tolerance: float, progress: Progress) -> Arrays:
    """Compliances at wavenumbers whose intervals are halved until a spline meets the middles.

    A loop of its own: the values that measure the error are those of the finer table.
    """
    count = max(int(np.ceil(PER_DECADE * np.log10(maximum / least))), 3) + 1
    size = 8 * (3 * cells.n_cells) ** 2
    refuse_beyond_memory(f"the compliance of {cells.n_cells} cells at {2 * count} wavenumbers", 6 * count * size)
    logs = np.linspace(np.log(least), np.log(maximum), count)
    values = compliances(cells, np.exp(logs))
    open_intervals = np.ones(count - 1, dtype=np.bool_)
    error = 0.0
    for stage in range(MAX_DOUBLINGS):
        middles = (logs[:-1] + logs[1:])[open_intervals] / 2.0
        new = compliances(cells, np.exp(middles))
        scaled = values * np.exp(logs)[:, None, None]
        missed = _spline(logs, scaled)(middles) - new * np.exp(middles)[:, None, None]
        errors = np.abs(missed).max(axis=(1, 2)) / np.abs(scaled).max() / MIN_ERROR_RATIO
        rough = errors > tolerance if stage < MAX_DOUBLINGS - 1 else np.zeros(len(errors), dtype=np.bool_)
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
    bounds = np.concatenate(([0.0], wavenumbers, [TAIL_FACTOR * wavenumbers[-1]]))
    reach = max(float(distances.max()), strip)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    points, lengths = [], []
    for start, end in pairwise(bounds):
        pieces = np.linspace(start, end, int(np.ceil((end - start) * reach / MAX_PHASE)) + 2)
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


def amplitudes(
    problem: Harmonic, wavenumbers: Floats, rhs: Floats, depths: Floats | None = None, cuts: Sequence[float] = (np.inf,)
) -> Iterator[Floats]:
    """Amplitudes (3 n_dofs, m) at each wavenumber, by loads (3 n_dofs, n_k, m), or (3 n_dofs, 1, m) at all of them.

    - `depths`: of the degrees of freedom below the loads, (n_dofs,), zero if left out.
    - `cuts`: depths that the mesh may be cut off at, falling, the first one of the whole mesh: below, a wave that is
      short over the depth moves nothing.
    """
    free, depths = problem.free(1.0), np.zeros(len(rhs) // 3) if depths is None else depths
    kept = {cut: (free & (depths <= cut)[:, None]).ravel() for cut in cuts}
    parts = {cut: [part.restricted(inside) for part in problem.parts] for cut, inside in kept.items()}
    groups = {cut: (np.flatnonzero(inside) // 3).astype(np.int32) for cut, inside in kept.items()}
    n_workers = n_threads()
    left = memory_left() // n_workers

    def answer(number: int) -> Floats:
        wavenumber = wavenumbers[number]
        cut = min([cuts[0], *(depth for depth in cuts if wavenumber * depth >= WAVE_DEPTH)])
        displacements = np.zeros((len(rhs), rhs.shape[2]))
        factor = cholesky(at_wavenumber(parts[cut], wavenumber), groups[cut], max_bytes=left)
        displacements[kept[cut]] = factor.solve(rhs[kept[cut], number if rhs.shape[1] > 1 else 0])
        return displacements

    with ThreadPoolExecutor(n_workers) as pool:
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
        return components_of(nodes, 3).ravel(), on_nodes


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
    for number, strip_forces in enumerate(loaded):
        unknowns, loads = strip_forces.at_waves(wavenumbers)
        rhs[unknowns, :, first + 2 * number : first + 2 * number + 2] = loads
    sums = np.zeros((len(loaded), 2, len(others), 2))
    nodes = np.concatenate([strip_forces.cells.nodes_and_loads[0] for strip_forces in loaded])
    depths = _depths(problem.elasticity.space, nodes)
    cuts = _cut_depths(depths, max(strip_forces.cells.longest_edge for strip_forces in loaded))
    by_wave = amplitudes(problem, wavenumbers, rhs, depths, cuts)
    for i, (k, displacements) in enumerate(zip(wavenumbers.tolist(), by_wave, strict=True)):
        by_others = displacements[:, :first]
        for number in range(len(loaded)):
            moved = displacements[:, first + 2 * number : first + 2 * number + 2]
            if first:
                moved = moved + by_others @ amounts[number](i, np.concatenate((moved, by_others), axis=1))
            sums[number] += np.stack((moved, k * moved))
    cosines, sines = np.moveaxis(sums.reshape(len(loaded), 2, -1, 3, 2), -1, 0)
    return list(zip(cosines, sines, strict=True))
