"""Published problems: Hertz's contact, a preset of the general case, and Cook's membrane."""

# ruff: noqa: N815 (units in names)
import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import annotated_types as at
from pydantic import Field

from flangeway.cases.bodies.bodies_run import (
    AT_EDGE,
    HALF_WIDTH,
    PATCH_PRESSURE,
    REMARK,
    BodiesCase,
    BodiesRun,
    TwoBodiesCase,
)
from flangeway.cases.case import PresetCase
from flangeway.contact.contact_records import Law, Pairing
from flangeway.errors import InputError
from flangeway.exact import LineContact, contact_modulus
from flangeway.materials import Elastic
from flangeway.post import PressurePatch
from flangeway.problems.body_records import MethodName, Stabilisation
from flangeway.quantities import Quantities, Quantity, of_part
from flangeway.records import ElementOrder, ElementSize, Fraction, PoissonRatio, Positive

# --- Hertz's contact as a preset of the general case.


METHOD_MEANING = "fem: triangles; vem: polygons with virtual elements; vem-triangles: triangles with virtual elements"
ZONE_OF_LENS = 0.85
"""Half width of the fine zone relative to that of the overlap of the rigid bodies; elastic contact takes about half."""
ZONE_OF_HERTZ = 1.6  # the same relative to Hertz's half width, where the force is given
ZONE_EDGES = 3.0  # edges of the mesh that the fine zone is wider
MAX_EDGES = 10_000  # on half of the fine zone: more is a mistake in a size
MAX_RADIUS = 1e6  # radius relative to the elements' size above which a half disc is not meshed
MIN_PIECES = 17  # minimum number of pieces of the polyline along a fine arc
MAX_ZONE = 0.75  # half width of the fine zone relative to the radius: wider ones do not fit half discs


def _fullest(run: BodiesRun) -> PressurePatch:
    """Region with the maximum force."""
    return max(run.patches, key=lambda patch: float(patch.normal_forces.sum()))


def _hertz(run: BodiesRun) -> LineContact:
    assert run.theory is not None
    return run.theory


HERTZ: Quantities[BodiesRun] = (
    *of_part(_fullest, PATCH_PRESSURE, REMARK),
    Quantity(
        "hertz_max_pressure",
        "maximum pressure, Hertz",
        lambda run: _hertz(run).max_pressure,
        "MPa",
        ".6g",
    ),
    Quantity(
        *("max_pressure_difference", "maximum pressure, relative difference"),
        lambda run: _fullest(run).max_pressure / _hertz(run).max_pressure - 1.0,
        form=".3g",
    ),
    *of_part(_fullest, HALF_WIDTH),
    Quantity(
        "hertz_half_width",
        "half width of contact, Hertz",
        lambda run: _hertz(run).half_width,
        "mm",
        ".6g",
    ),
    Quantity(
        *("half_width_difference", "half width, relative difference"),
        lambda run: _fullest(run).half_width / _hertz(run).half_width - 1.0,
        form=".3g",
    ),
    *of_part(_fullest, AT_EDGE),
)
"""Numbers of a contact beside Hertz's solution."""


class HertzCase(PresetCase, BodiesCase):
    """A half disc pressed on another one, or on a block, in plane strain (Moherdaui 2021, 6.2.2)."""

    name = "hertz"
    title = "A cylinder on another one or on a block, compared with Hertz's solution"
    essential = ("radius_mm", "lower", "lower_radius_mm", "indentation_mm", "size_mm")

    radius_mm: Positive = 40.0
    """radius of the upper cylinder"""
    lower: Literal["disc", "block"] = "disc"
    """lower body: a half disc, or a block"""
    lower_radius_mm: Positive = 40.0
    """radius of the lower disc; a block is four radii wide and two high"""
    indentation_mm: Positive = 0.2
    """approach of the fixed sides after first touch"""
    force_N: Positive | None = None
    """pressing force, instead of indentation_mm"""
    thickness_mm: Positive = 10.0
    """length of the cylinders"""
    young_MPa: Positive = 200e3
    """Young's modulus"""
    poisson: PoissonRatio = 1.0 / 3.0
    """Poisson's ratio"""
    lower_young_MPa: Positive | None = None
    """Young's modulus of the lower body (default: young_MPa)"""
    lower_poisson: PoissonRatio | None = None
    """Poisson's ratio of the lower body (default: poisson)"""
    method: MethodName = Field("fem", description=METHOD_MEANING)
    order: ElementOrder = 1
    """order of the elements"""
    lower_method: MethodName | None = None
    """method of the lower body (default: method)"""
    lower_order: ElementOrder | None = None
    """order of the lower body (default: order)"""
    size_mm: ElementSize = 0.1
    """edge length of the triangles in contact"""
    lower_size_mm: ElementSize | None = None
    """size_mm of the lower body (default: size_mm)"""
    body_size_mm: ElementSize = 5.0
    """edge length of the triangles elsewhere"""
    growth: Fraction = 0.13
    """growth of the edge length per distance from the contact"""
    pairing: Pairing
    enforcement: Law
    fine_arc_deg: Annotated[float, at.Gt(0.0), at.Lt(180.0)] | None = None
    """angle of the fine arc of both discs about the contact (default: its zone)"""
    halved_edges: bool = False
    """whether the edges of the fine arcs are halved, see halved_side"""
    stabilisation: Stabilisation = "default"
    curved: bool = True
    """whether gaps are measured between the circles, not between straight edges"""
    n_steps: Annotated[int, at.Ge(1), at.Le(1000)] = 1
    """number of equal load steps"""

    exclusive = (("indentation_mm", "force_N"),)
    needs = (("halved_edges", "fine_arc_deg"),)

    def theory_of(self, run: BodiesRun) -> LineContact | None:
        """See `BodiesCase.theory_of`."""
        assert run.contact is not None
        force = float(run.contact.forces[0, 1])
        return self.theory(force) if run.status.converged and force > 0.0 else None

    def theory(self, force_N: float) -> LineContact:
        """Hertz's solution for a force."""
        bodies = (
            Elastic(self.of_body(name, "young_MPa"), self.of_body(name, "poisson")) for name in ("upper", "lower")
        )
        modulus = contact_modulus(*(body.plane_modulus for body in bodies))
        return LineContact(force_N / self.thickness_mm, self._curvature, modulus)

    def general(self) -> TwoBodiesCase:
        """See `PresetCase.general`.

        The contact must be neither too wide for the bodies nor too narrow for the elements' size.
        """
        self._refuse_unfit()
        return self.filled_in(TwoBodiesCase)

    def _refuse_unfit(self) -> None:
        """Refuse a contact too wide for the bodies, or too narrow for the elements' size."""
        radius, below = self.radius_mm, self.lower_radius_mm
        if self.fine_arc_deg is not None:
            self._refuse_narrow(self.fine_arc_deg)
        zone, size = self.zone, min(self.size_mm, self.of_body("lower", "size_mm"))
        for key, value in (("radius_mm", radius), ("lower_radius_mm", below)):
            if value > MAX_RADIUS * size:
                raise InputError(
                    f"{key} = {value:g} with elements of size_mm = {size:g}",
                    f"radii up to {MAX_RADIUS:g} times size_mm",
                    'make it smaller; lower = "block" is flat',
                )
        smallest = radius if self.lower == "block" else min(radius, below)
        if zone > MAX_ZONE * smallest:
            raise InputError(
                f"a contact that may reach {zone:.3g} mm to either side on a radius of {smallest:g} mm",
                f"up to {MAX_ZONE:g} of the radius",
                "make size_mm and the indentation or the force smaller",
            )
        if zone > MAX_EDGES * size:
            raise InputError(
                f"size_mm = {size:g} for a contact that may reach {zone:.3g} mm to either side",
                f"at most {MAX_EDGES} edges on that length",
                "make size_mm larger",
            )

    def _refuse_narrow(self, arc_deg: float) -> None:
        """Refuse a fine arc of blocks, or one that does not hold the zone where the bodies may touch."""
        if self.lower == "block":
            raise InputError("fine_arc_deg with lower = block", "two discs", "leave fine_arc_deg out")
        reach = min(self.radius_mm, self.lower_radius_mm) * math.sin(math.radians(arc_deg) / 2.0)
        if self.zone > reach:
            raise InputError(
                f"fine_arc_deg = {arc_deg:g}, {reach:.3g} mm to either side, for a contact that may reach "
                f"{self.zone:.3g} mm",
                "a fine arc that holds the contact",
                "make it larger, or the indentation, the force or size_mm smaller",
            )

    def fine_points(self, name: str) -> list[tuple[float, float]]:
        """Points of the contact surface of a body along which its mesh is finer: within `zone`, or on the fine arc."""
        radius, size = self.of_body(name, "radius_mm"), self.of_body(name, "size_mm")
        n = max(math.ceil(self.zone / (2.0 * size)), 1)
        xs = [self.zone * i / n for i in range(-n, n + 1)]
        if self.fine_arc_deg is not None:
            angle = math.radians(self.fine_arc_deg) / 2.0
            n = max(math.ceil(angle * radius / (2.0 * size)), MIN_PIECES)
            xs = [radius * math.sin(angle * (2 * i / n - 1.0)) for i in range(n + 1)]
        up = 1.0 if name == "upper" else -1.0 if self.lower == "disc" else 0.0
        return [(x, up * (radius - math.sqrt(radius**2 - x**2))) for x in xs]

    def of_body(self, name: str, key: str) -> Any:
        """Return an input of a body; that of the upper one where the lower one has none of its own."""
        lower = getattr(self, f"lower_{key}") if name == "lower" else None
        return getattr(self, key) if lower is None else lower

    @property
    def _curvature(self) -> float:
        return 1.0 / self.radius_mm + (0.0 if self.lower == "block" else 1.0 / self.lower_radius_mm)

    @property
    def zone(self) -> float:
        """Half width of the zone where the bodies may touch."""
        edges = ZONE_EDGES * max(self.size_mm, self.of_body("lower", "size_mm"))
        if self.force_N is not None:
            return ZONE_OF_HERTZ * self.theory(self.force_N).half_width + edges
        return ZONE_OF_LENS * math.sqrt(2.0 * self.indentation_mm / self._curvature) + edges

    def quantities(self, run: BodiesRun) -> Sequence[Quantity[BodiesRun]]:
        """Force and indentation, and the contact beside Hertz's solution."""
        assert run.contact is not None
        force, pushed = float(run.contact.forces[0, 1]), run.pushed_mm
        return (
            Quantity("force", "force", lambda _: force, "N", ".6g"),
            Quantity("indentation", "indentation", lambda _: self.indentation_mm if pushed is None else pushed, "mm"),
            *(HERTZ if run.theory is not None and run.patches else ()),
        )
