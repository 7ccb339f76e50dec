"""Pictures: what they say, and that they can be read in black and white."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from flangeway.report import part_fields
from flangeway.report.figures.drawing import ColourSteps, Room, figure_with_room, png, power_of_ten
from flangeway.report.wheelset.contact_figure import contact_figure, pressure_figure
from flangeway.report.wheelset.wheelset_figure import deformation_factor, wheelset_figure


def figures(run):
    """All pictures of a run, in the order of the page."""
    fields = list(part_fields(run.result))
    return (
        wheelset_figure(run, fields),
        *(contact_figure(run, fields, side) for side in ("left", "right")),
        pressure_figure(run),
    )


@pytest.fixture(scope="module")
def drawn(runs):
    """Pictures of the coarse runs by method."""
    return {method: figures(run) for method, run in runs.items()}


def texts(figure):
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text()]


@pytest.mark.parametrize("method", ["fem", "vem"])
def test_nothing_is_clipped(drawn, method):
    """Every text of every picture lies inside of the picture."""
    for figure in drawn[method]:
        figure.draw_without_rendering()
        renderer = figure.canvas.get_renderer()
        width, height = figure.bbox.size
        for text in texts(figure):
            (left, bottom), (right, top) = text.get_window_extent(renderer).get_points()
            outside = left < -1 or bottom < -1 or right > width + 1 or top > height + 1
            ticks = {
                label for axes in figure.axes for axis in (axes.xaxis, axes.yaxis) for label in axis.get_ticklabels()
            }
            assert not outside or text in ticks, text.get_text()  # ticks out of range are not drawn


def test_axes_bear_units_and_names(drawn):
    """All axes have a unit, and the pictures name the wheel, stresses, forces and factors that they show."""
    said = [" ".join(text.get_text() for text in texts(figure)) for figure in drawn["fem"]]
    zones = (
        *("von Mises stress in MPa", "minimum principal stress in MPa", "in-plane shear stress in MPa"),
        *("kN", "x in mm", "y in mm"),
    )
    for words, wanted in zip(
        said,
        (
            ("AAR-1B (approximate)", "von Mises stress in MPa", "deformation x", "x in mm", "gauge 1600", "300 kN"),
            (*zones, "Left contact"),
            (*zones, "Right contact"),
            ("contact pressure in MPa", "in mm", "Hertz"),
        ),
        strict=True,
    ):
        assert all(word in words for word in wanted), words


def test_the_left_side_is_at_the_left(drawn):
    """Pictures of both sides show negative x first, then positive x, with x to the right in both."""
    whole, left, right, _ = drawn["fem"]
    panels = [axes for axes in whole.axes if axes.get_xlabel() == "x in mm"]
    first, last = panels[0].get_xlim(), panels[-1].get_xlim()
    assert first[0] < first[1] < 0.0 < last[0] < last[1]
    assert panels[0].get_position().x1 < panels[-1].get_position().x0
    for figure, sign in ((left, -1.0), (right, 1.0)):
        limits = [axes.get_xlim() for axes in figure.axes if axes.get_xlabel() == "x in mm"]
        assert len(limits) == 3
        assert all(sign * low > 0.0 < sign * high for low, high in limits)


def test_both_sides_have_the_same_colours(drawn):
    """Bars of the left and the right zones of contact have the same levels, so that pictures can be compared."""
    bars = [
        [axes.get_xticks().tolist() for axes in figure.axes if "MPa" in axes.get_xlabel()]
        for figure in drawn["vem"][1:3]
    ]
    assert len(bars[0]) == 3
    assert bars[0] == bars[1]


def test_a_side_without_contact_is_drawn(runs):
    """A side that does not touch is shown whole and said to be without contact."""
    run = runs["fem"]
    right = tuple(patch for patch in run.result.patches if patch.side == "right")
    lifted = replace(run, result=replace(run.result, patches=right))
    said = [text.get_text() for text in texts(contact_figure(lifted, list(part_fields(run.result)), "left"))]
    assert "the left wheel does not touch its rail" in said


def luminance(colours):
    return np.asarray(colours)[:, :3] @ (0.2126, 0.7152, 0.0722)


@pytest.mark.parametrize("values", [(0.0, 930.0), (-1500.0, 0.0)])
def test_colours_stay_apart_in_grey(values):
    """Each step of colour is clearly darker than the one before, away from zero stress."""
    colours = ColourSteps(np.array(values), from_zero=True)
    middles = (colours.levels[1:] + colours.levels[:-1]) / 2.0
    steps = luminance(colours.map(colours.norm(middles)))
    order = np.argsort(np.abs(middles))
    assert (np.diff(steps[order]) < -0.02).all()
    assert colours.levels.min() <= values[0]
    assert colours.levels.max() >= values[1]


def test_colours_of_a_body_without_stress():
    """A body without any stress can be drawn too."""
    assert len(ColourSteps(np.zeros(3), from_zero=True).levels) > 1


def test_the_factor_makes_the_motion_visible(runs):
    """The deformed picture shows the maximum motion as a hundredth to a fortieth of a part's size."""
    parts = list(part_fields(runs["fem"].result))
    factor = deformation_factor(parts)
    maximum = max(np.abs(part.points() - part.touch_points).max() for part in parts)
    size = max(np.ptp(part.touch_points, axis=0).max() for part in parts)
    assert size / 100.0 < factor * maximum <= size / 40.0


def test_pictures_are_png(runs):
    """A figure becomes the contents of a PNG file of its size."""
    data = png(pressure_figure(runs["fem"]))
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert int.from_bytes(data[16:20], "big") == 13 * 160


def test_room_is_kept_about_panels():
    """Panels leave as many inches about and between them as are asked for."""
    room = Room(left=1.0, right=0.5, bottom=0.75, top=0.25, across=0.6, between=0.9)
    figure, panels = figure_with_room(10.0, 8.0, room, 2, 3)
    assert panels.shape == (2, 3)
    inches = np.array([[axes.get_position().get_points() * (10.0, 8.0) for axes in row] for row in panels])
    assert inches[1, 0, 0] == pytest.approx([1.0, 0.75])
    assert inches[0, 2, 1] == pytest.approx([9.5, 7.75])
    assert inches[:, 1:, 0, 0] - inches[:, :-1, 1, 0] == pytest.approx(np.full((2, 2), 0.6))
    assert inches[0, :, 0, 1] - inches[1, :, 1, 1] == pytest.approx(np.full(3, 0.9))
    before = [axes.get_position().bounds for axes in figure.axes]
    png(figure)
    assert [axes.get_position().bounds for axes in figure.axes] == before


def test_powers_of_ten_are_labelled():
    """Labels of logarithmic axes are powers with signs and all digits."""
    assert [power_of_ten(value) for value in (1e-16, 0.1, 1.0, 1e23)] == ["10⁻¹⁶", "10⁻¹", "10⁰", "10²³"]


def test_a_picture_of_fewer_dots_is_smaller():
    """A picture with half the dots to the inch is half as wide and high, with its labels in the same places."""
    figure, _ = figure_with_room(4.0, 3.0, Room())
    sizes = [[int.from_bytes(data[at : at + 4], "big") for at in (16, 20)] for data in (png(figure), png(figure, 80))]
    assert sizes == [[640, 480], [320, 240]]
