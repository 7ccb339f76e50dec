"""Lateral force of a wheelset with friction over its lateral position, in steps of 0.01 mm: how smooth it is.

The slip zones are as thin as a cell, so that the force jumps with the cells: where the lateral position is sought, it
is known no better than this noise over the slope of the force. Noise is the root mean square about the cubic that fits
the forces of 0.2 mm best; bias is their mean less that on finer cells, relative to the sum of all rows' creep forces.
"""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from benchmarks.measurement import NO_PEER, Measurement
from benchmarks.sweep import moved_to, wheelset_of
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.spatial_result import SpatialResult

LENGTH_MM, STEPS = 0.2, 20
FINER, N_FINER = 50, 3
"""Cells across a patch for the bias, and the positions at which they are used."""
THEORIES = "fastsim", "exact"
PLACES: dict[str, tuple[float, dict[str, Any]]] = {
    "S1002 on 60E1": (1.0, {}),
    "S1002 on 54E1, R 3000 m": (
        0.45,
        {
            "rail": "54E1",
            "axle_load_kN": 193.7,
            "rolling.friction": 0.24,
            "load.curve": {"radius_m": 3000.0, "speed_km_h": 72.0},
        },
    ),
    "AAR-1B on 49E1": (6.3, {"wheelset.wheel": "AAR-1B", "rail": "49E1"}),
    "S1002 on 60E1, two patches": (6.2, {}),
    "AAR-1B on 60E1, conforming": (3.0, {"wheelset.wheel": "AAR-1B"}),
    "S1002 on 60E1 1:20, R 500 m": (-2.0, {"inclination": 0.05, "load.curve": {"radius_m": 500.0, "speed_km_h": 72.0}}),
}
"""First position, mm, and inputs of each wheelset beside those of the case."""


def lateral_forces(result: SpatialResult) -> tuple[float, float]:
    """Lateral force of both wheels, and the sum of the lateral creep forces of all rows without their signs, N."""
    total = sum(float(result.force_on_wheel_N(side)[0]) for side in SIDES)
    rolled = result.equilibrium.state.rolled
    assert rolled is not None
    return total, sum(float(np.abs(rolled.creep[side].rows[:, 0]).sum()) for side in SIDES)


def measurements() -> Iterator[Measurement]:
    """All pairs, with FASTSIM and the exact theory."""
    for name in PLACES:
        for theory in THEORIES:
            yield _sweep(name, theory)


def _sweep(name: str, theory: str) -> Measurement:
    first, inputs = PLACES[name]
    speed = {} if "load.curve" in inputs else {"speed_km_h": 72.0}
    inputs = {"rolling.friction": 0.3, "theory": theory} | speed | inputs
    coarse, fine = (wheelset_of(inputs | cells) for cells in ({}, {"patch_cells": FINER}))
    laterals = np.linspace(first, first + LENGTH_MM, STEPS + 1)
    forces, sums, seconds, n_failed = [], [], 0.0, 0
    for lateral in laterals.tolist():
        start = time.process_time()
        result = moved_to(coarse, lateral)
        seconds += time.process_time() - start
        n_failed += not result.status.converged
        force, whole = lateral_forces(result)
        forces.append(force)
        sums.append(whole)
    values = np.array(forces)
    fit = Polynomial.fit(laterals, values, 3)
    # at few positions: the force on fine cells is smoother
    at = np.linspace(0, STEPS, N_FINER).astype(int)
    differences = [fit(laterals[k]) - lateral_forces(moved_to(fine, float(laterals[k])))[0] for k in at]
    rms = float(np.sqrt(np.mean((values - fit(laterals)) ** 2)))
    return Measurement(
        f"lateral force in {STEPS} steps over {LENGTH_MM:g} mm, {theory}: {name}", NO_PEER, seconds / len(laterals),
        None, rms, None, "seconds of processor of a position; noise of the force in N",
        more={
            "force_N": float(values.mean()), "creep_force_N": float(np.mean(sums)),
            "bias": float(np.mean(differences)) / float(np.mean(sums)),
            "slope_N_per_mm": float(fit.deriv()(first + LENGTH_MM / 2.0)), "n_failed": n_failed,
        },
    )  # fmt: skip
