"""Friction of the studies: a belt, a die that slides along a slab, and a flat punch beside its integral equations.

The punch's, integrated once (K. L. Johnson, 1985, "Contact Mechanics", 2.25), ``b = (1 - 2 nu) / (2 (1 - nu))``::

    (1/pi) int p(s) ln|x - s| ds - b int_0^x q ds = constant           |x| < a
    (1/pi) int q(s) ln|x - s| ds + b int_0^x p ds = 0                  |x| < c
    q = mu p sgn(x)                                                    c < |x| < a

p and q are constant on intervals that shrink towards c and a. The c is right at which q does not grow without limit.
Left out of the first equation, b gives the equation ``K'(c/a) / K(c/a) = b / mu`` of complete elliptic integrals
(Spence, 1975, J. Elasticity 5; Johnson, 1985, 5.4). If nothing slips, ``p + i q = P 2 (1 - nu) / sqrt(3 - 4 nu) / (pi
sqrt(a^2 - x^2)) exp(i g ln((a + x) / (a - x)))``, ``g = ln(3 - 4 nu) / 2 pi`` (N. I. Muskhelishvili, 1953).
"""

import re
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

from flangeway.types import Floats
from flangeway_studies.friction import ironing
from flangeway_studies.friction.punch_with_friction import POISSON
from flangeway_studies.friction.sliding_bodies import BELT_STRAIN, belt_exponent, belt_tensions, turned_belt
from flangeway_studies.study import published_values

COUPLING = (1.0 - 2.0 * POISSON) / (2.0 * (1.0 - POISSON))
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


@cache
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


@pytest.mark.parametrize("friction", [0.15, 0.3])
def test_without_coupling_the_stick_zone_obeys_spences_equation(friction: float) -> None:
    """K'(c) / K(c) = b / mu of complete elliptic integrals, with the parameter c^2."""
    exact = brentq(lambda c: ellipk(1.0 - c**2) / ellipk(c**2) - COUPLING / friction, 0.01, 0.99)
    assert pressed_punch(friction, ratio=1.2, coupled=False).stick == pytest.approx(exact, rel=1e-4)


def test_much_friction_gives_the_pull_of_the_punch_that_sticks() -> None:
    """The integral equations with the coefficient 1 stick to 0.3 % of the end: within 0.2 % of Muskhelishvili's."""
    half = pressed_punch(1.0, ratio=1.2)
    assert half.stick > 0.997
    assert half.pull == pytest.approx(sticking_pull(), rel=2e-3)


@pytest.mark.parametrize("friction", [pytest.param(0.2, marks=pytest.mark.ci), 0.3])
def test_published_values_are_those_of_the_equations(friction: float) -> None:
    """Stick zones and pulls in `flangeway_studies/data/friction.csv` are computed here."""
    known = published_values("friction.csv", "punch")
    half = pressed_punch(friction)
    assert (known[f"{friction:g}", "stick"], known[f"{friction:g}", "pull"]) == pytest.approx((half.stick, half.pull))
    assert known["10", "pull"] == pytest.approx(sticking_pull())


@pytest.mark.parametrize(("thickness", "cells", "pull", "mu"), [(1.0, 40, 100.0, 0.6), (2.0, 40, 100.0, 1.5)])
def test_a_belt_that_is_pulled_hard_is_found_in_few_iterations(thickness, cells, pull, mu) -> None:
    """10 and 100 times the pull, friction up to 1.5: at most 30 iterations a step, none halved, Eytelwein to 6 %.

    Pressure on a curved surface makes the belt alone unstable, so that the matrix of the contact is indefinite.
    """
    belt = turned_belt(thickness, cells, pull * BELT_STRAIN, mu)
    assert belt.status.converged, belt.status.message
    assert [step.share for step in belt.steps] == [1.0, 1.5, 2.0]
    assert max(step.state.status.iterations for step in belt.steps) <= 30
    ratio = np.divide(*belt_tensions(belt))
    assert ratio == pytest.approx(np.exp(belt_exponent(thickness, mu) * np.pi), rel=0.02 if mu < 1.0 else 0.06)


def test_the_published_ratios_in_sliding_are_those_of_the_collection() -> None:
    """Batistic, Cardiff and Tukovic (2022) give the ratio of both forces at time 1.5 for each curve, within 0.015."""
    collected = {
        "Poulios, Renard 2015": 0.30,
        "Code_Aster SSNP153": 0.34,
        "Hartmann et al. 2009": 0.38,
        "Yastrebov 2011": 0.47,
        "Fischer, Wriggers 2006": 0.53,
    }
    normal, tangential = (published_values("friction.csv", case) for case in ("normal", "tangential"))
    assert normal.keys() == tangential.keys()
    assert {name for _, name in normal} == set(collected)
    for name, ratio in collected.items():
        assert tangential["1.5", name] / normal["1.5", name] == pytest.approx(ratio, abs=0.015)
        lowered = [value for (time, other), value in normal.items() if other == name and float(time) <= 1.04]
        assert (np.diff(lowered) > 0.0).all()


def test_a_coarse_die_slides_in_long_steps() -> None:
    """Cells a third as fine in steps of 3/10 mm converge, to the forces of the fine mesh within 5 %."""
    found = ironing.ironed_slab(cells=(40, 10), steps=(5, 20))
    assert found.status.converged, found.status.message
    assert max(step.state.status.iterations for step in found.steps) <= 30
    shares = [step.share for step in found.steps]
    forces = np.array([replace(found, state=step.state).forces[0] for step in found.steps])
    # time 1.5 is half of 10 mm along, of which 6 are computed
    x, y = (float(np.interp(1.0 + 5.0 / 6.0, shares, force)) for force in forces.T)
    assert (y, -x) == pytest.approx((367.0, 144.4), rel=0.05)


@pytest.mark.ci
def test_a_surface_that_folds_is_named(monkeypatch) -> None:
    """With friction 1.5 the slab folds before the die: the message names the bodies and the node."""
    monkeypatch.setattr(ironing, "MU", 1.5)
    found = ironing.ironed_slab(cells=(40, 10), steps=(5, 20))
    assert not found.status.converged
    assert {"'die'", "'slab'"} <= set(re.findall(r"'\w+'", found.status.message))
    assert re.search(r"at node \d+ of", found.status.message)
