"""A coarse wheelset in three dimensions, whose running surfaces several files of tests share."""

import pytest

from flangeway.cases.case_file import load_case
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset

COARSE = {"size_scale": 6.0, "order": 1, "support": "continuous", "gauge_at": "narrowest"}
"""Meshes for quick tests; reference positions of the tests were found at the narrowest place of the heads."""


def coarse_case(**inputs):
    """The case on coarse meshes."""
    return load_case("wheelset", **COARSE | inputs)


@pytest.fixture(scope="session")
def wheelset():
    """Running surfaces on a continuous foundation, with an elastic axle."""
    return SpatialWheelset(coarse_case(), running_surfaces(coarse_case()))
