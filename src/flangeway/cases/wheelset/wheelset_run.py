"""What a run of a wheelset found, in three dimensions or in the plane: results, ``summary.json``."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from flangeway.cases.summary import RunResult
from flangeway.cases.wheelset.wheelset_notes import side_warnings, unusual
from flangeway.cases.wheelset.wheelset_quantities import (
    HEAD,
    LOAD,
    MESH,
    NADAL,
    PATCH,
    PLANE_PATCH,
    POSITION,
    RESIDUAL,
    ROLLING,
    TRACK,
    WHEEL,
    AnyPatch,
    AnyResult,
    WheelResult,
    patch_name,
)
from flangeway.quantities import Quantity, values
from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.plane_wheelset import WheelsetResult
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.solve import Status

if TYPE_CHECKING:
    from flangeway.cases.wheelset.wheelset_case import Wheelset


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
    def in_space(self) -> SpatialResult | None:
        """The solution in three dimensions; None of a plane wheelset."""
        return self.result if isinstance(self.result, SpatialResult) else None

    @property
    def space(self) -> SpatialResult:
        """The solution of a wheelset in three dimensions."""
        assert isinstance(self.result, SpatialResult)
        return self.result

    @property
    def plane(self) -> WheelsetResult:
        """The solution of a plane wheelset."""
        assert isinstance(self.result, WheelsetResult)
        return self.result

    @property
    def patches(self) -> Sequence[AnyPatch]:
        """The contact patches, left side first."""
        return self.result.patches

    @cached_property
    def wheels(self) -> list[WheelResult]:
        """The left and the right wheel."""
        return [
            WheelResult(self.result, side, [patch for patch in self.patches if patch.side == side]) for side in SIDES
        ]

    @property
    def patch_names(self) -> list[str]:
        """Names of the patches."""
        return [patch_name(patch) for patch in self.result.patches]

    @property
    def patch_quantities(self) -> Sequence[Quantity[Any]]:
        """Numbers of its patches."""
        return PLANE_PATCH if self.in_space is None else PATCH

    @property
    def wheel_quantities(self) -> Sequence[Quantity[WheelResult]]:
        """Numbers of its wheels."""
        space = self.in_space
        return WHEEL if space is None else (*WHEEL, *HEAD, *(NADAL if space.rolling else ()))

    @property
    def warnings(self) -> list[str]:
        """What limits the results."""
        return [*unusual(self.case), *self.result.warnings, *side_warnings(self.problem.track)]

    def parts(self) -> dict[str, Any]:
        """See `RunResult.parts`."""
        result, space = self.result, self.in_space
        content: dict[str, Any] = {
            "position": values(POSITION, result),
            "track": values(TRACK, self.problem.track),
            "load": values(LOAD, self.problem.forces),
            "residual": values(RESIDUAL, result.equilibrium.residuals),
            "sides": [{"side": wheel.side, **values(self.wheel_quantities, wheel)} for wheel in self.wheels],
            "patches": [values(self.patch_quantities, patch) for patch in self.patches],
        }
        if space is not None:
            content["rolling"] = values(ROLLING, space) if space.rolling else None
        elif isinstance(result, WheelsetResult):
            content["bodies"] = [values(MESH, body) for body in result.model.bodies]
        return content | {"assumptions": self.case.assumptions(result), "warnings": self.warnings}
