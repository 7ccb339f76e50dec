"""Pictures in US units."""

import numpy as np
import pytest

from flangeway.report.figures.drawing import ColourSteps, new_figure
from flangeway.report.figures.us_figure import figure_in_us_units


def test_ticks_stand_at_round_numbers_of_the_unit_in_the_us():
    """An axis in mm has ticks at whole inches in their places, its neighbour without a label too; others stay."""
    figure = new_figure(8.0, 4.0)
    left, right = figure.subplots(1, 2)
    for axes in (left, right):
        axes.plot([0.0, 101.6], [0.0, 5.0])
        axes.set_xlim(0.0, 101.6)
    left.set(xlabel="x in mm", ylabel="creepage in %")
    figure_in_us_units(figure)
    figure.draw_without_rendering()
    for axes in (left, right):
        numbers = [float(each.get_text()) for each in axes.get_xticklabels()]
        assert len(numbers) > 3
        np.testing.assert_allclose(axes.get_xticks(), 25.4 * np.array(numbers))
    assert (left.get_xlabel(), left.get_ylabel()) == ("x, in", "creepage in %")
    assert left.get_yticks()[-1] == pytest.approx(5.0, abs=1.0)


def test_texts_with_numbers_follow_and_a_colour_bar_takes_its_title_along():
    """Numbers with units, bare numbers whose `gid` is a unit, and what names the unit of either are converted."""
    figure = new_figure(8.0, 4.0)
    axes = figure.subplots()
    axes.set_title("stress, MPa")
    axes.text(0.5, 0.5, "25.4 mm at 200 kN")
    axes.text(0.1, 0.1, "10 / -90", gid="kN")
    figure.colorbar(ColourSteps(np.array([0.0, 100.0])).mappable(), ax=axes, label="MPa")
    figure_in_us_units(figure)
    figure.draw_without_rendering()
    assert axes.get_title() == "stress, ksi"
    assert [each.get_text() for each in axes.texts] == ["1 in at 44.96 kip", "2.2 / -20.2"]
    bar = figure.axes[1]
    numbers = np.array([float(each.get_text()) for each in bar.get_yticklabels()])
    np.testing.assert_allclose(bar.get_yticks(), numbers * 6.894757293168361)
    assert bar.get_ylabel() == "ksi"
