"""Cases of chains and rings of bodies with friction: statics, rolling, Lamé's pressure, files, and bad inputs."""

import meshio
import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.cases.bodies.bodies_run import TwoBodiesCase
from flangeway.errors import InputError
from flangeway.report.case_outputs import write_case


def coarse(name: str, n_bodies: int, fine_mm: float) -> dict[str, float]:
    """Sizes of the bodies of an example that are twice as large, and those where they are finer."""
    sizes = {f"bodies.{number}.size_mm": 8.0 for number in range(1, n_bodies + 1)}
    values = load_case(name).model_dump()["bodies"]
    for number, body in enumerate(values, 1):
        sizes |= {f"bodies.{number}.fine.{n}.size_mm": fine_mm for n in range(1, len(body["fine"]) + 1)}
    return sizes


@pytest.mark.parametrize("enforcement", ["multiplier", "augmented-lagrange"])
def test_a_stack_slides_where_friction_is_least(enforcement: str) -> None:
    """The push is carried through; the limit of the lower interface is the shifting force; work is force times slip."""
    changes = {f"contacts.{number}.enforcement": enforcement for number in (1, 2)} | coarse("stack", 3, 8.0)
    run = load_case("stack", **changes).run()
    assert run.status.converged, run.status.message
    lower, upper = run.summary["friction"]
    assert lower["tangential_force_N"] == pytest.approx(0.2 * 20e3, rel=1e-3)
    assert lower["sticking_share"] == 0.0
    assert upper["sticking_share"] > 0.9
    assert lower["dissipated_N_mm"] == pytest.approx(4e3 * run.shift("middle")[0], rel=0.05)
    assert run.summary["contacts"][0]["force_on_secondary_N"][1] == pytest.approx(20e3, rel=1e-6)
    assert max(step.state.status.iterations for step in run.contact.steps) <= 30


@pytest.mark.ci
def test_a_roller_rolls_by_half_of_the_way(tmp_path) -> None:
    """Its middle moves by half of the plate's shift and turns by that over its radius; files have the tractions."""
    run = load_case("roller-between-plates", **coarse("roller-between-plates", 3, 0.15)).run()
    assert run.status.converged, run.status.message
    placement = run.bodies["roller"].placement
    assert placement.points([(0.0, 20.0)])[0, 0] == pytest.approx(0.25, rel=0.01)
    assert placement.rotation_rad == pytest.approx(-0.25 / 20.0, rel=0.01)
    assert [each["max_pressure_MPa"] for each in run.summary["contacts"]] == pytest.approx([1916.5, 1916.5], rel=0.1)
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


@pytest.mark.ci
def test_rollers_of_a_bearing_share_the_load() -> None:
    """Without interference the two lower rollers carry the force each, by statics; with it all three carry."""
    sizes = coarse("bearing-ring", 5, 0.25)
    fitting = {f"bodies.roller-{n}.disc.radius_mm": 8.0 for n in (1, 2, 3)}
    loose, tight = (load_case("bearing-ring", **sizes, **more).run() for more in (fitting, {}))
    for run in (loose, tight):
        assert run.status.converged, run.status.message
    for number in (2, 4):
        assert np.hypot(*loose.contact.forces[number]) == pytest.approx(10e3, rel=0.01)
    on_rollers = tight.contact.forces[::2]
    assert np.linalg.norm(on_rollers, axis=1).min() > 1e3
    np.testing.assert_allclose(on_rollers.sum(axis=0), [0.0, 10e3], atol=1.0)


def test_a_shrink_fit_has_lames_pressure() -> None:
    """The mean pressure within 0.5 % of that of two tubes (Timoshenko and Goodier, Theory of elasticity, 28)."""
    (bore, fit, rim), modulus, ratio = (10.0, 25.0, 50.0), 210e3 / (1.0 - 0.3**2), 0.3 / 0.7
    hub, shaft = (rim**2 + fit**2) / (rim**2 - fit**2) + ratio, (fit**2 + bore**2) / (fit**2 - bore**2) - ratio
    lame = modulus * 0.02 / (fit * (hub + shaft))
    run, bare = (
        load_case("shrink-fit", **{"contacts.1.friction": 0.2}, **more).run()
        for more in ({}, {"contacts.1.interference": False})
    )
    assert run.status.converged, run.status.message
    assert run.summary["notices"] == []
    (notice,) = bare.summary["notices"]
    assert "hub on shaft: the surfaces overlapped by 0.02 mm before any motion" in notice
    # each component of the force of a quarter acts on the length of its radius
    assert run.contact.forces[0].mean() / (fit * 10.0) == pytest.approx(lame, rel=5e-3)
    assert run.summary["contacts"][0]["max_pressure_MPa"] == pytest.approx(lame, rel=0.01)


@pytest.mark.parametrize("pairing", ["segment-to-segment", "node-to-segment"])
def test_a_shrink_fit_is_augmented_in_few_iterations(pairing: str) -> None:
    """Where nodes of both surfaces are opposite each other within the penetration no part of an edge comes and goes."""
    changes = {"contacts.1.enforcement": "augmented-lagrange", "contacts.1.pairing": pairing}
    run = load_case("shrink-fit", **changes).run()
    assert run.status.converged, run.status.message
    assert run.status.iterations < 10
    assert run.summary["contacts"][0]["max_pressure_MPa"] == pytest.approx(60.58, rel=0.01)


def test_a_barrier_of_a_case_is_that_of_multipliers_with_a_gap() -> None:
    """The pressure of a shrink fit by a small barrier is nearly that of multipliers."""
    barrier = {"kind": "barrier", "barrier_N_per_mm": 1e-3, "reach_mm": 0.01}
    run = load_case("shrink-fit", **{"contacts.1.enforcement": barrier}).run()
    assert run.status.converged, run.status.message
    assert run.summary["contacts"][0]["max_pressure_MPa"] == pytest.approx(60.6, rel=0.02)
    with pytest.raises(InputError, match=r"no contacts\[1\]\.enforcement\.barrier_N_per_mm"):
        load_case("shrink-fit", **{"contacts.1.enforcement": "barrier"})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"motions": [{"body": "upper", "leg": 2, "push_N": (0.0, -1e3)}]}, r"motions\[1\].leg = 2"),
        ({"motions": [{"body": "middle", "shift_mm": (0.0, -0.1)}]}, "which has no supports"),
    ],
)
def test_what_friction_and_floating_bodies_do_not_go_with_is_refused(change, message) -> None:
    """Late pushes, and motions of bodies without supports."""
    values = load_case("stack").model_dump()
    with pytest.raises(InputError, match=message):
        TwoBodiesCase.from_values({**values, **change}).check()
