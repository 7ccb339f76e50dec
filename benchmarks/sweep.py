"""Wheelsets in three dimensions moved sideways in small steps: noise, convergence, and the balance of energy.

Noise of a number is what its value differs from the closest of three predictions by its neighbours: by the cubic
through two on each side, or by the parabola through three on one side, which is right beside a kink, as where a patch
appears. Of each side that of the maximum pressure and the area of its most loaded patch is reported.

Of all bundled pairs without friction on a rigid axle, from the middle of the track until the flange climbs or takes
60 kN: positions that do not converge, and the work that holds the wheelset sideways beside the change of elastic and
potential energy.
"""

import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement
from benchmarks.worn import worn_pair
from flangeway.cases import Wheelset, load_case
from flangeway.railway.profiles.bundled import RAILS, REFERENCE_WHEELS, WHEELS
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.side_contact import SideState
from flangeway.railway.wheelset.spatial_result import SpatialResult, solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheelset_newton import SpatialState
from flangeway.system.disk_cache import Cache
from flangeway.types import Floats

STEP_MM, QUICK_STEP_MM = 0.05, 0.4
SWEEPS = {
    "one patch, S1002 on 60E1": ({}, (0.8, 2.0)),
    "flange contact and two patches, S1002 on 60E1": ({}, (5.9, 6.8)),
    "conforming, AAR-1B on 60E1": ({"wheel": "AAR-1B", "rail": "60E1"}, (2.6, 3.6)),
}
WORN_MM = (-0.6, 0.6)
ASKED_NOISE, ASKED_ENERGY = 3e-3, 1e-3
MAX_FORCE_N, FARTHEST_MM, ENERGY_STEP_MM = 60e3, 12.0, 0.25
"""Lateral force and position up to which the balance of energy is followed, and steps for it."""


def wheelset_of(values: dict[str, Any]) -> SpatialWheelset:
    """Wheelset of a case with its running surfaces."""
    case = load_case("wheelset", **values)
    assert isinstance(case, Wheelset)
    return SpatialWheelset(case, running_surfaces(case, cache=Cache.of_user()))


def moved_to(wheelset: SpatialWheelset, lateral_mm: float) -> SpatialResult:
    """The wheelset at a lateral position."""
    return solve_position(wheelset.at(wheelset.problem.replaced(position={"lateral_mm": lateral_mm})), {})


def noise(values: Floats) -> Floats:
    """Relative noise of values (n, m) at even steps, from the fourth to the fourth from the end, (n - 6, m)."""
    by = {shift: values[3 + shift : len(values) - 3 + shift] for shift in range(-3, 4)}
    predictions = [
        (4.0 * (by[-1] + by[1]) - by[-2] - by[2]) / 6.0,
        3.0 * by[-1] - 3.0 * by[-2] + by[-3],
        3.0 * by[1] - 3.0 * by[2] + by[3],
    ]
    return np.asarray(np.min([np.abs(each - by[0]) for each in predictions], axis=0) / np.abs(by[0]))


def pressures_and_areas(results: list[SpatialResult]) -> Floats:
    """Maximum pressure and area of the most loaded patch of each side, (n, 4)."""
    rows = []
    for result in results:
        assert result.status.converged, result.status.message
        first = [next(p for p in result.patches if p.side == side) for side in ("left", "right")]
        rows.append([*(patch.max_pressure for patch in first), *(patch.area for patch in first)])
    return np.array(rows)


def _noise(name: str, values: dict[str, Any], ends: tuple[float, float], step: float) -> Measurement:
    wheelset = wheelset_of(values)
    laterals = np.arange(ends[0], ends[1] + step / 2.0, step)
    start = time.process_time()
    numbers = pressures_and_areas([moved_to(wheelset, lateral) for lateral in laterals.tolist()])
    seconds = (time.process_time() - start) / len(laterals)
    found = noise(numbers).max(axis=0)
    return Measurement(
        f"noise of {len(laterals)} steps of {step:g} mm: {name}", NO_PEER, seconds, None, float(found.max()), None,
        "seconds of processor of a position; maximum noise",
        more={"pressure": float(found[:2].max()), "area": float(found[2:].max()), "asked_noise": ASKED_NOISE},
    )  # fmt: skip


@dataclass(frozen=True)
class EnergySweep:
    """Positions of a sweep: how far it went, what did not converge, and the error of the balance of energy.

    - `error`: maximum of work less change of energy, over the energy that was put in up to the last position.
    """

    last_mm: float
    failures: list[str]
    error: float


def elastic_energy(state: SideState) -> float:
    """Elastic energy of a wheel and its rail without friction, N mm.

    ``1/2 f A f`` of the forces along the undeformed normals N, and what their shares s along the tangents T add:
    ``-(p N + s T / 2) . B' s`` with the displacements B' of the rail less those of the wheel.
    """
    grid, forces = state.grid, state.forces
    row = forces.sum(axis=1)
    _, shares = grid.turned(row, np.zeros_like(row))
    tangents, normals = grid.frames[:, 0, :2], grid.frames[:, 1, :2]
    along = row[:, None] * normals + 0.5 * shares[:, None] * tangents
    by_shares = float((along * (grid.bending_across @ shares)).sum())
    return 0.5 * float((forces * grid.influence(forces)).sum()) - by_shares


def energy_of(result: SpatialResult) -> float:
    """Elastic energy of wheels and rails and potential energy of the load, N mm."""
    equilibrium: Equilibrium[SpatialState] = result.equilibrium
    elastic = sum(elastic_energy(state) for state in equilibrium.state.sides.values())
    forces = result.problem.forces
    (along, onto), (x, y, roll) = forces.in_track, equilibrium.position.components
    height = forces.height_mm
    return elastic + float(onto * (y + height * np.cos(roll)) - along * (x - height * np.sin(roll)))


def energy_sweep(
    wheelset: SpatialWheelset, step: float = ENERGY_STEP_MM, lateral: float = 0.0, farthest: float = FARTHEST_MM
) -> EnergySweep:
    """Move a wheelset on a rigid axle sideways; positions at the Gauss points of steps, for the work."""
    ends, work, failures = [energy_of(moved_to(wheelset, lateral))], [0.0], []
    nodes = step / 2.0 * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))
    while lateral < farthest:
        results = [moved_to(wheelset, lateral + float(ahead)) for ahead in (*nodes, step)]
        if any("rigid wheels stand up to" in result.status.message for result in results):  # the flange climbs
            break
        lateral += step
        failures += [f"{lateral:g} mm: {result.status.message}" for result in results if not result.status.converged]
        # what holds the wheelset is opposite to what is left of the lateral force
        work.append(work[-1] - step / 2.0 * sum(float(result.equilibrium.residual[0]) for result in results[:2]))
        ends.append(energy_of(results[-1]))
        if abs(float(results[-1].equilibrium.residual[0])) > MAX_FORCE_N:
            break
    change = np.array(ends) - ends[0]
    return EnergySweep(lateral, failures, float(np.abs(np.array(work) - change).max() / np.abs(change).max()))


def measurements() -> Iterator[Measurement]:
    """Noise in steps of 0.05 mm, and all bundled pairs."""
    yield from _noises(STEP_MM)
    pairs = [(wheel, rail) for wheel in (*WHEELS, *REFERENCE_WHEELS) for rail in RAILS]
    for wheel, rail in pairs:
        start = time.process_time()
        found = energy_sweep(wheelset_of({"wheel": wheel, "rail": rail, "axle": "rigid"}))
        yield Measurement(
            f"{wheel} on {rail} moved sideways to {found.last_mm:g} mm", NO_PEER, time.process_time() - start, None,
            found.error, None, "error of the balance of work and energy",
            more={"failures": found.failures, "asked_error": ASKED_ENERGY},
        )  # fmt: skip


def quick() -> Iterator[Measurement]:
    """Wider steps."""
    yield from _noises(QUICK_STEP_MM)


def _noises(step: float) -> Iterator[Measurement]:
    for name, (values, ends) in SWEEPS.items():
        yield _noise(name, values, ends, step)
    with tempfile.TemporaryDirectory() as folder:
        yield _noise("worn", worn_pair(Path(folder)), WORN_MM, step)
