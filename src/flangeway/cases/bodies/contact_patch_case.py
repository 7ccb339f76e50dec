"""The case of the contact patch test: two boxes under a pressure that must be uniform."""

from dataclasses import replace
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.cases.bodies.two_bodies import TwoBodiesCase
from flangeway.cases.case import Progress, RunnableCase


class ContactPatchCase(RunnableCase):
    """Two equal boxes pressed together, free to spread: the exact pressure is uniform (Moherdaui 2021, Figure 64)."""

    name: ClassVar[str] = "contact-patch"
    title: ClassVar[str] = "Contact patch test: two boxes with unlike meshes under a uniform pressure"
    essential: ClassVar[tuple[str, ...]] = ("approach_mm", "upper_size_mm", "lower_size_mm", "pairing")

    width_mm: float = Field(20.0, gt=0.0, description="width of each box")
    height_mm: float = Field(10.0, gt=0.0, description="height of each box")
    approach_mm: float = Field(0.1, gt=0.0, description="how much nearer the far sides come")
    thickness_mm: float = Field(1.0, gt=0.0, description="length out of the plane")
    young_MPa: float = Field(200e3, gt=0.0, description="Young's modulus")  # noqa: N815 (the unit megapascal)
    poisson: float = Field(1.0 / 3.0, gt=-1.0, lt=0.5, description="Poisson's ratio")
    upper_method: Literal["fem", "vem"] = Field("fem", description="elements of the upper, secondary box")
    lower_method: Literal["fem", "vem"] = Field("vem", description="elements of the lower, primary box")
    upper_order: int = Field(1, ge=1, le=2, description="order of the upper box's elements")
    lower_order: int = Field(1, ge=1, le=2, description="order of the lower box's elements")
    upper_size_mm: float = Field(2.3, ge=1e-6, description="edge length of the upper box's triangles")
    lower_size_mm: float = Field(3.1, ge=1e-6, description="edge length of the lower box's triangles")
    pairing: Literal["segment-to-segment", "node-to-segment"] = Field(
        "segment-to-segment", description="how the surfaces are compared; node-to-segment does not pass"
    )
    enforcement: Literal["multiplier", "augmented-lagrange", "penalty"] = Field(
        "multiplier", description="how penetration is kept off"
    )

    def check(self) -> None:
        """See `RunnableCase.check`."""
        self.bodies().check()

    def run(self, progress: Progress = lambda _: None) -> BodiesRun:
        """See `RunnableCase.run`."""
        run = self.bodies().run(progress)
        exact = self.exact_pressure_MPa
        pressures = np.concatenate([patch.pressures for patch in run.patches]) if run.patches else np.zeros(1)
        results: dict[str, Any] = {
            "exact_pressure_MPa": exact,
            "least_pressure_MPa": float(pressures.min()),
            "greatest_pressure_MPa": float(pressures.max()),
            "maximum_difference": float(np.abs(pressures / exact - 1.0).max()),
        }
        case = {"name": self.name, **self.model_dump()}
        return replace(run, case=self, summary={**run.summary, "case": case, "results": results})

    @property
    def exact_pressure_MPa(self) -> float:  # noqa: N802 (the unit megapascal)
        """The uniform pressure, ``E / (1 - nu^2)`` times the approach over the height of both boxes."""
        return self.young_MPa / (1.0 - self.poisson**2) * self.approach_mm / (2.0 * self.height_mm)

    def bodies(self) -> TwoBodiesCase:
        """Return the same as a general case."""
        bodies: list[dict[str, Any]] = []
        supports: list[dict[str, Any]] = []
        for name, sign, far in (("upper", 1.0, "top"), ("lower", -1.0, "bottom")):
            bodies.append(
                {
                    "name": name,
                    "rectangle": {
                        "width_mm": self.width_mm,
                        "height_mm": self.height_mm,
                        "centre_mm": (0.5 * self.width_mm, 0.5 * sign * self.height_mm),
                    },
                    "young_MPa": self.young_MPa,
                    "poisson": self.poisson,
                    "method": getattr(self, f"{name}_method"),
                    "order": getattr(self, f"{name}_order"),
                    "size_mm": getattr(self, f"{name}_size_mm"),
                }
            )
            supports.append({"body": name, "edges": far, "hold": "y"})
            supports.append({"body": name, "point_mm": (0.0, sign * self.height_mm), "hold": "x"})
        contact = {
            "secondary": "upper",
            "secondary_edges": "bottom",
            "primary": "lower",
            "primary_edges": "top",
            "pairing": self.pairing,
            "enforcement": self.enforcement,
        }
        return TwoBodiesCase.from_values(
            {
                "thickness_mm": self.thickness_mm,
                "bodies": bodies,
                "supports": supports,
                "motions": [{"body": "upper", "shift_mm": (0.0, -self.approach_mm)}],
                "contacts": [contact],
            }
        )
