"""Campaigns of wheelsets in three dimensions: rows, columns, and that a row does not depend on the others."""

import numpy as np
import pytest

from flangeway.campaign import chunk
from flangeway.campaign.chunk import Chunk, compute
from flangeway.cases.wheelset.wheelset_case import WheelsetTangentCase
from flangeway.system.latest_values import LatestValues
from tests.campaign.conftest import computed, read

FILE = """
case = "wheelset"
[inputs]
size_scale = 8.0
order = 1
rail_support = "fixed"
patch_cells = 12
[vary]
lateral_mm = [-1.0, 1.0]
yaw_mrad = [0.0, 5.0]
"""


LOADS = ("vertical_force_kN", "longitudinal_creep_force_kN", "frictional_power_W", "t_gamma_N", "share_of_nadal_limit")


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """Four positions, computed in this process."""
    return computed(tmp_path_factory.mktemp("spatial"), FILE)


def test_rows_carry_the_load_and_have_the_columns_of_both_models(sweep):
    """Both wheels carry the load; the columns that plane wheelsets have too mean the same; mirrored rows agree."""
    campaign, found = sweep
    assert set(found.rows["status"]) == {"converged"}, found.rows["message"]
    assert set(campaign.known_columns) <= set(found.rows)
    assert list(found.patches) == list(campaign.patch_columns)
    left, right = (found.numbers(f"{side}_vertical_force_kN") for side in ("left", "right"))
    assert np.allclose(left + right, campaign.rows[0].case.axle_load_kN, rtol=1e-7)
    for side in ("left", "right"):
        mine = np.array(found.patches["side"]) == side
        forces = np.array(found.patches["normal_force_kN"])[mine]
        assert np.bincount(np.array(found.patches["row"])[mine], forces)[1:] == pytest.approx(
            found.numbers(f"{side}_normal_force_kN")
        )
    # rows 1 and 3: at -1 and +1 mm without yaw
    for name in ("max_pressure_MPa", "semi_axes_a_mm", "contact_angle_deg", "rolling_radius_mm", "head_vertical_mm"):
        one, other = found.numbers(f"left_{name}")[0], found.numbers(f"right_{name}")[2]
        assert one == pytest.approx(other, rel=1e-6)
    assert found.numbers("left_head_lateral_mm")[0] == pytest.approx(-found.numbers("right_head_lateral_mm")[2])
    # with yaw the right wheel is ahead
    assert (found.numbers("right_longitudinal_position_mm")[1::2] > 1.0).all()


def test_rows_that_roll_have_their_creep_forces(tmp_path):
    """Lateral and vertical forces contain creep forces: they carry the load, and no torque is left without one."""
    rolling = 'friction = 0.3\nspeed_km_h = 80\nrolling_theory = "fastsim"\n[vary]'
    campaign = read(tmp_path, FILE.partition("lateral_mm =")[0].replace("[vary]", rolling) + "lateral_mm = [2.0]\n")
    first, rows = campaign.chunks[0]
    (found,) = compute(Chunk(rows, first)).results
    assert found.status == "converged", found.message
    assert set(campaign.known_columns) == set(found.values)
    assert {"row", *found.patches[0]} == set(campaign.patch_columns)
    left, right = ({name: found.values[f"{side}_{name}"] for name in LOADS} for side in ("left", "right"))
    load = campaign.rows[0].case.axle_load_kN
    assert left["vertical_force_kN"] + right["vertical_force_kN"] == pytest.approx(load, rel=1e-7)
    assert left["longitudinal_creep_force_kN"] == pytest.approx(-right["longitudinal_creep_force_kN"], rel=0.05)
    assert abs(left["longitudinal_creep_force_kN"]) > 0.01 * load
    for each in (left, right):
        assert each["frictional_power_W"] == pytest.approx(each["t_gamma_N"] * 80.0 / 3.6)
        assert each["share_of_nadal_limit"] is None or each["share_of_nadal_limit"] < 1.0


@pytest.mark.ci
def test_a_row_is_that_of_a_run_and_does_not_depend_on_the_others(sweep, monkeypatch):
    """A row computed alone in a worker that prepared nothing has the same bytes; `flangeway run` has its numbers."""
    campaign, found = sweep
    first, rows = campaign.chunks[0]
    monkeypatch.setattr(chunk, "_prepared", LatestValues(1))
    (alone,) = compute(Chunk(rows[2:3], first)).results
    for name, value in alone.values.items():
        if name not in ("lateral_mm", "yaw_mrad"):
            assert found.rows[name][2] == value
    run = rows[2].case.run()
    assert run.result.equilibrium.position.vertical_mm == pytest.approx(alone.values["vertical_mm"], rel=1e-12)
    assert run.patches[0].max_pressure == pytest.approx(alone.values["left_max_pressure_MPa"], rel=1e-9)
    assert run.wheels[1].head[0] == pytest.approx(alone.values["right_head_lateral_mm"], rel=1e-9)


def test_positions_share_their_bodies_and_plane_rows_are_those_of_plane_wheelsets(tmp_path):
    """Position, yaw and load leave the bodies; sleepers and profiles do not; plane rows are plane wheelsets."""
    text = 'case = "wheelset"\n[vary]\n{} = {}\n'
    rolling = text.replace("[vary]", "[inputs]\nspeed_km_h = 80\n[vary]")
    assert len(read(tmp_path, rolling.format("friction", "[0.2, 0.4]")).chunks) == 1
    for key, values in (("lateral_mm", "[0, 1]"), ("yaw_mrad", "[0, 1]"), ("axle_load_kN", "[100, 200]")):
        assert len(read(tmp_path, text.format(key, values)).chunks) == 1
    for key, values in (
        ("wheel_section", '["rim", "whole"]'),
        ("sleeper_position", "[0, 0.5]"),
        ("rail", '["60E1", "136RE"]'),
    ):
        assert len(read(tmp_path, text.format(key, values)).chunks) == 2
    both = read(tmp_path, text.format("model", '["plane", "spatial"]'))
    (plane,) = compute(Chunk(both.rows[:1])).results
    assert set(plane.values) == set(WheelsetTangentCase.from_values({}).columns())
    assert {"left_half_width_mm", "left_semi_axes_a_mm"} <= set(both.known_columns)


def test_a_position_that_cannot_be_reached_fails_alone(tmp_path):
    """A row beyond the rails reports the reason, in its own row."""
    campaign = read(tmp_path, FILE.replace("[-1.0, 1.0]", "[0.0, 90.0]").replace("[0.0, 5.0]", "[0.0]"))
    ((first, rows),) = campaign.chunks
    good, bad = compute(Chunk(rows, first)).results
    assert (good.status, bad.status) == ("converged", "not converged")
    assert "derail" in bad.message
