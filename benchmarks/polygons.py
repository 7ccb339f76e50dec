"""Random polygons pressed on each other by motions and by loads on handles, judged apart from the solver.

Two random convex polygons of triangles, of order 1 or 2, meet in a random position under a random pairing, enforcement,
and friction from 0 to 1. One of them is moved, or loaded on a handle that slides, or that slides and turns on springs.
What converged is judged by Shapely and by sums over displacements, nodal forces and slips alone: overlap, balance of
forces and moments, load, pull, cone of friction, and dissipation. Each case has a number:
``python -m benchmarks.polygons FIRST COUNT`` prints those that failed or are wrong.
"""

import itertools
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.measurement import NO_PEER, Measurement
from flangeway.contact import (
    AugmentedLagrange,
    Barrier,
    Contact,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Penalty,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh
from flangeway.problems import Body, Part
from flangeway.solve import Handle

Floats = NDArray[np.float64]

STEEL = Elastic(210e3, 0.3)
STIFFNESS, PENETRATION = 5e6, 1e-6
"""Penalty in N/mm of a surface 1 mm wide, and the depth in mm that augmented Lagrange leaves."""

PAIRINGS = (NodeToSegment(), SegmentToSegment(), SegmentToSegment(weighting="dual"))
LAWS = (
    Multiplier(),
    Penalty(STIFFNESS, per="length"),
    AugmentedLagrange(STIFFNESS, per="length", penetration=PENETRATION),
    Barrier(1e-3, 1e-4),
)
SPRING = 1e-3 * STEEL.young
"""Spring in N/mm along the load on a handle: a body that slides past the other one has an equilibrium."""

DRIVES = ("motion", "slide", "springs")
MAX_OVERLAP = 0.05
"""Overlap over the indentation, the maximum displacement of the surfaces, that coarse meshes leave between nodes."""

MAX_SAID = 0.25
"""The same where the status says that bodies overlap."""

ROUND_OFF = 1e-9


@dataclass(frozen=True)
class Shape:
    """A convex polygon about the origin.

    Parameters
    ----------
    corners
        Its corners counter-clockwise, shape (n, 2).
    per_side
        Elements on each side.
    order
        Their order.

    """

    corners: Floats
    per_side: int
    order: int

    @classmethod
    def random(cls, rng: np.random.Generator) -> "Shape":
        """Three to seven corners on an ellipse, in even parts or not, turned by any angle or a special one."""
        n, aspect = int(rng.integers(3, 8)), float(rng.choice([1.0, 1.0, 2.0, 8.0]))
        moved = rng.uniform(-0.3, 0.3, n) if rng.random() < 0.7 else np.zeros(n)
        angles = 2.0 * np.pi * (np.arange(n) + 0.5 + moved) / n
        turn = float(rng.uniform(0.0, 6.2)) if rng.random() < 0.6 else float(rng.integers(0, 3)) * np.pi / 4.0
        points = np.stack((np.cos(angles), np.sin(angles) / aspect), axis=1)
        return cls(Placement(turn).points(points), int(rng.integers(1, 4)), int(rng.choice([1, 1, 2])))

    def part(self, name: str, where: Placement) -> Part:
        """Two rings of triangles about a middle, whose inner points are held: all of the outer side may touch."""
        corners, shares = self.corners, np.arange(self.per_side)[:, None] / self.per_side
        sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
        outer = np.concatenate([a + shares * (b - a) for a, b in sides])
        middle, n = corners.mean(axis=0), len(outer)
        inner = middle + 0.5 * (outer - middle)
        i, j = np.arange(n), np.roll(np.arange(n), -1)
        rings = ((i, j, n + j), (i, n + j, n + i), (n + i, n + j, 0 * i + 2 * n))
        cells = np.concatenate([np.stack(each, axis=1) for each in rings])
        mesh = PolyMesh(
            np.concatenate((outer, inner, [middle])), 3 * np.arange(len(cells) + 1, dtype=np.int32), cells.ravel()
        )
        held: dict[str | tuple[float, float], Literal["x", "y", "xy"]] = {(float(x), float(y)): "xy" for x, y in inner}
        return Part(name, Body(name, mesh, Lagrange(self.order), STEEL, held), placement=where)


@dataclass(frozen=True)
class Case:
    """Two shapes, of which the second is pressed on the first.

    Parameters
    ----------
    shapes
        The shapes.
    direction
        Angle of the line along which the second comes.
    lateral_offset
        How far beside the first one's middle it comes, in (-1, 1).
    depth
        How far they overlap along the direction before they give way, in mm; of a load, half of it times the modulus.
    pairing, law
        Number of the pairing and of the enforcement.
    friction
        Coefficient of friction.
    drive
        One of `DRIVES`.

    """

    shapes: tuple[Shape, Shape]
    direction: float
    lateral_offset: float
    depth: float
    pairing: int
    law: int
    friction: float
    drive: str

    @classmethod
    def of(cls, number: int) -> "Case":
        """Return the case of a number."""
        rng = np.random.default_rng([28, number])
        shapes = Shape.random(rng), Shape.random(rng)
        direction = float(rng.uniform(0.0, 6.2)) if rng.random() < 0.7 else float(rng.integers(0, 2)) * np.pi / 2.0
        lateral = float(rng.uniform(-1.0, 1.0)) if rng.random() < 0.7 else 0.0
        depth = float(10.0 ** rng.uniform(-4.0, np.log10(0.02)))
        numbers = int(rng.integers(0, len(PAIRINGS))), int(rng.integers(0, len(LAWS)))
        friction = float(rng.uniform(0.0, 1.0)) if rng.random() < 0.7 else 0.0
        return cls(shapes, direction, lateral, depth, *numbers, friction, DRIVES[int(rng.integers(0, len(DRIVES)))])

    @property
    def along(self) -> Floats:
        """Unit vector from the first shape to the second one, shape (2,)."""
        return np.array([np.cos(self.direction), np.sin(self.direction)])

    @property
    def load(self) -> Floats:
        """Force on a loaded second shape in N, shape (2,)."""
        return np.asarray(-0.5 * STEEL.young * self.depth * self.along)

    def solve(self) -> ContactSolution:
        """Press them."""
        along = self.along
        across = np.array([-along[1], along[0]])
        # a load far beside the middle pushes one past the other, to where springs alone hold it
        beside = (0.8 if self.drive == "motion" else 0.3) * self.lateral_offset * across
        touch = distance_along(self.shapes[0].corners, self.shapes[1].corners + beside, along)
        start = beside + (touch + 0.01) * along
        x, y = start.tolist()
        parts = self.shapes[0].part("fixed", Placement()), self.shapes[1].part("moved", Placement(0.0, (x, y)))
        surfaces = [Surface(part, part.body.boundary_edges) for part in parts]
        contact = Contact(surfaces[0], surfaces[1], PAIRINGS[self.pairing], LAWS[self.law], self.friction)
        if self.drive == "motion":
            x, y = (-(0.01 + self.depth) * along).tolist()
            return press([contact], {parts[1]: Placement(0.0, (x, y))})
        load = np.append(self.load, 0.0)
        spring = np.array([[SPRING]])
        handle = Handle((parts[1],), start, directions=along[None], turns=False, load=load, stiffness=spring)
        if self.drive == "springs":
            springs = np.diag([SPRING, 0.3 * STEEL.young, 0.3 * STEEL.young])
            handle = Handle((parts[1],), start, directions=np.stack((along, across)), load=load, stiffness=springs)
        return press([contact], {}, handles=[handle])


def distance_along(fixed: Floats, moved: Floats, along: Floats) -> float:
    """How far a convex polygon is to be moved along a direction so that it only touches another one; 0 if it passes."""
    longest = -np.inf
    for points, sides, sign in ((moved, fixed, 1.0), (fixed, moved, -1.0)):
        for start, end in zip(sides, np.roll(sides, -1, axis=0), strict=True):
            chord = end - start
            area = along[0] * chord[1] - along[1] * chord[0]
            if area == 0.0:
                continue
            apart = points - start
            ways = -sign * (apart[:, 0] * chord[1] - apart[:, 1] * chord[0]) / area
            shares = (apart[:, 0] * along[1] - apart[:, 1] * along[0]) / (chord[0] * along[1] - chord[1] * along[0])
            longest = max(longest, float(ways[(shares >= 0.0) & (shares <= 1.0)].max(initial=-np.inf)))
    return longest if np.isfinite(longest) else 0.0


def positions(solution: ContactSolution, part: Part) -> Floats:
    """Deformed positions of all nodes of a part, shape (n_nodes, 2)."""
    field = solution.field(part).displacements[: len(part.body.nodes)]
    return np.asarray(solution.placement(part).points(part.body.nodes + field))


def outline(solution: ContactSolution, part: Part) -> shapely.Geometry:
    """Deformed boundary of a part in 12 points an edge."""
    nodes = part.body.edge_nodes(part.body.boundary_edges)
    t = np.arange(12) / 12.0
    shapes = np.stack((1.0 - t, t), axis=1)
    if nodes.shape[1] == 3:
        shapes = np.stack(((1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)), axis=1)
    following = {int(edge[0]): number for number, edge in enumerate(nodes)}
    loop = [0]
    while (number := following[int(nodes[loop[-1], -1])]) != 0:
        loop.append(number)
    # x_eti = sum_a N_a(t) x_eai
    points = np.einsum("ta,eai->eti", shapes, positions(solution, part)[nodes])[loop].reshape(-1, 2)
    return shapely.make_valid(shapely.Polygon(points))


def overlap(one: shapely.Geometry, other: shapely.Geometry) -> float:
    """Maximum distance of the corners of the common area from the boundary of either body."""
    corners = shapely.points(shapely.get_coordinates(one & other))
    if len(corners) == 0:
        return 0.0
    return float(np.maximum(*(shapely.distance(corners, each.boundary) for each in (one, other))).max())


def faults(solution: ContactSolution, case: Case) -> Iterator[str]:
    """What is wrong with a solution that says it converged: one sentence for each thing."""
    parts = sorted(solution.system.parts, key=lambda part: part.name)  # fixed, moved
    forces, at = [solution.nodal_forces(part) for part in parts], [positions(solution, part) for part in parts]
    acting, points = np.concatenate(forces), np.concatenate(at)
    largest = float(np.linalg.norm(acting, axis=1).max())
    table = {name: np.asarray(values) for name, values in solution.friction_table.columns.items()}
    law = LAWS[case.law]
    given = {Penalty: float((table["pressure"] / STIFFNESS).max(initial=0.0)), AugmentedLagrange: PENETRATION}
    moved = max(float(np.linalg.norm(solution.field(part).displacements, axis=1).max()) for part in parts)
    depth = overlap(*(outline(solution, part) for part in parts))
    said = " overlap by " in solution.status.message
    if depth > given.get(type(law), 0.0) + (MAX_SAID if said else MAX_OVERLAP) * moved + ROUND_OFF:
        yield f"overlap by {depth:.3g} mm for displacements of {moved:.3g} mm"
    # friction acts across the gap of a law, or across that between the nodes
    apart = MAX_OVERLAP * moved + given.get(type(law), 1e-4 if isinstance(law, Barrier) else 0.0)
    arm = apart * float(np.abs(table["tangential_force"]).sum()) + ROUND_OFF * largest
    moment = abs(float((points[:, 0] * acting[:, 1] - points[:, 1] * acting[:, 0]).sum()))
    if np.abs(acting.sum(axis=0)).max() > ROUND_OFF * largest or moment > arm:
        yield f"unbalanced by {np.abs(acting.sum(axis=0)).max():.3g} N and {moment:.3g} N mm of {largest:.3g} N"
    slid = np.subtract(solution.placement(parts[1]).translation, parts[1].placement.translation)
    left = (forces[1].sum(axis=0) + case.load - SPRING * slid) @ case.along
    if case.drive != "motion" and abs(left) > 1e-6 * largest:
        yield f"{left:.6g} N of the load of {case.load @ case.along:.6g} N are left"
    if table["normal_force"].min(initial=0.0) < 0.0:
        yield "contact pulls"
    tangential, normal = table["tangential_force"], table["normal_force"]
    if (np.abs(tangential) > case.friction * normal * (1.0 + 1e-6) + ROUND_OFF * largest).any():
        yield "friction is outside of its cone"
    if (tangential * table["slip"])[~table["sticks"]].max(initial=0.0) > ROUND_OFF * largest * max(moved, 1e-12):
        yield "friction makes work"


@dataclass(frozen=True)
class Outcome:
    """What came of a case: its number, whether it converged, its message, what is wrong, whether bodies touch."""

    number: int
    converged: bool
    message: str
    wrong: tuple[str, ...]
    touches: bool


def outcome(number: int) -> Outcome:
    """Solve the case of a number and judge it."""
    case = Case.of(number)
    solution = case.solve()
    converged, touches = solution.status.converged, bool(solution.state.nodal_forces.any())
    wrong = tuple(faults(solution, case)) if converged and touches else ()
    return Outcome(number, converged, solution.status.message, wrong, touches)


def measurements(count: int = 1000) -> Iterator[Measurement]:
    """One line: how many of the cases converged, touch, did not converge, and are wrong, with the numbers of both."""
    started = time.perf_counter()
    found = [outcome(number) for number in range(count)]
    more = {
        "touching": sum(each.touches for each in found),
        "not_converged": [each.number for each in found if not each.converged],
        "wrong": [each.number for each in found if each.wrong],
    }
    yield Measurement(f"{count} random polygons", NO_PEER, time.perf_counter() - started, None, None, None, more=more)


def quick() -> Iterator[Measurement]:
    """As `measurements`, of 20 cases."""
    return measurements(20)


def main(arguments: list[str]) -> int:
    """Print the cases that failed or are wrong, and how many there were; 1 if any is wrong."""
    first, count = (int(each) for each in arguments)
    started, counts = time.perf_counter(), {"converged": 0, "not converged": 0, "wrong": 0, "touching": 0}
    for number in itertools.islice(itertools.count(first), count):
        before = time.perf_counter()
        each = outcome(number)
        seconds = time.perf_counter() - before
        counts["converged" if each.converged else "not converged"] += 1
        counts["wrong"] += bool(each.wrong)
        counts["touching"] += each.touches
        if each.wrong or not each.converged or seconds > 20.0:
            case = Case.of(number)
            about = f"{case.drive}, {PAIRINGS[case.pairing]}, {LAWS[case.law]}, friction {case.friction:.3g}"
            print(f"{number} ({seconds:.1f} s; {about}): {'; '.join(each.wrong) or each.message}", flush=True)
    print(counts, f"{time.perf_counter() - started:.0f} s")
    return int(counts["wrong"] > 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
