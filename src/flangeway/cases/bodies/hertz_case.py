"""The case of a cylinder on another one or on a block, with Hertz's solution beside it."""

import math
from dataclasses import replace
from typing import Any, ClassVar, Literal

from pydantic import Field

from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.cases.bodies.two_bodies import TwoBodiesCase
from flangeway.cases.case import Progress, RunnableCase
from flangeway.errors import InputError
from flangeway.exact import LineContact, contact_modulus
from flangeway.materials import Elastic

ZONE_OF_LENS = 0.85
"""Half width of the candidate zone over that of the overlap of the rigid bodies; elastic contact takes about half."""
ZONE_OF_HERTZ = 1.6
"""The same over Hertz's half width, where the force is given."""
ZONE_EDGES = 3.0
MOST_EDGES = 10_000
MAX_RADIUS = 1e6
"""Radius over the elements' size above which a half disc is no shape to be meshed."""
WIDEST_ZONE = 0.75
"""Half width of the zone over the radius above which the bodies are no half discs any more."""


class HertzCase(RunnableCase):
    """A half disc pressed on another one, or on a block, in plane strain (Moherdaui 2021, 6.2.2)."""

    name: ClassVar[str] = "hertz"
    title: ClassVar[str] = "A cylinder on another one or on a block, beside Hertz's solution"
    essential: ClassVar[tuple[str, ...]] = ("radius_mm", "lower", "lower_radius_mm", "indentation_mm", "size_mm")

    radius_mm: float = Field(40.0, gt=0.0, description="radius of the upper cylinder")
    lower: Literal["disc", "block"] = Field("disc", description="what is below: a half disc, or a block")
    lower_radius_mm: float = Field(40.0, gt=0.0, description="radius of the lower disc; a block is four and two of it")
    indentation_mm: float = Field(0.2, gt=0.0, description="approach of the held sides after first touch")
    force_N: float | None = Field(None, gt=0.0, description="pressing force, instead of indentation_mm")  # noqa: N815
    thickness_mm: float = Field(10.0, gt=0.0, description="length of the cylinders")
    young_MPa: float = Field(200e3, gt=0.0, description="Young's modulus")  # noqa: N815 (the unit megapascal)
    poisson: float = Field(1.0 / 3.0, gt=-1.0, lt=0.5, description="Poisson's ratio")
    lower_young_MPa: float | None = Field(None, gt=0.0, description="young_MPa of the lower body, if unlike")  # noqa: N815
    lower_poisson: float | None = Field(None, gt=-1.0, lt=0.5, description="poisson of the lower body, if unlike")
    method: Literal["fem", "vem"] = Field("fem", description="fem is triangles, vem is polygons with virtual elements")
    order: int = Field(1, ge=1, le=2, description="order of the elements")
    lower_method: Literal["fem", "vem"] | None = Field(None, description="method of the lower body, if unlike")
    lower_order: int | None = Field(None, ge=1, le=2, description="order of the lower body, if unlike")
    size_mm: float = Field(0.1, ge=1e-6, description="edge length of the triangles in contact")
    body_size_mm: float = Field(5.0, ge=1e-6, description="edge length of the triangles elsewhere")
    growth: float = Field(0.13, gt=0.0, le=1.0, description="growth of the edges per distance from the contact")
    pairing: Literal["segment-to-segment", "node-to-segment"] = Field(
        "segment-to-segment", description="how the surfaces are compared"
    )
    enforcement: Literal["multiplier", "augmented-lagrange", "penalty"] = Field(
        "augmented-lagrange", description="how penetration is kept off"
    )
    n_steps: int = Field(1, ge=1, le=1000, description="equal load steps of the indentation")

    def check(self) -> None:
        """See `RunnableCase.check`."""
        self.bodies()

    def run(self, progress: Progress = lambda _: None) -> BodiesRun:
        """See `RunnableCase.run`."""
        run = self.bodies().run(progress)
        assert run.contact is not None
        force = float(run.contact.forces[0, 1])
        theory = self.theory(force) if run.status.converged and force > 0.0 else None
        case = {"name": self.name, **self.model_dump()}
        summary = {**run.summary, "case": case, "results": self._results(run, theory)}
        return replace(run, case=self, summary=summary, theory=theory)

    def theory(self, force_N: float) -> LineContact:
        """Hertz's solution for a force."""
        upper, lower = self._materials()
        modulus = contact_modulus(upper.plane_modulus, lower.plane_modulus)
        return LineContact(force_N / self.thickness_mm, self._curvature, modulus)

    def bodies(self) -> TwoBodiesCase:
        """Return the same as a general case.

        Raises
        ------
        InputError
            If the contact would be too wide for the bodies, or too narrow for the elements' size.

        """
        self._refuse_unfit()
        zone, radius, below = self._zone(), self.radius_mm, self.lower_radius_mm
        upper = {"disc": {"radius_mm": radius, "centre_mm": (0.0, radius), "half": "lower"}}
        lower: dict[str, Any] = {"disc": {"radius_mm": below, "centre_mm": (0.0, -below), "half": "upper"}}
        if self.lower == "block":
            lower = {"rectangle": {"width_mm": 4.0 * below, "height_mm": 2.0 * below, "centre_mm": (0.0, -below)}}
        block = self.lower == "block"
        motion = {"shift_mm": (0.0, -self.indentation_mm)} if self.force_N is None else {"push_N": (0.0, -self.force_N)}
        wide = zone + 0.01 * self.size_mm
        contact = {
            "secondary": "upper",
            "secondary_edges": "rim",
            "secondary_box_mm": (-wide, -1.0, wide, radius),
            "primary": "lower",
            "primary_edges": "top" if block else "rim",
            "primary_box_mm": (-wide, -below, wide, 1.0),
            "pairing": self.pairing,
            "enforcement": self.enforcement,
        }
        return TwoBodiesCase.from_values(
            {
                "thickness_mm": self.thickness_mm,
                "bodies": [self._body("upper", upper, zone), self._body("lower", lower, zone)],
                "supports": [
                    {"body": "upper", "edges": "cut"},
                    {"body": "lower", "edges": "bottom" if block else "cut"},
                ],
                "motions": [{"body": "upper", **motion}],
                "contacts": [contact],
                "steps": {"number": self.n_steps},
            }
        )

    def _refuse_unfit(self) -> None:
        """Refuse a contact too wide for the bodies, or too narrow for the elements' size."""
        if self.force_N is not None and "indentation_mm" in self.model_fields_set:
            raise InputError("force_N and indentation_mm", "one of both", "leave one out")
        radius, below = self.radius_mm, self.lower_radius_mm
        if max(radius, below) > MAX_RADIUS * self.size_mm:
            key = "radius_mm" if radius >= below else "lower_radius_mm"
            raise InputError(
                f"{key} = {max(radius, below):g} with elements of size_mm = {self.size_mm:g}",
                f"radii up to {MAX_RADIUS:g} times size_mm",
                'make it smaller; lower = "block" is flat',
            )
        zone = self._zone()
        smallest = radius if self.lower == "block" else min(radius, below)
        if zone > WIDEST_ZONE * smallest:
            raise InputError(
                f"a contact that may reach {zone:.3g} mm to either side on a radius of {smallest:g} mm",
                f"up to {WIDEST_ZONE:g} of the radius",
                "make size_mm and the indentation or the force smaller",
            )
        if zone > MOST_EDGES * self.size_mm:
            raise InputError(
                f"size_mm = {self.size_mm:g} for a contact that may reach {zone:.3g} mm to either side",
                f"at most {MOST_EDGES} edges on that length",
                "make size_mm larger",
            )

    def _body(self, name: str, shape: dict[str, Any], zone: float) -> dict[str, Any]:
        upper = name == "upper"
        material = self._materials()[0 if upper else 1]
        radius = self.radius_mm if upper else -self.lower_radius_mm
        n = max(math.ceil(zone / (2.0 * self.size_mm)), 1)
        places = [zone * i / n for i in range(-n, n + 1)]
        flat = not upper and self.lower == "block"
        heights = [0.0 if flat else radius - math.copysign(math.sqrt(radius**2 - x**2), radius) for x in places]
        fine = {"at_mm": list(zip(places, heights, strict=True)), "size_mm": self.size_mm, "growth": self.growth}
        return {
            "name": name,
            **shape,
            "young_MPa": material.young,
            "poisson": material.poisson,
            "method": self.method if upper else self.lower_method or self.method,
            "order": self.order if upper else self.lower_order or self.order,
            "size_mm": max(self.body_size_mm, self.size_mm),
            "fine": [fine],
        }

    def _materials(self) -> tuple[Elastic, Elastic]:
        young, poisson = self.lower_young_MPa, self.lower_poisson
        lower = Elastic(self.young_MPa if young is None else young, self.poisson if poisson is None else poisson)
        return Elastic(self.young_MPa, self.poisson), lower

    @property
    def _curvature(self) -> float:
        return 1.0 / self.radius_mm + (0.0 if self.lower == "block" else 1.0 / self.lower_radius_mm)

    def _zone(self) -> float:
        """Half width of the zone where the bodies may touch."""
        if self.force_N is not None:
            return ZONE_OF_HERTZ * self.theory(self.force_N).half_width + ZONE_EDGES * self.size_mm
        return ZONE_OF_LENS * math.sqrt(2.0 * self.indentation_mm / self._curvature) + ZONE_EDGES * self.size_mm

    def _results(self, run: BodiesRun, theory: LineContact | None) -> dict[str, Any]:
        assert run.contact is not None
        found: dict[str, Any] = {
            "force_N": float(run.contact.forces[0, 1]),
            "indentation_mm": run.summary["results"].get("pushed_mm", self.indentation_mm),
        }
        if theory is None or not run.patches:
            return found
        patch = max(run.patches, key=lambda patch: float(patch.normal_forces.sum()))
        maximum = float(patch.pressures.max())
        return {
            **found,
            "max_pressure_MPa": maximum,
            "max_pressure_remark": patch.remark,
            "hertz_max_pressure_MPa": theory.max_pressure,
            "max_pressure_difference": maximum / theory.max_pressure - 1.0,
            "half_width_mm": patch.half_width,
            "hertz_half_width_mm": theory.half_width,
            "half_width_difference": patch.half_width / theory.half_width - 1.0,
            "reaches_an_end": patch.at_edge,
        }
