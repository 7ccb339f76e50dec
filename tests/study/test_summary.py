"""The summary of a run, for programs."""

import json

import numpy as np
import pytest

from flangeway.study import WheelsetTangentCase, summarise, write_summary

IN_SPACE = {"horizontal_in_space_mm", "vertical_in_space_mm"}
SHAPE = {
    "status": {"converged", "message"},
    "motion": {"vertical_mm", "lateral_mm", "roll_rad", "approach_mm", "reference"} | IN_SPACE,
    "load": {"vertical_kN", "lateral_kN", "tilt_rad", "along_track_kN", "onto_track_kN"},
    "balance": {"vertical_error", "lateral_error", "moment_error", "resulting_error"},
    "timings_s": {"meshing", "assembly", "factorisation", "contact", "post_processing", "total"},
    "versions": {"flangeway", "python", "numpy", "scipy", "gmsh"},
}
CONTACT = {
    "side", "region", "force_kN", "lateral_force_kN", "vertical_force_kN", "rail_position_mm", "wheel_position_mm",
    "space_position_mm", "half_width_mm", "max_pressure_MPa", "pressure_scatter", "hertz_half_width_mm",
    "hertz_pressure_MPa", "n_nodes",
}  # fmt: skip


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
        assert set(run.summary[key]) == names
    assert all(set(contact) == CONTACT for contact in run.summary["contacts"])
    kinds = {type(value) for value in leaves({**run.summary, "case": {}})}
    assert kinds <= {str, bool, int, float}
    inputs = {type(value) for value in run.summary["case"].values()}
    assert inputs <= {str, bool, int, float, type(None)}  # an input that was left out is null


def test_the_file_holds_the_summary(run, tmp_path):
    """What is read from the file is what was written, to the last digit."""
    write_summary(tmp_path / "summary.json", run.summary)
    text = (tmp_path / "summary.json").read_text(encoding="utf-8")
    assert json.loads(text) == run.summary
    assert "NaN" not in text


def test_forces_balance_the_load(run):
    """Vertical forces sum to 300 kN, both sides are equal to 0.1 %, and lateral forces cancel."""
    left, right = run.summary["contacts"]
    assert (left["side"], right["side"]) == ("left", "right")
    assert left["vertical_force_kN"] + right["vertical_force_kN"] == pytest.approx(300.0, rel=1e-9)
    assert left["force_kN"] == pytest.approx(right["force_kN"], rel=1e-3)
    assert left["lateral_force_kN"] + right["lateral_force_kN"] == pytest.approx(0.0, abs=1e-6)
    assert left["lateral_force_kN"] > 0.0
    assert run.summary["balance"]["resulting_error"] < 1e-10
    assert run.summary["status"]["converged"] is True


def test_sides_mirror_each_other(run):
    """The axle neither slides nor tilts, and the contacts are at mirrored places, equal on the profiles."""
    motion = run.summary["motion"]
    assert 0.1 < motion["approach_mm"] < 2.0
    assert abs(motion["lateral_mm"]) < 1e-3 * motion["approach_mm"]
    assert abs(motion["roll_rad"]) * 1000.0 < 1e-3 * motion["approach_mm"]
    left, right = run.summary["contacts"]
    for key in ("rail_position_mm", "wheel_position_mm"):
        assert np.allclose(left[key], right[key], atol=1e-6)
    assert np.allclose(left["space_position_mm"], np.array(right["space_position_mm"]) * (-1, 1), atol=1e-6)
    assert right["space_position_mm"][0] > 0.0


def test_pressure_is_near_that_of_hertz(run):
    """The largest pressure is within 10 % of Hertz's and the half width within a node's spacing of his."""
    for contact in run.summary["contacts"]:
        assert contact["max_pressure_MPa"] == pytest.approx(contact["hertz_pressure_MPa"], rel=0.1)
        assert contact["half_width_mm"] == pytest.approx(contact["hertz_half_width_mm"], abs=0.75)
        assert contact["n_nodes"] >= 8


def test_sizes_and_stresses_are_those_of_the_bodies(run):
    """Bodies have the counts of their meshes, stresses the extremes of all parts, left as right."""
    model = run.result.model
    for row, body in zip(run.summary["bodies"], (model.wheel, model.rail), strict=True):
        assert (row["name"], row["cells"], row["points"]) == (body.name, body.mesh.n_cells, body.mesh.n_points)
        assert row["unknowns"] == int(body.free.sum())
        assert row["parts"] == [f"{body.name}-left", f"{body.name}-right"]
    extremes = {row["part"]: row for row in run.summary["stresses"]}
    assert set(extremes) == set(model.parts)
    for body in ("wheel", "rail"):
        left, right = (extremes[f"{body}-{side}"] for side in ("left", "right"))
        assert left["min_principal_MPa"] == pytest.approx(right["min_principal_MPa"], rel=1e-6)
        assert left["min_principal_MPa"] < -1000.0


def test_inputs_and_assumptions_are_told(run):
    """All inputs are in the summary, and so are the assumptions with the wheel's uncertain origin."""
    inputs = dict(run.summary["case"])
    assert inputs.pop("name") == "wheelset-tangent"
    assert WheelsetTangentCase.from_values(inputs) == run.case
    text = " ".join(run.summary["assumptions"])
    for word in ("Plane strain", "10 mm", "AAR-1B (approximate)", "without friction", "base"):
        assert word in text


def test_numbers_that_are_not_finite_become_null(runs):
    """A number that is not finite is written as null, since JSON has no other word for it."""
    run = runs["fem"]
    assert summarise(run.case, run.result, float("inf"))["timings_s"]["total"] is None
