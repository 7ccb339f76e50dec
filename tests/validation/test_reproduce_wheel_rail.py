"""The published wheelset on its rails computed again, as `flangeway reproduce wheel-rail --quick` does."""

import itertools

import numpy as np
import pytest

from studies.wheel_rail.variations import contact_name, extrapolated_differences_mm
from studies.wheel_rail.wheel_rail_reproduced import WheelRailReproduction, reproduce_wheel_rail
from studies.wheel_rail.wheel_rail_tables import CASES, CODES

pytestmark = pytest.mark.ci


@pytest.fixture(scope="module")
def found() -> WheelRailReproduction:
    """Eight rows, flange roots of two families, two values of Young's modulus, one refinement."""
    return reproduce_wheel_rail(quick=True)


def test_rows_are_in_equilibrium_from_a_cold_start(found: WheelRailReproduction) -> None:
    """The equilibrium residual of every row is below 1e-9; the curve has contact on tread and flange root outside."""
    assert [(row.situation, row.code) for row in found.rows] == list(itertools.product(CASES, CODES))
    for row in found.rows:
        assert row.result.equilibrium.residuals.equilibrium_residual < 1e-9
        contacts = sorted(contact_name(row.result, patch) for patch in row.result.patches)
        outer = ["right flange root"] if row.situation == "curve" else []
        assert contacts == sorted(["left tread", "right tread", *outer])


def test_what_has_a_limit_is_within(found: WheelRailReproduction) -> None:
    """Positions, agreement of orders, regions, rigid limit, refinement in contact and Hertz are within."""
    assert found.passed
    required = [number for number in found.numbers if number.required]
    assert {number.table for number in required} == {
        15,
        16,
        "agreement",
        "regions",
        "rigid limit",
        "refinement",
        "Hertz",
    }


def test_one_number_is_fitted_and_the_others_are_predicted(found: WheelRailReproduction) -> None:
    """One fitted number; 11 rows of the curve within 5 % of the published; the reference height is one constant."""
    fitted = [number for number in found.numbers if number.note.startswith("fitted")]
    assert [(number.code, number.quantity) for number in fitted] == [("curve VO2", "horizontal translation")]
    assert abs(fitted[0].relative_difference) < 1e-3
    names = ("horizontal translation", "rotation", "vertical translation, curve less tangent")
    curve = [n for n in found.numbers if n.table == 16 and n.quantity in names and n.note == "predicted"]
    assert len(curve) == 11
    assert max(abs(number.relative_difference) for number in curve) < 0.05
    heights = [n.computed - n.published for n in found.numbers if n.quantity == "vertical translation"]
    assert len(heights) == 8
    assert max(heights) - min(heights) < 1e-3  # cm


def test_only_one_family_of_roots_meets_all_together(found: WheelRailReproduction) -> None:
    """At the published lateral translation one family is within 1 % of rotation and height, the other 4 % off."""
    apart: dict[str, list[float]] = {}
    for number in found.numbers:
        if number.table == "flange root":
            apart.setdefault(number.code.partition(", ")[2], []).append(abs(number.relative_difference))
    assert max(apart["arcs moved"]) < 0.01
    assert max(apart["narrow arc in place"]) > 0.04


def test_stiff_wheelsets_tend_to_the_rigid_one(found: WheelRailReproduction) -> None:
    """From E x 10 to E x 100 the distance from the rigid position falls by 8 to 12 times; the rest is below 10 um."""
    soft, stiff = (np.linalg.norm(each.position_differences_mm) for each in found.limit)
    assert 8.0 < soft / stiff < 12.0
    assert np.abs(extrapolated_differences_mm(found.limit)).max() < 0.01
    assert found.limit[-1].point_distances_mm.max() < 0.5


def test_a_finer_contact_changes_little(found: WheelRailReproduction) -> None:
    """With half the element size forces change by less than 0.5 %, pressures and shear stresses by less than 3 %."""
    for coarse, fine in itertools.pairwise(found.refined):
        assert coarse.quantities.keys() == fine.quantities.keys()
        for (name, quantity), value in fine.quantities.items():
            limit = 0.005 if quantity == "force" else 0.03
            assert value == pytest.approx(coarse.quantities[name, quantity], rel=limit), (name, quantity)


def test_one_arc_on_one_arc_is_hertz(found: WheelRailReproduction) -> None:
    """Pressure, half width and the bend of the approach over the load agree with Hertz within 1 %."""
    numbers = {number.quantity: number for number in found.numbers if number.table == "Hertz"}
    assert numbers.keys() == {
        "maximum pressure",
        "half width",
        "approach under twice the load less twice the approach",
    }
    assert all(abs(number.relative_difference) < 0.01 for number in numbers.values())
