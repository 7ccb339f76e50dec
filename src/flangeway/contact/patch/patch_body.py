"""Bodies of a contact patch: prisms along z, and bodies of revolution, by their plane sections."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry import Contour, Placement, Point, crossing_shares
from flangeway.geometry.arrays import chain_lengths, turned_right
from flangeway.problems import Harmonic
from flangeway.types import Floats, Ints

DRAWN = 1e-8
"""Distance of the chords of drawn arcs over the size of the curve."""
YAWED = 1e-3
"""Spacing of the drawn points of a body with yaw over the size of the curve."""
LARGEST_YAW = np.pi / 4.0
"""Yaw of an axis, beyond which the elasticity of the body is no longer that of a prism along z."""


@dataclass(frozen=True)
class Axis:
    """Axis of revolution in the frame of a body's section.

    Parameters
    ----------
    point
        A point of the axis.
    direction
        Its direction in the plane of the section.
    yaw_rad
        Rotation about the vertical y of the common axes through `point`, from x towards z, up to pi / 4. The axes of
        a cylinder and of a prism along z then cross at the angle pi / 2 - yaw.

    """

    point: Point
    direction: Point = (1.0, 0.0)
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        if not abs(self.yaw_rad) <= LARGEST_YAW or not np.hypot(*self.direction) > 0.0:
            raise InputError(
                f"an axis along {self.direction} with a yaw of {self.yaw_rad:g}",
                "a direction, and a yaw between -pi/4 and pi/4",
                "exchange the bodies, so that the one whose axis is closer to z is the prism",
            )


@dataclass(frozen=True, eq=False)
class PatchBody:
    """A prism along z or a body of revolution in a contact patch.

    Its elasticity is that of the prism of its section. In a body of revolution the true surface goes into the gap, and
    waves around the axis are straightened, which changes the pressure on a wheel of 920 mm by 0.02 %.

    Parameters
    ----------
    problem
        Space, material, supports and foundations of the section.
    surface
        Edge set of the contact surface, or pairs of points of boundary edges (n_edges, 2): one chain.
    curve
        The drawn surface in the section's frame, from which gaps are measured. Left out: the mesh's edges.
    placement
        Position of the section in the common axes.
    axis
        Axis of a body of revolution in the section's frame; None for a prism.

    Raises
    ------
    InputError
        If the body is neither held nor on a foundation along x, y or z: long waves could then move it without force.

    """

    problem: Harmonic
    surface: str | Ints
    curve: Contour | None = None
    placement: Placement = field(default_factory=Placement)
    axis: Axis | None = None

    def __post_init__(self) -> None:
        supported = set("".join((self.problem.held or {}).values()))
        supported |= {axis for each in self.problem.foundations for axis in "xyz" if getattr(each, axis) > 0.0}
        if loose := "".join(sorted(set("xyz") - supported)):
            raise InputError(
                f"{self.name!r} without a support along {' and '.join(loose)}, free to move at the wavenumber 0",
                "a body that is held, or on a foundation, along x, y and z",
                "hold it along x, y and z, or give a foundation with a stiffness along each axis",
            )

    @property
    def name(self) -> str:
        """Name for messages."""
        return self.problem.elasticity.name

    @cached_property
    def edges(self) -> Ints:
        """Edges of the surface one after the other, body on the left, shape (n_edges, 2)."""
        mesh, name = self.problem.elasticity.space.mesh, self.surface
        if not isinstance(name, str):
            mesh, name = mesh.with_edge_set("contact surface", name), "contact surface"
        chain = mesh.chain(name).astype(np.int64)
        return np.stack((chain[:-1], chain[1:]), axis=1)

    @cached_property
    def chain(self) -> Floats:
        """Corners of the meshed surface in the common axes, body on the left, shape (n_edges + 1, 2)."""
        points = self.problem.elasticity.space.mesh.points
        chain = self.placement.points(np.concatenate((points[self.edges[:, 0]], points[self.edges[-1:, 1]])))
        return chain[::-1] if self.placement.mirrored else chain

    @property
    def length(self) -> float:
        """Length of the meshed surface."""
        return float(chain_lengths(self.chain)[-1])

    def longest_edge(self, low: float, high: float) -> float:
        """Maximum length of the edges between two lengths along the chain."""
        ends = chain_lengths(self.chain)
        return float(np.diff(ends)[(ends[1:] > low) & (ends[:-1] < high)].max())

    @cached_property
    def drawn(self) -> Floats:
        """The drawn surface in the plane z = 0 of a body without yaw as a polyline, shape (n, 2)."""
        if self.curve is None:
            return self.chain
        # planes z = const cut straight lines of a yawed body in curves
        spacing = YAWED * self.curve.size if self.axis is not None and self.axis.yaw_rad else None
        return self.placement.points(self.curve.sampled(spacing=spacing, max_deviation=DRAWN * self.curve.size))

    def section(self, z: float, part: slice = slice(None)) -> Floats:
        """The drawn surface in the plane of a z as a polyline, shape (n, 2); not-a-number where it does not reach.

        A point of a surface of revolution at the distance r from the axis a is turned by the angle t about it, so that
        ``xi a + r (cos t e1 + sin t e2)`` is at z; e1 is the axis' normal in the plane of the section. A part of the
        points of `drawn` saves time.
        """
        if self.axis is None:
            return self.drawn[part]
        centre = self.placement.points(np.array([self.axis.point]))[0]
        straight = self.placement.vectors(np.array([self.axis.direction]))[0]
        straight /= np.linalg.norm(straight)
        apart = self.drawn[part] - centre
        along, radii = apart @ straight, apart @ np.array([-straight[1], straight[0]])
        axis = np.array([straight[0] * np.cos(self.axis.yaw_rad), straight[1]])
        out_of_plane = straight[0] * np.sin(self.axis.yaw_rad)
        level = np.sqrt(1.0 - out_of_plane**2)
        first, second = np.array([-axis[1], axis[0]]) / level, -out_of_plane * axis / level
        with np.errstate(invalid="ignore", divide="ignore"):
            sine = (z - along * out_of_plane) / (radii * level)
            cosine = np.sqrt(1.0 - sine**2)
        turned = cosine[:, None] * first + sine[:, None] * second
        return centre + along[:, None] * axis + radii[:, None] * turned


def points_along(chain: Floats, stations: Floats) -> tuple[Floats, Floats]:
    """Points and outward unit normals of a chain, body on its left, at lengths along it, each (n, 2)."""
    chords, ends = np.diff(chain, axis=0), chain_lengths(chain)
    points = np.stack([np.interp(stations, ends, chain[:, axis]) for axis in range(2)], axis=1)
    # normals of the edges belong to their middles, between which they turn
    middles = (ends[1:] + ends[:-1]) / 2.0
    normals = turned_right(chords) / np.diff(ends)[:, None]
    found = np.stack([np.interp(stations, middles, normals[:, axis]) for axis in range(2)], axis=1)
    return points, found / np.linalg.norm(found, axis=1)[:, None]


def cast(points: Floats, normals: Floats, chain: Floats) -> tuple[Floats, Floats]:
    """Signed distances from points along normals to a chain, and the lengths along it where they meet, each (n,).

    Infinite where they do not meet.
    """
    distance, share = crossing_shares(points[:, None], normals[:, None], chain[:-1], np.diff(chain, axis=0))
    distance = np.where((share >= 0.0) & (share <= 1.0), distance, np.inf)
    nearest = np.abs(distance).argmin(axis=1)
    rows, ends = np.arange(len(points)), chain_lengths(np.nan_to_num(chain))
    return distance[rows, nearest], ends[nearest] + share[rows, nearest] * np.diff(ends)[nearest]
