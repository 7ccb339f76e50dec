"""Rolling with friction: cheaper numbers of `flangeway reproduce rolling`."""

import numpy as np
import pytest

from studies.rolling.rolling_cases import (
    coefficients,
    extrapolated,
    published,
)


def test_a_coarse_circle_has_creep_coefficients() -> None:
    """Two coarse grids, extrapolated, are within 3 % of Kalker's table."""
    cells = (12, 20)
    found = extrapolated(cells, np.array([coefficients(1.0, 0.25, n) for n in cells]))
    table = published("coefficients")
    for value, name in zip(found.tolist(), ("c11", "c22", "c23"), strict=False):
        assert value == pytest.approx(table["1", name], rel=0.03)
