"""The comparison of a case with the same case on half of its sizes."""

import pytest

from flangeway.cases import find_case, run_halved
from flangeway.errors import InputError


@pytest.mark.parametrize(
    ("name", "given", "halved", "key", "change"),
    [
        ("wheelset-tangent", {"size_scale": 4.0}, {"size_scale": 2.0}, "left_max_pressure_MPa", 0.02),
        pytest.param(
            "wheelset",
            {"size_scale": 6.0, "patch_cells": 12, "order": 1, "rail_support": "fixed"},
            {"size_scale": 3.0, "patch_cells": 24},
            "left_max_pressure_MPa",
            0.02,
            marks=pytest.mark.ci,
        ),
        (
            "rolling-patch",
            {"cells_along": 10, "cells_across": 10},
            {"cells_along": 20, "cells_across": 20},
            "longitudinal_force_kN",
            0.03,
        ),
    ],
)
def test_halving_the_sizes_changes_little(name, given, halved, key, change):
    """Forces, pressures and approaches change by some percent, and the sizes are half of the given ones."""
    convergence = run_halved(find_case(name).from_values(given))
    assert convergence.converged
    assert {name: sizes[1] for name, sizes in convergence.sizes.items()} == halved
    assert {name: sizes[0] for name, sizes in convergence.sizes.items()}.items() <= given.items()
    one, other = (run.summary for run in convergence.runs)
    assert one["case"].items() >= given.items()
    assert other["case"].items() >= halved.items()
    first, second = convergence.numbers[key]
    assert 0.0 < abs(second / first - 1.0) < change


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("wheelset-tangent", {"size_scale": 0.06}, r"size_scale = 0\.03"),
        ("wheelset", {"patch_cells": 40}, "patch_cells = 80"),
        ("cook", {}, "cook"),
    ],
)
def test_sizes_that_cannot_be_halved_are_refused(name, given, message):
    """A size whose half is out of range, or a case without a size, is refused before anything is computed."""
    with pytest.raises(InputError, match=message):
        run_halved(find_case(name).from_values(given))
