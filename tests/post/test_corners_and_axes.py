"""Pressures at sharp corners, and the radius of contacts about an axis."""

from typing import Any

import numpy as np
import pytest

from flangeway.cases.bodies.bodies_run import BodiesRun, TwoBodiesCase


def pressed(
    upper: dict[str, Any], lower: dict[str, Any], held: str, contact: dict[str, str], **values: Any
) -> BodiesRun:
    """A body pressed on another one."""
    return TwoBodiesCase.from_values(
        {
            "bodies": [{"name": "upper", **upper}, {"name": "lower", **lower}],
            "supports": [{"body": "upper", "edges": held}, {"body": "lower", "edges": "bottom"}],
            "motions": [{"body": "upper", "push_N": [0.0, -100.0]}],
            "contacts": [contact],
        }
        | values
    ).run()


def box(width: float, y: float, size: float, x: float = 0.0) -> dict[str, Any]:
    """A block of height 5."""
    return {"rectangle": {"width_mm": width, "height_mm": 5.0, "centre_mm": [x, y]}, "size_mm": size}


SIDES = {"secondary": "upper", "secondary_edges": "bottom", "primary": "lower", "primary_edges": "top"}
OTHER = {"primary": "upper", "primary_edges": "bottom", "secondary": "lower", "secondary_edges": "top"}


@pytest.mark.parametrize("contact", [SIDES, OTHER])
@pytest.mark.parametrize("size", [0.5, 0.25])
def test_the_pressure_of_a_punch_is_marked(contact: dict[str, str], size: float) -> None:
    """At the edge of a punch the exact pressure has no limit: it is marked, however fine and smooth the solution is."""
    run = pressed(box(10.0, 2.5, size), box(40.0, -2.5, size), "top", contact)
    (patch,) = run.patches
    assert patch.corner is not None
    assert np.abs(patch.corner) == pytest.approx([5.0, 0.0], abs=0.05)
    assert "sharp corner" in run.pairs[0].remark
    assert any("sharp corner" in notice for notice in run.notices)


@pytest.mark.parametrize("contact", [SIDES, OTHER])
def test_corners_that_meet_corners_are_no_mark(contact: dict[str, str]) -> None:
    """Equal blocks one on the other have a uniform pressure."""
    run = pressed(box(10.0, 2.5, 0.5), box(10.0, -2.5, 0.4), "top", contact, supports=[
        {"body": "upper", "edges": "top", "hold": "y"}, {"body": "upper", "point_mm": [-5.0, 5.0], "hold": "x"},
        {"body": "lower", "edges": "bottom", "hold": "y"}, {"body": "lower", "point_mm": [-5.0, -5.0], "hold": "x"},
    ], motions=[{"body": "upper", "shift_mm": [0.0, -0.01]}])  # fmt: skip
    (patch,) = run.patches
    assert np.ptp(patch.pressures) < 1e-3 * patch.pressures.max()
    assert patch.corner is None
    assert patch.remark is None


@pytest.mark.parametrize("order", [1, 2])
def test_a_contact_about_an_axis_has_its_radius(order: int) -> None:
    """Hertz: a = (3 F R / 4 E*)^(1/3), 1.010 mm for a sphere of 8 mm and 1000 MPa under 188.5 N on a rigid flat."""
    path = [
        {"from": [0.0, 0.0]},
        {"arc_to": [8.0, 8.0], "centre": [0.0, 8.0], "turn": "left", "name": "cap"},
        {"line_to": [0.0, 8.0], "name": "cut"},
        {"line_to": [0.0, 0.0], "name": "axis"},
    ]
    fine = [{"at_mm": [[0.0, 0.0], [1.3, 0.1]], "size_mm": 0.08}]
    run = pressed(
        {"outline": {"path": path}, "size_mm": 1.0, "order": order, "young_MPa": 1000.0, "fine": fine},
        {"rectangle": {"width_mm": 12.0, "height_mm": 6.0, "centre_mm": [6.0, -3.0]}, "young_MPa": 1e9, "fine": fine},
        "cut",
        {"secondary": "upper", "secondary_edges": "cap", "primary": "lower", "primary_edges": "top"},
        hypothesis="axisymmetric",
        motions=[{"body": "upper", "push_N": [0.0, -188.4955592]}],
    )
    (patch,) = run.patches
    assert patch.half_width == pytest.approx(1.010, abs=0.08)
