"""Reads a table of creep forces: contact and creep forces of a wheelset at any position and any creepages.

This file needs NumPy only, so that it also runs beside other programs. Units: mm, mrad, kN for the
axle load, N, N mm. Axes of forces are those of each patch; see the README that is written beside every table.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

try:
    from flangeway.errors import InputError
except ImportError:  # outside of flangeway
    InputError = ValueError  # type: ignore[misc, assignment]

Floats = NDArray[np.float64]

SIDES = ("left", "right")
MIRROR = np.array([-1.0, 1.0])
"""From a side's right-hand form to the axes of the track: factor on x of left and right."""
SATURATED = 2.0
"""Reduced creepage at which the axis of slip is at 0.5."""
FORMAT = 3
AXES = ("lateral_mm", "yaw_mrad", "load_kN")
OF_PATCH = {
    "normal_force_N": 0,
    "contact_angle_rad": 0,
    "wheel_roll_rad": 0,
    "rolling_radius_mm": 0,
    "position_mm": 1,
    "rail_point_mm": 1,
    "wheel_point_mm": 1,
    "semi_axes_mm": 1,
    "max_pressure_MPa": 0,
    "free_creepage": 1,
    "stiffness_N": 1,
    "radius_mm": 0,
}
"""Numbers of a patch that are interpolated, and their further dimensions."""
MIN_DIVISOR = 1e-300
"""Far below all numbers of a table: zero divided by zero is zero."""
ROUNDING_WIDTH = 0.004
"""Distance from the limit of friction within which forces bend into it; at the limit they are a quarter of it less."""


def reduced(creepages: Floats, stiffness: Floats, radius: Floats, limit: Floats) -> tuple[Floats, Floats, Floats]:
    """Slip from 0 to 1, angle of spin from -pi/2 to pi/2 and angle of creepage, each (...).

    - `creepages`: longitudinal, lateral, spin, (..., 3); `stiffness`: -dF/d creepage at 0, both, (..., 2).
    - `radius`: of spin, (...); `limit`: friction times normal force, (...).
    """
    ahead = stiffness[..., 0] * creepages[..., 0]
    across = stiffness[..., 1] * creepages[..., 1]
    spin = stiffness[..., 1] * radius * creepages[..., 2]
    plane = np.hypot(ahead, across)
    size = np.hypot(plane, spin)
    return size / np.maximum(size + SATURATED * limit, MIN_DIVISOR), np.arctan2(spin, plane), np.arctan2(across, ahead)


def stencil(axis: Floats, values: Floats, smooth: NDArray[np.bool_]) -> tuple[NDArray[np.intp], Floats]:
    """Numbers (n, 4) of the points of an axis around values (n,) within it, and their weights, (n, ..., 4).

    Between two points a cubic has the slopes of parabolas through three points (Catmull and Rom, 1974): it and its
    derivative are continuous. At points that are not smooth the slope is that of a parabola with the other end's slope,
    or of a line.

    - `smooth`: points at which the parabola through both neighbours counts, (n_points, ...); never the ends.
    """
    last = len(axis) - 1
    below = np.clip(np.searchsorted(axis, values, side="right") - 1, 0, max(last - 1, 0))
    nodes = np.clip(below[:, None] + np.arange(-1, 3), 0, last)
    if last == 0:
        return nodes, np.broadcast_to([0.0, 1.0, 0.0, 0.0], (len(values), *smooth.shape[1:], 4))
    x = axis[nodes]
    before, step, after = np.where(np.diff(x) > 0.0, np.diff(x), 1.0).T
    zero = np.zeros(len(values))
    line = np.stack((zero, -1.0 / step, 1.0 / step, zero), -1)
    low, high = (
        np.pad(middle_slope(before, step), ((0, 0), (0, 1))),
        np.pad(middle_slope(step, after), ((0, 0), (1, 0))),
    )
    shape = (len(values), *[1] * (smooth.ndim - 1), 4)
    line, low, high = (array.reshape(shape) for array in (line, low, high))
    left, right = smooth[below][..., None], smooth[np.minimum(below + 1, last)][..., None]
    first = np.where(left, low, np.where(right, 2.0 * line - high, line))
    second = np.where(right, high, np.where(left, 2.0 * line - low, line))
    t, h = (array.reshape((*shape[:-1], 1)) for array in ((values - x[:, 1]) / step, step))
    ends = t**2 * (3.0 - 2.0 * t) * h * line
    ends = ends + np.array([0.0, 1.0, 0.0, 0.0])
    return nodes, ends + h * t * (1.0 - t) * ((1.0 - t) * first - t * second)


def middle_slope(before: Floats, after: Floats) -> Floats:
    """Weights (n, 3) of three points in the slope at the second one of their parabola, by both distances (n,)."""
    ratio = after / before
    return np.stack((-ratio, ratio - before / after, before / after), -1) / (before + after)[:, None]


def crossed(arrays: Sequence[NDArray[Any]]) -> tuple[NDArray[Any], ...]:
    """Give three arrays (..., k) axes of their own, (..., k, 1, 1), (..., 1, k, 1) and (..., 1, 1, k)."""
    first, second, third = arrays
    return first[..., :, None, None], second[..., None, :, None], third[..., None, None, :]


def interior(axis: Floats) -> NDArray[np.bool_]:
    """Points of an axis other than its ends, (n_points,)."""
    index = np.arange(len(axis))
    return np.asarray((index > 0) & (index < len(axis) - 1))


@dataclass(frozen=True, eq=False)
class ForceAxes:
    """Forces over the limit of friction and over slip as ``M(slip) d + R(slip, spin angle, creep angle)``.

    d is the direction of the reduced creepage, a unit vector. With M alone forces are linear where creepages are small,
    and next to pure spin in the other two creepages: so the remainder R and its derivatives vanish at no slip and in
    pure spin, and the derivative of the forces is the same from all sides, whatever the angles do there.

    - `axes`: slip, angles of spin and of creepage, both with one more angle at each end.
    - `linear`: M, (..., slips, 3 forces, 3 creepages).
    - `rest`: R, (..., slips, spin angles, creep angles, 3).
    """

    axes: tuple[Floats, ...]
    linear: Floats
    rest: Floats

    @classmethod
    def of(cls, forces: NDArray[Any], axes: tuple[Floats, ...]) -> "ForceAxes":
        """Take forces over the limit and over slip, (..., slips, spin angles, creep angles, 3), and their axes."""
        slip, spin, creep = axes
        values = np.asarray(forces, dtype=np.float64)
        # around pure spin, first half and second half: the opposite creepage has the opposite force
        ring = np.concatenate((values[..., -2, :-1, :], -values[..., 1, :-1, :]), axis=-2)
        around = np.concatenate((creep[:-1], creep[:-1] + np.pi))
        slopes = [2.0 / len(around) / np.cos(spin[-2]) * np.einsum("...cf,c->...f", ring, wave(around))
                  for wave in (np.cos, np.sin)]  # fmt: skip
        linear = np.stack((*slopes, values[..., -1, 0, :]), axis=-1)
        rest = values - np.einsum("...fd,bcd->...bcf", linear, direction(*np.meshgrid(spin, creep, indexing="ij")))
        rest[..., 0, :, :, :] = rest[..., [0, -1], :, :] = 0.0
        # mirrored at pure spin: no slope there
        over = np.concatenate((rest[..., 1:2, :, :], rest, rest[..., -2:-1, :, :]), axis=-3)
        turned = over[..., ::-1, :, :]
        whole = np.concatenate((-turned[..., -2:-1, :], over, -turned[..., 1:2, :]), axis=-2)
        more = [np.concatenate((2 * axis[:1] - axis[1:2], axis, 2 * axis[-1:] - axis[-2:-1])) for axis in (spin, creep)]
        return cls((slip, *more), linear, whole.astype(np.float32))

    def rows(self) -> "ForceAxes":
        """Take all positions, sides and patches as rows: (positions, 2 sides, patches, ...)."""
        linear, rest = (array.reshape(-1, *array.shape[3:]) for array in (self.linear, self.rest))
        return ForceAxes(self.axes, linear, rest)

    def at(self, rows: tuple[NDArray[np.intp], ...], point: tuple[Floats, ...]) -> Floats:
        """Forces over their limits of friction at reduced creepages, (n, 3), by cubics between the points.

        - `rows`: places in the first dimensions, each (n,).
        - `point`: slip, angle of spin, angle of creepage from -pi to pi, each (n,).
        """
        slip, spin, creep = point
        other = creep < 0.0
        spin, creep = np.where(other, -spin, spin), np.where(other, creep + np.pi, creep)
        stencils = [stencil(axis, x, interior(axis)) for axis, x in zip(self.axes, (slip, spin, creep), strict=True)]
        unit, total = direction(spin, creep), np.zeros((len(slip), 3))
        for a in range(4):
            nodes, weights = (array[:, a] for array in stencils[0])
            total += weights[:, None] * np.einsum("nfd,nd->nf", self.linear[(*rows, nodes)], unit)
        for corner in np.ndindex(4, 4, 4):
            of_corner = tuple(nodes[:, k] for (nodes, _), k in zip(stencils, corner, strict=True))
            weight = np.prod([weights[:, k] for (_, weights), k in zip(stencils, corner, strict=True)], axis=0)
            total += weight[:, None] * self.rest[(*rows, *of_corner)]
        return within_cone(total * np.where(other, -slip, slip)[:, None])


def direction(spin: Floats, creep: Floats) -> Floats:
    """Unit vector (..., 3) of a reduced creepage by its angles: longitudinal, lateral, spin."""
    return np.stack((np.cos(spin) * np.cos(creep), np.cos(spin) * np.sin(creep), np.sin(spin)), axis=-1)


def within_cone(forces: Floats) -> Floats:
    """Forces over the limit of friction, those near it and beyond it shortened without a kink, (..., 3)."""
    size = np.hypot(forces[..., 0], forces[..., 1])
    near = np.clip(size, 1.0 - ROUNDING_WIDTH, 1.0 + ROUNDING_WIDTH) - 1.0 + ROUNDING_WIDTH
    forces[..., :2] *= (
        (np.minimum(size, 1.0 + ROUNDING_WIDTH) - near**2 / (4.0 * ROUNDING_WIDTH)) / np.maximum(size, MIN_DIVISOR)
    )[..., None]
    return forces


@dataclass(frozen=True, eq=False)
class CreepTable:
    """Contact and creep forces over lateral position, yaw, axle load and creepages.

    Read one with `load`.

    Parameters
    ----------
    values
        Arrays by name, see the README beside the table.
    metadata
        Inputs, versions, axes, error bound and checks.

    """

    values: Mapping[str, NDArray[Any]]
    metadata: Mapping[str, Any]

    @classmethod
    def load(cls, path: str | Path) -> "CreepTable":
        """Read a table (.npz).

        Raises
        ------
        InputError
            If it cannot be read, or is no table of creep forces.

        """
        try:
            with np.load(path, allow_pickle=False) as file:
                values = {name: file[name] for name in file.files}
            metadata = json.loads(str(values.pop("metadata")))
            version = metadata["format"]
        except Exception as reason:  # NumPy, zipfile and json each have errors of their own
            raise InputError(
                f"{path}: {type(reason).__name__}: {reason}",
                "a table of creep forces, creep-table.npz",
                "make one with `flangeway creep-table`",
            ) from reason
        if version != FORMAT:
            raise InputError(f"{path}: format {version}", f"format {FORMAT}", "make the table anew")
        return cls(values, metadata)

    @property
    def axes(self) -> tuple[Floats, Floats, Floats]:
        """Axes of the positions: lateral in mm, yaw in mrad, load in kN."""
        lateral, yaw, load = (self.values[name] for name in AXES)
        return lateral, yaw, load

    @property
    def creep_axes(self) -> tuple[Floats, Floats, Floats]:
        """Axes of the creepages: slip, angle of spin, angle of creepage."""
        return self.values["slip"], self.values["spin_angle_rad"], self.values["creep_angle_rad"]

    def position(
        self,
        lateral_mm: ArrayLike,
        yaw_mrad: ArrayLike,
        load_kN: ArrayLike,
        *,
        clamp: bool = False,
    ) -> tuple[NDArray[np.intp], Floats]:
        """Numbers of the table's positions around each, and their weights for both sides: (n, 64) and (n, 2, k, 64).

        Where a side's patches go over into each other all around, the first of the k sets of patches is that of weights
        that add up to 1. Elsewhere each of the eight nearest positions has a set of its own with a part of the load,
        over the lateral position without a slope at its ends, linear over yaw and load. k is 8, 1 if nothing jumps.

        - `clamp`: values out of range become those at its end; otherwise they are an `InputError`.
        """
        given = np.broadcast_arrays(
            *(np.atleast_1d(np.asarray(value, float)) for value in (lateral_mm, yaw_mrad, load_kN))
        )
        around, fractions = [], []
        for name, axis, values, smooth in zip(AXES, self.axes, given, self.smooth, strict=True):
            inside = np.clip(values, axis[0], axis[-1])
            slack = 1e-9 * max(float(np.abs(axis).max()), 1.0)
            if not (clamp or (np.abs(values - inside) <= slack).all()):
                wrong = values[~(np.abs(values - inside) <= slack)][0]
                raise InputError(
                    f"{name} = {wrong:g}",
                    f"values from {axis[0]:g} to {axis[-1]:g}, the range of the table",
                    "make a larger table, or clamp=True",
                )
            around.append(stencil(axis, inside, smooth))
            low, high = axis[around[-1][0][:, 1:3]].T
            fractions.append(np.clip((inside - low) / np.maximum(high - low, MIN_DIVISOR), 0.0, 1.0))
        fractions[0] = fractions[0] ** 2 * (3.0 - 2.0 * fractions[0])
        nodes, of_nodes = zip(*around, strict=True)
        numbers = np.ravel_multi_index(crossed(nodes), [len(axis) for axis in self.axes]).reshape(-1, 64)
        cells = self.values["joined"]
        # the last point of an axis is in the cell before it
        joined = cells[tuple(np.minimum(at[:, 1], n - 1) for at, n in zip(nodes, cells.shape, strict=False))]
        weights = np.zeros((len(numbers), 2, 1 if cells.all() else 8, 4, 4, 4))
        weights[:, :, 0] = np.where(joined[..., None, None, None], math.prod(crossed(of_nodes)), 0.0)
        if weights.shape[2] > 1:
            parts: Any = math.prod(crossed([np.stack((1.0 - t, t), axis=-1) for t in fractions]))
            for corner, (a, b, c) in enumerate(np.ndindex(2, 2, 2)):
                weights[:, :, corner, a + 1, b + 1, c + 1] += np.where(joined, 0.0, parts[:, None, a, b, c])
        return numbers, weights.reshape(*weights.shape[:3], 64)

    @cached_property
    def smooth(self) -> tuple[NDArray[np.bool_], ...]:
        """Points of the axes of positions at which slopes are those of parabolas, by side, (n_points, 2) each.

        There all patches of the side go over into those of both neighbours, at all points of the other axes.
        """
        masks = []
        for axis, points in enumerate(self.axes):
            edges: NDArray[Any] = np.moveaxis(
                self.values["joined"], axis, 0
            )  # cells along the axis, cells of the others, sides
            for other in (1, 2):  # an edge of the axis is joined in one of the cells that it bounds
                none = np.zeros_like(edges.take([0], axis=other))
                edges = np.concatenate((edges, none), axis=other) | np.concatenate((none, edges), axis=other)
            whole = np.asarray(edges.all(axis=(1, 2)))
            smooth = np.zeros((len(points), 2), dtype=np.bool_)
            smooth[1:-1] = whole[:-1] & whole[1:]
            masks.append(smooth)
        return tuple(masks)

    @cached_property
    def force_axes(self) -> ForceAxes:
        """Forces of all positions, sides and patches."""
        return ForceAxes.of(self.values["forces"], self.creep_axes).rows()

    def contacts(
        self,
        lateral_mm: ArrayLike,
        yaw_mrad: ArrayLike,
        load_kN: ArrayLike,
        *,
        clamp: bool = False,
    ) -> dict[str, Floats]:
        """Numbers of the patches of both wheels at n positions, each (n, 2 sides, patches, ...); absent ones are 0.

        In a table in which patches jump there are eight times as many places: between positions with different patches
        the patches of all these are there, each with a part of its force.
        """
        nodes, weights = self.position(lateral_mm, yaw_mrad, load_kN, clamp=clamp)
        return self._contacts(nodes, weights)

    def _contacts(self, nodes: NDArray[np.intp], weights: Floats) -> dict[str, Floats]:
        parts = weights.sum(axis=-1)
        shares = weights / np.where(parts > 0.0, parts, 1.0)[..., None]
        contacts = {}
        for name, more in OF_PATCH.items():
            values = self.values[name]
            around = values.reshape(-1, *values.shape[3:])[nodes]
            numbers = np.einsum("nskc,ncsp...->nskp..." if more else "nskc,ncsp->nskp", shares, around)
            if name in ("normal_force_N", "stiffness_N"):  # parts of patches: the same pressure, on less of the area
                numbers *= parts.reshape(*parts.shape, *[1] * (numbers.ndim - 3))
            contacts[name] = numbers.reshape(*numbers.shape[:2], -1, *numbers.shape[4:])
        return contacts

    def forces(
        self,
        lateral_mm: ArrayLike,
        yaw_mrad: ArrayLike,
        load_kN: ArrayLike,
        creepages: ArrayLike,
        *,
        friction: ArrayLike = 0.3,
        clamp: bool = False,
    ) -> Floats:
        """Creep forces on the wheels.

        Parameters
        ----------
        lateral_mm, yaw_mrad, load_kN
            Positions of the wheelset and its axle load, numbers or (n,).
        creepages
            Longitudinal and lateral creepage and spin (1/mm) of every patch, (n, 2 sides, patches, 3), or what
            broadcasts to it; see `creepages`.
        friction
            Coefficient of friction, a number or (n,).
        clamp
            Positions out of range become those at its end.

        Returns
        -------
        Floats
            Longitudinal and lateral force in N and spin moment in N mm, (n, 2 sides, patches, 3), in the axes of the
            patches; 0 for absent patches.

        Raises
        ------
        InputError
            If a position is out of range, the friction negative, or a value no finite number.

        """
        nodes, weights = self.position(lateral_mm, yaw_mrad, load_kN, clamp=clamp)
        contacts = self._contacts(nodes, weights)
        names = "normal_force_N", "stiffness_N", "radius_mm", "free_creepage"
        normal, stiffness, radius, free = (contacts[name] for name in names)
        given = np.asarray(creepages, float)
        mu = np.asarray(friction, float)
        if not (np.isfinite(given).all() and np.isfinite(mu).all() and (mu >= 0.0).all()):
            raise InputError("creepages or friction", "finite numbers, friction >= 0", "correct them")
        given = np.broadcast_to(given, (*normal.shape, 3))
        limit = np.reshape(mu, (-1, 1, 1)) * normal
        further = given - np.concatenate((free, np.zeros((*normal.shape, 1))), axis=-1)
        point = reduced(further, stiffness, radius, limit)
        total = np.zeros(given.shape)
        shares = weights / np.maximum(weights.sum(axis=-1, keepdims=True), MIN_DIVISOR)
        n_patches = normal.shape[2] // weights.shape[2]
        present = normal.reshape(*normal.shape[:2], -1, n_patches) > 0.0
        at, side, group, corner, patch = np.nonzero((shares[..., None] != 0.0) & present[:, :, :, None])
        entry = at, side, group * n_patches + patch
        forces = self.force_axes.at((nodes[at, corner], side, patch), tuple(coordinate[entry] for coordinate in point))
        np.add.at(total, entry, shares[at, side, group, corner, None] * forces)
        total[..., 2] *= radius
        return within_cone(total) * limit[..., None]

    def creepages(
        self,
        contacts: Mapping[str, Floats],
        yaw_mrad: ArrayLike,
        *,
        speed: ArrayLike,
        rotation: ArrayLike,
        lateral_velocity: ArrayLike = 0.0,
        yaw_rate: ArrayLike = 0.0,
    ) -> Floats:
        """Creepages of the patches that `contacts` gave, by the motion of a rigid wheelset, (n, 2 sides, patches, 3).

        Parameters
        ----------
        contacts
            What `contacts` gave.
        yaw_mrad
            Yaw, positive where the right wheel is ahead.
        speed
            Of the axle along the track in mm/s, > 0.
        rotation
            Of the axle in rad/s, positive where it rolls ahead.
        lateral_velocity
            Of the axle to the right, relative to the track, in mm/s.
        yaw_rate
            Relative to the track, in rad/s, positive where the right wheel moves ahead.

        Raises
        ------
        InputError
            If a speed is not positive.

        """
        given = (yaw_mrad, speed, rotation, lateral_velocity, yaw_rate)
        # in the right-hand form of each side, whose x, yaw and yaw rate have the sign of the side
        yaw, v, omega, lateral, turning = (np.asarray(value, float).reshape(-1, 1, 1) for value in given)
        if not (v > 0.0).all():
            raise InputError(f"speed = {float(v.min()):g}", "speeds > 0: the table rolls ahead", "turn the axes over")
        sign = MIRROR[:, None]
        point = contacts["position_mm"] * np.stack((sign, *[np.ones((2, 1))] * 2), -1)
        roll, level = np.sin(contacts["wheel_roll_rad"]), np.cos(contacts["wheel_roll_rad"])
        axis = np.stack((level * np.cos(1e-3 * sign * yaw), roll, level * np.sin(1e-3 * sign * yaw)), -1)
        arm = point - axis * (point * axis).sum(axis=-1, keepdims=True)
        arm *= (contacts["rolling_radius_mm"] / np.maximum(np.linalg.norm(arm, axis=-1), MIN_DIVISOR))[..., None]
        zero = np.zeros_like(sign * turning)
        yawing = np.stack((zero, -sign * turning, zero), -1)
        slip = np.stack((sign * lateral + zero, zero, v + zero), -1) + np.cross(yawing, point)
        slip = slip + np.cross(omega[..., None] * axis, arm)
        sine, cosine = np.sin(contacts["contact_angle_rad"]), np.cos(contacts["contact_angle_rad"])
        across = -cosine * slip[..., 0] - sine * slip[..., 1]
        turned = omega[..., None] * axis + yawing
        spin = cosine * turned[..., 1] - sine * turned[..., 0]
        present = (contacts["normal_force_N"] > 0.0)[..., None]
        return np.where(present, np.stack((slip[..., 2], across, spin), -1) / v[..., None], 0.0)

    def wrench(self, contacts: Mapping[str, Floats], forces: Floats) -> tuple[Floats, Floats]:
        """Forces of the rails on the wheels, normal ones with creep forces, and their moments, each (n, 2 sides, 3).

        Forces are to the right, up and ahead. Moments are about the middle of the axle: of rotation (positive where it
        drives the axle ahead), of yaw (right wheel ahead) and of roll (right wheel up), in N mm.
        """
        normal, angle = contacts["normal_force_N"], contacts["contact_angle_rad"]
        along, across, moment = np.moveaxis(forces, -1, 0)
        sine, cosine, sign = np.sin(angle), np.cos(angle), MIRROR[:, None]
        push = np.stack((sign * (-normal * sine - across * cosine), normal * cosine - across * sine, along), -1)
        x, y, z = np.moveaxis(contacts["position_mm"], -1, 0)
        turned = np.stack(
            (
                y * push[..., 2] - z * push[..., 1] - moment * sine,
                x * push[..., 2] - z * push[..., 0] - sign * moment * cosine,
                x * push[..., 1] - y * push[..., 0],
            ),
            -1,
        )
        return push.sum(axis=2), turned.sum(axis=2)
