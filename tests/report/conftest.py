"""One coarse run of the main case by each method, shared by the tests of this folder."""

import pytest

from flangeway.cases import WheelsetTangentCase, run_case


@pytest.fixture(scope="session")
def runs():
    """Solved cases by method."""
    return {
        method: run_case(WheelsetTangentCase.from_values({"method": method, "size_scale": 3.0}))
        for method in ("fem", "vem")
    }
