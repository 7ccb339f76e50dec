"""Contact pressure from the forces of contact nodes, and what makes it wrong or rough."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.contact import Contact, ContactState, ContactSystem, NodeToNode, SegmentToSegment, Surface
from flangeway.contact.force_errors import contact_regions
from flangeway.contact.pairs import Constraints
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import as_point, chain_lengths, max_magnitude, norms, sums_at
from flangeway.problems.elasticity_problem import ON_AXIS
from flangeway.results import Result, ResultTable
from flangeway.space.symmetric import EPS
from flangeway.types import Floats, Ints

# --- Contact pressure from the forces of contact nodes.


MIN_SEGMENTS = 8
"""Segments in a region of contact below which its maximum pressure depends on where the nodes happen to lie."""

MAX_OSCILLATION = 0.1
"""Pressure oscillation (`oscillation_of`) above which no pressure is reliable; the default cases have 0.02."""

AT_CORNER = "at a sharp corner, where the pressure has no limit"
"""Remark on the pressure of a corner."""

FOURTH = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
"""Fourth difference: hardly anything of smooth pressures, and 16 times the amplitude of the finest wave."""

MIN_FACED_FRACTION = 0.5
"""Share of a node's area that the primary faces below which its force counts with its neighbour's: a corner that is
beside a node presses on a sliver, whose pressure has no limit."""

MIN_AREA_RATIO = 0.2
"""Area of a node relative to its neighbour's below which the force of node-to-node contact counts with the
neighbour's: what a short edge's node carries is a small part of the errors of its neighbours' forces, but not of
their pressures."""


@dataclass(frozen=True, eq=False)
class PressurePatch(Result):
    """A contiguous region of contact on a secondary surface.

    Parameters
    ----------
    contact
        Number of the contact in its system.
    nodes
        The loaded nodes by their positions in `Surface.nodes` of the secondary, shape (n,).
    points
        Positions of the loaded nodes along the surface, shape (n, 2).
    along
        Length along the surface from the centre of pressure, shape (n,).
    forces
        Resultants of the loaded nodes' contact on the secondary side, shape (n, 2).
    normal_forces
        Contact forces of the nodes, shape (n,).
    pressures
        Contact forces over the nodes' areas: for node-to-segment by influence width (Moherdaui 2021, Figure 63), for
        node-to-node by the integrals of the shape functions, for segment-to-segment the values of the integrated field,
        shape (n,). A node of whose area the primary faces less than half has the mean pressure of itself and its
        neighbour, and so has node-to-node one with less than a fifth of its neighbour's area.
    width
        Sum of the lengths that belong to the nodes.
    secondary_point, primary_point
        Centres of pressure on the undeformed bodies, in their own frames, shape (2,).
    at_edge
        Whether the patch reaches an end of either surface, so that contact may go on outside.
    per_segment
        Number of constraints of a segment of the surface.
    corner
        Sharp corner of one body, x and y, under pressure against a smooth part of the other; None: there is none.
    about_axis
        Whether it is around the axis of bodies of revolution, up to which it reaches.
    """

    contact: int
    nodes: Ints
    points: Floats
    along: Floats
    forces: Floats
    normal_forces: Floats
    pressures: Floats
    width: float
    secondary_point: Floats
    primary_point: Floats
    at_edge: bool
    per_segment: int = 1
    corner: tuple[float, float] | None = None
    about_axis: bool = False

    @property
    def table(self) -> ResultTable:
        """Places, forces and pressures of its nodes."""
        (x, y), forces = self.points.T, self.normal_forces
        return ResultTable({"x": x, "y": y, "along": self.along, "force": forces, "pressure": self.pressures})

    @property
    def force(self) -> Floats:
        """Resultant on the secondary side, shape (2,)."""
        return self.forces.sum(axis=0)

    @property
    def max_pressure(self) -> float:
        """Maximum pressure of its nodes."""
        return float(self.pressures.max())

    @property
    def centre(self) -> Floats:
        """Centre of pressure, shape (2,)."""
        return self.normal_forces @ self.points / self.normal_forces.sum()

    @property
    def oscillation(self) -> float:
        """Change of the pressure from one node to the next and back, over the local mean; see `oscillation_of`."""
        return oscillation_of(self.pressures)

    @property
    def n_segments(self) -> float:
        """Number of segments of the secondary surface that it is wide."""
        return len(self.pressures) / self.per_segment

    @property
    def remark(self) -> str | None:
        """Why its pressures are not reliable, see `pressure_remark`."""
        return pressure_remark(self.n_segments, self.oscillation) or (AT_CORNER if self.corner else None)

    @property
    def half_width(self) -> float:
        """Half of the loaded length, about an axis of revolution the radius of the contact."""
        return self.width if self.about_axis else self.width / 2.0


def oscillation_of(pressures: Floats) -> float:
    """Change of pressures from one node to the next and back, over the mean around them.

    It is the noise of node-to-segment contact; smooth pressures have almost none, and a peak at an edge hides none: a
    pressure whose nodes have 1 - a and 1 + a in turn has 2 a. The root mean square is weighted with the pressures; the
    nodes at both ends, where pressures may have no limit, are left out.

    - `pressures`: of the nodes along the surface, >= 0, shape (n,); the oscillation of fewer than seven is 0.
    """
    inner = pressures[1:-1]
    if len(inner) < len(FOURTH):
        return 0.0
    wave = np.convolve(inner, FOURTH / 8.0, "valid")
    mean = np.convolve(inner, np.abs(FOURTH) / 16.0, "valid")
    return float(np.sqrt((wave**2 / mean).sum() / mean.sum()))


def pressure_remark(n_segments: float, oscillation: float) -> str | None:
    """Return why the pressures of a region that is some segments wide are not reliable; None if they are."""
    if n_segments < MIN_SEGMENTS:
        return f"only {n_segments:g} segment{'' if n_segments == 1 else 's'} wide"
    if oscillation > MAX_OSCILLATION:
        return f"oscillates by {100.0 * oscillation:.0f} %"
    return None


def pressure_patches(system: ContactSystem, state: ContactState) -> list[PressurePatch]:
    """Regions of contact of a solution, contact by contact along the secondary surfaces."""
    patches = []
    for number, (contact, pairs, _, forces) in enumerate(system.solved(state.linearisation, state.forces)):
        points, others = (state.positions[system.nodes_of(surface)] for surface in contact.sides)
        patches += [
            _patch(number, contact, pairs, (points, others), forces, group, keys)
            for group, keys in contact_regions(contact, pairs, forces)
        ]
    return patches


AXIS_NODES = 5
"""Nodes from an axis of revolution on within which pressures of linear elements are off by more than a per cent."""


@dataclass(frozen=True, eq=False)
class ContactLine:
    """Pressure and gap at the nodes of the secondary surface of a contact that may have a constraint.

    Parameters
    ----------
    contact
        The contact.
    nodes
        Numbers of the nodes in the space of the secondary body, along its surface, shape (n,).
    lines
        Nodes that follow each other on the surface, positions in ``nodes``, shape (m, 2).
    positions
        Of the nodes in space, shape (n, 2).
    pressures
        See `PressurePatch`; 0 where the contact is open, shape (n,).
    gaps
        To the primary surface, negative where it is penetrated; not-a-number where nothing is within reach. Shape (n,).
    tractions, slips
        Of friction, on the secondary along the primary's edges, whose body is on their left; slips of the last step,
        each (n,).

    """

    contact: Contact
    nodes: Ints
    lines: Ints
    positions: Floats
    pressures: Floats
    gaps: Floats
    tractions: Floats
    slips: Floats


def contact_lines(system: ContactSystem, state: ContactState) -> list[ContactLine]:
    """Pressures and gaps along the secondary surfaces of all contacts."""
    patches, of_contacts = pressure_patches(system, state), []
    for number, (contact, pairs, inside, _) in enumerate(system.solved(state.linearisation, state.forces)):
        surface, unguarded = contact.secondary, ~pairs.guarded
        nodes = np.unique(contact.pairing.key_nodes(surface)).astype(np.int64)
        n, pressures = len(surface.nodes), np.zeros(len(surface.nodes))
        for patch in patches:
            if patch.contact == number:
                np.maximum.at(pressures, patch.nodes, patch.pressures)
        with np.errstate(invalid="ignore"):
            gaps = np.bincount(pairs.nodes[unguarded], pairs.gaps[unguarded], n) / np.bincount(
                pairs.nodes[unguarded], minlength=n
            )
        lines = np.column_stack((np.arange(len(nodes)), np.roll(np.arange(len(nodes)), -1)))
        of_contacts.append(
            ContactLine(
                contact,
                surface.nodes[nodes].astype(np.int64),
                lines if surface.is_closed else lines[:-1],
                state.positions[system.nodes_of(surface)[nodes]],
                pressures[nodes],
                gaps[nodes],
                *(values[nodes] for values in _sliding(pairs, state, inside, n)),
            )
        )
    return of_contacts


def _sliding(pairs: Constraints, state: ContactState, inside: slice, n: int) -> tuple[Floats, Floats]:
    """Tractions and slips at the n nodes of a surface; those of several constraints of a node are averaged."""
    if state.friction is None:
        return np.zeros(n), np.zeros(n)
    at, areas = pairs.nodes, pairs.areas * (state.forces[inside] > 0.0)
    whole = np.maximum(np.bincount(at, areas, n), 1e-300)
    slips = np.bincount(at, areas * state.friction.slips[inside], n) / whole
    return np.bincount(at, state.friction.forces[inside], n) / whole, slips


def _patch(
    number: int,
    contact: Contact,
    pairs: Constraints,
    positions: tuple[Floats, Floats],
    forces: Floats,
    group: Ints,
    keys: Ints,
) -> PressurePatch:
    """Patch of the constraints in ``group``, sorted along the surface; those of one key are added up.

    - `positions`: of the nodes of the secondary and of the primary surface.
    """
    points = positions[0]
    nodes, force = pairs.nodes[group], forces[group]
    share = force / force.sum()

    secondary, primary = contact.sides
    key_nodes = contact.pairing.key_nodes(secondary)[keys]
    n, lengths = len(points), chain_lengths(points[np.append(np.arange(len(points)), 0)])
    numbers = _unwrapped(key_nodes, nodes, n)
    along = lengths[numbers % n] + lengths[-1] * (numbers // n)
    on_secondary = secondary.part.body.nodes[secondary.nodes[nodes]]
    on_primary = pairs.opposite_points(primary.undeformed_edges)[group]
    touched = np.isin(pairs.rows, group).any(axis=1)
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    reached = np.append(numbers, _unwrapped(key_nodes, key_nodes, n))
    faced = np.arange(reached.min(), min(reached.max() + 1, reached.min() + n)) % n
    first, total = group[starts], np.add.reduceat(force, starts)
    return PressurePatch(
        number,
        key_nodes[starts],
        points[nodes[starts]],
        (along - share @ along)[starts],
        np.add.reduceat(force[:, None] * _directions(pairs)[group], starts),
        total,
        _recovered_at_axis(
            _pressures(
                total,
                pairs.areas[first],
                pairs.whole_areas[first],
                MIN_AREA_RATIO if isinstance(contact.pairing, NodeToNode) else 0.0,
            ),
            pairs.areas[first],
            on_secondary[starts, 0],
            contact,
        ),
        float(_lengths(contact)[faced].sum()),
        share @ on_secondary,
        share @ on_primary,
        (not secondary.is_closed and _reaches_end(nodes, n))
        or (not primary.is_closed and _reaches_end(pairs.primary_edges[touched], len(primary.edges))),
        1 if isinstance(contact.pairing, SegmentToSegment) else secondary.edge_nodes.shape[1] - 1,
        _corner_in(contact, points[faced], positions),
        _is_about_axis(secondary, numbers % n),
    )


def _is_about_axis(surface: Surface, nodes: Ints) -> bool:
    """Whether nodes of a body of revolution are in contact up to its axis: the first one is on an edge that ends there.

    The mean of the gap of a node on the axis has little weight, so that this node may be open.
    """
    body = surface.part.body
    if not body.axisymmetric:
        return False
    radii = body.nodes[surface.nodes, 0]
    on_axis = np.abs(radii) <= EPS * body.size
    near_axis = np.unique(surface.edge_places[on_axis[surface.edge_places].any(axis=1)])
    return bool(np.isin(nodes, near_axis).any())


def _corner_in(contact: Contact, region: Floats, positions: tuple[Floats, Floats]) -> tuple[float, float] | None:
    """First sharp corner of either body in a region of contact with nodes at points (n, 2) that no corner faces.

    - `positions`: of the nodes of both surfaces, each (n_nodes, 2).
    """
    places = [surface.sharp_places for surface in contact.sides]
    corners = [at[numbers] for at, numbers in zip(positions, places, strict=True)]
    length = max(float(surface.edge_lengths.min()) for surface in contact.sides)
    for own, other in (corners, corners[::-1]):
        for corner in own:
            to_region, to_others = (norms(points - corner).min(initial=np.inf) for points in (region, other))
            if to_region <= length and to_others > length / 2.0:
                return as_point(corner)
    return None


def _lengths(contact: Contact) -> Floats:
    """Length of the secondary surface that belongs to each of its nodes, shape (n_nodes,).

    Of bodies of revolution, whose nodes' areas go around the axis, up to the middles between nodes with constraints.
    """
    surface = contact.secondary
    body = surface.part.body
    if not body.axisymmetric:
        return contact.node_areas / body.thickness
    lengths, nodes = np.zeros(len(surface.nodes)), np.unique(contact.pairing.key_nodes(surface))
    starts, ends = (nodes, np.roll(nodes, -1)) if surface.is_closed else (nodes[:-1], nodes[1:])
    apart = norms(np.subtract(*body.nodes[surface.nodes[np.array([ends, starts])]])) / 2.0
    np.add.at(lengths, starts, apart)
    np.add.at(lengths, ends, apart)
    return lengths


def _unwrapped(key_nodes: Ints, nodes: Ints, n: int) -> Ints:
    """Numbers (m,) of nodes near those of constraints in order, which go on beyond n where these pass a closed seam."""
    starts = key_nodes + n * np.cumsum(np.diff(key_nodes, prepend=key_nodes[:1]) < 0)
    return starts + (nodes - key_nodes + n // 2) % n - n // 2


def _pressures(forces: Floats, areas: Floats, whole_areas: Floats, least: float = 0.0) -> Floats:
    """Pressures of the nodes of a patch, along the surface.

    Nodes with less than a part `least` of the area of one beside them have the mean pressure of both.
    """
    of_node = _groups(areas, least)
    if of_node[-1] + 1 < len(of_node):
        one, two, three = (np.bincount(of_node, weights).astype(np.float64) for weights in (forces, areas, whole_areas))
        return _pressures(one, two, three)[of_node]
    n = len(forces)
    slivers = areas < MIN_FACED_FRACTION * whole_areas
    if n == 1:
        return forces / np.where(slivers, MIN_FACED_FRACTION * whole_areas, areas)
    label = np.arange(n)
    for sliver in np.flatnonzero(slivers):
        sides = [side for side in (sliver - 1, sliver + 1) if 0 <= side < n]
        label[label == label[sliver]] = label[max(sides, key=lambda side: areas[side])]
    return (np.bincount(label, forces, n) / np.maximum(np.bincount(label, areas, n), 1e-300))[label]


def _recovered_at_axis(pressures: Floats, areas: Floats, radii: Floats, contact: Contact) -> Floats:
    """Pressures at an axis of revolution: of linear elements, the parabola c0 + c2 r^2 of the same force.

    Linear elements bend a surface of curvature 1/R by shear that is off by about h/R beside the axis, where the areas
    of nodes are small. So pressures are off by a multiple of h/a: -23 % and +9 % at the first two of eight segments of
    a sphere's contact. A node on the axis that is off to the other side, as at a cone's peak, stays.
    """
    surface = contact.secondary
    body = surface.part.body
    inwards = len(radii) > 1 and radii[-1] < radii[0]
    at = slice(None, -AXIS_NODES - 1, -1) if inwards else slice(0, AXIS_NODES)
    is_linear = body.axisymmetric and surface.edge_nodes.shape[1] == 2
    if not is_linear or len(radii) < AXIS_NODES or radii[at][0] > ON_AXIS * body.size:
        return pressures
    basis, root = np.vander(radii[at] ** 2 / radii[at].max() ** 2, 2), np.sqrt(areas[at])
    curvature, middle = np.linalg.lstsq(basis * root[:, None], pressures[at] * root, rcond=None)[0]
    if (pressures[at][0] - middle) * curvature <= 0.0:
        return pressures
    recovered = pressures.copy()
    recovered[at] = basis @ (curvature, middle)
    return recovered


def _groups(areas: Floats, least: float) -> Ints:
    """Number of the group of each node along a surface; groups have at least a part of their neighbours' areas."""
    sums, sizes = areas.tolist(), [1] * len(areas)
    while True:
        beside = [max(sums[max(i - 1, 0) : i] + sums[i + 1 : i + 2], default=0.0) for i in range(len(sums))]
        short = [i for i, area in enumerate(sums) if area < least * beside[i]]
        if not short:
            return np.repeat(np.arange(len(sums)), sizes)
        i = min(short, key=sums.__getitem__)
        j = i + 1 if i + 1 < len(sums) and sums[i + 1] == beside[i] else i - 1
        for values in (sums, sizes):
            values[j] += values[i]
            del values[i]


def _directions(pairs: Constraints) -> Floats:
    """Resultant on the secondary side of a unit force of each constraint, shape (m, 2)."""
    of_parts = []
    for part in pairs.parts:
        of_terms = part.gradients[:, :, : part.secondary_members.shape[1]].sum(axis=2)
        of_parts.append(sums_at(part.rows, of_terms, len(part.keys)))
    return np.concatenate(of_parts)


def _reaches_end(members: Ints, n_all: int) -> bool:
    return bool(members.min() == 0 or members.max() == n_all - 1)


# --- What makes a contact pressure wrong or rough although the iteration converged.


SMALL_PENETRATION = 0.05
"""Penetration relative to the elastic sinking of the surfaces: about the relative error that it makes in the
pressure."""

MAX_PENETRATION = 1.0
MAX_PULL = 1e-9
MAX_TURN = np.deg2rad(30.0)  # turn at the end of a surface below which the boundary goes on as the same surface


@dataclass(frozen=True)
class ContactChecks:
    """What was found.

    - `errors`: sentences about what makes the result wrong.
    - `warnings`: sentences about what makes it less exact.
    """

    errors: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def check_contact(
    system: ContactSystem,
    state: ContactState,
    patches: Sequence[PressurePatch],
    names: Sequence[str] = (),
    finer: str = "take smaller elements there",
    stiffer: str = "raise the penalty",
) -> ContactChecks:
    """Check the regions of contact of a solution, independently of the iteration that found it.

    Errors: forces or positions that are not finite, nodes that pull, and a penetration of the size of the elastic
    sinking p a / E* (maximum pressure, half width, modulus of contact; for Hertz's contact it is the height of the
    circle over the half width). Warnings: a penetration above 5 % of that, or a gap that
    a barrier leaves, straight edges in contact whose distance h^2 / 8 R from their curve is above it, regions of fewer
    than 8 segments, and a pressure that oscillates from node to node.

    Parameters
    ----------
    system, state
        The contacts and their solution.
    patches
        Its regions of contact, see `pressure_patches`.
    names
        What the contacts are called in the sentences, one for each; left out: the names of their bodies.
    finer, stiffer
        How to get a finer mesh and a stiffer contact, for the advice.

    Raises
    ------
    InputError
        If there are names, but not one for each contact.

    """
    if not (np.isfinite(state.forces).all() and np.isfinite(state.positions).all()):
        return ContactChecks(errors=("forces or positions are not finite numbers",))
    contacts = system.contacts
    names = names or [
        f"the contact of {contact.secondary.part.name} and {contact.primary.part.name}" for contact in contacts
    ]
    if isinstance(names, str) or len(names) != len(contacts):
        raise InputError(
            f"check_contact: names={short(names)}",
            f"a list of {len(contacts)}, one name for each contact",
            "leave them out for the names of the parts",
        )
    errors: list[str] = []
    warnings: list[str] = []
    solved = system.solved(state.linearisation, state.forces)
    for number, ((contact, pairs, _, forces), name) in enumerate(zip(solved, names, strict=True)):
        if forces.min(initial=0.0) < -MAX_PULL * max_magnitude(forces):
            errors.append(f"{name} pulls with {-forces.min():.3g} N at a node, which contact cannot")
        own_patches = [patch for patch in patches if patch.contact == number]
        depth = float(-pairs.gaps[forces > 0.0].min(initial=0.0))
        sinking = max((_sinking(contact, patch) for patch in own_patches), default=np.inf)
        if depth > SMALL_PENETRATION * sinking:
            too_soft = (
                f"the penetration of {name}, {depth:.1e} mm, is {100.0 * depth / sinking:.0f} % of what the "
                f"surfaces sink; {stiffer}"
            )
            (errors if depth > MAX_PENETRATION * sinking else warnings).append(too_soft)
        facets = _facet_depth(contact, pairs, np.flatnonzero(forces > 0.0))
        if facets > SMALL_PENETRATION * sinking:
            drawn = contact.secondary.curve is not None and contact.primary.curve is not None
            warnings.append(
                f"straight edges in {name} are up to {facets:.1e} mm off the smooth curves they approximate, "
                f"{100.0 * facets / sinking:.0f} % of what the surfaces sink, which makes its pressures wrong; "
                f"{'' if drawn else 'give its surfaces their drawn curves (curved), or '}{finer}"
            )
        corners = dict.fromkeys(patch.corner for patch in own_patches if patch.corner)
        warnings += [
            f"the maximum pressure of {name} is at a sharp corner, at ({x:.4g}, {y:.4g}), where it has no limit: it "
            "grows with finer elements; round the corner off for a maximum"
            for x, y in corners
        ]
        for patch in own_patches:
            warnings += roughness(patch.n_segments, patch.oscillation, name, finer)
    return ContactChecks(tuple(errors), tuple(warnings))


def cut_zones(system: ContactSystem, state: ContactState) -> tuple[Surface, ...]:
    """Surfaces at whose ends there is contact, while the body's boundary goes on there without a corner.

    Contact beyond such an end is missed, unless it was left out on purpose.
    """
    cut: list[Surface] = []
    for contact, pairs, _, forces in system.solved(state.linearisation, state.forces):
        loaded = np.flatnonzero(forces > 0.0)
        if len(loaded):
            cut += _cut(contact, pairs, loaded)
    return tuple(cut)


def roughness(n_segments: float, oscillation: float, name: str, finer: str) -> list[str]:
    """Sentence about a region of contact called `name` whose pressure is not reliable; none if it is."""
    remark = pressure_remark(n_segments, oscillation)
    if remark is None:
        return []
    if n_segments < MIN_SEGMENTS:
        return [f"{name} is {remark}, fewer than {MIN_SEGMENTS}; {finer} for a reliable pressure"]
    return [f"the pressure of {name} {remark} from node to node; {finer}"]


def _facet_depth(contact: Contact, pairs: Constraints, loaded: Ints) -> float:
    """Sum of the maximum distances of both sides' edges in contact from the curves they approximate."""
    secondary = np.isin(contact.secondary.edge_places, pairs.nodes[loaded]).any(axis=1)
    primary = pairs.primary_edges[np.isin(pairs.rows, loaded).any(axis=1)]
    depths = contact.secondary.facet_depth[secondary], contact.primary.facet_depth[primary]
    return sum(float(depths_of_side.max(initial=0.0)) for depths_of_side in depths)


def _sinking(contact: Contact, patch: PressurePatch) -> float:
    """Maximum pressure times half width over the modulus of contact."""
    softness = sum(part.body.softness for part in contact.parts)
    return float(patch.pressures.max()) * patch.half_width * softness


def _cut(contact: Contact, pairs: Constraints, loaded: Ints) -> list[Surface]:
    nodes, edges = pairs.nodes[loaded], pairs.primary_edges[np.isin(pairs.rows, loaded).any(axis=1)]
    ends = {
        contact.secondary: (nodes.min() == 0, nodes.max() == len(contact.secondary.nodes) - 1),
        contact.primary: (edges.min() == 0, edges.max() == len(contact.primary.edges) - 1),
    }
    surfaces = []
    for surface, reached in ends.items():
        first, last = reached[::-1] if surface.part.placement.mirrored else reached
        if (first and _goes_on(surface, forwards=False)) or (last and _goes_on(surface, forwards=True)):
            surfaces.append(surface)
    return surfaces


def _goes_on(surface: Surface, *, forwards: bool) -> bool:
    """Whether the boundary has a further edge beyond an end, hardly turned against the last one."""
    body = surface.part.body
    last_edge = surface.edges[-1 if forwards else 0]
    outer = body.boundary_edges
    beyond = outer[outer[:, 0] == last_edge[1]] if forwards else outer[outer[:, 1] == last_edge[0]]
    if len(beyond) != 1 or (surface.edges == beyond[0]).all(axis=1).any():
        return False
    (ax, ay), (bx, by) = (body.nodes[edge[1]] - body.nodes[edge[0]] for edge in (last_edge, beyond[0]))
    return bool(abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)) < MAX_TURN)
