"""One coarse run of the main case by each method, shared by the tests of this folder."""

import pytest

from flangeway.cases import WheelsetTangentCase


@pytest.fixture(scope="session")
def runs():
    """Solved cases by method."""
    return {
        method: WheelsetTangentCase.from_values({"method": method, "size_scale": 3.0}).run()
        for method in ("fem", "vem")
    }
