"""Random elastic bodies pushed by loads onto stops, in 1, 5 and 50 steps, checked apart from the solver.

A cantilever, a strip held at both ends or a block held at its top is loaded by a force on a part of its side, a
pressure, its weight, a temperature that bends it, or a prescribed displacement, so that without contact it would go up
to far beyond one or two stops: thick, thin, pointed or round ones, some elastic cantilevers themselves, under it or
above it. Pairing, enforcement, order of the elements, friction and the direction of everything are random.

What converged is checked by the bodies' stiffness matrices, by Shapely and by sums: equilibrium of each body, equal and
opposite forces, overlap of the deformed outlines, penetration along the way of the finest steps, cone of friction, and
the same forces in all numbers of steps. ``python -m benchmarks.pushed FIRST COUNT`` prints what failed or is wrong.
"""

import itertools
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.measurement import NO_PEER, Measurement
from benchmarks.polygons import outline, overlap, positions
from flangeway.contact import (
    AugmentedLagrange,
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, polygon
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.post import nodal_residual
from flangeway.problems import Body, BodyForce, Part, PrescribedDisplacement, Pressure, TemperatureChange, Traction
from flangeway.problems.loads import AppliedLoad
from flangeway.solve import StepSettings, solve_elasticity
from flangeway.solve.body_response import BodyLoad

Floats = NDArray[np.float64]

STEEL = Elastic(210e3, 0.3, expansion=12e-6)
PAIRINGS = (NodeToSegment(), SegmentToSegment())
LAWS = (Multiplier(), AugmentedLagrange(5e6, per="length", penetration=1e-6))
MOVERS = ("cantilever", "strip", "block")
DRIVES = ("force", "pressure", "weight", "displacement", "temperature")
STOPS = ("thick", "thin", "pointed", "round", "cantilever")
STEPS = (1, 5, 50)
"""Numbers of load steps."""

MAX_OVERLAP = 0.06
"""Overlap over the maximum displacement of the surfaces that coarse meshes leave between nodes."""

MAX_SAID = 0.2
"""The same where the status says that bodies overlap."""

MAX_DIFFERENCE, MAX_DIFFERENCE_WITH_FRICTION = 2e-3, 0.1
"""Difference of the forces in 1 or 5 steps from those in 50, over the maximum force or the load: with friction the
answer depends on the steps, which are made shorter until they agree."""

STEP_ERROR = 0.02
"""Error of a step with friction, see `StepSettings`."""

ROUND_OFF = 1e-6
"""Forces that are not balanced over the maximum force."""


@dataclass(frozen=True)
class Case:
    """A body that is pushed onto stops.

    Parameters
    ----------
    mover, drive
        One of `MOVERS` and of `DRIVES`.
    length, height
        Of the mover, mm; its left lower corner is the origin before the scene is turned.
    stops
        For each stop: its kind, middle over the length of the mover, gap in mm, whether it is above.
    reach
        How far the maximum displacement would go without contact, in mm.
    order, per_height
        Order of the elements, and number of cells over the mover's height.
    pairing, law
        Number of the pairing and of the enforcement.
    friction
        Coefficient of friction.
    angle
        Rotation of the scene in rad.

    """

    mover: str
    drive: str
    length: float
    height: float
    stops: tuple[tuple[str, float, float, bool], ...]
    reach: float
    order: int
    per_height: int
    pairing: int
    law: int
    friction: float
    angle: float

    @classmethod
    def of(cls, number: int) -> "Case":
        """Return the case of a number."""
        rng = np.random.default_rng([49, number])
        mover = str(rng.choice(MOVERS))
        drives = {"block": ("displacement", "weight"), "cantilever": DRIVES, "strip": DRIVES[:4]}[mover]
        drive = str(rng.choice(drives))
        length = float(rng.uniform(30.0, 100.0)) if mover != "block" else float(rng.uniform(4.0, 10.0))
        height = float(rng.uniform(1.0, 4.0)) if mover != "block" else float(rng.uniform(2.0, 6.0))
        gap = float(rng.choice([0.0, 0.02, 0.2, 1.0]))
        middle = {"cantilever": (0.6, 1.02), "strip": (0.25, 0.75), "block": (0.2, 0.8)}[mover]
        stops = [(str(rng.choice(STOPS)), float(rng.uniform(*middle)), gap, False)]
        if rng.random() < 0.3 and mover != "block":
            stops.append((str(rng.choice(STOPS)), float(rng.uniform(*middle)), 3.0 * gap, True))
        if mover == "block":
            reach = gap + float(10.0 ** rng.uniform(-3.0, -0.8)) * height
        else:
            reach = max(gap, 0.05) * float(10.0 ** rng.uniform(-0.2, 2.5))
            reach = min(reach, 0.6 * length)
        order, per_height = int(rng.choice([1, 2])), int(rng.integers(1, 4))
        friction = float(rng.uniform(0.1, 0.6)) if rng.random() < 0.3 else 0.0
        pairing, law = int(rng.integers(0, len(PAIRINGS))), int(rng.integers(0, len(LAWS)))
        angle = float(rng.uniform(-3.1, 3.1)) if rng.random() < 0.5 else 0.0
        return cls(mover, drive, length, height, tuple(stops), reach, order, per_height, pairing, law, friction, angle)

    @property
    def held(self) -> tuple[str, ...]:
        """Sides of the mover that are held."""
        return {"cantilever": ("left",), "strip": ("left", "right"), "block": ("top",)}[self.mover]

    def build(self) -> tuple[Part, list[BodyLoad], list[Contact]]:
        """The mover, its loads and the contacts."""
        size = self.height / self.per_height
        mesh = rectangle_grid(self.length, self.height, max(2, round(self.length / size)), self.per_height)
        scene = Placement(self.angle)
        supports: dict[str | tuple[float, float], Literal["x", "y", "xy"]] = dict.fromkeys(self.held, "xy")
        part = Part("mover", Body("mover", mesh, Lagrange(self.order), STEEL, supports), placement=scene)
        contacts = []
        for number, (kind, middle, gap, above) in enumerate(self.stops):
            stop = stop_part(f"stop {number}", kind, size)
            where = Placement(np.pi, (middle * self.length, self.height + gap)) if above else None
            where = where or Placement(0.0, (middle * self.length, -gap))
            stop = Part(stop.name, stop.body, placement=scene.after(where))
            edges = free_edges(part, "top" if above else "bottom", with_ends=self.mover == "cantilever")
            sides = Surface(part, edges), Surface(stop, free_edges(stop, "", with_ends=True))
            contacts.append(Contact(*sides, PAIRINGS[self.pairing], LAWS[self.law], self.friction))
        return part, [self.load(part, scene, self.reach)], contacts

    def load(self, part: Part, scene: Placement, reach: float) -> BodyLoad:
        """The load by which the maximum displacement without contact is a distance in mm."""
        if self.drive == "displacement":
            edges = {"cantilever": "left", "strip": "right", "block": "top"}[self.mover]
            return PrescribedDisplacement(edges, 0.0, -reach)
        alone = self._load((0.0, -1.0), 1.0)
        supports = [PrescribedDisplacement(name, 0.0, 0.0) for name in self.held]
        unit = solve_elasticity(replace(part.body.elasticity, loads=[alone], supports=supports))
        factor = reach / float(np.linalg.norm(unit.displacements[: len(part.body.nodes)], axis=1).max())
        x, y = scene.vectors([[0.0, -1.0]])[0].tolist()
        return self._load((x, y), factor)

    def _load(self, down: tuple[float, float], factor: float) -> AppliedLoad:
        along = factor * down[0], factor * down[1]
        if self.drive == "force":
            return Traction("right" if self.mover == "cantilever" else "top", along)
        if self.drive == "pressure":
            return Pressure("top", factor)
        if self.drive == "weight":
            return BodyForce(along)
        return TemperatureChange(lambda points: factor * (points[:, 1] - self.height / 2.0))

    def solve(self, steps: int) -> ContactSolution:
        """Load it in a number of steps."""
        part, loads, contacts = self.build()
        error = STEP_ERROR if self.friction else None
        sizes = StepSettings(1.0 / steps, 1.0 / steps, 1.0 / 1024.0, error)
        return press(contacts, {}, body_loads={part: loads}, steps=sizes)


def stop_part(name: str, kind: str, size: float) -> Part:
    """A stop whose top is at the origin, held at its bottom, or at its right end."""
    size, held = max(size, 0.7), "bottom"
    if kind in ("thick", "thin"):
        width, height = 6.0, 6.0 if kind == "thick" else 0.3
        rows = max(1, round(height / size))
        mesh = rectangle_grid(width, height, round(width / size), rows, origin=(-width / 2.0, -height))
    elif kind == "cantilever":
        mesh, held = rectangle_grid(40.0, 2.0, 40, 2, origin=(-4.0, -2.0)), "right"
    else:
        angles = np.linspace(0.0, np.pi, 5 if kind == "round" else 3)
        top = [(3.0 * float(np.cos(angle)), 3.0 * float(np.sin(angle)) - 3.0) for angle in angles]
        points = [(-3.0, -5.0), (3.0, -5.0), *top]
        mesh = triangulate(polygon(points, names=["bottom", *(f"side {i}" for i in range(len(points) - 1))]), size=size)
    return Part(name, Body(name, mesh, Lagrange(1), STEEL, held))


def free_edges(part: Part, side: str, *, with_ends: bool) -> NDArray[np.int32]:
    """Edges of a part's boundary without a held node, those of one side or all."""
    body = part.body
    assert isinstance(body, Body)
    edges = body.boundary_edges if with_ends else body.mesh.edge_set(side)
    return np.asarray(edges[~body.supported[edges].any(axis=(1, 2))])


def faults(solution: ContactSolution, case: Case) -> Iterator[str]:
    """What is wrong with a solution that says it converged: one sentence for each thing."""
    parts = solution.system.parts
    forces = {part: solution.nodal_forces(part) for part in parts}
    largest = max(float(np.linalg.norm(acting, axis=1).max()) for acting in forces.values())
    moved = max(float(np.linalg.norm(solution.field(part).displacements, axis=1).max()) for part in parts)
    for part in parts:
        field = solution.field(part)
        left = nodal_residual(field, part.placement.inverse().vectors(forces[part]))[: len(part.body.nodes)]
        unbalanced = float(np.abs(left[~part.body.supported]).max())
        if unbalanced > ROUND_OFF * max(float(np.abs(left).max()), largest) + 1e-14 * STEEL.young * moved:
            yield f"{part.name}: nodes are unbalanced by {unbalanced:.3g} N of {largest:.3g} N"
    total = np.sum([acting.sum(axis=0) for acting in forces.values()], axis=0)
    if np.abs(total).max() > ROUND_OFF * largest:
        yield f"contact forces do not balance each other by {np.abs(total).max():.3g} N of {largest:.3g}"
    shapes = {part: outline(solution, part) for part in parts}
    limit = MAX_SAID if " overlap by " in solution.status.message else MAX_OVERLAP
    for one, other in itertools.combinations(parts, 2):
        depth = overlap(shapes[one], shapes[other])
        if depth > limit * moved + ROUND_OFF:
            yield f"{one.name} and {other.name} overlap by {depth:.3g} mm for displacements of {moved:.3g} mm"
    table = {name: np.asarray(values) for name, values in solution.friction_table.columns.items()}
    tangential, normal = table["tangential_force"], table["normal_force"]
    if normal.min(initial=0.0) < 0.0:
        yield "contact pulls"
    if (np.abs(tangential) > case.friction * normal * (1.0 + 1e-6) + ROUND_OFF * largest).any():
        yield "friction is outside of its cone"


def passages(solution: ContactSolution) -> Iterator[str]:
    """Where deformed outlines overlap between two steps, at straight ways of all nodes from one to the next."""
    parts = solution.system.parts
    states = [replace(solution, state=step.state) for step in solution.steps]
    at = [[part.placement.points(part.body.nodes) for part in parts]]
    at += [[positions(state, part) for part in parts] for state in states]
    chains = [rings(part) for part in parts]
    stands = np.zeros((len(parts), len(parts)))  # overlap at the ends of a step, which `faults` sees to
    for before, after in itertools.pairwise(at):
        way = max(float(np.linalg.norm(b - a, axis=1).max()) for a, b in zip(before, after, strict=True))
        between = np.linspace(0.0, 1.0, 2 + min(int(way / 0.1), 100))[1:]
        depths = []
        for share in between:
            shapes = [
                shapely.make_valid(shapely.Polygon(((1.0 - share) * a + share * b)[ring]))
                for a, b, ring in zip(before, after, chains, strict=True)
            ]
            depths.append(np.array([[overlap(one, other) for other in shapes] for one in shapes]))
            np.fill_diagonal(depths[-1], 0.0)
        beyond = np.max(depths, axis=0) - np.maximum(stands, depths[-1])
        if beyond.max() > MAX_OVERLAP * way + 0.05:
            one, other = np.unravel_index(beyond.argmax(), beyond.shape)
            yield f"{parts[one].name} and {parts[other].name} overlap by {beyond.max():.3g} mm more on the way"
            return
        stands = depths[-1]


def rings(part: Part) -> list[int]:
    """Nodes of the boundary's corners, one after the other."""
    following = {int(first): int(last) for first, last in part.body.boundary_edges}
    loop = [next(iter(following))]
    while (node := following[loop[-1]]) != loop[0]:
        loop.append(node)
    return loop


@dataclass(frozen=True)
class Outcome:
    """What came of a case: its number, which numbers of steps converged, messages, and what is wrong."""

    number: int
    converged: tuple[bool, ...]
    messages: tuple[str, ...]
    wrong: tuple[str, ...]
    touches: bool


def outcome(number: int, all_steps: tuple[int, ...] = STEPS) -> Outcome:
    """Solve the case of a number in all numbers of steps and check it."""
    case = Case.of(number)
    solutions = {steps: case.solve(steps) for steps in all_steps}
    good = {steps: solution for steps, solution in solutions.items() if solution.status.converged}
    wrong = [f"{steps} steps: {fault}" for steps, solution in good.items() for fault in faults(solution, case)]
    if good:
        finest = good[max(good)]
        if max(good) == max(all_steps):
            wrong += passages(finest)
        scale = max(float(np.abs(finest.forces).max()), 1e-9)
        limit = MAX_DIFFERENCE_WITH_FRICTION if case.friction else MAX_DIFFERENCE
        for steps, solution in good.items():
            difference = float(np.abs(solution.forces - finest.forces).max()) / scale
            if difference > limit:
                wrong.append(f"forces in {steps} steps differ by {difference:.2g}: {solution.forces.tolist()}")
    touches = any(bool(solution.forces.any()) for solution in good.values())
    messages = tuple(solution.status.message for solution in solutions.values())
    return Outcome(number, tuple(steps in good for steps in all_steps), messages, tuple(wrong), touches)


def measurements(count: int = 300) -> Iterator[Measurement]:
    """One line: how many of the cases converged, touch, did not converge, and are wrong, with the numbers of both."""
    started = time.perf_counter()
    outcomes = [outcome(number) for number in range(count)]
    more = {
        "touching": sum(case.touches for case in outcomes),
        "not_converged": [case.number for case in outcomes if not all(case.converged)],
        "wrong": [case.number for case in outcomes if case.wrong],
    }
    yield Measurement(f"{count} pushed bodies", NO_PEER, time.perf_counter() - started, None, None, None, more=more)


def quick() -> Iterator[Measurement]:
    """As `measurements`, of 10 cases."""
    return measurements(10)


def main(arguments: list[str]) -> int:
    """Print the cases that failed or are wrong, and how many there were; 1 if any is wrong."""
    first, count = (int(argument) for argument in arguments)
    started, counts = time.perf_counter(), {"converged": 0, "not converged": 0, "wrong": 0, "touching": 0}
    for number in range(first, first + count):
        before = time.perf_counter()
        result = outcome(number)
        seconds = time.perf_counter() - before
        counts["converged" if all(result.converged) else "not converged"] += 1
        counts["wrong"] += bool(result.wrong)
        counts["touching"] += result.touches
        if result.wrong or not all(result.converged):
            words = "; ".join(
                result.wrong or [m for m, good in zip(result.messages, result.converged, strict=True) if not good]
            )
            print(f"{number} ({seconds:.1f} s; {result.converged}; {Case.of(number)}): {words}", flush=True)
    print(counts, f"{time.perf_counter() - started:.0f} s")
    return int(counts["wrong"] > 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
