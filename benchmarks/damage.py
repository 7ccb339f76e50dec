"""Wear and fatigue: eleven free states with friction, on new profiles and later, and repeated rolling with plasticity.

Times are those of the processor, on one core, with the tables of the bodies in the cache.

- The step is one of the bundled mixed line: S1002 on 60E1, 160 kN, exact theory, 26 cells across a patch. Its accuracy
  is the largest difference between the area on a profile and that of its cells over the latter. Asked: 8 s. Later ones,
  which begin where the wheelsets rolled on the profiles before, are the mean of the two evaluations of a short step.
- Repeated rolling is that of a line contact until it has settled at p0 / k = 3.95 and 4.05 without friction, on both
  sides of Melan's limit of 4, with 12 cells over the half width. Its accuracy is the share of wrong verdicts.
"""

import time
from collections.abc import Iterator

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.railway.damage.collective import COLLECTIVES, Collective, RunningState, parts_of
from flangeway.railway.damage.evolution import Evolution, EvolutionSettings
from flangeway.railway.damage.rolling_plasticity import RollingLine, RollingSteel
from flangeway.railway.damage.wear_laws import UsfdLaw, row_wear
from flangeway.railway.damage.worn_surface import WornSurface
from flangeway.railway.wheelset.spatial_result import solve_spatial
from flangeway.records import with_settings

ASKED_STEP_S = 8.0
STEP_KM = 300.0
"""Length of the step after the one on new profiles."""
VERDICTS = {3.95: "shakedown", 4.05: "ratchetting"}
SHARED = {"load.axle_load_kN": 160.0, "rolling.yaw_stiffness_kNm_per_mrad": 10.0}


def measurements() -> Iterator[Measurement]:
    """The step, and both loads."""
    yield _step()
    yield _plasticity(12)


def quick() -> Iterator[Measurement]:
    """Repeated rolling on a coarse mesh."""
    yield _plasticity(6)


def collective() -> Collective:
    """The bundled mixed line."""
    states = []
    for each in [part for state in COLLECTIVES["mixed-line"] for part in parts_of(state)]:
        name, share = each.pop("name"), each.pop("share")
        case = Wheelset.from_values(with_settings(Wheelset, {}, SHARED | each))
        states.append(RunningState(name, share, case))
    return Collective(states)


def _step() -> Measurement:
    states, times = collective(), list[float]()
    evolution = Evolution(states, {"wheel": UsfdLaw()}, EvolutionSettings(end=STEP_KM))
    first, number = states.states[-1], len(states.states)
    result = solve_spatial(first.problem)
    errors = []
    for row in row_wear(result, {"wheel": UsfdLaw()}):
        surface = WornSurface(first.problem.wheelset.wheel_of("right"))
        depth = surface.deposited(row.ends, row.areas)
        errors.append(abs(float((depth * surface.worn_lengths).sum() / row.areas.sum()) - 1.0))
    steps = evolution.run(progress=lambda _: times.append(time.process_time()))
    new, later = times[number] - times[0], (time.process_time() - times[number]) / (len(times) / number - 1.0)
    unconverged = sum(len(step.unconverged) for step in steps)
    more = {"states": number, "unconverged": unconverged, "asked_s": ASKED_STEP_S, "later_s": later}
    return Measurement("step of a mixed line", NO_PEER, new, None, max(errors), None, more=more)


def _plasticity(cells: int) -> Measurement:
    begun = time.process_time()
    steel = RollingSteel(shear_yield_MPa=300.0)
    found = {
        factor: RollingLine(load_factor=factor, friction=0.0, steel=steel, cells=cells, depth=1.0).repeated()
        for factor in VERDICTS
    }
    wrong = np.mean([found[factor].state != state for factor, state in VERDICTS.items()])
    more = {
        "passages": [len(each.newton) for each in found.values()],
        "newton": max(map(max, (e.newton for e in found.values()))),
    }
    seconds = time.process_time() - begun
    return Measurement(f"repeated rolling, {cells} cells", NO_PEER, seconds, None, float(wrong), None, more=more)
