"""A small table of a wheelset in three dimensions, computed once."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.cases.case_file import load_case
from flangeway.tables import TableRequest, creep_sampling, table_build
from flangeway.tables.table_build import _Build

COARSE = load_case("wheelset", size_scale=8.0, order=1, support="fixed", patch_cells=12)
ANGLES = np.linspace(0.0, np.pi, 5)


@pytest.fixture(scope="session")
def few_points():
    """One slip between sticking and sliding, angles of 45 degrees, two checks a patch."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(creep_sampling, "AXES", (np.array([0.0, 0.5, 1.0]), ANGLES - np.pi / 2, ANGLES))
        patch.setattr(creep_sampling, "DIRECTIONS", (4,))
        patch.setattr(table_build, "N_POINTS", 2)
        patch.setattr(table_build, "MAX_PASSES", 1)
        patch.setattr(table_build, "N_RANDOM", 2)
        patch.setattr(table_build, "N_CREEPAGES", 2)
        yield


@pytest.fixture(scope="session")
def small(few_points):
    """A table of two lateral positions, what was reported, and its positions."""
    sentences = []
    build = _Build(TableRequest(COARSE, [0.0, 0.5], [0.0], [100.0], tolerance=1.0), 1, sentences.append)
    table = build.table()
    return replace(table, metadata={**table.metadata, "seconds": 1.0}), sentences, build.sampled
