"""The Manchester contact benchmark, case A-2.2, left wheel: S1002 on UIC60 in 21 positions, beside CONTACT."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from studies.study import Row, Run, published_rows
from studies.wheelset3d.one_wheel import FIXED, PressedWheel, as_half_spaces, pressed_wheel

FORCE = 10e3
CASE = {
    "rail": "60E1",
    "wheel": "S1002",
    "gauge_mm": 1435.0,
    "gauge_depth_mm": 14.0,
    "back_to_back_mm": 1360.0,
    "wheel_radius_mm": 460.0,
    "axle_load_kN": 2e-3 * FORCE,
    "young_MPa": 2.0 * 82e3 * 1.28,
    "poisson": 0.28,
}
TABLE = "Manchester A-2.2"
PRESSURE_LIMIT, FORCE_LIMIT, POSITION_LIMIT_MM = 0.03, 0.01, 0.3
STEEPEST_RAD = 0.3
"""Contact angle up to which numbers of half-spaces are a measure for real bodies."""
CENTRE = "CONTACT gives the centre of the squared overlap of the undeformed surfaces instead of that of the pressure"
STEEP = "steep or divided contact: half-spaces are no measure for it"


@dataclass(frozen=True, eq=False)
class BenchmarkPosition:
    """One position: as published, on the real bodies, and on half-spaces."""

    published: dict[str, float]
    real: PressedWheel
    half_spaces: PressedWheel

    @property
    def code(self) -> str:
        """Lateral position."""
        return f"y = {self.published['y']:g} mm"

    @property
    def comparable(self) -> bool:
        """Whether the contact is flat and in one piece."""
        return self.published["angle"] < STEEPEST_RAD and len(self.real.patches) == 1


def benchmark_positions(run: Run, *, every: int) -> Iterator[BenchmarkPosition]:
    """Press the left wheel in the positions, or every so many of them."""
    problem = SpatialWheelsetCase.from_values(CASE).problem()
    real = running_surfaces(problem, FIXED, progress=run.progress)
    half = {side: as_half_spaces(each) for side, each in real.items()}
    rows = published_rows("manchester_a22_left.csv")
    for row in rows[::every]:
        values = {name: float(value) for name, value in row.items()}
        run.progress(f"Manchester A-2.2, y = {values['y']:g} mm")
        # CONTACT's axes x ahead and z down: both angles have the opposite sign
        model = replace(FIXED, yaw_rad=-values["yaw"])
        found = [
            pressed_wheel(SpatialWheelset(problem, each, model), "left", FORCE, values["y"], -values["roll"])
            for each in (real, half)
        ]
        yield BenchmarkPosition(values, *found)


def benchmark_numbers(position: BenchmarkPosition) -> Iterator[Row]:
    """Pressure, force, contact point and height of one position."""
    published, real, half = position.published, position.real, position.half_spaces
    limited = position.comparable
    note = "" if limited else STEEP
    p0 = published["p0"]
    for quantity, found in (("maximum pressure", real), ("maximum pressure of half-spaces", half)):
        value = found.patches[0].max_pressure
        yield Row(TABLE, position.code, quantity, "MPa", value, p0, PRESSURE_LIMIT if limited else None, note)
    value, limit = published["normal_force"], FORCE_LIMIT if limited else None
    yield Row(TABLE, position.code, "normal force", "N", real.normal_force, value, limit, note)
    # y to the right is to the gauge side of a left wheel
    for quantity, place in (
        ("contact point on the wheel", real.interpenetration_mm),
        ("centre of pressure on the wheel", real.centre_of_pressure_mm),
    ):
        shown = not limited or quantity.startswith("centre")
        near, why = (None, CENTRE) if shown else (f"{POSITION_LIMIT_MM:g} mm", "")
        yield Row(TABLE, position.code, quantity, "mm", -place, published["wheel_y"], near, why)
