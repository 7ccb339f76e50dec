"""Rolling with friction: the exact theory on one patch, creep curves and tables, fast theories, wheelsets, CONTACT.

Times are seconds of the processor, of all threads together, and hold on a machine that is shared, too.
The patch is an ellipse of 8 by 4 mm on n x n half-space cells, under longitudinal and lateral creepage and spin with
which about half of it slips. Cold includes the influence coefficients and starts from nothing; warm starts from the
tractions at 1 % less creepage. Accuracy is the relative error of the longitudinal force from that of grids of 60 and 90
cells, extrapolated; that of the fast theories is beside the exact one on the same cells.

Three examples of CONTACT are computed with its inputs on as many cells. Published are the processor times in the
outputs that are distributed with it (github.com/eve70a/CONTACT at d431cdb, examples/*.ref_out, "Performance timers":
open source version, revision 2707 of 23 July 2025, Windows, 2 threads). They name no processor and have one decimal, so
that no ratio is given. What they contain stands below the table.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement, best_time, timed
from flangeway.cases.wheelset.wheelset_case import Wheelset
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.exact_rolling import creep_curve, roll
from flangeway.contact.rolling.fast_theories import fastrip, fastsim, linear_theory, polach
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import Creepages, CreepForces, Rolling, RollingContact
from flangeway.materials import Elastic
from flangeway.railway.wheelset.running_surfaces import running_surfaces
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.system.disk_cache import Cache
from flangeway.tables.creep_sampling import (
    DIRECTIONS,
    SampledForces,
    SampledPatch,
    check,
    exact_forces,
    random_points,
    sample,
)
from flangeway_studies.rolling_cases import elliptic, published

CELLS, FORCE = 30, 82_000.0
MOTION = Creepages(1e-3, 5e-4, -2e-4)
POINTS = 120
ASKED_COLD_S, ASKED_WARM_S, ASKED_CURVE_S, ASKED_FASTSIM_S = 0.5, 0.1, 5.0, 1e-3
GRIDS = (20, 40, 80)
N_POINTS = 12
CLOCK = time.process_time
ASKED_WHEELSET_S = 3.0
WHEELSETS: dict[str, dict[str, Any]] = {
    "in the middle of straight track": {},
    "2 mm to the right in a curve of 800 m": {
        "position": {"lateral_mm": 2.0, "yaw_mrad": 1.0},
        "load": {"curve": {"radius_m": 800.0, "speed_km_h": 72.0}},
        "rolling": {"friction": 0.3},
    },
    "6 mm to the left, three patches": {"position": {"lateral_mm": -6.0, "yaw_mrad": 1.0}},
    "on narrow gauge, four patches": {"track": {"gauge_mm": 1421.5}, "wheelset": {"back_to_back_mm": 1360.0}},
    "8 mm to the right, at the flange root": {"position": {"lateral_mm": 8.0}},
}
TRACTCURV = (
    *(1e-5, 0.0004, 0.0008, 0.0012, 0.0016, 0.002, 0.0024, 0.0028, 0.0032, 0.0036, 0.004, 0.0044, 0.0048, 0.0052),
    *(0.0056, 0.006, 0.008, 0.01, 0.02, 0.03, 0.04, 0.05, 0.075, 0.1, 0.125, 0.15, 0.175, 0.2, 0.225, 0.25),
)
"""Creepages of the first curve of CONTACT's example."""
ONSET_STATES, ONSET_CREEP = 57, 3.101e-3
"""States of the first sequence of CONTACT's example catt_to_cart, and the creepage of the last one."""
FAST: dict[str, Callable[[RollingContact, Creepages], CreepForces]] = {
    "FASTSIM": fastsim, "FaStrip": fastrip, "Polach": polach, "linear theory": linear_theory,
}  # fmt: skip


def measurements() -> Iterator[Measurement]:
    """All parts."""
    yield from patches((CELLS, *GRIDS), accurate=True)
    yield curve(CELLS, POINTS)
    yield from fast(CELLS)
    yield table(CELLS)
    yield from wheelsets(WHEELSETS)
    yield from contact_examples()


def quick() -> Iterator[Measurement]:
    """Small grids."""
    yield from patches((12,), accurate=False)
    yield curve(12, 5)
    yield from fast(12)
    yield table(8)


def patch(n: int) -> RollingContact:
    """The ellipse on n x n cells."""
    return elliptic(8.0, 4.0, FORCE, (n, n))


def patches(grids: tuple[int, ...], *, accurate: bool) -> Iterator[Measurement]:
    """One state, cold and warm."""
    exact = None
    if accurate:
        coarse, fine = (roll(patch(n), MOTION).along for n in (2 * CELLS, 3 * CELLS))
        exact = 3.0 * fine - 2.0 * coarse
    for n in grids:
        contact = patch(n)
        near = roll(contact, replace(MOTION, along=0.99 * MOTION.along, across=0.99 * MOTION.across))
        cold, found = best_time(lambda n=n: roll(patch(n), MOTION), clock=CLOCK)  # type: ignore[misc]
        warm, _ = best_time(lambda contact=contact, near=near: roll(contact, MOTION, start=near), clock=CLOCK)  # type: ignore[misc]
        asked = {"asked_cold_s": ASKED_COLD_S, "asked_warm_s": ASKED_WARM_S} if n == CELLS else {}
        yield Measurement(
            f"steady rolling on {n} x {n} cells", NO_PEER, cold, None,
            None if exact is None else found.along / exact - 1.0, None, "",
            more={"warm_s": warm, "converged": found.status.converged, "steps": found.status.iterations} | asked,
        )  # fmt: skip


def curve(n: int, points: int) -> Measurement:
    """Forces at many creepages."""
    contact = patch(n)
    seconds, found = timed(
        lambda: creep_curve(contact, [replace(MOTION, along=each) for each in np.linspace(0.0, 0.01, points)]),
        CLOCK,
    )
    converged = sum(each.status.converged for each in found)
    return Measurement(
        f"creep curve of {points} points on {n} x {n} cells", NO_PEER, seconds, None, None, None, "",
        more={"converged": converged, "asked_s": ASKED_CURVE_S},
    )  # fmt: skip


def fast(n: int) -> Iterator[Measurement]:
    """The fast theories; accuracy beside the exact one on the same cells."""
    contact = patch(n)
    exact = roll(contact, MOTION).along
    for name, theory in FAST.items():
        seconds, found = best_time(lambda theory=theory: theory(contact, MOTION), clock=CLOCK)  # type: ignore[misc]
        yield Measurement(
            f"{name} on {n} rows of cells", NO_PEER, seconds, None, found.along / exact - 1.0, None, "",
            more={"asked_s": ASKED_FASTSIM_S} if name == "FASTSIM" else {},
        )  # fmt: skip


def wheelsets(places: dict[str, dict[str, Any]]) -> Iterator[Measurement]:
    """Wheelsets by the exact theory at 72 km/h with a friction of 0.3, from their rigid positions, surfaces ready.

    Accuracy is the equilibrium residual.
    """
    for name, inputs in places.items():
        case = Wheelset.from_values({"rolling": {"friction": 0.3, "speed_km_h": 72.0}} | inputs)
        wheelset = SpatialWheelset(case, running_surfaces(case, cache=Cache.of_user()))
        _ = wheelset.start
        seconds, found = timed(wheelset.solve, CLOCK)
        assert found.state.rolled is not None
        n_patches = sum(len(each.patches) for each in found.state.rolled.creep.values())
        yield Measurement(
            f"rolling wheelset {name}", NO_PEER, seconds, None, found.residuals.equilibrium_residual, None, "",
            more={
                "patches": n_patches, "converged": found.status.converged, "asked_s": ASKED_WHEELSET_S,
            },
        )  # fmt: skip


def table(n: int) -> Measurement:
    """The coarsest table of the patch for multibody programs; accuracy is its maximum error at random creepages."""
    contact = patch(n)

    def made() -> tuple[SampledPatch, SampledForces]:
        fresh = SampledPatch(contact)  # which keeps its solutions
        return fresh, sample(fresh, DIRECTIONS[0])

    seconds, (sampled, found) = timed(made, CLOCK)
    points = random_points(N_POINTS, np.random.default_rng(0))
    errors = check(found, points, exact_forces(sampled, points))
    return Measurement(
        f"creep table of the patch on {n} x {n} cells, {sampled.n_exact} exact states", NO_PEER, seconds, None,
        float(errors.force.max()), None, "",
        more={"s_for_a_state": seconds / sampled.n_exact, "failed": sampled.n_failed},
    )  # fmt: skip


def contact_examples() -> Iterator[Measurement]:
    """Examples of CONTACT; accuracy is the difference of the force from the published one, over its limit."""
    spin = Creepages(0.0, -0.000625, -0.000625)
    seconds, one = best_time(lambda: roll(elliptic(8.0, 4.0, FORCE, (40, 40)), spin), clock=CLOCK)
    yield Measurement(
        "CONTACT's example fastsim: its exact state", NO_PEER, seconds, None,
        one.across / (0.3 * FORCE) - published("fastsim")["exact", "F_y"], None,
        "published: the solver of this state (StedyGS, called once)", more={"published_s": 0.3, "converged": 1},
    )  # fmt: skip
    force = 106.7e3
    seconds, states = timed(
        lambda: creep_curve(elliptic(6.304, 12.61, force, (40, 44), 0.33), [Creepages(each) for each in TRACTCURV]),
        CLOCK,
    )
    yield Measurement(
        f"CONTACT's example tractcurv: its first {len(TRACTCURV)} states", NO_PEER, seconds, None,
        states[3].along / (0.33 * force) - published("curve")["0.0012", "exact"], None,
        "published: its 120 states, 60 of them by the exact theory, 30 of these with a layer and falling friction",
        more={"published_s": 24.2, "converged": sum(each.status.converged for each in states)},
    )  # fmt: skip
    seconds, onset = timed(rolling_onset, CLOCK)
    yield Measurement(
        f"CONTACT's example catt_to_cart: its first {len(onset)} states", NO_PEER, seconds, None,
        float(onset[-1].motion.along) / ONSET_CREEP - 1.0, None,
        "published: its 171 states, three such sequences; accuracy is that of the last creepage",
        more={"published_s": 2.2, "converged": sum(each.status.converged for each in onset)},
    )  # fmt: skip


def rolling_onset() -> list[Rolling]:
    """A sphere that is shifted by a force, and then starts to roll under it, for two diameters of the patch."""
    grid = PatchGrid(-4.125 + 0.25 * np.arange(34.0), 0.25, 34)
    across = (grid.bounds[1:] + grid.bounds[:-1]) / 2.0
    gaps = 0.002963 * (across[:, None] ** 2 + grid.along**2)
    material, force, mu = Elastic(2.0 * 1.28, 0.28), 0.4705, 0.4013
    contact = RollingContact.of_half_spaces(grid, gaps, Friction(mu), (material, material), force=force)
    pull = -0.657 * mu * force
    found = [roll(contact, Creepages(speed=0.0), force_along=pull)]
    while len(found) < ONSET_STATES:
        start = found[-1].motion.along if len(found) > 1 else 0.0
        found.append(roll(contact, Creepages(start), force_along=pull, before=found[-1], start=found[-1]))
    return found
