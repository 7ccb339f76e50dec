"""Rolling with friction: the exact theory on one patch cold and warm, creep curves, growth, and the fast theories.

The patch is an ellipse of 8 by 4 mm on n x n half-space cells, under longitudinal and lateral creepage and spin with
which about half of it slips. Cold includes the influence coefficients and starts from nothing; warm starts from the
tractions at 1 % less creepage. Accuracy is the relative error of the longitudinal force from that of grids of 60 and 90
cells, extrapolated; that of the fast theories is beside the exact one on the same cells.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement, best_time, timed
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetCase
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import creep_curve, roll
from flangeway.contact.rolling.fast_theories import linear_theory, polach
from flangeway.contact.rolling.fastsim import fastrip, fastsim
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.contact.rolling.rolling_result import CreepForces
from flangeway.railway.spatial.running_surfaces import running_surfaces
from flangeway.railway.spatial.spatial_wheelset import SpatialWheelset
from flangeway.system.disk_cache import Cache
from flangeway.validation.rolling.rolling_cases import elliptic

CELLS, FORCE = 30, 82_000.0
MOTION = Creepages(1e-3, 5e-4, -2e-4)
POINTS = 120
ASKED_COLD_S, ASKED_WARM_S, ASKED_CURVE_S, ASKED_FASTSIM_S = 0.5, 0.1, 5.0, 1e-3
GRIDS = (20, 40, 80)
ASKED_WHEELSET_S = 3.0
WHEELSETS: dict[str, dict[str, float]] = {
    "in the middle of straight track": {},
    "2 mm to the right in a curve of 800 m": {"lateral_mm": 2.0, "yaw_mrad": 1.0, "curve_radius_m": 800.0},
    "6 mm to the left, three patches": {"lateral_mm": -6.0, "yaw_mrad": 1.0},
    "8 mm to the right, at the flange root": {"lateral_mm": 8.0},
}
FAST: dict[str, Callable[[RollingContact, Creepages], CreepForces]] = {
    "FASTSIM": fastsim, "FaStrip": fastrip, "Polach": polach, "linear theory": linear_theory,
}  # fmt: skip


def measurements() -> Iterator[Measurement]:
    """All parts."""
    yield from patches((CELLS, *GRIDS), accurate=True)
    yield curve(CELLS, POINTS)
    yield from fast(CELLS)
    yield from wheelsets(WHEELSETS)


def quick() -> Iterator[Measurement]:
    """Small grids."""
    yield from patches((12,), accurate=False)
    yield curve(12, 5)
    yield from fast(12)


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
        cold, found = best_time(lambda n=n: roll(patch(n), MOTION))  # type: ignore[misc]
        warm, _ = best_time(lambda contact=contact, near=near: roll(contact, MOTION, start=near))  # type: ignore[misc]
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
        lambda: creep_curve(contact, [replace(MOTION, along=each) for each in np.linspace(0.0, 0.01, points)])
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
        seconds, found = best_time(lambda theory=theory: theory(contact, MOTION))  # type: ignore[misc]
        yield Measurement(
            f"{name} on {n} rows of cells", NO_PEER, seconds, None, found.along / exact - 1.0, None, "",
            more={"asked_s": ASKED_FASTSIM_S} if name == "FASTSIM" else {},
        )  # fmt: skip


def wheelsets(places: dict[str, dict[str, float]]) -> Iterator[Measurement]:
    """Wheelsets by the exact theory at 72 km/h with a friction of 0.3, from their rigid positions, surfaces ready.

    Accuracy is the equilibrium residual; processor time is that of one core.
    """
    case = SpatialWheelsetCase.from_values({})
    surfaces = running_surfaces(case.problem(), case.spatial_model(), cache=Cache.of_user())
    for name, inputs in places.items():
        one = SpatialWheelsetCase.from_values({"speed_km_h": 72.0, "friction": 0.3, **inputs})
        wheelset = SpatialWheelset(one.problem(), surfaces, one.spatial_model())
        _ = wheelset.start
        start = time.process_time()
        seconds, found = timed(wheelset.solve)
        yield Measurement(
            f"rolling wheelset {name}", NO_PEER, seconds, None, found.residuals.equilibrium_residual, None, "",
            more={
                "processor_s": time.process_time() - start, "converged": found.status.converged,
                "asked_s": ASKED_WHEELSET_S,
            },
        )  # fmt: skip
