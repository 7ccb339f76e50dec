"""The case of two bodies in contact in three dimensions, its numbers, and presets that machines have."""

# ruff: noqa: N815 (units in names)
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

import annotated_types as at
import numpy as np
from pydantic import Field

from flangeway.cases.case import Case, PresetCase, RunnableCase, example_of
from flangeway.cases.patch_quantities import (
    ANGLE,
    AREA,
    AXES,
    CELLS,
    HERTZ_AXES,
    HERTZ_PRESSURE,
    MAX_PRESSURE,
    ON_SURFACE,
)
from flangeway.cases.summary import RunResult
from flangeway.contact.patch.patch_contact import PatchContact, SpatialPatch, press_patch
from flangeway.contact.patch.patch_grid import Axis, PatchBody, PatchGrid, cast, grid_about, grid_of, points_along
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.post.patch_stresses import DepthProfile, SectionStresses, depth_profile, patch_stresses
from flangeway.problems import Elasticity, Foundation, Harmonic
from flangeway.problems.body_records import BodyTable, FineTable, Names, body_shape, listed
from flangeway.quantities import Quantities, Quantity, values
from flangeway.records import ElementOrder, Pair, PoissonRatio, Positive
from flangeway.solve import Status
from flangeway.space import Space
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats, Progress

# --- Numbers of two bodies in contact in three dimensions.


@dataclass(frozen=True, eq=False)
class SpatialBodyResult:
    """One of both bodies, and the stresses below the centre of the first patch."""

    contact: PatchContact
    number: int
    profile: DepthProfile

    @property
    def body(self) -> PatchBody:
        """The body."""
        return (self.contact.pair.first, self.contact.pair.second)[self.number]

    @property
    def name(self) -> str:
        """Of the body."""
        return self.body.name

    @property
    def von_mises(self) -> tuple[float, float]:
        """Maximum von Mises stress and its depth."""
        return self.profile.maximum(self.profile.stresses.von_mises)

    @property
    def tresca(self) -> tuple[float, float]:
        """Maximum of Tresca's stress and its depth."""
        return self.profile.maximum(self.profile.stresses.tresca)


LOAD: Quantity[PatchContact] = Quantity("load", "force", lambda contact: contact.force[1], "kN", ".5g", factor=1e-3)
"""The force as it is given; the summary has its components."""
APPROACH: Quantity[PatchContact] = Quantity(
    "approach", "approach from first touch", lambda contact: contact.approach, "mm", ".5g"
)
CONTACT: Quantities[PatchContact] = (
    Quantity("force", "force on the upper body", lambda contact: contact.force, "N", ".1f", ("x", "y")),
    APPROACH,
    Quantity(
        *("cell", "size of the cells", lambda c: (float(c.pair.grid.widths.mean()), c.pair.grid.strip), "mm"),
        parts=ON_SURFACE,
    ),
    Quantity("cells", "cells of the grid", lambda contact: contact.loaded.shape, "", "d", ON_SURFACE),
    Quantity(
        "gap_error", "", lambda contact: contact.closed_error, meaning="gap under pressure relative to the approach"
    ),
    Quantity(
        "overlap_error",
        "",
        lambda contact: contact.overlap,
        meaning="overlap outside of the patch relative to the approach",
    ),
)
PATCH: Quantities[SpatialPatch] = (
    Quantity("force", "force", lambda patch: patch.force, "N", ".1f", ("x", "y")),
    Quantity("centre", "centre of pressure", lambda patch: patch.centre, "mm", ".3f", ("x", "y", "z")),
    MAX_PRESSURE,
    HERTZ_PRESSURE,
    AXES,
    HERTZ_AXES,
    ANGLE,
    AREA,
    CELLS,
)
MAX_VON_MISES: Quantity[SpatialBodyResult] = Quantity(
    "max_von_mises",
    "maximum von Mises stress",
    lambda body: body.von_mises[0],
    "MPa",
    ".1f",
    meaning="on the normal below the centre of the first patch",
)
BODY: Quantities[SpatialBodyResult] = (
    Quantity("name", "", lambda body: body.name),
    Quantity("elements", "elements", lambda body: body.body.problem.elasticity.space.mesh.n_cells, form=","),
    Quantity(  # of each wavenumber
        "unknowns", "unknowns", lambda body: body.body.problem.elasticity.space.n_dofs, form=",", factor=3
    ),
    Quantity(
        "wavenumbers", "wavenumbers", lambda body: len(body.contact.pair.tables[body.number].wavenumbers), form="d"
    ),
    Quantity("interpolation_error", "", lambda body: body.contact.pair.tables[body.number].error),
    MAX_VON_MISES,
    Quantity("max_von_mises_depth", "  at the depth", lambda body: body.von_mises[1], "mm", ".3f"),
    Quantity("max_tresca", "maximum Tresca stress", lambda body: body.tresca[0], "MPa", ".1f"),
    Quantity("max_tresca_depth", "  at the depth", lambda body: body.tresca[1], "mm", ".3f"),
)


# --- The case of two bodies in contact in three dimensions: prisms and bodies of revolution by their sections.


TRIANGLES_PER_CELL = 0.85
"""Size of triangles relative to that of the cells: Gmsh makes some edges longer."""
FINE_MESH_MARGIN = 0.15
"""Length of the finer mesh beyond the window on each side, relative to the window."""
DEPTHS = 3.0
"""Depth of the profiles relative to the longer semi-axis."""


class SpatialBodyTable(BodyTable):
    """A prism along z, or a body of revolution, by its section in the plane z = 0."""

    contact_edges: Names
    """edge sets of its contact surface, one chain"""
    held_edges: Names | None = None
    """edge sets that are held"""
    hold: str = Field("xyz", pattern="^[xyz]+$")
    """held components, some of x, y, z"""
    foundation_edges: Names | None = None
    """edge sets on an elastic foundation"""
    foundation_N_mm3: tuple[float, float, float] | None = Field(None, strict=False)
    """pressure per displacement of the foundation along x, y and z"""
    axis_mm: Pair | None = None
    """a point of the axis of a body of revolution (default: a prism)"""
    axis_rotation_deg: float = 0.0
    """angle of the axis from x, counter-clockwise"""
    yaw_deg: Annotated[float, at.Ge(-45.0), at.Le(45.0)] = 0.0
    """rotation of the axis about y, from x towards z"""

    needs = (
        *BodyTable.needs, ("foundation_edges", "foundation_N_mm3"), ("foundation_N_mm3", "foundation_edges")
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class SpatialRun(RunResult):
    """Two bodies and the patches between them.

    Parameters
    ----------
    case
        The inputs.
    timings_s
        Seconds by stage.
    contact
        Pressures.
    sections
        Stresses of the lower and the upper body in the plane of the first patch's centre.
    profiles
        The same below this centre.
    notices
        What the reader should know.

    """

    main_table = "patches"

    case: Case
    timings_s: Mapping[str, float]
    contact: PatchContact
    sections: tuple[SectionStresses, SectionStresses]
    profiles: tuple[DepthProfile, DepthProfile]
    notices: Sequence[str]

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.contact.status

    @property
    def patches(self) -> list[SpatialPatch]:
        """The patches by falling force."""
        return self.contact.patches

    @cached_property
    def bodies(self) -> list[SpatialBodyResult]:
        """The lower and the upper body."""
        return [SpatialBodyResult(self.contact, number, profile) for number, profile in enumerate(self.profiles)]

    def parts(self) -> dict[str, Any]:
        """See `RunResult.parts`."""
        return values(CONTACT, self.contact) | {
            "patches": [values(PATCH, patch) for patch in self.patches],
            "bodies": [values(BODY, body) for body in self.bodies],
            "notices": self.notices,
        }


class SpatialCase(RunnableCase):
    """Two bodies by their sections, one above the other; x to the right, y up, z along the prisms."""

    name = "spatial"
    title = "Two prisms or bodies of revolution in contact in three dimensions"
    essential = ("force_kN",)
    example = example_of(name)

    force_kN: Positive | None = None
    """force on the upper body, downwards"""
    approach_mm: Positive | None = None
    """approach after first touch, instead of force_kN"""
    cell_mm: Positive | None = None
    """size of square cells (default: 26 across the patch)"""
    window_mm: Pair | None = None
    """width and length along z of the grid, with cell_mm"""
    tolerance: Annotated[float, at.Gt(0.0), at.Le(0.1)] = 1e-3
    """interpolation error of the compliances"""
    bodies: Annotated[list[SpatialBodyTable], at.MinLen(2), at.MaxLen(2)]
    """the lower body, then the upper one"""

    exclusive = needed = (("force_kN", "approach_mm"),)
    needs = (("cell_mm", "window_mm"), ("window_mm", "cell_mm"))

    def check(self) -> None:
        """See `RunnableCase.check`; the bodies are meshed coarsely."""
        self.coarse([])

    def run(self, progress: Progress = lambda _: None) -> SpatialRun:
        """See `RunnableCase.run`; the meshes are fine at the patch."""
        start = time.perf_counter()
        notices: list[str] = []
        progress("meshing the bodies")
        bodies = self.coarse(notices)
        force = None if self.force_kN is None else 1e3 * self.force_kN
        grid = self._grid(bodies, force)
        fine = [self._body(number, [], self._along(grid, bodies, number)) for number in (0, 1)]
        meshed = time.perf_counter()
        contact = press_patch(
            fine[0],
            fine[1],
            force=force,
            approach=self.approach_mm,
            grid=None if self.cell_mm is None else self._grid(fine, force),
            tolerance=self.tolerance,
            progress=progress,
            cache=Cache.of_user(),
        )
        pressed = time.perf_counter()
        lower, upper = (patch_stresses(contact, which, progress=progress) for which in (0, 1))
        patch = contact.patches[0]
        cell = min(contact.pair.grid.strip, float(contact.pair.grid.widths.min()))
        depths: Floats = np.geomspace(0.25 * cell, DEPTHS * patch.semi_axes[0], 120)
        profiles = depth_profile(lower, patch, depths), depth_profile(upper, patch, depths)
        timings = {"meshing": meshed - start, "contact": pressed - meshed, "total": time.perf_counter() - start}
        return SpatialRun(self, timings, contact, (lower, upper), profiles, notices)

    def coarse(self, notices: list[str]) -> list[PatchBody]:
        """Bodies as they are without refinement at the patch, after all inputs are checked."""
        return [self._body(number, notices) for number in (0, 1)]

    def _grid(self, bodies: Sequence[PatchBody], force: float | None) -> PatchGrid:
        if self.cell_mm is not None and self.window_mm is not None:
            return grid_about(bodies[0], bodies[1], self.cell_mm, self.window_mm)
        return grid_of(bodies[0], bodies[1], force=force, approach=self.approach_mm)

    def _along(self, grid: PatchGrid, bodies: Sequence[PatchBody], number: int) -> FineTable | None:
        """Refinement along a body's surface in the window."""
        table, size = self.bodies[number], TRIANGLES_PER_CELL * min(float(grid.widths.min()), 2.0 * grid.strip)
        if table.file is not None and not bodies[number].curve:
            return None
        beyond = FINE_MESH_MARGIN * float(np.ptp(grid.bounds))
        stations: Floats = np.linspace(grid.bounds[0] - beyond, grid.bounds[-1] + beyond, 2 * len(grid.bounds))
        points, normals = points_along(bodies[0].chain, np.clip(stations, 0.0, bodies[0].length))
        if number == 1:
            distances, _ = cast(points, normals, bodies[1].chain)
            points = points + np.where(np.isfinite(distances), distances, 0.0)[:, None] * normals
        back = Placement(np.deg2rad(table.rotation_deg), table.shift_mm).inverse()
        return FineTable(
            edges=None, at_mm=[(float(x), float(y)) for x, y in back.points(points)], size_mm=size, growth=0.2
        )

    def _body(self, number: int, notices: list[str], fine: FineTable | None = None) -> PatchBody:
        table, key = self.bodies[number], f"bodies[{number + 1}]"
        if fine is not None:
            table = table.model_copy(update={"fine": [*table.fine, fine]})
        shape = body_shape(table, key, notices)
        mesh, supports = shape.mesh, {}
        for name, given in (("held_edges", table.held_edges), ("foundation_edges", table.foundation_edges)):
            if given is not None:
                supports[name] = f"{key}.{name}"
                mesh = mesh.with_edge_set(f"{key}.{name}", np.vstack([mesh.edge_set(edges) for edges in listed(given)]))
        names = listed(table.contact_edges)
        chain = mesh.chain(*names).astype(np.int64)
        problem = Harmonic(
            Elasticity(Space(mesh, table.element(mesh)), table.material("plane-strain"), name=table.name),
            held={supports["held_edges"]: table.hold} if "held_edges" in supports else None,
            foundations=[Foundation(supports["foundation_edges"], *table.foundation_N_mm3)]
            if table.foundation_N_mm3 is not None
            else [],
        )
        return PatchBody(
            problem,
            np.stack((chain[:-1], chain[1:]), axis=1),
            shape.curve(names, mesh.points[chain]),
            axis=_axis(table),
        )


def _axis(table: SpatialBodyTable) -> Axis | None:
    if table.axis_mm is None:
        return None
    angle = np.deg2rad(table.axis_rotation_deg)
    return Axis(table.axis_mm, (float(np.cos(angle)), float(np.sin(angle))), float(np.deg2rad(table.yaw_deg)))


# --- Contacts in three dimensions that machines have: a crane wheel on a rail, a roller on a race, crossed cylinders.


class SpatialPreset(PresetCase):
    """Two steel bodies with a few inputs, pressed together by a force."""

    young_MPa: Positive = 210e3
    """Young's modulus of both bodies"""
    poisson: PoissonRatio = 0.3
    """Poisson's ratio of both bodies"""
    method: Literal["fem", "vem"] = "fem"
    """fem is triangles, vem is polygons with virtual elements"""
    order: ElementOrder = 2
    """order of the elements"""
    force_kN: Positive
    """pressing force"""

    def general(self) -> SpatialCase:
        """See `PresetCase.general`."""
        return self.filled_in(SpatialCase)


def _refuse_narrow_crown(radius: float, width: float) -> None:
    """Refuse a crown whose radius is not more than half of the block's width."""
    if radius < 0.51 * width:
        raise InputError(
            f"a crown radius of {radius:g} mm on a width of {width:g} mm",
            "more than half the width",
            "make it larger",
        )


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
    yaw_deg: Annotated[float, at.Ge(-5.0), at.Le(5.0)] = 0.0
    """skew of the wheel"""

    def general(self) -> SpatialCase:
        """See `PresetCase.general`."""
        _refuse_narrow_crown(self.crown_radius_mm, self.tread_width_mm)
        return super().general()


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

    def general(self) -> SpatialCase:
        """See `PresetCase.general`."""
        if self.race == "outer" and self.race_radius_mm <= self.roller_radius_mm:
            raise InputError(
                f"race_radius_mm = {self.race_radius_mm:g} of an outer race",
                f"more than roller_radius_mm = {self.roller_radius_mm:g}",
                "make the race larger",
            )
        _refuse_narrow_crown(self.crown_radius_mm, self.roller_length_mm)
        return super().general()


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
    angle_deg: Annotated[float, at.Ge(45.0), at.Le(90.0)] = 90.0
    """angle between both axes"""
