"""Bending of the rails: motion of the head against the base, stresses in web and fillets."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flangeway.geometry import Outline
from flangeway.mesh import PolyMesh
from flangeway.mesh.connectivity import ordered_pairs
from flangeway.post import force_through_cut
from flangeway.problems import ElasticField
from flangeway.railway.profiles.bundled import RailProfile
from flangeway.railway.track.placements import SIDE_SIGN, Side, WheelsetPosition
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.types import Floats

Face = Literal["gauge", "field"]

WEB_SHARES = np.linspace(0.2, 0.75, 221)
"""Heights over that of the rail between which the web's narrowest place is sought."""

DEVIATION_MM = 0.02  # of chords from the outline, for widths and heights

GAUGE_DEPTH_MM = 14.0
"""Depth below the top of the gauge face whose displacement is reported, unless the track has its own (EN 13848-1)."""


@dataclass(frozen=True, eq=False)
class FaceStresses:
    """Stresses along a rail's free surface between head and base, on one side of the web.

    They are the strains of the mesh's edges times the plane modulus: nothing acts on the surface, so the other stress
    in the plane is zero.

    - `face`: ``gauge`` or ``field`` side.
    - `points_mm`: middles of the edges in the frame of the rail's profile, from the base up, shape (n, 2).
    - `outwards`: unit normals out of the rail there, shape (n, 2).
    - `stresses_MPa`: normal stress along the surface, tension positive, shape (n,).
    - `web_MPa`: that at the narrowest place of the web; nan if the surface does not pass it.
    """

    face: Face
    points_mm: Floats
    outwards: Floats
    stresses_MPa: Floats  # noqa: N815 (the unit megapascal)
    web_MPa: float  # noqa: N815

    def extreme(self, sign: float, above_mm: float = -np.inf, below_mm: float = np.inf) -> tuple[float, Floats]:
        """Maximum tension (sign 1) or compression (sign -1) between two heights in MPa, signed, and its place (2,).

        Not-a-number if no edge lies between the heights.
        """
        inside = (self.points_mm[:, 1] > above_mm) & (self.points_mm[:, 1] < below_mm)
        if not inside.any():
            return float("nan"), np.full(2, np.nan)
        place = int(np.argmax(np.where(inside, sign * self.stresses_MPa, -np.inf)))
        return float(self.stresses_MPa[place]), self.points_mm[place]


@dataclass(frozen=True, eq=False)
class RailBending:
    """How a rail bends on its base.

    - `head_motion`: rigid motion that fits best the displacement of the head, all that is above the ends of its running
      surface, by its cells' areas: translation of the rail's top in the track's axes, and counter-clockwise rotation.
    - `gauge_outward_mm`: motion of the fitted head at the height of the gauge away from the middle of the track.
    - `web_height_mm`, `web_thickness_mm`: narrowest place of the web, above the base.
    - `web_normal_N`, `web_shear_N`, `web_moment_Nmm`: what the upper part does to the lower one there: force along the
      web (tension positive), force across it and moment about the web's middle, in the frame of the rail's profile (x
      away from the track, counter-clockwise).
    - `faces`: stresses of the gauge and the field side.
    """

    side: Side
    head_motion: WheelsetPosition
    gauge_outward_mm: float
    web_height_mm: float
    web_thickness_mm: float
    web_normal_N: float  # noqa: N815 (the unit newton)
    web_shear_N: float  # noqa: N815
    web_moment_Nmm: float  # noqa: N815
    faces: tuple[FaceStresses, FaceStresses]


def rail_bending(result: WheelsetResult, side: Side) -> RailBending:
    """Bending of the rail of a side."""
    name = f"rail-{side}"
    track = result.model.problem.track
    profile, body, placement = track.rail_of(side), result.model.parts[name].body, result.placements[name]
    displacement = result.displacements[name]
    mesh = body.space.mesh
    centre, shift, turn = head_motion(mesh, displacement[: mesh.n_points], profile)

    def moved(point: Floats) -> Floats:
        arm = point - centre
        return placement.vectors([shift + turn * np.array([-arm[1], arm[0]])])[0]

    top, gauge = top_and_gauge(profile, placement.matrix, track.gauge_depth_mm or GAUGE_DEPTH_MM)
    lateral, vertical = moved(top)
    outward = float(moved(gauge)[0]) * SIDE_SIGN[side]
    height, left, right = narrowest_web(profile.outline)
    cut = force_through_cut(ElasticField(body.elasticity, displacement), (right + 1.0, height), (left - 1.0, height))
    middle = np.array([(left + right) / 2.0, height])
    moment = cut.moment - (middle[0] * cut.force[1] - middle[1] * cut.force[0])
    plane_modulus = result.model.problem.material_of("rail").plane_modulus
    faces = _faces(mesh, displacement, profile, middle, plane_modulus)
    return RailBending(
        side,
        WheelsetPosition(float(lateral), float(vertical), -turn if placement.mirrored else turn),
        outward,
        height,
        right - left,
        float(cut.force[1]),
        float(cut.force[0]),
        float(moment),
        faces,
    )


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
    foot = float(profile.outline.bounds(profile.head_names)[0, 1])
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


def _faces(
    mesh: PolyMesh, displacement: Floats, profile: RailProfile, web: Floats, plane_modulus: float
) -> tuple[FaceStresses, FaceStresses]:
    """Stresses on both sides of the web's middle (2,), on the boundary without running surface and base."""
    loaded = np.vstack([mesh.edge_set(name) for name in dict.fromkeys((*profile.head_names, *profile.base_names))])
    numbers = mesh.edge_numbers(mesh.boundary_edges)
    free = mesh.boundary_edges[~np.isin(numbers, mesh.edge_numbers(loaded))]
    edges = ordered_pairs(free, "free surface of the rail")
    first, second = mesh.points[edges].swapaxes(0, 1)
    along = second - first
    lengths = np.linalg.norm(along, axis=1)
    strains = np.einsum("ni,ni->n", displacement[edges[:, 1]] - displacement[edges[:, 0]], along) / lengths**2
    middles, stresses = (first + second) / 2.0, plane_modulus * strains
    outwards = np.column_stack((along[:, 1], -along[:, 0])) / lengths[:, None]

    def face(name: Face, mine: NDArray[np.bool_]) -> FaceStresses:
        # the boundary is counter-clockwise: up on the field side, down on the gauge side
        order = np.flatnonzero(mine)[:: 1 if name == "field" else -1]
        points, values = middles[order], stresses[order]
        return FaceStresses(name, points, outwards[order], values, _at_height(points[:, 1], values, float(web[1])))

    left = middles[:, 0] < web[0]
    return face("gauge", left), face("field", ~left)


def _at_height(heights: Floats, values: Floats, height: float) -> float:
    """Value where a line of heights (n,) first passes a height; nan if it does not."""
    passes = np.flatnonzero((heights[:-1] <= height) != (heights[1:] <= height))
    if len(passes) == 0:
        return float("nan")
    i = int(passes[0])
    share = (height - heights[i]) / (heights[i + 1] - heights[i])
    return float(values[i] + share * (values[i + 1] - values[i]))
