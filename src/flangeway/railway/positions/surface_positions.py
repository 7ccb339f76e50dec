"""Surfaces of many positions of a wheelset and their loads; a slot of the batch holds one position."""

from dataclasses import dataclass, replace

import numpy as np

from flangeway.railway.positions.running_pair import Candidates, Gaps, RunningPair
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.residual import AxleLoads
from flangeway.types import Bools, Floats, Ints


@dataclass(frozen=True, eq=False)
class SidePose:
    """Placement of the pair of a side, in the right-hand form.

    - `side`: the side; positions of the left one are mirrored.
    - `rail_angle`, `rail_point`: placement of the rail.
    - `wheel_angle`, `wheel_point`: placement of the wheel in the reference position.
    - `axle_height`: height of the axle above the rails' tops in the reference position.
    """

    side: Side
    pair: RunningPair
    rail_angle: float
    rail_point: Floats
    wheel_angle: float
    wheel_point: Floats
    axle_height: float

    @property
    def sign(self) -> float:
        """-1 on the left."""
        return -1.0 if self.side == "left" else 1.0

    @property
    def signs(self) -> Floats:
        """What mirrors a position or a force and moment."""
        return np.array([self.sign, 1.0, self.sign])

    @property
    def rail_turn(self) -> Floats:
        """Matrix from the rail's axes to the track's."""
        return _turn(np.array(self.rail_angle))

    def wheels(self, position: Floats) -> tuple[Floats, Floats, Floats]:
        """Matrices (L, 2, 2) from the wheel's frame to the rail's, its places and the axle's middles there (L, 2)."""
        position = position * self.signs
        centre = np.array([0.0, self.axle_height])
        axle = centre + position[:, :2]
        place = axle + np.einsum("lij,j->li", _turn(position[:, 2]), self.wheel_point - centre)
        turn = _turn(position[:, 2] + self.wheel_angle - self.rail_angle)
        back = self.rail_turn
        return turn, (place - self.rail_point) @ back, (axle - self.rail_point) @ back


@dataclass(frozen=True, eq=False)
class Targets:
    """Loads and prescribed components of each position.

    - `loads`: loads on the wheelset, each shape (L,).
    - `prescribed`: prescribed components of the position, nan for those that are found, shape (L, 3).
    """

    loads: AxleLoads
    prescribed: Floats

    @property
    def free(self) -> Bools:
        """Which components of the position are found, shape (L, 3)."""
        return np.isnan(self.prescribed)

    def remaining(self, position: Floats) -> Floats:
        """Difference of what is prescribed and a position, zero for what is found, shape (L, 3)."""
        return np.where(self.free, 0.0, self.prescribed - position)

    def snapped(self, position: Floats) -> Floats:
        """Position whose prescribed components are exact where they are so but for round-off."""
        exact = ~self.free & (np.abs(self.remaining(position)) <= 1e-9)
        return np.where(exact, self.prescribed, position)

    def take(self, slots: Ints | Bools) -> "Targets":
        """Those of some slots."""
        return Targets(self.loads.take(slots), self.prescribed[slots])

    def changed(self, slot: int, other: "Targets", number: int, share: float, origin: int | None) -> "Targets":
        """Those with another target for one slot: a share of the way to it from another, or a share of its load.

        - `other`, `number`: targets, and which of them.
        - `share`: part of the way or of the load.
        - `origin`: which of the other targets the way begins at; None: the same without load.
        """

        def part_way(mine: Floats, theirs: Floats, start: Floats | float) -> Floats:
            result = mine.copy()
            result[slot] = theirs[number] if share == 1.0 else (1.0 - share) * start + share * theirs[number]
            return result

        ours, theirs = self.loads, other.loads
        along, onto, weight = (
            part_way(mine, target, 0.0 if origin is None else target[origin])
            for mine, target in ((ours.along, theirs.along), (ours.onto, theirs.onto), (ours.weight, theirs.weight))
        )
        start = other.prescribed[number if origin is None else origin]
        return Targets(
            replace(ours, along=along, onto=onto, weight=weight), part_way(self.prescribed, other.prescribed, start)
        )


@dataclass(frozen=True, eq=False)
class Loads:
    """Contact forces on one side of slots.

    - `forces`: of all hat functions, shape (L, n_hats).
    - `wheel`, `rail`: forces on the nodes in the bodies' own frames, shapes (L, n, 2).
    """

    forces: Floats
    wheel: Floats
    rail: Floats

    @classmethod
    def none(cls, pair: RunningPair, n_positions: int) -> "Loads":
        """Nothing touches."""
        return cls(
            np.zeros((n_positions, len(pair.hats.nodes))),
            np.zeros((n_positions, *pair.wheel.points.shape)),
            np.zeros((n_positions, *pair.rail.points.shape)),
        )

    def take(self, slots: Ints | Bools) -> "Loads":
        """Those of some slots."""
        return Loads(self.forces[slots], self.wheel[slots], self.rail[slots])

    def packed(self, slot: int) -> tuple[Ints, Floats]:
        """Loads of a slot that are not zero: places among all, and values."""
        values = np.concatenate((self.forces[slot], self.wheel[slot].ravel(), self.rail[slot].ravel()))
        places = np.flatnonzero(values)
        return places, values[places]

    def unpack(self, slot: int, packed: tuple[Ints, Floats]) -> None:
        """Set the loads of a slot to what was packed."""
        size, on_wheel = self.forces.shape[1], self.wheel[slot].size
        values = np.zeros(size + on_wheel + self.rail[slot].size)
        values[packed[0]] = packed[1]
        self.forces[slot] = values[:size]
        self.wheel[slot] = values[size : size + on_wheel].reshape(-1, 2)
        self.rail[slot] = values[size + on_wheel :].reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class SurfacePositions:
    """Positions of one side's surfaces in the rail's frame.

    - `wheel`, `rail`: positions of the nodes, shapes (L, n, 2).
    - `turns`: matrices from the wheel's frame to the rail's, shape (L, 2, 2).
    - `axles`: the axle's middle, shape (L, 2).
    - `lowered`: about how far the rail's head has moved, shape (L, 2).
    - `scale`: maximum displacement, shape (L,).
    """

    wheel: Floats
    rail: Floats
    turns: Floats
    axles: Floats
    lowered: Floats
    scale: Floats

    @classmethod
    def at(cls, pose: SidePose, position: Floats, loads: Loads) -> "SurfacePositions":
        """Positions of the surfaces at positions of the wheelset (L, 3) under loads."""
        pair = pose.pair
        turns, places, axles = pose.wheels(position)
        on_wheel, on_rail = pair.wheel.displacements(loads.wheel), pair.rail.displacements(loads.rail)
        wheel = (pair.wheel.points + on_wheel) @ turns.swapaxes(1, 2) + places[:, None]
        size = np.abs(loads.rail).sum(axis=2)
        lowered = np.einsum("ln,lnx->lx", size / np.maximum(size.sum(axis=1), 1e-300)[:, None], on_rail)
        scale = np.maximum(np.abs(on_wheel).max(axis=(1, 2)), np.abs(on_rail).max(axis=(1, 2)))
        return cls(wheel, pair.rail.points + on_rail, turns, axles, lowered, np.maximum(scale, 1e-300))

    def search(self, pair: RunningPair, margin: Floats | float) -> Candidates:
        """See `RunningPair.search`."""
        return pair.search(self.wheel, self.rail, self.turns, self.lowered, margin)

    def take(self, slots: Ints | Bools) -> "SurfacePositions":
        """Those of some slots."""
        return SurfacePositions(
            self.wheel[slots], self.rail[slots], self.turns[slots], self.axles[slots], self.lowered[slots],
            self.scale[slots],
        )  # fmt: skip


def resultants(pose: SidePose, gaps: Gaps, around: SurfacePositions) -> Floats:
    """Forces in the track's axes and moment about the axle's middle of unit contact forces, shape (L, n_hats, 3).

    They are those on the wheel, with the signs of the position, and also the derivatives of the gaps by the position.
    """
    nodes, on_wheel = gaps.nodes[0], gaps.on_wheel
    slots = gaps.rows[:, 0] // gaps.gaps.shape[1]
    arms = around.wheel.reshape(-1, 2)[nodes] - around.axles[slots][:, None]
    x, y = (sum(on_wheel[:, :, number, axis] for number in range(nodes.shape[1])) for axis in range(2))
    moments = sum(
        arms[:, None, number, 0] * on_wheel[:, :, number, 1] - arms[:, None, number, 1] * on_wheel[:, :, number, 0]
        for number in range(nodes.shape[1])
    )
    turn = pose.rail_turn
    rows, size = gaps.rows.ravel(), gaps.gaps.size
    columns = [
        np.bincount(rows, np.ravel(each), minlength=size)
        for each in (turn[0, 0] * x + turn[0, 1] * y, turn[1, 0] * x + turn[1, 1] * y, moments)
    ]
    return np.stack(columns, axis=1).reshape(*gaps.gaps.shape, 3) * pose.signs


def carried(pose: SidePose, gaps: Gaps, around: SurfacePositions, forces: Floats) -> Loads:
    """Loads of the bodies under contact forces (L, n_hats)."""
    first, second = (forces.ravel()[gaps.rows[:, number], None, None] for number in range(2))
    found = []
    for chain, gradients, nodes in zip(
        (pose.pair.wheel, pose.pair.rail), (gaps.on_wheel, gaps.on_rail), gaps.nodes, strict=True
    ):
        values = first * gradients[:, 0] + second * gradients[:, 1]
        size = len(forces) * len(chain.points)
        sums = [np.bincount(nodes.ravel(), values[..., x].ravel(), minlength=size) for x in range(2)]
        found.append(np.stack(sums, axis=1).reshape(len(forces), -1, 2).astype(np.float64, copy=False))
    return Loads(forces, found[0] @ around.turns, found[1])


def _turn(angle: Floats) -> Floats:
    """Rotation matrices of angles (...), shape (..., 2, 2)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack((np.stack((cosine, -sine), axis=-1), np.stack((sine, cosine), axis=-1)), axis=-2)
