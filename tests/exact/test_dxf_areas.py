"""Areas of DXF drawings, which ezdxf writes here, beside closed forms: what is visible counts, and nothing else."""

import math

import ezdxf
import numpy as np
import pytest
from ezdxf.math import Matrix44
from ezdxf.xclip import XClip

from flangeway.errors import InputError
from flangeway.formats import read_section
from flangeway.geometry import Arc

BOX = [(0, 0), (100, 0), (100, 50), (0, 50)]
HOLE = [(20, 10), (80, 10), (80, 40), (20, 40)]


@pytest.fixture
def drawn(tmp_path):
    """Draw a rectangle of 100 by 50 and `draw(modelspace, document)` in a DXF file, and read it as a section."""

    def read(draw, box=True, **options):
        document = ezdxf.new("R2010")
        document.header["$INSUNITS"] = 4
        if box:
            document.modelspace().add_lwpolyline(BOX, close=True)
        draw(document.modelspace(), document)
        document.saveas(tmp_path / "drawing.dxf")
        return read_section(tmp_path / "drawing.dxf", **options)

    return read


def polyline3d(space, _):
    space.add_polyline3d([(x, y, 7.0) for x, y in HOLE], close=True)


def open_polyline3d(space, _):
    space.add_polyline3d([(*point, 0.0) for point in [*HOLE, HOLE[0]]])


def line_chain(space, _):
    for a, b in zip(HOLE, [*HOLE[1:], HOLE[0]], strict=True):
        space.add_line(b, a)
    space.add_line((20, 10), (20, 10))


def polyline2d(space, _):
    space.add_polyline2d(HOLE, close=True)


def lwpolyline_back_at_its_start(space, _):
    space.add_lwpolyline([*HOLE, HOLE[0]])


@pytest.mark.parametrize("draw", [polyline3d, open_polyline3d, line_chain, polyline2d, lwpolyline_back_at_its_start])
def test_a_rectangular_hole_counts_however_it_is_drawn(drawn, draw):
    """A hole of 60 by 30 leaves 3200 of 5000, as a polyline of any kind or a chain of lines."""
    assert drawn(draw).section.area == pytest.approx(3200.0, rel=1e-12)


def circle(space, _):
    space.add_circle((50, 25), 10)


def arc_of_a_full_turn(space, _):
    space.add_arc((50, 25), 10, 0, 360)


def arc_from_40_to_400(space, _):
    space.add_arc((50, 25), 10, 40, 400)


def two_bulges(space, _):
    space.add_lwpolyline([(40, 25, 1), (60, 25, 1)], format="xyb", close=True)


def bulges_from_below(space, _):
    space.add_lwpolyline(
        [(-40, 25, 1), (-60, 25, 1)], format="xyb", close=True, dxfattribs={"extrusion": (0, 0, -1), "elevation": 3}
    )


def bulges_of_a_heavy_polyline(space, _):
    space.add_polyline2d([(40, 25, -1), (60, 25, -1)], format="xyb", close=True)


def circle_from_below(space, _):
    space.add_circle((-50, 25), 10, dxfattribs={"extrusion": (0, 0, -1)})


def round_ellipse(space, _):
    space.add_ellipse((50, 25), (6, 8), 1.0)


def circle_in_a_block(space, document):
    document.blocks.new("hole", base_point=(1, 2)).add_circle((1, 2), 2)
    space.add_blockref("hole", (50, 25), {"xscale": 5, "yscale": -5, "rotation": 33})


def circle_in_a_block_in_a_block(space, document):
    document.blocks.new("inner").add_circle((1, 0), 1)
    outer = document.blocks.new("outer")
    outer.add_blockref("inner", (-2, 0), {"xscale": 2, "yscale": 2})
    space.add_blockref("outer", (50, 25), {"xscale": 5, "yscale": 5, "rotation": 90})


def blocks_of_unequal_scales_that_cancel(space, document):
    document.blocks.new("inner").add_circle((0, 0), 2)
    document.blocks.new("outer").add_blockref("inner", (0, 0), {"xscale": 5, "yscale": 1})
    space.add_blockref("outer", (50, 25), {"xscale": 1, "yscale": 5})


ROUND = [
    *(circle, arc_of_a_full_turn, arc_from_40_to_400, two_bulges, bulges_from_below, bulges_of_a_heavy_polyline),
    *(circle_from_below, round_ellipse, circle_in_a_block, circle_in_a_block_in_a_block),
    blocks_of_unequal_scales_that_cancel,
]


@pytest.mark.parametrize("draw", ROUND)
def test_a_round_hole_counts_however_it_is_drawn(drawn, draw):
    """A hole of radius 10 leaves 5000 - 100 pi, to rounding, and its outline is of arcs."""
    section = drawn(draw).section
    assert section.area == pytest.approx(5000.0 - 100.0 * math.pi, rel=1e-11)
    assert section.centroid() == pytest.approx((50.0, 25.0), rel=1e-10)
    assert all(isinstance(side, Arc) for side in section.regions[0].holes[0].segments)


def ellipse(space, _):
    space.add_ellipse((50, 25), (30, 10), 0.3)


def half_ellipses(space, _):
    space.add_ellipse((50, 25), (30, 10), 0.3, 0.4, 0.4 + math.pi)
    space.add_ellipse((50, 25), (30, 10), 0.3, 0.4 + math.pi, 0.4)


def stretched_circle(space, document):
    document.blocks.new("hole").add_circle((0, 0), 1)
    space.add_blockref("hole", (50, 25), {"xscale": 10, "yscale": 30})


def stretched_bulges(space, document):
    block = document.blocks.new("hole")
    block.add_lwpolyline([(-1, 0, 1), (1, 0, 1)], format="xyb", close=True)
    space.add_blockref("hole", (50, 25), {"xscale": 30, "yscale": 10, "rotation": 20})


AREAS_OF_ELLIPSES = {ellipse: 300.0, half_ellipses: 300.0, stretched_circle: 300.0, stretched_bulges: 300.0}


@pytest.mark.parametrize("draw", AREAS_OF_ELLIPSES)
def test_an_elliptic_hole_is_within_its_stated_bound(drawn, draw):
    """An ellipse has the area pi a b within the stated distance times its length, and a notice states the distance."""
    box = [(-100, -100), (200, -100), (200, 200), (-100, 200)]
    found = drawn(lambda space, document: (space.add_lwpolyline(box, close=True), draw(space, document)), box=False)
    (hole,) = found.section.regions[0].holes
    exact = math.pi * (1000.0 * 0.3 if draw in (ellipse, half_ellipses) else 300.0)
    assert hole.area == pytest.approx(exact, abs=2e-5 * 65.0 * hole.length)
    assert len(hole.segments) < 200
    assert any("at most" in notice for notice in found.notices)


def test_a_spline_is_read_as_its_control_points_say(drawn):
    """A closed cubic B-spline has the area of its own polynomial pieces, integrated exactly here."""
    angles = np.linspace(0.0, 2.0 * math.pi, 9)[:-1]
    controls = np.column_stack((50.0 + 30.0 * np.cos(angles), 25.0 + 15.0 * np.sin(angles)))
    found = drawn(lambda space, _: space.add_spline().set_closed([(*point, 0.0) for point in controls], degree=3))
    area = 0.0
    for piece in range(8):  # a uniform cubic piece in powers of its parameter
        rows = controls[(piece + np.arange(4)) % 8].T @ (
            np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]]) / 6.0
        )
        x, y = (np.polynomial.Polynomial(row) for row in rows)
        area += 0.5 * (x * y.deriv() - y * x.deriv()).integ()(1.0)
    (hole,) = found.section.regions[0].holes
    assert hole.area == pytest.approx(area, abs=1e-5 * 60.0 * hole.length)


def test_a_rational_spline_is_a_circle(drawn):
    """Nine control points with weights make a circle exactly."""
    corner = math.sqrt(0.5)
    ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    points = [(50 + 10 * x, 25 + 10 * y, 0) for x, y in ring]
    weights = [1, corner] * 4 + [1]
    knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]
    found = drawn(lambda space, _: space.add_rational_spline(points, weights, degree=2, knots=knots))
    assert found.section.area == pytest.approx(5000.0 - 100.0 * math.pi, abs=2e-4 * 63.0)


def test_a_spline_with_corners_keeps_them(drawn):
    """A spline of the first degree is the polygon of its points."""
    points = [(*point, 0.0) for point in [*HOLE, HOLE[0]]]
    found = drawn(lambda space, _: space.add_open_spline(points, degree=1))
    assert found.section.area == pytest.approx(3200.0, rel=1e-9)


# what is hidden, and what is chosen


def on_layer(name, off=False, frozen=False):
    def draw(space, document):
        layer = document.layers.add(name)
        if off:
            layer.off()
        if frozen:
            layer.freeze()
        space.add_circle((50, 25), 300, dxfattribs={"layer": name.lower()})

    return draw


def invisible(space, _):
    space.add_circle((50, 25), 10, dxfattribs={"invisible": 1})


def block_on_a_layer_off(space, document):
    document.layers.add("HELP").off()
    document.blocks.new("hole").add_circle((0, 0), 10)
    space.add_blockref("hole", (50, 25), {"layer": "HELP"})


def inner_layer_off(space, document):
    document.layers.add("HELP").off()
    document.blocks.new("hole").add_circle((0, 0), 10, dxfattribs={"layer": "HELP"})
    space.add_blockref("hole", (50, 25))


def block_on_a_frozen_layer(space, document):
    document.layers.add("HELP").freeze()
    document.layers.add("SHOWN")
    document.blocks.new("hole").add_circle((0, 0), 10, dxfattribs={"layer": "SHOWN"})
    space.add_blockref("hole", (50, 25), {"layer": "HELP"})


def invisible_block(space, document):
    document.blocks.new("hole").add_circle((0, 0), 10)
    space.add_blockref("hole", (50, 25), {"invisible": 1})


HIDDEN = [
    *(on_layer("HELP", off=True), on_layer("HELP", frozen=True), invisible, block_on_a_layer_off, inner_layer_off),
    *(block_on_a_frozen_layer, invisible_block),
]


@pytest.mark.parametrize("draw", HIDDEN)
def test_what_is_hidden_does_not_count_and_is_reported(drawn, draw):
    """Invisible objects, and those on layers that are off or frozen, leave the area as it is; a notice says so."""
    found = drawn(draw)
    assert found.section.area == pytest.approx(5000.0, rel=1e-12)
    assert any("hidden" in notice for notice in found.notices)


def paper_space(_, document):
    document.layout("Layout1").add_circle((50, 25), 10)


def frozen_in_a_viewport(space, document):
    document.layers.add("VIEW")
    space.add_circle((50, 25), 10, dxfattribs={"layer": "VIEW"})
    viewport = document.layout("Layout1").add_viewport((0, 0), (10, 10), (50, 25), 60)
    viewport.frozen_layers = ["VIEW"]


def shown_layer_of_a_block_on_a_layer_off(space, document):
    document.layers.add("HELP").off()
    document.layers.add("SHOWN")
    document.blocks.new("hole").add_circle((0, 0), 10, dxfattribs={"layer": "SHOWN"})
    space.add_blockref("hole", (50, 25), {"layer": "HELP"})


@pytest.mark.parametrize(
    ("draw", "area"),
    [
        (paper_space, 5000.0),
        (frozen_in_a_viewport, 5000.0 - 100.0 * math.pi),
        (shown_layer_of_a_block_on_a_layer_off, 5000.0 - 100.0 * math.pi),
    ],
)
def test_model_space_is_what_counts(drawn, draw, area):
    """Paper space does not count, viewports hide nothing of it, and a layer that is off hides layer 0 of blocks."""
    assert drawn(draw).section.area == pytest.approx(area, rel=1e-12)


def test_layers_are_chosen_by_name(drawn):
    """Chosen layers alone count, shown or not; an unknown one is refused with those of the drawing."""

    def draw(space, document):
        document.layers.add("Steel").off()
        document.layers.add("Frame")
        space.add_circle((0, 0), 300, dxfattribs={"layer": "Frame"})
        space.add_lwpolyline([(0, 0), (10, 0), (10, 10)], close=True, dxfattribs={"layer": "Steel"})

    assert drawn(draw, layers=["STEEL"]).section.area == pytest.approx(50.0, rel=1e-12)
    assert drawn(draw, layers=["0"]).section.area == pytest.approx(5000.0, rel=1e-12)
    with pytest.raises(InputError, match="Steel"):
        drawn(draw, layers=["steal"])


def rows_of_blocks(space, document):
    document.blocks.new("hole").add_circle((0, 0), 1)
    space.add_blockref("hole", (10, 10), {"column_count": 4, "row_count": 3, "column_spacing": 20, "row_spacing": 10})


def test_an_array_of_blocks_has_as_many_holes(drawn):
    """Four by three inserted holes of radius 1 leave 5000 - 12 pi."""
    assert drawn(rows_of_blocks).section.area == pytest.approx(5000.0 - 12.0 * math.pi, rel=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_nested_blocks_in_any_place_keep_their_area(drawn, seed):
    """A half disc in nested blocks has its area times the determinants of both maps, with mirrors and any scales."""
    rng = np.random.default_rng(seed)
    scales = rng.uniform(0.3, 3.0, (2, 2)) * rng.choice([-1.0, 1.0], (2, 2))
    turns = rng.uniform(0.0, 360.0, 2)

    def draw(space, document):
        inner, outer = document.blocks.new("inner", base_point=(3, 4)), document.blocks.new("outer")
        inner.add_arc((0, 0), 2, 0, 180)
        inner.add_line((2, 0), (-2, 0))
        for block, (x, y), turn, name in ((outer, scales[0], turns[0], "inner"), (space, scales[1], turns[1], "outer")):
            block.add_blockref(name, rng.uniform(-9, 9, 2), {"xscale": x, "yscale": y, "rotation": turn})

    section = drawn(draw, box=False).section
    assert section.area == pytest.approx(2.0 * math.pi * abs(scales.prod()), rel=1e-4)


# what is left out


def hatch(space, _):
    space.add_circle((50, 25), 10)
    filled = space.add_hatch()
    filled.paths.add_polyline_path(BOX, is_closed=True)
    filled.paths.add_edge_path(flags=16).add_arc((50, 25), 10, 0, 360)


def dimension(space, _):
    space.add_circle((50, 25), 10)
    space.add_linear_dim((50, 70), (0, 0), (100, 0)).render()
    space.add_text("not a part of it").set_placement((50, 25))


@pytest.mark.parametrize("draw", [hatch, dimension])
def test_annotations_change_nothing(drawn, draw):
    """Hatches of what is drawn, dimensions and texts are left out with a notice."""
    found = drawn(draw)
    assert found.section.area == pytest.approx(5000.0 - 100.0 * math.pi, rel=1e-11)
    assert any("Left out" in notice for notice in found.notices)


def hole_that_is_hatched_only(space, _):
    filled = space.add_hatch()
    filled.paths.add_polyline_path(BOX, is_closed=True)
    filled.paths.add_polyline_path(HOLE, is_closed=True, flags=16)


def solid(space, _):
    space.add_solid([(20, 10), (80, 10), (20, 40), (80, 40)])


def face(space, _):
    space.add_3dface([(*point, 0.0) for point in HOLE])


def mline(space, _):
    space.add_mline(HOLE, close=True)


def mesh(space, _):
    space.add_polymesh((3, 3))


def tilted(space, _):
    space.add_polyline3d([(x, y, 0.1 * x) for x, y in HOLE], close=True)


def sloped_line(space, _):
    space.add_line((20, 10, 0), (80, 10, 5))


def clipped_block(space, document):
    document.blocks.new("hole").add_circle((0, 0), 10)
    XClip(space.add_blockref("hole", (50, 25))).set_block_clipping_path([(0, 0), (5, 0), (5, 5)])


@pytest.mark.parametrize(
    "draw", [hole_that_is_hatched_only, solid, face, mline, mesh, tilted, sloped_line, clipped_block]
)
def test_what_is_not_read_in_a_section_is_refused_with_its_handle(drawn, draw):
    """An object in the section that is not read is an error that names its handle and its layer."""
    with pytest.raises(InputError, match=r"with the handle [0-9A-F]+ on layer '0'"):
        drawn(draw)


def test_what_is_not_read_beside_a_section_is_left_out(drawn):
    """A filled area far from the section is left out with a notice."""
    found = drawn(lambda space, _: space.add_solid([(200, 0), (210, 0), (200, 10), (210, 10)]))
    assert (found.section.area, found.notices) == (pytest.approx(5000.0), ("Left out: 1 SOLID.",))


def test_a_tree_of_blocks_ends(drawn):
    """Blocks that insert each other ten times, ten deep, are refused before they are expanded."""

    def draw(space, document):
        document.blocks.new("b0").add_circle((0, 0), 1)
        for level in range(1, 11):
            block = document.blocks.new(f"b{level}")
            for _ in range(10):
                block.add_blockref(f"b{level - 1}", (0, 0))
        space.add_blockref("b10", (50, 25))

    with pytest.raises(InputError, match="objects"):
        drawn(draw)


def test_a_drawing_turned_over_keeps_its_area(drawn):
    """A triangle with one side bulged outwards, seen from below, has the area of both and of the circular segment."""

    def draw(space, _):
        piece = space.add_lwpolyline([(0, 0, 0.3), (10, 0, 0), (10, 10, 0)], format="xyb", close=True)
        piece.transform(Matrix44.y_rotate(math.pi))

    angle = 4.0 * math.atan(0.3)
    radius = 5.0 / math.sin(angle / 2.0)
    exact = 50.0 + radius**2 / 2.0 * (angle - math.sin(angle))
    assert drawn(draw, box=False).section.area == pytest.approx(exact, rel=1e-12)
