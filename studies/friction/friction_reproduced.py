"""Coulomb friction of plane bodies beside exact solutions: partial slip, its reversal, a sliding punch.

*Partial slip* of cylinders (C. Cattaneo, 1938, Rend. Accad. Naz. Lincei 27; R. D. Mindlin, 1949, J. Appl. Mech. 16; K.
L. Johnson, 1985, "Contact Mechanics", 7.2): two like bodies pressed by P to the half-width a, then pushed by Q, stick
within ``c = a sqrt(1 - Q / mu P)``. After a reversal the stick zone is that of half the change of Q. The missing
traction ``mu p - q`` is an ellipse over the stick zone, so that its second moment gives c. Beyond c the half-planes
slip by the integral of ``K mu p0 / a sqrt(x^2 - c^2)``, ``K = 4 (1 - nu^2) / E``, under the traction mu p: both give
the dissipated work, and twice as much in a reversal.

*A rigid flat punch that slides* (Johnson, 1985, 2.8): the pressure ``(a + x)^(g - 1/2) (a - x)^(-g - 1/2)`` with
``tan(pi g) = -mu (1 - 2 nu) / (2 (1 - nu))`` has its centre at ``2 g a``: behind the middle of a punch that
slides to +x.
"""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flangeway.contact import Contact, ContactSolution, Multiplier, SegmentToSegment, press
from flangeway.materials import Elastic
from flangeway.problems import Part
from flangeway.solve import Iteration, StepSettings
from flangeway.types import Floats, Ints
from studies.friction.blocks import block, face, shift
from studies.friction.ironing import Ironing, ironed_slab, ironing_numbers, ironing_of
from studies.friction.loaded_bodies import loaded_bodies
from studies.friction.punch_with_friction import PunchWithFriction, punches_with_friction
from studies.friction.revolved_contact import revolved_contact
from studies.friction.sliding_bodies import sliding_bodies, strip_loop
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare

YOUNG_MPA, POISSON, MU = 210e3, 0.3, 0.3
RADIUS_MM = 1000.0  # relative radius of the cylinders; their contact is about 2 mm wide
APPROACH_MM = 0.0077
PUSH_MM = 0.0013
REACH_MM, SIZE_MM, FINE_MM = 2000.0, 0.03, 1.5  # half-width and height of the blocks; edges, and where they are fine
NEAR_MM = 2.0 * FINE_MM
N_STEPS = 5
PUNCH_MM, PUNCH_SIZE_MM = 1.0, 0.025  # half-width of the punch, and edges below it
PUNCH_FRICTIONS = (0.2, 0.5)
MOST_ITERATIONS = 30
STICK = "half-width of the stick zone over the contact's"
STICK_LIMIT, WORK_LIMIT, PUNCH_LIMIT = 0.005, 0.05, 0.06


@dataclass(frozen=True)
class PartialSlip:
    """Cylinders after one step of a push or its reversal."""

    leg: str  # push or reversal
    load: float  # change of Q since the leg began, over that which makes all slip
    stick: float  # half-width of the zone that sticks over that of the contact
    x_mm: Floats  # nodes of the contact
    pressures: Floats
    tractions: Floats

    @property
    def exact(self) -> float:
        """Half-width of the stick zone of the exact solution."""
        return float(np.sqrt(1.0 - self.load))


@dataclass(frozen=True, eq=False, kw_only=True)
class FrictionReproduction(Reproduced):
    """What was computed."""

    slips: tuple[PartialSlip, ...]
    strip: tuple[Ints, Floats, Floats]  # see `strip_loop`
    punches: tuple[PunchWithFriction, ...]
    ironing: Ironing
    not_converged: tuple[str, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """See `Reproduced.failures`."""
        return self.not_converged


def reproduce_friction(
    *,
    quick: bool = False,  # noqa: ARG001 (all of it takes seconds)
    progress: Callable[[str], None] = lambda _: None,
) -> FrictionReproduction:
    """Compute all problems, also if `quick`."""
    start = time.perf_counter()
    progress("cylinders in partial slip")
    slips, numbers, solutions = _cylinders()
    for mu in PUNCH_FRICTIONS:
        progress(f"flat punch that slides, friction {mu:g}")
        punch = _sliding_punch(mu)
        solutions.append(punch)
        numbers.append(_punch_number(punch, mu))
    loop: ContactSolution | None = None
    for study in (sliding_bodies, revolved_contact, loaded_bodies):
        rows, more = study(progress)
        numbers += rows
        solutions += more
        loop = loop or more[0]
    assert loop is not None
    rows, more, punches = punches_with_friction(progress)
    numbers += rows
    solutions += more
    progress("ironing")
    solutions.append(ironed_slab())
    ironing = ironing_of(solutions[-1])
    numbers += ironing_numbers(ironing)
    most = max(iterations_of(step.state.history) for solution in solutions for step in solution.steps)
    words = f"{MOST_ITERATIONS:g}"
    given = ("all load steps", "all", "iterations of the slowest step", "1", (0.0, float(most)), MOST_ITERATIONS)
    numbers.append(compare(*given, words=words))
    return FrictionReproduction(
        slips=slips,
        strip=strip_loop(loop),
        punches=punches,
        ironing=ironing,
        not_converged=tuple(each.status.message for each in solutions if not each.status.converged),
        numbers=tuple(numbers),
        seconds=time.perf_counter() - start,
    )


def iterations_of(history: Sequence[Iteration]) -> int:
    """Newton's iterations of the slowest correction of the forces; without augmented Lagrange there is one of all."""
    return max(Counter(each.correction for each in history).values(), default=0)


def stick_rows(found: FrictionReproduction) -> list[Row]:
    """Rows of ``tractions.csv``."""
    return [
        {"leg": each.leg, "load": each.load, "x_mm": x, "pressure_MPa": p, "traction_MPa": q}
        for each in found.slips
        for x, p, q in zip(*(v.tolist() for v in (each.x_mm, each.pressures, each.tractions)), strict=True)
    ]


def _plane_block(
    name: str, *, half: float, radius: float = np.inf, young: float = YOUNG_MPA, size: float = SIZE_MM
) -> Part:
    """A block above or below y = 0, fine at the contact; its face is bulged by a radius."""
    coarse = FINE_MM + size * np.cumsum(1.4 ** np.arange(1, 60))
    side = np.concatenate((np.arange(0.0, FINE_MM + size / 2.0, size), coarse))
    side = side[side < half] if half < REACH_MM else side[side < REACH_MM]
    side = np.append(side[:-1], half)
    x = np.concatenate((-side[:0:-1], side))
    depth = np.concatenate(([0.0], size * np.cumsum(1.3 ** np.arange(60))))
    height = min(half, REACH_MM)  # a punch is as high as half of its width, so that it does not bend
    depth = np.append(depth[depth < 0.8 * height], height)
    return block(name, x, depth, Elastic(young, POISSON), near=NEAR_MM, radius=radius)


def _cylinders() -> tuple[tuple[PartialSlip, ...], list[ReproducedNumber], list[ContactSolution]]:
    upper, lower = _plane_block("upper", half=REACH_MM, radius=RADIUS_MM), _plane_block("lower", half=REACH_MM)
    contact = Contact(face(upper, NEAR_MM), face(lower, NEAR_MM), SegmentToSegment(), Multiplier(), MU)
    path = [shift(upper, 0.0, -APPROACH_MM), shift(upper, PUSH_MM, 0.0), shift(upper, -2.0 * PUSH_MM, 0.0)]
    equal = StepSettings(1.0 / N_STEPS, 1.0 / N_STEPS)
    solution = press([contact], path, steps=[StepSettings(), equal, equal])
    slips: list[PartialSlip] = []
    before = turned = np.zeros(0)
    for step in solution.steps:
        table = {name: np.asarray(v) for name, v in replace(solution, state=step.state).friction_table.columns.items()}
        normal, tangential = table["normal_force"], table["tangential_force"]
        if step.share <= 1.0:
            continue
        back = step.share > 2.0
        if back and not len(turned):
            turned = before
        before = tangential
        missing = (2.0 if back else 1.0) * MU * normal - (turned - tangential if back else np.abs(tangential))
        load = 1.0 - float(missing.sum() / ((2.0 if back else 1.0) * MU * normal.sum()))
        stick = _half_width(table["x"], missing) / _half_width(table["x"], normal)
        given = "reversal" if back else "push", load, stick, table["x"], table["pressure"], table["traction"]
        slips.append(PartialSlip(*given))
    numbers = [
        compare("Cylinders", f"{each.leg}, {each.load:.3f} of sliding", STICK,
                "1", (each.exact, each.stick), STICK_LIMIT)
        for each in slips
    ]  # fmt: skip
    force = float(solution.state.forces.sum())
    work = solution.dissipated_work
    ends = {each.leg: each for each in slips}
    for leg, factor in (("push", 1.0), ("reversal", 2.0)):
        steps = [step.share > 1.0 and (step.share > 2.0) == (leg == "reversal") for step in solution.steps]
        values = factor * partial_slip_work(force, ends[leg].load), float(work[steps].sum())
        numbers.append(compare("Cylinders", leg, "dissipated work", "N mm", values, WORK_LIMIT))
    return tuple(slips), numbers, [solution]


def partial_slip_work(force: float, load: float) -> float:
    """Exact work, per length, that pushing cylinders dissipates up to a part ``load`` of sliding, in N mm / mm."""
    compliance = 4.0 * (1.0 - POISSON**2) / YOUNG_MPA
    a = np.sqrt(2.0 * force * RADIUS_MM * compliance / np.pi)
    peak, c = 2.0 * force / (np.pi * a), a * np.sqrt(1.0 - load)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    x = c + (a - c) * (nodes + 1.0) / 2.0
    root = np.sqrt(x**2 - c**2)
    slip = compliance * MU * peak / a * (x * root - c**2 * np.log((x + root) / c)) / 2.0
    return float((a - c) * (weights * slip * MU * peak * np.sqrt(1.0 - (x / a) ** 2)).sum())


def _half_width(x: Floats, ellipse: Floats) -> float:
    """Half-width of an ellipse of forces by its second moment."""
    x = x - ellipse @ x / ellipse.sum()
    return float(2.0 * np.sqrt(ellipse @ x**2 / ellipse.sum()))


def _sliding_punch(mu: float) -> ContactSolution:
    upper = _plane_block("upper", half=PUNCH_MM, young=1e4 * YOUNG_MPA, size=PUNCH_SIZE_MM)
    lower = _plane_block("lower", half=REACH_MM, size=PUNCH_SIZE_MM)
    contact = Contact(face(upper, NEAR_MM), face(lower, NEAR_MM), SegmentToSegment(), Multiplier(), mu)
    return press([contact], [shift(upper, 0.0, -APPROACH_MM), shift(upper, 10.0 * mu * APPROACH_MM, 0.0)])


def _punch_number(solution: ContactSolution, mu: float) -> ReproducedNumber:
    table = {name: np.asarray(values) for name, values in solution.friction_table.columns.items()}
    centre = float(table["normal_force"] @ table["x"] / table["normal_force"].sum())
    middle = float((table["x"].min() + table["x"].max()) / 2.0)
    exact = -2.0 * np.arctan(mu * (1.0 - 2.0 * POISSON) / (2.0 * (1.0 - POISSON))) / np.pi
    code = f"friction {mu:g}"
    return compare(
        "Flat punch",
        code,
        "centre of pressure over the half-width",
        "1",
        (exact, (centre - middle) / PUNCH_MM),
        PUNCH_LIMIT,
    )
