"""Pieces of the secondary surface that face one primary edge, and the integrals of the gap over them.

The gap at a secondary point is measured along the secondary's own normal: it is continuous over the primary's corners,
where the closest point would jump. Integrals are over the undeformed length of the secondary, whose edges are straight,
so that pressure on an open or penetrated gap does no work on the surface's stretching. Their derivatives are exact,
those of the pieces' ends included: the sum over the pieces is invariant to rigid motions, so forces balance to
round-off.
"""

from dataclasses import dataclass

import numpy as np

from flangeway.contact.edge_shapes import as_complex, derivative, edge_series, horner
from flangeway.contact.kinematics import closest_parameters
from flangeway.contact.points import PiecePoints, ray_parameters
from flangeway.contact.straight import straight_integrals
from flangeway.types import Bools, Complex, Floats, Ints

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
        Maximum gap and maximum penetration along the secondary's normal at the middle of a piece.

    """
    edges, partners, feet = _over_chords(secondary, primary, candidates)
    straight = secondary.shape[1] == primary.shape[1] == 2
    if straight:
        high, low = feet.real
    else:
        ends = np.concatenate((primary[partners, 0], primary[partners, -1]))
        high, low = closest_parameters(ends, secondary[np.tile(edges, 2)]).reshape(2, -1)
    start_is_foot, end_is_foot = low > SNAP, high < 1.0 - SNAP
    starts, stops = np.where(start_is_foot, low, 0.0), np.where(end_is_foot, high, 1.0)
    pieces = Pieces(edges, partners, starts, stops, start_is_foot, end_is_foot)
    middle = (starts + stops) / 2.0
    if straight:
        across = feet[0] + (middle - high) / (low - high) * (feet[1] - feet[0])
        chords = secondary[:, 1] - secondary[:, 0]
        distance = -across.imag * np.hypot(chords[:, 0], chords[:, 1])[edges]
    else:
        distance = _distances(secondary[edges], primary[partners], middle)
    return pieces.take(np.flatnonzero((stops - starts > SNAP) & (distance < reach) & (distance > -depth)))


def _over_chords(secondary: Floats, primary: Floats, candidates: tuple[Ints, Ints]) -> tuple[Ints, Ints, Complex]:
    """Candidates that face each other, the primary over the secondary's chord or near it.

    The third array (2, c) has the primary edge's start and end as numbers: the real part along the chord, 0 at its
    start and 1 at its end, the imaginary part to its left. Curved edges are near enough to their chords to leave out
    what is far.
    """
    edges, partners = candidates
    start, other_start = as_complex(secondary[:, 0]), as_complex(primary[:, 0])
    chord, other = as_complex(secondary[:, -1]) - start, as_complex(primary[:, -1]) - other_start
    scale = (1.0 / chord)[edges]
    high, along = (other_start[partners] - start[edges]) * scale, other[partners] * scale
    # the two sides run against each other
    over = np.flatnonzero((along.real < 0.0) & (high.real > -FAR) & (high.real + along.real < 1.0 + FAR))
    high, along = high[over], along[over]
    facing = along.real < -LEAST_FACING * np.abs(along)
    over = over[facing]
    return edges[over], partners[over], np.stack((high, high + along))[:, facing]


@dataclass(frozen=True, eq=False)
class GapIntegral:
    """Integrals of the gap over pieces with one of the two hat functions of each piece's edge.

    Parameters
    ----------
    value
        ``int phi_r g ds`` over the undeformed length, shape (p,).
    gradient
        First derivatives by the components of the secondary edge's nodes, then of the primary's, shape (p, d).

    """

    value: Floats
    gradient: Floats


@dataclass(frozen=True, eq=False)
class PieceIntegrals:
    """Integrals over pieces with the two hat functions of each piece's edge, linear between its ends.

    Parameters
    ----------
    gaps
        Integrals of the gap for r = 0 and 1.
    lengths
        ``int phi_r ds``, shape (p, 2).
    primary_shapes
        ``int phi_r N_a ds`` with the primary edge's functions at the opposite point, shape (p, 2, order + 1).
    points
        The points of quadrature, for second derivatives; None where these are not wanted.

    """

    gaps: tuple[GapIntegral, GapIntegral]
    lengths: Floats
    primary_shapes: Floats
    points: PiecePoints | None


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
        Whether second derivatives will be wanted; without them straight edges have a closed form.

    """
    given = (pieces.starts, pieces.ends), (pieces.start_is_foot, pieces.end_is_foot), secondary, primary, edge_lengths
    if not second and secondary.shape[1] == primary.shape[1] == 2:
        values, gradients, covered, shapes = straight_integrals(*given)
        gaps = GapIntegral(values[0], gradients[0]), GapIntegral(values[1], gradients[1])
        return PieceIntegrals(gaps, covered.T, shapes.swapaxes(0, 1), None)
    points = PiecePoints(*given)
    values, gradients = points.gaps()
    gaps = GapIntegral(values[:, 0], gradients[:, 0]), GapIntegral(values[:, 1], gradients[:, 1])
    hats = points.hats
    return PieceIntegrals(gaps, hats.sum(axis=-1), hats @ points.other_values, points if second else None)


def _distances(secondary: Floats, primary: Floats, xi: Floats) -> Floats:
    """Distances along the secondary's normal from its points at parameters ``xi`` (p,) to the primary edges."""
    own, other = edge_series(secondary), edge_series(primary)
    at, tangent = horner(own, xi), horner(derivative(own), xi)
    apart = horner(other, ray_parameters(other, at, tangent)) - at
    distance: Floats = -(np.conj(tangent) * apart).imag / np.abs(tangent)
    return distance
