"""Parts whose rigid motions contact and loads decide.

The frame of such a part is placed by unknowns q: how far its pivot slides along directions of space, and how far it
turns about the pivot. The equations for them are the equilibrium of the part. With the velocities V of the surface
nodes by q, their contact forces f, the quarter turn J of f by the part's own rotation in T, and the geometric stiffness
G, a step dq changes the positions by ``dx = Y (B^T p' + W dq) + V dq + ...`` with ``Y = (K + G)^-1`` and
``W = T - G V``. The resultant of the part then is ``L p' + H dq + e`` with ``L = (V + Y W)^T B^T`` and
``H = W^T (V + Y W)``, whose terms of slides in T vanish in equilibrium; the gaps change by ``L^T dq``: the system is
symmetric. With friction G is not, nor are directions D of forces those of gaps and slips: there
``L = (V + Y^T W')^T D^T`` and ``H = W'^T (V + Y W)`` with ``W' = T - G^T V``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.solve.body_response import BodyResponse
from flangeway.solve.free_motions import described_motions
from flangeway.types import Floats, Ints

LONGEST_MOVE = 0.1
"""Motion of an iteration over the size of the part, above which it is shortened: gaps are linear over a part of it."""

HARDLY = 0.03
"""Share of a motion over the whole one that is not named."""


@dataclass(frozen=True, eq=False)
class Floating:
    """Rigid motions of a part that are unknown.

    Parameters
    ----------
    pivot
        Point in the body's frame, shape (2,), that slides and about which the part turns.
    directions
        Unit vectors of space along which it slides, shape (n, 2).
    turns
        Whether it turns.
    load
        Given force x, y, which acts at the pivot, and moment about the pivot, shape (3,), axes of space.

    """

    pivot: Floats
    directions: Floats
    turns: bool
    load: Floats

    @property
    def n_motions(self) -> int:
        """Number of unknowns: slides, then the rotation."""
        return len(self.directions) + self.turns

    @property
    def resultants(self) -> Floats:
        """Given force along each direction, then the moment, shape (n_motions,)."""
        along = self.directions @ self.load[:2]
        return np.append(along, self.load[2]) if self.turns else along

    def placed(self, placement: Placement, motion: Floats) -> Placement:
        """Placement after a motion (n_motions,): slides and the angle in radians."""
        angle = float(motion[-1]) if self.turns else 0.0
        x, y = motion[: len(self.directions)] @ self.directions
        turned = Placement.about(placement.points([self.pivot]), angle).after(placement)
        return Placement(0.0, (float(x), float(y))).after(turned)


class FloatingParts:
    """The unknown rigid motions of some of the placed bodies.

    Unknowns of all parts follow each other; rotations are scaled with the part's size to lengths.

    Parameters
    ----------
    response
        The bodies.
    placements
        Placements before any of the motions.
    floating
        The unknown motions of each body; None: it is where it is placed.

    Raises
    ------
    InputError
        If what is held of a body leaves a motion free that is not among the unknowns.

    """

    def __init__(
        self,
        response: BodyResponse,
        placements: Sequence[Placement],
        floating: Sequence[Floating | None] | None,
    ) -> None:
        self._response, self._placements = response, tuple(placements)
        self._floating = tuple(floating or [None] * len(self._placements))
        for surface, part in zip(response.surfaces, self._floating, strict=True):
            freedom = surface.body.freedom
            if freedom.n_motions > (0 if part is None else part.n_motions):
                raise InputError(
                    f"body `{surface.body.name}` that what is held of it leaves free to move",
                    "bodies that are held, or whose contacts are solved by `press`",
                    "hold both translations and the rotation in Body(held=...)",
                )
        counts = [0 if part is None else part.n_motions for part in self._floating]
        self.starts: Ints = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
        self.n = int(self.starts[-1])
        sizes = [surface.body.size for surface in response.surfaces]
        self._units = np.ones(self.n)
        self.load = np.zeros(self.n)
        for number, part, mine in self._each():
            if part.turns:
                self._units[mine.stop - 1] = 1.0 / sizes[number]
            self.load[mine] = part.resultants
        self.load *= self._units
        self.sizes: Floats = np.repeat(sizes, counts)
        self.numbers: Ints = np.repeat(np.arange(len(counts)), counts)

    def _each(self) -> list[tuple[int, Floating, slice]]:
        return [
            (number, part, slice(*self.starts[number : number + 2].tolist()))
            for number, part in enumerate(self._floating)
            if part is not None
        ]

    def placements(self, motions: Floats) -> tuple[Placement, ...]:
        """Placements after motions (n,), rotations scaled."""
        result = list(self._placements)
        for number, part, mine in self._each():
            result[number] = part.placed(result[number], (motions * self._units)[mine])
        return tuple(result)

    def velocities(self, motions: Floats, positions: Floats) -> Floats:
        """Velocities of all surface nodes at positions (n_nodes, 2) by the motions, shape (n_nodes, 2, n)."""
        result = np.zeros((len(positions), 2, self.n))
        placements = self.placements(motions)
        for number, part, mine in self._each():
            nodes = slice(*self._response.offsets[number : number + 2].tolist())
            slides = slice(mine.start, mine.start + len(part.directions))
            result[nodes, :, slides] = part.directions.T
            if part.turns:
                arms = positions[nodes] - placements[number].points([part.pivot])
                result[nodes, :, mine.stop - 1] = quarter_turn(arms) * self._units[mine.stop - 1]
        return result

    def turned(self, forces: Floats) -> Floats:
        """Forces (n_nodes, 2) turned back by the motions, as each part's axes see them: (n_nodes, 2, n)."""
        result = np.zeros((len(forces), 2, self.n))
        for number, part, mine in self._each():
            if part.turns:
                nodes = slice(*self._response.offsets[number : number + 2].tolist())
                result[nodes, :, mine.stop - 1] = -quarter_turn(forces[nodes]) * self._units[mine.stop - 1]
        return result

    def residual(self, motions: Floats, positions: Floats, forces: Floats) -> Floats:
        """What is left of the forces (n_nodes, 2) and the loads, along the motions, shape (n,)."""
        return np.einsum("niq,ni->q", self.velocities(motions, positions), forces) + self.load

    def shortened(self, step: Floats, velocities: Floats) -> Floats:
        """A step (n,) that moves no node by more than `LONGEST_MOVE` of its part's size."""
        worst = 0.0
        for number, _, mine in self._each():
            nodes = slice(*self._response.offsets[number : number + 2].tolist())
            moved = np.linalg.norm(velocities[nodes, :, mine] @ step[mine], axis=1).max(initial=0.0)
            worst = max(worst, moved / (LONGEST_MOVE * self._response.surfaces[number].body.size))
        return step / max(worst, 1.0)

    def describe(self, motions: Floats, directions: Floats) -> list[str]:
        """Words for what each part can do by motions in the span of some directions (n, k), for parts that move."""
        sentences = []
        for number, placement in enumerate(self.placements(motions)):
            part = self._floating[number]
            if part is None:
                continue
            mine = slice(*self.starts[number : number + 2].tolist())
            size = self._response.surfaces[number].body.size
            rigid = np.zeros((3, directions.shape[1]))
            rigid[:2] = part.directions.T @ directions[mine][: len(part.directions)]
            if part.turns:
                rigid[2] = directions[mine.stop - 1]
            rigid[np.abs(rigid) < HARDLY] = 0.0
            words = described_motions(rigid, placement.points([part.pivot])[0], size)
            if words:
                sentences.append(f"`{self._response.surfaces[number].body.name}` {words}")
        return sentences


def quarter_turn(vectors: Floats) -> Floats:
    """Vectors (..., 2) turned counter-clockwise by a right angle."""
    return np.stack((-vectors[..., 1], vectors[..., 0]), axis=-1)
