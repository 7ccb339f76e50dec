"""Contacts in three dimensions that machines have: a crane wheel on a rail, a roller on a race, crossed cylinders."""

from typing import Any, Literal

from pydantic import Field

from flangeway.cases.case import ElementOrder, PoissonRatio, Positive, PresetCase
from flangeway.cases.spatial.spatial_case import SpatialCase
from flangeway.errors import InputError
from flangeway.units import sentence

# ruff: noqa: N815 (units in names)


class SpatialPreset(PresetCase):
    """Two steel bodies with a few inputs."""

    young_MPa: Positive = 210e3
    """Young's modulus of both bodies"""
    poisson: PoissonRatio = 0.3
    """Poisson's ratio of both bodies"""
    method: Literal["fem", "vem"] = "fem"
    """fem is triangles, vem is polygons with virtual elements"""
    order: ElementOrder = 2
    """order of the elements"""

    def general(self) -> SpatialCase:
        """See `PresetCase.general`."""
        own = {"young_MPa": self.young_MPa, "poisson": self.poisson, "method": self.method, "order": self.order}
        values = self.tables()
        return SpatialCase.from_values(values | {"bodies": [body | own for body in values["bodies"]]})

    def tables(self) -> dict[str, Any]:
        """Inputs of the general case, without material and elements."""
        raise NotImplementedError


def _crowned(name: str, width: float, height: float, radius: float, *, up: bool) -> dict[str, Any]:
    """A block whose top (or bottom, if it is not the lower body) at y = 0 is an arc of a crown radius."""
    half, sign = width / 2.0, 1.0 if up else -1.0
    if radius < 0.51 * width:
        raise InputError(
            sentence("a crown radius of {:g mm} on a width of {:g mm}", radius, width),
            "more than half the width",
            "make it larger",
        )
    drop = sign * ((radius**2 - half**2) ** 0.5 - radius)
    ends = [[half * sign, drop], [-half * sign, drop]]
    path = [
        {"from": ends[0]},
        {"arc_to": ends[1], "through": [0.0, 0.0], "name": "running"},
        {"line_to": [-half * sign, -sign * height], "name": "side"},
        {"line_to": [half * sign, -sign * height], "name": "far"},
        {"line_to": ends[0], "name": "other side"},
    ]
    return {"name": name, "outline": {"path": path}, "contact_edges": "running", "held_edges": "far"}


def _flat(name: str, width: float, height: float, *, up: bool) -> dict[str, Any]:
    """A block whose top (or bottom) is the line y = 0."""
    middle = [0.0, -height / 2.0 if up else height / 2.0]
    shape = {"width_mm": width, "height_mm": height, "centre_mm": middle}
    running, far = ("top", "bottom") if up else ("bottom", "top")
    return {"name": name, "rectangle": shape, "contact_edges": running, "held_edges": far}


class CraneWheelCase(SpatialPreset):
    """A wheel with a cylindrical tread on a rail with a crowned head."""

    name = "crane-wheel"
    title = "A crane wheel on a crowned rail, in three dimensions"
    essential = ("force_kN", "wheel_radius_mm", "crown_radius_mm", "tread_width_mm")

    force_kN: Positive = 100.0
    """wheel load"""
    wheel_radius_mm: Positive = 200.0
    """radius of the tread"""
    crown_radius_mm: Positive = 400.0
    """radius of the rail's head"""
    tread_width_mm: Positive = 75.0
    """width of the tread and of the rail's head"""
    rim_mm: Positive = 50.0
    """thickness of the rim, and height of the head, that are modelled"""
    yaw_deg: float = Field(0.0, ge=-5.0, le=5.0)
    """skew of the wheel"""

    def tables(self) -> dict[str, Any]:
        """See `SpatialPreset.tables`."""
        rail = _crowned("rail", self.tread_width_mm, self.rim_mm, self.crown_radius_mm, up=True)
        wheel = _flat("wheel", self.tread_width_mm, self.rim_mm, up=False)
        wheel |= {"axis_mm": [0.0, self.wheel_radius_mm], "yaw_deg": self.yaw_deg}
        return {"force_kN": self.force_kN, "bodies": [rail, wheel]}


class RollerCase(SpatialPreset):
    """A crowned roller of a bearing on the inner or the outer race."""

    name = "roller"
    title = "A crowned roller on the inner or outer race of a bearing, in three dimensions"
    essential = ("force_kN", "roller_radius_mm", "crown_radius_mm", "race_radius_mm", "race")

    force_kN: Positive = 5.0
    """force on the roller"""
    roller_radius_mm: Positive = 10.0
    """radius of the roller at its middle"""
    roller_length_mm: Positive = 20.0
    """length of the roller, and width of the race"""
    crown_radius_mm: Positive = 100.0
    """radius of the roller's crown"""
    race_radius_mm: Positive = 50.0
    """radius of the race"""
    race: Literal["inner", "outer"] = "inner"
    """inner race, convex, or outer race, hollow"""
    ring_mm: Positive = 10.0
    """thickness of the ring"""

    def tables(self) -> dict[str, Any]:
        """See `SpatialPreset.tables`.

        The roller is modelled to its axis, where it is held.
        """
        if self.race == "outer" and self.race_radius_mm <= self.roller_radius_mm:
            raise InputError(
                sentence("{race_radius_mm = :g} of an outer race", self.race_radius_mm),
                sentence("more than {roller_radius_mm = :g}", self.roller_radius_mm),
                "make the race larger",
            )
        ring = _flat("race", self.roller_length_mm, self.ring_mm, up=True)
        ring["axis_mm"] = [0.0, self.race_radius_mm if self.race == "outer" else -self.race_radius_mm]
        roller = _crowned("roller", self.roller_length_mm, self.roller_radius_mm, self.crown_radius_mm, up=False)
        roller["axis_mm"] = [0.0, self.roller_radius_mm]
        return {"force_kN": self.force_kN, "bodies": [ring, roller]}


class CrossedCylindersCase(SpatialPreset):
    """Two cylinders whose axes cross."""

    name = "crossed-cylinders"
    title = "Two cylinders whose axes cross at an angle, in three dimensions"
    essential = ("force_kN", "lower_radius_mm", "upper_radius_mm", "angle_deg")

    force_kN: Positive = 10.0
    """force on the upper cylinder"""
    lower_radius_mm: Positive = 40.0
    """radius of the lower cylinder, whose axis is z"""
    upper_radius_mm: Positive = 40.0
    """radius of the upper cylinder"""
    angle_deg: float = Field(90.0, ge=45.0, le=90.0)
    """angle between both axes"""

    def tables(self) -> dict[str, Any]:
        """See `SpatialPreset.tables`.

        The lower half cylinder is held at its diameter, the upper cylinder at its axis.
        """
        lower, upper = self.lower_radius_mm, self.upper_radius_mm
        below = {"radius_mm": lower, "centre_mm": [0.0, -lower], "half": "upper"}
        cylinder = _flat("upper", 2.0 * lower, upper, up=False)
        cylinder |= {"axis_mm": [0.0, upper], "yaw_deg": 90.0 - self.angle_deg}
        bodies = [{"name": "lower", "disc": below, "contact_edges": "rim", "held_edges": "cut"}, cylinder]
        return {"force_kN": self.force_kN, "bodies": bodies}
