"""Forty loads of the plane wheelset, each solved from the one before, after condensation: processor time of one load.

Weight and lateral force grow together by a fifth. Accuracy is the maximum equilibrium residual. The peer is the same
program at commit 3bac472, which searched for the position around the contact forces: processor time of its search.
"""

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.measurement import ITSELF, Measurement
from flangeway.cases import Wheelset, load_case
from flangeway.railway.wheelset.plane_wheelset import PlaneWheelset
from flangeway.railway.wheelset.wheelset_model import build_model

N_LOADS, GROWTH = 40, 1.2
SEARCHED_S = {("tangent", "fem"): 0.61, ("curve", "fem"): 2.23, ("curve", "vem"): 7.5}
"""Processor seconds of the search at commit 3bac472, by track and method."""
LIMIT_S = 0.25
"""Processor time asked of one load."""


def measurements() -> Iterator[Measurement]:
    """Both tracks with default sizes."""
    yield from _measured(1.0, N_LOADS)


def quick() -> Iterator[Measurement]:
    """As `measurements`, with a coarse mesh and few loads."""
    yield from _measured(4.0, 4)


def _measured(size_scale: float, n_loads: int) -> Iterator[Measurement]:
    for (track, method), searched in SEARCHED_S.items():
        problem = load_case(f"wheelset-{track}", method=method, size_scale=size_scale)
        assert isinstance(problem, Wheelset)
        wheelset = PlaneWheelset.of(build_model(problem))
        found = wheelset.equilibrium()
        seconds, iterations, residual = [], [], 0.0
        for factor in np.linspace(1.0, GROWTH, n_loads + 1)[1:].tolist():
            load = problem.load
            changes = {key: factor * getattr(load, key) for key in ("axle_load_kN", "lateral_force_kN")}
            model = replace(wheelset.model, problem=problem.replaced(load=changes))
            start = time.process_time()
            found = replace(wheelset, model=model).equilibrium(found)
            seconds.append(time.process_time() - start)
            if not found.status.converged:
                raise RuntimeError(f"{track}, {method}, {factor:.3f} of the load: {found.status.message}")
            iterations.append(found.status.iterations)
            residual = max(residual, found.residuals.equilibrium_residual)
        mean = float(np.mean(seconds))
        yield Measurement(
            f"one of {n_loads} loads, wheelset-{track}, {method}, size_scale {size_scale:g}",
            ITSELF,
            mean,
            searched if size_scale == 1.0 else None,
            residual,
            None,
            f"processor time; at most {LIMIT_S:g} s are asked, the slowest load takes {max(seconds):.2f} s; "
            f"{np.mean(iterations):.1f} iterations a load",
            asked=searched / LIMIT_S if size_scale == 1.0 else None,
        )
