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

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flangeway.contact import press
from flangeway.materials import Elastic
from flangeway.problems import Part
from flangeway.solve import StepSettings
from flangeway.types import Floats
from flangeway_studies.friction.blocks import Solved, block, columns, face, shift, touching
from flangeway_studies.friction.ironing import ironing_rows
from flangeway_studies.friction.loaded_bodies import loaded_body_rows
from flangeway_studies.friction.punch_with_friction import punch_rows
from flangeway_studies.friction.revolved_contact import revolved_rows
from flangeway_studies.friction.sliding_bodies import sliding_rows
from flangeway_studies.study import Row, Run

YOUNG_MPA, POISSON, MU = 210e3, 0.3, 0.3
RADIUS_MM = 1000.0  # relative radius of the cylinders; their contact is about 2 mm wide
APPROACH_MM = 0.0077
PUSH_MM = 0.0013
REACH_MM, SIZE_MM, FINE_MM = 2000.0, 0.03, 1.5  # half-width and height of the blocks; edges, and where they are fine
NEAR_MM = 2.0 * FINE_MM
N_STEPS = 5
PUNCH_MM, PUNCH_SIZE_MM = 1.0, 0.025  # half-width of the punch, and edges below it
PUNCH_FRICTIONS = (0.2, 0.5)
MAX_ITERATIONS = 30
STICK = "half-width of the stick zone over the contact's"
STICK_LIMIT, WORK_LIMIT, PUNCH_LIMIT = 0.005, 0.05, 0.06


def rows(run: Run) -> Iterator[Row]:
    """Rows of all problems."""
    solved = Solved(run)
    yield from _cylinder_rows(solved)
    for mu in PUNCH_FRICTIONS:
        yield _sliding_punch_row(mu, solved)
    for part in (sliding_rows, revolved_rows, loaded_body_rows, punch_rows, ironing_rows):
        yield from part(solved)
    yield Row("all load steps", "all", "iterations of the slowest step", "1", solved.slowest, 0.0, MAX_ITERATIONS)


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


def _cylinder_rows(solved: Solved) -> Iterator[Row]:
    upper, lower = _plane_block("upper", half=REACH_MM, radius=RADIUS_MM), _plane_block("lower", half=REACH_MM)
    contact = touching(face(upper, NEAR_MM), face(lower, NEAR_MM), MU)
    path = [shift(upper, 0.0, -APPROACH_MM), shift(upper, PUSH_MM, 0.0), shift(upper, -2.0 * PUSH_MM, 0.0)]
    equal = StepSettings(1.0 / N_STEPS, 1.0 / N_STEPS)
    solution = solved(press([contact], path, steps=[StepSettings(), equal, equal]))
    loads, works, force = {}, {"push": 0.0, "reversal": 0.0}, solution.state.forces.sum()
    before = turned = np.zeros(0)
    for step, work in zip(solution.steps, solution.dissipated_work, strict=True):
        if step.share <= 1.0:
            continue
        table = columns(replace(solution, state=step.state))
        normal, tangential, back = table["normal_force"], table["tangential_force"], step.share > 2.0
        if back and not len(turned):
            turned = before
        before = tangential
        leg, factor = ("reversal", 2.0) if back else ("push", 1.0)
        missing = factor * MU * normal - (turned - tangential if back else np.abs(tangential))
        loads[leg] = 1.0 - (missing.sum() / (factor * MU * normal.sum()))
        works[leg] += work
        stick = _half_width(table["x"], missing) / _half_width(table["x"], normal)
        exact, code = np.sqrt(1.0 - loads[leg]), f"{leg}, {loads[leg]:.3f} of sliding"
        yield Row("Cylinders", code, STICK, "1", stick, exact, STICK_LIMIT)
        solved.run.curve(
            "tractions", leg, f"step {round(5.0 * (step.share % 1.0) or 5.0)}", table["x"], table["traction"]
        )
        if abs(step.share - round(step.share)) < 1e-9:
            for sign in (1.0, -1.0):
                solved.run.curve(
                    "tractions", leg, "limit by the pressure", table["x"], sign * MU * table["pressure"], "--"
                )
    for leg, factor in (("push", 1.0), ("reversal", 2.0)):
        exact = factor * partial_slip_work(force, loads[leg])
        yield Row("Cylinders", leg, "dissipated work", "N mm", works[leg], exact, WORK_LIMIT)


def partial_slip_work(force: float, load: float) -> float:
    """Exact work, per length, that pushing cylinders dissipates up to a part ``load`` of sliding, in N mm / mm."""
    compliance = 4.0 * (1.0 - POISSON**2) / YOUNG_MPA
    a = np.sqrt(2.0 * force * RADIUS_MM * compliance / np.pi)
    peak, c = 2.0 * force / (np.pi * a), a * np.sqrt(1.0 - load)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    x = c + (a - c) * (nodes + 1.0) / 2.0
    root = np.sqrt(x**2 - c**2)
    slip = compliance * MU * peak / a * (x * root - c**2 * np.log((x + root) / c)) / 2.0
    return (a - c) * (weights * slip * MU * peak * np.sqrt(1.0 - (x / a) ** 2)).sum()


def _half_width(x: Floats, ellipse: Floats) -> float:
    """Half-width of an ellipse of forces by its second moment."""
    x = x - ellipse @ x / ellipse.sum()
    return 2.0 * np.sqrt(ellipse @ x**2 / ellipse.sum())


def _sliding_punch_row(mu: float, solved: Solved) -> Row:
    upper = _plane_block("upper", half=PUNCH_MM, young=1e4 * YOUNG_MPA, size=PUNCH_SIZE_MM)
    lower = _plane_block("lower", half=REACH_MM, size=PUNCH_SIZE_MM)
    contact = touching(face(upper, NEAR_MM), face(lower, NEAR_MM), mu)
    path = [shift(upper, 0.0, -APPROACH_MM), shift(upper, 10.0 * mu * APPROACH_MM, 0.0)]
    table = columns(solved(press([contact], path)))
    centre = table["normal_force"] @ table["x"] / table["normal_force"].sum()
    middle = (table["x"].min() + table["x"].max()) / 2.0
    exact = -2.0 * np.arctan(mu * (1.0 - 2.0 * POISSON) / (2.0 * (1.0 - POISSON))) / np.pi
    quantity = "centre of pressure over the half-width"
    return Row("Flat punch", f"friction {mu:g}", quantity, "1", (centre - middle) / PUNCH_MM, exact, PUNCH_LIMIT)
