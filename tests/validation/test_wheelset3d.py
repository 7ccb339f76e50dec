"""The wheelset in three dimensions: one position of the Manchester benchmark."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from studies.study import published_rows
from studies.wheelset3d.manchester import CASE, BenchmarkPosition, benchmark_numbers
from studies.wheelset3d.one_wheel import FIXED, PressedWheel, as_half_spaces, pressed_wheel

ROW = 12  # y = 6 mm


@pytest.fixture(scope="module")
def position() -> BenchmarkPosition:
    """A position of the benchmark on a coarse mesh: the half-spaces are not meshed."""
    problem = SpatialWheelsetCase.from_values(CASE | {"order": 1, "size_scale": 6.0}).problem()
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("flangeway.railway.wheelset.running_surfaces.CELL_MM", 6.0)
        real = running_surfaces(problem, FIXED)
    half = {side: as_half_spaces(each) for side, each in real.items()}
    values = {name: float(value) for name, value in published_rows("manchester_a22_left.csv")[ROW].items()}
    model = replace(FIXED, yaw_rad=-values["yaw"])
    found: list[PressedWheel] = [
        pressed_wheel(SpatialWheelset(problem, each, model), "left", 10e3, values["y"], -values["roll"])
        for each in (real, half)
    ]
    return BenchmarkPosition(values, *found)


def test_half_spaces_are_those_of_contact(position) -> None:
    """Pressure to 1 %, contact point to 0.03 mm and height to 0.5 micrometres, with yaw and roll."""
    published, found = position.published, position.half_spaces
    assert found.patches[0].max_pressure == pytest.approx(published["p0"], rel=0.01)
    assert -found.interpenetration_mm == pytest.approx(published["wheel_y"], abs=0.03)
    assert -found.position.vertical_mm == pytest.approx(published["z"], abs=5e-4)
    np.testing.assert_allclose(found.state.resultant[1], 10e3, rtol=1e-7)


def test_all_numbers_with_a_limit_are_within(position) -> None:
    """Also on the meshed bodies, whose rail moves down under the wheel."""
    numbers = list(benchmark_numbers(position))
    assert [number.within for number in numbers] == [True, True, True, True, None]
    assert position.real.position.vertical_mm < position.half_spaces.position.vertical_mm
