"""A loaded rail along the track: deflection, roll, gauge, reactions of the sleepers, stresses at the free surface."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from flangeway.elements import Reconstruction
from flangeway.errors import InputError
from flangeway.geometry import Outline, Placement
from flangeway.mesh import PolyMesh
from flangeway.mesh.connectivity import ordered_pairs
from flangeway.post.lines import polynomials_at
from flangeway.post.patch_stresses import SpatialStresses, summed_stresses
from flangeway.railway.profiles.bundled import RailProfile
from flangeway.railway.profiles.measures import GAUGE_DEPTH_MM
from flangeway.railway.wheelset.supported_rail import SPREAD, SupportedRail
from flangeway.space import CellBatch
from flangeway.types import Floats, Ints

WEB_SHARES = np.linspace(0.2, 0.75, 221)
"""Heights over that of the rail between which the web's narrowest place is sought."""

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
    place = int(np.argmin(right - left))
    return float(heights[place]), float(left[place]), float(right[place])


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
    nodes, loads, reactions = zip(*(_on_head(rail, each) for each in loaded), strict=True)
    # each rail has two columns: by its forces in the section, and by those along z
    columns = block_diag(*(each.reshape(-1, 2) for each in loads)).reshape(-1, 3, 2 * len(loaded))
    fields = rail.released(rail.answers(np.concatenate(nodes), columns))
    return [
        _along(rail, profile, z, gauge_depth_mm, each.placement, of_seats, fields[..., 2 * i : 2 * i + 2])
        for i, (each, of_seats) in enumerate(zip(loaded, reactions, strict=True))
    ]


def _on_head(rail: SupportedRail, loaded: LoadedRail) -> tuple[Ints, Floats, Floats]:
    """Nodes (m,) of the edges of a rail's points, their loads (m, 3, 2), and `SupportedRail.seat_forces`."""
    points, forces = (np.asarray(each, dtype=np.float64) for each in loaded[:2])
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
        rail.support.sleepers_mm,
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
    wavenumbers, places = rail.wavenumbers, rail.support.sleepers_mm
    even, odd = rail.weights_at(z, LOADED_MM, 1)
    # sources: forces in the section, and along z, whose waves are a quarter of a length ahead; modes of the seats
    cosine, sine = np.zeros((2, len(z), len(wavenumbers), 5))
    cosine[..., 0], sine[..., 0], cosine[..., 1], sine[..., 1] = even, odd, -odd, even
    fields = np.concatenate((by_forces, rail.by_seats), axis=-1)
    if len(places):
        even, odd = rail.weights_at(z[:, None] - places, rail.support.pad_length_mm, 1)
        cosine[..., 2:], sine[..., 2:] = (np.einsum("zsk,sm->zkm", each, reactions) for each in (even, odd))
    found = [
        np.einsum("zkm,kdim->zdi", weights * factor[:, None], fields, optimize=True)
        for weights in (cosine, sine)
        for factor in (np.ones(len(wavenumbers)), wavenumbers)
    ]
    return np.stack(found[:2]), np.stack(found[2:])


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
    found = SpatialStresses(components.swapaxes(0, 1).reshape(-1, 6))
    return RailStresses(points, regions, z, components[..., 2].T, found.von_mises.reshape(len(z), -1))


def _surface(mesh: PolyMesh, profile: RailProfile) -> tuple[NDArray[np.int32], NDArray[np.str_]]:
    """Edges of the surface below the head, and their regions."""
    base = np.vstack([mesh.edge_set(name) for name in dict.fromkeys(profile.held_names)])
    head = np.vstack([mesh.edge_set(name) for name in dict.fromkeys(profile.running_names)])
    taken = mesh.edge_numbers(np.vstack((base, head)))
    free = mesh.boundary_edges[~np.isin(mesh.edge_numbers(mesh.boundary_edges), taken)]
    height, left, right = narrowest_web(profile.outline)
    found, regions = [base], [np.full(len(base), "foot", dtype="U12")]
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
            mine = np.array(names, dtype="U12")[steps]
            found.append(chain[part][mine != ""])
            regions.append(mine[mine != ""])
    return np.vstack(found), np.concatenate(regions)
