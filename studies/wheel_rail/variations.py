"""The wheelset varied: stiffer material beside the rigid one, finer meshes in contact, one arc on one arc."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.exact import LineContact
from flangeway.geometry import Arc, Line, Outline
from flangeway.materials import Elastic
from flangeway.post import PressurePatch
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.subsurface import maximum_shear
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset
from flangeway.types import Floats
from studies.study import Published, Row, Run

FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # factors on Young's modulus
DIVISORS = (1, 2, 4)  # divisors of the element size in contact
ONE_ARC = 0.01  # maximum relative difference of one arc on one arc from Hertz's theory
ROLL_ARM_MM = 750.0  # half the distance of the contacts: turns a roll into a length


def rigid_differences_mm(result: WheelsetResult) -> tuple[Floats, float]:
    """Distances of a wheelset from the rigid equilibrium of the same inputs.

    Lateral and vertical displacement in the track's axes, and roll times `ROLL_ARM_MM`, elastic less rigid; and the
    maximum distance on the rail of a rigid contact point from the nearest elastic centre of pressure of its side.
    """
    equilibrium = result.model.rigid_start.equilibrium
    assert equilibrium is not None
    rigid, one = equilibrium.reached(), result.equilibrium.position
    other, points = rigid.motion, []
    for contact in rigid.contacts:
        own = [patch.rail_point_mm for patch in result.patches if patch.side == contact.side]
        points.append(min((float(np.hypot(*(p - np.array(contact.rail_point_mm)))) for p in own), default=np.inf))
    differences = (
        one.lateral_mm - other.lateral_mm,
        one.vertical_mm - other.vertical_mm,
        ROLL_ARM_MM * (one.roll_rad - other.roll_rad),
    )
    return np.array(differences), max(points)


def solve_varied(case: WheelsetCase, values: dict[str, float]) -> WheelsetResult:
    """Solve a case with changed inputs from a cold start."""
    return type(case).from_values({**case.model_dump(exclude_unset=True), **values}).run(cold=True).plane


def contact_name(result: WheelsetResult, patch: WheelRailPatch) -> str:
    """Side of a contact and the part of the wheel that touches: ``tread`` or ``flange root``.

    The wheel is one whose tread is a segment of that name.
    """
    wheel = result.model.problem.wheelset.wheel_of(patch.side)
    tread = [name for name in wheel.running_names if name.startswith("tread")]
    in_root = patch.wheel_point_mm[0] < wheel.outline.bounds(tread)[0, 0]
    return f"{patch.side} {'flange root' if in_root else 'tread'}"


def contact_quantities(result: WheelsetResult) -> Published:
    """Force in N, maximum pressure and maximum shear stresses below in MPa, by patch and quantity."""
    found = {}
    for patch in result.patches:
        name = contact_name(result, patch)
        found[name, "force"] = np.hypot(*patch.force_on_wheel_N)
        found[name, "maximum pressure"] = patch.pressure.pressures.max()
        found[name, "maximum shear in the rail"] = maximum_shear(result, patch, "rail").value_MPa
        found[name, "maximum shear in the wheel"] = maximum_shear(result, patch, "wheel").value_MPa
    return found


WHEEL_RADIUS_MM, RAIL_RADIUS_MM = 330.0, 254.0
WIDTH_MM, HEIGHT_MM = 140.0, 120.0
LOADS_N = (60e3, 120e3)  # loads of the wheelset, half of them on each side; the second twice the first

THICKNESS_MM = 10.0
SOURCE = "one arc between straight lines, to compare with Hertz's theory"


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


def one_arc_rows(run: Run, discretisation: Discretisation, material: Elastic) -> Iterator[Row]:
    """Pressure, half width and approach of two arcs under two loads beside Hertz's."""
    run.progress("one arc on one arc")
    track = Track(one_arc_rail(), gauge_mm=1500.0, rail_inclination=0.0)
    # the wheels stand over the middles of their rails
    wheelset = Wheelset(one_arc_wheel(), back_to_back_mm=1500.0, radius_mm=500.0, centre_of_gravity_height_mm=0.0)
    # round on round a wheelset is not stable sideways
    upright = Prescribed(lateral_mm=0.0, roll_rad=0.0)
    problem = WheelsetProblem(
        track, wheelset, WheelsetLoad(LOADS_N[0]), material, THICKNESS_MM, discretisation, prescribed=upright
    )
    approaches = []
    for load in LOADS_N:
        result = solve_wheelset(replace(problem, load=WheelsetLoad(load)), cold=True)
        run.check(f"one arc on one arc, {0.5 * load:g} N", result.status)
        approaches.append(result.approach_mm)
    patch = next(patch for patch in result.patches if patch.side == "right")
    modulus, curvature = result.model.hertz.modulus, 1.0 / WHEEL_RADIUS_MM + 1.0 / RAIL_RADIUS_MM
    theory, (pressure, half_width) = (
        LineContact(0.5 * load / THICKNESS_MM, curvature, modulus),
        _ellipse(patch.pressure),
    )
    bend = approaches[1] - 2.0 * approaches[0]
    exact = -math.log(2.0) * LOADS_N[0] / THICKNESS_MM / (math.pi * modulus)
    for quantity, unit, value, wanted in (
        ("maximum pressure", "MPa", pressure, theory.max_pressure),
        ("half width", "mm", half_width, theory.half_width),
        ("approach under twice the load less twice the approach", "mm", bend, exact),
    ):
        yield Row(
            "Hertz", "one arc on one arc", quantity, unit, value, wanted, ONE_ARC, "reference: Hertz's line contact"
        )


def _ellipse(patch: PressurePatch) -> tuple[float, float]:
    """Height and half width of ``p^2 = p0^2 (1 - x^2 / a^2)`` by least squares; nodes jump by elements."""
    bent, slope, level = np.polyfit(patch.along, patch.pressures**2, 2)
    top = level - slope**2 / (4.0 * bent)
    return math.sqrt(top), math.sqrt(-top / bent)


def _sagitta(radius: float, half: float) -> float:
    return radius - float(np.sqrt(radius**2 - half**2))
