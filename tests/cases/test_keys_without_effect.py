"""Inputs that would change nothing are refused with their names."""

from typing import Literal, get_args, get_origin

import pytest

from flangeway.cases import Wheelset, find_case, load_case
from flangeway.cases.case import OF_REPORT
from flangeway.cases.rigid_run import GeometryCase, run_geometry
from flangeway.errors import InputError
from flangeway.records import alternatives, entries_of, is_number, leaves, with_settings

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


OTHER = {
    "rail": "136RE",
    "wheel": "heavy-haul",
    "inclination": 0.05,
    "radius_mm": 455.0,
    "back_to_back_mm": 1361.0,
    "gauge_mm": 1437.0,
    "maximum_lateral_mm": 4.0,
    "gauge_depth_mm": 12.0,
    "superelevation_base_mm": 1600.0,
}
"""Values that no rule finds: names, and lengths that have to fit."""
CURVE = {"radius_m": 500.0, "speed_km_h": 80.0, "superelevation_mm": 60.0}
COARSE = {"mesh": {"size_scale": 4.0}, "contact": {"patch_cells": 12}}
BASES = {
    "geometry": [
        {"scan": {"step_mm": 0.1}, "load": load}
        for load in ({"superelevation_mm": 20.0}, {"car": {"mass_t": 80.0}}, {"curve": CURVE})
    ],
    "wheelset": [
        COARSE,
        {
            **COARSE,
            "rolling": {"friction": 0.3, "theory": "fastsim"},
            "load": {"curve": CURVE, "car": {"mass_t": 80.0}},
            "wheelset": {"section": "whole"},
            "track": {"support": "continuous"},
        },
    ],
}
"""Inputs with which every other input can be given in one of them at least."""


def others(entry):
    """Other values of an input that its type allows."""
    value, key = entry.value, entry.path[-1]
    kinds = alternatives(entry.field.annotation)
    if key in OTHER:
        return [OTHER[key]]
    if is_number(value):
        return [value + 1, value - 1] if isinstance(value, int) else [1.1 * value or 0.5, 0.9 * value or 0.01]
    if isinstance(value, tuple):
        return [tuple(tuple(1.05 * x for x in part) if isinstance(part, tuple) else 1.05 * part for part in value)]
    named = [choice for kind in kinds if get_origin(kind) is Literal for choice in get_args(kind) if choice != value]
    return named or [1.0, 300.0, 0.3]


def results(name, values):
    """Numbers of a run by their paths, without those that repeat its inputs."""
    if name == "geometry":
        summary = run_geometry(name, GeometryCase.from_values(values)).summary
    else:
        summary = find_case(name).from_values(values).run().summary
    told = {"inputs", "timings_s", "versions", "peak_memory_bytes", "assumptions", "title"}
    return [(path, value) for path, value in leaves(summary) if path[0] not in told]


@pytest.mark.ci
@pytest.mark.parametrize("name", BASES)
def test_every_input_that_is_accepted_changes_a_result(name):
    """Each input of a wheelset, rigid or elastic in space, changes a number of the results where it is accepted."""
    case, seen, changing = {"geometry": GeometryCase, "wheelset": Wheelset}[name], set(), set()
    for base in BASES[name]:
        usual = results(name, base)
        for entry in entries_of(case.from_values(base)):
            if entry.path[0] in OF_REPORT or entry.path[-1] == "kind" or entry.name in changing:
                continue
            for value in others(entry):
                try:
                    changed = results(name, with_settings(case, base, {entry.name: value}))
                except InputError:
                    continue
                seen.add(entry.name)
                if changed != usual:
                    changing.add(entry.name)
                    break
    assert len(seen) > 25
    assert changing == seen


@pytest.mark.parametrize("path", ["track.support", "track.left.friction", "wheelset.axle", "material.yield_MPa"])
def test_the_geometry_has_no_inputs_of_elastic_bodies(path):
    """What bends, yields or rubs is no input of a rigid wheelset: it is unknown, with its path."""
    table, _, key = path.rpartition(".")
    with pytest.raises(InputError, match=key):
        GeometryCase.from_values({table: {key: 1.0}} if "." not in table else {"track": {"left": {key: 0.3}}})
