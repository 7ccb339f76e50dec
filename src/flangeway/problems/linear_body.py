"""What contact asks of a linear elastic body, wherever its stiffness comes from."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry.arrays import IntArray, point_text
from flangeway.problems.elasticity_problem import Elasticity
from flangeway.space import DifferenceProduct, Space, SymmetricMatrix
from flangeway.types import Bools, Floats, Indices


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
