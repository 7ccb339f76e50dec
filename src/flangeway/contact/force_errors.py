"""Errors of contact forces by the law of contact, by chords of curves, and by contacts narrower than the mesh."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.contact.contact_state import ContactState
from flangeway.contact.kinematics import as_vectors, derivative, edge_series, horner, node_edge_gaps
from flangeway.contact.pairs import Constraints
from flangeway.contact.search import nearest_edges
from flangeway.contact.surface import CORNER_ANGLE, Surface, heights_of, turns_of
from flangeway.contact.system import Contact, ContactSystem, nodal_forces_of
from flangeway.geometry.arrays import turned_right
from flangeway.solve.body_response import BodyResponse
from flangeway.types import Floats, Ints

CONSTRAINTS_APART = 3
"""Number of open constraints between two regions of contact; fewer are a gap in one region."""

SMALL_FORCE_ERROR = 0.05
"""Error of a force from which a warning names it; of an approach relative to the elastic closure."""

MAX_FORCE_ERROR = 0.5
"""Error of a force above which it is wrong: half of it is penetration or gap of the law, or unknown by the mesh."""

MAX_APPROACH_ERROR = 0.1
"""Error of the approach under a prescribed force, relative to the edges in contact, above which it is wrong: chords of
15 degrees on both sides leave 0.07. The elastic closure is no measure of it: that of a small force is tiny."""

SPREAD = 1.2
"""Half width over which an element spreads the pressure of a contact that is narrower than it, in its lengths: the
smallest that bounds the errors of the random contacts of `benchmarks.narrow_contacts` is 1."""

POINTS = (np.arange(6) + 0.5) / 6.0
"""Points of an edge at which gaps are measured."""


def contact_regions(contact: Contact, pairs: Constraints, forces: Floats) -> list[tuple[Ints, Ints]]:
    """Constraints under force of each region along the secondary surface, and the keys that order them, each (n,).

    Guarded nodes have the key of the pairing's constraint next to them; on a closed surface a region may pass its seam.
    """
    nodes = contact.pairing.key_nodes(contact.secondary)
    order = np.argsort(nodes, kind="stable")
    nearest = order[np.minimum(np.searchsorted(nodes[order], pairs.nodes), len(nodes) - 1)]
    keys = np.where(pairs.guarded, nearest, pairs.keys)
    loaded = np.flatnonzero(forces > 0.0)
    loaded = loaded[np.argsort(keys[loaded], kind="stable")]
    if len(loaded) == 0:
        return []
    groups = np.split(loaded, np.flatnonzero(np.diff(keys[loaded]) > CONSTRAINTS_APART) + 1)
    over_seam = keys[loaded[0]] + len(nodes) - keys[loaded[-1]] <= CONSTRAINTS_APART
    if len(groups) > 1 and contact.secondary.is_closed and over_seam:
        groups = [np.append(groups[-1], groups[0]), *groups[1:-1]]
    return [(group, keys[group]) for group in groups]


@dataclass(frozen=True)
class ForceError:
    """Errors of the approach of the surfaces in a region of contact, beside the elastic closure by its force.

    The energy of the solution is between those of the exact one at its approach, and at an approach that is less by the
    maximum penetration between the nodes: these solutions are admissible. Forces are between these, too.

    Parameters
    ----------
    contact
        Number of the contact.
    force
        Sum of the region's forces.
    closure
        Displacement of both surfaces against each other by the region's forces, their mean weighted by them.
    penetration, gap
        Mean penetration and mean gap under pressure that the law of contact leaves.
    between_nodes
        Penetration between the nodes, its mean weighted by the pressure.
    chords
        Sagitta of the curves whose chords are in contact.
    spread
        Closure that is missing because elements spread the pressure of a contact that is narrower.
    exponent
        Power of the approach with which the force grows: 1 in lines, 3/2 at points of bodies of revolution.
    size
        Size of elements with which the mesh's error is small.
    edge
        Length of the shortest edge in contact.

    """

    contact: int
    force: float
    closure: float
    penetration: float
    gap: float
    between_nodes: float
    chords: float
    spread: float
    exponent: float
    size: float
    edge: float

    def by_law(self, *, prescribed: bool) -> float:
        """Error of the force by the law of contact, relative to that of surfaces that touch without penetration.

        With a ``prescribed`` force that of the approach, a length.
        """
        motion = 1.0 if prescribed else self.closure + self.penetration - self.gap
        return (self.penetration + self.gap) / motion if motion > 0.0 else np.inf

    def by_mesh(self, *, prescribed: bool) -> float:
        """Estimated error of the force by the mesh, relative to it, or of the approach, a length, as in `by_law`."""
        missing = self.between_nodes + self.chords
        if prescribed:
            return missing + self.spread
        return self.exponent * (missing / self.closure + self.spread / (self.closure + self.spread))

    def limits(self, *, prescribed: bool) -> tuple[float, float]:
        """Errors from which a warning names them, and above which they are wrong."""
        if prescribed:
            return SMALL_FORCE_ERROR * self.closure, MAX_APPROACH_ERROR * self.edge
        return SMALL_FORCE_ERROR, MAX_FORCE_ERROR


def force_errors(system: ContactSystem, response: BodyResponse, state: ContactState) -> list[ForceError]:
    """Errors of each region of contact of a solution."""
    return [
        _Region(system, response, state, number, group).error()
        for number, solved in enumerate(system.solved(state.linearisation, state.forces))
        for group, _ in contact_regions(solved.contact, solved.pairs, solved.forces)
    ]


def hidden_overlap(system: ContactSystem, state: ContactState, number: int) -> float:
    """Maximum overlap of the drawn surfaces of a contact without force, between their nodes; 0 if there is none."""
    contact = system.contacts[number]
    depths = [surface.facet_depths(CORNER_ANGLE) for surface in contact.sides]
    edges, faced, _, gaps = _gaps(system, contact, state.positions, np.arange(len(contact.secondary.edges)))
    overlap = depths[0][edges] + depths[1][faced] - gaps
    overlap[-gaps > contact.secondary.edge_lengths[edges]] = 0.0  # faced through a body
    return max(0.0, float(overlap.max(initial=0.0)))


def _gaps(
    system: ContactSystem, contact: Contact, positions: Floats, chosen: Ints
) -> tuple[Ints, Ints, Floats, Floats]:
    """Chosen secondary edges at points that have a foot on a primary one, that one, the parameters, and the gaps."""
    edges, other = (
        system.points_of(surface, positions)[surface.contact_places] for surface in (contact.secondary, contact.primary)
    )
    owners, xi = np.repeat(chosen, len(POINTS)), np.tile(POINTS, len(chosen))
    series = edge_series(edges[owners])
    points, tangents = (as_vectors(horner(of, xi)) for of in (series, derivative(series)))
    faced = nearest_edges(points, turned_right(tangents), other)
    node_gaps = node_edge_gaps(points, other[faced])
    on_edge = (faced >= 0) & (np.abs(node_gaps.parameters - 0.5) <= 0.5)
    return owners[on_edge], faced[on_edge], xi[on_edge], node_gaps.gaps[on_edge]


class _Region:
    """A region of contact: constraints ``group`` under force of a contact."""

    def __init__(
        self, system: ContactSystem, response: BodyResponse, state: ContactState, number: int, group: Ints
    ) -> None:
        self.system, self.response, self.state, self.number, self.group = system, response, state, number, group
        self.contact, self.pairs, self.inside, forces = system.solved(state.linearisation, state.forces)[number]
        self.forces, self.nodes = forces[group], self.pairs.nodes[group]
        self.force = float(self.forces.sum())

    def error(self) -> ForceError:
        """Errors of the region."""
        gaps, sides = self.pairs.gaps[self.group], list(zip(self.contact.sides, self.edges, strict=True))
        depths = [surface.facet_depths(CORNER_ANGLE)[edges].max(initial=0.0) for surface, edges in sides]
        spread, exponent, size = self._spread()
        return ForceError(
            self.number,
            self.force,
            self._closure(),
            float(self.forces @ np.maximum(-gaps, 0.0)) / self.force,
            float(self.forces @ np.maximum(gaps, 0.0)) / self.force,
            self._between_nodes(),
            float(sum(depths)),
            spread,
            exponent,
            size,
            min(float(surface.edge_lengths[edges].min()) for surface, edges in sides),
        )

    @cached_property
    def edges(self) -> tuple[Ints, Ints]:
        """Edges of both sides in contact."""
        secondary = np.isin(self.contact.secondary.edge_places, self.nodes).any(axis=1)
        rows = np.isin(self.pairs.rows, self.group).any(axis=1)
        return np.flatnonzero(secondary), np.unique(self.pairs.primary_edges[rows])

    def _closure(self) -> float:
        """Mean of the displacements against each other; of floating parts with those by all other forces."""
        lin, forces = self.state.linearisation, np.zeros(len(self.state.forces))
        forces[np.arange(len(forces))[self.inside][self.group]] = self.forces
        nodal = nodal_forces_of(lin, forces, None, np.zeros(len(forces)), len(self.state.positions))
        rotations = self.response.rotations(self.state.placements)
        displacements = self.response.displacements(rotations, np.arange(len(nodal)), nodal)
        for number, part in enumerate(self.system.parts):
            if part.body.freedom.n_motions:
                rows = self.system.rows_of(number)
                displacements[rows] = self.state.displacements[rows]
        return abs(float((nodal * displacements).sum())) / self.force

    @cached_property
    def _end_loads(self) -> tuple[Floats, Floats]:
        """Pressure and penetration at the nodes of the secondary surface, those of inner ones at the edges' ends."""
        surface = self.contact.secondary
        n = len(surface.nodes)
        forces, areas, depths = np.bincount(self.nodes, self.forces, n), np.zeros(n), np.zeros(n)
        np.maximum.at(depths, self.nodes, -self.pairs.gaps[self.group])
        for inner in surface.edge_places[:, 1:-1].T:
            for end in surface.ends.T:
                np.add.at(forces, end, forces[inner] / 2.0)
        np.add.at(areas, surface.hats.nodes, surface.hats.areas)
        return forces / np.where(areas > 0.0, areas, np.inf), depths

    def _between_nodes(self) -> float:
        """Mean penetration beyond that of the law, weighted by the pressure; gaps of as much are in the same means."""
        surface = self.contact.secondary
        beside = np.isin(surface.edge_places, surface.edge_places[self.edges[0]]).any(axis=1)
        edges, _, xi, gaps = _gaps(self.system, self.contact, self.state.positions, np.flatnonzero(beside))
        starts, ends = surface.edge_places[edges, 0], surface.edge_places[edges, -1]
        pressures, depths = (values[starts] * (1.0 - xi) + values[ends] * xi for values in self._end_loads)
        weights = pressures * surface.edge_lengths[edges]
        beyond = np.maximum(-gaps - depths, 0.0)
        beyond[beyond > surface.edge_lengths[edges]] = 0.0  # faced through a body
        return 2.0 * float(weights @ beyond) / max(float(weights.sum()), np.finfo(float).tiny)

    def _spread(self) -> tuple[float, float, float]:
        """Missing closure, the force's exponent, and a size of elements that resolves the contact.

        Elements of length h spread the pressure of a contact of Hertz's half width a to ``sqrt(a^2 + (c h)^2)``. A
        line's closure has the term ``-(2 F / pi E) ln a``, that of a point is ``3 F / 4 E a`` (Johnson, 1985, 4.2).
        """
        sides = list(zip(self.contact.sides, self.edges, strict=True))
        lengths = np.array([surface.edge_lengths[edges].max() for surface, edges in sides])
        softness = np.array([surface.part.body.softness for surface, _ in sides])
        curvature = sum(float(_curvatures(surface)[edges].mean()) for surface, edges in sides)
        body, surface = self.contact.secondary.part.body, self.contact.secondary
        radius, at_axis = 1.0, False
        if body.axisymmetric:
            radii = body.nodes[surface.nodes[self.nodes], 0]
            radius, at_axis = float(self.forces @ radii) / self.force, bool(radii.min() < lengths[0])
        if curvature * body.size < 1e-6:
            return 0.0, 1.0, float(lengths.min()) / 4.0
        if at_axis:
            half = float(np.cbrt(0.75 * self.force * softness.sum() / curvature))
            ratios = 1.0 - 1.0 / np.sqrt(1.0 + (SPREAD * lengths / half) ** 2)
            return float(0.75 * self.force / half * softness @ ratios), 1.5, half / 4.0
        line = self.force / (2.0 * np.pi * radius if body.axisymmetric else body.thickness)
        half = float(np.sqrt(4.0 * line * softness.sum() / (np.pi * curvature)))
        return float(line / np.pi * softness @ np.log1p((SPREAD * lengths / half) ** 2)), 1.0, half / 4.0


def _curvatures(surface: Surface) -> Floats:
    """Curvature of the drawn surface at each edge, positive where convex, shape (n_edges,)."""
    edges = surface.part.placement.points(surface.points)[surface.contact_places]
    heights = heights_of(edges)
    curved = heights[np.arange(len(edges)), np.abs(heights).argmax(axis=1)] if heights.size else np.zeros(len(edges))
    turns = turns_of(edges[:, [0, -1]])
    turns[-1] *= surface.is_closed  # an open surface ends there
    chorded = np.sign(turns + np.roll(turns, 1)) * surface.facet_depths(CORNER_ANGLE)
    return 8.0 * (curved + chorded) / surface.edge_lengths**2
