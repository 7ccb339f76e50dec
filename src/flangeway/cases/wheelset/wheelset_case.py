"""The case of a wheelset on two rails."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from flangeway.cases.case import RunnableCase
from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.wheelset_notes import derived, side_warnings, unusual
from flangeway.cases.wheelset.wheelset_quantities import (
    APPROACH,
    CREEP_MAIN,
    GAUGE,
    GAUGE_DEPTH,
    HEAD,
    LATERAL,
    LATERAL_UNCERTAINTY,
    LOAD,
    MESH,
    MOTION,
    NADAL,
    PATCH,
    PLANE_FURTHER,
    PLANE_MAIN,
    PLANE_PATCH,
    PLANE_PATCH_ROW,
    PLANE_ROW,
    POSITION,
    RATIO,
    RESIDUAL,
    ROLLING,
    ROLLING_PATCH_ROW,
    ROLLING_ROW,
    SPATIAL_FURTHER,
    SPATIAL_MAIN,
    SPATIAL_PATCH_ROW,
    SPATIAL_ROW,
    TRACK,
    WHEEL,
    AnyPatch,
    AnyResult,
    SpatialWheelResult,
    WheelResult,
    patch_name,
    row_columns,
)
from flangeway.contact.patch.patch_contact import MAX_PARABOLOID_DISTANCE
from flangeway.contact.rolling.fast_theories import Theory
from flangeway.errors import InputError, located
from flangeway.quantities import Quantity, column_names, numbers, present, values
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.track.wheelset_problem import Plane, WheelsetProblem
from flangeway.railway.wheelset.plane_wheelset import PlaneWheelset, WheelsetResult, solve_condensed, solve_wheelset
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_result import SpatialResult, solve_position, solve_spatial
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheelset_model import build_model
from flangeway.solve import Status
from flangeway.system.disk_cache import Cache
from flangeway.system.templates import sentences
from flangeway.types import Progress

# --- What a run found, in three dimensions or in the plane.


class ShownQuantities(NamedTuple):
    """Numbers in the tables of a report: of position, wheels and patches with the results, and further ones."""

    position: Sequence[Quantity[Any]]
    wheels: Sequence[Quantity[Any]]
    patches: Sequence[Quantity[Any]]
    further_position: Sequence[Quantity[Any]]
    further_patches: Sequence[Quantity[Any]]


@dataclass(frozen=True, eq=False)
class WheelsetRun(RunResult):
    """A case of a wheelset and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    result
        The solution.
    total_s
        Wall-clock time of the computation in seconds.

    """

    main_table = "patches"

    case: "Wheelset"
    result: AnyResult
    total_s: float

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.result.status

    @property
    def timings_s(self) -> dict[str, float]:
        """Seconds by stage."""
        return {name.replace("-", "_"): s for name, s in self.result.timings_s.items()} | {"total": self.total_s}

    @property
    def problem(self) -> WheelsetProblem:
        """Wheelset, track and load."""
        return self.result.problem

    @property
    def patches(self) -> Sequence[AnyPatch]:
        """The contact patches, left side first."""
        return self.result.patches

    @cached_property
    def wheels(self) -> Sequence[WheelResult]:
        """The left and the right wheel."""
        return [WheelResult(self.result, side, self.patches_of(side)) for side in SIDES]

    def patches_of(self, side: Side) -> list[Any]:
        """The contact patches of a side."""
        return [patch for patch in self.patches if patch.side == side]

    @property
    def patch_names(self) -> list[str]:
        """Names of the patches."""
        return [patch_name(patch) for patch in self.result.patches]

    @property
    def patch_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of its patches."""
        raise NotImplementedError

    @property
    def wheel_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of its wheels."""
        raise NotImplementedError

    @property
    def shown(self) -> ShownQuantities:
        """Numbers in the tables of its report."""
        raise NotImplementedError

    def further_parts(self) -> dict[str, Any]:
        """What the summary of this kind of result has besides."""
        raise NotImplementedError

    @property
    def warnings(self) -> list[str]:
        """What limits the results."""
        return [*unusual(self.case), *self.result.warnings, *side_warnings(self.problem.track)]

    def parts(self) -> dict[str, Any]:
        """See `RunResult.parts`."""
        result = self.result
        content: dict[str, Any] = {
            "position": values(POSITION, result),
            "track": values(TRACK, self.problem.track),
            "load": values(LOAD, self.problem.forces),
            "residual": values(RESIDUAL, result.equilibrium.residuals),
            "sides": [{"side": wheel.side, **values(self.wheel_quantities, wheel)} for wheel in self.wheels],
            "patches": [values(self.patch_quantities, patch) for patch in self.patches],
        }
        content |= self.further_parts()
        return content | {"assumptions": self.case.assumptions(result), "warnings": self.warnings}


class PlaneWheelsetRun(WheelsetRun):
    """A plane wheelset."""

    result: WheelsetResult
    patch_quantities = PLANE_PATCH
    wheel_quantities = WHEEL
    shown = ShownQuantities(
        (LATERAL, APPROACH), (RATIO, GAUGE_DEPTH), PLANE_MAIN, (*MOTION[1:], APPROACH), PLANE_FURTHER
    )

    def further_parts(self) -> dict[str, Any]:
        """Meshes of the bodies."""
        return {"bodies": [values(MESH, body) for body in self.result.model.bodies]}


class SpatialWheelsetRun(WheelsetRun):
    """A wheelset in three dimensions."""

    result: SpatialResult
    patch_quantities = PATCH

    @cached_property
    def wheels(self) -> Sequence[SpatialWheelResult]:
        """The left and the right wheel."""
        return [SpatialWheelResult(self.result, side, self.patches_of(side)) for side in SIDES]

    @property
    def wheel_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of its wheels."""
        return (*WHEEL, *HEAD, *(NADAL if self.result.rolling else ()))

    @property
    def shown(self) -> ShownQuantities:
        """Numbers in the tables of its report, of creep where it rolls."""
        creep, nadal = (CREEP_MAIN, NADAL) if self.result.rolling else ((), ())
        return ShownQuantities(
            position=[LATERAL, *present([LATERAL_UNCERTAINTY], self.result), *MOTION[1:]],
            wheels=[RATIO, *nadal, GAUGE, GAUGE_DEPTH],
            patches=[*SPATIAL_MAIN, *creep],
            further_position=[APPROACH],
            further_patches=SPATIAL_FURTHER,
        )

    def further_parts(self) -> dict[str, Any]:
        """How it rolls."""
        return {"rolling": values(ROLLING, self.result) if self.result.rolling else None}


AnyWheelsetRun = PlaneWheelsetRun | SpatialWheelsetRun


# --- The case.


THEORIES: dict[Theory, str] = {
    "exact": "the exact theory on the bodies",
    "fastsim": "FASTSIM",
    "fastrip": "FaStrip",
    "polach": "Polach's formula",
    "linear": "linear theory",
}
MIN_TOGETHER = 12
"""Positions of the same plane bodies from which on these are prepared for many positions."""


class Wheelset(WheelsetProblem, RunnableCase):
    """A wheelset on two rails: the tree of its inputs is the case file, and what the solver takes."""

    name = "wheelset"
    title = "A wheelset on two rails"
    essential = (
        *("track.rail", "track.gauge_mm", "track.inclination", "wheelset.wheel", "wheelset.radius_mm"),
        *("load.axle_load_kN", "position.yaw_mrad"),
    )
    position_keys = ("position", "load", "rolling")

    def check(self) -> None:
        """See `RunnableCase.check`: profiles are read, and wheels fit their rails."""
        _ = self.wheels
        for side in SIDES:
            self.track.gauge_point(side)
        self.check_position()

    def check_position(self) -> None:
        """See `RunnableCase.check_position`: friction falls from a static value above the kinetic one."""
        if self.rolling is not None and self.friction is not None:
            with located("rolling.falling.kinetic: "):
                for side in SIDES:
                    self.rolling.law(self.friction_of(side))

    def check_sections(self) -> None:
        """See `RunnableCase.check_sections`."""
        if isinstance(self.contact, Plane):
            super().check_sections()

    def run(
        self, progress: Progress = lambda _: None, *, cold: bool = False, start: SpatialWheelsetRun | None = None
    ) -> AnyWheelsetRun:
        """See `RunnableCase.run`.

        - `cold`: compute everything without the user's cache.
        - `start`: run of a similar wheelset in three dimensions, from whose place the search begins: fewer iterations
          to the same equilibrium. An `InputError` in a plane.
        """
        begun = time.perf_counter()
        if not isinstance(self.contact, Plane):
            result = solve_spatial(self, progress=progress, cold=cold, start=None if start is None else start.result)
            return SpatialWheelsetRun(self, result, time.perf_counter() - begun)
        if start is not None:
            raise InputError("a start with contact.kind = plane", "contact.kind = spatial", "leave start out")
        plane = solve_wheelset(self, progress=progress, cold=cold)
        return PlaneWheelsetRun(self, plane, time.perf_counter() - begun)

    solve = run

    @property
    def min_together(self) -> int:
        """See `RunnableCase.min_together`: in three dimensions the bodies are most of the work of one position too."""
        return MIN_TOGETHER if isinstance(self.contact, Plane) else 1

    def prepared(self, progress: Progress = lambda _: None) -> PlaneWheelset | SpatialWheelset:
        """See `RunnableCase.prepared`."""
        cache = Cache.of_user()
        if not isinstance(self.contact, Plane):
            return SpatialWheelset(self, running_surfaces(self, cache=cache, progress=progress))
        # in the middle of level track, which rigid wheels can always reach
        middle = WheelsetProblem(
            track=self.track, wheelset=self.wheelset, material=self.material, contact=self.contact, mesh=self.mesh,
            load=self.load.replaced(lateral_force_kN=0.0, superelevation_mm=0.0, offset_mm=0.0, curve=None),
        )  # fmt: skip
        return PlaneWheelset.of(build_model(middle, whole=True, cache=cache), cache=cache)

    def run_on(self, bodies: Any, progress: Progress = lambda _: None) -> AnyWheelsetRun:
        """See `RunnableCase.run_on`."""
        start, placed = time.perf_counter(), bodies.at(self)
        if isinstance(self.contact, Plane):
            return PlaneWheelsetRun(self, solve_condensed(placed, progress), time.perf_counter() - start)
        return SpatialWheelsetRun(self, solve_position(placed, {}, progress), time.perf_counter() - start)

    # --- Rows of campaigns.

    @property
    def row_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of a wheel in a row of a campaign."""
        spatial = ROLLING_ROW if self.friction else SPATIAL_ROW
        return PLANE_ROW if isinstance(self.contact, Plane) else spatial

    @property
    def patch_row_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of a patch in the table of patches of a campaign."""
        spatial = ROLLING_PATCH_ROW if self.friction else SPATIAL_PATCH_ROW
        return PLANE_PATCH_ROW if isinstance(self.contact, Plane) else spatial

    def columns(self) -> tuple[str, ...]:
        """See `RunnableCase.columns`."""
        return row_columns(self.row_quantities)

    def patch_columns(self) -> tuple[str, ...]:
        """See `RunnableCase.patch_columns`."""
        return tuple(column_names(self.patch_row_quantities))

    def row(self, run: Any) -> dict[str, Any]:
        """See `RunnableCase.row`: position, and of each side the sums over its patches, and the most loaded one."""
        wheels = [number for result in run.wheels for number in numbers(self.row_quantities, result)]
        return dict(zip(self.columns(), [*numbers(MOTION, run.result), *wheels], strict=True))

    def patch_rows(self, run: Any) -> list[dict[str, Any]]:
        """See `RunnableCase.patch_rows`: on each side from the field to the gauge."""
        rows = []
        for result in run.wheels:
            ordered = sorted(result.patches, key=lambda patch: -float(patch.rail_point_mm[0]))
            for number, patch in enumerate(ordered, 1):
                row = dict(zip(self.patch_columns(), numbers(self.patch_row_quantities, patch), strict=True))
                rows.append({"side": result.side, "number": number} | row)
        return rows

    def warnings_of(self, run: Any) -> list[str]:
        """See `RunnableCase.warnings_of`."""
        return list(run.warnings)

    # --- What a solution rests on, in sentences.

    def assumptions(self, result: Any) -> list[str]:
        """Return in sentences what a solution rests on."""
        return sentences(
            "flangeway.cases.wheelset",
            "assumptions.txt",
            case=self,
            result=result,
            derived=derived(self),
            frictions=dict.fromkeys(self.friction_of(side) for side in SIDES) if self.friction else (),
            theory=THEORIES[self.friction.theory] if self.friction else "",
            distance=MAX_PARABOLOID_DISTANCE,
            supports=dict.fromkeys(self.track.support_of(side) for side in SIDES),
        )
