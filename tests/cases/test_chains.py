"""Cases of chains and rings of bodies with friction: statics, rolling, Lamé's pressure, files, and bad inputs."""

import meshio
import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.cases.bodies.two_bodies import TwoBodiesCase
from flangeway.errors import InputError
from flangeway.report.case_outputs import write_case

ROLLER = {"size_mm": 0.12, "body_size_mm": 8.0}


@pytest.mark.parametrize("enforcement", ["multiplier", "penalty", "augmented-lagrange"])
def test_a_stack_slides_where_friction_is_least(enforcement: str) -> None:
    """The push is carried through; the limit of the lower interface is the shifting force; work is force times slip."""
    run = load_case("stack", enforcement=enforcement, size_mm=8.0).run()
    assert run.status.converged, run.status.message
    lower, upper = run.summary["friction"]
    assert lower["tangential_force_N"] == pytest.approx(0.2 * 20e3, rel=1e-3)
    assert lower["sticking_share"] == 0.0
    assert upper["sticking_share"] > 0.9
    assert lower["dissipated_N_mm"] == pytest.approx(4e3 * run.summary["results"]["middle_shift_mm"][0], rel=0.05)
    assert run.summary["results"]["force_on_middle_by_lower_N"][1] == pytest.approx(20e3, rel=1e-6)
    assert max(step.state.status.iterations for step in run.contact.steps) <= 30


def test_a_roller_rolls_by_half_of_the_way(tmp_path) -> None:
    """Its middle moves by half of the plate's shift and turns by that over its radius; files have the tractions."""
    run = load_case("roller-between-plates", **ROLLER).run()
    assert run.status.converged, run.status.message
    results = run.summary["results"]
    assert results["roller_shift_mm"][0] == pytest.approx(0.25, rel=0.01)
    assert results["roller_rotation_deg"] == pytest.approx(np.degrees(-0.25 / 20.0), rel=0.01)
    assert results["max_pressure_MPa"] == pytest.approx(results["hertz_max_pressure_MPa"], rel=0.1)
    assert all(each["dissipated_N_mm"] >= 0.0 for each in run.summary["friction"])
    write_case(run, tmp_path)
    contact = meshio.read(tmp_path / "contact.vtu").point_data
    limits = 0.2 * contact["pressure_MPa"]
    assert np.abs(contact["traction_MPa"]).max() > 0.0
    assert (np.abs(contact["traction_MPa"]) <= 1.001 * limits + 1e-6 * limits.max()).all()
    assert np.isfinite(contact["slip_mm"]).all()
    assert (tmp_path / "traction.png").exists()
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Coulomb's friction, coefficient 0.2." in page.replace("&#x27;", "'").replace("&#39;", "'")
    assert "leg 2: 100 %" in page


def test_rollers_of_a_bearing_share_the_load() -> None:
    """Without interference the two lower rollers carry the force each, by statics; with it all three carry."""
    coarse = {"size_mm": 0.25, "body_size_mm": 8.0}
    loose = load_case("bearing-ring", interference_mm=0.0, **coarse).run()
    assert loose.status.converged, loose.status.message
    for roller in ("2", "3"):
        force = loose.summary["results"][f"force_on_roller_{roller}_by_ring_N"]
        assert np.hypot(*force) == pytest.approx(10e3, rel=0.01)
    tight = load_case("bearing-ring", **coarse).run()
    assert tight.status.converged, tight.status.message
    forces = np.array([tight.summary["results"][f"force_on_roller_{n}_by_ring_N"] for n in (1, 2, 3)])
    assert np.linalg.norm(forces, axis=1).min() > 1e3
    np.testing.assert_allclose(forces.sum(axis=0), [0.0, 10e3], atol=1.0)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_shrink_fit_has_lames_pressure(friction: float) -> None:
    """The mean pressure of the fit within 0.5 %, and it is uniform to 1 %; only an overlap not intended is named."""
    case = load_case("shrink-fit", friction=friction)
    run = case.run()
    values = case.general().model_dump()
    assert run.summary["notices"] == []
    values["contacts"][0]["interference"] = False
    (notice,) = TwoBodiesCase.from_values(values).run().summary["notices"]
    assert "hub on shaft: the surfaces overlapped by 0.02 mm before any motion" in notice
    assert run.status.converged, run.status.message
    assert abs(run.summary["results"]["pressure_difference"]) < 5e-3
    assert run.summary["results"]["max_pressure_MPa"] == pytest.approx(
        run.summary["results"]["lame_pressure_MPa"], rel=0.01
    )


def test_a_barrier_of_a_case_is_that_of_multipliers_with_a_gap() -> None:
    """The pressure of a shrink fit by a small barrier is nearly that of multipliers."""
    given = {"enforcement": "barrier", "friction": 0.0}
    values = load_case("shrink-fit", friction=0.0).general().model_dump()
    values["contacts"] = [{**values["contacts"][0], **given, "barrier_N_per_mm": 1e-3, "barrier_reach_mm": 0.01}]
    run = TwoBodiesCase.from_values(values).run()
    assert run.status.converged, run.status.message
    assert run.summary["contacts"][0]["max_pressure_MPa"] == pytest.approx(60.6, rel=0.02)
    values["contacts"] = [{**values["contacts"][0], "barrier_reach_mm": None}]
    with pytest.raises(InputError, match="a barrier without"):
        TwoBodiesCase.from_values(values).check()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"motions": [{"body": "upper", "leg": 2, "push_N": (0.0, -1e3)}]}, "in leg 1"),
        ({"motions": [{"body": "middle", "shift_mm": (0.0, -0.1)}]}, "which has no supports"),
    ],
)
def test_what_friction_and_floating_bodies_do_not_go_with_is_refused(change, message) -> None:
    """Late pushes, and motions of bodies without supports."""
    values = load_case("stack", size_mm=10.0).general().model_dump()
    with pytest.raises(InputError, match=message):
        TwoBodiesCase.from_values({**values, **change}).check()


def test_radii_of_a_shrink_fit_rise_and_rolling_stays_on_the_roller() -> None:
    """Wrong sizes are named."""
    with pytest.raises(InputError, match="radii of bore, fit and hub"):
        load_case("shrink-fit", fit_radius_mm=60.0).check()
    with pytest.raises(InputError, match="contacts that reach"):
        load_case("roller-between-plates", shift_mm=40.0).check()
