"""Adaptive refinement of polygons around a singularity: the orders of convergence that triangles have."""

import numpy as np
import pytest

from studies.forms import LAST, OPTIMAL, corner_errors


@pytest.mark.parametrize(
    ("domain", "order"),
    [
        ("L-shape, not convex", 1),
        *(pytest.param(*case, marks=pytest.mark.ci) for case in (("L-shape, duals", 4), ("slit, not convex", 3))),
    ],
)
def test_errors_fall_with_the_unknowns_to_minus_half_the_order(domain, order):
    """``r^a sin(a phi)``: the error of the gradient falls like ``n^(-k / 2)`` (order 2: `reproduce forms`)."""
    sizes, errors = corner_errors(domain, order)
    rate = np.polyfit(np.log(sizes[-LAST:]), np.log(errors[-LAST:]), 1)[0]
    assert rate < -OPTIMAL * order / 2.0
