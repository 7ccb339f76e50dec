"""Rolling with friction: cheaper numbers of `flangeway reproduce rolling`."""

from dataclasses import replace

import numpy as np
import pytest

from studies.published_numbers import Reproduced
from studies.rolling.rolling_cases import (
    Energy,
    coefficients,
    contact_numbers,
    extrapolated,
    plane_numbers,
    published,
)
from studies.rolling.rolling_chapter import ROLLING
from studies.rolling.rolling_rollers import falling_numbers, free_numbers


def test_cylinders_materials_and_examples_are_those_of_the_page(same_as_page) -> None:
    """All numbers are within, and as on the page; states converge, and power is that of creepages."""
    energy, rows = Energy(), []
    numbers = (*plane_numbers(energy, rows), *free_numbers(energy), *contact_numbers(energy), *falling_numbers(energy))
    assert all(number.within for number in numbers)
    assert energy.failures == []
    assert energy.number().within
    errors = [abs(row.value - 0.6399949669714529) for row in rows if row.case == "Carter"]
    assert errors == sorted(errors, reverse=True)
    chapter = replace(ROLLING.chapter, tables=lambda _: [])
    same_as_page(chapter, Reproduced(numbers=numbers, seconds=0.0), whole=False)


def test_a_coarse_circle_has_creep_coefficients() -> None:
    """Two coarse grids, extrapolated, are within 3 % of Kalker's table."""
    cells = (12, 20)
    found = extrapolated(cells, np.array([coefficients(1.0, 0.25, n) for n in cells]))
    table = published("coefficients")
    for value, name in zip(found.tolist(), ("c11", "c22", "c23"), strict=False):
        assert value == pytest.approx(table["1", name], rel=0.03)
