"""The summary of a run, for programs."""

import pytest

from flangeway.cases import WheelsetTangentCase
from flangeway.report.wheelset.wheelset_page import wheelset_record

IN_SPACE = {"horizontal_in_space_mm", "vertical_in_space_mm"}
SHAPE = {
    "status": {"converged", "message"},
    "position": {"vertical_mm", "lateral_mm", "roll_mrad", "approach_mm", "stable", "reference"} | IN_SPACE,
    "load": {"vertical_kN", "lateral_kN", "tilt_rad", "lateral_in_track_kN", "onto_track_kN"},
    "residual": {"vertical", "lateral", "moment", "equilibrium"},
    "timings_s": {"meshing", "condensation", "contact", "post_processing", "total"},
    "versions": {"flangeway", "python", "numpy", "scipy", "gmsh"},
}
BELOW = {f"in_{role}_{name}" for role in ("rail", "wheel") for name in (
    "max_in_plane_shear_MPa", "max_in_plane_shear_depth_mm", "max_von_mises_MPa", "max_von_mises_depth_mm",
)}  # fmt: skip
PATCH = {
    "side", "region", "normal_force_kN", "lateral_force_kN", "vertical_force_kN", "rail_position_mm",
    "wheel_position_mm", "track_position_mm", "contact_angle_deg", "half_width_mm", "max_pressure_MPa",
    "max_pressure_remark", "pressure_oscillation", "hertz_half_width_mm", "hertz_pressure_MPa", "nodes", *BELOW,
}  # fmt: skip


@pytest.fixture(scope="module")
def run():
    """A wheelset on coarse meshes."""
    return WheelsetTangentCase.from_values({"size_scale": 4.0}).run()


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
    assert all(set(patch) == PATCH for patch in run.summary["patches"])
    kinds = {type(value) for value in leaves({**run.summary, "case": {}})}
    assert kinds <= {str, bool, int, float, type(None)}  # no remark is null
    inputs = {type(value) for value in run.summary["case"].values()}
    assert inputs <= {str, bool, int, float, type(None)}  # an input that was left out is null


def test_inputs_and_assumptions_are_told(run):
    """All inputs are in the summary, and so are assumptions."""
    inputs = dict(run.summary["case"])
    assert inputs.pop("name") == "wheelset-tangent"
    assert WheelsetTangentCase.from_values(inputs) == run.case
    assert len(run.summary["assumptions"]) > 3


def test_numbers_that_are_not_finite_become_null(run):
    """A number that is not finite is written as null, since JSON has no other word for it."""
    assert type(run)(run.case, run.result, float("inf")).summary["timings_s"]["total"] is None


def test_a_prescribed_motion_is_not_in_equilibrium():
    """With a prescribed component the residual is that of the free ones; the force that holds it is in `residual`."""
    run = WheelsetTangentCase.from_values({"lateral_mm": 2.0, "size_scale": 4.0}).run()
    summary = run.summary
    assert summary["residual"]["equilibrium"] < 1e-9
    assert abs(summary["residual"]["lateral"]) * 28.4e3 == pytest.approx(  # Moherdaui (2021), 7.2.2
        1e3 * abs(sum(side["lateral_force_kN"] for side in summary["sides"])), rel=1e-9
    )
    assert abs(summary["residual"]["lateral"]) > 1e-3
    assert summary["position"]["stable"] is None
    assert wheelset_record(run).results.rows[0][1] == "2.000"
