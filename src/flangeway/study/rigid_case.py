"""Inputs of ``flangeway geometry``: a rigid wheelset on two rigid rails, its profiles, measures and load."""

from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from flangeway.errors import InputError
from flangeway.geometry.file_content import is_file
from flangeway.railway.rigid_contact import RigidWheelset
from flangeway.study.case import closest
from flangeway.study.wheelset_inputs import WheelsetInputs


class GeometryCase(WheelsetInputs):
    """A rigid wheelset on two rigid rails; thickness and material are for Hertz's estimate."""

    name: ClassVar[str] = "geometry"
    title: ClassVar[str] = "Contact geometry of a rigid wheelset on rigid rails"

    largest_lateral_mm: float = Field(8.0, gt=0.0, le=60.0, description="largest lateral motion that is shown")
    step_mm: float = Field(0.02, ge=1e-3, le=1.0, description="distance of the positions")
    largest_amplitude_mm: float = Field(6.0, gt=0.0, le=30.0, description="largest amplitude of the conicity")
    roll: Literal["free", "none"] = Field(
        "free", description="free: both wheels touch; none: no roll, as in the reference results of EN 15302"
    )

    def curves(self) -> RigidWheelset:
        """Return the rigid curves.

        Raises
        ------
        InputError
            If a profile is unknown or a length is not allowed.

        """
        return RigidWheelset.of(self.track(), self.wheelset())


GEOMETRY_CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "wheelset-tangent": ("136RE and AAR-1B on straight, level track", {}),
    "wheelset-curve": (
        "136RE and AAR-1B in a curve of 400 m at 70 km/h, superelevation 3 cm",
        {"lateral_force_kN": 28.4, "superelevation_mm": 30.0, "largest_lateral_mm": 9.9},
    ),
    "s1002-60e1": (
        "S1002 on 60E1 at 1:40, gauge 1435 mm, back-to-back 1360 mm, rolling radius 460 mm",
        {
            "rail": "60E1",
            "wheel": "S1002",
            "gauge_mm": 1435.0,
            "gauge_depth_mm": 14.0,
            "back_to_back_mm": 1360.0,
            "wheel_radius_mm": 460.0,
            "wheel_radius_at": "tape-line",
            "barycentre_height_mm": 1000.0,
            "axle_load_kN": 225.0,
            "largest_lateral_mm": 7.0,
        },
    ),
}
"""Title and what differs from the defaults, by name."""


def find_geometry_case(name: str, values: dict[str, Any]) -> GeometryCase:
    """Return a case by its name with some inputs changed.

    Raises
    ------
    InputError
        If there is none of that name, or an input is wrong.

    """
    if name not in GEOMETRY_CASES:
        advice = closest(name, list(GEOMETRY_CASES))
        if is_file(Path(name)):
            advice = "choose one of these, and give the file's rail, wheel, gauge_mm, ... by --set"
        raise InputError(f"a geometry case called {name!r}", f"one of: {', '.join(GEOMETRY_CASES)}", advice)
    return GeometryCase.from_values({**GEOMETRY_CASES[name][1], **values})
