"""A wheel on a rail in three dimensions; Hertz's ellipse beside it is in `flangeway reproduce wheelset3d`."""

import numpy as np
import pytest

from flangeway.cases.wheelset.wheelset_case import WheelsetTangentCase
from flangeway.contact.patch.patch_contact import PatchContact
from flangeway.railway.wheelset.wheel_patch import spatial_patch
from flangeway.railway.wheelset.wheelset_model import WheelsetModel, build_model

FORCE = 150e3  # N


def model_of(method: str, order: int, size: float) -> WheelsetModel:
    values = {"method": method, "order": order, "contact_size_mm": size, "axle_load_kN": 300.0, "body_size_mm": 12.0}
    return build_model(WheelsetTangentCase.from_values(values).problem())


def patch_of(method: str, order: int, size: float) -> PatchContact:
    """AAR-1B on 136RE under 150 kN."""
    return spatial_patch(
        model_of(method, order, size), "right", FORCE, cell_mm=0.5, window_mm=(13.0, 20.0), tolerance=5e-3
    )


@pytest.mark.ci
def test_finite_and_virtual_elements_agree() -> None:
    """Maximum pressure, semi-axes and centre of triangles of order 2 and polygons of order 1 agree to 0.3 %."""
    (fem,), (vem,) = (found.patches for found in (patch_of("fem", 2, 0.25), patch_of("vem", 1, 0.5)))
    assert fem.max_pressure == pytest.approx(vem.max_pressure, rel=3e-3)
    np.testing.assert_allclose(fem.semi_axes, vem.semi_axes, rtol=3e-3)
    np.testing.assert_allclose(fem.centre, vem.centre, atol=0.02)


@pytest.mark.ci
def test_both_sides_are_mirror_images() -> None:
    """On a symmetric track the pressures of both sides are equal to 1e-6, mirrored."""
    model = model_of("fem", 1, 0.5)
    left, right = (
        spatial_patch(model, side, FORCE, cell_mm=0.57, window_mm=(13.0, 20.0), tolerance=0.1)
        for side in ("left", "right")
    )
    np.testing.assert_allclose(left.pressures[::-1], right.pressures, atol=1e-3)
    np.testing.assert_allclose(left.force, right.force * [-1.0, 1.0], rtol=1e-6)
