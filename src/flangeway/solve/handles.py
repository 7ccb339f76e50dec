"""Handles: rigid motions, shared by any number of parts, that contact and loads decide.

The frames of the parts on a handle are moved by unknowns q: how far its pivot slides along directions of space, and how
far it turns about the pivot. The equations for them are the equilibrium of the handle. With the velocities V of the
surface nodes of its parts by q, their contact forces f, the quarter turn J of f by the rotation in T, and the geometric
stiffness G, a step dq changes the positions by ``dx = Y (B^T p' + W dq) + V dq + ...`` with ``Y = (K + G)^-1`` and
``W = T - G V``. The resultant of the handle then is ``L p' + H dq + e`` with ``L = (V + Y W)^T B^T`` and
``H = W^T (V + Y W) - S``, whose terms of slides in T vanish in equilibrium; S is the stiffness of the handle's springs
and of its load, which moves with it. The gaps change by ``L^T dq``: the system is symmetric. With friction G is not,
nor are directions D of forces those of gaps and slips: there ``L = (V + Y^T W')^T D^T`` and
``H = W'^T (V + Y W) - S`` with ``W' = T - G^T V``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from flangeway.checks import are_finite, check_kind, refused
from flangeway.errors import InputError, short
from flangeway.geometry import Placement
from flangeway.geometry.arrays import diagonal, norms, starts_of, turned_right
from flangeway.problems import Part
from flangeway.solve.body_response import BodyResponse
from flangeway.solve.constraints import described_motions
from flangeway.types import Bools, Floats, Ints

LONGEST_MOVE = 0.1
"""Motion of an iteration relative to the size of the part, above which it is shortened: gaps are linear over a part
of it."""

SOLVED = 1e6
"""Factor on the size by which soft motions are measured, for handles whose soft motions are solved for: what is softer
still is round-off of the stiffness."""

MIN_NAMED_FRACTION = 0.03
"""Share of a motion over the whole one that is not named."""

SoftMotions = Literal["solved", "kept"]
"""What becomes of motions that only the curvature of surfaces resists."""


@dataclass(frozen=True, eq=False)
class Handle:
    """A rigid motion that parts share: a floating body, a pushed punch, an axle with two wheels, bolted bodies.

    What is held of each part, see `flangeway.problems.Body`, moves with the handle.

    Parameters
    ----------
    parts
        The parts; each part has at most one handle.
    pivot
        Point of space, shape (2,), that slides with the handle and about which it turns.
    directions
        Unit vectors of space along which it slides, shape (n, 2); left out: both axes.
    turns
        Whether it turns.
    load
        Force x, y, whose direction does not change, and moment, counter-clockwise, shape (3,).
    load_point
        Point of space, shape (2,), that moves with the handle and where the force acts; left out: the pivot.
    stiffness
        Springs between the handle and the ground: a symmetric matrix without negative eigenvalues, shape (m, m), from
        the m free motions (slides, then the rotation in rad) to the forces and the moment against them. Left out: none.
    soft_motions
        Motions that only the curvature of surfaces in contact resists: ``"solved"`` for, as an axle's, or ``"kept"``
        in place where less than a thousandth of the forces acts along them, as rolling without friction, which is
        resisted by the error of the meshes only.

    Raises
    ------
    InputError
        If a part is named twice, nothing is free, or a shape or number is wrong.

    """

    parts: tuple[Part, ...]
    pivot: Floats
    directions: Floats = field(default_factory=lambda: np.eye(2))
    turns: bool = True
    load: Floats = field(default_factory=lambda: np.zeros(3))
    load_point: Floats | None = None
    stiffness: Floats | None = None
    soft_motions: SoftMotions = "solved"

    def __post_init__(self) -> None:
        parts = tuple(self.parts) if isinstance(self.parts, Sequence) else ()
        if not parts or len(set(parts)) < len(parts) or not all(isinstance(part, Part) for part in parts):
            raise InputError(f"Handle(parts={short(self.parts)})", "one or more parts, each once", "write (part,)")
        check_kind("Handle", "turns", self.turns, bool | np.bool_, "True or False", "choose one")
        if self.soft_motions not in get_args(SoftMotions):
            raise refused(
                "Handle",
                "soft_motions",
                self.soft_motions,
                " or ".join(map(repr, get_args(SoftMotions))),
                "leave it out",
            )
        object.__setattr__(self, "parts", parts)
        values = {"pivot": (2,), "directions": (len(np.atleast_1d(self.directions)), 2), "load": (3,)}
        if self.load_point is not None:
            values["load_point"] = (2,)
        if self.stiffness is not None:
            values["stiffness"] = (self.n_motions, self.n_motions)
        for name, shape in values.items():
            given = np.asarray(getattr(self, name), dtype=object)
            if given.shape != shape or not are_finite(given.ravel().tolist(), given.size):
                raise InputError(
                    f"Handle({name}={short(getattr(self, name))})", f"finite numbers {shape}", "see Handle"
                )
            object.__setattr__(self, name, given.astype(np.float64))
        independent = np.linalg.matrix_rank(self.directions) == len(self.directions)
        if self.n_motions == 0 or not independent or not np.allclose(norms(self.directions), 1.0):
            raise InputError(
                f"Handle(directions={short(self.directions)}, turns={self.turns})",
                "at most two unit vectors that are not parallel, and at least one slide or the rotation",
                "leave them out for a handle that slides and turns, or no handle where nothing is free",
            )
        if self.stiffness is not None and (
            not np.allclose(self.stiffness, self.stiffness.T)
            or np.linalg.eigvalsh(self.stiffness)[0] < -1e-12 * np.abs(self.stiffness).max()
        ):
            raise InputError(
                f"Handle(stiffness={short(self.stiffness)})",
                "a symmetric matrix without negative eigenvalues",
                "give springs that pull the handle back",
            )

    @property
    def n_motions(self) -> int:
        """Number of unknowns: slides, then the rotation."""
        return len(self.directions) + self.turns

    def turned(self, vector: Floats, angle: float) -> Floats:
        """A vector (2,) after a rotation in rad."""
        return Placement(angle).matrix @ vector

    def placed(self, placement: Placement, motion: Floats) -> Placement:
        """Placement after a motion (n_motions,): slides, and the angle in rad."""
        turned = Placement.about(self.pivot, self.angle(motion)).after(placement)
        x, y = (self.pivot_after(motion) - self.pivot).tolist()
        return Placement(0.0, (x, y)).after(turned)

    def angle(self, motion: Floats) -> float:
        """Angle of a motion (n_motions,) in rad."""
        return float(motion[-1]) if self.turns else 0.0

    def pivot_after(self, motion: Floats) -> Floats:
        """Pivot in space, shape (2,), after a motion (n_motions,)."""
        return self.pivot + motion[: len(self.directions)] @ self.directions

    def forces(self, motion: Floats) -> Floats:
        """Forces along the slides, and moment about the pivot, of load and springs after a motion (n_motions,)."""
        x, y = self._arm(motion)
        moment = self.load[2] + x * self.load[1] - y * self.load[0]
        forces: Floats = np.append(self.directions @ self.load[:2], [moment] if self.turns else [])
        return forces if self.stiffness is None else forces - self.stiffness @ motion

    def tangent(self, motion: Floats) -> Floats:
        """Derivatives of `forces` by the motion, shape (n_motions, n_motions)."""
        n = self.n_motions
        result = np.zeros((n, n)) if self.stiffness is None else -self.stiffness
        if self.turns:  # the force keeps its direction while its arm turns
            result[-1, -1] -= self._arm(motion) @ self.load[:2]
        return result

    def _arm(self, motion: Floats) -> Floats:
        """From the pivot to where the force acts, shape (2,)."""
        return np.zeros(2) if self.load_point is None else self.turned(self.load_point - self.pivot, self.angle(motion))


class Handles:
    """The unknown rigid motions of some of the placed bodies.

    Unknowns of all handles follow each other; rotations are scaled with the size of the handle's parts to lengths.

    Parameters
    ----------
    response
        The bodies.
    placements
        Placements before any of the motions.
    handles
        Handle of each body, the same object for all that share it; None: the body is where it is placed.

    Raises
    ------
    InputError
        If what is held of a body leaves a motion free that is not among the unknowns, or of one that shares a handle
        leaves any free.

    """

    def __init__(
        self,
        response: BodyResponse,
        placements: Sequence[Placement],
        handles: Sequence[Handle | None] | None,
    ) -> None:
        self._response, self._placements = response, tuple(placements)
        of_bodies = list(handles or [None] * len(self._placements))
        self._handles = list(dict.fromkeys(handle for handle in of_bodies if handle is not None))
        self._members = [
            [i for i, handle_of_body in enumerate(of_bodies) if handle_of_body is handle] for handle in self._handles
        ]
        for surface, handle in zip(response.surfaces, of_bodies, strict=True):
            freedom, shared = surface.body.freedom, handle is not None and of_bodies.count(handle) > 1
            if freedom.n_motions > (0 if handle is None or shared else handle.n_motions):
                raise InputError(
                    f"body `{surface.body.name}` that what is held of it leaves free to move",
                    "bodies that are held, or whose contacts are solved by `press`, and held ones only on a handle "
                    "that several parts share",
                    "hold both translations and the rotation in Body(held=...)",
                )
        counts = [handle.n_motions for handle in self._handles]
        self.starts: Ints = starts_of(counts)
        self.n = int(self.starts[-1])
        self._sizes = [self._size(members) for members in self._members]
        solved = [SOLVED if handle.soft_motions == "solved" else 1.0 for handle in self._handles]
        self.lengths: Floats = np.repeat(self._sizes, counts)
        # the last motion of a handle that turns
        self._turns = np.zeros(self.n, dtype=np.bool_)
        self._turns[[last - 1 for last, handle in zip(self.starts[1:], self._handles, strict=True) if handle.turns]] = (
            True
        )
        self._units = np.where(self._turns, 1.0 / self.lengths, 1.0)
        self.sizes: Floats = self.lengths * np.repeat(solved, counts)
        self.numbers: Ints = np.repeat(np.arange(len(counts)), counts)
        self.load: Floats = self.forces(np.zeros(self.n))

    def _size(self, members: Sequence[int]) -> float:
        """Size of a part, or the diagonal of the box around several."""
        bodies = [self._response.surfaces[i].body for i in members]
        if len(bodies) == 1:
            return bodies[0].size
        points = [self._placements[i].points(body.nodes) for i, body in zip(members, bodies, strict=True)]
        return diagonal(np.concatenate(points))

    def _slices(self) -> Iterator[slice]:
        return (slice(*self.starts[i : i + 2].tolist()) for i in range(len(self._handles)))

    def _motions(self, motions: Floats) -> Iterator[tuple[Handle, slice, list[int], Floats]]:
        """Each handle, the place of its unknowns, its bodies, and its motion of motions (n,), not scaled."""
        for handle, components, members in zip(self._handles, self._slices(), self._members, strict=True):
            yield handle, components, members, (motions * self._units)[components]

    def _nodes(self, member: int) -> slice:
        return slice(*self._response.offsets[member : member + 2].tolist())

    @property
    def size(self) -> float:
        """Size of the largest body."""
        return max(surface.body.size for surface in self._response.surfaces)

    def untouched(self, nodes: Ints) -> Bools:
        """Which motions are of handles without any of some surface nodes, shape (n,)."""
        return ~self.of_bodies(np.unique(self._response.body_of_node[nodes]))

    def of_bodies(self, bodies: Ints) -> Bools:
        """Which motions move one of some bodies, shape (n,)."""
        moved = [not set(bodies.tolist()).isdisjoint(members) for members in self._members]
        return np.repeat(np.array(moved, dtype=np.bool_), np.diff(self.starts))

    @property
    def springs(self) -> Floats:
        """Stiffness of the handles' springs, shape (n, n)."""
        result = np.zeros((self.n, self.n))
        for handle, components in zip(self._handles, self._slices(), strict=True):
            if handle.stiffness is not None:
                result[components, components] = handle.stiffness
        return result * np.outer(self._units, self._units)

    def without_turns(self, motions: Floats) -> Floats:
        """Motions (n,) without rotations."""
        return np.where(self._turns, 0.0, motions)

    def placements(self, motions: Floats) -> tuple[Placement, ...]:
        """Placements after motions (n,), rotations scaled."""
        result = list(self._placements)
        for handle, _, members, motion in self._motions(motions):
            for i in members:
                result[i] = handle.placed(result[i], motion)
        return tuple(result)

    def velocities(self, motions: Floats, positions: Floats) -> Floats:
        """Velocities of all surface nodes at positions (n_nodes, 2) by the motions, shape (n_nodes, 2, n)."""
        result = np.zeros((len(positions), 2, self.n))
        for handle, components, members, motion in self._motions(motions):
            for i in members:
                nodes = self._nodes(i)
                result[nodes, :, components.start : components.start + len(handle.directions)] = handle.directions.T
                if handle.turns:
                    moved = -turned_right(positions[nodes] - handle.pivot_after(motion))
                    by_loads = self._response.turning(i, handle.placed(self._placements[i], motion))
                    moved = moved if by_loads is None else moved + by_loads
                    result[nodes, :, components.stop - 1] = moved * self._units[components.stop - 1]
        return result

    def turned(self, forces: Floats) -> Floats:
        """Forces (n_nodes, 2) turned back by the motions, as each part's axes see them: (n_nodes, 2, n)."""
        result = np.zeros((len(forces), 2, self.n))
        for handle, components, members, _ in self._motions(np.zeros(self.n)):
            for nodes in map(self._nodes, members if handle.turns else []):
                result[nodes, :, components.stop - 1] = turned_right(forces[nodes]) * self._units[components.stop - 1]
        return result

    def forces(self, motions: Floats) -> Floats:
        """Forces of loads, on the handles and on their bodies, and of springs along the motions, shape (n,)."""
        forces = np.zeros(self.n)
        for handle, components, members, motion in self._motions(motions):
            x, y, moment, _ = self._resultant(handle, members, motion)
            on_bodies = np.append(handle.directions @ (x, y), [moment] if handle.turns else [])
            forces[components] = handle.forces(motion) + on_bodies
        return forces * self._units

    def _resultant(self, handle: Handle, members: Sequence[int], motion: Floats) -> Floats:
        """Sum of `BodyResponse.resultant` over the bodies of a handle after a motion."""
        pivot, response = handle.pivot_after(motion), self._response
        placed = ((i, handle.placed(self._placements[i], motion)) for i in members)
        return np.sum([response.resultant(i, placement, pivot) for i, placement in placed], axis=0)

    def tangent(self, motions: Floats) -> Floats:
        """Derivatives of `forces` by the motions, shape (n, n)."""
        result = np.zeros((self.n, self.n))
        for handle, components, members, motion in self._motions(motions):
            result[components, components] = handle.tangent(motion)
            if handle.turns:
                result[components.stop - 1, components.stop - 1] += self._resultant(handle, members, motion)[3]
        return result * np.outer(self._units, self._units)

    def residual(self, motions: Floats, positions: Floats, forces: Floats) -> Floats:
        """What is left of the forces (n_nodes, 2), the loads and the springs, along the motions, shape (n,)."""
        return np.einsum("niq,ni->q", self.velocities(motions, positions), forces) + self.forces(motions)

    def shortened(self, step: Floats, velocities: Floats) -> Floats:
        """A step (n,) that moves no node by more than `LONGEST_MOVE` of its part's size."""
        worst = 0.0
        for _, components, members, _ in self._motions(step):
            for i in members:
                moved = norms(velocities[self._nodes(i), :, components] @ step[components]).max(initial=0.0)
                worst = max(worst, moved / (LONGEST_MOVE * self._response.surfaces[i].body.size))
        return step / max(worst, 1.0)

    def describe(self, motions: Floats, directions: Floats) -> list[str]:
        """Words for what each handle can do by motions in the span of some directions (n, k), for those that move."""
        sentences = []
        for (handle, components, members, motion), size in zip(self._motions(motions), self._sizes, strict=True):
            rigid = np.zeros((3, directions.shape[1]))
            rigid[:2] = handle.directions.T @ directions[components][: len(handle.directions)]
            if handle.turns:
                rigid[2] = directions[components.stop - 1]
            rigid[np.abs(rigid) < MIN_NAMED_FRACTION] = 0.0
            words = described_motions(rigid, handle.pivot_after(motion), size)
            if words:
                names = [self._response.surfaces[i].body.name for i in members]
                names = names if len(set(names)) == len(names) else [part.name for part in handle.parts]
                sentences.append(f"{' with '.join(f'`{name}`' for name in names)} {words}")
        return sentences
