"""Pictures: what they say, and that they can be read in black and white."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from flangeway.railway.track.placements import SIDES
from flangeway.report.figures.fields import drawn_parts
from flangeway.report.wheelset.wheelset_patches import ORDINATE_MM, contact_figure, nodes_figure, section_figure


def figures(run):
    """All pictures of a run, in the order of the page."""
    return section_figure(run), contact_figure(run), nodes_figure(run)


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
    for figure in drawn[:2]:
        panels = [axes for axes in figure.axes if axes.get_xlabel() == "x, mm"]
        first, last = panels[0].get_xlim(), panels[-1].get_xlim()
        assert first[0] < first[1] < 0.0 < last[0] < last[1]
        assert panels[0].get_position().x1 < panels[-1].get_position().x0


def test_all_contacts_have_the_same_colours(drawn, runs):
    """Each contact has a panel of its own, in true shape, and one bar of colours is of all."""
    panels, bars = ([axes for axes in drawn[1].axes if bool(axes.get_xlabel()) == named] for named in (True, False))
    assert len(panels) == len(runs["vem"].patches)
    assert len(bars) == 1
    assert all(axes.get_aspect() == 1.0 for axes in panels)


def test_a_side_without_contact_is_drawn(runs):
    """A side that does not touch is in the section, without a force."""
    run = runs["fem"]
    right = tuple(patch for patch in run.result.patches if patch.side == "right")
    left, other = section_figure(replace(run, result=replace(run.result, patches=right))).axes
    assert left.patches
    assert not left.texts
    assert other.texts


def test_the_area_of_the_pressures_is_the_force(runs):
    """In the section, the pressures of a patch cover its force over the length, in their scale."""
    run = runs["fem"]
    highest = max(patch.max_pressure for patch in run.patches)
    for axes, side in zip(section_figure(run).axes, SIDES, strict=True):
        (patch,) = (patch for patch in run.patches if patch.patch.side == side)
        x, y = axes.patches[-1].get_xy()[:-1].T
        area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0
        force = area * highest / ORDINATE_MM * run.problem.thickness_mm
        # without half of an element at both ends
        assert force == pytest.approx(patch.normal_force, rel=0.2)


def test_deformed_surfaces_meet(runs):
    """The drawn points are those of the contact solution."""
    result = runs["fem"].result
    state, system = result.equilibrium.state, result.model.system
    for contact in system.contacts:
        for surface in (contact.secondary, contact.primary):
            body = drawn_parts(result)[surface.part.name]
            nodes = body.space.nodes
            drawn = body.place(nodes, body.field.displacements[: len(nodes)])
            assert np.allclose(drawn[surface.nodes], state.positions[system.nodes_of(surface)], atol=1e-9)
