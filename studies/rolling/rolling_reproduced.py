"""Rolling with friction: what ``flangeway reproduce rolling`` computes."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import creep_curve, roll
from flangeway.contact.rolling.fast_theories import linear_theory, polach
from flangeway.contact.rolling.fastsim import fastrip, fastsim
from flangeway.contact.rolling.rolling_result import Rolling
from flangeway.types import Floats
from studies.published_numbers import Reproduced, Row
from studies.rolling.manchester_rolling import creep_numbers
from studies.rolling.rolling_bodies import body_numbers
from studies.rolling.rolling_cases import (
    PUBLISHED_CELLS,
    Energy,
    RollingRow,
    coefficient_numbers,
    contact_numbers,
    elliptic,
    plane_numbers,
    sphere_numbers,
)
from studies.rolling.rolling_rollers import falling_numbers, free_numbers, onset_numbers
from studies.wheelset3d.manchester import benchmark_positions

CURVE = tuple(np.linspace(0.0, 0.004, 17).tolist())
SPIN = 3e-4
"""Spin per mm of the second creep curve."""
THEORIES = {"linear theory": linear_theory, "Polach": polach, "FASTSIM": fastsim, "FaStrip": fastrip}


@dataclass(frozen=True)
class CurveRow:
    """Forces over the limit of friction by one theory: a row of ``creep_curves.csv``."""

    theory: str
    spin: float
    creepage: float
    along: float
    across: float


@dataclass(frozen=True, eq=False, kw_only=True)
class RollingReproduction(Reproduced):
    """Closed forms and published numbers of rolling computed again.

    Parameters
    ----------
    rows
        Values on all grids.
    curves
        Creep curves of all theories.
    shown
        The state with lateral creepage and spin.
    unconverged
        States that did not converge.

    """

    rows: tuple[RollingRow, ...]
    curves: tuple[CurveRow, ...]
    shown: Rolling
    unconverged: tuple[str, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """States that did not converge."""
        return self.unconverged


def reproduce_rolling(*, quick: bool = False, progress: Callable[[str], None] = lambda _: None) -> RollingReproduction:
    """Compute all parts; if `quick`, without the real bodies."""
    start = time.perf_counter()
    energy, rows = Energy(), list[RollingRow]()
    progress("cylinders")
    numbers = list(plane_numbers(energy, rows))
    progress("spheres")
    numbers += sphere_numbers(energy, rows)
    progress("different materials")
    numbers += free_numbers(energy)
    progress("examples of CONTACT")
    numbers += contact_numbers(energy)
    numbers += falling_numbers(energy)
    numbers += onset_numbers(energy)
    numbers += coefficient_numbers(progress, rows)
    if not quick:
        progress("real bodies")
        numbers += body_numbers(energy)
    for position in benchmark_positions(quick=quick, progress=progress):
        numbers += creep_numbers(position, energy)
    progress("creep curves")
    contact = elliptic(8.0, 4.0, 82000.0, (PUBLISHED_CELLS, PUBLISHED_CELLS))
    limit = float(contact.friction.limits[0][0]) * contact.force
    curves = []
    for spin in (0.0, SPIN):
        motions = [Creepages(each, 0.0, spin) for each in CURVE]
        found = {"exact": [energy.check("creep curve", each) for each in creep_curve(contact, motions)]}
        found |= {name: [theory(contact, each) for each in motions] for name, theory in THEORIES.items()}  # type: ignore[misc]
        curves += [
            CurveRow(name, spin, float(each.motion.along), each.along / limit, each.across / limit)
            for name, states in found.items()
            for each in states
        ]
    shown = roll(contact, Creepages(0.0, -0.000625, -0.000625))
    return RollingReproduction(
        rows=tuple(rows),
        curves=tuple(curves),
        shown=shown,
        unconverged=tuple(energy.failures),
        numbers=(energy.number(), *numbers),
        seconds=time.perf_counter() - start,
    )


def refinement_table(found: RollingReproduction) -> list[Row]:
    """Rows of ``refinement.csv``."""
    return [asdict(row) for row in found.rows]


def curve_table(found: RollingReproduction) -> list[Row]:
    """Rows of ``creep_curves.csv``."""
    return [asdict(row) for row in found.curves]


def curve_of(found: RollingReproduction, theory: str, spin: float) -> Floats:
    """Creepage, and forces along and across over the limit, shape (n, 3)."""
    return np.array([(r.creepage, r.along, r.across) for r in found.curves if (r.theory, r.spin) == (theory, spin)])
