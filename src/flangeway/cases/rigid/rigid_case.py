"""Inputs of ``flangeway geometry``: a rigid wheelset on two rigid rails, its profiles, measures and load."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from flangeway.cases.case import closest, merged
from flangeway.cases.case_file import CaseText, resolved
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.cases.wheelset.wheelset_case import WheelsetCase
from flangeway.cases.wheelset.wheelset_inputs import WheelsetInputs
from flangeway.errors import InputError, short
from flangeway.railway.profiles.measures import GAUGE_DEPTH_MM
from flangeway.railway.rigid.rigid_curve import MAX_YAW_RAD
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.railway.track.placements import RUNNING_CIRCLES_MM
from flangeway.units import sentence


class GeometryCase(WheelsetInputs):
    """A rigid wheelset on two rigid rails; thickness and material are for Hertz's estimate."""

    name = "geometry"
    title = "Contact geometry of a rigid wheelset on rigid rails"

    maximum_lateral_mm: float = Field(8.0, gt=0.0, le=60.0)
    """maximum lateral displacement that is shown; less where a flange climbs before"""
    step_mm: float = Field(0.02, ge=1e-3, le=1.0)
    """distance of the positions"""
    maximum_amplitude_mm: float = Field(6.0, gt=0.0, le=30.0)
    """maximum amplitude of the conicity"""
    roll: Literal["free", "none"] = "free"
    """free: both wheels touch; none: no roll, as in the reference results of EN 15302"""

    yaw_mrad: float = Field(0.0, ge=-1e3 * MAX_YAW_RAD, le=1e3 * MAX_YAW_RAD)
    """yaw of the axle, counter-clockwise seen from above: the right wheel is ahead"""

    @property
    def yaw_rad(self) -> float:
        """Yaw of the axle in radians."""
        return 1e-3 * self.yaw_mrad

    def geometry(self) -> RigidGeometry:
        """Return the rigid geometry; an `InputError` if a profile is unknown or a length is not allowed."""
        return RigidGeometry.of(self.track(), self.wheelset(), self.yaw_rad)


def _main_inputs() -> dict[str, Any]:
    """Inputs of the wheelset in three dimensions where they are not the defaults here."""
    own, main = GeometryCase.model_fields, SpatialWheelsetCase.model_fields
    shared = [key for key in WheelsetInputs.model_fields if main[key].default != own[key].default]
    return {key: main[key].default for key in shared}


_STANDARD = {
    "gauge_depth_mm": GAUGE_DEPTH_MM,
    "back_to_back_mm": 1360.0,
    "wheel_radius_mm": 460.0,
    "wheel_radius_at": "tape-line",
    "centre_of_gravity_height_mm": 1000.0,
    "axle_load_kN": 200.0,
    "maximum_lateral_mm": 7.0,
}
"""A vehicle on standard gauge, which is measured 14 mm below the top of the rails."""
GEOMETRY_CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "wheelset": ("S1002 on 60E1 at 1:40, standard gauge, as `flangeway run wheelset`", _main_inputs()),
    "wheelset-tangent": ("136RE and AAR-1B on straight, level track", {}),
    "wheelset-curve": (
        sentence("136RE and AAR-1B in a curve of {400 m} at {70 km/h}, superelevation {3 cm}"),
        {"lateral_force_kN": 28.4, "superelevation_mm": 30.0, "maximum_lateral_mm": 9.9},
    ),
    "s1002-60e1": (
        sentence("S1002 on 60E1 at 1:40, gauge {1435 mm}, back-to-back {1360 mm}, rolling radius {460 mm}"),
        _STANDARD | {"rail": "60E1", "wheel": "S1002", "gauge_mm": 1435.0},
    ),
    "en15302": (
        sentence("benchmark of EN 15302: R-519-A on S-519-A at 1:20, gauge {1435.16 mm}, diameter {920 mm}"),
        _STANDARD
        | {
            "rail": "S-519-A",
            "wheel": "R-519-A",
            "gauge_mm": 1435.1654,  # tape lines and the origins of the rails' formulas are then at the same positions
            "rail_inclination": 0.05,
            "roll": "none",
            "maximum_amplitude_mm": 7.4,
        },
    ),
}
"""Title and inputs that differ from the defaults, by name."""


OWN_NAME = "geometry"  # name in a case file of nothing but the geometry


def find_geometry_case(name: str, values: Mapping[str, Any]) -> GeometryCase:
    """Return a case by its name with some inputs changed.

    It is an `InputError` if there is none of that name, or an input is wrong.
    """
    if name not in GEOMETRY_CASES:
        raise InputError(
            f"a geometry case called {name!r}",
            f"one of: {', '.join(GEOMETRY_CASES)}; a case file; or a file of a rolling radius difference",
            closest(name, list(GEOMETRY_CASES)),
        )
    return _on_its_base(name, GeometryCase.from_values(merged(GEOMETRY_CASES[name][1], values)))


def _on_its_base(name: str, case: GeometryCase) -> GeometryCase:
    """Return a case whose superelevation is measured over the same base as by the case of that name."""
    if name != SpatialWheelsetCase.name or not case.superelevation_mm or case.superelevation_base_mm is not None:
        return case
    return case.model_copy(update={"superelevation_base_mm": case.gauge_mm + RUNNING_CIRCLES_MM})


def read_geometry_case(file: Path, values: Mapping[str, Any]) -> tuple[GeometryCase, tuple[str, ...]]:
    """Return the geometry case of a case file, and a sentence on the keys that it does not use.

    It is an `InputError` if the file is of another case, or an input is wrong; the message names file, line and key.
    - `file`: a case file of a wheelset, as `flangeway.cases.case_file.read_case` reads it, or with ``case =
      "geometry"``.
    - `values`: inputs that replace those of the file.
    """
    text = CaseText.read(file)
    name, given = text.name_and_values()
    if name != OWN_NAME and name not in GEOMETRY_CASES:
        raise InputError(
            f"{text.place(('case',))}case = {short(name)}",
            f"a wheelset: {', '.join((OWN_NAME, *GEOMETRY_CASES))}",
            "`flangeway run` computes the other cases",
        )
    kind = SpatialWheelsetCase if name == SpatialWheelsetCase.name else WheelsetCase
    own, known = GeometryCase.model_fields, kind.model_fields
    unused = [key for key in given if (name_of := kind.input_named(key)[0]) in known and name_of not in own]
    used = {key: value for key, value in given.items() if key not in unused}
    base = GEOMETRY_CASES["s1002-60e1" if name == OWN_NAME else name][1]
    case = GeometryCase.from_values(
        merged(merged(base, resolved(text, used, file.parent)), values),
        lambda key: "" if key and key[0] in values else text.place(key),
    )
    notice = f"not used by the geometry: {', '.join(unused)}"
    return _on_its_base(name, case), (notice,) if unused else ()
