"""Rolling with friction: what ``flangeway reproduce rolling`` computes."""

from collections.abc import Iterator

import numpy as np

from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.exact_rolling import creep_curve
from flangeway.contact.rolling.fast_theories import linear_theory, polach
from flangeway.contact.rolling.fastsim import fastrip, fastsim
from studies.rolling.manchester_rolling import creep_numbers
from studies.rolling.rolling_bodies import body_numbers
from studies.rolling.rolling_cases import (
    PUBLISHED_CELLS,
    Energy,
    coefficient_numbers,
    contact_numbers,
    elliptic,
    plane_numbers,
    sphere_numbers,
)
from studies.rolling.rolling_rollers import falling_numbers, free_numbers, onset_numbers, warm_numbers
from studies.study import Row, Run
from studies.wheelset3d.manchester import benchmark_positions

CURVE = tuple(np.linspace(0.0, 0.004, 17).tolist())
SPIN = 3e-4  # per mm, of the second creep curve
THEORIES = {"linear theory": linear_theory, "Polach": polach, "FASTSIM": fastsim, "FaStrip": fastrip}


def rows(run: Run) -> Iterator[Row]:
    """Rows of all parts."""
    energy, found = Energy(run), list[Row]()
    for name, part in (
        ("cylinders", plane_numbers),
        ("spheres", sphere_numbers),
        ("different materials", free_numbers),
        ("examples of CONTACT", contact_numbers),
        ("falling friction", falling_numbers),
        ("temperature and reduced slope", warm_numbers),
        ("onset of rolling", onset_numbers),
    ):
        run.progress(name)
        found += part(energy)
    found += coefficient_numbers(run.progress)
    run.progress("real bodies")
    found += body_numbers(energy)
    for position in benchmark_positions(run, every=1):
        found += creep_numbers(position, energy)
    run.progress("creep curves")
    contact = elliptic(8.0, 4.0, 82000.0, (PUBLISHED_CELLS, PUBLISHED_CELLS))
    limit = contact.friction.limits[0][0] * contact.force
    for spin in (0.0, SPIN):
        motions = [Creepages(creepage, 0.0, spin) for creepage in CURVE]
        exact = [energy.check("creep curve", state) for state in creep_curve(contact, motions)]
        forces = {"exact": [(state.along, state.across) for state in exact]}
        for name, theory in THEORIES.items():
            forces[name] = [(state.along, state.across) for state in (theory(contact, motion) for motion in motions)]
        for name, curve in forces.items():
            along, across = np.array(curve).T / limit
            words = f"spin {1e3 * spin:g} per m" if spin else "without spin"
            run.curve("creep_curves", f"along, {words}", name, 1e3 * np.array(CURVE), along)
            if spin:
                run.curve("creep_curves", f"across, {words}", name, 1e3 * np.array(CURVE), across)
    yield energy.row()
    yield from found
