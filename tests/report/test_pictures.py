"""Pictures: what they say, that they can be read in black and white, and that they draw the numbers."""

from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.quiver import Quiver
from matplotlib.text import Text

from flangeway.cases.wheelset.wheelset_quantities import SpatialWheelResult
from flangeway.contact.patch.patch_contact import CellForces
from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, SLIPS, Creepages
from flangeway.elements import Virtual
from flangeway.exact.shakedown import shakedown_limits
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.railway.profiles.bundled import rail
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.report import profile_outputs
from flangeway.report.figures.drawing import COLOURS, SIGNED
from flangeway.report.figures.plots import drawn_parts, plot_stress
from flangeway.report.patch_figures import maps_figure, rolling_figure, shakedown_figure
from flangeway.report.patch_maps import PatchMap, ShownRolling
from flangeway.report.wheelset.wheelset_figures import ORDINATE_MM, contact_figure, nodes_figure, plane_section_figure
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from flangeway_studies.rolling_cases import elliptic


def figures(run):
    """All pictures of a run, in the order of the page."""
    return plane_section_figure(run), contact_figure(run), nodes_figure(run)


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
    left, other = plane_section_figure(replace(run, result=replace(run.result, patches=right))).axes
    assert left.patches
    assert not left.texts
    assert other.texts


def test_the_area_of_the_pressures_is_the_force(runs):
    """In the section, the pressures of a patch cover its force over the length, in their scale."""
    run = runs["fem"]
    highest = max(patch.max_pressure for patch in run.patches)
    for axes, side in zip(plane_section_figure(run).axes, SIDES, strict=True):
        (patch,) = (patch for patch in run.patches if patch.side == side)
        x, y = axes.patches[-1].get_xy()[:-1].T
        area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0
        force = area * highest / ORDINATE_MM * run.problem.plane.thickness_mm
        # without half of an element at both ends
        assert force == pytest.approx(patch.normal_force_N, rel=0.2)


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


def test_signed_stresses_are_white_at_zero():
    """A stress that changes its sign is drawn in diverging colours about zero, an equivalent one is not."""
    space = Space(rectangle_grid(3.0, 1.0, 6, 3), Virtual(1))
    beam = Elasticity(space, Elastic(1e3, 0.3), loads=[Traction("right", (0.0, 1.0))], supports=[fixed("left")])
    solution = solve_elasticity(beam)
    drawn = {name: plot_stress(solution, name).collections[0] for name in ("xx", "von_mises")}
    assert drawn["xx"].get_cmap() is SIGNED
    assert drawn["xx"].norm.vmin == -drawn["xx"].norm.vmax
    assert drawn["von_mises"].get_cmap() is COLOURS


def test_wear_is_measured_along_the_normal():
    """A head that lies 0.5 mm lower is 0.5 mm below the nominal one at its top, and off its flanks only by a share."""
    nominal = rail("60E1")
    lowered = nominal.running_surface.transformed(Placement(0.0, (0.0, -0.5)))
    joint = SimpleNamespace(end=(0.0, 0.0), landing=(0.0, 0.0))
    profile = SimpleNamespace(outline=nominal.outline, title="lowered")
    joined = SimpleNamespace(nominal=nominal, measured=lowered, profile=profile, joints=2 * [joint])
    axes = profile_outputs.join_figure(joined).axes[1]
    x, off = axes.lines[0].get_data()
    assert off.min() == pytest.approx(-0.5, abs=1e-3)
    assert off[np.abs(x).argmin()] == pytest.approx(-0.5, abs=1e-3)
    flank = np.abs(x) > 0.999 * np.abs(x).max()
    assert np.abs(off[flank]).max() < 0.2
    assert "at most 0.5 mm below it" in axes.get_title()


@pytest.fixture(scope="module")
def found():
    """An ellipse of 16 by 20 cells under all creepages, at 2 m/s for each unit of speed."""
    return roll(elliptic(8.0, 5.0, 100e3, (16, 20)), Creepages(-0.5e-3, -0.6e-3, -2e-4, speed=2.0))


def shown(found, sign=1.0):
    return ShownRolling("left", found, 20.0, 1.0, sign)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_maps_show_states_slip_and_power_where_they_are(found, sign):
    """A row of three maps: states, slip velocities in m/s and power in W/mm^2, mirrored with the side."""
    figure = rolling_figure([shown(found, sign)])
    maps = [next(each for each in axes.collections if isinstance(each, PolyCollection)) for axes in figure.axes[:3]]
    states, slip, power = (each.get_array() for each in maps)
    touching = found.states != NO_CONTACT
    assert (states == found.states[touching]).all()
    assert slip.max() == pytest.approx(10.0 * np.linalg.norm(found.slip_velocities, axis=2).max())
    corners = np.array([path.vertices[:4] for path in maps[2].get_paths()])
    areas = np.ptp(corners[..., 0], axis=1) * np.ptp(corners[..., 1], axis=1)
    assert (power * areas).sum() == pytest.approx(10.0 * found.frictional_power, rel=1e-9)
    # lengths along the surface run to the left for the sign of the left side
    rows = np.nonzero(touching)[0]
    assert np.sign(corners[rows.argmax()].mean(axis=0)[0] - corners[rows.argmin()].mean(axis=0)[0]) == -sign
    slipping = 100.0 * (found.states == SLIPS).sum() / (found.states != NO_CONTACT).sum()
    assert f"{slipping:.0f} % slips" in figure.axes[0].get_title()
    arrows = next(each for each in figure.axes[0].collections if isinstance(each, Quiver))
    assert np.sign(arrows.U.sum()) == -sign * np.sign(found.across)
    assert np.sign(arrows.V.sum()) == np.sign(found.along)
    assert len(arrows.U) > 50


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("seed", range(3))
def test_pressures_are_drawn_on_their_cells(seed, sign):
    """Each pixel of the map has the colour of the random uneven cell below it; the outline is that of the cells.

    The outline has the length of all sides between cells with and without pressure.
    """
    random = np.random.default_rng(seed)
    bounds, strip = np.cumsum(random.uniform(0.1, 1.3, 13)), 0.5
    pressures = np.where(random.random((12, 9)) < 0.7, random.uniform(100.0, 900.0, (12, 9)), 0.0)
    pressures[[0, -1]] = pressures[:, [0, -1]] = 0.0
    grid = PatchGrid(bounds, strip, 9)
    cells = CellForces(
        pressures * grid.areas, grid, np.zeros((12, 2)), np.zeros((12, 2)), 0.0 * pressures, 1e5, 0.0 * pressures
    )
    figure, (axes,) = maps_figure([PatchMap(cells, [], bounds[3], sign)], "x", "z")
    line = next(each for each in axes.collections if isinstance(each, LineCollection))
    length = sum(np.linalg.norm(np.diff(ends, axis=0)) for ends in line.get_segments())
    jumps = [np.abs(np.diff(pressures > 0.0, axis=axis).astype(int)) for axis in (0, 1)]
    assert length == pytest.approx(strip * jumps[0].sum() + (jumps[1].sum(axis=1) * np.diff(bounds)).sum())
    line.remove()
    figure.set_dpi(100)
    figure.canvas.draw()
    image = np.asarray(figure.canvas.buffer_rgba())[::-1, :, :3]
    middles = sign * (bounds[3] - grid.stations)
    x, y = np.meshgrid(middles, grid.along, indexing="ij")
    at = axes.transData.transform(np.column_stack((x.ravel(), y.ravel()))).astype(int)
    expected = COLOURS(pressures / pressures.max(), bytes=True)[..., :3].astype(int)
    expected[pressures == 0.0] = 255
    inside = np.array([axes.bbox.padded(-2.0).contains(*point) for point in at])
    drawn = image[at[inside, 1], at[inside, 0]].astype(int)
    assert inside.sum() > 0.5 * inside.size
    assert np.abs(drawn - expected.reshape(-1, 3)[inside]).max() <= 1


def test_patches_lie_in_the_shakedown_diagram():
    """Points at (creep force over normal force, pressure over k), named in the legend; limits are the theory's."""
    patches = [("left", 0.1, 900.0), ("right, tread", 0.27, 1300.0), ("right, flange", 0.27, 1290.0)]
    axes = shakedown_figure(patches, 510.0).axes[0]
    points = {line.get_label(): line.get_xydata().ravel() for line in axes.lines if line.get_marker() != "None"}
    assert list(points) == ["left: 900 MPa", "right, tread: 1300 MPa", "right, flange: 1290 MPa"]
    for (_, used, pressure), found in zip(patches, points.values(), strict=True):
        assert found == pytest.approx([used, pressure * np.sqrt(3.0) / 510.0])
    drawn = [line.get_xydata() for line in axes.lines if line.get_marker() == "None" and len(line.get_xydata())]
    assert len(drawn) == 6
    traction, pressure = drawn[1].T
    assert pressure == pytest.approx(shakedown_limits("point", traction).shakedown)


def test_nadals_criterion_is_that_of_the_wheel_whose_flange_touches():
    """L/V over Nadal's limit, None for a wheel whose flange does not touch, and the statement."""
    for ratio, touches, said in (
        (0.6, True, "exceeded (120 %)"),
        (0.095, True, "not exceeded (19 %)"),
        (0.6, False, None),
    ):
        result = Mock(spec=SpatialResult, rolling=(1,))
        result.nadal_limit.return_value, result.flange_touches.return_value = 0.5, touches
        result.lateral_over_vertical.return_value = ratio
        wheel = SpatialWheelResult(result, "right", [])
        assert wheel.nadal_fraction == (pytest.approx(ratio / 0.5) if touches else None)
        assert wheel.nadal_words == said
