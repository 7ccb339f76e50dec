"""A strip with distributed friction, and a belt on a drum, beside closed forms.

*A strip* of length L and section A, uniformly pressed upon a rigid base, is moved at one end. Friction of t per length
makes the force fall by t along the part that slips, so that the end moves by ``u = N^2 / (2 t E A)``; after a reversal
changes of both follow the same law at twice the size (G. Masing, 1926, Proc. 2nd Int. Congr. Appl. Mech.), until all
slides under ``N = t L``. A push dissipates a third of ``N u``, a whole loop four thirds. Without lateral strain
(Poisson's ratio 0) the mean over the height of the strip obeys the law exactly where it slips; what the part that
sticks yields by shear is left out of it, a displacement of the order of the height.

*A belt* lies without stress on half of a rigid drum, which is moved so that it pulls at both straight ends, and then
turned until all slips: the tensions differ by ``exp(mu pi)`` (L. Euler, 1769; J. A. Eytelwein, 1808). That is a belt
without thickness. Pressure and friction act at the drum's radius R, the tension of a belt of thickness h at
``R + h / 2``. Equilibrium of an element with a transverse force, which bends nothing since the curvature stays, then
gives ``exp(k pi)`` with ``k = mu r / (1 + k mu (1 - r))``, ``r = R / (R + h / 2)``.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flangeway.contact import ContactSolution, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Arc, Line, Outline, Placement
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, curved, rectangle_grid
from flangeway.problems import Body, Part
from flangeway.solve import StepSettings
from flangeway.types import Floats
from flangeway_studies.friction.blocks import Solved, shift, touching
from flangeway_studies.study import Row

YOUNG_MPA, MU, RIGID = 210e3, 0.3, 1e4
STRIP_MM, STRIP_HEIGHT_MM, STRIP_MPA, SLIPPING = 60.0, 1.0, 100.0, 0.7  # SLIPPING: part of the strip at the reversals
STRIP_CELLS, STRIP_STEPS = 120, 5
DRUM_MM, SPAN_MM, BELT_STRAIN = 100.0, 20.0, 1e-5
BELT_THICKNESSES_MM, BELT_CELLS = (2.0, 1.0, 0.5), 80
STRIP_LIMIT, BELT_LIMIT, FREE_LIMIT = 0.01, 0.01, 1e-5  # FREE_LIMIT: without friction, exact but for the mesh
LEGS = ("push", "reversal", "return", "sliding")


def sliding_rows(solved: Solved) -> Iterator[Row]:
    """Rows of the strip and of the belts; the thinnest belt has the limit, thicker ones show its effect."""
    yield from _strip_rows(solved(pushed_strip()))
    for thickness in BELT_THICKNESSES_MM:
        ratio = float(np.divide(*belt_tensions(solved(turned_belt(thickness, BELT_CELLS)))))
        given = "Belt on a drum", f"thickness {thickness / DRUM_MM:g} of the radius"
        exact, thick = (np.exp(k * np.pi) for k in (MU, belt_exponent(thickness)))
        limit = BELT_LIMIT if thickness == BELT_THICKNESSES_MM[-1] else None
        yield Row(*given, "ratio of tensions", "1", ratio, exact, limit)
        yield Row(*given, "ratio of tensions with its thickness", "1", ratio, thick, BELT_LIMIT)
    free = solved(turned_belt(BELT_THICKNESSES_MM[0], BELT_CELLS, mu=0.0))
    before, after = (
        np.array(belt_tensions(replace(free, state=step.state))) for step in (free.steps[0], free.steps[-1])
    )
    given = "Belt on a drum without friction", f"thickness {BELT_THICKNESSES_MM[0] / DRUM_MM:g} of the radius"
    yield Row(*given, "ratio of tensions", "1", np.divide(*after), 1.0, FREE_LIMIT)
    change = np.abs(after / before - 1.0).max()
    yield Row(*given, "change of a tension by turning", "1", change, 0.0, FREE_LIMIT)


def _tangential_force() -> float:
    """Friction per length of the strip."""
    return MU * STRIP_MPA


def strip_turn() -> float:
    """Displacement of the strip's end at the reversals."""
    return (SLIPPING * STRIP_MM) ** 2 * _tangential_force() / (2.0 * YOUNG_MPA * STRIP_HEIGHT_MM)


def _strip_ends() -> tuple[float, float]:
    """Force and displacement of the strip's end at the reversals."""
    return _tangential_force() * SLIPPING * STRIP_MM, strip_turn()


def pushed_strip() -> ContactSolution:
    """A strip that is pressed, pulled, pushed back, pulled again, and pulled until all slides."""
    mesh = rectangle_grid(STRIP_MM, STRIP_HEIGHT_MM, STRIP_CELLS, 2)
    steel = Elastic(YOUNG_MPA, 0.0, "plane_stress")
    strip = Part("strip", Body("strip", mesh, Lagrange(2), steel, {"top": "y", "right": "x"}))
    wide, height = STRIP_MM + 20.0 * STRIP_HEIGHT_MM, 4.0 * STRIP_HEIGHT_MM
    ground = rectangle_grid(wide, height, STRIP_CELLS // 2, 2, origin=(-10.0 * STRIP_HEIGHT_MM, -height))
    base = Part("base", Body("base", ground, Lagrange(2), replace(steel, young=RIGID * YOUNG_MPA), "bottom"))
    sides = Surface(strip, mesh.edge_sets["bottom"]), Surface(base, ground.edge_sets["top"])
    u = strip_turn()
    path = [(0.0, -STRIP_MPA * STRIP_HEIGHT_MM / YOUNG_MPA), (u, 0.0), (-2.0 * u, 0.0), (2.0 * u, 0.0), (1.5 * u, 0.0)]
    equal = StepSettings(1.0 / STRIP_STEPS, 1.0 / STRIP_STEPS)
    contact = touching(*sides, MU)
    return press([contact], [shift(strip, *point) for point in path], steps=[StepSettings(), *len(LEGS) * [equal]])


def strip_force(leg: int, displacement: float) -> float:
    """Exact force at the strip's end at a displacement on the way of a leg, an index of `LEGS`."""
    force, u = _strip_ends()
    law = 2.0 * _tangential_force() * YOUNG_MPA * STRIP_HEIGHT_MM
    if LEGS[leg] == "reversal":
        return force - np.sqrt(2.0 * law * max(u - displacement, 0.0))
    if LEGS[leg] == "return":
        return np.sqrt(2.0 * law * max(u + displacement, 0.0)) - force
    return min(np.sqrt(law * displacement), _tangential_force() * STRIP_MM)


def _strip_rows(solution: ContactSolution) -> Iterator[Row]:
    force, u = _strip_ends()
    shares = np.array([step.share for step in solution.steps[1:]])
    # displacement and force of the strip's end in each step after the pressing
    at = np.interp(shares, np.arange(6), [0.0, 0.0, u, -u, u, 2.5 * u])
    forces = np.array([-replace(solution, state=step.state).forces[0, 0] for step in solution.steps[1:]])
    legs = np.ceil(shares - 1e-9).astype(np.int64) - 2
    exact = np.array([strip_force(leg, position) for leg, position in zip(legs.tolist(), at.tolist(), strict=True)])
    for number, leg in enumerate(LEGS):
        worst = np.abs(forces - exact)[legs == number].max() / force
        yield Row("Strip", leg, "largest difference of force over that of the reversal", "1", worst, 0.0, STRIP_LIMIT)
    work = np.bincount(legs, solution.dissipated_work[1:])
    for code, part, value in (("push", 1.0 / 3.0, work[0]), ("loop", 4.0 / 3.0, work[1] + work[2])):
        yield Row("Strip", code, "dissipated work", "N mm", value, part * force * u, STRIP_LIMIT)


def belt_exponent(thickness: float, mu: float = MU) -> float:
    """Exponent k of a belt with a thickness, see the head of the file."""
    ratio, exponent = DRUM_MM / (DRUM_MM + thickness / 2.0), mu
    for _ in range(50):
        exponent = mu * ratio / (1.0 + exponent * mu * (1.0 - ratio))
    return exponent


def turned_belt(thickness: float, cells: int, strain: float = BELT_STRAIN, mu: float = MU) -> ContactSolution:
    """A belt over the upper half of a drum that moves up and turns until all slips, with cells along the arc."""
    arc = np.linspace(0.0, np.pi * DRUM_MM, cells + 1)
    straight = np.linspace(0.0, SPAN_MM, cells // 10 + 1)[1:]
    along = np.concatenate((-straight[::-1], arc, arc[-1] + straight))
    belt_mesh = _around(along, np.array([0.0, thickness]), SPAN_MM)
    drum_mesh = _around(arc, np.array([-0.2, -0.1, 0.0]) * DRUM_MM, 0.0)
    steel = Elastic(YOUNG_MPA, 0.0, "plane_stress")
    belt = Part("belt", Body("belt", belt_mesh, Lagrange(2), steel, {"left": "xy", "right": "xy"}))
    drum = Part("drum", Body("drum", drum_mesh, Lagrange(2), replace(steel, young=RIGID * YOUNG_MPA), "bottom"))
    edges = belt_mesh.edge_sets["bottom"]
    wound = edges[belt_mesh.points[edges].mean(axis=1)[:, 1] > 0.0]
    sides = Surface(belt, wound), Surface(drum, drum_mesh.edge_sets["top"])
    contact = touching(*sides, mu)
    up = strain * (arc[-1] + 2.0 * SPAN_MM) / 2.0
    turn = {drum: Placement.about((0.0, up), -2.5 * up / DRUM_MM)}
    return press([contact], [shift(drum, 0.0, up), turn], steps=[StepSettings(), StepSettings(0.5, 0.5)])


def belt_tensions(solution: ContactSolution) -> tuple[float, float]:
    """Tension at the left and at the right end of the belt, by its stiffness and displacements."""
    belt = solution.system.contacts[0].secondary.part
    field = solution.field(belt)
    forces = (field.problem.stiffness().full() @ field.displacements.ravel()).reshape(-1, 2)
    space = field.space
    left, right = (np.unique(space.edge_nodes(space.mesh.edge_sets[side])) for side in ("left", "right"))
    return -forces[left, 1].sum(), -forces[right, 1].sum()


def _around(along: Floats, heights: Floats, span: float) -> PolyMesh:
    """Cells over the upper half of the drum and straight down from both of its sides, at heights over its surface."""
    grid = rectangle_grid(1.0, 1.0, len(along) - 1, len(heights) - 1)
    s, height = (coordinates.ravel() for coordinates in np.meshgrid(along, heights))
    half = np.pi * DRUM_MM
    angle, radius = np.pi - np.clip(s, 0.0, half) / DRUM_MM, DRUM_MM + height
    y = radius * np.sin(angle) + np.minimum(s, 0.0) - np.maximum(s - half, 0.0)
    points = np.column_stack((radius * np.cos(angle), y))
    inner, outer = (DRUM_MM + float(heights[end]) for end in (0, -1))
    right = [(inner, 0.0), (inner, -span), (outer, -span), (outer, 0.0)]
    lines = [Line(start, end) for start, end in pairwise(right) if np.any(np.subtract(end, start))]
    others = [Line((-line.end[0], line.end[1]), (-line.start[0], line.start[1])) for line in lines[::-1]]
    under = Arc((-inner, 0.0), (inner, 0.0), (0.0, 0.0), counter_clockwise=False)
    over = Arc((outer, 0.0), (-outer, 0.0), (0.0, 0.0), counter_clockwise=True)
    sides: list[Line | Arc] = [under, *lines, over, *others]
    return curved(replace(grid, points=points), Outline.from_segments(sides, len(sides) * ["side"]))
