"""Parts of a boundary where contact can happen."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flangeway.checks import are_all, check_kind
from flangeway.contact.kinematics import as_complex, as_vectors
from flangeway.elements.quadrature import gauss_lobatto
from flangeway.errors import InputError, short
from flangeway.geometry import Contour
from flangeway.geometry.arrays import (
    COLLINEAR,
    ROUGH_ANGLE,
    chain_points,
    chord_depths,
    chords_of,
    cross_product,
    facet_depths,
    frozen,
    max_magnitude,
    norms,
    point_text,
    sums_at,
    turned_right,
)
from flangeway.mesh.connectivity import chain_starts, edge_places, ordered_pairs
from flangeway.problems import Body, Part
from flangeway.types import Bools, Complex, Floats, Ints

MAX_CURVE_DISTANCE = 0.25
"""Distance of a node from the surface's curve, relative to the mean edge, above which the curve is refused."""

CORNER_ANGLE = np.deg2rad(15.0)
"""Turn between edges from which they meet in a corner."""

CHORD_ANGLE = np.deg2rad(5.0)
"""Turn between edges up to which they are taken for chords of a curve where none is drawn, 72 or more to a circle: what
these overlap is allowed, what the sides of a polygon overlap is not. Of a drawn curve it is `CORNER_ANGLE`."""

PRESSING_ANGLE = np.deg2rad(30.0)
"""Angle beyond the normals of a node's edges up to which an edge presses on it: coarse chords of two curves turn by
half of it each. What presses on a smooth surface from the side is the corner beside the node."""

MAX_STRAIGHT_DISTANCE = 1e-9
"""Distance of the curve from the edges' middles, relative to the edges, below which it is straight."""


@dataclass(frozen=True, eq=False)
class Hats:
    """Hat functions on a surface, which weight the gaps: one at each end of edges, two where it turns by `ROUGH_ANGLE`.

    Parameters
    ----------
    nodes
        Position in `Surface.nodes` of each function's node, shape (n,).
    of_edge
        Functions of the two ends of each edge, shape (n_edges, 2).
    areas
        Integrals of the functions over the undeformed surface, times the thickness, shape (n,).

    """

    nodes: Ints
    of_edge: Ints
    areas: Floats


@dataclass(frozen=True, eq=False, init=False)
class Surface:
    """A chain of boundary edges of a part.

    Parameters
    ----------
    part
        The part.
    edges
        Boundary edges that make one chain: the name of an edge set, or several names, or None for the whole boundary,
        without edges that what is held prevents from moving (`LinearBody.surface_edges`); or pairs of the mesh's
        points, shape (n_edges, 2), in any order and either direction. They are stored as pairs, one after the other,
        with the body on the left.
    curve
        The drawn surface in the body's frame. The mesh's straight edges have corners where it is smooth, and corners
        show in the pressure and in the size of the gap, by h^2 / 8 R for edges of length h on a radius R. With a curve
        the gap is measured from the curve, all along the edges: the nodes are shifted onto it, and edges of order 1
        get a point of it in their middles (`bends`). Left out: the mesh's edges themselves, which are curved where the
        mesh is, at order 1 too.
    nodes_only
        Whether edges of order 1 stay straight between their nodes on the curve. It saves a third of the time of an
        iteration, and is enough where h^2 / 8 R is far below the approach of the surfaces, as on wheels and rails.
    within
        Box x_min, y_min, x_max, y_max in the body's frame: the surface has only the edges in it.

    Raises
    ------
    InputError
        If a name is unknown, no edge is in the box, a pair is not an edge of the mesh's boundary, occurs twice, the
        edges are not one chain, or the curve is not near them.

    """

    part: Part
    edges: NDArray[np.int32]
    curve: Contour | None
    nodes_only: bool

    def __init__(
        self,
        part: Part,
        edges: str | Sequence[str] | ArrayLike | None = None,
        curve: Contour | None = None,
        nodes_only: bool = False,
        *,
        within: Sequence[float] | None = None,
    ) -> None:
        """Store the chain of edges; see the class."""
        check_kind("Surface", "part", part, Part, "a Part", "write Part(name, body), or body.part")
        check_kind("Surface", "curve", curve, Contour | None, "an Outline or Polyline", "leave it out")
        for name, value in (("part", part), ("curve", curve), ("nodes_only", nodes_only)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "edges", self._chain(edges, within))
        self._refuse_far_curve()

    def _chain(self, edges: Any, within: Sequence[float] | None) -> NDArray[np.int32]:
        """Edges one after the other, the body on their left."""
        if edges is None or (are_all(edges, str) and len(edges) > 0):
            edges, _ = self.part.body.surface_edges(edges, within)
        elif within is not None:
            raise InputError(
                f"{self._name} of pairs within {short(within)}", "names with a box, or pairs", "leave one out"
            )
        edges = np.asarray(edges)
        if edges.ndim != 2 or edges.shape[1:] != (2,) or len(edges) == 0 or edges.dtype.kind not in "iu":
            raise InputError(
                f"{self._name} with edges of shape {edges.shape} and type {edges.dtype}",
                "a chain of at least one edge, pairs of point numbers, shape (n_edges, 2)",
                "take the edges from mesh.edge_sets",
            )
        chain = ordered_pairs(self._on_the_left(edges), self._name)
        starts = chain_starts(chain)
        if len(starts) > 1:
            starts_text = ", ".join(f"({x:g}, {y:g})" for x, y in self.part.body.nodes[chain[starts[:4], 0]])
            raise InputError(
                f"{self._name} of {len(starts)} chains, which start at {starts_text}",
                "one chain of edges that follow each other",
                "make one contact for each chain",
            )
        return frozen(chain.astype(np.int32))

    @property
    def _name(self) -> str:
        return f"contact surface of {self.part.name!r}"

    def _on_the_left(self, edges: NDArray[np.integer]) -> NDArray[np.int32]:
        """Edges turned so that the body is on their left."""
        body = self.part.body
        body.edge_nodes(edges)  # refuses what is no edge
        outer = body.boundary_edges
        rows, known = edge_places(edges, outer, len(body.nodes))
        if not known.all():
            a, b = edges[known.argmin()]
            raise InputError(
                f"{self._name} with the edge ({a}, {b}) near {point_text(body.nodes[a])}, which is inside the body",
                "edges of the boundary",
                "choose among mesh.boundary_edges",
            )
        return outer[rows]

    @cached_property
    def edge_nodes(self) -> NDArray[np.int32]:
        """Nodes of each edge so that the placed body lies on the left, shape (n_edges, order + 1)."""
        nodes = self.part.body.edge_nodes(self.edges)
        return nodes[::-1, ::-1] if self.part.placement.mirrored else nodes

    @cached_property
    def nodes(self) -> NDArray[np.int32]:
        """Nodes of the surface along the chain, each once, shape (n_nodes,)."""
        chain = chain_points(self.edge_nodes)
        closed = len(chain) > 1 and chain[0] == chain[-1]
        return chain[:-1] if closed else chain

    @property
    def is_closed(self) -> bool:
        """Whether the chain ends where it starts."""
        return bool(self.edge_places[-1, -1] == 0)

    @cached_property
    def edge_places(self) -> Ints:
        """Positions in `nodes` of each edge's nodes, shape (n_edges, order + 1)."""
        n_edges, width = self.edge_nodes.shape
        places = np.arange(n_edges)[:, None] * (width - 1) + np.arange(width)
        return places % len(self.nodes)

    @property
    def ends(self) -> Ints:
        """Positions in `nodes` of each edge's ends, shape (n_edges, 2)."""
        return self.edge_places[:, [0, -1]]

    @property
    def placed_nodes(self) -> Floats:
        """Nodes of the undeformed part in space, shape (n_nodes, 2)."""
        return self.part.placement.points(self.part.body.nodes[self.nodes])

    @cached_property
    def corners(self) -> Bools:
        """Which edges end at a sharp convex corner of the undeformed body where another one follows: (n_edges,)."""
        ends, turns = self.ends, turns_of(self.placed_nodes[self.ends])
        return (turns > CORNER_ANGLE) & (ends[:, 1] == np.roll(ends[:, 0], -1))

    @cached_property
    def sharp_places(self) -> Ints:
        """Positions in `nodes` of sharp convex corners of the body, those at the ends of the surface too, (n,)."""
        points, outer = self.part.body.nodes, self.part.body.boundary_edges
        into = np.full(len(points), -1)
        into[outer[:, 1]] = np.arange(len(outer))
        chords, before = chords_of(points[outer]), into[outer[:, 0]]
        turns = np.arctan2(cross_product(chords[before], chords), (chords[before] * chords).sum(axis=1))
        return np.flatnonzero(np.isin(self.nodes, outer[(turns > ROUGH_ANGLE) & (before >= 0), 0]))

    @cached_property
    def shifts(self) -> Floats:
        """From the nodes to the closest points of the curve, in the body's frame, shape (n_nodes, 2)."""
        return self._to_curve(self.part.body.nodes[self.nodes])

    @cached_property
    def bends(self) -> Complex | None:
        """Where the curve is beside the middles of edges of order 1, shape (n_edges,).

        The point of an edge from a to b is ``(a + b) / 2 + bend (b - a)``, with points as complex numbers: it moves and
        turns with its edge. None if no curve is given and the mesh is not curved, with nodes only, where the curve is
        straight, and of a higher order, whose own nodes between the ends are on the curve.
        """
        if self.nodes_only or self.edge_nodes.shape[1] > 2:
            return None
        body = self.part.body
        ends = (body.nodes[self.nodes] + self.shifts)[self.edge_places]
        middles = ends.mean(axis=1)
        if self.curve is not None:
            off = self._to_curve(middles)
        elif isinstance(body, Body) and body.mesh.curves is not None:
            off = body.mesh.edge_middles(body.mesh.edge_numbers(self.edge_nodes)) - middles
        else:
            return None
        bends = as_complex(off) / as_complex(chords_of(ends))
        return bends if np.abs(bends).max() > MAX_STRAIGHT_DISTANCE else None

    @cached_property
    def contact_places(self) -> Ints:
        """Points of each edge in contact, shape (n_edges, order + 1), or (n_edges, 3) with `bends`.

        They are numbered as positions in `nodes`, and after these the edges' middles.
        """
        if self.bends is None:
            return self.edge_places
        middles = len(self.nodes) + np.arange(len(self.edge_places))
        return np.insert(self.edge_places, 1, middles, axis=1)

    @cached_property
    def guard_places(self) -> Ints:
        """Points of each edge that may be guarded, shape (n_edges, order + 2).

        They are numbered as positions in `nodes`, and after these one point of each edge, wherever it is on the edge.
        """
        return np.insert(self.edge_places, 1, len(self.nodes) + np.arange(len(self.edge_places)), axis=1)

    @cached_property
    def undeformed_edges(self) -> Floats:
        """Points of `contact_places` of each edge of the mesh in the body's frame, shape (n_edges, order + 1, 2)."""
        edges: Floats = self.part.body.nodes[self.edge_nodes]
        if self.bends is None:
            return edges
        return np.insert(edges, 1, _bent_middles(edges, self.bends), axis=1)

    @cached_property
    def points(self) -> Floats:
        """Points of `contact_places` of the undeformed surface in the body's frame, on its curve, shape (n, 2)."""
        at_nodes: Floats = self.part.body.nodes[self.nodes] + self.shifts
        if self.bends is None:
            return at_nodes
        return np.concatenate((at_nodes, _bent_middles(at_nodes[self.edge_places], self.bends)))

    @cached_property
    def follows_curve(self) -> Bools:
        """Which edges are on the drawn curve all along, or are curved in the mesh: they are no chords, (n_edges,)."""
        if self.bends is not None or (self.curve is not None and not self.nodes_only):
            return np.ones(len(self.edge_nodes), dtype=np.bool_)
        return self.is_curved

    @property
    def curve_height(self) -> float:
        """Maximum height of the undeformed edges' inner points over the chords."""
        return max_magnitude(heights_of(self.points[self.contact_places]))

    @cached_property
    def is_curved(self) -> Bools:
        """Which edges have inner points beside their chords, shape (n_edges,)."""
        heights = np.abs(heights_of(self.points[self.contact_places])).max(axis=1, initial=0.0)
        return np.asarray(heights > MAX_STRAIGHT_DISTANCE * self.edge_lengths)

    @property
    def facet_depth(self) -> Floats:
        """Distance of each edge from a smooth curve that it may belong to, coarse ones included, shape (n_edges,)."""
        return self.facet_depths(ROUGH_ANGLE)

    def facet_depths(self, limit: float) -> Floats:
        """Distance of each edge from the smooth curve whose chords turn by less than a limit, shape (n_edges,).

        See `chord_depths`; pieces of one straight line are one chord. Zero for edges that follow a curve.
        """
        depth = np.zeros(len(self.edge_nodes))
        if not self.follows_curve.all():
            depth = facet_depths(self.part.body.nodes[self.edge_nodes[:, [0, -1]]], limit)
        depth[self.follows_curve] = 0.0
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
        apart = norms(self.shifts)
        allowed = MAX_CURVE_DISTANCE * float(self.edge_lengths.mean())
        if apart.max() > allowed:
            x, y = self.part.body.nodes[self.nodes[apart.argmax()]]
            raise InputError(
                f"{self._name} whose node at ({x:g}, {y:g}) is {apart.max():.3g} from its curve",
                f"at most {allowed:.3g}, a quarter of the mean edge",
                "give the outline that was meshed, in the body's own frame, or leave the curve out",
            )

    @cached_property
    def edge_lengths(self) -> Floats:
        """Undeformed lengths of the edges, shape (n_edges,)."""
        points = self.part.body.nodes
        return norms(chords_of(points[self.edge_nodes]))

    @cached_property
    def hats(self) -> Hats:
        """Hat functions on the edges' ends, for averages of the gap."""
        points = self.part.body.nodes
        ends = points[self.edge_nodes[:, [0, -1]]]
        starts_anew = np.abs(np.roll(turns_of(ends), 1)) > ROUGH_ANGLE
        starts_anew[0] |= not self.is_closed
        # one new function at each edge's end, one more at its start where the surface starts anew
        last = np.arange(len(ends)) + np.cumsum(starts_anew)
        first = last - 1
        if not starts_anew[0]:
            first[0] = last[-1]
        nodes = np.empty(last.max() + 1, dtype=np.int64)
        nodes[first], nodes[last] = self.edge_places[:, 0], self.edge_places[:, -1]
        halves = self.edge_lengths[:, None] / 2.0 * self._radii_at(np.array([1.0, 2.0]) / 3.0) * self.part.body.depth
        of_edge = np.stack((first, last), axis=1)
        return Hats(nodes, of_edge, sums_at(of_edge.T, halves.T, len(nodes)))

    @cached_property
    def radii(self) -> Floats | None:
        """Radius of both ends of each edge of a body of revolution, shape (n_edges, 2); None in the plane."""
        body = self.part.body
        return body.nodes[self.edge_nodes[:, [0, -1]], 0] if body.axisymmetric else None

    def _radii_at(self, parameters: Floats) -> Floats:
        """Radius at q parameters of each edge, linear along it, 1 in the plane, shape (n_edges, q)."""
        radii = np.ones((len(self.edge_nodes), 2)) if self.radii is None else self.radii
        return radii[:, :1] + (radii[:, 1:] - radii[:, :1]) * parameters

    @property
    def chord_turn(self) -> float:
        """Turn between edges up to which they are chords of a curve; edges of a curved mesh are drawn as curves too."""
        body = self.part.body
        is_drawn = self.curve is not None or (isinstance(body, Body) and body.mesh.curves is not None)
        return CORNER_ANGLE if is_drawn else CHORD_ANGLE

    def sagittas(self, edges: Floats, bent: float, exact: Bools) -> Floats:
        """How far a smooth curve may lie from deformed edges (n_edges, order + 1, 2), see `sagittas_of`: (n_edges,)."""
        drawn = self.part.placement.points(self.points)[self.contact_places]
        joints = self.edge_nodes[:, 0].astype(np.int64), self.edge_nodes[:, -1].astype(np.int64)
        return sagittas_of(drawn, edges, joints, bent, self.chord_turn, exact)

    @cached_property
    def edge_shares(self) -> Floats:
        """Part of each edge's length that belongs to each of its nodes, by quadrature weights: (n_edges, order + 1).

        In a body of revolution times its radius, which makes the integral of the node's shape function. On the axis
        that is 0 for higher orders: there the radius is that of the middle of the node's part, as an area is wanted.
        """
        abscissae, weights = gauss_lobatto(self.edge_nodes.shape[1])
        middles = np.cumsum(weights) - weights / 2.0
        radii = self._radii_at(np.array([1.0, 2.0]) / 3.0 if len(weights) == 2 else abscissae)
        return self.edge_lengths[:, None] * weights * np.where(radii > 0.0, radii, self._radii_at(middles))

    @cached_property
    def tributary_areas(self) -> Floats:
        """Area of each node, by `edge_shares` times the thickness or around the axis, shape (n_nodes,)."""
        return sums_at(self.edge_places, self.edge_shares, len(self.nodes)) * self.part.body.depth


def _bent_middles(edges: Floats, bends: Complex) -> Floats:
    """Points (n, 2) of edges by their ends (n, 2, 2) and `Surface.bends`."""
    start, end = as_complex(edges).T
    return as_vectors((start + end) / 2.0 + bends * (end - start))


def sagittas_of(
    drawn: Floats, deformed: Floats, joints: tuple[Ints, Ints], bent: float, limit: float, exact: Bools
) -> Floats:
    """Distance to which a smooth curve may leave each edge or one of its neighbours, shape (n,).

    An edge of a drawn curve turns at both ends to one side, by less than a limit; straight sides do not, and a corner
    is at one end; see `chord_depths`. What the deformation adds to the turns at both ends, and to the distance of an
    edge's inner points from its chord, is allowed up to a depth.

    Parameters
    ----------
    drawn, deformed
        Points of the edges before and after the deformation, shape (n, order + 1, 2).
    joints
        Points at which the edges start and end, each (n,): edges with a common one meet there.
    bent
        That depth.
    limit
        Turn up to which edges are chords of a curve.
    exact
        Which edges are no chords, as they are on the curve all along, (n,).

    """
    n = len(drawn)
    starting = np.argsort(joints[0], kind="stable")
    position = np.minimum(np.searchsorted(joints[0][starting], joints[1]), n - 1)
    following = starting[position]
    meets = joints[0][following] == joints[1]
    was, now = (turns_of(edges, following) for edges in (drawn[:, [0, -1]], deformed[:, [0, -1]]))
    curved = np.where(meets, was, 0.0)
    added = np.where(meets, np.abs(np.remainder(now - was + np.pi, 2.0 * np.pi) - np.pi), 0.0)
    previous = np.full(n, -1)
    previous[following[meets]] = np.flatnonzero(meets)
    first, last = previous < 0, ~meets
    added_before = np.where(first, 0.0, added[previous])
    at_start, at_end = np.where(first, 0.0, curved[previous]), curved
    # of the two halves of a chord, as on dual polygons, each has a turn at one end: that of the other half completes it
    ends = ~first & (np.abs(was[previous]) <= COLLINEAR), ~last & (np.abs(was) <= COLLINEAR)
    half = ends[0] ^ ends[1]
    at_start, at_end = (
        np.where(half & ends[0], at_start[previous], at_start),
        np.where(half & ends[1], at_end[following], at_end),
    )
    # the last edge of a chain is treated as one on the curve of the turn before
    at_start, at_end = np.where(first, at_end, at_start), np.where(last, at_start, at_end)
    lengths = norms(chords_of(deformed))
    depths = chord_depths(np.where(half, 2.0, 1.0) * lengths, at_start, at_end, limit)
    depths[exact] = 0.0
    bulge = np.abs(heights_of(deformed) - heights_of(drawn)).max(axis=1, initial=0.0)
    depths += np.minimum(np.maximum(lengths / 8.0 * (added + added_before), bulge), bent)
    result = depths.copy()
    np.maximum.at(result, following[meets], depths[meets])
    result[meets] = np.maximum(result[meets], depths[following[meets]])
    return result


def heights_of(edges: Floats) -> Floats:
    """Heights of the inner points of edges (n, order + 1, 2) over their chords, out of the body, (n, order - 1)."""
    chords = edges[:, -1:] - edges[:, :1]
    return -cross_product(chords, edges[:, 1:-1] - edges[:, :1]) / norms(chords)


def turns_of(edges: Floats, following: Ints | None = None) -> Floats:
    """Angle from each edge (n, 2, 2) to the one that follows; left out: to the next one, of the last to the first."""
    chords = chords_of(edges)
    after = np.roll(chords, -1, axis=0) if following is None else chords[following]
    return np.arctan2(cross_product(chords, after), (chords * after).sum(axis=1))


def node_normals(positions: Floats, edge_places: Ints, *, bisecting: bool = False) -> Floats:
    """Outward directions at the nodes of a chain: the sum of the normals of their edges, shape (n_nodes, 2).

    Parameters
    ----------
    positions
        Of the chain's nodes, shape (n_nodes, 2).
    edge_places
        From `Surface.edge_places`.
    bisecting
        Whether normals are of length 1, so that the sums bisect corners; else they are as long as their edges.

    """
    chord = chords_of(positions[edge_places])
    edge_normals = turned_right(chord)
    if bisecting:
        edge_normals /= norms(chord)[:, None]
    normals = np.zeros_like(positions)
    for column in edge_places.T:
        np.add.at(normals, column, edge_normals)
    return normals


def pressing_cosines(positions: Floats, edge_places: Ints) -> Floats:
    """Minimum cosine >= 0 between the direction of a node and the opposite of the normal of an edge that presses on it.

    That is the angle from the bisector to the normals of the node's two edges, and `PRESSING_ANGLE`: a node within a
    smooth surface is pressed along its normal alone, one at a corner from all of its sides. At the ends of a chain all
    edges press that face the node.

    Parameters
    ----------
    positions, edge_places
        See `node_normals`.

    Returns
    -------
    Floats
        Shape (n_nodes,).

    """
    counts, ends = (
        np.bincount(places.ravel(), minlength=len(positions)) for places in (edge_places, edge_places[:, [0, -1]])
    )
    # the sum of two unit normals is twice the cosine of half of the angle between them
    half = np.minimum(norms(node_normals(positions, edge_places, bisecting=True)) / np.maximum(counts, 1), 1.0)
    cosines = half * np.cos(PRESSING_ANGLE) - np.sqrt(1.0 - half**2) * np.sin(PRESSING_ANGLE)
    return np.where(ends == 1, 0.0, np.maximum(cosines, 0.0))
