"""Contact of bodies of revolution of order 1: the pressure on the axis beside Hertz's and that of a cone."""

import numpy as np
import pytest

from flangeway.cases.bodies.bodies_run import TwoBodiesCase
from flangeway.post import pressure_patches

RADIUS, FORCE, YOUNG, POISSON = 8.0, 188.4955592, 1000.0, 0.3


def _case(path, size, pairing, young, edge):
    fine = [{"at_mm": [[0.0, 0.0], [1.5, 0.1]], "size_mm": size}]
    bodies = [
        {"name": "upper", "outline": {"path": path}, "young_MPa": YOUNG, "poisson": POISSON},
        {"name": "flat", "rectangle": {"width_mm": 12.0, "height_mm": 6.0, "centre_mm": [6.0, -3.0]},
         "young_MPa": young, "poisson": POISSON},
    ]  # fmt: skip
    contact = {"secondary": "upper", "secondary_edges": edge, "primary": "flat", "primary_edges": "top"}
    return TwoBodiesCase.from_values(
        {
            "hypothesis": "axisymmetric",
            "bodies": [body | {"order": 1, "size_mm": 0.9, "fine": fine} for body in bodies],
            "supports": [{"body": "upper", "edges": "cut"}, {"body": "flat", "edges": "bottom"}],
            "motions": [{"body": "upper", "push_N": [0.0, -FORCE]}],
            "contacts": [contact | {"pairing": pairing}],
        }
    ).run()


def _patch(run):
    (patch,) = pressure_patches(run.contact.system, run.contact.state)
    return patch


@pytest.mark.parametrize(
    ("size", "pairing", "young"),
    [
        (0.12, "segment-to-segment", 1e9),
        (0.09, "segment-to-segment", 1e9),
        (0.06, "segment-to-segment", 1e9),
        (0.12, "segment-to-segment", 1e3),
        (0.09, "segment-to-segment", 1e3),
        (0.06, "node-to-segment", 1e9),
    ],
)
def test_a_sphere_has_hertz_pressure_on_its_axis(size, pairing, young):
    """Of eight to seventeen segments: the maximum and the node on the axis within 1.5 % of 3 F / 2 pi a^2."""
    path = [
        {"from": [0.0, 0.0]},
        {"arc_to": [RADIUS, RADIUS], "centre": [0.0, RADIUS], "turn": "left", "name": "cap"},
        {"line_to": [0.0, RADIUS], "name": "cut"},
        {"line_to": [0.0, 0.0], "name": "axis"},
    ]
    patch = _patch(_case(path, size, pairing, young, "cap"))
    modulus = 1.0 / ((1.0 - POISSON**2) * (1.0 / YOUNG + 1.0 / young))
    half_width = (0.75 * FORCE * RADIUS / modulus) ** (1.0 / 3.0)
    exact = 1.5 * FORCE / (np.pi * half_width**2)
    on_axis = patch.pressures[np.argmin(patch.points[:, 0])]
    np.testing.assert_allclose((on_axis, patch.pressures.max()), exact, rtol=0.015)
    np.testing.assert_allclose(abs(patch.force[1]), FORCE, rtol=1e-9)


def test_the_peak_of_a_cone_stays():
    """Sneddon (1965): p = E* tan(b) / 2 arcosh(a/r), without limit on the axis, where its node has more than others."""
    path = [
        {"from": [0.0, 0.0]},
        {"line_to": [8.0, 1.2], "name": "cap"},
        {"line_to": [8.0, 8.0], "name": "side"},
        {"line_to": [0.0, 8.0], "name": "cut"},
        {"line_to": [0.0, 0.0], "name": "axis"},
    ]
    patch = _patch(_case(path, 0.06, "segment-to-segment", 1e9, "cap"))
    order = np.argsort(patch.points[:, 0])
    radii, pressures = patch.points[order, 0], patch.pressures[order]
    modulus, slope = YOUNG / (1.0 - POISSON**2), 1.2 / 8.0
    radius = np.sqrt(2.0 * FORCE / (np.pi * modulus * slope))
    exact = modulus * slope / 2.0 * np.arccosh(radius / radii[1:6])
    np.testing.assert_allclose(pressures[1:6], exact, rtol=0.08)
    assert pressures[0] > 1.15 * pressures[1]
