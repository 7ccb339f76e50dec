"""Inputs that would change nothing are refused with their names."""

import pytest

from flangeway.cases import find_case, load_case
from flangeway.errors import InputError

BLOCK = {"rectangle": {"width_mm": 2.0, "height_mm": 1.0}, "size_mm": 0.5}


def blocks(**inputs):
    lower, upper = BLOCK | {"name": "lower"}, BLOCK | {"name": "upper", "shift_mm": [0.0, 1.0]}
    contact = {"secondary": "upper", "secondary_edges": "bottom", "primary": "lower", "primary_edges": "top"}
    supports = [{"body": "lower", "edges": "bottom"}, {"body": "upper", "edges": "top"}]
    return find_case("two-bodies").from_values(
        {"bodies": [lower, upper], "contacts": [contact], "supports": supports} | inputs
    )


def moved(*legs):
    return [{"body": "upper", "leg": leg, "shift_mm": [0.0, -1e-3]} for leg in legs]


@pytest.mark.parametrize("legs", [(1, 3), (3,), (1, 2, 4), (2,), (100,)])
def test_legs_without_those_before_are_refused(legs):
    """Motions of a leg need some in every leg before it."""
    with pytest.raises(InputError, match="leg"):
        blocks(motions=moved(*legs)).check()


def test_legs_that_follow_each_other_are_allowed():
    """Legs 1, 2, 3 are, and leg 2 alone where forces act in leg 1."""
    blocks(motions=moved(1, 2, 3)).check()
    blocks(motions=moved(2), loads=[{"body": "upper", "edges": "left", "pressure_MPa": 0.1}]).check()


@pytest.mark.parametrize("name", ["wheelset", "wheelset-curve"])
@pytest.mark.parametrize(
    ("path", "body"), [("track.rail", "nonsense"), ("track.rail", "60E1"), ("wheelset.wheel", "plain")]
)
def test_bodies_of_bundled_profiles_are_refused(name, path, body):
    """A body for a file's running surface has no effect on bundled profiles."""
    with pytest.raises(InputError, match=path):
        load_case(name, **{f"{path}.body": body}).check()


@pytest.mark.parametrize("key", ["rolling.torque_kNm", "rolling.yaw_stiffness_kNm_per_mrad"])
def test_what_only_friction_bears_is_refused_without_friction(key):
    """Torque and guidance need friction on a side at least."""
    standing = {"rolling.friction": 0.0, "rolling.speed_km_h": 80.0, key: 1.0}
    with pytest.raises(InputError, match=key):
        load_case("wheelset", **standing)
    load_case("wheelset", **standing, **{"track.left.friction": 0.2})
