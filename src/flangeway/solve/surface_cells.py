"""Rows of cells on the surface of a prism or a body of revolution, and their compliance at one wavenumber.

A contact surface is a row of cells across, each some edges of the plane mesh with a frame of its own (tangent, outward
normal, z). C(k) are the mean displacements of the cells by uniform loads on them. A wave of the number k reaches about
1/k into the body: where it is short, the mesh is cut off below the surface.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from flangeway._core import NotPositiveDefiniteError
from flangeway.elements.quadrature import edge_shapes, gauss
from flangeway.errors import InputError
from flangeway.geometry.arrays import chain_lengths
from flangeway.materials import Elastic
from flangeway.problems.harmonic import Harmonic, at_wavenumber
from flangeway.solve.linear import cholesky
from flangeway.space import InnerUnknowns, SymmetricMatrix
from flangeway.types import Bools, Floats, Ints

SAME = 1e-9
"""Length over that of a surface that is round-off."""
STRAIGHT = 1e-6
"""Angle between edges of one straight piece, in rad."""
WAVE_DEPTH = 10.0
"""Depth of a cut mesh times the wavenumber, at least: C(k) then changes by 1e-5 or less (at 5 it would be 1e-3)."""
CUTS = (1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0)
"""Depths of the cut meshes over the depth of the whole one."""
LEAST_EDGES = 8.0
"""Depth of a cut mesh over the longest edge below the cells, at least."""


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
        if not (np.diff(self.limits) > 0.0).all() or first < -SAME * length or last > (1.0 + SAME) * length:
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
        points = self.problem.elasticity.space.mesh.points
        return np.concatenate((points[self.edges[:, 0]], points[self.edges[-1:, 1]]))

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
        return np.stack([np.interp(self.limits, self._stations, each) for each in self.chain.T], axis=1)

    @cached_property
    def widths(self) -> Floats:
        """Widths of the cells along the surface, shape (n_cells,)."""
        return np.diff(self.limits)

    @property
    def middles(self) -> Floats:
        """Middles of the cells' chords, shape (n_cells, 2)."""
        return (self.ends[1:] + self.ends[:-1]) / 2.0

    @cached_property
    def frames(self) -> Floats:
        """Axes tangent, outward normal and z of the cells, rows of (n_cells, 3, 3).

        The tangent turns evenly from the middle of one straight piece of the mesh to that of the next, as that of the
        curve does which they are chords of: edges of dual polygons are straight in pairs.
        """
        angles = np.unwrap(np.angle(np.diff(self.chain, axis=0) @ np.array([1.0, 1j])))
        first = np.flatnonzero(np.abs(np.diff(angles, prepend=np.inf)) > STRAIGHT)
        bounds = np.append(self._stations[first], self._stations[-1])
        at_cells = (self.limits[1:] + self.limits[:-1]) / 2.0
        turned = np.interp(at_cells, (bounds[1:] + bounds[:-1]) / 2.0, angles[first])
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
        depths = np.empty(space.n_dofs)
        depths[: space.n_nodes] = cKDTree(space.nodes[nodes]).query(space.nodes)[0]
        for batch in space.batches():
            outer = len(batch.dofs) - batch.element.n_interior()
            depths[batch.dofs[outer:]] = depths[batch.dofs[:outer]].max(axis=0)
        unknowns = (3 * nodes[:, None] + np.arange(3)).ravel()
        rows, columns = np.nonzero(loads)
        entries = loads[rows, columns], (columns, unknowns[rows])
        border = sp.csc_array(sp.coo_array(entries, shape=(loads.shape[1], 3 * space.n_dofs)))
        whole, free = float(depths.max()), self.problem.free(1.0)
        at = [whole, *(share * whole for share in CUTS if share * whole >= LEAST_EDGES * self.longest_edge)]
        return tuple(self._cut(depth, (free & (depths <= depth)[:, None]).ravel(), border) for depth in at)

    def _cut(self, depth: float, kept: Bools, border: sp.csc_array) -> _CutMesh:
        space = self.problem.elasticity.space
        at_nodes = kept & (np.arange(len(kept)) < 3 * space.n_nodes)
        constant, linear, square = (part.restricted(at_nodes) for part in self.problem.parts)
        loads, scale = border[:, at_nodes], float(np.abs(constant.values).max())
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
        mesh = min([whole, *(each for each in cut if per_length * each.depth >= WAVE_DEPTH)], key=lambda one: one.depth)
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
        names = {each.edges for each in problem.foundations} | {name for name in held if isinstance(name, str)}
        return (
            (mesh.points, mesh.cell_offsets, mesh.cell_points, dict(mesh.cell_sets)),
            {name: mesh.edge_set(name) for name in sorted(names)},
            (problem.elasticity.space.element, problem.elasticity.material, tuple(problem.foundations), dict(held)),
            (self.edges, self.limits, WAVE_DEPTH, CUTS),
        )
