"""Pieces of the secondary surface that face one primary edge, and the integrals of the gap over them.

The gap at a secondary point is measured along the secondary's own normal: it is continuous over the primary's corners,
where the closest point would jump. Integrals are over the undeformed length of the secondary, whose edges are straight,
so that pressure on an open or penetrated gap does no work on the surface's stretching. Their derivatives are exact,
those of the pieces' ends included: the sum over the pieces is invariant to rigid motions, so forces balance to
round-off.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flangeway.contact.jets import Jet
from flangeway.contact.kinematics import closest_parameters
from flangeway.contact.shape import shape_functions
from flangeway.contact.straight import straight_integrals
from flangeway.elements.quadrature import gauss

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

SNAP = 1e-8  # parts of an edge within which the ends of two pieces are one
FAR = 0.5  # parts of an edge beyond its ends where a foot on its chord is not one on the edge itself
LEAST_FACING = 0.2  # cosine between the normals of two edges above which they do not face each other


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of secondary edges between nodes and feet of primary nodes; p of them.

    Parameters
    ----------
    edges, partners
        Secondary and primary edge, each of shape (p,).
    starts, ends
        Parameters of the piece on the secondary edge, shape (p,).
    start_is_foot, end_is_foot
        Whether that is the foot of a node of the primary edge (else an end of the secondary edge), shape (p,).

    """

    edges: Ints
    partners: Ints
    starts: Floats
    ends: Floats
    start_is_foot: Bools
    end_is_foot: Bools

    def __len__(self) -> int:
        """Return the number of pieces."""
        return len(self.edges)

    def take(self, chosen: Ints | Bools) -> "Pieces":
        """Some of the pieces."""
        return Pieces(
            self.edges[chosen], self.partners[chosen], self.starts[chosen], self.ends[chosen],
            self.start_is_foot[chosen], self.end_is_foot[chosen],
        )  # fmt: skip


def find_pieces(
    secondary: Floats, primary: Floats, candidates: tuple[Ints, Ints], reach: float, depth: float
) -> Pieces:
    """Cut secondary edges at the feet of the primary edges' ends.

    Parameters
    ----------
    secondary, primary
        Current positions of the edges' nodes, their bodies on the left, shapes (n, order + 1, 2).
    candidates
        Secondary and primary edges that may face each other, each of shape (c,).
    reach, depth
        Largest gap and largest penetration along the secondary's normal at the middle of a piece.

    """
    if secondary.shape[1] == primary.shape[1] == 2:
        return _straight_pieces(secondary, primary, candidates, (-depth, reach))
    edges, partners = candidates
    chords = [side[:, -1] - side[:, 0] for side in (secondary, primary)]
    units = [chord / np.linalg.norm(chord, axis=1)[:, None] for chord in chords]
    facing = np.einsum("ci,ci->c", units[0][edges], units[1][partners]) < -LEAST_FACING
    edges, partners = edges[facing], partners[facing]
    # the two sides run against each other; curved edges are near enough to their chords to leave out what is far
    low, high = (closest_parameters(primary[partners, end], secondary[edges][:, [0, -1]]) for end in (-1, 0))
    over = (high > -FAR) & (low < 1.0 + FAR)
    edges, partners = edges[over], partners[over]
    low = closest_parameters(primary[partners, -1], secondary[edges])
    high = closest_parameters(primary[partners, 0], secondary[edges])
    start_is_foot, end_is_foot = low > SNAP, high < 1.0 - SNAP
    starts, ends = np.where(start_is_foot, low, 0.0), np.where(end_is_foot, high, 1.0)
    pieces = Pieces(edges, partners, starts, ends, start_is_foot, end_is_foot).take(ends - starts > SNAP)
    middle = (pieces.starts + pieces.ends) / 2.0
    distance = _distances(secondary[pieces.edges], primary[pieces.partners], middle)
    return pieces.take((distance < reach) & (distance > -depth))


def _straight_pieces(
    secondary: Floats, primary: Floats, candidates: tuple[Ints, Ints], limits: tuple[float, float]
) -> Pieces:
    """`find_pieces` between straight edges, whose gaps along the secondary's normal are linear."""
    edges, partners = candidates
    chords, others = secondary[:, 1] - secondary[:, 0], primary[:, 1] - primary[:, 0]
    (cx, cy), (dx, dy) = chords[edges].T, others[partners].T
    squares = cx * cx + cy * cy
    along = cx * dx + cy * dy
    near = along < -LEAST_FACING * np.sqrt(squares * (dx * dx + dy * dy))
    ax, ay = (primary[partners, 0] - secondary[edges, 0]).T
    high = (ax * cx + ay * cy) / squares  # feet of the primary's start and end
    low = high + along / squares
    near &= (high > -FAR) & (low < 1.0 + FAR)
    start_is_foot, end_is_foot = low > SNAP, high < 1.0 - SNAP
    starts, ends = np.where(start_is_foot, low, 0.0), np.where(end_is_foot, high, 1.0)
    near &= ends - starts > SNAP
    with np.errstate(divide="ignore", invalid="ignore"):  # of edges that do not face each other
        part = ((starts + ends) / 2.0 - high) * squares / along
        distance = (ax * cy - ay * cx + part * (dx * cy - dy * cx)) / np.sqrt(squares)
        near &= (distance > limits[0]) & (distance < limits[1])
    return Pieces(edges, partners, starts, ends, start_is_foot, end_is_foot).take(np.flatnonzero(near))


@dataclass(frozen=True, eq=False)
class PieceIntegrals:
    """Integrals over pieces with the two hat functions of each piece's edge, linear between its ends.

    Parameters
    ----------
    gaps
        ``int phi_r g ds``, a jet of shape (p,) for r = 0 and 1, over the undeformed length.
    lengths
        ``int phi_r ds``, shape (p, 2).
    primary_shapes
        ``int phi_r N_a ds`` with the primary edge's functions at the opposite point, shape (p, 2, order + 1).

    """

    gaps: tuple[Jet, Jet]
    lengths: Floats
    primary_shapes: Floats


def integrate(
    pieces: Pieces, secondary: Floats, primary: Floats, edge_lengths: Floats, *, second: bool
) -> PieceIntegrals:
    """Integrate the gap over pieces.

    Parameters
    ----------
    pieces
        From `find_pieces`.
    secondary, primary
        Current positions of each piece's edges' nodes, shapes (p, order + 1, 2).
    edge_lengths
        Undeformed length of each piece's secondary edge, shape (p,).
    second
        Whether second derivatives are wanted. The variables are the components of the secondary edge's nodes, then of
        the primary's.

    """
    if not second and secondary.shape[1] == primary.shape[1] == 2:
        limits, feet = (pieces.starts, pieces.ends), (pieces.start_is_foot, pieces.end_is_foot)
        values, gradients, covered, shapes = straight_integrals(limits, feet, secondary, primary, edge_lengths)
        jets = Jet(values[0], gradients[0], None), Jet(values[1], gradients[1], None)
        return PieceIntegrals(jets, covered.T, shapes.swapaxes(0, 1))
    n, n_variables = len(pieces), 2 * (secondary.shape[1] + primary.shape[1])
    own, other = _Edge(secondary, 0), _Edge(primary, 2 * secondary.shape[1])
    points, weights = gauss(max(own.order, other.order) + 1)

    rest = Jet.constant(pieces.starts, n_variables, second=second)
    start = _foot(own, rest, other, -1).masked(pieces.start_is_foot)
    end = _foot(own, replace(rest, value=pieces.ends), other, 0).masked(pieces.end_is_foot)
    width = end - start
    xi = start.along_points() + width.along_points() * np.broadcast_to(points, (n, len(points)))
    at = _point(own, xi)
    tangent = _point(own, xi, derivative=1)
    eta = _opposite(other, at, tangent)
    apart = [there - here for there, here in zip(_point(other, eta), at, strict=True)]
    stretch = (tangent[0] * tangent[0] + tangent[1] * tangent[1]).sqrt()
    gap = (apart[0] * tangent[1] - apart[1] * tangent[0]) / stretch

    hats = (1.0 - xi, xi)
    measure = width.along_points() * np.broadcast_to(weights, (n, len(weights))) * edge_lengths[:, None]
    weighted = gap * measure
    gaps = tuple((hat * weighted).sum() for hat in hats)
    shares = np.stack([hat.value for hat in hats], axis=1)
    there = shape_functions(other.order, eta.value, 0)[0]
    return PieceIntegrals(
        (gaps[0], gaps[1]),
        np.einsum("nrq,nq->nr", shares, measure.value),
        np.einsum("nrq,nq,nqa->nra", shares, measure.value, there),
    )


@dataclass(frozen=True, eq=False)
class _Edge:
    """Positions of edges' nodes, shape (n, order + 1, 2), that are variables from number ``first`` on."""

    nodes: Floats
    first: int

    @property
    def order(self) -> int:
        return self.nodes.shape[1] - 1


def _foot(own: _Edge, start: Jet, other: _Edge, place: int) -> Jet:
    """Parameter of the foot of a primary node on the secondary edge, whose value is that of ``start``."""
    node = other.nodes[:, place]
    at, tangent, bend = (_values(own.nodes, start.value, derivative) for derivative in range(3))
    slope = ((node - at) * bend).sum(-1) - (tangent**2).sum(-1)
    columns = [other.first + 2 * (place % (other.order + 1)) + component for component in range(2)]
    xi = start
    for _ in range(2):  # each round makes the derivatives of one more order exact
        residual = start * 0.0
        for component, (x, t) in enumerate(zip(_point(own, xi), _point(own, xi, derivative=1), strict=True)):
            apart = start.variable(node[:, component], columns[component]) - x
            residual = residual + apart * t
        xi = xi - residual * (1.0 / slope)
    return replace(xi, value=start.value)


def _opposite(other: _Edge, at: list[Jet], tangent: list[Jet]) -> Jet:
    """Parameter where the secondary's normal meets the primary edge (extended beyond its ends)."""
    here = np.stack([x.value for x in at], axis=-1)
    along = np.stack([t.value for t in tangent], axis=-1)
    value = _ray_parameters(other.nodes[:, None], here, along)
    slope = (_values(other.nodes[:, None], value, 1) * along).sum(-1)
    start = replace(at[0] * 0.0, value=value)
    eta = start
    for _ in range(2):
        there = _point(other, eta)
        residual = (there[0] - at[0]) * tangent[0] + (there[1] - at[1]) * tangent[1]
        eta = eta - residual * (1.0 / slope)
    return replace(eta, value=value)


def _ray_parameters(edges: Floats, points: Floats, tangents: Floats) -> Floats:
    """Parameters of edges (..., order + 1, 2) where normals to ``tangents`` through ``points`` (..., 2) meet them."""
    order = edges.shape[-2] - 1
    chord = edges[..., -1, :] - edges[..., 0, :]
    eta: Floats = ((points - edges[..., 0, :]) * tangents).sum(-1) / (chord * tangents).sum(-1)
    for _ in range(20 if order > 1 else 0):
        residual = ((_values(edges, eta) - points) * tangents).sum(-1)
        slope = (_values(edges, eta, 1) * tangents).sum(-1)
        change = np.clip(residual / slope, -0.5, 0.5)
        eta = eta - change
        if np.abs(change).max(initial=0.0) < 1e-14:
            break
    return eta


def _distances(secondary: Floats, primary: Floats, xi: Floats) -> Floats:
    """Distances along the secondary's normal from its points at parameters ``xi`` (p,) to the primary edges."""
    at, tangent = _values(secondary, xi), _values(secondary, xi, 1)
    apart = _values(primary, _ray_parameters(primary, at, tangent)) - at
    distance: Floats = (apart[:, 0] * tangent[:, 1] - apart[:, 1] * tangent[:, 0]) / np.linalg.norm(tangent, axis=1)
    return distance


def _values(edges: Floats, xi: Floats, derivative: int = 0) -> Floats:
    """Points of edges (..., order + 1, 2) at parameters (...), or derivatives by the parameter, shape (..., 2)."""
    shapes = shape_functions(edges.shape[-2] - 1, xi, derivative)[derivative]
    points: Floats = (shapes[..., None] * edges).sum(-2)
    return points


def _point(edge: _Edge, xi: Jet, derivative: int = 0) -> list[Jet]:
    """Components x and y of points of edges, or of their derivatives by the parameter.

    The product of jets ``sum N_a(xi) X_a`` is written out, because the gradients of the nodes are unit vectors.
    """
    shapes = shape_functions(edge.order, xi.value, derivative + 2)[derivative:]
    nodes = edge.nodes if xi.value.ndim == 1 else edge.nodes[:, None]
    result = []
    for component in range(2):
        value, first, second = ((shape * nodes[..., component]).sum(-1) for shape in shapes)
        jet = xi.through(value, first, second)
        for number in range(edge.order + 1):
            column = edge.first + 2 * number + component
            jet.gradient[..., column] += shapes[0][..., number]
            if jet.hessian is not None:
                mixed = shapes[1][..., number, None] * xi.gradient
                jet.hessian[..., column, :] += mixed
                jet.hessian[..., :, column] += mixed
        result.append(jet)
    return result
