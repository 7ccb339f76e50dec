"""The wheelset varied: stiffer material beside the rigid one, finer meshes in contact, one arc on one arc."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.geometry import Arc, Line, Outline
from flangeway.materials import Elastic
from flangeway.post import PressurePatch
from flangeway.railway.profiles.bundled import RailProfile, WheelProfile
from flangeway.railway.rigid.rigid_equilibrium import RigidPosition
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.subsurface import maximum_shear
from flangeway.railway.wheelset.wheelset_model import WheelRailPatch
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset
from flangeway.types import Floats

FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # factors on Young's modulus
DIVISORS = (1, 2, 4)  # divisors of the element size in contact
ROLL_ARM_MM = 750.0  # half the distance of the contacts: turns a roll into a length


@dataclass(frozen=True, eq=False)
class StiffenedWheelset:
    """A wheelset of raised Young's modulus, and its distance from the rigid one."""

    factor: float  # factor on Young's modulus
    result: WheelsetResult  # elastic solution

    @cached_property
    def rigid(self) -> RigidPosition:
        """Rigid equilibrium of the same inputs, from which the elastic search started."""
        equilibrium = self.result.model.rigid_start.equilibrium
        if equilibrium is None:
            raise InputError("a prescribed lateral displacement", "a wheelset in equilibrium", "leave lateral_mm out")
        return equilibrium.reached()

    @cached_property
    def position_differences_mm(self) -> Floats:
        """Lateral and vertical displacement in the track's axes, and roll times `ROLL_ARM_MM`, elastic less rigid."""
        one, other = self.result.equilibrium.position, self.rigid.motion
        return np.array(
            (
                one.lateral_mm - other.lateral_mm,
                one.vertical_mm - other.vertical_mm,
                ROLL_ARM_MM * (one.roll_rad - other.roll_rad),
            )
        )

    @cached_property
    def point_distances_mm(self) -> Floats:
        """Distance on the rail of each rigid contact point from the nearest elastic centre of pressure of its side."""
        distances = []
        for contact in self.rigid.contacts:
            mine = [patch.rail_point_mm for patch in self.result.patches if patch.side == contact.side]
            apart = [float(np.hypot(*(point - np.array(contact.rail_point_mm)))) for point in mine]
            distances.append(min(apart, default=np.inf))
        return np.array(distances)


def extrapolated_differences_mm(stiffened: Sequence[StiffenedWheelset]) -> Floats:
    """Position differences extrapolated as 1/E to an infinite Young's modulus E, from the last two."""
    one, other = stiffened[-2:]
    share = other.factor / (other.factor - one.factor)
    return share * other.position_differences_mm + (1.0 - share) * one.position_differences_mm


def rigid_limit(
    case: WheelsetCase, factors: Sequence[float] = FACTORS, progress: Callable[[str], None] = lambda _: None
) -> Iterator[StiffenedWheelset]:
    """Solve a case with the Young's modulus of all bodies multiplied by factors."""
    values = case.model_dump(exclude_unset=True)
    for factor in factors:
        progress(f"Young's modulus times {factor:g}")
        raised = type(case).from_values({**values, "young_MPa": factor * case.young_MPa})
        yield StiffenedWheelset(factor, raised.run(cold=True).plane)


def contact_name(result: WheelsetResult, patch: WheelRailPatch) -> str:
    """Side of a contact and the part of the wheel that touches: ``tread`` or ``flange root``.

    The wheel is one whose tread is a segment of that name.
    """
    wheel = result.model.problem.wheelset.wheel_of(patch.side)
    tread = [name for name in wheel.running_names if name.startswith("tread")]
    in_root = float(patch.wheel_point_mm[0]) < float(wheel.outline.bounds(tread)[0, 0])
    return f"{patch.side} {'flange root' if in_root else 'tread'}"


@dataclass(frozen=True, eq=False)
class RefinedContact:
    """A wheelset with a finer mesh in contact."""

    divisor: int  # divisor of the element size in contact
    result: WheelsetResult  # the solution

    @property
    def quantities(self) -> dict[tuple[str, str], float]:
        """Force in N, maximum pressure and maximum shear stresses below in MPa, by patch and quantity."""
        found = {}
        for patch in self.result.patches:
            name = contact_name(self.result, patch)
            found[name, "force"] = float(np.hypot(*patch.force_on_wheel_N))
            found[name, "maximum pressure"] = float(patch.pressure.pressures.max())
            found[name, "maximum shear in the rail"] = maximum_shear(self.result, patch, "rail").value_MPa
            found[name, "maximum shear in the wheel"] = maximum_shear(self.result, patch, "wheel").value_MPa
        return found


def refine_contact(
    case: WheelsetCase, divisors: Sequence[int] = DIVISORS, progress: Callable[[str], None] = lambda _: None
) -> Iterator[RefinedContact]:
    """Solve a case with `contact_size_mm` divided by divisors; the size elsewhere is unchanged."""
    values = case.model_dump(exclude_unset=True)
    for divisor in divisors:
        progress(f"element size in contact over {divisor}")
        finer = type(case).from_values({**values, "contact_size_mm": case.contact_size_mm / divisor})
        yield RefinedContact(divisor, finer.run(cold=True).plane)


WHEEL_RADIUS_MM, RAIL_RADIUS_MM = 330.0, 254.0
WIDTH_MM, HEIGHT_MM = 140.0, 120.0
LOADS_N = (60e3, 120e3)  # loads of the wheelset, half of them on each side; the second twice the first

THICKNESS_MM = 10.0
SOURCE = "one arc between straight lines, to compare with Hertz's theory"


@dataclass(frozen=True, eq=False)
class OneArcContact:
    """One side of the wheelset under a load."""

    load_N: float  # noqa: N815 (the unit newton)
    """Force on the side."""
    result: WheelsetResult  # solution of the wheelset
    pressure_MPa: float  # noqa: N815
    half_width_mm: float
    """pressure_MPa, half_width_mm: maximum pressure and half width of the ellipse that fits the pressures of the nodes
    best."""
    approach_mm: float  # how far the wheelset sinks
    theory: LineContact  # Hertz's contact of the two arcs under that force


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
    return OneArcContact(0.5 * load, result, *_ellipse(patch.pressure), result.approach_mm, theory)


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
