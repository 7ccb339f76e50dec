"""Over which width superelevation is measured is said, and can be set."""

import math

import pytest

from flangeway.cases import WheelsetCurveCase


@pytest.mark.parametrize(
    ("inputs", "base", "word"),
    [({}, 1600.0, "the gauge"), ({"superelevation_base_mm": 1665.0}, 1665.0, "superelevation_base_mm")],
)
def test_the_base_of_the_superelevation_is_said(inputs, base, word):
    """The words of a curve name height, base and where the base is from, as the load has them."""
    case = WheelsetCurveCase.from_values({"superelevation_mm": 30.0, **inputs})
    (said,) = [each for each in case.derived() if each.startswith("Superelevation")]
    assert f"30 mm over a base of {base:g} mm: {word}" in said
    assert case.load().tilt_rad == pytest.approx(math.asin(30.0 / base))
    assert "1500" in (type(case).model_fields["superelevation_base_mm"].description or "")
