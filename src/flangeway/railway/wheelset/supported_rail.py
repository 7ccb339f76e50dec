"""A rail on sleepers in three dimensions, and what the load makes of it along the track."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from flangeway.elements import Lagrange, Reconstruction
from flangeway.elements.quadrature import edge_shapes
from flangeway.errors import InputError, short
from flangeway.geometry import Outline, Placement
from flangeway.geometry.arrays import nearest_on_segments
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, triangulate
from flangeway.mesh.connectivity import ordered_pairs
from flangeway.post.patch_stresses import SpatialStresses, summed_stresses
from flangeway.post.stress import polynomials_at
from flangeway.problems import Elasticity, Foundation, Harmonic
from flangeway.problems.harmonic import mean_and_rotation
from flangeway.problems.loads import edge_quadrature
from flangeway.railway.profiles.bundled import RailProfile
from flangeway.railway.profiles.orientation import GAUGE_DEPTH_MM
from flangeway.railway.track.supports import Continuous, Sleepers
from flangeway.solve.surface_compliance import amplitudes, inverse_weights
from flangeway.space import CellBatch, Space
from flangeway.system.disk_cache import Cache, cached
from flangeway.types import Floats, Ints

# --- A rail on sleepers in three dimensions, from its section at many wavenumbers.
#
# All is a sum over wavenumbers of the section's amplitudes. Sleepers are superposed in two steps. At each wavenumber
# all but a share `SPREAD` of the continuous support, of stiffness K per length, is taken away: fields A that loads of
# the base's modes (forces along x and y, moment) cause, and their mean displacements G = M' A, become ``A (1 - (1 -
# SPREAD) K G)^-1``. Then forces of the seats, found from the compliance between them, take its place. The share that is
# left bounds the motion beyond the last sleepers, and changes the result by about that much of the difference between
# sleepers and continuous support.


HEIGHT_TOLERANCE = 1e-6
"""Height of a base, relative to the size of a section, that is round-off."""


def rail_problem(space: Space, material: Elastic, base_edges: str, support: Sleepers | Continuous) -> Harmonic:
    """Put a rail on its support, spread along z.

    What discrete sleepers change of it is `sleeper_compliance`.

    Parameters
    ----------
    space
        Section in its own frame, x across, y up.
    material
        Its material.
    base_edges
        Edge set of the whole base.
    support
        The support.

    Raises
    ------
    InputError
        If the edges are not the whole of a flat base.

    """
    mesh = space.mesh
    rule = edge_quadrature(space, mesh.edge_set(base_edges))
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    near = HEIGHT_TOLERANCE * float(np.linalg.norm(high - low))
    bottom = mesh.points[mesh.boundary_edges]
    bottom = bottom[(bottom[..., 1] <= low[1] + near).all(axis=1)]
    whole, length = float(np.ptp(bottom[..., 0])) if len(bottom) else 0.0, float(rule.weights.sum())
    if float(rule.points[..., 1].max()) > low[1] + near or abs(length - whole) > near:
        raise InputError(
            f"edges {short(base_edges)} of {length:g} mm as the base of a rail, which is {whole:g} mm wide",
            "all edges of a flat base, and no others",
            "check the names of the outline's segments",
        )
    lateral, vertical, roll = support.per_length
    along = 1e3 * support.longitudinal_kN_per_mm / support.spacing_mm
    foundation = Foundation(base_edges, lateral / length, vertical / length, along / length, roll)
    return Harmonic(Elasticity(space, material, name="rail"), foundations=[foundation])


SPREAD = 0.003
"""Share of the sleepers' stiffness that stays spread along the rail."""
WAVENUMBERS = (5e-6, 0.3)
"""Range per mm: from the reach of torsion on the share that is spread to waves of 20 mm."""
PER_DECADE = 8
"""Wavenumbers for each decade; three times as many change no displacement by more than 1e-4."""
N_SLEEPERS = (21, 41, 61, 81, 101)
"""Sleepers about the wheel that act one by one: the first number that the load does not reach beyond."""
MAX_LAST_LOAD = 0.02
"""Load of the last sleepers relative to that of the most loaded one, above which there are too few."""
MAX_OFF_MM = 3.0
"""Distance from the section's surface above which points are in another frame; chords and corners make up to 1 mm."""
CHUNK = 64
"""Distances whose weights are computed together: bounds their memory."""


def weights_at(
    wavenumbers: Floats, distances: Floats, strip: float, averaged: int, cache: Cache | None = None
) -> tuple[Floats, Floats]:
    """`inverse_weights` at signed distances (...), each (..., n_k): of cosine and sine of ``k z``."""
    apart, of_distance = np.unique(np.round(np.abs(distances), 6).astype(np.float64), return_inverse=True)
    even, odd = _weights(tuple(wavenumbers.tolist()), tuple(apart.tolist()), strip, averaged, cache)
    of_distance = of_distance.reshape(distances.shape)
    return even[of_distance], np.sign(distances)[..., None] * odd[of_distance]


@lru_cache(maxsize=8)  # both rails and all positions ask for the same ones
def _weights(
    wavenumbers: tuple[float, ...], apart: tuple[float, ...], strip: float, averaged: int, cache: Cache | None
) -> tuple[Floats, Floats]:
    at, distances = np.array(wavenumbers), np.array(apart)

    def make() -> dict[str, Floats]:
        chunks = np.split(distances, range(CHUNK, len(distances), CHUNK))
        parts = [inverse_weights(at, part, strip, averaged) for part in chunks]
        even, odd = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        return {"even": even, "odd": odd}

    weights = cached(cache, make, "wave weights", at, distances, strip, averaged)
    return weights["even"], weights["odd"]


@dataclass(frozen=True, eq=False)
class SupportedRail:
    """A rail on its support.

    Parameters
    ----------
    problem
        The rail on its continuous support, see `rail_problem`.
    support
        The support; the wheel is at z = 0.
    cache
        Where the section's amplitudes are kept from one process to the next.

    """

    problem: Harmonic
    support: Sleepers | Continuous
    cache: Cache | None = None

    @property
    def wavenumbers(self) -> Floats:
        """Wavenumbers at which the section is solved, (n_k,)."""
        least, top = WAVENUMBERS
        return np.geomspace(least, top, int(np.ceil(PER_DECADE * np.log10(top / least))) + 1)

    def weights_at(self, distances: Floats, strip: float, averaged: int) -> tuple[Floats, Floats]:
        """`weights_at` at its wavenumbers."""
        return weights_at(self.wavenumbers, distances, strip, averaged, self.cache)

    @cached_property
    def base(self) -> tuple[Ints, Floats]:
        """Nodes of the base, and their forces by unit loads of its modes (even along x, along y, moment), (n, 3, 3)."""
        space = self.problem.elasticity.space
        edges = space.mesh.edge_set(self.problem.foundations[0].edges)
        nodes, (mean, slope), _ = mean_and_rotation(edge_quadrature(space, edges))
        loads = np.zeros((len(nodes), 3, 3))
        loads[:, 0, 0], loads[:, 1, 1], loads[:, 1, 2] = mean, mean, slope
        return nodes, loads

    def answers(self, nodes: Ints, loads: Floats) -> Floats:
        """Amplitudes at all wavenumbers by m loads (n, 3, m) at nodes (n,): (n_k, n_dofs, 3, m)."""
        space = self.problem.elasticity.space
        rhs = np.zeros((space.n_dofs, 3, loads.shape[-1]))
        np.add.at(rhs, nodes, loads)
        rhs = rhs.reshape(3 * space.n_dofs, 1, -1)
        displacements = np.stack(list(amplitudes(self.problem, self.wavenumbers, rhs)))
        return displacements.reshape(len(displacements), space.n_dofs, 3, -1)

    @cached_property
    def by_modes(self) -> Floats:
        """Amplitudes by the base's modes on the continuous support, (n_k, n_dofs, 3, 3 modes)."""
        elasticity = self.problem.elasticity
        mesh, foundation = elasticity.space.mesh, self.problem.foundations[0]
        content = (
            (mesh.points, mesh.cell_offsets, mesh.cell_points, mesh.edge_set(foundation.edges)),
            (elasticity.space.element, elasticity.material, foundation, WAVENUMBERS, PER_DECADE),
        )
        stored = cached(self.cache, lambda: {"amplitudes": self.answers(*self.base)}, "supported rail", *content)
        return stored["amplitudes"]

    @cached_property
    def freedom(self) -> Floats:
        """X = ((1 - SPREAD)^-1 K^-1 - G)^-1 at the wavenumbers, by which A X M' A is what spreading less adds."""
        kept = np.diag(1.0 / ((1.0 - SPREAD) * self.support.per_length))
        return np.linalg.inv(kept - self.on_base(self.by_modes)).astype(np.float64)

    def on_base(self, fields: Floats) -> Floats:
        """Mean displacements of the base along x, y and rotation, of fields (..., n_dofs, 3, m): (..., 3, m)."""
        nodes, loads = self.base
        return np.einsum("nia,...nim->...am", loads, fields[..., nodes, :, :])

    def released(self, fields: Floats) -> Floats:
        """Fields (n_k, n_dofs, 3, m) of the continuous support, as they are with only its share `SPREAD`."""
        if self.support.kind == "continuous":
            return fields
        change: Floats = self.freedom @ self.on_base(fields)
        return fields + np.einsum("kdia,kam->kdim", self.by_modes, change)

    @cached_property
    def by_seats(self) -> Floats:
        """Amplitudes by the base's modes with the share `SPREAD` of the support, (n_k, n_dofs, 3, 3 modes)."""
        return self.released(self.by_modes)

    @property
    def sleepers_mm(self) -> Floats:
        """Places of the sleepers along z from the wheel, shape (n_sleepers,); none if the support is continuous."""
        return self._seats[0]

    @property
    def seat_stiffness(self) -> Floats:
        """Forces of seats (minus) by the displacements that others cause there, (n_sleepers, 3, n_sleepers, 3).

        ``R = (K^-1 + G)^-1`` with the stiffnesses K of the seats and the compliance G between them. As many sleepers
        act one by one as the load reaches: a crossing, which is stiffer than a rail, spreads it over more. An
        `InputError` if these are more than `N_SLEEPERS`.
        """
        return self._seats[1]

    @cached_property
    def _seats(self) -> tuple[Floats, Floats]:
        support, last = self.support, 0.0
        if support.kind == "continuous":
            return np.empty(0), np.empty((0, 3, 0, 3))
        on_base = self.on_base(self.by_seats)
        for n in N_SLEEPERS:
            distances: Floats = support.spacing_mm * np.arange(float(n))
            even, _ = self.weights_at(distances, support.pad_length_mm, 2)
            by_distance = np.einsum("zk,kam->zam", even, on_base)
            apart = np.abs(np.arange(n)[:, None] - np.arange(n))
            between = by_distance[apart].transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)
            stiffness = np.linalg.inv(between + np.diag(np.tile(1.0 / ((1.0 - SPREAD) * support.of_seat), n)))
            # a load over the middle sleeper, each along its own mode
            carried = np.abs(np.einsum("sma,am->sm", stiffness.reshape(n, 3, -1), between[:, 3 * (n // 2) :][:, :3]))
            last = float((carried[[0, -1]] / carried.max(axis=0)).max())
            if last <= MAX_LAST_LOAD:
                return support.sleepers_mm(n), stiffness.reshape(n, 3, n, 3)
        raise InputError(
            f"a load that reaches beyond {N_SLEEPERS[-1]} sleepers, the last with {last:.2g} of the largest load",
            f"seats on which less than {MAX_LAST_LOAD:g} reaches it",
            "raise the stiffness or the spacing of the seats, or take a continuous support",
        )

    def on_surface(self, points: Floats) -> tuple[Ints, Floats]:
        """Nodes of the boundary's edges nearest to points (n, 2), and their shares at the feet, each (n, order + 1).

        Points of another mesh of the section lie off these chords where the outline turns, most at the joints of a
        measured head with its body: they are projected. An `InputError` if one is farther away than `MAX_OFF_MM`.
        """
        space = self.problem.elasticity.space
        edges = space.mesh.boundary_edges
        best, shares, distances = nearest_on_segments(points, *space.mesh.points[edges].swapaxes(0, 1))
        if (maximum := float(distances.max(initial=0.0))) > MAX_OFF_MM:
            raise InputError(
                f"points up to {maximum:.3g} mm from the surface of `{self.problem.elasticity.name}`",
                "points on the surface, in the frame of the section",
                "check the placement of the rail",
            )
        return space.edge_nodes(edges)[best].astype(np.int64), edge_shapes(space.order, shares)

    @property
    def pad_mm(self) -> float:
        """Length of a seat along the rail; a continuous support has no seats."""
        return self.support.pad_length_mm if isinstance(self.support, Sleepers) else 0.0

    def seats_from(self, nodes: Ints, shares: Floats) -> Floats:
        """Displacements of points at z = 0 by unit loads of the seats: (n, 3, n_sleepers, 3).

        By reciprocity they are also the displacements of the seats by unit forces at the points.
        """
        at_points = np.einsum("np,knpim->knim", shares, self.by_seats[:, nodes])
        even, odd = self.weights_at(-self.sleepers_mm, self.pad_mm, 1)
        displacements = np.einsum("sk,knim->nism", even, at_points)
        displacements[:, 2] = np.einsum("sk,knm->nsm", odd, at_points[:, :, 2])
        return displacements

    def seat_forces(self, nodes: Ints, shares: Floats, forces: Floats) -> Floats:
        """Loads of the seats on the rail by forces (n, 3) at points at z = 0: (n_sleepers, 3)."""
        if self.support.kind == "continuous":
            return np.empty((0, 3))
        moved = np.einsum("nism,ni->sm", self.seats_from(nodes, shares), forces)
        return -np.einsum("satb,tb->sa", self.seat_stiffness, moved)


def supported_rail(
    profile: RailProfile,
    material: Elastic,
    support: Sleepers | Continuous,
    size_mm: float = 6.0,
    cache: Cache | None = None,
) -> SupportedRail:
    """Mesh a rail's section by triangles of order 2 and a size, for what a support does to it.

    Only smooth fields come from this mesh; contact wants a finer one, see `rail_problem`.
    """
    mesh = triangulate(profile.outline, size=size_mm)
    mesh = mesh.with_edge_set("supported base", np.vstack([mesh.edge_set(name) for name in profile.held_names]))
    problem = rail_problem(Space(mesh, Lagrange(2)), material, "supported base", support)
    return SupportedRail(problem, support, cache)


def sleeper_compliance(rail: SupportedRail, points: Floats, frames: Floats) -> Floats:
    """What discrete sleepers change of the compliance of cells near z = 0 on a continuous support.

    It is taken at the wheel's place as constant over a patch: 10 mm from there it differs by less than 0.15 % of the
    rail's whole compliance. The coarse section errs by 2 % of the difference.

    Parameters
    ----------
    rail
        The rail, in its own frame.
    points
        Middles of cells on the surface of any mesh of the section, (n, 2).
    frames
        Axes t, n and z of the cells as rows, (n, 3, 3), see `flangeway.solve.SurfaceCells`.

    Returns
    -------
    Floats
        Displacements by unit forces, mm/N, (n, 3, n, 3), symmetric; zero for a continuous support.

    """
    if rail.support.kind == "continuous":
        return np.zeros((len(points), 3, len(points), 3))
    nodes, shares = rail.on_surface(points)
    seats = rail.seats_from(nodes, shares)
    n, n_loads = len(points), 3 * len(rail.sleepers_mm)
    in_axes = np.einsum("nai,nim->nam", frames, seats.reshape(n, 3, n_loads)).reshape(3 * n, n_loads)
    taken = in_axes @ rail.seat_stiffness.reshape(n_loads, n_loads) @ in_axes.T
    fields = np.einsum("nai,np,knpim->knam", frames, shares, rail.by_modes[:, nodes], optimize=True)
    fields = fields.reshape(len(fields), 3 * n, 3)
    at_place = rail.weights_at(np.zeros(1), rail.pad_mm, 0)[0][0]
    added = np.einsum("k,krm,kmj,kcj->rc", at_place, fields, rail.freedom, fields, optimize=True).reshape(n, 3, n, 3)
    added[:, :2, :, 2] = added[:, 2, :, :2] = 0.0  # they vary as the sine
    change: Floats = added - taken.reshape(n, 3, n, 3)
    return change


# --- A loaded rail along the track: deflection, roll, gauge, reactions of the sleepers, stresses at the free surface.


WEB_SHARES = np.linspace(0.2, 0.75, 221)
"""Heights relative to that of the rail between which the web's narrowest place is sought."""

DEVIATION_MM = 0.02  # of chords from the outline, for widths and heights


def narrowest_web(outline: Outline) -> tuple[float, float, float]:
    """Height of a rail's narrowest place between foot and head, and x of the two faces there, in its own frame."""
    points = outline.sampled(max_deviation=DEVIATION_MM, spacing=5.0)
    (_, low), (_, high) = outline.bounds()
    heights = low + WEB_SHARES * (high - low)
    first, second = points, np.roll(points, -1, axis=0)
    rise = second[:, 1] - first[:, 1]
    crossed = (first[:, 1] <= heights[:, None]) != (second[:, 1] <= heights[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = first[:, 0] + (heights[:, None] - first[:, 1]) / rise * (second[:, 0] - first[:, 0])
    left = np.where(crossed, x, np.inf).min(axis=1)
    right = np.where(crossed, x, -np.inf).max(axis=1)
    row = int(np.argmin(right - left))
    return float(heights[row]), float(left[row]), float(right[row])


def head_motion(mesh: PolyMesh, displacement: Floats, profile: RailProfile) -> tuple[Floats, Floats, float]:
    """Centre of the head, its translation and its counter-clockwise rotation, least squares by the cells' areas."""
    foot = float(profile.outline.bounds(profile.running_names)[0, 1])
    in_head = mesh.cell_centroids[:, 1] > foot
    starts = mesh.cell_offsets[:-1]
    means = np.add.reduceat(displacement[mesh.cell_points], starts, axis=0) / mesh.cell_sizes[:, None]
    points, moves, areas = mesh.cell_centroids[in_head], means[in_head], mesh.cell_areas[in_head]
    centre, shift = areas @ points / areas.sum(), areas @ moves / areas.sum()
    arms = points - centre
    turn = areas @ (arms[:, 0] * moves[:, 1] - arms[:, 1] * moves[:, 0]) / (areas @ np.sum(arms**2, axis=1))
    return centre, shift, float(turn)


def top_and_gauge(profile: RailProfile, matrix: Floats, depth_mm: float) -> tuple[Floats, Floats]:
    """Highest point of the inclined head and its gauge face at a depth below, in the frame of the profile."""
    points = profile.running_surface.sampled(max_deviation=DEVIATION_MM, spacing=1.0)
    heights = points @ matrix[1]
    top = int(np.argmax(heights))
    gauge = points[top:][np.argmin(np.abs(heights[top:] - heights[top] + depth_mm))]
    return points[top], gauge


REGIONS = ("web", "upper fillet", "lower fillet", "foot")
UPRIGHT, LEVEL = 0.25, 0.9
"""Vertical part of a normal up to which a face is the web's, and from which it is the foot's or the head's."""
LOADED_MM = 10.0
"""Length along the track over which forces are spread."""
NEAR_MM, FAR_MM = (25.0, 600.0), (100.0, 3000.0)
"""Usual step and end of the places along the track, near the load and beyond."""


@dataclass(frozen=True, eq=False)
class RailStresses:
    """Stresses at a rail's surface along the track.

    - `points_mm`: middles of the mesh's edges in the rail's own frame, shape (n, 2).
    - `regions`: which of `REGIONS` they belong to, shape (n,).
    - `z_mm`: places along the track, shape (n_z,).
    - `along_MPa`: normal stresses along the track, tension positive, shape (n_z, n).
    - `von_mises_MPa`: equivalent stresses, shape (n_z, n).
    """

    points_mm: Floats
    regions: NDArray[np.str_]
    z_mm: Floats
    along_MPa: Floats  # noqa: N815 (the unit megapascal)
    von_mises_MPa: Floats  # noqa: N815

    def peak(self, region: str, values: Floats) -> tuple[float, Floats]:
        """Value of the maximum magnitude in a region of `along_MPa` or `von_mises_MPa`, and its x, y and z (3,)."""
        inside = np.flatnonzero(self.regions == region)
        if len(inside) == 0:
            raise InputError(f"region {region!r}", f"one of {', '.join(REGIONS)}", "choose one of these")
        row, column = np.unravel_index(np.abs(values[:, inside]).argmax(), (len(values), len(inside)))
        return float(values[row, inside[column]]), np.append(self.points_mm[inside[column]], self.z_mm[row])


@dataclass(frozen=True, eq=False)
class RailAlongTrack:
    """A loaded rail along the track, in its own frame: x across, y up, rotations from x to y.

    - `z_mm`: places, the load at 0, shape (n_z,).
    - `base`: mean displacements of the base along x and y in mm, and its mean rotation in rad, shape (n_z, 3).
    - `head`: displacements of the rail's top and rotation, by the rigid motion that fits the head best, shape (n_z, 3).
    - `gauge_outward_mm`: displacement of the head at the gauge's depth away from the middle of the track, shape (n_z,).
    - `sleepers_mm`: places of the sleepers, shape (n_sleepers,); none on a continuous support.
    - `reactions`: of the sleepers on the rail: forces along x and y in N, moments about the middle of the base in N mm,
      shape (n_sleepers, 3); the stiffness of a seat times its displacement.
    - `stresses`: at the surface below the head.
    """

    z_mm: Floats
    base: Floats
    head: Floats
    gauge_outward_mm: Floats
    sleepers_mm: Floats
    reactions: Floats
    stresses: RailStresses


class LoadedRail(NamedTuple):
    """Forces on the head of a rail at z = 0.

    - `points`: on its surface in its own frame, (n, 2).
    - `forces`: there along x, y and z of that frame, (n, 3). They are spread over `LOADED_MM` along z: what is within a
      few times that of them depends on it.
    - `placement`: of the rail in the axes of the track, for the gauge; left out: upright, on the right.
    """

    points: Floats
    forces: Floats
    placement: Placement = Placement()


def rails_along_track(
    rail: SupportedRail,
    profile: RailProfile,
    loaded: Sequence[LoadedRail],
    gauge_depth_mm: float = GAUGE_DEPTH_MM,
    z_mm: Floats | None = None,
) -> list[RailAlongTrack]:
    """Follow rails of one section and support, which share its factorisations, along the track under forces.

    Parameters
    ----------
    rail
        The rail on its support.
    profile
        Its profile.
    loaded
        Forces on each rail.
    gauge_depth_mm
        Depth of the gauge face below the top.
    z_mm
        Places along the track; left out: up to 3 m on both sides.

    Raises
    ------
    InputError
        If points are off the surface, or arrays do not fit.

    """
    z = _usual_places() if z_mm is None else np.asarray(z_mm, dtype=np.float64)
    nodes, loads, reactions = zip(*(_on_head(rail, forces) for forces in loaded), strict=True)
    # each rail has two columns: by its forces in the section, and by those along z
    columns = block_diag(*(forces.reshape(-1, 2) for forces in loads)).reshape(-1, 3, 2 * len(loaded))
    fields = rail.released(rail.answers(np.concatenate(nodes), columns))
    return [
        _along(rail, profile, z, gauge_depth_mm, head.placement, of_seats, fields[..., 2 * i : 2 * i + 2])
        for i, (head, of_seats) in enumerate(zip(loaded, reactions, strict=True))
    ]


def _on_head(rail: SupportedRail, loaded: LoadedRail) -> tuple[Ints, Floats, Floats]:
    """Nodes (m,) of the edges of a rail's points, their loads (m, 3, 2), and `SupportedRail.seat_forces`."""
    points, forces = (np.asarray(array, dtype=np.float64) for array in loaded[:2])
    if points.shape[1:] != (2,) or forces.shape != (len(points), 3) or not np.isfinite(forces).all():
        raise InputError(
            f"points of shape {points.shape} and forces of shape {forces.shape}",
            "finite ones, (n, 2) and (n, 3)",
            "give forces along x, y and z at each point",
        )
    nodes, shares = rail.on_surface(points)
    along = np.array([0.0, 0.0, 1.0])
    loads = np.einsum("np,nif->npif", shares, np.stack((forces * (1.0 - along), forces * along), axis=-1))
    return nodes.ravel(), loads, rail.seat_forces(nodes, shares, forces)


def _along(
    rail: SupportedRail,
    profile: RailProfile,
    z: Floats,
    gauge_depth_mm: float,
    placement: Placement,
    reactions: Floats,
    fields: Floats,
) -> RailAlongTrack:
    """The rail at places z by the amplitudes of its forces, those in the section and along z, (n_k, n_dofs, 3, 2)."""
    even, odd = _summed(rail, fields, reactions, z)
    mesh = rail.problem.elasticity.space.mesh
    top, gauge = top_and_gauge(profile, placement.matrix, gauge_depth_mm)
    sign = -1.0 if placement.mirrored else 1.0
    head, outward = np.empty((len(z), 3)), np.empty(len(z))
    for i, displacement in enumerate(even[0, :, : mesh.n_points, :2]):
        centre, shift, turn = head_motion(mesh, displacement, profile)
        at_top, at_gauge = (shift + turn * np.array([centre[1] - y, x - centre[0]]) for x, y in (top, gauge))
        head[i] = *at_top, turn
        outward[i] = sign * placement.vectors([at_gauge])[0, 0]
    return RailAlongTrack(
        z,
        rail.on_base(even[0][..., None])[..., 0],
        head,
        outward,
        rail.sleepers_mm,
        reactions / (1.0 - SPREAD),
        _stresses(rail, profile, z, even, odd),
    )


def _usual_places() -> Floats:
    ends = [np.arange(-end, end + step / 2.0, step) for step, end in (NEAR_MM, FAR_MM)]
    return np.unique(np.concatenate(ends))


def _summed(rail: SupportedRail, by_forces: Floats, reactions: Floats, z: Floats) -> tuple[Floats, Floats]:
    """Sum all wavenumbers at places z: amplitudes that go with the cosine and the sine, each (2, n_z, n_dofs, 3).

    The first of the two is the sum, the second that of amplitudes times wavenumbers.
    """
    wavenumbers, sleepers = rail.wavenumbers, rail.sleepers_mm
    even, odd = rail.weights_at(z, LOADED_MM, 1)
    # sources: forces in the section, and along z, whose waves are a quarter of a length ahead; modes of the seats
    cosine, sine = np.zeros((2, len(z), len(wavenumbers), 5))
    cosine[..., 0], sine[..., 0], cosine[..., 1], sine[..., 1] = even, odd, -odd, even
    fields = np.concatenate((by_forces, rail.by_seats), axis=-1)
    if len(sleepers):
        even, odd = rail.weights_at(z[:, None] - sleepers, rail.pad_mm, 1)
        cosine[..., 2:], sine[..., 2:] = (np.einsum("zsk,sm->zkm", parts, reactions) for parts in (even, odd))
    sums = [
        np.einsum("zkm,kdim->zdi", weights * factor[:, None], fields, optimize=True)
        for weights in (cosine, sine)
        for factor in (np.ones(len(wavenumbers)), wavenumbers)
    ]
    return np.stack(sums[:2]), np.stack(sums[2:])


def _stresses(rail: SupportedRail, profile: RailProfile, z: Floats, even: Floats, odd: Floats) -> RailStresses:
    space = rail.problem.elasticity.space
    mesh = space.mesh
    edges, regions = _surface(mesh, profile)
    points = mesh.points[edges].mean(axis=1)
    cells = mesh.edge_cells[mesh.edge_numbers(edges)].max(axis=1).astype(np.int64)

    def polynomials(batch: CellBatch) -> tuple[Reconstruction, Floats]:
        reconstruction, stress = summed_stresses(rail.problem, batch, even, odd)
        return reconstruction, stress.reshape(-1, *stress.shape[2:])

    components = polynomials_at(space, points, cells, polynomials, 6 * len(z)).reshape(len(points), len(z), 6)
    stresses = SpatialStresses(components.swapaxes(0, 1).reshape(-1, 6))
    return RailStresses(points, regions, z, components[..., 2].T, stresses.von_mises.reshape(len(z), -1))


def _surface(mesh: PolyMesh, profile: RailProfile) -> tuple[NDArray[np.int32], NDArray[np.str_]]:
    """Edges of the surface below the head, and their regions."""
    base = np.vstack([mesh.edge_set(name) for name in dict.fromkeys(profile.held_names)])
    head = np.vstack([mesh.edge_set(name) for name in dict.fromkeys(profile.running_names)])
    taken = mesh.edge_numbers(np.vstack((base, head)))
    free = mesh.boundary_edges[~np.isin(mesh.edge_numbers(mesh.boundary_edges), taken)]
    height, left, right = narrowest_web(profile.outline)
    chains, regions = [base], [np.full(len(base), "foot", dtype="U12")]
    outer = mesh.points[free].mean(axis=1)[:, 0] > (left + right) / 2.0
    for side in (free[outer], free[~outer]):
        chain = ordered_pairs(side, "side of the rail")
        ends = mesh.points[chain]
        along = ends[:, 1] - ends[:, 0]
        level = np.abs(along[:, 0]) / np.linalg.norm(along, axis=1)
        heights = ends[..., 1].mean(axis=1)
        if heights[-1] < heights[0]:
            chain, level, heights = chain[::-1], level[::-1], heights[::-1]
        start = int(np.abs(heights - height).argmin())
        for part, names in (
            (slice(start, None), ("web", "upper fillet", "")),
            (slice(start, None, -1), ("web", "lower fillet", "foot")),
        ):
            steps = np.digitize(np.maximum.accumulate(level[part]), (UPRIGHT, LEVEL))
            region_names = np.array(names, dtype="U12")[steps]
            chains.append(chain[part][region_names != ""])
            regions.append(region_names[region_names != ""])
    return np.vstack(chains), np.concatenate(regions)
