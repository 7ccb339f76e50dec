"""What contact asks of a linear elastic body, and a body of a stiffness matrix that another program has assembled."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from flangeway.checks import as_numbers, check_angle, check_kind, check_positive
from flangeway.elements.quadrature import edge_rule
from flangeway.errors import InputError, short
from flangeway.geometry import Placement
from flangeway.geometry.arrays import (
    IntArray,
    chain_points,
    chords_of,
    cross_product,
    diagonal,
    max_magnitude,
    norms,
    point_text,
    quotients,
    sums_at,
    turned_right,
    units_of,
)
from flangeway.mesh.connectivity import NamedEdges, edge_places
from flangeway.mesh.mesh_checks import meeting
from flangeway.problems.elasticity_problem import ON_AXIS, Elasticity
from flangeway.space import DifferenceProduct, Space, SymmetricMatrix
from flangeway.types import Bools, Floats, Indices, Ints

# --- What contact asks of a linear elastic body, wherever its stiffness comes from.


@dataclass(frozen=True, eq=False)
class RigidFreedom:
    """Rigid motions that what is held of a body leaves free; contact and loads decide them.

    Parameters
    ----------
    pivot
        Point in the body's frame about which it turns, and which slides.
    axes
        Components along which the pivot can slide, axes of the frame: ``""``, ``"x"``, ``"y"`` or ``"xy"``.
    turns
        Whether the body can turn.
    pins
        Components held besides at some nodes, by node, so that the body cannot move in its own frame: loads in
        equilibrium do not act on them.

    """

    pivot: Floats
    axes: str
    turns: bool
    pins: Mapping[int, str]

    @property
    def n_motions(self) -> int:
        """How many motions are free."""
        return len(self.axes) + self.turns


class LinearBody(ABC):
    """A linear elastic body in its own frame, in which what is held of it does not move.

    Its nodes have two unknowns each; further unknowns (inside cells) are numbered like those of nodes after the last
    one. Placing the frame in space, and moving it if what is held is a handle, costs nothing and strains nothing,
    however large the motion.

    Parameters
    ----------
    name
        Name for messages and results.
    thickness
        Length out of the plane; 1 of a body of revolution.

    """

    name: str
    thickness: float

    @property
    def axisymmetric(self) -> bool:
        """Whether the body is one of revolution about y, x the radius, and forces are summed around the axis."""
        return self.hypothesis == "axisymmetric"

    @property
    def depth(self) -> float:
        """Length out of the plane; of a body of revolution by the radius."""
        return 2.0 * np.pi if self.axisymmetric else self.thickness

    @property
    @abstractmethod
    def nodes(self) -> Floats:
        """Nodes in the body's frame, shape (n_nodes, 2)."""

    @property
    @abstractmethod
    def boundary_edges(self) -> IntArray:
        """Nodes at the start and the end of the edges that may touch, the body on their left, shape (n_edges, 2)."""

    @property
    @abstractmethod
    def edge_sets(self) -> Mapping[str, IntArray]:
        """Ends of the edges that have a name, the body on their left, by name, shape (n_edges, 2)."""

    @cached_property
    def part(self) -> "Part":
        """The body as a part of its own name, in the position in which it was drawn."""
        return Part(self.name, self)

    def surface_edges(
        self, names: str | Sequence[str] | None = None, within: Sequence[float] | None = None
    ) -> tuple[IntArray, int]:
        """Edges that may touch, pairs of nodes (n, 2), and the number of those left out, as what is held prevents it.

        An edge is left out if one of its nodes is held in both components.

        Parameters
        ----------
        names, within
            As of `flangeway.mesh.PolyMesh.edge_set`.

        Raises
        ------
        InputError
            If a name is unknown, no edge is there, or all edges are left out.

        """
        pairs = NamedEdges(self.nodes, self.boundary_edges, self.edge_sets).chosen(names, within=within)
        fixed: Bools = np.asarray(self.supported.all(axis=1))
        movable = ~fixed[self.edge_nodes(pairs)].any(axis=1)
        if not movable.any():
            raise InputError(
                f"a surface of body {self.name!r} that is held all along",
                "a surface that can move",
                "take other edges, or hold fewer of them",
            )
        return pairs[movable], int((~movable).sum())

    @abstractmethod
    def edge_nodes(self, pairs: Indices) -> IntArray:
        """Nodes of edges given by their ends (n, 2) in either direction, shape (n, order + 1); others are refused."""

    @property
    @abstractmethod
    def free(self) -> Bools:
        """Which unknowns move in the body's frame, two each of the nodes and then further ones, shape (2 n,)."""

    @property
    def supported(self) -> Bools:
        """Which components of nodes what is held prevents, shape (n_nodes, 2)."""
        return ~self.free[: 2 * len(self.nodes)].reshape(-1, 2)

    @property
    def freedom(self) -> RigidFreedom:
        """Rigid motions that what is held leaves free."""
        return RigidFreedom(np.zeros(2), "", False, {})

    @property
    @abstractmethod
    def stiffness(self) -> SymmetricMatrix:
        """Stiffness of the unknowns that move, in their order."""

    @property
    def product(self) -> SymmetricMatrix | DifferenceProduct:
        """Product with the stiffness, as accurate as it can be had."""
        return self.stiffness

    @abstractmethod
    def field(self, values: Floats) -> Floats:
        """All displacements (n_dofs, 2), those of the nodes first, from those of the unknowns that move (n_free,)."""

    @abstractmethod
    def unknowns(self, field: Floats) -> Floats:
        """Displacements of `field` in the order of the body's whole stiffness matrix."""

    @property
    @abstractmethod
    def modulus(self) -> float:
        """Largest stiffness of the material, a stress per strain."""

    @property
    @abstractmethod
    def softness(self) -> float:
        """Strain per stress in the softest direction and material: (1 - nu^2) / E in plane strain."""

    @property
    @abstractmethod
    def hypothesis(self) -> str | None:
        """Plane strain, plane stress or axisymmetric; None where it is not known."""

    @property
    @abstractmethod
    def held_by(self) -> str:
        """What is held, in words."""

    @property
    @abstractmethod
    def content(self) -> tuple[object, ...]:
        """What determines the stiffness, for `flangeway.system.disk_cache.content_key`."""

    @property
    def elasticity(self) -> Elasticity:
        """The elastic problem behind the body: an `InputError` where there is none."""
        raise InputError(
            f"the mesh and the stresses of body {self.name!r}, which was given by its stiffness matrix",
            "displacements and forces at nodes: its elements are not known here",
            "take solution.unknowns(part) and recover stresses in the program that assembled the matrix",
        )

    @property
    def space(self) -> Space:
        """Space of one displacement component; see `elasticity`."""
        return self.elasticity.space

    @property
    def size(self) -> float:
        """Diagonal of the nodes' bounding box."""
        return diagonal(self.nodes)

    @property
    def boundary_is_closed(self) -> bool:
        """Whether the boundary's edges are closed chains, which have an inside."""
        edges = self.boundary_edges
        return bool(np.array_equal(np.sort(edges[:, 0]), np.sort(edges[:, 1])))

    @property
    def free_nodes(self) -> IntArray:
        """Node of each unknown that moves, shape (n_free,): the unknowns of a node are ordered together."""
        return (np.flatnonzero(self.free) // 2).astype(np.int32)

    def named(self, number: int) -> str:
        """Words for an unknown, by its number among those that move."""
        node, component = divmod(int(np.flatnonzero(self.free)[number]), 2)
        if node >= len(self.nodes):
            return "an unknown that belongs to no node"
        return f"node {node} at {point_text(self.nodes[node])} in {'xy'[component]}"

    def free_numbers(self, nodes: Indices) -> IntArray:
        """Numbers among the unknowns that move of nodes' components, -1 for one that is held, shape (2 n_nodes,).

        Raises
        ------
        InputError
            If both components of all nodes are held: nothing could answer to a contact there.

        """
        free = self.free.reshape(-1, 2)
        if self.supported[nodes].all():
            x, y = self.nodes[nodes[0]]
            raise InputError(
                f"body {self.name!r}: a contact surface all of whose nodes are held by {self.held_by}, from "
                f"({x:g}, {y:g}) on",
                "a surface that can move",
                "take another surface, or hold the body elsewhere",
            )
        numbers = np.where(free, (np.cumsum(free) - 1).reshape(-1, 2), -1)
        return numbers[nodes].ravel().astype(np.int32)


@dataclass(frozen=True, eq=False)
class Part:
    """One instance of a body in space; a body may have several instances, mirrored too.

    Parameters
    ----------
    name
        Name for messages and results.
    body
        The body.
    placement
        Position of the body's frame; a body of revolution is only shifted along its axis.

    Raises
    ------
    InputError
        If a body of revolution is placed off its axis.

    """

    name: str
    body: LinearBody
    placement: Placement = field(default_factory=Placement)

    def __post_init__(self) -> None:
        check_kind("Part", "name", self.name, str, "a text", "name the part")
        kinds = "Body(...), or Body.from_stiffness(...)"
        check_kind("Part", "body", self.body, LinearBody, kinds, "make one of them")
        check_kind("Part", "placement", self.placement, Placement, "Placement(...)", "leave it out")
        self.check_placement("a placement", self.placement)

    def check_placement(self, what: str, placement: Placement) -> None:
        """Raise `InputError` for more than one turn, or if a placement takes a body of revolution off its axis."""
        check_angle(f"{what} of part {self.name!r}", "rotation_rad", placement.rotation_rad)
        off = placement.rotation_rad or placement.translation[0] or placement.mirrored
        if off and isinstance(self.body, LinearBody) and self.body.axisymmetric:
            raise InputError(
                f"{what} of part {self.name!r}, a body of revolution: {placement}",
                "a shift along its axis y",
                "write Placement(0.0, (0.0, y))",
            )


# --- A linear body of a stiffness matrix that another program has assembled.


MAX_ASYMMETRY = 1e-9
"""Difference of two entries across the diagonal, relative to the maximum entry, that rounding explains."""

MAX_FORCE = 1e-4
"""Force of a rigid motion on a row relative to the sum of its terms' magnitudes: above what seven printed digits
leave."""

MAX_WRONG = 0.5
"""Fraction of rows with such a force from which K does not belong to the nodes; fewer are springs to the ground."""

NEIGHBOURS = 9
"""Nodes, with the node itself, within twice whose distance a missing unknown may have been coupled to the node."""

MAX_JUMP = 0.1
"""Change of a uniform pressure, up and down from node to node: 2/3 on edges of another order, 1e-12 on those of K."""

MIN_UP_AND_DOWN = 0.9
"""Fraction of the nodes with such changes: all of them in an isotropic body with edges of another order."""

MIN_COSINE = 0.8
"""Of the angle between normals of nodes that are compared: stretches of orthotropic bodies push more on one side."""

MIN_HEIGHT, MAX_HEIGHT = -0.9, 0.3
"""Heights over an edge, inwards, relative to its length, between which a node of the boundary may have been skipped:
corners of a body down to 60 degrees, and holes of six edges."""


def _far_from(nodes: Floats, missing: Bools) -> Bools:
    """Nodes farther from missing ones than twice the distance of their next `NEIGHBOURS`."""
    if not missing.any():
        return ~missing
    around = cKDTree(nodes).query(nodes, k=min(NEIGHBOURS, len(nodes)))[0]
    return cKDTree(nodes[missing]).query(nodes)[0] > 2.0 * around[:, -1]


def _directed(edges: Any, pairs: Indices, rows: Ints) -> Any:
    """Rows of edges (m, n_nodes) from the first to the second of pairs (n, 2) of their ends, (n, n_nodes)."""
    chosen = edges[rows]
    return np.where(chosen[:, :1] == pairs[:, :1], chosen, chosen[:, ::-1])


@dataclass(frozen=True, eq=False)
class StiffnessBody(LinearBody):
    """A plane body or one of revolution, given by its stiffness matrix; stresses are not known here.

    Parameters
    ----------
    name
        Name for messages and results.
    matrix
        Symmetric stiffness K, any sparse matrix of SciPy or an array, shape (n, n), forces over displacements for the
        whole thickness. It may be without the unknowns that are held, and have more than those of nodes, such as those
        inside cells.
    coordinates
        Nodes in the body's frame, shape (n_nodes, 2).
    surfaces
        By name, the numbers of the nodes along each surface where contact can happen, the body on the left, middle
        nodes included; a closed one ends with its first node. Or its edges, shape (n_edges, order + 1), in any order
        and direction, of which the middle node may be the second or the last one. Overlap is measured on whole
        boundaries: give them closed where the mesh has them, and take the edges near the contact for a `Surface`.
    order
        Order of the elements, 1 or 2: the nodes of an edge less one.
    rows
        Row of K of the x and the y component of each node, -1 where K is without it because it is held, shape
        (n_nodes, 2). Left out: ``2 * node + component``.
    held
        Whether each component of each node does not move, shape (n_nodes, 2).
    thickness
        Length out of the plane over which surfaces touch.
    axisymmetric
        Whether K is that of a body of revolution about y, x the radius, with forces summed around the axis (integrals
        with ``2 pi x``); what moves nodes off the axis must be held.

    Raises
    ------
    InputError
        If the matrix is not symmetric, has another size, a diagonal that is not positive or numbers that are not
        finite; if a surface has unknown nodes, crosses or touches itself, has the body on its right, leaves nodes
        between out, or has edges of another order than K; if K times a translation or rotation is not zero on most
        nodes: rows in another order than the coordinates. K times a stretch that is the same everywhere shows edges:
        its forces are those of a uniform pressure. A wrong unit of length or of force cannot be seen in K, nor can a
        wrong permutation of a body of revolution. Motions without strain are found where the matrix is factorised.

    """

    name: str
    matrix: Any
    coordinates: ArrayLike
    surfaces: Mapping[str, ArrayLike]
    order: int = 1
    rows: ArrayLike | None = None
    held: ArrayLike | None = None
    thickness: float = 1.0
    axisymmetric: bool = False

    def __post_init__(self) -> None:
        check_positive(self._owner, "thickness", self.thickness, "a positive length", "take 1 for forces per length")
        if self.order not in (1, 2):
            raise InputError(
                f"{self._owner} of order {short(self.order)}", "1 or 2", "give edges of two or three nodes"
            )
        self._check_matrix()
        self._check_places()
        if self.axisymmetric:
            self._check_axis()
        if not self.surfaces or not isinstance(self.surfaces, Mapping):
            raise InputError(
                f"{self._owner} with surfaces={short(self.surfaces)}, without surfaces by name",
                "at least one, {name: nodes}",
                "name the nodes along its boundary",
            )
        self._check_rigid_motions()
        for surface in self.surfaces:
            self._check_surface(surface)

    @property
    def _owner(self) -> str:
        return f"Body.from_stiffness({self.name!r})"

    @cached_property
    def _matrix(self) -> sp.csr_array:
        try:
            matrix = sp.csr_array(self.matrix)
            kind = matrix.dtype.kind
        except (TypeError, ValueError) as reason:
            raise InputError(f"{self._owner} of {short(self.matrix)}", "a matrix", "give a SciPy matrix") from reason
        if kind not in "iuf" or len(matrix.shape) != 2 or matrix.shape[0] != matrix.shape[1]:
            raise InputError(
                f"{self._owner} of a matrix of shape {matrix.shape} and type {matrix.dtype}",
                "a square matrix of real numbers",
                "give the stiffness of all unknowns, or of those that are not held",
            )
        matrix = matrix.astype(np.float64)
        matrix.sum_duplicates()
        return matrix

    @cached_property
    def nodes(self) -> Floats:
        """See `LinearBody.nodes`."""
        nodes = as_numbers(f"{self._owner}: coordinates", self.coordinates)
        if nodes.ndim != 2 or nodes.shape[1] != 2 or not len(nodes) or not np.isfinite(nodes).all():
            raise InputError(
                f"{self._owner} with coordinates of shape {nodes.shape}, {int((~np.isfinite(nodes)).sum())} not finite",
                "finite numbers, shape (n_nodes, 2)",
                "give one row a node (transpose what has one column a node)",
            )
        return nodes

    @cached_property
    def _places(self) -> Ints:
        """Row of K of each unknown (n_dofs, 2), -1 for none; after the nodes those that belong to no node."""
        n, nodes = self._matrix.shape[0], self.nodes
        given: Any = self.rows
        if given is None and n != 2 * len(nodes):
            raise InputError(
                f"{self._owner} of a matrix of {n} rows with coordinates of {len(nodes)} nodes",
                f"{2 * len(nodes)} rows, two a node",
                "give rows=..., those of each node's components (n_nodes, 2), -1 where one is held",
            )
        dofs = np.arange(n).reshape(-1, 2) if given is None else np.asarray(given)
        used = dofs[dofs >= 0] if dofs.dtype.kind in "iu" else np.empty(0, dtype=np.int64)
        if dofs.dtype.kind not in "iu" or dofs.shape != nodes.shape or dofs.max(initial=-1) >= n:
            raise InputError(
                f"{self._owner} with rows of shape {dofs.shape}, up to {short(dofs.max(initial=-1))}",
                f"numbers of rows below {n}, or -1, shape {nodes.shape}",
                "correct the numbers",
            )
        rows, counts = np.unique(used, return_counts=True)
        if (counts > 1).any():
            row = rows[counts.argmax()]
            first, second = np.argwhere(dofs == row)[:2, 0]
            raise InputError(
                f"{self._owner} with row {row} for node {first} and node {second}", "a row a component", "correct one"
            )
        inner = np.setdiff1d(np.arange(n), rows)
        inner = np.append(inner, np.full(len(inner) % 2, -1)).reshape(-1, 2)
        return np.concatenate((dofs, inner)).astype(np.int64)

    @cached_property
    def free(self) -> Bools:
        """See `LinearBody.free`."""
        free = self._places >= 0
        if self.held is not None:
            held = np.asarray(self.held)
            if held.dtype != bool or held.shape != self.nodes.shape:
                raise InputError(
                    f"{self._owner} with held={short(self.held)}",
                    f"True for each component of a node that does not move, shape {self.nodes.shape}",
                    "numbers may be those of nodes or of rows: take held=np.isin(rows, held_rows), or "
                    "held=np.isin(np.arange(n_nodes), held_nodes)[:, None].repeat(2, axis=1)",
                )
            free[: len(held)] &= ~held
        return free.ravel()

    @cached_property
    def stiffness(self) -> SymmetricMatrix:
        """See `LinearBody.stiffness`."""
        rows = self._places.ravel()[self.free]
        return SymmetricMatrix.from_full(self._matrix[rows][:, rows])

    def field(self, values: Floats) -> Floats:
        """See `LinearBody.field`."""
        field = np.zeros(len(self.free))
        field[self.free] = values
        return field.reshape(-1, 2)

    def unknowns(self, field: Floats) -> Floats:
        """See `LinearBody.unknowns`; those that are held are zero."""
        there = self._places >= 0
        result = np.zeros(self._matrix.shape[0])
        result[self._places[there]] = field[there]
        return result

    @cached_property
    def modulus(self) -> float:
        """The maximum diagonal entry of K over the thickness, as large as the modulus of plane elements."""
        return float(self._matrix.diagonal().max()) / (
            self.depth * (self.nodes[:, 0].max() if self.axisymmetric else 1.0)
        )

    @property
    def softness(self) -> float:
        """One over `modulus`."""
        return 1.0 / self.modulus

    @property
    def hypothesis(self) -> str | None:
        """Axisymmetric, or not known."""
        return "axisymmetric" if self.axisymmetric else None

    @property
    def held_by(self) -> str:
        """See `LinearBody.held_by`."""
        return f"({int(self.supported.sum())} components of nodes, with those that K is without)"

    @property
    def content(self) -> tuple[object, ...]:
        """See `LinearBody.content`."""
        matrix = self.stiffness
        return matrix.indptr, matrix.indices, matrix.values, self._places, self.free, self.nodes

    @cached_property
    def edge_sets(self) -> dict[str, IntArray]:
        """Ends of the edges of each surface, the body on their left, shape (n_edges, 2)."""
        return {name: chain[:, [0, -1]] for name, chain in self._chains.items()}

    @cached_property
    def boundary_edges(self) -> IntArray:
        """See `LinearBody.boundary_edges`; those of all surfaces."""
        return self._edges[:, [0, -1]]

    def edge_nodes(self, pairs: Indices) -> IntArray:
        """See `LinearBody.edge_nodes`."""
        rows, known = edge_places(pairs, self.boundary_edges, len(self.nodes))
        if not known.all():
            a, b = pairs[known.argmin()]
            raise InputError(
                f"{self._owner}: the edge ({a}, {b})",
                f"an edge of one of its surfaces: {', '.join(self.surfaces)}",
                "take body.edge_sets[name], or rows of it",
            )
        return _directed(self._edges, pairs, rows)

    @cached_property
    def _chains(self) -> dict[str, IntArray]:
        """Nodes of each surface's edges, (n_edges, order + 1)."""
        return {name: self._chain(name) for name in self.surfaces}

    @cached_property
    def _edges(self) -> IntArray:
        every = np.concatenate(list(self._chains.values()))
        _, first = np.unique(every[:, [0, -1]], axis=0, return_index=True)
        return every[np.sort(first)]

    def _chain(self, name: str) -> IntArray:
        line, n = np.asarray(self.surfaces[name]), len(self.nodes)
        allowed = (
            f"at least {self.order + 1} numbers of nodes, 0 to {n - 1}, along a chain, or its edges, shape (n_edges, "
            f"{self.order + 1})"
        )
        if self.order == 2:
            allowed += "; a chain is an odd number of them with the middle nodes"
        is_line = line.ndim == 1 and len(line) > self.order and (len(line) - 1) % self.order == 0
        is_edges = line.ndim == 2 and len(line) > 0 and line.shape[1] == self.order + 1
        if not (is_line or is_edges) or line.dtype.kind not in "iu":
            raise InputError(
                f"{self._owner} with surface {name!r} of shape {line.shape} and type {line.dtype}",
                allowed,
                "correct it",
            )
        if line.min() < 0 or line.max() >= n:
            wrong = line[(line < 0) | (line >= n)][0]
            raise InputError(f"{self._owner}: surface {name!r} has node {wrong}", allowed, "count nodes from 0")
        if is_edges:
            line = self._joined(name, line)
        inner = line[:-1] if line[0] == line[-1] else line
        nodes, counts = np.unique(inner, return_counts=True)
        if (counts > 1).any():
            node = nodes[counts.argmax()]
            raise InputError(
                f"{self._owner}: surface {name!r} passes node {node} at {point_text(self.nodes[node])} twice",
                "each node once; the last may be the first one of a closed surface",
                "give two surfaces, or remove the node",
            )
        starts = np.arange(0, len(line) - 1, self.order)
        return line[starts[:, None] + np.arange(self.order + 1)].astype(np.int32)

    def _joined(self, name: str, edges: Ints) -> Ints:
        """Nodes along the chain that edges (n_edges, order + 1) make, with the body on the left."""
        if self.order == 2:
            apart = norms(self.nodes[edges][:, :, None] - self.nodes[edges][:, None]).sum(axis=-1)
            around = (apart.argmin(axis=1)[:, None] + np.arange(-1, 2)) % 3
            edges = np.take_along_axis(edges, around, axis=1)
        ends, numbers, counts = np.unique(edges[:, [0, -1]], return_inverse=True, return_counts=True)
        links = sp.coo_array((np.ones(len(edges)), numbers.reshape(-1, 2).T), shape=(len(ends), len(ends)))
        first = int(counts.argmin())  # a loose end, if there is one
        chain = ends[sp.csgraph.depth_first_order(sp.csr_array(links), first, False, False)]
        if counts.max() > 2 or len(chain) < len(ends):
            what, node = ("branch", ends[counts.argmax()]) if counts.max() > 2 else ("have a gap", chain[-1])
            raise InputError(
                f"{self._owner}: the edges of surface {name!r} {what} at node {node} at {point_text(self.nodes[node])}",
                "one chain of edges that follow each other",
                "give each edge once, and a surface for each chain",
            )
        chain = chain if counts.min() == 1 else np.append(chain, chain[0])
        pairs = np.column_stack((chain[:-1], chain[1:]))
        edges = _directed(edges, pairs, edge_places(pairs, edges[:, [0, -1]], len(self.nodes))[0])
        line = chain_points(edges)
        return line[::-1] if self._side(edges) < 0.0 else line

    def _check_matrix(self) -> None:
        matrix = self._matrix
        if not np.isfinite(matrix.data).all():
            at = int(np.argmin(np.isfinite(matrix.data)))
            row = int(np.searchsorted(matrix.indptr, at, side="right")) - 1
            raise InputError(
                f"{self._owner}: K[{row}, {matrix.indices[at]}] is {matrix.data[at]}", "finite numbers", "correct it"
            )
        apart = sp.coo_array(matrix - matrix.T)
        most = max_magnitude(matrix.data)
        if max_magnitude(apart.data) > MAX_ASYMMETRY * most:
            i, j = (int(indices[np.abs(apart.data).argmax()]) for indices in apart.coords)
            raise InputError(
                f"{self._owner}: K[{i}, {j}] is {matrix[i, j]:.6g} and K[{j}, {i}] is {matrix[j, i]:.6g}",
                "a symmetric matrix: each work of a force on another's displacement is mutual",
                "give both triangles (T + T.T less the diagonal, of one triangle T), and the stiffness before rows are "
                "changed for supports, with held=...",
            )

    def _check_places(self) -> None:
        rows = self._places.ravel()[self.free]
        diagonal = self._matrix.diagonal()[rows]
        if len(rows) == 0:
            raise InputError(f"{self._owner}: all unknowns are held", "some that move", "hold less of the body")
        if diagonal.min() <= 0.0:
            number = int(diagonal.argmin())
            raise InputError(
                f"{self._owner}: K[{rows[number]}, {rows[number]}] is {diagonal[number]:.6g}, of {self.named(number)}",
                "a positive definite matrix of the unknowns that are not held",
                "a multiplier or an unknown without stiffness is no displacement: eliminate it, or hold it",
            )

    @cached_property
    def _tested(self) -> tuple[float, Bools, Floats]:
        """Forces of motions whose forces are known: rigid ones have none, x -> x + c x those of a uniform pressure.

        A homogeneous isotropic body under the same pressure on its whole boundary has the strain of that stretch, so
        that K x = p ∫ N n ds.

        Returns
        -------
        wrong
            Fraction of the nodes on which a rigid motion makes a force; below `MAX_WRONG` that is explained. Forces of
            translations may be those of springs to the ground, or of unknowns that K is without or has decoupled: they
            count away from such unknowns. Where translations make no force, nothing explains a rotation's: 1.
        clear
            Nodes whose rows are there, and on which rigid motions make no force, (n_nodes,).
        pressures
            Forces of a uniform pressure on the nodes, (n_nodes, 2), right where `clear`.

        """
        matrix, nodes = self._matrix, self.nodes
        rows = self._places[: len(nodes)]
        off_diagonal = sp.csr_array(abs(matrix) - sp.diags_array(abs(matrix.diagonal())))
        decoupled = np.asarray(off_diagonal.sum(axis=1)).ravel() == 0.0
        there = rows >= 0
        clear = _far_from(nodes, (~there | decoupled[rows]).any(axis=1))
        x, y = (nodes - nodes.mean(axis=0)).T
        one, zero = np.ones(len(x)), np.zeros(len(x))
        rigid = [(zero, one)] if self.axisymmetric else [(zero, one), (one, zero), (-y, x)]
        # (n_nodes, 2, motions)
        fields = np.transpose([*rigid, (nodes[:, 0] if self.axisymmetric else x, y)], (2, 1, 0))
        motions = np.zeros((matrix.shape[0], fields.shape[2]))
        motions[rows[there]] = fields[there]
        inner = self._places[len(nodes) :]
        inner = inner[inner >= 0]
        if len(inner):  # unknowns inside of cells follow: K_ii r_i = -K_ib r_b
            system = sp.csc_array(matrix[inner][:, inner])
            motions[inner] = spsolve(system, -(matrix[inner] @ motions)).reshape(len(inner), -1)
        forces: Floats = (matrix @ motions)[rows]
        terms: Floats = (abs(matrix) @ np.abs(motions))[rows]
        ratios = quotients(np.abs(forces), terms)
        loaded: Any = (ratios > MAX_FORCE)[:, :, :-1] & there[:, :, None]
        if len(rigid) == 3 and (loaded[:, :, 2] & (ratios[:, :, :2] < 0.01 * MAX_FORCE).all(axis=2)).any():
            return 1.0, clear, forces[:, :, -1]
        wrong = loaded.any(axis=(1, 2))
        return float(wrong[clear].mean()) if clear.any() else 0.0, there.all(axis=1) & clear & ~wrong, forces[:, :, -1]

    def _check_rigid_motions(self) -> None:
        wrong = self._tested[0]
        if wrong > MAX_WRONG:
            raise InputError(
                f"{self._owner}: a rigid motion of the body makes forces on {100.0 * wrong:.0f} % of the nodes",
                "a stiffness K that belongs to these coordinates and rows: K times a rigid motion is zero",
                "compare the orders of K and the coordinates: where all x components come first, give "
                "rows=np.arange(n).reshape(2, -1).T; x and y may be swapped, nodes permuted or counted from 1",
            )

    def _check_axis(self) -> None:
        loose = (self.nodes[:, 0] <= ON_AXIS * self.size) & ~self.supported[:, 0]
        if self.thickness != 1.0 or self.nodes[:, 0].min() < -ON_AXIS * self.size or loose.any():
            least = f"radii from {self.nodes[:, 0].min():g}"
            raise InputError(
                f"{self._owner} of revolution with thickness {self.thickness:g}, {least}, and {int(loose.sum())} nodes "
                "on the axis that can leave it",
                "thickness 1, radii x >= 0, and held x components of nodes on the axis",
                "hold their rows with held=...",
            )

    def _check_surface(self, name: str) -> None:
        edges = self._chains[name]
        pairs = np.stack((edges[:, :-1], edges[:, 1:]), axis=2).reshape(-1, 2)
        touching = meeting(self.nodes, pairs)
        if len(touching.crossing) or len(touching.on):
            a, b = pairs[touching.crossing[0] if len(touching.crossing) else [touching.on[0], touching.of[0]]]
            raise InputError(
                f"{self._owner}: surface {name!r} {'crosses' if len(touching.crossing) else 'touches'} itself with the "
                f"edges ({a[0]}, {a[1]}) and ({b[0]}, {b[1]}) near {point_text(self.nodes[a[0]])}",
                "a line along the boundary that passes each place once",
                "put its nodes in their order along the boundary",
            )
        self._check_coupled(name)
        if self._side(edges) < 0.0:
            raise InputError(
                f"{self._owner}: surface {name!r} has the body on its right",
                "nodes in the order in which the body is on the left, counter-clockwise around the outside",
                f"turn it: surfaces={{{name!r}: nodes[::-1]}}",
            )
        self._check_pressure(name)

    @cached_property
    def _coupled(self) -> sp.csr_array:
        """Nodes that K couples, not zero there and on the diagonal, (n_nodes, n_nodes)."""
        node, component = np.nonzero(self._places[: len(self.nodes)] >= 0)
        entries = np.ones(len(node)), (self._places[node, component], node)
        of_node = sp.csr_array(entries, shape=(self._matrix.shape[0], len(self.nodes)))
        return of_node.T @ (self._matrix != 0.0) @ of_node

    def _check_coupled(self, name: str) -> None:
        """Refuse edges that no element has, whose ends K does not couple."""
        ends = self._chains[name][:, [0, -1]]
        movable: Any = ~self.supported.all(axis=1)
        uncoupled: Any = movable[ends].all(axis=1) & ~self._couples(*ends.T)
        if uncoupled.any():
            raise self._skipped(name, ends[int(uncoupled.argmax())], "K does not couple them")

    def _areas(self, edges: Indices) -> Floats:
        """Integrals of shape function and outward normal along edges at their nodes, (n_nodes, 2)."""
        weights, shapes, slopes = edge_rule(self.order, 3)
        points = self.nodes[edges]  # (e, i, 2)
        tangents = np.einsum("qi,eic->qec", slopes, points)
        radii = np.einsum("qi,ei->qe", shapes, points[:, :, 0]) if self.axisymmetric else np.ones(tangents.shape[:2])
        along = np.einsum("q,qi,qe,qec->eic", weights, shapes, radii, tangents)
        return sums_at(edges, turned_right(along), len(self.nodes))

    def _check_pressure(self, name: str) -> None:
        """Refuse edges on which K has not the forces of a uniform pressure, and edges that leave out a loaded node."""
        edges = self._chains[name]
        _, clear, forces = self._tested
        areas, line = self._areas(edges), chain_points(edges)[1:-1]
        line = line[areas[line].any(axis=1)]  # without an edge along the axis of revolution
        normals = units_of(areas[line])
        pressures = (forces[line] * normals).sum(axis=1) / norms(areas[line])
        sums = np.abs(pressures[1:]) + np.abs(pressures[:-1])
        jumps = quotients(2.0 * np.diff(pressures), sums)
        up_and_down = (jumps[1:] * jumps[:-1] < 0.0) & (np.minimum(abs(jumps[1:]), abs(jumps[:-1])) > MAX_JUMP)
        known = clear[line]
        known[1:] &= (normals[1:] * normals[:-1]).sum(axis=1) > MIN_COSINE
        known = known[2:] & known[1:-1] & clear[line[:-2]]
        if known.any() and up_and_down[known].mean() > MIN_UP_AND_DOWN:
            raise InputError(
                f"{self._owner}: surface {name!r} with edges of order {self.order}, on which K has not the forces of a "
                f"uniform pressure: from node to node they go up and down by {np.abs(jumps[1:][known]).max():.0%}",
                "edges of the elements of K: order=2 with the middle nodes of quadratic ones, order=1 for linear ones",
                "give the order of the elements, and begin at the corner of one",
            )
        starts, chords = self.nodes[edges[:, 0]], chords_of(self.nodes[edges])
        lengths = norms(chords)
        around = cKDTree(self.nodes).query_ball_point(starts + chords / 2.0, lengths)
        edge, node = np.repeat(np.arange(len(edges)), [*map(len, around)]), np.concatenate(around).astype(np.int64)
        offsets, chord = self.nodes[node] - starts[edge], chords[edge] / lengths[edge, None] ** 2
        height, place = cross_product(chord, offsets), (chord * offsets).sum(axis=1)
        highest = MAX_HEIGHT if self.order == 1 else 0.0  # a middle node shows where the edge is
        between: Any = (height > MIN_HEIGHT) & (height < highest) & (place > 0.0) & (place < 1.0)
        between &= ~np.isin(node, edges) & clear[node] & clear[edges[edge]].all(axis=1)
        between &= self._couples(edges[edge, 0], node) & self._couples(edges[edge, -1], node)
        # a node of the boundary has the force of its own edges, outwards as those of the ends
        outward = np.sign(pressures.sum() or 1.0) * cross_product(forces[node], chord) * lengths[edge]
        ends = norms(forces[edges[:, [0, -1]]].reshape(-1, 2)).reshape(-1, 2).mean(axis=1)[edge]
        between &= (outward > 0.5 * norms(forces[node])) & (outward > 0.4 * ends) & (outward < 2.5 * ends)
        if between.any():
            at = int(between.argmax())
            raise self._skipped(name, edges[edge[at], [0, -1]], f"node {node[at]} is between them")

    def _couples(self, first: Indices, second: Indices) -> Bools:
        """Whether K couples pairs of nodes."""
        return np.asarray(self._coupled[first, second]).ravel() != 0

    def _skipped(self, name: str, pair: Indices, reason: str) -> InputError:
        a, b = pair
        return InputError(
            f"{self._owner}: surface {name!r} goes from node {a} at {point_text(self.nodes[a])} to node {b} at "
            f"{point_text(self.nodes[b])}, which are no edge of an element: {reason}",
            "all nodes along the boundary in their order, middle nodes of quadratic elements too, with order=2",
            "add the nodes between",
        )

    def _side(self, edges: Indices) -> float:
        """Positive where the body is on a chain's left, negative: on its right.

        A pressure acts along the outward normal. Where its forces are not known, nodes of the same elements count.
        """
        _, clear, forces = self._tested
        pushed = (forces * self._areas(edges)).sum(axis=1)[clear].sum()
        if pushed != 0.0:
            return float(pushed)
        first, last = edges[:, 0], edges[:, -1]
        edge, node = (self._coupled[first] * self._coupled[last]).nonzero()  # of the elements of edges
        starts, chords = self.nodes[first[edge]], self.nodes[last[edge]] - self.nodes[first[edge]]
        votes = float(np.sign(cross_product(chords, self.nodes[node] - starts))[~np.isin(node, edges)].sum())
        if votes != 0.0:
            return votes
        if edges[0, 0] != edges[-1, -1]:
            return 0.0
        x, y = self.nodes[edges[:, 0]].T
        around = np.allclose([np.ptp(x), np.ptp(y)], np.ptp(self.nodes, axis=0))
        return float(around) * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
