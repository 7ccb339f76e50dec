"""The benchmark of EN 15302: `flangeway reproduce conicity`."""

import numpy as np
import pytest

from studies.en15302.en15302_chapter import CONICITY
from studies.en15302.en15302_reproduced import COMBINATIONS, conicity_table, reproduce_conicity


@pytest.mark.ci
def test_all_conicities_are_within_the_tolerance_of_the_standard(same_as_page) -> None:
    """All combinations, at all amplitudes, as on the page; most agree to a few units of the standard's last digit."""
    found = reproduce_conicity()
    assert all(number.within and number.required for number in found.numbers)
    same_as_page(CONICITY.chapter, found, whole=True)
    rows = conicity_table(found)
    assert len(rows) == 33 * len(COMBINATIONS) - 1
    errors = np.array([abs(float(row["computed"]) - float(row["reference"])) for row in rows])
    assert (errors <= [float(row["tolerance"]) for row in rows]).all()
    assert np.count_nonzero(errors > 0.004) == 5
    assert errors.max() < 0.016
