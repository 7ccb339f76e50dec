"""Measured profiles of the testbank of CONTACT, in the default case; skipped without the folder that holds them.

``FLANGEWAY_PROFILES`` names the folder ``testbank/profiles`` of github.com/eve70a/CONTACT.
"""

import os
from pathlib import Path

import pytest

from benchmarks.measured_profiles import profile_files, rows_of
from flangeway.cases.profile.profile_run import run_profile
from flangeway.errors import InputError
from flangeway.railway.profiles.profile_file import ReadOptions, read_profile

FOLDER = Path(os.environ.get("FLANGEWAY_PROFILES", "none"))
LEFT = ("avg_HR.BAN", "avg_low2.ban", "rail_left_iter288.ban", "rail_left_iter795.ban")
RIGHT = ("site_b_hr.prr", "left-roller-v1-pre-dry.ban", "MBench_UIC60_v3.prr", "uic60_true.prr")
"""Rails that inputs of CONTACT's testbank mirror (MIRRORY = 1), and those that they do not."""
WHEELS = (
    *("avg_wheel.whl", "whl_left_iter288.whl", "whl_left_iter795.whl", "worn_high_mileage.prw", "Car7216_0001r.whl"),
    *("left-wheel-v1-pre-dry.whl", "right-wheel-v1-pre-dry.whl", "MBench_S1002_v3.prw"),
)

pytestmark = [
    pytest.mark.ci,
    pytest.mark.skipif(not FOLDER.is_dir(), reason="FLANGEWAY_PROFILES does not name a folder"),
]


@pytest.mark.parametrize("name", [*LEFT, *RIGHT])
def test_left_rails_are_those_that_contact_mirrors(name: str) -> None:
    """A head is mirrored by its worn side or its only face where the inputs of CONTACT mirror it, and nowhere else."""
    assert read_profile(FOLDER / name).orientation.mirrored is (name in LEFT)


@pytest.mark.parametrize("name", [*LEFT, *RIGHT, *WHEELS])
def test_measured_profiles_stand_in_the_default_case(name: str) -> None:
    """Each measured rail and wheel converges with a nominal partner at -2, 0 and 2 mm."""
    rows = list(rows_of(FOLDER / name, None, (-2.0, 0.0, 2.0)))
    assert [(row.lateral_mm, row.end) for row in rows] == [(each, "converged") for each in (-2.0, 0.0, 2.0)], rows


def test_what_is_refused_names_its_file() -> None:
    """Each file of the folder, worn or made up, is read, or refused with words that name it, also where a case does."""
    for file, position in profile_files(FOLDER):
        try:
            found = run_profile(str(file), ReadOptions(position=position)).profile.notices
        except InputError as reason:
            found = (str(reason),)
        for notice in found:
            assert file.name in notice or not notice.startswith(("Cases refuse it", str(FOLDER))), notice
