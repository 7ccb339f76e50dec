"""A rigid punch and a rigid cylinder pressed on a half-plane with friction, beside integral equations.

A half-plane with Poisson's ratio below a half shrinks towards the middle of what presses on it; friction holds it back,
so that it sticks in ``|x| < c`` and slips inwards up to the contact's end a. While the force grows all grows with it:
``c / a`` of a flat punch is that of a cylinder and of every profile of a power (D. A. Spence, 1968, Proc. R. Soc. Lond.
A 305; 1973, Math. Proc. Camb. Phil. Soc. 73), and so is the part of the force with which friction pulls the halves
apart. No citable equation of c is known to us for the plane with pressure and traction coupled; the equations
of the flat punch (K. L. Johnson, 1985, "Contact Mechanics", 2.25), integrated once, are solved by themselves::

    (1/pi) int p(s) ln|x - s| ds - b int_0^x q ds = constant           |x| < a
    (1/pi) int q(s) ln|x - s| ds + b int_0^x p ds = 0                  |x| < c
    q = mu p sgn(x)                                                    c < |x| < a

with ``b = (1 - 2 nu) / (2 (1 - nu))``, constant p and q on intervals that shrink towards c and a. The c is right at
which q does not grow without limit. Left out of the first equation, b gives the equation ``K'(c/a) / K(c/a) = b / mu``
of complete elliptic integrals (Spence, 1975, J. Elasticity 5; Johnson, 1985, 5.4), which the equations then obey in a
test.

If nothing slips, ``p + i q = P 2 (1 - nu) / sqrt(3 - 4 nu) / (pi sqrt(a^2 - x^2)) exp(i g ln((a + x) / (a - x)))``,
``g = ln(3 - 4 nu) / 2 pi`` (N. I. Muskhelishvili, 1953; Johnson, 1985, 2.8); a coefficient of friction of 10 comes
within 1e-6 a of it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from flangeway.contact import Contact, ContactSolution, Multiplier, SegmentToSegment, press
from flangeway.materials import Elastic
from flangeway.solve import StepSettings
from flangeway.types import Floats
from studies.friction.blocks import block, face, growing, shift
from studies.published_numbers import ReproducedNumber, compare

YOUNG_MPA, POISSON, RIGID = 210e3, 0.3, 1e4  # RIGID: stiffness of the punch over the half-plane's
COUPLING = (1.0 - 2.0 * POISSON) / (2.0 * (1.0 - POISSON))
FRICTIONS, STICKING = (0.2, 0.3), 10.0
CELLS, HALVED = 80, 8  # equal cells on half of the punch; how often the last is halved towards the end
CYLINDER_CELLS, CYLINDER_STEPS, CYLINDER_FRICTION = 40, 40, 0.3
CYLINDER_MM, DEPTH_MM = 1000.0, 0.004  # the cylinder's contact is about 1 mm wide to either side
FAR = 1000.0  # size of what stands for a half-plane, in mm; the punch is 1 mm wide to either side
PUNCH_STICK_LIMIT, PULL_LIMIT = 0.02, 0.005
STICK = "half-width of the stick zone over the contact's"
PULL = "friction that pulls a half outwards over the force"
FLAT, CYLINDER = "Flat punch pressed with friction", "Cylinder pressed with friction"
FAR_AWAY = 1e3  # distance over half the width of an interval, from which the series is exact to 1e-13
RATIO, SMALLEST = 1.1, 1e-9  # of the intervals of the integral equations: a length over the next, the last over c


@dataclass(frozen=True, eq=False)
class PressedHalf:
    """Pressure and friction on one half of a contact from 0 to 1 under the force 1.

    Parameters
    ----------
    x, widths
        Middles and widths of intervals, shape (n,).
    pressures, tractions
        On them; tractions pull outwards, shape (n,).
    stick
        Half-width of the stick zone.

    """

    x: Floats
    widths: Floats
    pressures: Floats
    tractions: Floats
    stick: float

    @property
    def pull(self) -> float:
        """Friction that pulls the half outwards."""
        return float(self.widths @ self.tractions)


def pressed_punch(friction: float, *, ratio: float = RATIO, coupled: bool = True) -> PressedHalf:
    """Solution of the integral equations of the flat punch, without the effect of q on p if not coupled."""

    def growth(stick: float) -> float:
        """What grows without limit of q towards the stick zone's end."""
        half = _half(stick, friction, ratio, coupled)
        inside = half.x < stick
        at = np.argmin(np.where(inside, np.abs(stick * (1.0 - 1e-6) - half.x), np.inf))
        return float((half.tractions[at] - friction * half.pressures[at]) * np.sqrt(stick - half.x[at]))

    return _half(float(brentq(growth, 0.02, 0.9999, xtol=1e-9)), friction, ratio, coupled)


def _half(stick: float, friction: float, ratio: float, coupled: bool) -> PressedHalf:
    falling = np.append(ratio ** -np.arange(np.ceil(-np.log(SMALLEST) / np.log(ratio))), 0.0)
    room = (1.0 - stick) / 2.0
    ends = np.unique(np.concatenate((stick - stick * falling, stick + room * falling, 1.0 - room * falling)))
    x, widths, n = (ends[1:] + ends[:-1]) / 2.0, np.diff(ends), len(ends) - 1
    # [i, j] = integral of ln|x_i - s| / pi over interval j, and over its mirror image
    right, left = (_integral_of_log(x[:, None] - centres, widths) / np.pi for centres in (x, -x))
    before = np.tril(np.broadcast_to(widths, (n, n)), -1) + np.diag(widths / 2.0)  # integral from 0 to x_i
    matrix, given = np.zeros((2 * n + 1, 2 * n + 1)), np.zeros(2 * n + 1)
    matrix[:n, :n], matrix[:n, -1] = right + left, 1.0
    if coupled:
        matrix[:n, n:-1] = -COUPLING * before
    sticks, slips = np.flatnonzero(x < stick), np.flatnonzero(x >= stick)
    matrix[n + sticks, :n], matrix[n + sticks, n:-1] = COUPLING * before[sticks], (right - left)[sticks]
    matrix[n + slips, slips], matrix[n + slips, n + slips] = -friction, 1.0
    matrix[-1, :n], given[-1] = widths, 0.5
    found = np.asarray(np.linalg.solve(matrix, given), dtype=np.float64)
    return PressedHalf(x, widths, found[:n], found[n:-1], stick)


def _integral_of_log(distances: Floats, widths: Floats) -> Floats:
    """Integral of ln|u - s| over s within half a width, for distances u (n, m) and widths (m,).

    From far away the difference of antiderivatives would lose the digits of a narrow interval: a series has them.
    """
    half = widths / 2.0
    near = np.abs(distances) < FAR_AWAY * half
    far = np.where(near, 1.0, distances)
    series = widths * (np.log(np.abs(far)) - (half / far) ** 2 / 6.0)
    return np.where(near, _log(distances + half) - _log(distances - half), series)


def _log(u: Floats) -> Floats:
    """Antiderivative of ln|u|."""
    size = np.maximum(np.abs(u), np.finfo(np.float64).tiny)
    return np.asarray(u * np.log(size) - u)


def sticking_pull() -> float:
    """Friction that pulls a half outwards over the force if nothing slips, by x = tanh t."""
    g = np.log(3.0 - 4.0 * POISSON) / (2.0 * np.pi)
    t = np.linspace(0.0, 40.0, 40001)
    factor = 2.0 * (1.0 - POISSON) / np.sqrt(3.0 - 4.0 * POISSON) / np.pi
    return float(factor * np.trapezoid(np.sin(2.0 * g * t) / np.cosh(t), t))


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
    both, wide = (np.concatenate((-each[:0:-1], each)) for each in (x, far))
    rigid, soft = Elastic(RIGID * YOUNG_MPA, POISSON), Elastic(YOUNG_MPA, POISSON)
    upper = block("upper", both, growing(0.0, size, half), rigid, near=half, radius=radius, order=2)
    lower = block("lower", wide, growing(0.0, size, FAR), soft, near=half, order=2)
    contact = Contact(face(upper, half), face(lower, reach), SegmentToSegment(), Multiplier(), friction)
    return press([contact], shift(upper, 0.0, -DEPTH_MM), steps=StepSettings(1.0 / steps, 1.0 / steps))


def half_of(solution: ContactSolution) -> tuple[float, float, Floats]:
    """Stick zone over the contact, outward pull over the force, and rows of x, pressure and outward traction.

    Lengths are over the contact's half-width, stresses over the force per half-width; both zones end in the middle
    between nodes of different states, a flat punch's contact at its last node. Tractions of the punch are positive
    along the half-plane's edges, which go to -x; those of the half-plane are opposite.
    """
    table = {name: np.asarray(values) for name, values in solution.friction_table.columns.items()}
    order = np.argsort(table["x"])
    x, sticks, forces, pulls = (table[name][order] for name in ("x", "sticks", "normal_force", "tangential_force"))
    right = x > 0.0
    surface = solution.system.contacts[0].secondary
    places = surface.part.body.nodes[surface.nodes, 0]
    beyond = places[places > x[-1] + 1e-6]
    end = float(x[-1] + beyond.min()) / 2.0 if len(beyond) else float(x[-1])
    slipping = x[right & ~sticks]
    stick = float(x[sticks].max() + slipping.min()) / 2.0 if len(slipping) else end
    force = float(forces.sum())
    stresses = (table[name][order][right] * end / force for name in ("pressure", "traction"))
    return stick / end, float(pulls[right].sum()) / force, np.array([x[right] / end, *stresses])


@dataclass(frozen=True, eq=False)
class PunchWithFriction:
    """The flat punch with a coefficient of friction."""

    friction: float
    exact: PressedHalf
    found: Floats  # rows of `half_of`


def punches_with_friction(
    progress: Callable[[str], None],
) -> tuple[list[ReproducedNumber], list[ContactSolution], tuple[PunchWithFriction, ...]]:
    """Rows of the punches and the cylinder, their solutions, and what is drawn."""
    numbers: list[ReproducedNumber] = []
    solutions: list[ContactSolution] = []
    drawn: list[PunchWithFriction] = []
    cases = [(FLAT, friction, flat_punch_pressed) for friction in FRICTIONS]
    for problem, friction, pressed in (*cases, (CYLINDER, CYLINDER_FRICTION, cylinder_pressed)):
        progress(f"{problem[0].lower()}{problem[1:]} {friction:g}")
        exact, solution = pressed_punch(friction), pressed(friction)
        stick, pull, rows = half_of(solution)
        solutions.append(solution)
        if problem == FLAT:
            drawn.append(PunchWithFriction(friction, exact, rows))
        given = problem, f"friction {friction:g}"
        numbers += [
            compare(*given, STICK, "1", (exact.stick, stick), PUNCH_STICK_LIMIT),
            compare(*given, PULL, "1", (exact.pull, pull), PULL_LIMIT),
        ]
    solutions.append(flat_punch_pressed(STICKING))
    values = sticking_pull(), half_of(solutions[-1])[1]
    numbers.append(compare(FLAT, f"friction {STICKING:g}, all sticks", PULL, "1", values, PULL_LIMIT))
    return numbers, solutions, tuple(drawn)
