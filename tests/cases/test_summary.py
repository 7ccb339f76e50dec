"""The summary of a run, for programs."""

import json

import numpy as np
import pytest

from flangeway.cases import WheelsetCurveCase, WheelsetTangentCase, summarise, write_summary
from flangeway.report.wheelset.wheelset_tables import position_table

IN_SPACE = {"horizontal_in_space_mm", "vertical_in_space_mm"}
SHAPE = {
    "status": {"converged", "message"},
    "position": {"vertical_mm", "lateral_mm", "roll_rad", "approach_mm", "stable", "reference"} | IN_SPACE,
    "load": {"vertical_kN", "lateral_kN", "tilt_rad", "lateral_in_track_kN", "onto_track_kN"},
    "residual": {"vertical", "lateral", "moment", "equilibrium"},
    "timings_s": {"meshing", "condensation", "contact", "post_processing", "total"},
    "versions": {"flangeway", "python", "numpy", "scipy", "gmsh"},
}
CONTACT = {
    "side", "region", "force_kN", "lateral_force_kN", "vertical_force_kN", "rail_position_mm", "wheel_position_mm",
    "space_position_mm", "contact_angle_deg", "half_width_mm", "max_pressure_MPa", "max_pressure_remark",
    "pressure_oscillation",
    "hertz_half_width_mm", "hertz_pressure_MPa", "hertz_in_plane_shear_MPa", "hertz_in_plane_shear_depth_mm", "n_nodes",
    "in_rail", "in_wheel",
}  # fmt: skip
RIGID_CONTACT = {
    "side", "force_kN", "lateral_force_kN", "vertical_force_kN", "contact_angle_deg", "rail_position_mm",
    "wheel_position_mm", "space_position_mm", "rolling_radius_mm", "hertz_half_width_mm", "hertz_pressure_MPa",
}  # fmt: skip
BELOW = {
    "max_in_plane_shear_MPa", "max_in_plane_shear_depth_mm", "max_von_mises_MPa", "max_von_mises_depth_mm",
}  # fmt: skip


@pytest.fixture(scope="module")
def runs():
    """Solved cases by method."""
    return {
        method: WheelsetTangentCase.from_values({"method": method, "size_scale": 2.0}).run()
        for method in ("fem", "vem")
    }


@pytest.fixture(params=["fem", "vem"])
def run(runs, request):
    return runs[request.param]


def leaves(value):
    if isinstance(value, dict | list):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from leaves(entry)
    else:
        yield value


def test_keys_are_those_that_programs_rely_on(run):
    """The summary has its keys, and its values are Python's own, so that any program can read them."""
    for key, names in SHAPE.items():
        assert set(run.summary.to_dict()[key]) == names
    assert all(set(contact) == CONTACT for contact in run.summary.to_dict()["contacts"])
    for contact in run.summary.to_dict()["contacts"]:
        assert set(contact["in_rail"]) == set(contact["in_wheel"]) == BELOW
    assert all(set(contact) == RIGID_CONTACT for contact in run.summary.to_dict()["rigid"]["contacts"])
    kinds = {type(value) for value in leaves({**run.summary.to_dict(), "case": {}})}
    assert kinds <= {str, bool, int, float, type(None)}  # no remark is null
    inputs = {type(value) for value in run.summary.case.values()}
    assert inputs <= {str, bool, int, float, type(None)}  # an input that was left out is null


def test_the_file_holds_the_summary(run, tmp_path):
    """What is read from the file is what was written, to the last digit."""
    write_summary(tmp_path / "summary.json", run.summary)
    text = (tmp_path / "summary.json").read_text(encoding="utf-8")
    assert json.loads(text) == run.summary.to_dict()
    assert "NaN" not in text


def test_forces_balance_the_load(run):
    """Vertical forces sum to 300 kN, both sides are equal to 0.1 %, and lateral forces cancel."""
    left, right = run.summary.to_dict()["contacts"]
    assert (left["side"], right["side"]) == ("left", "right")
    assert left["vertical_force_kN"] + right["vertical_force_kN"] == pytest.approx(300.0, rel=1e-9)
    assert left["force_kN"] == pytest.approx(right["force_kN"], rel=1e-3)
    assert left["lateral_force_kN"] + right["lateral_force_kN"] == pytest.approx(0.0, abs=1e-6)
    assert left["lateral_force_kN"] > 0.0
    assert run.summary.residual.equilibrium < 1e-10
    assert run.summary.status.converged is True


def test_sides_mirror_each_other(run):
    """The axle neither slides nor tilts, and the contacts are at mirrored places, equal on the profiles."""
    motion = run.summary.to_dict()["position"]
    assert 0.1 < motion["approach_mm"] < 2.0
    assert abs(motion["lateral_mm"]) < 1e-3 * motion["approach_mm"]
    assert abs(motion["roll_rad"]) * 1000.0 < 1e-3 * motion["approach_mm"]
    left, right = run.summary.to_dict()["contacts"]
    for key in ("rail_position_mm", "wheel_position_mm"):
        assert np.allclose(left[key], right[key], atol=1e-6)
    assert np.allclose(left["space_position_mm"], np.array(right["space_position_mm"]) * (-1, 1), atol=1e-6)
    assert right["space_position_mm"][0] > 0.0


def test_pressure_is_near_that_of_hertz(run):
    """The maximum pressure is within 10 % of Hertz's and the half width within a node's spacing of his."""
    for contact in run.summary.to_dict()["contacts"]:
        assert contact["max_pressure_MPa"] == pytest.approx(contact["hertz_pressure_MPa"], rel=0.1)
        assert contact["half_width_mm"] == pytest.approx(contact["hertz_half_width_mm"], abs=0.75)
        assert contact["n_nodes"] >= 8


def test_sizes_and_stresses_are_those_of_the_bodies(run):
    """Bodies have the counts of their meshes, stresses the extremes of all parts, left as right."""
    model = run.result.model
    for row, body in zip(run.summary.to_dict()["bodies"], (model.wheel, model.rail), strict=True):
        assert (row["name"], row["elements"], row["nodes"]) == (body.name, body.mesh.n_cells, body.space.n_nodes)
        assert row["unknowns"] == int(body.free.sum())
        assert row["parts"] == [f"{body.name}-left", f"{body.name}-right"]
    extremes = {row["part"]: row for row in run.summary.to_dict()["stresses"]}
    assert set(extremes) == set(model.parts)
    for body in ("wheel", "rail"):
        left, right = (extremes[f"{body}-{side}"] for side in ("left", "right"))
        assert left["min_principal_MPa"] == pytest.approx(right["min_principal_MPa"], rel=1e-6)
        assert left["min_principal_MPa"] < -1000.0


def test_inputs_and_assumptions_are_told(run):
    """All inputs are in the summary, and so are the assumptions with the wheel's uncertain origin."""
    inputs = dict(run.summary.case)
    assert inputs.pop("name") == "wheelset-tangent"
    assert WheelsetTangentCase.from_values(inputs) == run.case
    text = " ".join(run.summary.assumptions)
    for word in ("Plane strain", "10 mm", "AAR-1B (approximate)", "without friction", "base"):
        assert word in text


def test_numbers_that_are_not_finite_become_null(runs):
    """A number that is not finite is written as null, since JSON has no other word for it."""
    run = runs["fem"]
    assert summarise(run.case, run.result, float("inf")).timings_s["total"] is None


def test_rigid_wheels_stand_beside_the_elastic_ones(run):
    """The rigid wheelset carries the same load, at contact angles and with Hertz's pressures near the elastic ones."""
    rigid, contacts = run.summary.to_dict()["rigid"], run.summary.to_dict()["contacts"]
    assert sum(c["vertical_force_kN"] for c in rigid["contacts"]) == pytest.approx(300.0, rel=1e-6)
    for one, other in zip(rigid["contacts"], contacts, strict=True):
        assert one["side"] == other["side"]
        assert one["contact_angle_deg"] == pytest.approx(other["contact_angle_deg"], abs=0.2)
        assert one["hertz_pressure_MPa"] == pytest.approx(other["hertz_pressure_MPa"], rel=0.02)
    fall = rigid["vertical_mm"] - run.summary.to_dict()["position"]["vertical_mm"]
    assert fall == pytest.approx(run.summary.to_dict()["position"]["approach_mm"], abs=1e-3)


def test_stresses_below_the_contacts_are_told(run):
    """In-plane shear is above that of Hertz's half planes by less than a half, at about his depth."""
    for contact in run.summary.to_dict()["contacts"]:
        for body in ("in_rail", "in_wheel"):
            ratio = contact[body]["max_in_plane_shear_MPa"] / contact["hertz_in_plane_shear_MPa"]
            assert 1.0 < ratio < 1.5
            depth = contact[body]["max_in_plane_shear_depth_mm"] / contact["hertz_in_plane_shear_depth_mm"]
            assert 0.6 < depth < 1.3
            assert contact[body]["max_von_mises_MPa"] > contact[body]["max_in_plane_shear_MPa"] * 1.5


def test_a_prescribed_motion_is_not_in_equilibrium():
    """With a prescribed component the residual is that of the free ones; the force that holds it is in `residual`."""
    case = WheelsetTangentCase.from_values({"lateral_mm": 2.0, "size_scale": 4.0})
    summary = case.run().summary
    assert summary.residual.equilibrium < 1e-9
    assert abs(summary.residual.lateral) * 28.4e3 == pytest.approx(  # Moherdaui (2021), 7.2.2
        1e3 * abs(sum(each.lateral_force_kN for each in summary.sides)), rel=1e-9
    )
    assert abs(summary.residual.lateral) > 1e-3
    assert summary.position.stable is None
    assert all(contact.force_kN is None for contact in summary.rigid.contacts)
    assert summary.rigid.lateral_mm == pytest.approx(2.0)
    said = [row[0] for row in position_table(summary).rows]
    assert "  vertical" in said
    assert "  lateral" not in said


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        ({}, True),
        ({"method": "vem", "order": 2}, True),
        ({"axle_load_kN": 301.0}, False),
        ({"size_scale": 0.9}, False),
        ({"rail": "60E1"}, False),
    ],
)
def test_the_published_position_is_shown_for_its_own_inputs_only(values, shown):
    """The published position of the curve stands only beside default inputs, method and order excepted."""
    assert bool(WheelsetCurveCase.from_values(values).published_position()) == shown


def test_straight_track_has_no_published_position():
    """Moherdaui (2021) gives no position on straight track."""
    assert WheelsetTangentCase.from_values({}).published_position() is None
