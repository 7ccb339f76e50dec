"""One coarse run of the main case by each method, shared by the tests of this folder."""

import pytest

from flangeway.cases import load_case


@pytest.fixture(scope="session")
def runs():
    """Solved cases by method."""
    return {method: load_case("wheelset-tangent", method=method, size_scale=3.0).run() for method in ("fem", "vem")}
