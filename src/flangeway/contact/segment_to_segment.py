"""Segment-to-segment contact: gaps averaged over the secondary surface (mortar method).

Each end of a secondary edge carries a hat function, linear over the edges. On edges of order 2 and more this is one
order less than the displacements, which keeps multipliers free of oscillations (as Taylor and Hood's pair does for
fluids; with a hat at every node they oscillate), and pressures of values >= 0 are >= 0 everywhere. The constraint of a
hat is the mean of the gap weighted with it (Puso and Laursen, 2004, Comput. Methods Appl. Mech. Eng. 193), or with the
biorthogonal function of the same edge (Wohlmuth, 2000, SIAM J. Numer. Anal. 38).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import ClassVar, Literal

import numpy as np

from flangeway.checks import check_positive
from flangeway.contact.edge_pieces import PieceIntegrals, Pieces, find_pieces
from flangeway.contact.pairs import Pairing, Pairs
from flangeway.contact.search import candidate_pairs, leads_out
from flangeway.contact.slip import Slides
from flangeway.contact.surface import Surface
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import cross_product, turned_right
from flangeway.types import Bools, Floats, Ints

MIN_COVERED = 1e-6
"""Part of a hat function's area that must face the primary, and part of an edge that may be left uncovered."""

FLAT = np.deg2rad(20.0)
"""Angle up to which a secondary edge lies flat on primary ones: far above that of the chords of coarse curves, which it
meets in turn, and below that of the sides of a sharp corner."""

DUAL = np.array([[2.0, -1.0], [-1.0, 2.0]])
"""Biorthogonal functions of an edge as combinations of its two hats."""


@dataclass(frozen=True, eq=False)
class SegmentPairs(Pairs):
    """Constraints of the hat functions that face the primary.

    Parameters
    ----------
    pieces
        Pieces of the secondary surface.
    integrals
        Integrals over the pieces, with their derivatives.
    weights
        What the integrals with a piece's two hats add to the gaps of its two constraints, shape (p, 2, 2).

    """

    pieces: Pieces
    integrals: PieceIntegrals
    weights: Floats

    @cached_property
    def gradients(self) -> Floats:
        """See `Pairs.gradients`."""
        return self._on_points(self.integrals.gaps[1])

    def _on_points(self, integrals: Floats) -> Floats:
        """What the derivatives of the integrals with the hats (p, 2, d) add to those of the constraints."""
        gradients: Floats = np.einsum("prs,psd->prd", self.weights, integrals)
        return gradients.reshape(*gradients.shape[:2], gradients.shape[2] // 2, 2)

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """See `Pairs.curvatures`."""
        return self._on_terms(forces, PieceIntegrals.hessians)

    def _on_terms(self, forces: Floats, second: Callable[[PieceIntegrals, Floats], Floats]) -> tuple[Ints, Floats]:
        """Pieces under load, and their second derivatives by forces on the two hats."""
        on_hats = np.einsum("pr,prs->ps", forces[self.rows], self.weights)
        loaded = np.flatnonzero(on_hats.any(axis=1))
        return loaded, second(self.integrals.take(loaded), on_hats[loaded])

    def slides(self, points: Floats, before: Floats) -> Slides:  # noqa: ARG002 (the pieces know where they are)
        """See `Pairs.slides`."""
        n_secondary = self.secondary_members.shape[1]
        values, rates, directions = self.integrals.slips(before[:, :n_secondary], before[:, n_secondary:])
        slips = np.zeros(len(self.keys))
        np.add.at(slips, self.rows, np.einsum("prs,ps->pr", self.weights, values))
        turns = partial(self._on_terms, second=PieceIntegrals.turns)
        return Slides(slips, self._on_points(rates), self._on_points(directions), turns)

    def opposite_points(self, edges: Floats) -> Floats:
        """See `Pairs.opposite_points`."""
        moments = np.einsum("pra,pai->pri", self.integrals.primary_shapes, edges[self.pieces.partners])
        total, covered = np.zeros((len(self.keys), 2)), np.zeros(len(self.keys))
        np.add.at(total, self.rows, moments)
        np.add.at(covered, self.rows, self.integrals.lengths)
        return total / covered[:, None]


@dataclass(frozen=True)
class SegmentToSegment(Pairing):
    """Average the gap over the pieces between the nodes of both surfaces.

    A uniform pressure passes from one surface to the other exactly, whatever their meshes, where both are straight.
    The order of quadrature follows the edges'. Where a node's function is covered by the primary in part only, its
    constraint is the mean over that part; the tangent of a penalty then leaves out the change of the covered area.

    Parameters
    ----------
    depth
        Pieces that penetrate deeper are ignored; None: half the extent of the smaller surface. A step that moves a
        surface deeper than this into the other loses the contact.
    weighting
        ``"standard"``: gaps weighted with the hat functions. ``"dual"``: with their biorthogonal functions, on edges
        that lie flat on the primary as a whole; these oscillate less.

    """

    averages: ClassVar[bool] = True
    depth: float | None = None
    weighting: Literal["standard", "dual"] = "standard"

    def __post_init__(self) -> None:
        if self.depth is not None:
            check_positive("SegmentToSegment", "depth", self.depth, "a positive length or None", "leave it out")
        if self.weighting not in ("standard", "dual"):
            raise InputError(
                f"SegmentToSegment(weighting={short(self.weighting)})", "'standard' or 'dual'", "choose one of these"
            )

    def node_areas(self, secondary: Surface) -> Floats:
        """See `Pairing.node_areas`."""
        hats = secondary.hats
        areas = np.zeros(len(secondary.nodes))
        np.add.at(areas, hats.nodes, hats.areas)
        return areas

    def key_nodes(self, secondary: Surface) -> Ints:
        """See `Pairing.key_nodes`."""
        return secondary.hats.nodes

    def pair(
        self,
        secondary: Surface,
        primary: Surface,  # noqa: ARG002 (its edges are enough)
        positions: Floats,
        primary_edges: Floats,
        kept: Ints,  # noqa: ARG002 (gaps are continuous: no constraint has a partner)
        *,
        settle: bool = False,  # noqa: ARG002 (the same)
    ) -> SegmentPairs:
        """Find the pieces that are open by less than two mean primary edges; see `Pairing.pair`."""
        hats = secondary.hats
        chords = primary_edges[:, -1] - primary_edges[:, 0]
        reach = 2.0 * float(np.linalg.norm(chords, axis=1).mean())
        edges = positions[secondary.contact_places]
        depth = (
            self.depth or min(float(np.linalg.norm(np.ptp(side, axis=(0, 1)))) for side in (edges, primary_edges)) / 2.0
        )
        candidates = candidate_pairs(_swept(edges, reach, depth), primary_edges, secondary.edge_lengths)
        pieces = find_pieces(edges, primary_edges, candidates, reach, depth)
        pieces = pieces.take(~_through_itself(pieces, edges, primary_edges))
        found = _integrals(pieces, edges, primary_edges, secondary)

        of_piece = hats.of_edge[pieces.edges]
        covered = np.zeros(len(hats.nodes))
        np.add.at(covered, of_piece, found.lengths)
        thickness = secondary.part.body.depth
        keys = np.flatnonzero(covered * thickness > MIN_COVERED * hats.areas)
        if len(keys) == 0:  # at most slivers, which carry nothing
            pieces = pieces.take(np.empty(0, dtype=np.int64))
            found = _integrals(pieces, edges, primary_edges, secondary)
            of_piece = of_piece[:0]
        # pieces add nothing to a hat that is almost uncovered: their weight is zero
        row_of = np.zeros(len(hats.nodes), dtype=np.int64)
        row_of[keys] = np.arange(len(keys))
        inverse = np.zeros(len(hats.nodes))
        inverse[keys] = 1.0 / covered[keys]
        weights = self._functions(pieces, found, secondary, edges, primary_edges) * inverse[of_piece][:, :, None]
        rows = row_of[of_piece]
        gaps = np.zeros(len(keys))
        np.add.at(gaps, rows, np.einsum("prs,ps->pr", weights, found.gaps[0]))
        return SegmentPairs(
            keys, np.full(len(keys), -1), hats.nodes[keys], gaps, covered[keys] * thickness, hats.areas[keys],
            secondary.contact_places[pieces.edges], pieces.partners, rows, pieces, found, weights,
        )  # fmt: skip

    def _functions(
        self, pieces: Pieces, found: PieceIntegrals, secondary: Surface, edges: Floats, primary_edges: Floats
    ) -> Floats:
        """Weighting functions as combinations of the two hats of each piece's edge, shape (p, 2, 2).

        Biorthogonal functions have both signs. Where the gap is far from linear, as of an edge that a corner of the
        primary meets, their mean may be negative although the surfaces are apart.
        """
        functions = np.zeros((len(pieces), 2, 2))
        functions[:] = np.eye(2)
        if self.weighting == "dual":
            covered = np.zeros(len(edges))
            np.add.at(covered, pieces.edges, found.lengths.sum(axis=1))
            flat = covered > (1.0 - MIN_COVERED) * secondary.edge_lengths
            along, opposite = (
                (each[:, -1] - each[:, 0]) for each in (edges[pieces.edges], primary_edges[pieces.partners])
            )
            cosines = -(along * opposite).sum(axis=1) / np.linalg.norm(along, axis=1) / np.linalg.norm(opposite, axis=1)
            flat[pieces.edges[cosines < np.cos(FLAT)]] = False
            functions[flat[pieces.edges]] = DUAL
        return functions


def _integrals(pieces: Pieces, edges: Floats, primary_edges: Floats, secondary: Surface) -> PieceIntegrals:
    """Integrals over pieces of a surface between positions of its edges and of the primary's."""
    lengths = secondary.edge_lengths[pieces.edges]
    radii = None if secondary.radii is None else secondary.radii[pieces.edges]
    both = edges[pieces.edges], primary_edges[pieces.partners]
    return PieceIntegrals(pieces, *both, lengths, radii)


def _swept(edges: Floats, reach: float, depth: float) -> Floats:
    """Points of edges (n, order + 1, 2) moved outwards by a reach and inwards by a depth, beside each other."""
    outwards = turned_right(edges[:, -1] - edges[:, 0])
    outwards /= np.hypot(*outwards.T)[:, None]
    return np.concatenate((edges + reach * outwards[:, None], edges - depth * outwards[:, None]), axis=1)


def _through_itself(pieces: Pieces, edges: Floats, primary_edges: Floats) -> Bools:
    """Pieces that face the primary through their own body, see `leads_out`."""
    middle = ((pieces.starts + pieces.ends) / 2.0)[:, None]
    start, along = edges[pieces.edges, 0], edges[pieces.edges, -1] - edges[pieces.edges, 0]
    other = primary_edges[pieces.partners, 0]
    chord = primary_edges[pieces.partners, -1] - other
    at = start + middle * along
    share = ((at - other) * along).sum(axis=1) / (chord * along).sum(axis=1)
    way = other + share[:, None] * chord - at
    result = np.zeros(len(pieces), dtype=np.bool_)
    behind = np.flatnonzero(cross_product(along, way) > 0.0)
    sizes = (pieces.ends - pieces.starts) * np.linalg.norm(along, axis=1)
    own = edges, pieces.edges[behind, None] == np.arange(len(edges))
    its = primary_edges, pieces.partners[behind, None] == np.arange(len(primary_edges))
    result[behind] = leads_out(at[behind], way[behind], sizes[behind], own, its)
    return result
