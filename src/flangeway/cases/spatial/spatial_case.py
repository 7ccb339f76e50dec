"""The case of two bodies in contact in three dimensions: prisms and bodies of revolution by their sections."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from pydantic import Field

from flangeway.cases.bodies.bodies_model import elements_of
from flangeway.cases.bodies.bodies_shape import body_shape
from flangeway.cases.bodies.bodies_tables import BodyTable, FineTable, elastic
from flangeway.cases.case import Case, Pair, Positive, Progress, RunnableCase, example_of
from flangeway.cases.spatial.spatial_quantities import BODY, CONTACT, PATCH, SpatialBodyResult, SpatialPatchResult
from flangeway.cases.summary import RunResult
from flangeway.contact.patch.patch_body import Axis, PatchBody, cast, points_along
from flangeway.contact.patch.patch_contact import PatchContact, press_patch
from flangeway.contact.patch.patch_grid import PatchGrid, grid_about, grid_of
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.post.patch_stresses import DepthProfile, SectionStresses, depth_profile, patch_stresses
from flangeway.problems import Elasticity, Foundation, Harmonic
from flangeway.quantities import values
from flangeway.solve import Status
from flangeway.space import Space
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

# ruff: noqa: N815 (units in names)

FINER = 0.85
"""Size of triangles over that of the cells: Gmsh makes some edges longer."""
BEYOND = 0.15
"""Length of the finer mesh beyond the window on each side, over the window."""
DEPTHS = 3.0
"""Depth of the profiles over the longer semi-axis."""


class SpatialBodyTable(BodyTable):
    """A prism along z, or a body of revolution, by its section in the plane z = 0."""

    contact_edges: str | list[str]
    """edge sets of its contact surface, one chain"""
    held_edges: str | list[str] | None = None
    """edge sets that are held"""
    hold: str = Field("xyz", pattern="^[xyz]+$")
    """held components, some of x, y, z"""
    foundation_edges: str | list[str] | None = None
    """edge sets on an elastic foundation"""
    foundation_N_mm3: tuple[float, float, float] | None = Field(None, strict=False)
    """pressure per displacement of the foundation along x, y and z"""
    axis_mm: Pair | None = None
    """a point of the axis of a body of revolution (default: a prism)"""
    axis_rotation_deg: float = 0.0
    """angle of the axis from x, counter-clockwise"""
    yaw_deg: float = Field(0.0, ge=-45.0, le=45.0)
    """rotation of the axis about y, from x towards z"""


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

    @cached_property
    def patches(self) -> list[SpatialPatchResult]:
        """The patches by falling force."""
        return [SpatialPatchResult(self.contact, ellipse) for ellipse in self.contact.patches]

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
    tolerance: float = Field(1e-3, gt=0.0, le=0.1)
    """interpolation error of the compliances"""
    bodies: list[SpatialBodyTable] = Field(min_length=2, max_length=2)
    """the lower body, then the upper one"""

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
        if (self.force_kN is None) == (self.approach_mm is None):
            both = "force_kN and approach_mm" if self.force_kN is not None else "neither force_kN nor approach_mm"
            raise InputError(f"{both}", "one of them", "give the force, or the approach")
        if (self.cell_mm is None) != (self.window_mm is None):
            raise InputError("one of cell_mm and window_mm", "both or none", "give both, or leave both out")
        return [self._body(number, notices) for number in (0, 1)]

    def _grid(self, bodies: Sequence[PatchBody], force: float | None) -> PatchGrid:
        if self.cell_mm is not None and self.window_mm is not None:
            return grid_about(bodies[0], bodies[1], self.cell_mm, self.window_mm)
        return grid_of(bodies[0], bodies[1], force=force, approach=self.approach_mm)

    def _along(self, grid: PatchGrid, bodies: Sequence[PatchBody], number: int) -> FineTable | None:
        """Refinement along a body's surface in the window."""
        table, size = self.bodies[number], FINER * min(float(grid.widths.min()), 2.0 * grid.strip)
        if table.file is not None and not bodies[number].curve:
            return None
        beyond = BEYOND * float(np.ptp(grid.bounds))
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
                mesh = mesh.with_edge_set(f"{key}.{name}", np.vstack([mesh.edge_set(edges) for edges in _list(given)]))
        if (table.foundation_edges is None) != (table.foundation_N_mm3 is None):
            raise InputError(f"{key} with one of foundation_edges and foundation_N_mm3", "both or none", "give both")
        names = _list(table.contact_edges)
        chain = mesh.chain(*names).astype(np.int64)
        material = {name: elastic(material, "plane-strain") for name, material in table.materials.items()}
        problem = Harmonic(
            Elasticity(
                Space(mesh, elements_of(table)),
                material or elastic(table, "plane-strain"),
                name=table.name,
            ),
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


def _list(names: str | list[str]) -> list[str]:
    return [names] if isinstance(names, str) else names
