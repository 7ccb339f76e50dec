"""Pictures: what they say, and that they can be read in black and white."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.fields import drawn_parts
from flangeway.report.wheelset.contact_figure import contact_figure, pressure_figure
from flangeway.report.wheelset.wheelset_figure import wheelset_figure


def figures(run):
    """All pictures of a run, in the order of the page."""
    return wheelset_figure(run), *(contact_figure(run, side) for side in SIDES), pressure_figure(run)


@pytest.fixture(scope="module")
def drawn(runs):
    """Pictures of a coarse run."""
    return figures(runs["vem"])


def texts(figure):
    return [text for text in figure.findobj(Text) if text.get_visible() and text.get_text()]


def test_nothing_is_clipped(drawn):
    """Every text of every picture lies inside of the picture."""
    for figure in drawn:
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


def test_the_left_side_is_at_the_left(drawn):
    """Pictures of both sides show negative x first, then positive x, with x to the right in both."""
    whole, left, right, _ = drawn
    panels = [axes for axes in whole.axes if axes.get_xlabel() == "x, mm"]
    first, last = panels[0].get_xlim(), panels[-1].get_xlim()
    assert first[0] < first[1] < 0.0 < last[0] < last[1]
    assert panels[0].get_position().x1 < panels[-1].get_position().x0
    for figure, sign in ((left, -1.0), (right, 1.0)):
        limits = [axes.get_xlim() for axes in figure.axes if axes.get_xlabel() == "x, mm"]
        assert len(limits) == 3
        assert all(sign * low > 0.0 < sign * high for low, high in limits)


def test_both_sides_have_the_same_colours(drawn):
    """Bars of the left and the right zones of contact have the same levels, so that pictures can be compared."""
    bars = [[axes.get_xticks().tolist() for axes in figure.axes if "MPa" in axes.get_xlabel()] for figure in drawn[1:3]]
    assert len(bars[0]) == 3
    assert bars[0] == bars[1]


def test_a_side_without_contact_is_drawn(runs):
    """A side that does not touch is shown whole and said to be without contact."""
    run = runs["fem"]
    right = tuple(patch for patch in run.result.patches if patch.side == "right")
    lifted = replace(run, result=replace(run.result, patches=right))
    said = [text.get_text() for text in texts(contact_figure(lifted, "left"))]
    assert "the left wheel does not touch its rail" in said


def test_deformed_surfaces_meet(runs):
    """In true scale the drawn points are those of the contact solution; with factor 0 they are at first touch."""
    result = runs["fem"].result
    state, system = result.equilibrium.state, result.model.system
    for contact in system.contacts:
        for surface in (contact.secondary, contact.primary):
            side = surface.part.name.rpartition("-")[2]
            body, at_touch = (drawn_parts(result, side, factor)[surface.part.name] for factor in (1.0, 0.0))
            nodes = body.space.nodes
            drawn = body.place(nodes, body.field.displacements[: len(nodes)])
            assert np.allclose(drawn[surface.nodes], state.positions[system.nodes_of(surface)], atol=1e-9)
            if surface.part.name == "wheel-right":
                sunk = result.placements["wheel-right"].points(nodes) - at_touch.place(nodes, 0.0 * nodes)
                assert np.allclose(sunk, (0.0, -result.approach_mm), atol=1e-8)
