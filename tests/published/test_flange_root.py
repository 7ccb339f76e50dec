"""The flange root of the AAR-1B that one published number identifies (Moherdaui, 2021, Table 16)."""

import math

import numpy as np
import pytest

from flangeway import InputError
from flangeway.cases.wheelset.wheelset_profiles import profile_named
from flangeway.geometry import Arc
from flangeway.railway.profiles.bundled import wheel
from flangeway.railway.profiles.flange_root import IDENTIFIED, identified_wheel, with_flange_root
from flangeway.railway.track.discretisation import Discretisation


@pytest.mark.parametrize("radius", [30.0, 38.1, 49.2, 60.0])
def test_the_family_keeps_what_is_known_of_the_wheel(radius):
    """Taper, height, thickness and angle of the flange, narrow arc and slope between the arcs stay; no kink appears."""
    made = with_flange_root(wheel(), radius)
    parts = dict(zip(made.outline.names, made.outline.segments, strict=True))
    narrow, wide, tread, face = (
        parts[n] for n in ("flange_root_R1", "flange_root_R2", "tread_1:20", "flange_face_75deg")
    )
    assert isinstance(narrow, Arc)
    assert narrow.radius == pytest.approx(14.2875, abs=1e-4)
    assert 1.0 / abs(wide.curvature) == pytest.approx(radius, rel=1e-6)
    assert np.degrees(np.arctan(tread.tangent(0.0)[0] @ (0, 1))) == pytest.approx(
        math.degrees(math.atan(0.05)), abs=0.01
    )
    assert face.tangent(0.0)[0] == pytest.approx((math.cos(math.radians(75)), math.sin(math.radians(75))), abs=1e-5)
    for one, following in ((parts["flange_tip_front"], face), (face, narrow), (narrow, wide), (wide, tread)):
        assert one.tangent(1.0)[0] == pytest.approx(following.tangent(0.0)[0], abs=2e-5)
    assert wide.tangent(0.0)[0][1] == pytest.approx(math.sin(math.radians(30.0)), abs=1e-4)
    assert (made.flange_height_mm, made.outline.bounds()[0, 1]) == pytest.approx((25.4, -25.4))
    points = made.running_surface.sampled(max_deviation=1e-6)
    front = points[points[:, 0] > -60.0]
    thickness = np.interp(9.525, -front[::-1, 1], front[::-1, 0]) - made.outline.bounds(["back_face"])[0, 0]
    assert thickness == pytest.approx(34.925, abs=2e-3)


def test_roots_that_do_not_fit_are_refused():
    """A radius that leaves no room, and other wheels are refused."""
    for radius in (10.0, 90.0, float("nan")):
        with pytest.raises(InputError, match="flange root"):
            with_flange_root(wheel(), radius)
    with pytest.raises(InputError, match="flange root"):
        with_flange_root(wheel("S1002"), 40.0)
    assert profile_named(IDENTIFIED, "wheel").outline == identified_wheel().outline


def test_a_nodal_penalty_is_of_node_to_segment_alone():
    """A penalty per node with segment-to-segment or with multipliers is refused, since it would do nothing."""
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        Discretisation(nodal_penalty_N_per_mm=1e7)
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        Discretisation(pairing="node-to-segment", enforcement="multiplier", nodal_penalty_N_per_mm=1e7)
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        Discretisation(pairing="node-to-segment", nodal_penalty_N_per_mm=-1.0)
