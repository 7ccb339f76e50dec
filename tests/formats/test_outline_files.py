"""Sections from files: what is read, what is repaired with a notice, what is refused with its place."""

import functools
import io
import itertools
import math
from pathlib import Path

import ezdxf
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flangeway.campaign.campaign import read_table
from flangeway.errors import InputError
from flangeway.formats import read_section
from flangeway.geometry import Arc
from flangeway.railway.profiles.formats.two_column import read_two_column
from flangeway.system.file_content import csv_cells

BOX = 'unit = "mm"\n[outer]\npoints = [[0, 0], [40, 0], [40, 20], [0, 20]]\n'


@pytest.fixture
def read(tmp_path):
    """Write text or bytes to a file and read it as a section."""

    def from_content(content, ending=".toml", **options):
        file = tmp_path / f"outline{ending}"
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_section(file, **options)

    return from_content


@pytest.fixture
def read_drawing(tmp_path):
    """Draw in a new DXF file with `draw(modelspace)` and read it as a section."""

    def from_drawing(draw, units=4, version="R2010", **options):
        drawing = ezdxf.new(version)
        drawing.header["$INSUNITS"] = units
        draw(drawing.modelspace())
        file = tmp_path / "outline.dxf"
        drawing.saveas(file)
        return read_section(file, **options)

    return from_drawing


# what is read


def test_toml_with_rounded_corners_holes_and_title(read):
    """A box with corners rounded by r loses (4 - pi) r^2, holes their area; title, unit and names are kept."""
    found = read(
        """
        title = "Box"
        unit = "cm"
        [outer]
        points = [[0, 0, 3], [40, 0, 3], [40, 20, 3], [0, 20, 3]]
        names = ["bottom", "right", "top", "left"]
        [[holes]]
        circle = { centre = [10, 10], radius = 2 }
        [[holes]]
        points = [[20, 5], [20, 15], [30, 15], [30, 5]]
        """
    )
    region = found.section.parts["section"]
    assert (found.title, found.unit, found.notices) == ("Box", "cm", ())
    assert region.area == pytest.approx(800.0 - (4.0 - math.pi) * 9.0 - math.pi * 4.0 - 100.0, rel=1e-12)
    assert set(region.outer.names) == {"bottom", "right", "top", "left", *(f"corner_{i}" for i in range(1, 5))}
    assert not found.materials


def test_toml_rounds_a_hollow_corner_inwards(read):
    """Rounding the inner corner of an L with radius r adds (1 - pi/4) r^2, and radii may use up a side."""
    found = read('unit = "mm"\nouter.points = [[0, 0], [6, 0], [6, 2], [2, 2, 4], [2, 6], [0, 6]]')
    assert found.section.area == pytest.approx(20.0 + (1.0 - math.pi / 4) * 16.0, rel=1e-12)


def test_toml_path_of_lines_and_arcs(read):
    """A half disc drawn by its diameter and an arc, through a point or about a centre, has area pi r^2 / 2."""
    through = "{ arc_to = [-2, 0], through = [0, 2], name = 'round' }"
    about = "{ arc_to = [-2, 0], centre = [0, 0], turn = 'left', name = 'round' }"
    for arc in (through, about):
        found = read(f"unit = 'm'\nouter.path = [{{ from = [-2, 0] }}, {{ line_to = [2, 0] }}, {arc}]")
        assert found.section.area == pytest.approx(2.0 * math.pi, rel=1e-12)
        assert found.section.parts["section"].outer.names == ("step_1", "round")


def test_toml_parts_with_materials(read):
    """Parts have their own regions and materials, whose shear modulus is E / (2 (1 + nu))."""
    found = read(
        """
        unit = "mm"
        [parts.steel]
        young_MPa = 210000
        poisson = 0.3
        outer.points = [[0, 0], [10, 0], [10, 5], [0, 5]]
        [parts.concrete]
        young_MPa = 30e3
        poisson = 0.2
        outer.points = [[0, 5], [10, 5], [10, 25], [0, 25]]
        """
    )
    assert list(found.section.parts) == ["steel", "concrete"]
    assert found.materials["steel"].shear_modulus_MPa == pytest.approx(210e3 / 2.6)
    assert found.section.area == 250.0


def test_csv_of_corners_names_its_unit(read):
    """Corners in columns x_in, y_in make a polygon in inches; a second unit is refused."""
    text = "x_in,y_in\n0,0\n2,0\n2,1\n0,1\n"
    found = read(text, ".csv")
    assert (found.unit, found.section.area, found.title) == ("in", 2.0, "outline")
    assert read(text, ".csv", unit="in").unit == "in"
    with pytest.raises(InputError, match="unit mm for a file in in"):
        read(text, ".csv", unit="mm")


def test_csv_half_outline_is_mirrored(read):
    """A quarter-disc-topped half, mirrored by option or by comment, is whole and has twice the half's area."""
    rows = "arc,0,3,2,1,0,1\nline,2,1,2,0,,\nline,2,0,0,0,,\n"
    header = "type,x0,y0,x1,y1,xc,yc\n"
    by_option = read(header + rows, ".csv", unit="mm", mirrored=True)
    by_comment = read("# unit: mm\n# mirror\n" + header + rows, ".csv")
    for found in (by_option, by_comment):
        assert found.section.area == pytest.approx(4.0 + 2.0 * math.pi, rel=1e-12)
        assert found.section.centroid()[0] == pytest.approx(0.0, abs=1e-12)
        assert found.notices == ()


@pytest.mark.parametrize("first", range(4))
def test_csv_half_that_is_closed_along_the_axis_is_mirrored(read, first):
    """A half as corners, or with its cut on x = 0 among the lines, is whole after the mirror, wherever it begins."""
    corners = [(0, 0), (2, 0), (3, 5), (0, 5)]
    corners = corners[first:] + corners[:first]
    listed = "# mirror\nx_mm,y_mm\n" + "".join(f"{x},{y}\n" for x, y in corners)
    ends = zip(corners, corners[1:] + corners[:1], strict=True)
    lines = "# mirror\ntype,x0_mm,y0_mm,x1_mm,y1_mm\n" + "".join(f"line,{a},{b},{c},{d}\n" for (a, b), (c, d) in ends)
    for text in (listed, lines):
        section = read(text, ".csv").section
        assert section.area == pytest.approx(25.0, rel=1e-12)
        assert section.centroid()[0] == pytest.approx(0.0, abs=1e-12)
        assert len(next(iter(section.regions)).loops[0].segments) == 6


def test_csv_loops_inside_others_are_holes(read):
    """Rows that come back to their start end a loop; the smaller loop inside becomes a hole."""
    text = (
        "type,x0_mm,y0_mm,x1_mm,y1_mm,xc_mm,yc_mm,turn\n"
        "line,0,0,9,0,,,\nline,9,0,9,9,,,\nline,9,9,0,9,,,\nline,0,9,0,0,,,\n"
        "arc,3,4,5,4,4,4,right\narc,5,4,3,4,4,4,right\n"
    )
    found = read(text, ".csv")
    assert found.section.area == pytest.approx(81.0 - math.pi, rel=1e-12)
    assert found.notices == ()


def test_dxf_polyline_with_bulges_and_circles(read_drawing):
    """A stadium drawn as one polyline with bulges, with two circles in it, has its textbook area."""

    def draw(space):
        space.add_lwpolyline([(0, 0, 0), (10, 0, 1), (10, 4, 0), (0, 4, 1)], format="xyb", close=True)
        space.add_circle((0, 2), 1)
        space.add_circle((10, 2), 1)
        space.add_text("not a part of it")

    found = read_drawing(draw)
    assert found.unit == "mm"
    assert found.section.area == pytest.approx(40.0 + 4.0 * math.pi - 2.0 * math.pi, rel=1e-12)
    assert found.notices == ("Left out: 1 TEXT.",)


@pytest.mark.parametrize("bulge", [-0.4, 0.4])
@pytest.mark.parametrize("version", ["R12", "R2010"])
def test_dxf_bulge_to_either_side(read_drawing, version, bulge):
    """A bulge outwards adds its circular segment and one inwards takes it off, clockwise polylines too."""
    corners = [(0, 0, bulge), (6, 0, 0), (6, 5, 0), (0, 5, 0)]

    def draw(space):
        if version == "R12":
            space.add_polyline2d(corners, format="xyb", close=True)
        else:
            space.add_lwpolyline(corners, format="xyb", close=True)

    angle = 4.0 * math.atan(0.4)
    radius = 3.0 / math.sin(angle / 2.0)
    segment = 0.5 * radius**2 * (angle - math.sin(angle))
    found = read_drawing(draw, version=version, **({"unit": "mm"} if version == "R12" else {}))
    assert found.section.area == pytest.approx(30.0 + math.copysign(segment, bulge), rel=1e-12)


def test_dxf_lines_and_arcs_in_any_order_and_direction(read_drawing):
    """Lines and arcs that are drawn crisscross, one seen from below, are joined at their ends into one loop."""

    def draw(space):
        space.add_line((10, 4), (0, 4))
        space.add_arc((-10, 2), 2, -90, 90, dxfattribs={"extrusion": (0, 0, -1)})  # centre at (10, 2) from above
        space.add_line((10, 0), (0, 0))
        space.add_arc((0, 2), 2, 90, 270)

    # from below the arc's opening is turned over: it runs from (10, 0) to (10, 4) through (8, 2)
    found = read_drawing(draw)
    assert found.section.area == pytest.approx(40.0, rel=1e-12)
    assert sum(isinstance(s, Arc) for s in found.section.parts["section"].outer.segments) == 2


def test_dxf_units_come_from_the_drawing_or_the_option(read_drawing):
    """Inches are read from $INSUNITS; a drawing without a unit needs the option, and one with it refuses another."""

    def draw(space):
        space.add_lwpolyline([(0, 0), (1, 0), (0, 1)], close=True)

    assert read_drawing(draw, units=1).unit == "in"
    assert read_drawing(draw, units=0, unit="cm").unit == "cm"
    with pytest.raises(InputError, match="without a unit of length"):
        read_drawing(draw, units=0)
    with pytest.raises(InputError, match="leave the unit out"):
        read_drawing(draw, units=1, unit="mm")


# what is repaired


def test_clockwise_and_duplicate_points_are_mended_with_a_notice(read):
    """A clockwise outline with a point given twice is the same region, and two notices say what was done."""
    found = read('unit = "mm"\nouter.points = [[0, 0], [0, 20], [40, 20], [40, 20], [40, 0], [0, 0]]')
    assert found.section.area == 800.0
    assert len(found.notices) == 3
    assert any("(40, 20) is given twice" in notice for notice in found.notices)
    assert any("(0, 0) is given twice" in notice for notice in found.notices)
    assert any("clockwise" in notice for notice in found.notices)


# what is refused


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BOX.replace("mm", "furlong"), "unit of length 'furlong'"),
        (BOX.replace("points", "pionts"), "did you mean points"),
        (BOX.replace("[outer]", "[out"), "not TOML"),
        (BOX + "names = ['a']\n", "1 names for 4 points"),
        ("unit = 'mm'\nyoung_MPa = 1.0\n" + BOX.split("\n", 1)[1], "young_MPa without poisson"),
        ("unit = 'mm'\nyoung_MPa = 1.0\npoisson = 0.5\n" + BOX.split("\n", 1)[1], "below 0.5"),
        ("unit = 'mm'\n", "none of outer, parts"),
        (
            "unit = 'mm'\nouter.path = [{from = [0, 0]}, {line_to = [1, 0]}, {line_to = [1, 1]}]",
            r"segment 0 starts at \(0.0, 0.0\), 1.414\d* from the end \(1.0, 1.0\) of segment 1",
        ),
        (
            "unit = 'mm'\nouter.path = [{from = [0, 0]}, {arc_to = [2, 0], through = [1, 0]}, {line_to = [0, 0]}]",
            "three points on one line",
        ),
    ],
)
def test_wrong_toml_is_refused_with_the_place(read, text, message):
    """Every mistake in a TOML outline is an InputError whose message names the place or the key."""
    with pytest.raises(InputError, match=message):
        read(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x_mm,y_cm\n0,0\n", "columns in cm and mm"),
        ("type,x0_mm,y0_mm,x1_mm,y1_mm\nspline,0,0,1,1\n", "type = 'spline'"),
        ("type,x0_mm,y0_mm,x1_mm,y1_mm,xc_mm,yc_mm\narc,-1,0,1,0,0,0\nline,1,0,-1,0,,\n", "half a turn"),
        ("# mirror\ntype,x0_mm,y0_mm,x1_mm,y1_mm\nline,0,0,1,0\nline,1,0,1,1\n", r"ends at \(1, 1\)"),
    ],
)
def test_wrong_csv_is_refused_with_the_line(read, text, message):
    """Every mistake in a CSV outline is an InputError whose message names the line, column or place."""
    with pytest.raises(InputError, match=message):
        read(text, ".csv")


@pytest.mark.parametrize(
    ("draw", "message"),
    [
        (lambda space: space.add_line((0, 0), (3, 0)), r"an open end at \(0, 0\)"),
        (lambda space: space.add_lwpolyline([(0, 0), (3, 0), (0, 3)]), "an open end at"),
        (lambda space: space.add_spline([(0, 0), (1, 1), (2, 0)]), "an open end at"),
        (lambda space: space.add_text("nothing else"), "without a closed outline"),
        (lambda space: space.add_circle((0, 0), 1, dxfattribs={"extrusion": (0, 1, 1)}), "not parallel"),
        (
            lambda space: [space.add_line((0, 0), end) for end in ((1, 0), (0, 1), (-1, 0))],
            r"3 ends that meet at \(0, 0\)",
        ),
    ],
)
def test_wrong_drawings_are_refused_with_the_place(read_drawing, draw, message):
    """Open ends, branches, tilted circles and empty drawings are refused with place or layer."""
    with pytest.raises(InputError, match=message):
        read_drawing(draw)


@pytest.mark.parametrize("ending", [".toml", ".csv", ".dxf"])
@pytest.mark.parametrize("content", [b"", b"  \n", b"\x00\xff\xfe" * 50, b"%PDF-1.7\n\x93\x8c\x8b\x9e\n", b"0\nEOF\n"])
def test_junk_is_refused_in_every_format(read, ending, content):
    """Empty files, binary junk and other formats are an InputError that names the file."""
    with pytest.raises(InputError, match=rf"outline\{ending}"):
        read(content, ending)


def test_missing_files_are_refused(tmp_path):
    """A missing file, a folder, and a mirror for TOML are InputErrors."""
    with pytest.raises(InputError, match="No such file"):
        read_section(tmp_path / "missing.toml")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(InputError, match=r"folder\.csv"):
        read_section(tmp_path / "folder.csv")
    with pytest.raises(InputError, match="--mirror"):
        read_section(tmp_path / "a.toml", mirrored=True)


SOUND = {
    ".toml": """title = "all"
unit = "cm"
[parts.box]
young_MPa = 210000.0
poisson = 0.3
outer.points = [[0, 0, 3], [40, 0], [40, 20, 0.5], [0, 20]]
outer.names = ["bottom", "right", "top", "left"]
[[parts.box.holes]]
circle = { centre = [10, 10], radius = 2 }
[parts.cap]
outer.path = [{ from = [0, 20] }, { line_to = [40, 20] }, { arc_to = [0, 20], through = [20, 30], name = "cap" }]
""",
    ".csv": """# unit: mm
name,type,x0,y0,x1,y1,xc,yc,turn
base,line,0,0,9,0,,,
side,line,9,0,9,9,,,
top,line,9,9,0,9,,,
left,line,0,9,0,0,,,
hole,arc,3,4,5,4,4,4,right
hole,arc,5,4,3,4,4,4,right
""",
}


@functools.cache
def sound_file(ending):
    if ending != ".dxf":
        return SOUND[ending].encode()
    drawing = ezdxf.new("R12")
    space = drawing.modelspace()
    space.add_polyline2d([(0, 0, 0), (10, 0, 1), (10, 4, 0), (0, 4, 1)], format="xyb", close=True)
    space.add_circle((5, 2), 1)
    for start, end in itertools.pairwise([(20, 0), (30, 0), (30, 5), (20, 0)]):
        space.add_line(start, end)
    text = io.StringIO()
    drawing.write(text)
    return text.getvalue().encode()


@settings(suppress_health_check=list(HealthCheck))
@given(
    ending=st.sampled_from([".toml", ".csv", ".dxf"]),
    changes=st.lists(
        st.tuples(st.floats(0.0, 1.0), st.sampled_from([*b'0123456789.-+eE,; \n#"[]{}=_nx']), st.integers(0, 40)),
        min_size=1,
        max_size=4,
    ),
)
def test_damaged_outlines_are_read_or_refused(tmp_path, ending, changes):
    """Sound files with bytes changed, put in or cut out give a section of finite area or an InputError."""
    content = bytearray(sound_file(ending))
    whole = len(content)
    # the header of a drawing is long, and what counts stands at its end
    first = max(content.rfind(b"ENTITIES"), 0)
    for place, byte, cut in changes:
        i = first + int(place * (whole - first - 1))
        content[i : i + cut] = bytes([byte])
    file = tmp_path / f"damaged{ending}"
    file.write_bytes(content)
    try:
        found = read_section(file, unit=None if ending != ".dxf" else "mm")
    except InputError:
        return
    assert math.isfinite(found.section.area)


CORNERS = ((0.0, 0.0), (12.5, 0.0), (12.5, 7.25), (0.0, 7.25))


@pytest.mark.parametrize("separator", [";", "\t", ","])
def test_a_section_with_semicolons_and_decimal_commas(tmp_path: Path, separator: str) -> None:
    """Its area is that of the rectangle, whatever separates the cells; a profile reads the same points."""
    rows = [separator.join(f"{value:g}" for value in corner) for corner in CORNERS]
    text = "\n".join(row.replace(".", ",") if separator != "," else row for row in rows)
    file = tmp_path / "section.csv"
    file.write_text(f"x_mm{separator}y_mm\n{text}\n", encoding="utf-8")
    (part,) = read_section(file).section.regions
    assert part.outer.area == pytest.approx(12.5 * 7.25, rel=1e-12)
    assert read_two_column(f"x{separator}y\n{text}\n").points.tolist() == [list(corner) for corner in CORNERS]


def test_a_campaign_with_decimal_commas(tmp_path: Path) -> None:
    """Numbers of a table get points, names of profiles stay."""
    file = tmp_path / "rows.csv"
    file.write_text("rail;lateral_mm\n60E1;1,5\n136RE;-2\n", encoding="utf-8")
    expected = [{"rail": "60E1", "lateral_mm": "1.5"}, {"rail": "136RE", "lateral_mm": "-2"}]
    assert read_table(file) == expected


def test_commas_that_separate_are_no_decimal_commas() -> None:
    """Between commas there are numbers with points, and text between semicolons keeps its commas."""
    assert csv_cells("1,5,a", 1) == ["1", "5", "a"]
    assert csv_cells("1,5; a, b ;-2,5e3", 1, ";") == ["1.5", "a, b", "-2.5e3"]
