"""Row B7: the lateral force in the track's plane is called so, in picture and summary."""

import math

import pytest
from matplotlib.figure import Figure

from flangeway.cases import WheelsetCurveCase
from flangeway.report.wheelset.wheelset_figure import draw_sketch


def test_b7_the_lateral_force_is_not_said_to_be_along_the_track():
    """Summary and sketch have 22.77 kN as a lateral force in the track's plane, not along the track."""
    run = WheelsetCurveCase.from_values({"size_scale": 8.0}).run()
    load = run.summary["load"]
    tilt = math.asin(30.0 / 1600.0)
    assert load["lateral_in_track_kN"] == pytest.approx(28.4 * math.cos(tilt) - 300.0 * math.sin(tilt), abs=0.02)
    assert not any("along" in key for key in load)
    axes = Figure().add_subplot()
    draw_sketch(axes, run.result.model.problem, run.result.equilibrium.position)
    words = [" ".join(text.get_text().split()) for text in axes.texts]
    assert f"{load['lateral_in_track_kN']:.4g} kN lateral, in the track's plane" in words
    assert not any("along the track" in each for each in words)
