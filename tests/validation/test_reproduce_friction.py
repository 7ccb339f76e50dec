"""Coulomb friction of plane bodies: `flangeway reproduce friction`."""

import pytest

from flangeway.validation.friction.friction_chapter import FRICTION
from flangeway.validation.friction.friction_reproduced import partial_slip_work, reproduce_friction, stick_rows


@pytest.mark.ci
def test_friction_is_that_of_the_exact_solutions(same_as_page) -> None:
    """All numbers are within their limits, as on the page."""
    found = reproduce_friction()
    assert found.passed
    coarse = {number.code for number in found.numbers if not number.required}
    assert coarse == {"8 cells", "16 cells"}
    for quantity in {(each.table, each.quantity) for each in found.numbers if each.code == "8 cells"}:
        errors = {e.code: abs(e.relative_difference) for e in found.numbers if (e.table, e.quantity) == quantity}
        assert errors["32 cells"] < max(errors["8 cells"], 0.0025)
    same_as_page(FRICTION.chapter, found, whole=True)
    assert len(stick_rows(found)) == sum(len(each.x_mm) for each in found.slips)
    assert all((abs(each.tractions) <= 0.3 * each.pressures * (1.0 + 1e-9)).all() for each in found.slips)


def test_the_exact_work_grows_with_the_square_of_the_force() -> None:
    """Partial slip: no work without a push; twice the force and the same part of sliding, four times the work."""
    assert partial_slip_work(100.0, 0.0) == pytest.approx(0.0, abs=1e-15)
    assert partial_slip_work(200.0, 0.5) == pytest.approx(4.0 * partial_slip_work(100.0, 0.5))
    assert partial_slip_work(100.0, 0.6) > partial_slip_work(100.0, 0.5) > 0.0
