"""Scans of the geometry stop where a flange climbs, and say so."""

import pytest

from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.rigid.rigid_run import run_geometry


def scan(**values):
    """Geometry of AAR-1B on 136RE with less gauge."""
    inputs = {"gauge_mm": 1590.0, "back_to_back_mm": 1515.0, "step_mm": 0.1, "maximum_amplitude_mm": 2.0, **values}
    return run_geometry("wheelset-tangent", find_geometry_case("wheelset-tangent", inputs))


@pytest.mark.parametrize("maximum", [8.0, 60.0])
def test_scan(maximum):
    """A scan beyond what the flange allows ends at the flange with a notice; inside of it nothing is said."""
    run = scan(maximum_lateral_mm=maximum)
    reached = float(run.locus.lateral_mm[-1])
    assert 3.0 < reached < maximum - 0.5
    said = [notice for notice in run.summary["notices"] if "stops at" in notice]
    assert len(said) == 1
    assert f"{-reached:.2f} and {reached:.2f} mm" in said[0]
    assert run.locus.right.contact_angles_rad[-1, 0] > 0.5
    assert run.equilibrium.status.converged
