"""Discrete spaces: the numbering of unknowns on a mesh, and assembly."""

from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Generic

import numpy as np
from typing_extensions import TypeVar

from flangeway._core import Pattern, n_threads
from flangeway.checks import check_kind, values_at
from flangeway.elements import Element, Polyhedra, PolyhedralCells, Reconstruction, polygon_quadrature
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.errors import InputError, OutOfMemoryError, short
from flangeway.geometry.arrays import IntArray
from flangeway.mesh import PolyhedralMesh, PolyMesh, check, check_polyhedra
from flangeway.mesh.connectivity import entries_of
from flangeway.mesh.mesh_checks import check_curved_cells, items_by_cells, set_numbers
from flangeway.space.core_limits import refuse_large_assembly, refuse_many_threads
from flangeway.space.symmetric import SymmetricMatrix
from flangeway.types import Bools, Floats, Indices, Ints

Mesh = TypeVar("Mesh", PolyMesh, PolyhedralMesh, default=PolyMesh)

ENTRIES_PER_BATCH = 250_000  # 2 MB of matrices: a batch's arrays stay in cache
MAX_CELLS_PER_BATCH = 2000  # no power of two, which would put all rows into the same sets of the cache


@dataclass(frozen=True, eq=False)
class CellBatch:
    """Cells with one element and one number of vertices.

    Parameters
    ----------
    element
        Their element.
    cells
        Numbers of the cells, shape (n_cells,).
    vertices
        Vertices, counter-clockwise in the plane, shape (n_vertices, d, n_cells).
    dofs
        Unknowns of one field, shape (n_local, n_cells).
    outline
        Vertices, and where cells have curved edges the points inside the edges too, (n_vertices, order, 2, n_cells).
    polyhedra
        Geometry of cells in space.

    """

    element: Element
    cells: Ints
    vertices: Floats
    dofs: IntArray
    outline: Floats
    polyhedra: Polyhedra | None = None

    @cached_property
    def reconstruction(self) -> Reconstruction:
        """The element's polynomials on these cells."""
        return self.reconstruct()

    def reconstruct(self) -> Reconstruction:
        """The element's polynomials on these cells, computed anew: they take more memory than the cells."""
        return self.element.reconstruct(self.outline if self.polyhedra is None else self.polyhedra)

    def quadrature(self, degree: int) -> tuple[Floats, Floats]:
        """Points (n, d, n_cells) and weights (n, n_cells) that integrate polynomials of a degree, 2 of polyhedra."""
        return polygon_quadrature(self.outline, degree) if self.polyhedra is None else self.polyhedra.quadrature()

    def part(self, columns: Indices) -> "CellBatch":
        """Some of the cells, by their places in the batch (m,)."""
        dofs, outline = np.ascontiguousarray(self.dofs[:, columns]), self.outline[..., columns]
        polyhedra = None if self.polyhedra is None else self.polyhedra.part(columns)
        return CellBatch(self.element, self.cells[columns], self.vertices[..., columns], dofs, outline, polyhedra)

    @property
    def outer_dofs(self) -> IntArray:
        """Unknowns of the cells that are not inside of them, (n, n_cells)."""
        return self.dofs[: len(self.dofs) - self.element.n_interior()]

    def vector_dofs(self, n_components: int) -> IntArray:
        """Unknowns of a field with components, numbered ``n_components * dof + component``."""
        return component_dofs(self.dofs, n_components)


def component_dofs(dofs: IntArray, n_components: int) -> IntArray:
    """Unknowns (n_components n, n_cells) of a field with components, of those of one field (n, n_cells)."""
    numbers = dofs[:, None] * n_components + np.arange(n_components, dtype=np.int32)[:, None]
    return np.ascontiguousarray(numbers.reshape(-1, dofs.shape[1]))


@dataclass(frozen=True, eq=False)
class Space(Generic[Mesh]):
    """Continuous discrete functions on a mesh of polygons or, with virtual elements of order 1, of polyhedra.

    The unknowns of one field are numbered: values at the mesh's points, then ``order - 1`` Gauss-Lobatto values
    inside each edge (from its lower to its higher point), then the unknowns inside the cells.

    Parameters
    ----------
    mesh
        The mesh.
    element
        One element for all cells, or one for each named cell set, which must then cover the mesh once.
    cracks
        Names of the mesh's edge sets that are faces of closed cracks, or of bodies that touch without being joined.
        Elsewhere points that are there twice, or lie on an edge of another cell, are an error.

    Raises
    ------
    InputError
        If `flangeway.mesh.check` refuses the mesh, or the elements do not fit it.

    """

    mesh: Mesh
    element: Element | Mapping[str, Element]
    cracks: Collection[str] = ()

    def __post_init__(self) -> None:
        """Check the mesh and that elements fit it."""
        kinds = PolyMesh | PolyhedralMesh
        advice = "read or make one: triangulate, read_mesh"
        check_kind("Space", "mesh", self.mesh, kinds, "a PolyMesh or PolyhedralMesh", advice)
        if isinstance(self.mesh, PolyhedralMesh):
            check_polyhedra(self.mesh)
            self._check_spatial()
        else:
            check(self.plane_mesh, cracks=self.cracks)
        refuse_many_threads()
        orders = {element.order for element, _ in self._regions}
        if len(orders) != 1:
            raise InputError(
                f"elements of orders {sorted(orders)} in one space",
                "one order, since neighbours share the unknowns of their edge",
                "give every cell set an element of the same order",
            )
        for element, cells in self._regions:
            for n_vertices in np.unique(self.mesh.cell_sizes[cells]):
                element.check_cells(int(n_vertices))
            if self._curved[cells].any() and not element.curved:
                raise InputError(
                    f"{type(element).__name__} on cells with curved edges",
                    "Virtual(order), or Lagrange(order) on triangles",
                    "choose one of these, or take mesh.straight()",
                )
        if self._curved.any():
            check_curved_cells(self.plane_mesh, np.flatnonzero(self._curved), self.order)

    def _check_spatial(self) -> None:
        for element, _ in self._regions:
            if not element.spatial or element.order != 1:
                raise InputError(
                    f"{element} on polyhedra",
                    "Virtual(1)",
                    "take it: on tetrahedra it is the linear finite element",
                )

    @property
    def dimension(self) -> int:
        """Number of coordinates, 2 or 3."""
        return self.mesh.dimension

    @property
    def plane_mesh(self) -> PolyMesh:
        """The mesh of a space in the plane."""
        assert isinstance(self.mesh, PolyMesh)
        return self.mesh

    @cached_property
    def _polyhedra(self) -> PolyhedralCells | None:
        return PolyhedralCells.of(self.mesh) if isinstance(self.mesh, PolyhedralMesh) else None

    @cached_property
    def _curved(self) -> Bools:
        """Which cells have edges that are curved for elements of this order, (n_cells,)."""
        curved = np.zeros(self.mesh.n_cells, dtype=bool)
        if self.order > 1 and self.plane_mesh.curves is not None:
            mesh, curves = self.plane_mesh, self.plane_mesh.curves
            curved[mesh.edge_cells[mesh.edge_numbers(curves.pairs)]] = True
            # the cell outside of the boundary has the number -1, that of the last
            last = mesh.cell_edges[mesh.cell_offsets[-2] :]
            curved[-1] = (mesh.curve_rows[last] >= 0).any()
        return curved

    @cached_property
    def element_mesh(self) -> PolyMesh:
        """The mesh with the edges that elements of this order have: at order 1 all are straight."""
        return self.plane_mesh if self.order > 1 else self.plane_mesh.straight()

    @cached_property
    def _regions(self) -> tuple[tuple[Element, Ints], ...]:
        if isinstance(self.element, Element):
            return ((self.element, np.arange(self.mesh.n_cells)),)
        elements = items_by_cells(self.element)
        if not elements or not all(isinstance(element, Element) for element in elements):
            raise InputError(
                f"Space(mesh, {short(self.element)})",
                "an element, or one for each name of a cell set",
                "write Lagrange(2), Virtual(1) or {'name of the set': Virtual(1)}",
            )
        set_numbers(self.mesh, self.element, "element")
        return tuple((element, self.mesh.cell_sets[name].astype(np.int64)) for name, element in self.element.items())

    @property
    def order(self) -> int:
        """Order of the elements."""
        return self._regions[0][0].order

    @cached_property
    def _interior_offsets(self) -> Ints:
        """First interior unknown of each cell, and the total at the end."""
        counts = np.zeros(self.mesh.n_cells + 1, dtype=np.int64)
        for element, cells in self._regions:
            counts[cells + 1] = element.n_interior()
        counts[0] = self.mesh.n_points
        if self.order > 1:
            counts[0] += self.plane_mesh.n_edges * (self.order - 1)
        return np.cumsum(counts)

    @property
    def n_dofs(self) -> int:
        """Number of unknowns of one field."""
        return int(self._interior_offsets[-1])

    @property
    def n_nodes(self) -> int:
        """Unknowns of one field that are values at points: those of the mesh and of its edges."""
        return int(self._interior_offsets[0])

    @cached_property
    def nodes(self) -> Floats:
        """Points of the unknowns that are values, shape (n_nodes, d)."""
        if self.order == 1:
            return self.mesh.points
        inner, mesh = gauss_lobatto(self.order + 1)[0][1:-1], self.plane_mesh
        start, end = mesh.points[mesh.edges].swapaxes(0, 1)
        on_edges = start[:, None] + inner[:, None] * (end - start)[:, None]
        curves = mesh.curves
        if curves is not None:
            forward = curves.pairs[:, 0] < curves.pairs[:, 1]
            on_curves = curves.points(inner)
            on_curves[~forward] = on_curves[~forward, ::-1]  # Gauss-Lobatto points are symmetric
            on_edges[mesh.edge_numbers(curves.pairs)] = on_curves
        return np.concatenate((mesh.points, on_edges.reshape(-1, 2)))

    @cached_property
    def constant(self) -> Floats:
        """Unknowns (n_dofs,) of the function that is one everywhere."""
        result = np.ones(self.n_dofs)
        for batch in self.batches():
            if n_inner := batch.element.n_interior():
                inside = batch.element.interior_dofs(batch.outline, lambda points: np.ones(len(points)), 0)
                result[batch.dofs[-n_inner:]] = inside
        return result

    def boundary_dofs(self, where: str | Callable[[Floats], Bools] | None = None) -> Ints:
        """Unknowns of one field on the boundary, in rising order.

        Parameters
        ----------
        where
            Name of an edge set, in space of a face set, or a function that says of points (n, d) which it takes, (n,),
            such as ``lambda p: p[:, 0] < 1e-9``; None takes the whole boundary.

        """
        nodes = self.nodes_along(where if isinstance(where, str) else None)
        if where is None or isinstance(where, str):
            return nodes
        taken = values_at(where, self.nodes[nodes]) if callable(where) else np.empty(0)
        if taken.shape != nodes.shape or taken.dtype != bool or not taken.any():
            raise InputError(
                f"boundary_dofs({short(where)}), which takes {int(taken.sum())} of {len(nodes)} boundary points",
                "an edge set, or a function of points (n, 2) that gives a truth value for each and takes one or more",
                "write it as lambda p: p[:, 0] < 1e-9",
            )
        return nodes[taken]

    def nodes_along(self, name: str | None = None) -> Ints:
        """Nodes of an edge set or face set, of the whole boundary by default; each once, in rising order."""
        mesh = self.mesh
        if isinstance(mesh, PolyhedralMesh):
            faces = mesh.boundary_faces if name is None else mesh.face_set(name)
            return np.unique(mesh.face_points[entries_of(mesh.face_offsets, faces)[0]]).astype(np.int64)
        pairs = self.plane_mesh.boundary_edges if name is None else self.plane_mesh.edge_set(name)
        return np.unique(self.edge_nodes(pairs)).astype(np.int64)

    def edge_nodes(self, pairs: Indices) -> IntArray:
        """Nodes of edges given as directed pairs of points (n, 2): shape (n, order + 1), in direction."""
        inner = self._edge_inner(self.plane_mesh.edge_numbers(pairs), pairs[:, 0] < pairs[:, 1])
        nodes = np.concatenate((pairs[:, :1], inner, pairs[:, 1:]), axis=1)
        return nodes.astype(np.int32)

    def _edge_inner(self, edges: Indices, forward: Bools) -> IntArray:
        n_inner = self.order - 1
        position = np.arange(n_inner)
        position = np.where(forward[..., None], position, n_inner - 1 - position)
        numbers = self.mesh.n_points + edges[..., None].astype(np.int64) * n_inner + position
        return numbers.astype(np.int32)

    @property
    def locks(self) -> Bools:
        """Cells that become too stiff where their volume is nearly constant, (n_cells,); see `Element.locks`."""
        result, counts = np.zeros(self.mesh.n_cells, dtype=np.bool_), self.mesh.cell_sizes
        for element, cells in self._regions:
            for n_vertices in np.unique(counts[cells]):
                result[cells[counts[cells] == n_vertices]] = element.locks(int(n_vertices))
        return result

    def batches(self) -> Iterator[CellBatch]:
        """Cells in groups of one element and one number of vertices, in a fixed order."""
        mesh = self.mesh
        counts = mesh.cell_sizes
        for element, region in self._regions:
            for part in (region[~self._curved[region]], region[self._curved[region]]):
                for n_vertices in np.unique(counts[part]):
                    cells = part[counts[part] == n_vertices]
                    n_local = int(n_vertices) * self.order + element.n_interior()
                    step = min(MAX_CELLS_PER_BATCH, max(ENTRIES_PER_BATCH // n_local**2, 100))
                    for start in range(0, len(cells), step):
                        yield self._batch(element, int(n_vertices), cells[start : start + step])

    def batch_like(self, other: CellBatch) -> CellBatch:
        """Cells of a batch of another space on the same mesh, with the element and unknowns of this space."""
        for element, region in self._regions:
            if len(region) == self.mesh.n_cells or np.isin(other.cells, region).all():
                return self._batch(element, len(other.vertices), other.cells)
        raise InputError("two spaces in one form with different regions of elements", "one split", "use one element")

    def _batch(self, element: Element, n_vertices: int, cells: Ints) -> CellBatch:
        mesh = self.mesh
        entries = mesh.batch_places(n_vertices, cells)
        corners = mesh.cell_points[entries]
        parts = [corners]
        if self.order > 1:
            forward = corners < np.roll(corners, -1, axis=1)
            parts.append(self._edge_inner(self.plane_mesh.cell_edges[entries], forward).reshape(len(cells), -1))
        if element.n_interior():
            parts.append(self._interior_offsets[cells][:, None] + np.arange(element.n_interior()))
        dofs = np.ascontiguousarray(np.concatenate(parts, axis=1).T.astype(np.int32))
        vertices = np.ascontiguousarray(np.moveaxis(mesh.points[corners], 0, -1))
        outline = vertices
        if self._curved[cells[0]]:
            corner_dofs = dofs[: n_vertices * self.order].T
            inner = corner_dofs[:, n_vertices:].reshape(len(cells), n_vertices, -1)
            points = self.nodes[np.concatenate((corner_dofs[:, :n_vertices, None], inner), axis=2)]
            outline = np.ascontiguousarray(np.moveaxis(points, 0, -1))
        polyhedra = None if self._polyhedra is None else self._polyhedra.batch(cells, entries, vertices)
        return CellBatch(element, cells, vertices, dofs, outline, polyhedra)

    def assemble(self, cell_matrices: Callable[[CellBatch], Floats], n_components: int) -> SymmetricMatrix:
        """Add up symmetric matrices of cells.

        Parameters
        ----------
        cell_matrices
            Gives the matrices of a batch, shape (n, n, n_cells) with ``n = n_components * n_local``.
        n_components
            Components of the field.

        Returns
        -------
        SymmetricMatrix
            Of size ``n_components * n_dofs``.

        Raises
        ------
        OutOfMemoryError
            If there is too little memory for the matrices of all cells.

        """
        (matrix,) = self.assemble_each(lambda batch: (cell_matrices(batch),), n_components)
        return matrix

    def assemble_each(
        self, cell_matrices: Callable[[CellBatch], tuple[Floats, ...]], n_components: int
    ) -> tuple[SymmetricMatrix, ...]:
        """Add up several symmetric matrices of cells at once, which get one pattern; see `assemble`."""
        batches = list(self.batches())
        dofs = [batch.vector_dofs(n_components) for batch in batches]
        refuse_large_assembly(numbers.shape for numbers in dofs)

        def matrices_of(batch: CellBatch) -> tuple[Floats, ...]:
            return tuple(np.ascontiguousarray(matrix) for matrix in cell_matrices(batch))

        # NumPy releases the interpreter in its loops; those of order 1 are too short for threads to pay
        workers = 1 if self.order == 1 else min(n_threads(), len(batches))
        if workers == 1:
            matrices = [matrices_of(batch) for batch in batches]
        else:
            with ThreadPoolExecutor(workers) as pool:
                matrices = list(_begun(pool, matrices_of, batches))
        n = n_components * self.n_dofs
        pattern = Pattern(n, dofs)
        scattered = (pattern.scatter(list(values)) for values in zip(*matrices, strict=True))
        return tuple(SymmetricMatrix(n, pattern.indptr, pattern.indices, values) for values in scattered)


def _begun(
    pool: ThreadPoolExecutor, work: Callable[[CellBatch], tuple[Floats, ...]], batches: list[CellBatch]
) -> Iterator[tuple[Floats, ...]]:
    """Results to come; an error of lack of memory where threads cannot start."""
    try:
        return pool.map(work, batches)
    except RuntimeError as error:
        raise OutOfMemoryError(f"threads for the assembly: {error}") from error
