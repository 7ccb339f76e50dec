"""A wheel of one arc on a rail of one arc, through the whole wheelset machinery, against Hertz's line contact.

In two dimensions the approach of two bodies has no limit for half planes: ``delta = P (C - ln P) / (pi E*)`` with a
number C that the bodies' shapes give (Johnson, 1985, 5.6). So ``delta(2 P) - 2 delta(P) = -2 P ln 2 / (pi E*)``
whatever the shapes: what the approach's derivative changes by, without the noise that single elements at the edge of
the contact put on a derivative. That is compared.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from flangeway.exact import LineContact
from flangeway.geometry import Arc, Line, Outline
from flangeway.materials import Elastic
from flangeway.post import PressurePatch
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset

WHEEL_RADIUS_MM, RAIL_RADIUS_MM = 330.0, 254.0
WIDTH_MM, HEIGHT_MM = 140.0, 120.0
LOADS_N = (60e3, 120e3)
"""Loads of the wheelset, half of them on each side; the second twice the first."""

THICKNESS_MM = 10.0
SOURCE = "one arc between straight lines, to compare with Hertz's theory"


@dataclass(frozen=True, eq=False)
class OneArcContact:
    """One side of the wheelset under a load.

    Parameters
    ----------
    load_N
        Force on the side.
    result
        Solution of the wheelset.
    pressure_MPa, half_width_mm
        Maximum pressure and half width of the ellipse that fits the pressures of the nodes best.
    approach_mm
        How far the wheelset sinks.
    theory
        Hertz's contact of the two arcs under that force.

    """

    load_N: float  # noqa: N815 (the unit newton)
    result: WheelsetResult
    pressure_MPa: float  # noqa: N815
    half_width_mm: float
    approach_mm: float
    theory: LineContact


def one_arc_rail() -> RailProfile:
    """Return a block with a round top, the middle of its base at the origin."""
    half = 0.5 * WIDTH_MM
    low = HEIGHT_MM - _sagitta(RAIL_RADIUS_MM, half)
    outline = Outline.from_segments(
        [
            Line((-half, 0.0), (half, 0.0)),
            Line((half, 0.0), (half, low)),
            Arc((half, low), (-half, low), (0.0, HEIGHT_MM - RAIL_RADIUS_MM), counter_clockwise=True),
            Line((-half, low), (-half, 0.0)),
        ],
        ["base", "field", "head", "gauge"],
    )
    return RailProfile("block with a round top", outline, ("head",), ("base",), "exact", SOURCE)


def one_arc_wheel() -> WheelProfile:
    """Return a block with a round bottom, the lowest point on the tape line."""
    half = 0.5 * WIDTH_MM
    low = _sagitta(WHEEL_RADIUS_MM, half)
    outline = Outline.from_segments(
        [
            Arc((-half, low), (half, low), (0.0, WHEEL_RADIUS_MM), counter_clockwise=True),
            Line((half, low), (half, HEIGHT_MM)),
            Line((half, HEIGHT_MM), (-half, HEIGHT_MM)),
            Line((-half, HEIGHT_MM), (-half, low)),
        ],
        ["tread", "rim", "cut", "back"],
    )
    return WheelProfile("block with a round bottom", outline, ("tread",), 0.0, half, "exact", SOURCE)


def one_arc_contacts(discretisation: Discretisation, material: Elastic) -> tuple[OneArcContact, ...]:
    """Solve both loads."""
    track = Track(one_arc_rail(), gauge_mm=1500.0, rail_inclination=0.0)
    # the wheels stand over the middles of their rails
    wheelset = Wheelset(one_arc_wheel(), back_to_back_mm=1500.0, radius_mm=500.0, centre_of_gravity_height_mm=0.0)
    # round on round a wheelset is not stable sideways
    upright = Prescribed(lateral_mm=0.0, roll_rad=0.0)
    problem = WheelsetProblem(
        track, wheelset, WheelsetLoad(LOADS_N[0]), material, THICKNESS_MM, discretisation, prescribed=upright
    )
    return tuple(_contact(solve_wheelset(replace(problem, load=WheelsetLoad(load)), cold=True)) for load in LOADS_N)


def _contact(result: WheelsetResult) -> OneArcContact:
    model, load = result.model, result.model.problem.load.vertical_N
    patch = next(patch for patch in result.patches if patch.side == "right")
    theory = LineContact(0.5 * load / THICKNESS_MM, 1.0 / WHEEL_RADIUS_MM + 1.0 / RAIL_RADIUS_MM, model.hertz.modulus)
    return OneArcContact(
        0.5 * load,
        result,
        *_ellipse(patch.pressure),
        result.approach_mm,
        theory,
    )


def approach_curvature(contacts: tuple[OneArcContact, ...]) -> tuple[float, float]:
    """``delta(2 P) - 2 delta(P)`` in mm, and Hertz's."""
    first, last = contacts
    exact = -2.0 * math.log(2.0) * first.load_N / THICKNESS_MM / (math.pi * first.theory.modulus)
    return last.approach_mm - 2.0 * first.approach_mm, exact


def _ellipse(patch: PressurePatch) -> tuple[float, float]:
    """Height and half width of ``p^2 = p0^2 (1 - x^2 / a^2)`` by least squares; nodes jump by elements."""
    bent, slope, level = np.polyfit(patch.along, patch.pressures**2, 2)
    top = level - slope**2 / (4.0 * bent)
    return math.sqrt(top), math.sqrt(-top / bent)


def _sagitta(radius: float, half: float) -> float:
    return radius - float(np.sqrt(radius**2 - half**2))
