"""Numbers and quantities with units: what Python gives is taken, and what is out of range says why."""

import json
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from flangeway.contact import NodeToSegment, Penalty
from flangeway.elements import TraceStabilisation, Virtual
from flangeway.errors import InputError
from flangeway.exact import LineContact, ThickCylinder
from flangeway.geometry import Placement, circle, rectangle
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import (
    doerfler_marking,
    rectangle_grid,
    refined,
    triangulate,
)
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure, Spring, Traction
from flangeway.quantities import Quantity, columns, key_unit, reference, values
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.rigid.conicity import RollingRadiusDifference
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed
from flangeway.report.damage.damage_record import row_quantities
from flangeway.report.page.tables import About, table_across, table_of
from flangeway.solve import NewtonSettings, solve_elasticity
from flangeway.space import Space

GRID = rectangle_grid(1.0, 1.0, 2, 2, cells="quadrilaterals")
STEEL = Elastic(210e3, 0.3)
ORTHOTROPIC = {"young": (12.0, 0.8, 0.5), "poisson": (0.4, 0.35, 0.45), "shear": 0.7}
NO_NUMBERS = ["2", True, 2j, [2], 10**400, np.array([2.0])]


def space() -> Space:
    return Space(GRID, Virtual(2))


PLACES = {
    "order": Virtual,
    "factor": TraceStabilisation,
    "young": lambda value: Elastic(value, 0.3),
    "poisson": lambda value: Elastic(1.0, value),
    "expansion": lambda value: Elastic(1.0, 0.3, expansion=value),
    "orthotropic expansion": lambda value: Orthotropic(**ORTHOTROPIC, expansion=(0.0, 0.0, value)),
    "thickness": lambda value: Elasticity(space(), STEEL, thickness=value),
    "pressure": lambda value: Pressure("top", value),
    "prescribed": lambda value: PrescribedDisplacement("top", x=value),
    "spring": lambda value: Spring("top", x=value),
    "circle": circle,
    "rotation": Placement,
    "spacing": lambda value: rectangle(1.0, 1.0).sampled(spacing=value, max_deviation=1.0),
    "squares of a grid": lambda value: rectangle_grid(1.0, 1.0, 1, value),
    "size of triangles": lambda value: triangulate(rectangle(9.0, 9.0), size=value),
    "hanging points": lambda value: refined(GRID, most_hanging=value),
    "iterations": lambda value: NewtonSettings(max_iterations=value),
    "penalty": lambda value: Penalty(value, per="length"),
    "reach of nodes": NodeToSegment,
    "gauge": lambda value: Track(rail(), value),
    "back to back": lambda value: Wheelset(wheel(), value),
    "height of the load": lambda value: Wheelset(wheel(), centre_of_gravity_height_mm=value),
    "weight": WheelsetLoad,
    "size in contact": lambda value: Discretisation(contact_size_mm=value),
    "order of wheelsets": lambda value: Discretisation(order=value),
    "prescribed motion": lambda value: Prescribed(lateral_mm=value),
    "force of a line contact": lambda value: LineContact(value, 1.0, 1.0),
    "pressure in a cylinder": lambda value: ThickCylinder(1.0, 3.0, value),
}
MAY_BE_MISSING = {
    "expansion",
    "prescribed",
    "spacing",
    "hanging points",
    "penalty",
    "reach of nodes",
    "prescribed motion",
}


@pytest.mark.parametrize("place", PLACES)
def test_a_number_is_a_number(place: str) -> None:
    """No text, truth value, missing value, complex number or list is taken for a number; each is an InputError."""
    for value in NO_NUMBERS if place in MAY_BE_MISSING else [*NO_NUMBERS, None]:
        with pytest.raises(InputError) as error:
            PLACES[place](value)
        assert error.value.allowed
        assert error.value.advice


@pytest.mark.parametrize("values", [["1", "2"], [True, 1.0], [[1.0], [1.0, 2.0]]])
def test_arrays_hold_numbers(values) -> None:
    """Texts, truth values and rows of unlike length are refused where arrays of numbers are given."""
    for make in (
        doerfler_marking,
        lambda given: RollingRadiusDifference([1.0, 2.0], given),
    ):
        with pytest.raises(InputError):
            make(values)


def test_numbers_of_all_kinds_are_taken() -> None:
    """Whole numbers, fractions and NumPy's scalars are numbers."""
    for young in (210000, np.float32(210000), np.int32(210000), Fraction(210000), np.array(210000.0)):
        assert Elastic(young, 0).matrix == pytest.approx(Elastic(210e3, 0.0).matrix)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Elastic(1e-308, 0.3),
        lambda: Elastic(1e300, 0.3),
        lambda: Elasticity(space(), STEEL, thickness=1e-320),
        lambda: Orthotropic((1e-308, 1.0, 1.0), (0.0, 0.0, 0.0), 1.0),
        lambda: TraceStabilisation(1e-320),
    ],
)
def test_vanishing_numbers_say_the_range(make) -> None:
    """Positive numbers whose products vanish or overflow are refused with the range that is allowed."""
    with pytest.raises(InputError) as error:
        make()
    assert "1e-100 to 1e+100" in error.value.allowed


def test_poisson_near_a_half() -> None:
    """What is nearer to 1/2 than round-off allows is refused with the word 0.4999, other numbers without it."""
    for poisson in (0.4999999999999999, 0.4999999999999, np.nextafter(0.5, 0.0), 0.5, -1.5, -1.0, 0.7, 30.0):
        with pytest.raises(InputError, match="poisson") as error:
            Elastic(1.0, poisson)
        assert ("0.4999" in error.value.advice) == (0.4 < poisson <= 0.5)
    for hypothesis in ("plane_strain", "axisymmetric"):
        assert np.isfinite(Elastic(1.0, 0.499999999, hypothesis).matrix).all()


@pytest.mark.parametrize(
    ("make"),
    [
        lambda: Elastic(200.0, 0.5, "plane_stress"),
        lambda: Orthotropic((200.0,) * 3, (0.5,) * 3, 200.0 / 3.0, 0.3, "plane_stress"),
    ],
    ids=["isotropic", "orthotropic"],
)
def test_an_incompressible_sheet_is_well_posed(make) -> None:
    """In plane stress nu = 1/2 has a solution: a pulled sheet becomes narrower by half of its strain."""
    loads = [Traction("top", (0.0, 2.0))]
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("left", x=0.0)]
    found = solve_elasticity(Elasticity(space(), make(), loads=loads, supports=supports))
    assert found.displacement_at_node((1.0, 1.0)) == pytest.approx([-0.005, 0.01])
    assert np.linalg.eigvalsh(make().matrix[:3, :3]).min() > 0.0


@dataclass
class Patch:
    force_N: float  # noqa: N815 (the unit)
    centre: tuple[float, float] | None
    state: str = "elastic"


FORCE = Quantity[Patch](
    "force", "force", "force_N", "kN", ".2f", factor=1e-3, remark=lambda p: "coarse" if p.centre is None else None
)
CENTRE = Quantity[Patch]("centre", "centre of pressure", "centre", "mm", "z.2f", ("x", "z"), meaning="in track axes")
STATE = Quantity[Patch]("state", "  shakedown state", "state")
ALL = (FORCE, CENTRE, STATE)
PATCHES = [Patch(100e3, (25.4, -0.0)), Patch(4448.2216152605, None)]


@pytest.mark.parametrize(
    ("unit", "key"), [("MPa", "MPa"), ("mm²", "mm2"), ("kN/mm", "kN_per_mm"), ("1/m", "per_m"), ("rad/s", "rad_per_s")]
)
def test_keys_have_units_as_inputs_have_them(unit, key):
    """A unit at the end of a key is the one that inputs and US keys are read with."""
    assert key_unit(unit) == key


def test_summary_values_are_metric_and_have_units_in_their_names():
    """``summary.json`` has the number in the unit of its key, lists for points and None for what does not exist."""
    assert values(ALL, PATCHES[0]) == {"force_kN": 100.0, "centre_mm": [25.4, -0.0], "state": "elastic"}
    assert values(ALL, PATCHES[1])["centre_mm"] is None


def test_columns_in_us_units_are_the_metric_ones_by_exact_factors():
    """25.4 mm are 1 in, and 4448.22 N are 1 kip (0.45359237 kg times standard gravity times 1000)."""
    table = columns(ALL, PATCHES, "us").columns
    assert list(table) == ["force_kip", "centre_x_in", "centre_z_in", "state"]
    assert table["centre_x_in"] == [pytest.approx(1.0, rel=1e-15), None]
    assert table["force_kip"][1] == pytest.approx(1.0, rel=1e-13)


def test_tables_for_people_keep_the_precision_of_the_metric_number():
    """100.00 kN are 22.48 kip, at least three digits are shown, what is missing is a dash, and remarks mark a value."""
    metric, us = (table_across("Patches", "ab", PATCHES, ALL, units=units) for units in ("metric", "us"))
    assert metric.rows[0] == ("force, kN", "100.00", "4.45")
    assert us.rows[0] == ("force, kip", "22.481", "1.000")
    assert us.rows[1:3] == (("centre of pressure, x, in", "1.000", "–"), ("centre of pressure, z, in", "0.000", "–"))
    assert isinstance(us.rows[0][2], About)
    assert table_of("Patches", PATCHES, ALL, units="us").header[0] == "force, kip"
    assert FORCE.fact(PATCHES[0], "us") == ("22.481 kip", "force")


def test_the_reference_explains_every_key():
    """The page of keys is made from the same list."""
    assert reference(ALL)[1] == ("centre_mm", "mm", "centre of pressure: in track axes")


def test_a_conicity_that_does_not_exist_is_no_number() -> None:
    """A worn wheel may touch at places from which no conicity follows: the summary has null, and is written."""
    row = {"position": 17000.0, "conicity": float("nan")}
    values = {each.key: each.value(row) for each in row_quantities(["position", "conicity", "t_gamma_N"], "km")}
    assert json.loads(json.dumps(values, allow_nan=False)) == {"position": 17000.0, "conicity": None, "t_gamma_N": None}
