"""A coarse wheelset in three dimensions, whose running surfaces several files of tests share."""

import pytest

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset

COARSE = {"size_scale": 6.0, "order": 1, "rail_support": "continuous", "gauge_at": "narrowest"}
"""Meshes for quick tests; reference positions of the tests were found at the narrowest place of the heads."""


def coarse_case(**inputs):
    """The case on coarse meshes."""
    return SpatialWheelsetCase.from_values(COARSE | inputs)


@pytest.fixture(scope="session")
def wheelset():
    """Running surfaces on a continuous foundation, with an elastic axle."""
    problem, model = coarse_case().problem(), coarse_case().spatial_model()
    return SpatialWheelset(problem, running_surfaces(problem, model), model)
