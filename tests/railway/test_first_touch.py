"""First touch of rigid profiles."""

import math

import pytest

from flangeway.errors import InputError
from flangeway.railway.first_touch import first_touch, touching_motion
from flangeway.railway.profiles import rail, wheel
from flangeway.railway.track import Track, Wheelset


@pytest.mark.parametrize("cant", [1 / 40, 1 / 30, 1 / 100])
def test_a_conical_tread_touches_the_crown_where_the_slopes_agree(cant: float) -> None:
    """A tread of 1:20 touches a crown of radius R at R sin(atan(1/20) - atan(cant)) from its middle, to 0.05 mm."""
    track, wheelset = Track(rail(crown_radius_in=10), cant=cant), Wheelset(wheel())
    touch = first_touch(track, wheelset, "right")
    offset = 254.0 * math.sin(math.atan(1 / 20) - math.atan(cant))
    assert touch.rail_point_mm[0] == pytest.approx(-offset, abs=0.05)
    assert touch.relative_curvature_per_mm == pytest.approx(1 / 254.0)


def test_the_touch_is_on_both_profiles() -> None:
    """The touching point lies on the rail and, the wheel lowered, on the wheel, to a micrometre."""
    track, wheelset = Track(rail()), Wheelset(wheel())
    motion, touches = touching_motion(track, wheelset)
    for touch in touches:
        on_wheel = motion.placement(wheelset, touch.side).inverse().points([touch.point_mm])
        assert wheelset.wheel.outline.closest(on_wheel)[2][0] < 1e-3
        on_rail = track.placement(touch.side).inverse().points([touch.point_mm])
        assert track.rail.outline.closest(on_rail)[2][0] < 1e-3


def test_both_sides_touch_alike() -> None:
    """Mirrored sides touch at mirrored points after the same motion."""
    _, (left, right) = touching_motion(Track(rail()), Wheelset(wheel()))
    assert left.vertical_mm == pytest.approx(right.vertical_mm, abs=1e-6)
    assert left.point_mm[0] == pytest.approx(-right.point_mm[0], abs=0.03)


@pytest.mark.parametrize("gauge", [1000.0, 1850.0, 3000.0])
def test_a_wheel_that_misses_its_rail(gauge: float) -> None:
    """A gauge that leaves the wheels beside the rails, or on the edge of them, is refused with what to check."""
    with pytest.raises(InputError, match="gauge_mm"):
        touching_motion(Track(rail(), gauge_mm=gauge), Wheelset(wheel()))
