"""The published curves of a die that slides along a slab, and what is measured of a computed one."""

import numpy as np
import pytest

from studies.friction import ironing
from studies.friction.ironing import ALONG_MM, NORMAL_N_MM, TANGENTIAL_N_MM, TIMES, Ironing


def test_the_published_ratios_in_sliding_are_those_of_the_collection() -> None:
    """Batistic, Cardiff and Tukovic (2022) give the ratio of both forces at time 1.5 for each curve, within 0.015."""
    collected = {
        "Poulios, Renard 2015": 0.30,
        "Code_Aster SSNP153": 0.34,
        "Hartmann et al. 2009": 0.38,
        "Yastrebov 2011": 0.47,
        "Fischer, Wriggers 2006": 0.53,
    }
    assert set(NORMAL_N_MM) == set(TANGENTIAL_N_MM) == set(collected)
    at = TIMES.index(1.5)
    for name, ratio in collected.items():
        assert TANGENTIAL_N_MM[name][at] / NORMAL_N_MM[name][at] == pytest.approx(ratio, abs=0.015)
        assert len(NORMAL_N_MM[name]) == len(TANGENTIAL_N_MM[name]) == len(TIMES)
        assert (np.diff(NORMAL_N_MM[name][: TIMES.index(1.1)]) > 0.0).all()


def test_a_constant_force_works_along_the_way_and_does_not_oscillate() -> None:
    """10 N/mm over 2 mm of steady sliding are 20 N mm/mm, and a ripple of 1 % is an oscillation of 1 %."""
    times = np.linspace(0.05, 1.6, 32)
    still = Ironing(times, np.full(32, 40.0), np.full(32, 10.0), np.diff(times, prepend=0.0) * ALONG_MM * 10.0)
    assert still.works == pytest.approx((20.0, 20.0))
    assert still.oscillation == 0.0
    ripple = Ironing(times, still.normal, 10.0 + 0.05 * (-1.0) ** np.arange(32), still.work)
    assert ripple.oscillation == pytest.approx(0.01, rel=1e-6)
    assert ripple.at(0.025) == pytest.approx((40.0, 10.05))


def test_a_coarse_die_slides_in_long_steps() -> None:
    """Cells a third as fine in steps of 3/10 mm converge, to the forces of the fine mesh within 5 %."""
    found = ironing.ironed_slab(cells=(40, 10), steps=(5, 20))
    assert found.status.converged, found.status.message
    assert max(step.state.status.iterations for step in found.steps) <= 30
    assert ironing.ironing_of(found).at(1.5) == pytest.approx((367.0, 144.4), rel=0.05)


@pytest.mark.ci
def test_a_surface_that_folds_is_named(monkeypatch) -> None:
    """With friction 1.5 the slab folds before the die: the message has its turn and stretch in the last solution."""
    monkeypatch.setattr(ironing, "MU", 1.5)
    found = ironing.ironed_slab(cells=(40, 10), steps=(5, 20))
    assert not found.status.converged
    assert "the surface of 'slab' is turned by" in found.status.message
