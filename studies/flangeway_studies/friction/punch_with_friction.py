"""A rigid punch and a rigid cylinder pressed on a half-plane with friction, beside integral equations.

A half-plane with Poisson's ratio below a half shrinks towards the middle of what presses on it; friction holds it back,
so that it sticks in ``|x| < c`` and slips inwards up to the contact's end a. While the force grows all grows with it:
``c / a`` of a flat punch is that of a cylinder and of every profile of a power (D. A. Spence, 1968, Proc. R. Soc. Lond.
A 305; 1973, Math. Proc. Camb. Phil. Soc. 73), and so is the part of the force with which friction pulls the halves
apart. No citable equation of c is known to us for the plane
with pressure and traction coupled; ``tests/validation/test_punch_with_friction.py`` solves the equations of the flat
punch (K. L. Johnson, 1985, "Contact Mechanics", 2.25) by themselves, an independent route, whose values are in
``flangeway_studies/data/friction.csv``. With a coefficient of 10 nothing slips (N. I. Muskhelishvili, 1953;
Johnson, 1985, 2.8).
"""

from collections.abc import Iterator

import numpy as np

from flangeway.contact import ContactSolution, press
from flangeway.materials import Elastic
from flangeway.solve import StepSettings
from flangeway.types import Floats
from flangeway_studies.friction.blocks import Solved, block, columns, face, growing, shift, touching
from flangeway_studies.study import Row, published_values

YOUNG_MPA, POISSON, RIGID = 210e3, 0.3, 1e4  # RIGID: ratio of the stiffness of the punch to the half-plane's
FRICTIONS, STICKING = (0.2, 0.3), 10.0
CELLS, HALVED = 80, 8  # equal cells on half of the punch; how often the last is halved towards the end
CYLINDER_CELLS, CYLINDER_STEPS, CYLINDER_FRICTION = 40, 40, 0.3
CYLINDER_MM, DEPTH_MM = 1000.0, 0.004  # the cylinder's contact is about 1 mm wide to either side
FAR = 1000.0  # size of what stands for a half-plane, in mm; the punch is 1 mm wide to either side
STICK_LIMIT, PULL_LIMIT = 0.02, 0.005
STICK = "half-width of the stick zone over the contact's"
PULL = "friction that pulls a half outwards over the force"
FLAT, CYLINDER = "Flat punch pressed with friction", "Cylinder pressed with friction"


def flat_punch_pressed(friction: float, cells: int = CELLS) -> ContactSolution:
    """A nearly rigid punch, 1 mm wide to either side, pressed on a half-plane with friction."""
    size = 1.0 / cells
    x = np.concatenate((np.arange(cells) * size, 1.0 - size * 0.5 ** np.arange(1, HALVED + 1), [1.0]))
    last = float(x[-1] - x[-2])
    return _pressed(x, np.concatenate((x, growing(1.0, last, FAR)[1:])), np.inf, last, 1, friction)


def cylinder_pressed(friction: float, cells: int = CYLINDER_CELLS, steps: int = CYLINDER_STEPS) -> ContactSolution:
    """A nearly rigid cylinder pressed on a half-plane in equal steps, with cells of a size on 1 mm."""
    size = 1.0 / cells
    near = np.arange(1.3 * cells + 1.0) * size
    x, far = (np.concatenate((near, growing(float(near[-1]), size, end)[1:])) for end in (3.0, FAR))
    return _pressed(x, far, CYLINDER_MM, size, steps, friction)


def _pressed(x: Floats, far: Floats, radius: float, size: float, steps: int, friction: float) -> ContactSolution:
    half, reach = float(x[-1]), 1.3 * float(x[-1])
    both, wide = (np.concatenate((-half[:0:-1], half)) for half in (x, far))
    rigid, soft = Elastic(RIGID * YOUNG_MPA, POISSON), Elastic(YOUNG_MPA, POISSON)
    upper = block("upper", both, growing(0.0, size, half), rigid, near=half, radius=radius, order=2)
    lower = block("lower", wide, growing(0.0, size, FAR), soft, near=half, order=2)
    contact = touching(face(upper, half), face(lower, reach), friction)
    return press([contact], shift(upper, 0.0, -DEPTH_MM), steps=StepSettings(1.0 / steps, 1.0 / steps))


def stick_and_pull(solution: ContactSolution) -> tuple[float, float]:
    """Stick zone over the contact, and outward pull over the force.

    Both zones end in the middle between nodes of different states, a flat punch's contact at its last node. Tractions
    of the punch are positive along the half-plane's edges, which go to -x; those of the half-plane are opposite.
    """
    table = columns(solution)
    order = np.argsort(table["x"])
    x, sticks, forces, pulls = (table[name][order] for name in ("x", "sticks", "normal_force", "tangential_force"))
    right = x > 0.0
    surface = solution.system.contacts[0].secondary
    at_nodes = surface.part.body.nodes[surface.nodes, 0]
    beyond = at_nodes[at_nodes > x[-1] + 1e-6]
    end = float(x[-1] + beyond.min()) / 2.0 if len(beyond) else float(x[-1])
    slipping = x[right & (sticks == 0)]
    stick = float(x[sticks != 0].max() + slipping.min()) / 2.0 if len(slipping) else end
    force = forces.sum()
    return stick / end, pulls[right].sum() / force


def punch_rows(solved: Solved) -> Iterator[Row]:
    """Rows of the punches and the cylinder."""
    exact = published_values("friction.csv", "punch")
    cases = [(FLAT, friction, flat_punch_pressed) for friction in FRICTIONS]
    for problem, friction, pressed in (*cases, (CYLINDER, CYLINDER_FRICTION, cylinder_pressed)):
        stick, pull = stick_and_pull(solved(pressed(friction)))
        code = f"friction {friction:g}"
        yield Row(problem, code, STICK, "1", stick, exact[f"{friction:g}", "stick"], STICK_LIMIT)
        yield Row(problem, code, PULL, "1", pull, exact[f"{friction:g}", "pull"], PULL_LIMIT)
    _, pull = stick_and_pull(solved(flat_punch_pressed(STICKING)))
    code = f"friction {STICKING:g}, all sticks"
    yield Row(FLAT, code, PULL, "1", pull, exact[f"{STICKING:g}", "pull"], PULL_LIMIT)
