"""Quantities: one definition gives key, column, label and text, in metric and in US units."""

import json
from dataclasses import dataclass

import pytest

from flangeway.quantities import Quantity, columns, key_unit, reference, values
from flangeway.report.damage.damage_record import row_quantities
from flangeway.report.page.tables import About, table_across, table_of


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
