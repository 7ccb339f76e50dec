"""Contacts narrower than an element: forces are right within their stated error, or the solution has not converged."""

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from benchmarks.narrow_contacts import NarrowContact
from flangeway.cases.bodies.bodies_run import BodiesRun, TwoBodiesCase
from flangeway.cases.bodies.presets import HertzCase

YOUNG, POISSON, RADIUS, HEIGHT = 210e3, 0.3, 50.0, 60.0
SOFTNESS = (1.0 - POISSON**2) / (np.pi * YOUNG)


def line_approach(force: float) -> float:
    """Approach of the axis of a roller to the foot of a block under a force per length.

    Johnson (1985, 5.6): a disc between two forces, 2 ln(4 R / a) - 1, and a half plane down to a depth d,
    2 ln(2 d / a) - nu / (1 - nu), each times F (1 - nu^2) / (pi E).
    """
    half = np.sqrt(8.0 * force * RADIUS * SOFTNESS)
    disc = 2.0 * np.log(4.0 * RADIUS / half) - 1.0
    return force * SOFTNESS * (disc + 2.0 * np.log(2.0 * HEIGHT / half) - POISSON / (1.0 - POISSON))


def line_force(approach: float) -> float:
    """Force for an approach."""
    return brentq(lambda force: line_approach(force) - approach, 1e-9, 1e6)


def roller(
    motion: dict[str, Any], x: float = 0.0, size: float = 5.0, order: int = 1, height: float = 0.0, **contact: Any
) -> BodiesRun:
    """A half disc at a height above a block, meshed with one size."""
    elements = {"young_MPa": YOUNG, "poisson": POISSON, "size_mm": size, "order": order}
    disc = {"radius_mm": RADIUS, "centre_mm": [x, RADIUS + height], "half": "lower"}
    rectangle = {"width_mm": 200.0, "height_mm": HEIGHT, "centre_mm": [0.0, -HEIGHT / 2.0]}
    sides = {"secondary": "roller", "secondary_edges": "rim", "primary": "block", "primary_edges": "top"}
    return TwoBodiesCase.from_values(
        {
            "bodies": [
                {"name": "roller", "disc": disc} | elements,
                {"name": "block", "rectangle": rectangle} | elements,
            ],
            "supports": [{"body": "roller", "edges": "cut"}, {"body": "block", "edges": "bottom"}],
            "motions": [{"body": "roller", **motion}],
            "contacts": [sides | contact],
        }
    ).run()


DEPTHS, PAIRINGS = (0.02, 0.2), ("segment-to-segment", "node-to-segment")


@pytest.mark.parametrize(("pairing", "order"), list(itertools.product(PAIRINGS, (1, 2))))
def test_the_force_is_right_within_its_stated_error(pairing: str, order: int) -> None:
    """Drawn curves at 0.4 and 4 % of an edge, nodes anywhere: the closed form within the error and 5 % of the foot."""
    for depth, x in itertools.product(DEPTHS, (0.0, 2.6)):
        run = roller({"shift_mm": [0.0, -depth]}, x, order=order, pairing=pairing)
        assert run.status.converged, run.status.message
        error = run.contact.status.checks.force_error + 0.05
        assert abs(line_force(depth) / run.contact.forces[0, 1] - 1.0) < error, (depth, x)


@pytest.mark.parametrize("depth", DEPTHS)
def test_chords_are_refused_or_right_within_their_error(depth: float) -> None:
    """Chords of the roller, whose sagitta exceeds the small approaches: converged forces are right within the error."""
    for x in (0.0, 2.6):
        run = roller({"shift_mm": [0.0, -depth]}, x, curved=False)
        assert run.contact is not None
        assert not (run.status.converged and depth < 0.1)
        if run.status.converged:
            error = run.contact.status.checks.force_error + 0.05
            assert abs(line_force(depth) / run.contact.forces[0, 1] - 1.0) < error


def test_chords_of_a_sphere_are_refused_or_right_within_their_error() -> None:
    """The first edge at an axis has no edge before it: Hertz's 4/3 E* sqrt(R) d^1.5 within the stated error."""
    case = NarrowContact.random(1029)
    sphere, block = case.values["bodies"]
    softness = (1.0 - POISSON**2) * (1.0 / sphere["young_MPa"] + 1.0 / block["young_MPa"])
    radius = block["rectangle"]["height_mm"] / 2.0
    depth = -case.values["motions"][0]["shift_mm"][1]
    assert case.values["contacts"][0]["curved"] is False
    pressed = case.solve()
    right = 4.0 / 3.0 / softness * np.sqrt(radius) * depth**1.5
    assert abs(right / pressed.force - 1.0) < pressed.error


@pytest.mark.parametrize("pairing", PAIRINGS)
def test_with_friction_nothing_touches_only_where_surfaces_are_apart(pairing: str) -> None:
    """Nodes alone are guarded with friction: an overlap between them is refused, a force is right within its error."""
    for depth, x in itertools.product((0.02, 0.2), (0.0, 2.6)):
        run = roller({"shift_mm": [0.0, -depth]}, x, friction=0.3, pairing=pairing)
        assert run.contact is not None
        if run.status.converged:
            error = run.contact.status.checks.force_error + 0.05
            assert abs(line_force(depth) / run.contact.forces[0, 1] - 1.0) < error, (depth, x)


@pytest.mark.parametrize("gap", [0.1, 0.0])
def test_a_roller_that_does_not_reach_the_block_has_no_force(gap: float) -> None:
    """Chords that follow their circle, in the drawing and after the motion: nothing touches, and nothing passed."""
    run = roller({"shift_mm": [0.0, -1e-9]}, height=gap)
    assert run.status.converged, run.status.message
    assert run.contact is not None
    assert not run.contact.forces.any()


@pytest.mark.parametrize("force", [20.0, 2000.0])
def test_a_roller_under_a_small_load_does_not_sink(force: float) -> None:
    """Under a prescribed force the approach is right within its error: chords and averages would sink by 0.05 mm."""
    for x in (0.0, 2.6):
        run = roller({"push_N": [0.0, -force]}, x)
        assert run.status.converged, run.status.message
        exact = line_approach(force)
        assert abs(run.pushed_mm - exact) < run.contact.status.checks.approach_error + 0.05 * exact


def test_chords_under_a_prescribed_force_state_the_error_of_the_approach() -> None:
    """However small the force is, it is exact on chords, and the approach is right within the stated length."""
    for force, x in itertools.product((1e-6, 20.0), (0.0, 2.6)):
        run = roller({"push_N": [0.0, -force]}, x, curved=False)
        assert run.status.converged, run.status.message
        assert run.contact.forces[0, 1] == pytest.approx(force, rel=1e-6)
        checks = run.contact.status.checks
        exact = line_approach(force)
        assert 1e-3 < checks.approach_error < 0.1 * 5.0
        assert abs(run.pushed_mm - exact) < checks.approach_error + 0.05 * exact
        assert checks.force_error == 0.0
        assert any("approach" in warning for warning in checks.warnings)


@pytest.mark.parametrize("indentation", [1e-6, 1e-5, 1e-3])
def test_an_indentation_below_the_tolerance_has_a_force(indentation: float) -> None:
    """Twice the closed form of a disc between forces, within the stated error, however small the indentation is."""
    run = HertzCase.from_values({"indentation_mm": indentation, "thickness_mm": 1.0}).run()
    softness = (1.0 - 1.0 / 9.0) / (np.pi * 200e3)

    def approach(force: float) -> float:
        return 2.0 * force * softness * (2.0 * np.log(160.0 / np.sqrt(8.0 * force * 20.0 * softness)) - 1.0)

    force = brentq(lambda force: approach(force) - indentation, 1e-12, 1e6)
    assert run.status.converged, run.status.message
    assert abs(force / run.contact.forces[0, 1] - 1.0) < run.contact.status.checks.force_error + 0.03


def test_a_fine_mesh_states_no_error() -> None:
    """Hertz's contact over 30 edges has an error of the force below 1 %, and no warning of it; a coarse one has."""
    run = HertzCase.from_values({}).run()
    assert run.status.checks.force_error < 0.01
    assert not any("may be off" in notice for notice in run.notices)
    coarse = HertzCase.from_values({"indentation_mm": 1e-3}).run()
    assert coarse.status.converged
    assert any("may be off" in notice for notice in coarse.notices)


def test_surfaces_that_end_within_the_contact_are_refused() -> None:
    """A sphere whose contact reaches 7.9 mm, on a surface that ends at 5.7: the flat beyond it lies in the sphere."""
    coarse = NarrowContact.random(166).solve()
    assert not coarse.converged
    assert "give all edges that may touch" in coarse.message
