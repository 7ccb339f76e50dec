"""The published curves of a die that slides along a slab, and a coarse computed one."""

from dataclasses import replace

import numpy as np
import pytest

from studies.friction import ironing
from studies.study import published_values


def test_the_published_ratios_in_sliding_are_those_of_the_collection() -> None:
    """Batistic, Cardiff and Tukovic (2022) give the ratio of both forces at time 1.5 for each curve, within 0.015."""
    collected = {
        "Poulios, Renard 2015": 0.30,
        "Code_Aster SSNP153": 0.34,
        "Hartmann et al. 2009": 0.38,
        "Yastrebov 2011": 0.47,
        "Fischer, Wriggers 2006": 0.53,
    }
    normal, tangential = (published_values("friction.csv", case) for case in ("normal", "tangential"))
    assert normal.keys() == tangential.keys()
    assert {name for _, name in normal} == set(collected)
    for name, ratio in collected.items():
        assert tangential["1.5", name] / normal["1.5", name] == pytest.approx(ratio, abs=0.015)
        lowered = [value for (time, other), value in normal.items() if other == name and float(time) <= 1.04]
        assert (np.diff(lowered) > 0.0).all()


def test_a_coarse_die_slides_in_long_steps() -> None:
    """Cells a third as fine in steps of 3/10 mm converge, to the forces of the fine mesh within 5 %."""
    found = ironing.ironed_slab(cells=(40, 10), steps=(5, 20))
    assert found.status.converged, found.status.message
    assert max(step.state.status.iterations for step in found.steps) <= 30
    shares = [step.share for step in found.steps]
    forces = np.array([replace(found, state=step.state).forces[0] for step in found.steps])
    # time 1.5 is half of 10 mm along, of which 6 are computed
    x, y = (float(np.interp(1.0 + 5.0 / 6.0, shares, force)) for force in forces.T)
    assert (y, -x) == pytest.approx((367.0, 144.4), rel=0.05)


@pytest.mark.ci
def test_a_surface_that_folds_is_named(monkeypatch) -> None:
    """With friction 1.5 the slab folds before the die: the message names the bodies and the node."""
    monkeypatch.setattr(ironing, "MU", 1.5)
    found = ironing.ironed_slab(cells=(40, 10), steps=(5, 20))
    assert not found.status.converged
    assert "'slab'" in found.status.message
    assert "at node" in found.status.message
