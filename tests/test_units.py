"""Numbers, quantities and US units: exact factors, keys of inputs, errors in the units that were written, results."""

import json
import re
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from flangeway.cases import CASES, load_case, schema, write_template
from flangeway.cases.case_file import check_case, read_case, write_case_file
from flangeway.cases.rigid_run import find_geometry_case, read_geometry_case
from flangeway.contact import NodeToSegment, Penalty
from flangeway.elements import TraceStabilisation, Virtual
from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.geometry import Placement, circle, rectangle
from flangeway.materials import Elastic, Orthotropic
from flangeway.mesh import (
    doerfler_marking,
    rectangle_grid,
    refined,
    triangulate,
)
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure, Spring, Traction
from flangeway.quantities import Quantity, columns, key_unit, of_part, plain_text, reference, values
from flangeway.railway.rigid.conicity import RollingRadiusDifference
from flangeway.railway.track.placements import Track, WheelPair
from flangeway.railway.track.wheelset_loads import FromSpeed, Load, Position
from flangeway.railway.track.wheelset_problem import Mesh, Plane
from flangeway.records import GivenText
from flangeway.report.damage_record import row_quantities
from flangeway.report.page.html_page import command_line
from flangeway.report.page.record import About, table_across, table_of
from flangeway.solve import NewtonSettings, solve_elasticity
from flangeway.space import Space
from flangeway.units import us_key, us_unit

FACTORS = [
    ("mm", "in", 25.4),
    ("mm²", "in²", 25.4**2),
    ("mm⁻³", "in⁻³", 25.4**-3),
    ("m", "ft", 0.3048),
    ("kN", "kip", 4.4482216152605),
    ("MPa", "ksi", 4448.2216152605 / 645.16),
    ("km/h", "mph", 1.609344),
    ("kg/m", "lb/yd", 0.45359237 / 0.9144),
    ("kg/m³", "lb/ft³", 0.45359237 / 0.3048**3),
    ("kN m/rad", "kip ft/rad", 4.4482216152605 * 0.3048),
    ("1/m", "1/ft", 1 / 0.3048),
]


@pytest.mark.parametrize(("metric", "name", "factor"), FACTORS)
def test_factors_are_the_exact_definitions(metric, name, factor):
    """A unit and its compounds have the factors of inch, pound and standard gravity."""
    unit = us_unit(metric)
    assert unit.name == name
    assert float(unit.metric) == pytest.approx(factor, rel=1e-15)
    assert unit.to_metric(1.0) == pytest.approx(factor, rel=1e-15)
    assert unit.of(unit.to_metric(3.0)) == pytest.approx(3.0, rel=1e-15)


@pytest.mark.parametrize("key", ["yaw_rate_mrad_per_s", "timings_s", "rotation_deg", "peak_memory_MB", "rail", "order"])
def test_what_is_alike_in_both_systems_stays(key):
    """Angles, times and names have no other key."""
    assert us_key(key) is None


def test_keys_with_us_units_are_inputs():
    """Lengths, forces, speeds, masses and stiffnesses are read exactly, as numbers and as text of the command line."""
    given = {"gauge_in": 56.5, "axle_load_kip": GivenText("71.5"), "load.curve.speed_mph": 40, "radius_ft": 2000.0}
    given |= {"load.curve.superelevation_in": "from-speed", "vertical_kip_per_in": 150.0, "material.young_ksi": 3e4}
    case = load_case("wheelset", **given)
    curve = case.load.curve
    assert (case.track.gauge_mm, curve.speed_km_h, curve.radius_m) == (1435.1, 64.37376, 609.6)
    assert case.load.axle_load_kN == pytest.approx(71.5 * 4.4482216152605, rel=1e-15)
    assert curve.superelevation_mm == FromSpeed()
    assert case.material.young_MPa == pytest.approx(206842.7187950508, rel=1e-14)
    assert case.track.support.vertical_kN_per_mm == pytest.approx(150 * 4.4482216152605 / 25.4, rel=1e-15)
    assert load_case("wheelset", mass_lb=286e3).load.car.mass_t == pytest.approx(129.72741782)


def test_a_setting_replaces_the_quantity_of_the_file_in_any_units(tmp_path):
    """What `--set` gives in one system goes before the file's in the other, inside tables too."""
    file = tmp_path / "case.toml"
    file.write_text(write_template(CASES["two-bodies"]), encoding="utf-8")
    case = read_case(file, {"thickness_in": GivenText("2"), "bodies.1.size_in": GivenText("0.5")})
    assert (case.thickness_mm, case.bodies[0].size_mm) == (50.8, 12.7)
    assert find_geometry_case("s1002-60e1", {"gauge_in": 56.5}).track.gauge_mm == 1435.1
    text = 'case = "geometry"\nunits = "us"\ntrack.gauge_in = 56.5\ncontact.thickness_in = 1.0\n'
    file.write_text(text, encoding="utf-8")
    geometry, notices = read_geometry_case(file, {})
    assert (geometry.track.gauge_mm, geometry.contact.thickness_mm, notices) == (1435.1, 25.4, ())
    assert read_geometry_case(file, {"gauge_mm": 1440.0})[0].track.gauge_mm == 1440.0


@pytest.mark.parametrize("name", CASES)
def test_a_new_file_in_us_units_is_the_case_with_its_defaults(tmp_path, name):
    """What `init --units us` writes has the values of the case, up to round-off, and asks for results in US units."""
    file = tmp_path / "case.toml"
    file.write_text(write_template(CASES[name], "us"), encoding="utf-8")
    found, wanted = (case.model_dump() for case in (load_case(file), CASES[name].from_values(CASES[name].example)))
    assert found.pop("units") == "us"
    wanted.pop("units")
    assert list(_leaves(found)) == pytest.approx(list(_leaves(wanted)), rel=1e-14)
    keys = re.findall(r"^(?:# )?(\w+) =", file.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert not [key for key in keys if us_key(key)]


def _leaves(value):
    """Numbers in tables and lists; the hash of what is none."""
    if isinstance(value, dict):
        value = [*value, *value.values()]
    if isinstance(value, list | tuple):
        for each in value:
            yield from _leaves(each)
    else:
        yield value if isinstance(value, float) else float(hash(value) % 997)


WRONG = [
    (
        {"track": {"gauge_in": 56.5, "gauge_mm": 1435.0}},
        ["track.gauge_in, and the same quantity in another unit", "leave gauge_in"],
    ),
    ({"gauge_in": 56.5, "gauge_mm": 1435.0}, ["gauge_mm and gauge_in for the same input", "leave gauge_mm"]),
    ({"radius_in": 2.0}, ["wheelset.radius_in = 2.0\n", "a number from 5.90551", "default 18.1102"]),
    ({"axle_load_kips": 70}, ["did you mean load.axle_load_kip?"]),
    ({"gauge_in": 30.0}, ["track.gauge_mm = 762 without wheelset.back_to_back_mm"]),
    ({"gauge_mm": 800.0, "units": "us"}, ["track.gauge_mm = 800 without", "known, 1435, 1520, 1600, 1668 mm"]),
    ({"units": "imperial"}, ["units is metric or us"]),
]


@pytest.mark.parametrize(("given", "words"), WRONG)
def test_errors_name_the_key_and_the_unit_that_was_written(given, words):
    """A wrong pair, a number beyond a limit, a misspelt key, and what is wrong beyond single values."""
    with pytest.raises(InputError) as caught:
        check_case(load_case("wheelset", **given))
    for word in words:
        assert word in str(caught.value)


def test_errors_in_tables_name_the_line_of_the_key_with_us_units(tmp_path):
    """A wrong value inside a table has its path, its line and the limit in its unit."""
    text = write_template(CASES["two-bodies"], "us").replace("size_in = 0.19", "size_in = -0.19", 1)
    line = 1 + next(n for n, each in enumerate(text.splitlines()) if each.startswith("size_in = -0.19"))
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=rf"line {line}: bodies\[1\].size_in = -0.19"):
        load_case(tmp_path / "case.toml")


def test_errors_of_a_whole_case_name_the_line_of_the_key_with_us_units(tmp_path):
    """What is wrong beyond single values is reported in metric units, at the line of the input as it was written."""
    file = tmp_path / "case.toml"
    file.write_text('case = "wheelset"\n\ntrack.gauge_in = 30.0\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"line 3: track\.gauge_mm = 762 without"):
        check_case(load_case(file), file)


def test_the_schema_has_the_keys_with_us_units():
    """Editors complete both keys; limits are in their units, and one of both is enough where a quantity is needed."""
    case, described = schema(CASES["wheelset"]), schema(CASES["two-bodies"])
    wheels = case["$defs"]["WheelPair"]["properties"]
    assert wheels["radius_in"]["minimum"] == pytest.approx(150 / 25.4)
    assert wheels["radius_mm"]["minimum"] == 150
    disc = next(each for name, each in described["$defs"].items() if name.startswith("Disc"))
    assert "radius_mm" not in disc["required"]
    assert {"anyOf": [{"required": ["radius_mm"]}, {"required": ["radius_in"]}]} in disc["allOf"]


def test_what_computes_it_again_keeps_units_and_exact_inputs():
    """The command asks for US units; the case file has the inputs in metric units with all digits."""
    case = load_case("roller", crown_radius_in=0.8, units="us")
    assert command_line(case) == "flangeway run roller --units us --set crown_radius_mm=20.32"
    assert 'units = "us"' in write_case_file(case)
    assert "crown_radius_mm = 20.32\n" in write_case_file(case)


def test_the_inputs_in_us_units_are_listed(call):
    """`flangeway cases NAME --units us` has keys, defaults and limits in US units, in their groups."""
    status, out, _ = call("cases", "wheelset", "--units", "us")
    assert status == 0
    assert re.search(r"gauge_in .*\[default: 56.4961\]", out)
    assert re.search(r"^track\.support\.sleepers\b", out, flags=re.MULTILINE)
    assert not re.search(r"^\w+_(mm|kN|MPa|km_h)\b", out, flags=re.MULTILINE)


def test_meanings_of_inputs_are_the_same_in_both_systems():
    """Keys, defaults and limits are converted as numbers; what an input means is metric."""
    metric, us = (
        [row for _, table in CASES["wheelset"].tables_of_inputs(units) for row in table] for units in ("metric", "us")
    )
    assert [row[3] for row in us] == [row[3] for row in metric]
    assert [row[0] for row in us] == [unit.name if (unit := us_key(key)) else key for key, *_ in metric]
    assert "510 MPa" in {key: meaning for key, *_, meaning in us}["yield_ksi"]


@pytest.mark.parametrize("options", [(), ("--units", "us"), ("--set", "gauge_in=56.5")])
def test_errors_of_a_run_are_metric(call, monkeypatch, options):
    """What only the computation detects is reported by one sentence in both systems of units."""

    def fails(*_):
        raise InputError("lateral_mm = 38.1: the axle 12.7 mm higher", "up to 6.35 mm", "give a smaller lateral_mm")

    monkeypatch.setattr(CASES["wheelset"], "run", fails)
    status, _, err = call("run", "wheelset", *options)
    assert status == 2
    assert "lateral_mm = 38.1: the axle 12.7 mm higher\n  allowed: up to 6.35 mm\n  what to do: give a smaller" in err


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
    "gauge": lambda value: Track(gauge_mm=value),
    "back to back": lambda value: WheelPair(back_to_back_mm=value),
    "height of the load": lambda value: Load(centre_of_gravity_height_mm=value),
    "weight": lambda value: Load(axle_load_kN=value),
    "size in contact": lambda value: Plane(contact_size_mm=value),
    "order of wheelsets": lambda value: Mesh(order=value),
    "prescribed motion": lambda value: Position(lateral_mm=value),
    "force of a line contact": lambda value: LineContact(value, 1.0, 1.0),
}
MAY_BE_MISSING = {
    "expansion",
    "prescribed",
    "spacing",
    "hanging points",
    "penalty",
    "reach of nodes",
    "back to back",
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
    "force",
    "force",
    lambda p: p.force_N,
    "kN",
    ".2f",
    factor=1e-3,
    remark=lambda p: "coarse" if p.centre is None else None,
)
CENTRE = Quantity[Patch](
    "centre", "centre of pressure", lambda p: p.centre, "mm", "z.2f", ("x", "z"), meaning="in track axes"
)
STATE = Quantity[Patch]("state", "  shakedown state", lambda p: p.state)
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


def test_a_whole_has_the_quantities_of_its_part():
    """A part's numbers and remarks are those of the whole, and None where the whole does not have the part."""
    first = of_part(lambda patches: next(iter(patches), None), FORCE, STATE)
    assert values(first, PATCHES[1:]) == values((FORCE, STATE), PATCHES[1])
    assert [first[0].remark(PATCHES[1:]), first[0].remark([])] == ["coarse", None]
    assert values(first, []) == {"force_kN": None, "state": None}


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


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (3.94073e7, ".6g", "39407300"), (-2.5e10, ".4g", "-25000000000"), (1e-7, ".2g", "1e-07"),
        (3e12, ".3g", "3e+12"), (-1e-4, ".3f", "0.000"), (-0.0, ".4g", "0"), (-2e-6, ".1%", "0.0%"),
        (-0.6, ".0f", "-1"), (17, "d", "17"),
    ],
)  # fmt: skip
def test_plain_texts(value, form, text):
    """Large numbers have their digits in the place of a power of ten, and zero has no sign."""
    assert plain_text(value, form) == text
