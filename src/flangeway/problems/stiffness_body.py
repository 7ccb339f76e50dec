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
from flangeway.errors import InputError, short
from flangeway.geometry import Placement
from flangeway.geometry.arrays import IntArray, cross_product, norms, point_text
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
        return float(np.linalg.norm(np.ptp(self.nodes, axis=0)))

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


# --- Rigid motions in a stiffness matrix that another program has assembled: they strain nothing, so K r = 0.


MAX_FORCE = 1e-4
"""Force of a rigid motion on a row relative to the sum of its terms' magnitudes: above what seven printed digits
leave."""

MAX_WRONG = 0.5
"""Fraction of rows with such a force from which K does not belong to the nodes; fewer are springs to the ground."""

NEIGHBOURS = 9
"""Nodes, with the node itself, within twice whose distance a missing unknown may have been coupled to the node."""


def wrong_rows(matrix: sp.csr_array, nodes: Floats, rows: Ints, *, axisymmetric: bool) -> float:
    """Fraction of the nodes on which a rigid motion of the body makes a force; below `MAX_WRONG` that is explained.

    Forces of translations may be those of springs to the ground, or of unknowns that K is without or has decoupled:
    they count away from such unknowns, and on most nodes. Where translations make no force, nothing explains a
    rotation's: the fraction is 1.

    Parameters
    ----------
    matrix
        Symmetric stiffness K, shape (n, n).
    nodes
        Coordinates, shape (n_nodes, 2).
    rows
        Row of K of each component of each node, -1 where K is without it, shape (n_nodes, 2).
    axisymmetric
        Whether the only rigid motion is that along y.

    """
    off_diagonal = sp.csr_array(abs(matrix) - sp.diags_array(abs(matrix.diagonal())))
    decoupled = np.asarray(off_diagonal.sum(axis=1)).ravel() == 0.0
    clear = _far_from(nodes, ((rows < 0) | decoupled[rows]).any(axis=1))
    x, y = (nodes - nodes.mean(axis=0)).T
    motions = [(0.0 * x, 0.0 * x + 1.0)]
    if not axisymmetric:
        motions += [(0.0 * x + 1.0, 0.0 * x), (-y, x)]
    there = rows >= 0
    known = np.zeros(matrix.shape[0], dtype=bool)
    known[rows[there]] = True
    wrong = np.zeros(rows.shape, dtype=bool)
    for components in motions:
        motion = np.zeros(matrix.shape[0])
        motion[rows[there]] = np.column_stack(components)[there]
        if not known.all():  # unknowns inside of cells follow: K_ii r_i = -K_ib r_b
            inner = sp.csc_array(matrix[~known][:, ~known])
            motion[~known] = spsolve(inner, -(matrix[~known] @ motion))
        forces: Floats = np.abs(matrix @ motion)
        terms: Floats = abs(matrix) @ np.abs(motion)
        unequal = np.greater(forces[rows], MAX_FORCE * terms[rows]) & there
        if len(motions) == 3 and components is motions[2] and (unequal & ~wrong).any():
            return 1.0
        wrong |= unequal
    return float(np.asarray(wrong.any(axis=1))[clear].mean()) if clear.any() else 0.0


def _far_from(nodes: Floats, missing: Bools) -> Bools:
    """Nodes farther from missing ones than twice the distance of their next `NEIGHBOURS`."""
    if not missing.any():
        return ~missing
    around = cKDTree(nodes).query(nodes, k=min(NEIGHBOURS, len(nodes)))[0]
    return cKDTree(nodes[missing]).query(nodes)[0] > 2.0 * around[:, -1]


# --- A linear body of a stiffness matrix that another program has assembled.


MAX_ASYMMETRY = 1e-9
"""Difference of two entries across the diagonal, relative to the maximum entry, that rounding explains."""

MAX_EDGE_DISTANCE = 3.0
"""Distance of a node from an edge, relative to its length, within which it shows the side of the body."""

MAX_BULGE, MAX_DENT = 0.25, 0.02
"""Heights of a node outside and inside of an edge, relative to its length, that make it a node of the boundary: no
element has a node outside of its edge, and very thin ones have one that far inside."""

MIN_ONE_SIDED = 0.3
"""Length of the mean direction from a node to its neighbours on a boundary: 0.4 to 0.7 where it is straight."""


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
        Rows of K that do not move.
    thickness
        Length out of the plane over which surfaces touch.
    axisymmetric
        Whether K is that of a body of revolution about y, x the radius, with forces summed around the axis (integrals
        with ``2 pi x``); what moves nodes off the axis must be held.

    Raises
    ------
    InputError
        If the matrix is not symmetric, has another size, a diagonal that is not positive or numbers that are not
        finite; if a surface has unknown nodes, crosses or touches itself, has the body on its right, or leaves nodes
        between out, so that K does not couple those of an edge; if held rows are inside of the body and would be along
        its boundary as numbers of nodes; if K times a translation or rotation is not zero on most nodes: rows in
        another order than the coordinates. A wrong unit of
        length or of force cannot be seen in K, nor can a wrong permutation of a body of revolution. Motions without
        strain are found where the matrix is factorised.

    """

    name: str
    matrix: Any
    coordinates: ArrayLike
    surfaces: Mapping[str, ArrayLike]
    order: int = 1
    rows: ArrayLike | None = None
    held: ArrayLike = ()
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
        self._check_held()
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
        held = np.asarray(self.held)
        n = self._matrix.shape[0]
        if held.size and (held.dtype.kind not in "iu" or held.min() < 0 or held.max() >= n):
            raise InputError(
                f"{self._owner} with held={short(self.held)}",
                f"numbers of rows from 0 to {n - 1}",
                "correct them; of a mask take np.flatnonzero(mask)",
            )
        dofs = self._places.ravel()
        return (dofs >= 0) & ~np.isin(dofs, held)

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
        missing = int((self._places[: len(self.nodes)] < 0).sum())
        return f"({np.asarray(self.held).size} rows of K, and {missing} unknowns that K is without)"

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
            apart = np.linalg.norm(self.nodes[edges][:, :, None] - self.nodes[edges][:, None], axis=-1).sum(axis=-1)
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
        line = np.append(edges[:, :-1], edges[-1, -1])
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
        most = float(np.abs(matrix.data).max(initial=0.0))
        if np.abs(apart.data).max(initial=0.0) > MAX_ASYMMETRY * most:
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

    def _check_rigid_motions(self) -> None:
        dofs = self._places[: len(self.nodes)]
        wrong = wrong_rows(self._matrix, self.nodes, dofs, axisymmetric=self.axisymmetric)
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
        self._check_between(name)

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
        movable: Any = self.free[: 2 * len(self.nodes)].reshape(-1, 2).any(axis=1)
        uncoupled: Any = movable[ends].all(axis=1) & ~self._couples(*ends.T)
        if uncoupled.any():
            raise self._skipped(name, ends[int(uncoupled.argmax())], "K does not couple them")

    def _check_between(self, name: str) -> None:
        """Refuse edges with a node between: on them, or outside; K may be condensed and couple all nodes."""
        edges = self._chains[name]
        starts, chords = self.nodes[edges[:, 0]], self.nodes[edges[:, -1]] - self.nodes[edges[:, 0]]
        lengths = norms(chords)
        around = cKDTree(self.nodes).query_ball_point(starts + chords / 2.0, lengths / 2.0)
        edge, node = np.repeat(np.arange(len(edges)), [*map(len, around)]), np.concatenate(around).astype(np.int64)
        height: Any = cross_product(chords[edge], self.nodes[node] - starts[edge]) / lengths[edge] ** 2
        dent = MAX_DENT if self.order == 1 else 0.0  # a middle node shows where the edge is
        between: Any = (height >= -MAX_BULGE) & (height <= dent) & ~np.isin(node, edges)
        between &= self._couples(edges[edge, 0], node) & self._couples(edges[edge, -1], node)
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

    def _check_held(self) -> None:
        """Refuse held rows that are inside of the body and would be a part of its boundary as numbers of nodes."""
        held, n = np.unique(np.asarray(self.held, dtype=np.int64)), len(self.nodes)
        inner = ~self._on_boundary
        of_rows: Any = np.isin(self._places[:n], held).any(axis=1)
        for first in (0, 1):
            nodes = held - first
            if not held.size or nodes.min() < 0 or nodes.max() >= n or np.array_equal(nodes, np.flatnonzero(of_rows)):
                continue
            chosen = self.nodes[nodes]
            sides: Any = [self.nodes[:, i] == chosen[0, i] for i in range(2) if np.ptp(chosen[:, i]) == 0.0]
            whole_side = any(side.sum() == len(nodes) and not of_rows[side].all() for side in sides)
            if not inner[nodes].any() and (inner[of_rows].any() or (len(nodes) > 1 and whole_side)):
                raise InputError(
                    f"{self._owner}: held={short(self.held)} holds node {np.flatnonzero(of_rows)[0]} and others; as "
                    "numbers of nodes they would be along the boundary",
                    "rows of K: two for each node",
                    "of nodes that are held in x and y take held=np.concatenate((2 * nodes, 2 * nodes + 1)), or "
                    "rows[nodes].ravel()",
                )

    @cached_property
    def _on_boundary(self) -> Bools:
        """Nodes whose neighbours, those that K couples with them, are on one side of them."""
        node, other = self._coupled.nonzero()
        across = self.nodes[other] - self.nodes[node]
        directions = across / np.maximum(norms(across), np.finfo(np.float64).tiny)[:, None]
        sums = [np.bincount(node, component, len(self.nodes)) for component in directions.T]
        return np.hypot(*sums) > MIN_ONE_SIDED * (np.bincount(node, minlength=len(self.nodes)) - 1)

    def _side(self, edges: Indices) -> float:
        """Positive where the nodes nearest to a chain's edges are on its left, negative: on its right."""
        inner = np.setdiff1d(np.arange(len(self.nodes)), edges)
        starts, chords = self.nodes[edges[:, 0]], self.nodes[edges[:, -1]] - self.nodes[edges[:, 0]]
        if len(inner):
            apart, near = cKDTree(self.nodes[inner]).query(starts + chords / 2.0)
            close = apart <= MAX_EDGE_DISTANCE * np.linalg.norm(chords, axis=1)
            votes = float(np.sign(cross_product(chords, self.nodes[inner[near]] - starts))[close].sum())
            if votes != 0.0:
                return votes
        if edges[0, 0] != edges[-1, -1]:
            return 0.0
        x, y = self.nodes[edges[:, 0]].T
        around = np.allclose([np.ptp(x), np.ptp(y)], np.ptp(self.nodes, axis=0))
        return float(around) * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
