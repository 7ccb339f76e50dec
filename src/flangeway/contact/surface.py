"""Parts of a boundary where contact can happen."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flangeway.contact.boundary import sagittas_of
from flangeway.contact.edge_shapes import as_complex, as_vectors
from flangeway.contact.hats import SHARP, Hats
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.errors import InputError
from flangeway.geometry import Contour
from flangeway.geometry.arrays import point_text
from flangeway.mesh.connectivity import chain_starts, ordered_pairs
from flangeway.problems import Part
from flangeway.types import Complex, Floats

Ints = NDArray[np.int32]

FAR = 0.25
"""Distance of a node from the surface's curve, over the mean edge, above which the curve is refused."""

COLLINEAR = 1e-6
"""Turn between edges, in rad, below which they are one line."""

LONGEST = 1.5
"""Length of an edge that stands for a curve over that of the longer neighbour."""

STRAIGHT = 1e-9
"""Distance of the curve from the edges' middles, over the edges, below which it is straight."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A chain of boundary edges of a part.

    Parameters
    ----------
    part
        The part.
    edges
        Pairs of the mesh's points, shape (n_edges, 2): boundary edges that make one chain, in any order and either
        direction. They are stored one after the other with the body on the left.
    curve
        The drawn surface in the body's frame. The mesh's straight edges have corners where it is smooth, and corners
        show in the pressure and in the size of the gap, by h^2 / 8 R for edges of length h on a radius R. With a curve
        the gap is measured from the curve, all along the edges: the nodes are shifted onto it, and edges of order 1
        get a point of it in their middles (`bends`). Left out: the mesh's edges themselves.
    nodes_only
        Whether edges of order 1 stay straight between their nodes on the curve. It saves a third of the time of an
        iteration, and is enough where h^2 / 8 R is far below what the surfaces sink, as on wheels and rails.

    Raises
    ------
    InputError
        If a pair is not an edge of the mesh's boundary, is given twice, the edges are not one chain, or the curve is
        not near them.

    """

    part: Part
    edges: Ints
    curve: Contour | None = None
    nodes_only: bool = False

    def __post_init__(self) -> None:
        edges = np.asarray(self.edges)
        if edges.ndim != 2 or edges.shape[1:] != (2,) or len(edges) == 0 or edges.dtype.kind not in "iu":
            raise InputError(
                f"{self._name} with edges of shape {edges.shape} and type {edges.dtype}",
                "a chain of at least one edge, pairs of point numbers, shape (n_edges, 2)",
                "take the edges from mesh.edge_sets",
            )
        chain = ordered_pairs(self._on_the_left(edges), self._name)
        starts = chain_starts(chain)
        if len(starts) > 1:
            places = ", ".join(f"({x:g}, {y:g})" for x, y in self.part.body.mesh.points[chain[starts[:4], 0]])
            raise InputError(
                f"{self._name} of {len(starts)} chains, which start at {places}",
                "one chain of edges that follow each other",
                "make one contact for each chain",
            )
        chain = chain.astype(np.int32)
        chain.setflags(write=False)
        object.__setattr__(self, "edges", chain)
        self._refuse_far_curve()

    @property
    def _name(self) -> str:
        return f"contact surface of {self.part.name!r}"

    def _on_the_left(self, edges: NDArray[np.integer]) -> NDArray[np.int32]:
        """Edges turned so that the body is on their left."""
        mesh = self.part.body.mesh
        numbers, outer = mesh.edge_numbers(edges), mesh.boundary_edges
        keys = mesh.edge_numbers(outer)
        order = np.argsort(keys)
        places = order[np.minimum(np.searchsorted(keys, numbers, sorter=order), len(order) - 1)]
        inner = keys[places] != numbers
        if inner.any():
            a, b = edges[inner.argmax()]
            raise InputError(
                f"{self._name} with the edge ({a}, {b}) near {point_text(mesh.points[a])}, which is inside the body",
                "edges of the boundary",
                "choose among mesh.boundary_edges",
            )
        return outer[places]

    @cached_property
    def edge_nodes(self) -> Ints:
        """Nodes of each edge so that the placed body lies on the left, shape (n_edges, order + 1)."""
        nodes = self.part.body.space.edge_nodes(self.edges)
        return nodes[::-1, ::-1] if self.part.placement.mirrored else nodes

    @cached_property
    def nodes(self) -> Ints:
        """Nodes of the surface along the chain, each once, shape (n_nodes,)."""
        chain = np.concatenate((self.edge_nodes[:, :-1].ravel(), self.edge_nodes[-1:, -1]))
        closed = len(chain) > 1 and chain[0] == chain[-1]
        return chain[:-1] if closed else chain

    @cached_property
    def edge_places(self) -> NDArray[np.int64]:
        """Places in `nodes` of each edge's nodes, shape (n_edges, order + 1)."""
        n_edges, width = self.edge_nodes.shape
        places = np.arange(n_edges)[:, None] * (width - 1) + np.arange(width)
        return places % len(self.nodes)

    @cached_property
    def shifts(self) -> Floats:
        """From the nodes to the closest points of the curve, in the body's frame, shape (n_nodes, 2)."""
        return self._to_curve(self.part.body.space.nodes[self.nodes])

    @cached_property
    def bends(self) -> Complex | None:
        """Where the curve is beside the middles of edges of order 1, shape (n_edges,).

        The point of an edge from a to b is ``(a + b) / 2 + bend (b - a)``, with points as complex numbers: it moves and
        turns with its edge. None without a curve or with its nodes only, where the curve is straight, and of a higher
        order, whose own nodes between the ends are shifted onto the curve.
        """
        if self.curve is None or self.nodes_only or self.edge_nodes.shape[1] > 2:
            return None
        ends = (self.part.body.space.nodes[self.nodes] + self.shifts)[self.edge_places]
        bends = as_complex(self._to_curve(ends.mean(axis=1))) / as_complex(ends[:, 1] - ends[:, 0])
        return bends if np.abs(bends).max() > STRAIGHT else None

    @cached_property
    def contact_places(self) -> NDArray[np.int64]:
        """Places of the points that make each edge in contact, shape (n_edges, order + 1), or 3 for those with `bends`.

        They count the `nodes`, and after these the edges' middles.
        """
        if self.bends is None:
            return self.edge_places
        middles = len(self.nodes) + np.arange(len(self.edge_places))
        return np.insert(self.edge_places, 1, middles, axis=1)

    @cached_property
    def undeformed_edges(self) -> Floats:
        """Points of `contact_places` of each edge of the mesh in the body's frame, shape (n_edges, order + 1, 2)."""
        edges: Floats = self.part.body.space.nodes[self.edge_nodes]
        if self.bends is None:
            return edges
        start, end = as_complex(edges).T
        return as_vectors(np.stack((start, (start + end) / 2.0 + self.bends * (end - start), end), axis=1))

    @property
    def facet_depth(self) -> Floats:
        """Distance h^2 / 8 R of each edge from the smooth curve that it seems to stand for, shape (n_edges,).

        The curve is seen in the turns at both ends of an edge, to the same side and below that of a corner; pieces of
        one straight line count as one edge. Zero for edges that follow a drawn curve.
        """
        depth = np.zeros(len(self.edge_nodes))
        if self.curve is not None and (self.bends is not None or self.edge_nodes.shape[1] > 2):
            return depth
        ends = as_complex(self.part.body.mesh.points[self.edge_nodes[:, [0, -1]]])
        chords = ends[:, 1] - ends[:, 0]
        turns = np.angle(chords / np.roll(chords, 1))  # at the start of each edge
        if ends[0, 0] != ends[-1, 1]:
            turns[0] = np.nan
        starts = np.flatnonzero(~(np.abs(turns) < COLLINEAR))
        if len(starts) < 2:
            return depth
        line = (np.cumsum(~(np.abs(turns) < COLLINEAR)) - 1) % len(starts)
        lengths = np.bincount(line, np.abs(chords))
        # a line that is drawn as such is far longer than the edges of the arcs beside it
        lengths = np.minimum(lengths, LONGEST * np.maximum(np.roll(lengths, 1), np.roll(lengths, -1)))
        before, after = turns[starts], np.roll(turns[starts], -1)
        # a chain's first and last line have one turn each
        before, after = np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)
        smooth = (before * after > 0.0) & (np.maximum(np.abs(before), np.abs(after)) < SHARP)
        depth[:] = np.where(smooth, lengths * np.minimum(np.abs(before), np.abs(after)) / 8.0, 0.0)[line]
        return depth

    def _to_curve(self, points: Floats) -> Floats:
        """From points (n, 2) in the body's frame to the closest ones of the curve."""
        if self.curve is None:
            return np.zeros_like(points)
        numbers, parameters, _ = self.curve.closest(points)
        closest = np.empty_like(points)
        for number in np.unique(numbers):
            here = numbers == number
            closest[here] = self.curve.segments[number].point(parameters[here])
        return closest - points

    def _refuse_far_curve(self) -> None:
        apart = np.linalg.norm(self.shifts, axis=1)
        allowed = FAR * float(self.edge_lengths.mean())
        if apart.max() > allowed:
            x, y = self.part.body.space.nodes[self.nodes[apart.argmax()]]
            raise InputError(
                f"{self._name} whose node at ({x:g}, {y:g}) is {apart.max():.3g} from its curve",
                f"at most {allowed:.3g}, a quarter of the mean edge",
                "give the outline that was meshed, in the body's own frame, or leave the curve out",
            )

    @cached_property
    def edge_lengths(self) -> Floats:
        """Undeformed lengths of the edges, shape (n_edges,)."""
        points = self.part.body.mesh.points
        lengths: Floats = np.linalg.norm(points[self.edge_nodes[:, -1]] - points[self.edge_nodes[:, 0]], axis=1)
        return lengths

    @cached_property
    def hats(self) -> Hats:
        """Hat functions on the edges' ends, for averages of the gap."""
        return Hats.on(self)

    def sagittas(self, edges: Floats) -> Floats:
        """How far a smooth curve may lie from chords of the deformed edges, see `Boundary`, shape (n_edges,)."""
        drawn = self.part.placement.points(self.part.body.mesh.points[self.edge_nodes[:, [0, -1]]].reshape(-1, 2))
        joints = self.edge_nodes[:, 0].astype(np.int64), self.edge_nodes[:, -1].astype(np.int64)
        return sagittas_of(drawn.reshape(-1, 2, 2), edges, joints)

    @cached_property
    def tributary_lengths(self) -> Floats:
        """Length of surface that belongs to each node: weights of its edges, shape (n_nodes,)."""
        lengths = self.edge_lengths
        weights = gauss_lobatto(self.edge_nodes.shape[1])[1]
        total = np.zeros(len(self.nodes))
        np.add.at(total, self.edge_places, lengths[:, None] * weights)
        return total


def node_normals(positions: Floats, edge_places: NDArray[np.int64]) -> Floats:
    """Outward directions at the nodes of a chain: the mean of their edges', weighted by length.

    Parameters
    ----------
    positions
        Of the chain's nodes, shape (n_nodes, 2).
    edge_places
        From `Surface.edge_places`.

    Returns
    -------
    Floats
        Shape (n_nodes, 2), not normalised.

    """
    chord = positions[edge_places[:, -1]] - positions[edge_places[:, 0]]
    normals = np.zeros_like(positions)
    for column in edge_places.T:
        np.add.at(normals, column, np.stack((chord[:, 1], -chord[:, 0]), axis=1))
    return normals
