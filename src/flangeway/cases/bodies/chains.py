"""Chains and rings of bodies, floating ones among them, with friction, as presets of the general case."""

import itertools
import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from pydantic import Field

from flangeway.cases.bodies.bodies_run import XY, BodiesRun
from flangeway.cases.bodies.bodies_tables import EnforcementName
from flangeway.cases.bodies.presets import CONTACT_KEYS, BodiesPreset, max_pressure_of
from flangeway.cases.bodies.two_bodies import TwoBodiesCase
from flangeway.errors import InputError
from flangeway.exact import LineContact, contact_modulus
from flangeway.materials import Elastic
from flangeway.quantities import Quantity

# ruff: noqa: N815 (units in names)

Layout = dict[str, list[dict[str, Any]]]


class ChainPreset(BodiesPreset):
    """Bodies of one material in a chain or a ring."""

    thickness_mm: float = Field(10.0, gt=0.0)
    """length out of the plane"""
    young_MPa: float = Field(210e3, gt=0.0)
    """Young's modulus"""
    poisson: float = Field(0.3, gt=-1.0, lt=0.5)
    """Poisson's ratio"""
    order: int = Field(1, ge=1, le=2)
    """order of the elements"""
    pairing: Literal["segment-to-segment", "node-to-segment"] = "segment-to-segment"
    """contact discretisation"""
    enforcement: EnforcementName = "multiplier"
    """constraint enforcement"""
    penalty_MPa_mm: float | None = Field(None, gt=0.0)
    """pressure per penetration (default: as of bodies)"""
    penetration_mm: float = Field(1e-5, gt=0.0)
    """tolerated penetration of augmented-lagrange"""
    friction: float = Field(0.2, ge=0.0, le=10.0)
    """coefficient of friction"""
    n_steps: int = Field(1, ge=1, le=1000)
    """number of equal steps of each leg: pressing, then moving"""

    @abstractmethod
    def layout(self) -> Layout:
        """Tables of the general case."""

    def general(self) -> TwoBodiesCase:
        """See `PresetCase.general`."""
        tables, shared = self.layout(), self.model_dump(include=CONTACT_KEYS)
        material = {"young_MPa": self.young_MPa, "poisson": self.poisson, "order": self.order}
        tables["bodies"] = [material | body for body in tables["bodies"]]
        tables["contacts"] = [shared | contact for contact in tables["contacts"]]
        given = {"thickness_mm": self.thickness_mm, "steps": {"number": self.n_steps}}
        return TwoBodiesCase.from_values({**given, **tables})


def forces_of_contacts(run: BodiesRun) -> list[Quantity[BodiesRun]]:
    """Force of each contact on its secondary body."""
    return [_force(*pair.sides, pair.number) for pair in run.pairs]


def _force(on: str, by: str, number: int) -> Quantity[BodiesRun]:
    key = f"force_on_{on}_by_{by}".replace("-", "_")
    return Quantity(key, f"force on {on} by {by}", lambda r: r.pairs[number].solution.forces[number], "N", "z.6g", XY)


def motion_of(name: str) -> list[Quantity[BodiesRun]]:
    """How far the middle of a floating body has moved, and how far it has turned."""

    def shift(run: BodiesRun) -> list[float]:
        points = run.bodies[name].field.problem.space.mesh.points
        middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
        moved: list[float] = (run.bodies[name].placement.points([middle])[0] - middle).tolist()
        return moved

    return [
        Quantity(f"{name}_shift", f"{name}: shift", shift, "mm", "z.6g", XY),
        Quantity(
            *(f"{name}_rotation", f"{name}: rotation"),
            lambda run: math.degrees(run.bodies[name].placement.rotation_rad),
            "deg",
            "z.6g",
        ),
    ]


class StackCase(ChainPreset):
    """Blocks upon each other, the ones in between held by contact alone; pressed, then the upper one is shifted."""

    name = "stack"
    title = "A stack of three blocks, pressed and pushed sideways: friction alone holds the middle one"
    essential = ("force_N", "shift_mm", "friction", "upper_friction")

    width_mm: float = Field(40.0, gt=0.0)
    """width of the upper block; each below is 8 mm wider"""
    height_mm: float = Field(20.0, gt=0.0)
    """height of each block"""
    force_N: float = Field(20e3, gt=0.0)
    """force on the upper block"""
    shift_mm: float = 0.05
    """shift of the upper block after pressing"""
    upper_friction: float = Field(0.4, ge=0.0, le=10.0)
    """coefficient of friction below the upper block"""
    size_mm: float = Field(4.0, ge=1e-6)
    """edge length of the triangles"""

    def layout(self) -> Layout:
        """See `ChainPreset.layout`."""
        names, height = ("lower", "middle", "upper"), self.height_mm
        bodies: list[dict[str, Any]] = []
        for level, name in enumerate(names):
            shape: dict[str, Any] = {"width_mm": self.width_mm + 8.0 * (2 - level), "height_mm": height}
            shape["centre_mm"] = (0.0, (level + 0.5) * height)
            bodies.append({"name": name, "rectangle": shape, "size_mm": self.size_mm * (1.0 + 0.1 * level)})
        contacts: list[dict[str, Any]] = [
            {"secondary": above, "secondary_edges": "bottom", "primary": below, "primary_edges": "top"}
            for below, above in itertools.pairwise(names)
        ]
        contacts[-1]["friction"] = self.upper_friction
        return {
            "bodies": bodies,
            "contacts": contacts,
            "supports": [{"body": "lower", "edges": "bottom"}, {"body": "upper", "edges": "top"}],
            "motions": [
                {"body": "upper", "push_N": (0.0, -self.force_N)},
                {"body": "upper", "leg": 2, "shift_mm": (self.shift_mm, 0.0)},
            ],
        }

    def quantities(self, run: BodiesRun) -> Sequence[Quantity[BodiesRun]]:
        """Forces of the contacts, and the motion of the block between."""
        return [*forces_of_contacts(run), *motion_of("middle")]


class RollerBetweenPlatesCase(ChainPreset):
    """A roller that contact alone holds between two plates, of which the upper one is pressed and then shifted."""

    name = "roller-between-plates"
    title = "A roller between two plates moves half as far as the upper plate"
    essential = ("radius_mm", "force_N", "shift_mm", "friction", "size_mm")

    radius_mm: float = Field(20.0, gt=0.0)
    """radius of the roller"""
    plate_height_mm: float = Field(15.0, gt=0.0)
    """height of each plate; they are four radii wide"""
    force_N: float = Field(20e3, gt=0.0)
    """force on the upper plate"""
    shift_mm: float = 0.5
    """shift of the upper plate after pressing"""
    size_mm: float = Field(0.1, ge=1e-6)
    """edge length of the triangles at the contacts"""
    body_size_mm: float = Field(4.0, ge=1e-6)
    """edge length of the triangles elsewhere"""

    def theory(self, force_N: float) -> LineContact:
        """Hertz's solution for a force."""
        plane = Elastic(self.young_MPa, self.poisson).plane_modulus
        return LineContact(force_N / self.thickness_mm, 1.0 / self.radius_mm, contact_modulus(plane, plane))

    def layout(self) -> Layout:
        """See `ChainPreset.layout`."""
        radius, height = self.radius_mm, self.plate_height_mm
        zone = 1.5 * self.theory(self.force_N).half_width + 3.0 * self.size_mm
        middle = 0.5 * self.shift_mm  # where the contacts roll to
        low, high = min(middle, 0.0) - zone, max(middle, 0.0) + zone
        if max(-low, high) > 0.7 * radius:
            raise InputError(
                f"contacts that reach {max(-low, high):.3g} mm to a side on a radius of {radius:g} mm",
                "up to 0.7 of the radius",
                "make force_N, shift_mm or size_mm smaller",
            )
        xs = np.linspace(low, high, 2 + math.ceil((high - low) / (2.0 * self.size_mm)))
        rise = radius - np.sqrt(radius**2 - xs**2)

        def fine(ys: np.ndarray[Any, Any], sign: float = 1.0) -> dict[str, Any]:
            return {"at_mm": list(zip((sign * xs).tolist(), ys.tolist(), strict=True)), "size_mm": self.size_mm}

        plate = {"width_mm": 4.0 * radius, "height_mm": height}
        size = {"size_mm": self.body_size_mm}
        # the roller turns: what meets the upper plate later is on the other side
        rim = [fine(rise), fine(2.0 * radius - rise, -1.0)]
        rest = xs * 0.0
        return {
            "bodies": [
                {
                    "name": "lower",
                    "rectangle": plate | {"centre_mm": (0.0, -0.5 * height)},
                    "fine": [fine(rest)],
                    **size,
                },
                {"name": "roller", "disc": {"radius_mm": radius, "centre_mm": (0.0, radius)}, "fine": rim, **size},
                {
                    "name": "upper",
                    "rectangle": plate | {"centre_mm": (0.0, 2.0 * radius + 0.5 * height)},
                    "fine": [fine(rest + 2.0 * radius, -1.0)],
                    **size,
                },
            ],
            "contacts": [
                {
                    "secondary": "roller",
                    "secondary_edges": "rim",
                    "secondary_box_mm": (-0.8 * radius, edge - 0.4 * radius, 0.8 * radius, edge + 0.4 * radius),
                    "primary": name,
                    "primary_edges": side,
                }
                for name, side, edge in (("lower", "top", 0.0), ("upper", "bottom", 2.0 * radius))
            ],
            "supports": [{"body": "lower", "edges": "bottom"}, {"body": "upper", "edges": "top"}],
            "motions": [
                {"body": "upper", "push_N": (0.0, -self.force_N)},
                {"body": "upper", "leg": 2, "shift_mm": (self.shift_mm, 0.0)},
            ],
        }

    def quantities(self, run: BodiesRun) -> Sequence[Quantity[BodiesRun]]:
        """Forces of the contacts, the motion of the roller, and the pressure beside Hertz's."""
        hertz = self.theory(self.force_N).max_pressure
        return [
            *forces_of_contacts(run),
            *motion_of("roller"),
            Quantity("max_pressure", "maximum pressure", max_pressure_of, "MPa", ".6g"),
            Quantity("hertz_max_pressure", "maximum pressure, Hertz", lambda _: hertz, "MPa", ".6g"),
        ]


class BearingRingCase(ChainPreset):
    """A shaft in a ring with three rollers in between, which contact alone holds; the shaft is loaded downwards."""

    name = "bearing-ring"
    title = "A bearing: a shaft on three rollers in a ring, which contact alone holds"
    essential = ("shaft_radius_mm", "roller_radius_mm", "force_N", "interference_mm")

    shaft_radius_mm: float = Field(20.0, gt=0.0)
    """radius of the shaft; its bore has four tenths of it"""
    roller_radius_mm: float = Field(8.0, gt=0.0)
    """radius of the rollers, at 90, 210 and 330 degrees"""
    ring_height_mm: float = Field(12.0, gt=0.0)
    """thickness of the ring, whose outer circle is held"""
    interference_mm: float = Field(0.05, ge=0.0)
    """how much thicker the rollers are than the room for them"""
    force_N: float = Field(10e3, gt=0.0)
    """force on the shaft, downwards, through its bore"""
    size_mm: float = Field(0.03, ge=1e-6)
    """edge length of the triangles at the contacts"""
    body_size_mm: float = Field(4.0, ge=1e-6)
    """edge length of the triangles elsewhere"""

    def layout(self) -> Layout:
        """See `ChainPreset.layout`."""
        shaft, roller = self.shaft_radius_mm, self.roller_radius_mm
        race, pitch = shaft + 2.0 * roller, shaft + roller
        angles = np.deg2rad((90.0, 210.0, 330.0))
        ways = np.column_stack((np.cos(angles), np.sin(angles)))
        zone = 0.08 * roller  # half width of what is finely meshed

        def fine(centre: np.ndarray[Any, Any], radius: float, way: np.ndarray[Any, Any]) -> dict[str, Any]:
            turns = np.linspace(-zone / radius, zone / radius, 1 + 2 * math.ceil(zone / (2.0 * self.size_mm)))
            turned = np.outer(np.cos(turns), way) + np.outer(np.sin(turns), (-way[1], way[0]))
            return {"at_mm": [tuple(point) for point in (centre + radius * turned).tolist()], "size_mm": self.size_mm}

        middle, size = np.zeros(2), {"size_mm": self.body_size_mm}
        outer = race + self.ring_height_mm
        bodies: list[dict[str, Any]] = [
            {"name": name, "outline": _ring(hole, rim, inner, outside), "fine": [fine(middle, at, way) for way in ways]}
            for name, hole, rim, inner, outside, at in (
                ("ring", race, outer, "race", "housing", race),
                ("shaft", 0.4 * shaft, shaft, "bore", "race", shaft),
            )
        ]
        contacts: list[dict[str, Any]] = []
        for number, way in enumerate(ways, 1):
            centre, thick = pitch * way, roller + 0.5 * self.interference_mm
            rim = [fine(centre, thick, sign * way) for sign in (1.0, -1.0)]
            name = f"roller-{number}"
            bodies.append(
                {"name": name, "disc": {"radius_mm": thick, "centre_mm": tuple(centre.tolist())}, "fine": rim}
            )
            for other, sign, radius in (("ring", 1.0, race), ("shaft", -1.0, shaft)):
                boxes = {
                    f"{role}_box_mm": (*(at - 0.6 * roller).tolist(), *(at + 0.6 * roller).tolist())
                    for role, at in (("secondary", centre + sign * thick * way), ("primary", radius * way))
                }
                pair = {"secondary": name, "primary": other, "primary_edges": "race", "interference": True}
                contacts.append(pair | boxes)
        return {
            "bodies": [body | size for body in bodies],
            "contacts": contacts,
            "supports": [{"body": "ring", "edges": "housing"}, {"body": "shaft", "edges": "bore"}],
            "motions": [{"body": "shaft", "push_N": (0.0, -self.force_N)}],
        }

    def quantities(self, run: BodiesRun) -> Sequence[Quantity[BodiesRun]]:
        """Forces of the rollers, and how far the shaft sinks."""
        return [*forces_of_contacts(run), Quantity("shaft_sinks", "shaft sinks", "pushed_mm", "mm", ".6g")]


class ShrinkFitCase(ChainPreset):
    """A quarter of a hub that was shrunk on a hollow shaft, beside Lame's solution."""

    name = "shrink-fit"
    title = "A hub shrunk on a shaft, compared with Lamé's solution"
    essential = ("bore_radius_mm", "fit_radius_mm", "hub_radius_mm", "interference_mm")

    bore_radius_mm: float = Field(10.0, gt=0.0)
    """inner radius of the shaft"""
    fit_radius_mm: float = Field(25.0, gt=0.0)
    """radius of the fit"""
    hub_radius_mm: float = Field(50.0, gt=0.0)
    """outer radius of the hub"""
    interference_mm: float = Field(0.02, gt=0.0)
    """how much larger the shaft's radius is than the hub's"""
    friction: float = Field(0.0, ge=0.0, le=10.0)
    """coefficient of friction"""
    order: int = Field(2, ge=1, le=2)
    """order of the elements"""
    size_mm: float = Field(1.0, ge=1e-6)
    """edge length of the triangles along the fit"""
    body_size_mm: float = Field(4.0, ge=1e-6)
    """edge length of the triangles elsewhere"""

    @property
    def lame_pressure_MPa(self) -> float:  # noqa: N802 (the unit megapascal)
        """Uniform pressure of two tubes in plane strain (Timoshenko and Goodier, Theory of elasticity, 28)."""
        inner, fit, outer = self.bore_radius_mm, self.fit_radius_mm, self.hub_radius_mm
        modulus, ratio = self.young_MPa / (1.0 - self.poisson**2), self.poisson / (1.0 - self.poisson)
        hub = (outer**2 + fit**2) / (outer**2 - fit**2) + ratio
        shaft = (fit**2 + inner**2) / (fit**2 - inner**2) - ratio
        return modulus * self.interference_mm / (fit * (hub + shaft))

    def layout(self) -> Layout:
        """See `ChainPreset.layout`."""
        radii = self.bore_radius_mm, self.fit_radius_mm, self.hub_radius_mm
        if not radii[0] < radii[1] < radii[2]:
            raise InputError(f"radii of bore, fit and hub {radii}", "rising radii", "correct them")
        shaft = self.fit_radius_mm + self.interference_mm
        fine = {"edges": "fit", "size_mm": self.size_mm}
        bodies = [
            {"name": "shaft", "outline": _quarter(self.bore_radius_mm, shaft, "bore", "fit")},
            {"name": "hub", "outline": _quarter(self.fit_radius_mm, self.hub_radius_mm, "fit", "rim")},
        ]
        return {
            "bodies": [body | {"fine": [fine], "size_mm": self.body_size_mm} for body in bodies],
            "contacts": [
                {
                    "secondary": "hub",
                    "secondary_edges": "fit",
                    "primary": "shaft",
                    "primary_edges": "fit",
                    "curved": True,
                    "interference": True,
                }
            ],
            "supports": [{"body": name, "edges": axis, "hold": axis} for name in ("shaft", "hub") for axis in "xy"],
        }

    def quantities(self, run: BodiesRun) -> Sequence[Quantity[BodiesRun]]:
        """Mean pressure, from the force of a quarter, and the maximum beside Lame's pressure."""
        assert run.contact is not None
        exact, length = self.lame_pressure_MPa, self.fit_radius_mm * self.thickness_mm
        mean = float(run.contact.forces[0].mean()) / length  # each component of the force acts on this length
        return (
            Quantity("mean_pressure", "mean pressure", lambda _: mean, "MPa", ".6g"),
            Quantity("max_pressure", "maximum pressure", max_pressure_of, "MPa", ".6g"),
            Quantity("lame_pressure", "Lamé's pressure", lambda _: exact, "MPa", ".6g"),
            Quantity("pressure_difference", "relative difference", lambda _: mean / exact - 1.0, form=".3g"),
        )


def _ring(inner: float, outer: float, inside: str, outside: str) -> dict[str, Any]:
    """Outline of a ring about the origin with the names of its circles."""

    def circle(radius: float, name: str) -> list[dict[str, Any]]:
        arc = {"centre": [0.0, 0.0], "turn": "left", "name": name}
        return [{"from": [radius, 0.0]}, {"arc_to": [-radius, 0.0], **arc}, {"arc_to": [radius, 0.0], **arc}]

    return {"path": circle(outer, outside), "holes": [{"path": circle(inner, inside)}]}


def _quarter(inner: float, outer: float, inside: str, outside: str) -> dict[str, Any]:
    """Outline of a quarter of a ring; its straight sides have the names of the directions that symmetry holds."""
    arc = {"centre": [0.0, 0.0]}
    path = [
        {"from": [inner, 0.0]},
        {"line_to": [outer, 0.0], "name": "y"},
        {"arc_to": [0.0, outer], **arc, "turn": "left", "name": outside},
        {"line_to": [0.0, inner], "name": "x"},
        {"arc_to": [inner, 0.0], **arc, "turn": "right", "name": inside},
    ]
    return {"path": path}
