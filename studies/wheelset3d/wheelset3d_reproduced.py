"""The wheelset in three dimensions: what ``flangeway reproduce wheelset3d`` computes."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from studies.published_numbers import Reproduced, Row
from studies.spatial.profile_blocks import pressed_profiles, profile_numbers
from studies.wheelset3d.element_methods import (
    DIRECT,
    MethodRun,
    direct_numbers,
    method_numbers,
    method_runs,
)
from studies.wheelset3d.manchester import BenchmarkPosition, benchmark_numbers, benchmark_positions


@dataclass(frozen=True, eq=False, kw_only=True)
class Wheelset3dReproduction(Reproduced):
    """Wheels on rails in three dimensions beside other programs, and beside themselves on other meshes.

    Parameters
    ----------
    positions
        The Manchester benchmark.
    runs
        Tangent and curve by all kinds of elements.

    """

    positions: tuple[BenchmarkPosition, ...]
    runs: tuple[MethodRun, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """Wheelsets that found no equilibrium."""
        return tuple(
            f"{run.situation}, {run.method} {run.order}: {run.result.status.message}"
            for run in self.runs
            if not run.result.status.converged
        )


def reproduce_wheelset3d(
    *, quick: bool = False, progress: Callable[[str], None] = lambda _: None
) -> Wheelset3dReproduction:
    """Compute all parts; if `quick`, every fifth position of the benchmark, and elements of order 2 only."""
    start = time.perf_counter()
    positions = tuple(benchmark_positions(quick=quick, progress=progress))
    numbers = [number for position in positions for number in benchmark_numbers(position)]
    runs = tuple(method_runs(quick=quick, progress=progress))
    numbers += method_numbers(list(runs))
    for name in DIRECT:
        progress(name)
        numbers += direct_numbers(name)
    progress("one position beside CalculiX")
    numbers += profile_numbers(pressed_profiles())
    return Wheelset3dReproduction(
        positions=positions, runs=runs, numbers=tuple(numbers), seconds=time.perf_counter() - start
    )


def positions_table(found: Wheelset3dReproduction) -> list[Row]:
    """Rows of ``manchester.csv``."""
    return [
        {f"{name}_published": value for name, value in each.published.items()}
        | {
            "p0": each.real.patches[0].max_pressure,
            "p0_half_spaces": each.half_spaces.patches[0].max_pressure,
            "normal_force": each.real.normal_force,
            "wheel_y": -each.real.interpenetration_mm,
            "wheel_y_pressure": -each.real.centre_of_pressure_mm,
            "z": -each.real.position.vertical_mm,
            "z_half_spaces": -each.half_spaces.position.vertical_mm,
            "patches": len(each.real.patches),
        }
        for each in found.positions
    ]


def patches_table(found: Wheelset3dReproduction) -> list[Row]:
    """Rows of ``patches.csv``."""
    return [
        {
            "situation": run.situation,
            "method": run.method,
            "order": run.order,
            "side": patch.side,
            "region": patch.region,
            "force": float(np.hypot(*patch.force_on_wheel_N)),
            "contact_angle": patch.contact_angle_rad,
            "p0": patch.ellipse.max_pressure,
            "longer_semi_axis": patch.ellipse.semi_axes[0],
            "shorter_semi_axis": patch.ellipse.semi_axes[1],
        }
        for run in found.runs
        for patch in run.result.patches
    ]
