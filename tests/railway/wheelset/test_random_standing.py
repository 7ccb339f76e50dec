"""Wheelsets of the random campaign that did not find their position, and step limits that let them."""

import pytest

from benchmarks.standing import combinations, stand
from flangeway.railway.wheelset.equilibrium import Reach

DRAWN = combinations()


@pytest.mark.ci
@pytest.mark.parametrize("number", [92, 330, 387, 576])
def test_a_wheelset_with_friction_finds_its_position(number):
    """What each depends on.

    Creep forces that jump on coarse cells of a conforming pair (92), steps of the rate that keep their sense (330), a
    flange that holds a guided wheelset (387), and one that comes close beside the patch on the tread (576).
    """
    end = stand(DRAWN[number])
    assert end["end"] == "converged", end["message"]


def test_a_step_limit_shrinks_with_the_sense_of_steps_and_recovers():
    """After four changes of sense it is below a tenth of the first; steps of one sense bring it back, no farther."""
    reach = Reach(1.0, 1.0)
    for sense in (1.0, -1.0, 1.0, -1.0, 1.0):
        reach.last = sense * reach.limit_of(sense, halved=False)
    assert reach.limit < 0.1
    for _ in range(30):
        reach.last = reach.limit_of(1.0, halved=False)
    assert reach.limit == pytest.approx(1.0)
