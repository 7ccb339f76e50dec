"""Regions of contact of many positions, and the maximum shear stresses below them, from the fields of the bodies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Self
from weakref import WeakKeyDictionary

import numpy as np

from flangeway.post import pressure_patches
from flangeway.post.pressure import CONSTRAINTS_APART, oscillation_of, pressure_remark
from flangeway.problems import LinearBody
from flangeway.railway.positions.line_stresses import Lines, LineStresses
from flangeway.railway.positions.positions_newton import PositionSide
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset
from flangeway.railway.positions.surface_positions import resultants
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.subsurface import DEPTH, SEARCHED, SubsurfaceExtreme, inward_from, maximum_of_lines
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch, region_of, wheel_rail_patch
from flangeway.solve import CondensedBodies, ContactState
from flangeway.types import Floats, Ints


@dataclass(frozen=True, eq=False)
class PositionPatch:
    """One region of contact; see `flangeway.railway.wheelset.wheelset_model.WheelRailPatch`.

    - `force_on_wheel_N`: resultant on the wheel, axes of the track.
    - `max_pressure_MPa`, `half_width_mm`: maximum pressure, and half of the loaded length.
    - `wheel_point_mm`, `rail_point_mm`: centre of pressure on the undeformed profiles, in their frames.
    - `at_edge`: whether it reaches an end of either surface.
    - `n_segments`: number of segments of the secondary surface that it is wide.
    - `oscillation`: of its pressures, see `flangeway.post.PressurePatch.oscillation`.
    - `shear`: maximum shear stress below it in the wheel and in the rail, where that was asked for.
    """

    side: Side
    region: str
    force_on_wheel_N: tuple[float, float]  # noqa: N815 (the unit newton)
    max_pressure_MPa: float  # noqa: N815 (the unit megapascal)
    half_width_mm: float
    wheel_point_mm: tuple[float, float]
    rail_point_mm: tuple[float, float]
    at_edge: bool
    n_segments: float
    oscillation: float
    shear: Mapping[Role, SubsurfaceExtreme] | None = None

    @property
    def remark(self) -> str | None:
        """Why its pressure is not to be relied on, see `flangeway.post.pressure.pressure_remark`."""
        return pressure_remark(self.n_segments, self.oscillation)

    @classmethod
    def of(cls, patch: WheelRailPatch) -> Self:
        """Return the numbers of a region that was found by the full search."""
        (x, y), wheel, rail = patch.force_on_wheel_N, patch.wheel_point_mm, patch.rail_point_mm
        return cls(
            patch.side,
            patch.region,
            (float(x), float(y)),
            float(patch.pressure.pressures.max()),
            patch.pressure.half_width,
            (float(wheel[0]), float(wheel[1])),
            (float(rail[0]), float(rail[1])),
            patch.pressure.at_edge,
            patch.pressure.n_segments,
            patch.pressure.oscillation,
        )


def position_patches(side: PositionSide, slots: Ints) -> list[list[PositionPatch]]:
    """Regions of contact of one side of some slots, along the secondary surface."""
    pair, gaps, forces = side.pair, side.gaps, side.loads.forces
    n_hats = forces.shape[1]
    unit = resultants(side.pose, gaps, side.around)
    secondary, primary = pair.secondary, pair.primary
    of_piece = gaps.rows[:, 0] // n_hats
    chosen = np.isin(of_piece, slots)
    rows = gaps.rows[chosen].ravel()
    edges = gaps.pieces.partners[chosen] % len(primary.edges)
    moments = np.einsum("pra,pai->pri", gaps.shapes[chosen], primary.mesh_points[primary.edges[edges]])
    sums = [np.bincount(rows, moments[..., x].ravel(), minlength=forces.size) for x in range(2)]
    covered = np.bincount(rows, gaps.covered[chosen].ravel(), minlength=forces.size)
    widths = _node_lengths(side)
    found: list[list[PositionPatch]] = []
    for slot in slots:
        loaded = np.flatnonzero(forces[slot] > 0.0)
        groups = np.split(loaded, np.flatnonzero(np.diff(loaded) > CONSTRAINTS_APART) + 1)
        patches = []
        for group in groups:
            if len(group) == 0:
                continue
            force = forces[slot, group]
            share = force / force.sum()
            x, y, _ = force @ unit[slot, group]
            nodes = pair.hats.nodes[group]
            there = np.stack([each[slot * n_hats + group] for each in sums], axis=1)
            points = share @ secondary.mesh_points[nodes], share @ (there / covered[slot * n_hats + group][:, None])
            on_wheel, on_rail = points if pair.wheel_is_secondary else points[::-1]
            mine = (of_piece == slot) & np.isin(gaps.rows - slot * n_hats, group).any(axis=1)
            touched = gaps.pieces.partners[mine] % len(primary.edges)
            at_edge = (
                nodes.min() == 0
                or nodes.max() == len(secondary.points) - 1
                or touched.min() == 0
                or touched.max() == len(primary.edges) - 1
            )
            pressures = force / gaps.areas[slot, group]
            patches.append(
                PositionPatch(
                    side.pose.side,
                    region_of(side.pose.side, x, y),
                    (float(x), float(y)),
                    float(pressures.max()),
                    float(widths[nodes[0] : nodes[-1] + 1].sum()) / 2.0,
                    (float(on_wheel[0]), float(on_wheel[1])),
                    (float(on_rail[0]), float(on_rail[1])),
                    bool(at_edge),
                    float(len(group)),  # segment-to-segment has one constraint for each segment
                    oscillation_of(pressures),
                )
            )
        # the left side mirrors the right-hand form, and its chain runs the other way
        found.append(patches[::-1] if side.pose.side == "left" else patches)
    return found


def patches_of(prepared: PreparedWheelset, equilibrium: Equilibrium[ContactState]) -> tuple[PositionPatch, ...]:
    """Regions of contact of a position that was found by the full search, left side first."""
    model = prepared.model
    found = pressure_patches(model.system, equilibrium.state)
    return tuple(PositionPatch.of(wheel_rail_patch(model, patch)) for patch in found)


def _node_lengths(side: PositionSide) -> Floats:
    """Lengths that belong to the secondary's nodes, shape (n,)."""
    lengths = np.zeros(len(side.pair.secondary.points))
    np.add.at(lengths, side.pair.hats.nodes, side.pair.hats.areas / side.pair.thickness)
    return lengths


N_POINTS = 201  # points of a line into a body, as `stresses_below` has them


@dataclass(frozen=True, eq=False)
class LoadedPatch:
    """A region of contact and the forces on the whole surfaces of its bodies.

    - `wheel`, `rail`: forces on the nodes of the surfaces in the bodies' own frames and order, each (n, 2).
    """

    patch: PositionPatch
    wheel: Floats
    rail: Floats


Key = tuple[LinearBody, bytes]
"""A body and its surface nodes: twins that are placed elsewhere share what is known of it."""

_kept: WeakKeyDictionary[CondensedBodies, dict[Key, LineStresses]] = WeakKeyDictionary()
"""What serves all lines into condensed bodies; it goes with them."""


def maximum_shears(
    prepared: PreparedWheelset, loaded: Sequence[LoadedPatch], *, superposed: bool
) -> list[dict[Role, SubsurfaceExtreme]]:
    """Maximum in-plane shear stress in the wheel and in the rail below each region of contact.

    It is that of `flangeway.railway.wheelset.subsurface.maximum_shear`: on the line along the inward normal through
    the centre of pressure, smoothed over the cells. All regions are treated together, and displacements are found
    only where their lines run.

    - `superposed`: whether fields are superposed from those of unit forces, which are kept with the condensed bodies;
      it pays for hundreds of regions over all calls.
    """
    found: list[dict[Role, SubsurfaceExtreme]] = [{} for _ in loaded]
    parts = [part.name for part in prepared.model.system.parts]
    for role in ROLES:
        twins: dict[Key, list[Side]] = {}
        for side in SIDES:
            surface = prepared.response.surfaces[parts.index(f"{role}-{side}")]
            twins.setdefault((surface.body, surface.nodes.tobytes()), []).append(side)
        for key, sides in twins.items():
            numbers = [number for number, each in enumerate(loaded) if each.patch.side in sides]
            if not numbers:
                continue
            patches = [loaded[number] for number in numbers]
            forces = np.stack([each.wheel if role == "wheel" else each.rail for each in patches])
            lines = lines_below(prepared, role, sides[0], [each.patch for each in patches])
            solve = partial(prepared.response.body_fields, parts.index(f"{role}-{sides[0]}"))
            stresses = _stresses(prepared.response, key, forces.shape[1])
            shear = stresses.in_plane_shear(lines, forces, solve, superposed=superposed)
            for number, extreme in zip(numbers, maximum_of_lines(lines.depths, shear, SEARCHED), strict=True):
                found[number][role] = extreme
    return found


def lines_below(prepared: PreparedWheelset, role: Role, side: Side, patches: Sequence[PositionPatch]) -> Lines:
    """Lines into a body below regions of contact, in the body's frame.

    - `role`, `side`: which of its bodies.
    - `patches`: the regions, of this side or of a side with the same bodies.
    """
    problem = prepared.model.problem
    profile = problem.wheelset.wheel_of(side) if role == "wheel" else problem.track.rail_of(side)
    points = np.array([each.wheel_point_mm if role == "wheel" else each.rail_point_mm for each in patches])
    starts, inward = inward_from(
        profile.running_surface, prepared.model.parts[f"{role}-{side}"].body.space.mesh, points
    )
    lengths = DEPTH * np.array([each.half_width_mm for each in patches])
    return Lines(starts, inward, np.linspace(0.0, lengths, N_POINTS, axis=1))


def _stresses(response: CondensedBodies, key: Key, n_nodes: int) -> LineStresses:
    """Return what is kept of a body, made if needed."""
    kept = _kept.setdefault(response, {})
    if key not in kept:
        kept[key] = LineStresses(key[0], n_nodes)
    return kept[key]
