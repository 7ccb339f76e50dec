"""Files of all formats: what is read is what was written, small gaps are closed, bad files are clear errors."""

import functools
import json
import math
import re
import string

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flangeway.cases.profile_run import run_profile
from flangeway.errors import InputError
from flangeway.geometry import Outline
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.instrument_files import write_miniprof, write_segment_csv, write_simpack
from flangeway.railway.profiles.formats.two_column import MAX_POINTS
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import FORMATS, MeasuredProfile, profile_text, read_profile

NANOMETRE = 1e-6  # in mm


def points_of(kind, spacing=0.4):
    """Points of a bundled running surface: a wheel from back to rim, a rail's head about its top."""
    points = (wheel("S1002") if kind == "wheel" else rail("60E1")).running_surface.sampled(spacing=spacing)
    return points if kind == "wheel" else points - [0.0, points[:, 1].max()]


def lines_of(points, form="{:.6f} {:.6f}"):
    return "\n".join(form.format(x, y) for x, y in points)


def saved(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module", params=["rail", "wheel"])
def measured(request, tmp_path_factory):
    """A profile of points, read from plain text."""
    rng = np.random.default_rng(5)
    points = points_of(request.param, 1.2)
    points = points + 1e-3 * rng.normal(size=points.shape)
    text = f"# unit: mm\n# kind: {request.param}\n" + lines_of(points)
    return read_profile(saved(tmp_path_factory.mktemp("made"), "made.txt", text), ReadOptions(smooth_mm=0.0))


@pytest.mark.parametrize("ending", FORMATS)
def test_what_is_written_is_read_back_to_a_nanometre(measured, ending, tmp_path):
    """Written and read again, points, or ends of lines and arcs, are the same to a nanometre, kind and frame too."""
    kinds = dict.fromkeys((".ban", ".prr", ".rail"), "rail") | dict.fromkeys((".whl", ".prw", ".wheel"), "wheel")
    if kinds.get(ending, measured.kind) != measured.kind:
        with pytest.raises(InputError, match=f"for a {measured.kind}"):
            profile_text(measured, ending)
        return
    path = saved(tmp_path, f"again{ending}", profile_text(measured, ending))
    again = read_profile(path, ReadOptions(smooth_mm=0.0))
    assert again.kind == measured.kind
    if ending in (".csv", ".dxf"):
        ends = [np.array([(*s.start, *s.end) for s in p.surface.segments]) for p in (measured, again)]
        np.testing.assert_allclose(ends[1], ends[0], atol=NANOMETRE)
        middles = [p.surface.sampled(spacing=0.05) for p in (measured, again)]
        np.testing.assert_allclose(middles[1], middles[0], atol=NANOMETRE)
    else:
        np.testing.assert_allclose(again.points, measured.points, atol=NANOMETRE)


@pytest.mark.parametrize("kind", ["rail", "wheel"])
@pytest.mark.parametrize("ending", [".csv", ".dxf"])
def test_whole_outlines_are_kept(kind, ending, tmp_path):
    """A closed outline written as CSV or DXF is read back closed, with the same area and the same arcs."""
    outline = (rail() if kind == "rail" else wheel()).outline
    text = write_segment_csv(outline, kind, "first", "base" if kind == "rail" else "tape")
    first = read_profile(saved(tmp_path, "first.csv", text))
    again = read_profile(saved(tmp_path, f"again{ending}", profile_text(first, ending)))
    assert isinstance(again.surface, Outline)
    assert again.surface.area == pytest.approx(outline.area, rel=1e-12)
    assert sorted(round(s.curvature, 9) for s in again.surface.segments) == sorted(
        round(s.curvature, 9) for s in outline.segments
    )
    with pytest.raises(InputError, match="closed outline"):
        profile_text(again, ".txt")


@pytest.mark.parametrize(
    ("form", "head"),
    [
        ("{:.6f} {:.6f}", ""),
        ("{:.6f}\t{:.6f}", "y [mm]\tz [mm]"),
        ("{:.6f},{:.6f}", "x_mm,y_mm"),
        ("{:.6f};{:.6f}", "x;y"),
        ("{:.6f};{:.6f};good", "x;y;quality"),
        ("  {:.6e}  {:.6e} 1.0", "! a comment"),
    ],
)
def test_columns_may_be_apart_in_any_usual_way(form, head, tmp_path):
    """Blanks, tabs, commas and semicolons separate; names of columns and comments are no points."""
    points = points_of("rail")
    text = f"{head}\n" + lines_of(points, form)
    found = read_profile(saved(tmp_path, "p.txt", text), ReadOptions(unit="mm", kind="rail", smooth_mm=0.0))
    np.testing.assert_allclose(found.points, points, atol=6e-7 if "e" not in form else 1e-4)


@pytest.mark.parametrize("code", ["utf-16", "utf-16-le", "utf-16-be"])
def test_text_of_spreadsheets_in_two_bytes_a_letter_is_read(tmp_path, code):
    """A file in UTF-16, with its mark or without, is the same profile."""
    (tmp_path / "p.csv").write_text(lines_of(points_of("rail"), "{:.6f},{:.6f}"), encoding=code)
    found = read_profile(tmp_path / "p.csv", ReadOptions(unit="mm", kind="rail", smooth_mm=0.0))
    np.testing.assert_allclose(found.points, points_of("rail"), atol=6e-7)


@pytest.mark.parametrize(
    "head",
    ["n,x,y,angle", "point;X [mm];Y [mm];A", "No y_mm z_mm dev", "a line with y and x\nn\tX\tY\tcurvature", "\t"],
)
def test_named_columns_are_taken_wherever_they_stand(head, tmp_path):
    """Columns called x and y, or y and z, are the coordinates; else those that neither count points nor stay."""
    points = points_of("rail")
    separator = next(each for each in "\t;, " if each in head.splitlines()[-1])
    rows = [separator.join((str(n), f"{x:.6f}", f"{y:.6f}", "0.5")) for n, (x, y) in enumerate(points)]
    path = saved(tmp_path, "p.txt", "\n".join([head, *rows]))
    found = read_profile(path, ReadOptions(unit="mm", kind="rail", smooth_mm=0.0))
    np.testing.assert_allclose(found.points, points, atol=6e-7)
    assert any("numbers 2 and 3 are taken" in notice for notice in found.notices)


@pytest.mark.parametrize(("unit", "length"), [("m", 1000.0), ("in", 25.4)])
def test_units_are_converted(unit, length, tmp_path):
    """A file in another unit, named by comment, column or option, gives the same mm; the unit is reported."""
    points = points_of("rail")
    body = lines_of(points / length, "{:.12f},{:.12f}")
    for name, text, options in (
        ("a.txt", f"# unit: {unit}\n{body}", None),
        ("b.csv", f"x_{unit},y_{unit}\n{body}", None),
        ("c.txt", body, unit),
    ):
        found = read_profile(saved(tmp_path, name, text), ReadOptions(unit=options, smooth_mm=0.0))
        np.testing.assert_allclose(found.points, points, atol=1e-8)
        assert found.orientation.unit == unit


def miniprof(points, columns="X,Y", **header):
    keys = {"ProgramName": "made", "XYPoints": len(points), "ColumnDef": columns, **header}
    orders = {"X,Y": "{0:.4f} {1:.4f}", "N,Y,X,A": "7 {1:.4f} {0:.4f} 0.1"}
    head = "".join(f"{key}={value}\n" for key, value in keys.items())
    return f"{head}\n" + lines_of(points, orders[columns])


def test_miniprof_columns_comments_and_titles(tmp_path):
    """ColumnDef orders the columns, quoted lines are comments, and the title is the file's."""
    points = points_of("rail")
    text = miniprof(points, "N,Y,X,A", MPDN="Rail 7").replace("ColumnDef", '"ColumnDef=X,Y"\nColumnDef')
    text += '\n" 7 1.0 2.0 a line that was struck out\n'
    found = read_profile(saved(tmp_path, "r.BAN", text), ReadOptions(smooth_mm=0.0))
    np.testing.assert_allclose(found.points, points, atol=6e-5)
    assert found.title == "Rail 7"


@pytest.mark.parametrize("tape", [70.0, 77.8])
def test_miniprof_wheels_count_from_the_flange_back(tape, tmp_path):
    """The tape line is where WheelDiameterTaperline says, the flange's tip is turned down, the tread is at zero."""
    points = points_of("wheel")
    shown = (points + np.array([70.0, 0.0])) * [1.0, -1.0]
    text = miniprof(shown, WheelDiameterTaperline=tape)
    found = read_profile(saved(tmp_path, "w.whl", text), ReadOptions(smooth_mm=0.0))
    assert found.orientation.origin == "flange-back"
    assert found.orientation.tape_mm == tape
    tread = float(np.interp(tape - 70.0, points[:, 0], points[:, 1]))
    expected = points - [tape - 70.0, tread if abs(tread) > 0.05 else 0.0]
    np.testing.assert_allclose(found.points, expected, atol=2e-4)


def test_old_miniprof_files_are_read(tmp_path):
    """Files without keys have words in their first lines, numbers among them, and points after an empty line."""
    points = points_of("wheel") * [1.0, -1.0] + [70.0, 0.0]
    text = "MINIPROF 101 148 1994 3 24\nwheel.prd\nStock.......:\n32.58 37.11 14.71  (Sd/Sh/qR)\n\n" + lines_of(points)
    found = read_profile(saved(tmp_path, "old.whl", text), ReadOptions(smooth_mm=0.0))
    assert len(found.points) == len(points)
    np.testing.assert_allclose(found.points, points_of("wheel"), atol=1e-5)


def simpack(points, kind="rail", **keys):
    spline = "".join(f"  {key.replace('_', '.')} = {value}\n" for key, value in keys.items())
    return (
        f"! comment = 'not this'\nheader.begin\n  version = 1\n  type = {int(kind == 'wheel')}\nheader.end\n"
        f"spline.begin\n  comment = 'Rail! 8' ! the name\n  type = 0\n{spline}  point.begin\n"
        + lines_of(points, "    {:+.9e} {:+.9e} 1.0")
        + "\n  point.end\nspline.end\n"
    )


def test_simpack_points_are_processed_as_the_file_asks(tmp_path):
    """Mirrors, order, shift, rotation, unit and bounds of a Simpack file are undone in its own order."""
    points = points_of("rail")[::-1]  # from the gauge side outwards, as Simpack wants
    target = points * [1.0, -1.0]
    angle, shift = 0.02, np.array([0.3, -0.2])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    # from the end of the file's list of changes to its beginning
    raw = target[::-1] * [-1.0, 1.0]
    raw = np.vstack([raw, [[-300.0, 0.0]]])  # beyond the bounds
    raw = (raw @ turn - shift) / 1000.0
    text = simpack(
        raw, shift_y=shift[0] / 1e3, shift_z=shift[1] / 1e3, rotate=np.degrees(angle), units_ang_f=180.0 / np.pi,
        bound_y_min=-0.2, bound_y_max=0.2, mirror_y=1, mirror_z=0, inversion=1, units_len_f=1.0,
    )  # fmt: skip
    found = read_profile(saved(tmp_path, "r.prr", text), ReadOptions(smooth_mm=0.0))
    np.testing.assert_allclose(found.points, points[::-1], atol=1e-6)
    assert found.title == "Rail! 8"
    assert found.orientation.unit == "mm"


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.ban", "[FileInfo]\nProgramName=x\n", "several profiles"),
        ("a.ban", "ColumnDef=X,A\n\n1 2\n", "columns X and Y"),
        ("a.ban", "ColumnDef=X,Y\n\n1 2\n3\n", "line 4"),
        ("a.prr", "header.begin\ntype = 1\nheader.end\nspline.begin\npoint.begin\n1 2\npoint.end\nspline.end", "wheel"),
        ("a.prr", "spline.begin\npoint.begin\n1 2\n", "without its end"),
        ("a.prw", "spline.begin\nunits.len.f = -1\npoint.begin\n1 2\npoint.end\nspline.end", "units.len.f"),
        ("a.txt", "1 2\nthree 4\n", "line 2"),
        ("a.txt", "# kind: tram\n1 2\n", "kind = 'tram'"),
        ("a.txt", "1 nan\n", "line 1: '1 nan'"),
        ("a.txt", "1 1e9\n", "line 1: the point"),
        ("a.dxf", "hello", "DXF"),
        ("a.step", "1 2", "ending '.step'"),
        ("b.txt", "", "empty"),
        ("b.ban", "\0\1\2\3", "no text"),
        ("p.txt", "# unit: mm\n" + lines_of(points_of("rail")[:, ::-1]), "exchange the columns"),
        ("p.csv", lines_of(points_of("rail"), "{:.3f}.{:.3f}").replace(".", ","), "commas in the numbers and between"),
    ],
)  # fmt: skip
def test_broken_files_are_refused_with_their_place(name, text, message, tmp_path):
    """Each mistake in a file ends in a message that names the file and the line or key, and says what to do."""
    with pytest.raises(InputError, match=message) as caught:
        read_profile(saved(tmp_path, name, text))
    assert name in str(caught.value)
    assert caught.value.advice


@pytest.mark.parametrize(("kind", "ending"), [("wheel", "miniprof"), ("rail", "simpack")])
def test_decimal_commas_are_read_in_files_of_other_programs(kind, ending, tmp_path):
    """Instruments and tables of some countries write 1,5 for 1.5: the points are the same numbers."""
    points = points_of(kind)
    text = write_miniprof(points, kind, "a") if ending == "miniprof" else write_simpack(points, kind, "a")
    names = {"miniprof": {"rail": "a.ban", "wheel": "a.whl"}, "simpack": {"rail": "a.prr", "wheel": "a.prw"}}
    name = names[ending][kind]
    options = ReadOptions(smooth_mm=0.0)
    wanted = read_profile(saved(tmp_path, name, text), options)
    found = read_profile(saved(tmp_path, name, re.sub(r"(\d)\.(\d)", r"\1,\2", text)), options)
    np.testing.assert_array_equal(found.points, wanted.points)
    assert found.orientation.tape_mm == wanted.orientation.tape_mm


@pytest.mark.parametrize("ending", [".ban", ".prr", ".txt", ".csv", ".rail"])
@pytest.mark.parametrize("between", [";", " ; ", "\t", "  ", ", ", ";\t"])
def test_any_separator_goes_with_decimal_commas(ending, between, tmp_path):
    """Decimal commas beside semicolons, tabs, blanks, and commas with a blank: the numbers of decimal points."""
    points = points_of("rail", 1.0)
    rows = lines_of(points, "{:.6f}" + between + "{:.6f}").replace(".", ",")
    text = {".ban": miniprof([]) + rows, ".prr": f"spline.begin\npoint.begin\n{rows}\npoint.end\nspline.end\n"}
    path = saved(tmp_path, "p" + ending, text.get(ending, rows) + "\n")
    found = read_profile(path, ReadOptions(unit="mm", kind="rail", smooth_mm=0.0))
    np.testing.assert_allclose(np.abs(found.points), np.abs(points), atol=6e-7)


@pytest.mark.parametrize("ending", [".whl", ".ban", ".prw", ".txt", ".csv", ".dat", ".wheel"])
@pytest.mark.parametrize("end", [b"\x1a", b"\r\n\x1a\x1a\x1a", b"\n\x1arest of a block 1 2 3\n"])
def test_files_of_dos_end_at_their_mark(ending, end, tmp_path):
    """A control-Z ends a file of DOS, whatever its format; comments behind ``#`` are no points."""
    kind = "rail" if ending == ".ban" else "wheel"
    points = points_of(kind, 1.0)
    rows = lines_of(points * [1.0, 1.0 if kind == "rail" else -1.0] + [0.0 if kind == "rail" else 70.0, 0.0])
    plain = lines_of(points)
    text = {
        ".prw": f"spline.begin\npoint.begin\n{rows}\n# a comment = 1\npoint.end\nspline.end\n",
        ".whl": miniprof([], WheelDiameterTaperline=70.0) + rows.replace("\n", "\n# a comment, 7\n", 3),
        ".ban": miniprof([]) + rows.replace("\n", "\n# 1 2\n", 3),
    }
    path = tmp_path / ("p" + ending)
    content = text.get(ending, plain.replace("\n", "\n# 1 2\n", 3)).encode() + b"\n"
    path.write_bytes(content)
    options = ReadOptions(unit="mm", kind=kind, smooth_mm=0.0)
    wanted = read_profile(path, options)
    path.write_bytes(content + end)
    np.testing.assert_array_equal(read_profile(path, options).points, wanted.points)
    assert len(wanted.points) == len(points)


@pytest.mark.parametrize("ending", [".ban", ".prr", ".txt", ".csv", ".rail"])
@pytest.mark.parametrize("row", [0, 7])
@pytest.mark.parametrize("place", [0, 1])
def test_underscores_are_no_part_of_numbers(ending, row, place, tmp_path):
    """6_0.0, which Python reads as 60, is refused in every format, in the first row too."""
    rows = [f"{x:.6f} {y:.6f}".split() for x, y in points_of("rail", 1.0)]
    rows[row][place] = "6_0.000"
    body = "\n".join(map(" ".join, rows))
    text = {".ban": miniprof([]) + body, ".prr": f"spline.begin\npoint.begin\n{body}\npoint.end\nspline.end\n"}
    with pytest.raises(InputError, match="line"):
        read_profile(saved(tmp_path, "p" + ending, text.get(ending, body)), ReadOptions(unit="mm", kind="rail"))


@pytest.mark.parametrize("kind", ["rail", "wheel"])
@pytest.mark.parametrize(
    "shape",
    [
        lambda x, y: {"x": x, "y": y},
        lambda x, y: {"y": x, "z": y, "title": "a head"},
        lambda x, y: {"points": list(zip(x, y, strict=True))},
        lambda x, y: list(zip(x, y, strict=True)),
        lambda x, y: [x, y],
    ],
)
def test_json_of_two_columns_is_read(kind, shape, tmp_path):
    """Two lists of coordinates, or a list of points, alone or named in an object, are the points of two columns."""
    points = points_of(kind, 1.0)
    data = shape(*points.T.tolist())
    if isinstance(data, dict):
        data |= {"unit": "mm", "kind": kind, "up": True}
    found = read_profile(saved(tmp_path, "p.json", json.dumps(data)), ReadOptions(unit="mm", kind=kind, smooth_mm=0.0))
    np.testing.assert_allclose(found.points, points, atol=NANOMETRE)


@pytest.mark.parametrize(
    "text",
    ["{", "[[1, 2], [3]]", '{"x": [1], "y": 2}', '{"x": [1, 2, 3, 4], "y": [1, 2]}', '[["1", "2"]]', "7", "[" * 10_000],
)
def test_json_of_another_shape_is_refused(text, tmp_path):
    """What is no JSON, or no pairs of numbers, is refused with the shapes that are read."""
    with pytest.raises(InputError, match="JSON"):
        read_profile(saved(tmp_path, "p.json", text))


def test_endings_of_rails_and_wheels_give_the_kind(tmp_path):
    """Two columns in ``.rail`` and ``.wheel`` are a rail and a wheel without another word."""
    for kind in ("rail", "wheel"):
        path = saved(tmp_path, f"p.{kind}", lines_of(points_of(kind, 1.0)))
        assert read_profile(path).kind == kind


@pytest.mark.parametrize("ending", [".txt", ".whl", ".prw", ".json"])
def test_sizes_are_bounded_before_points_are_made(ending, tmp_path):
    """A hundred thousand points, and lines of megabytes, are refused in a moment."""
    rows = [(n * 1e-3, 0.0) for n in range(MAX_POINTS + 1)]
    text = json.dumps(rows) if ending == ".json" else lines_of(rows, "{:.3f} {:.1f}")
    if ending == ".prw":
        text = f"spline.begin\npoint.begin\n{text}\npoint.end\nspline.end\n"
    with pytest.raises(InputError, match=f"{MAX_POINTS + 1} points"):
        read_profile(saved(tmp_path, "p" + ending, text))
    if ending != ".json":
        with pytest.raises(InputError, match="letters"):
            read_profile(saved(tmp_path, "q" + ending, "1 " * 1_000_000))


@pytest.mark.parametrize(("kind", "at"), [("rail", -753.7), ("wheel", 750.0)])
def test_coordinates_of_the_track_need_an_origin(kind, at, tmp_path):
    """A profile far from its own origin is not placed by a guess; with the option it has its own coordinates."""
    points = points_of(kind)
    file = saved(tmp_path, "p.txt", lines_of(points + np.array([at, 5.0])))
    with pytest.raises(InputError, match="--origin X,Y"):
        read_profile(file, ReadOptions(unit="mm", kind=kind))
    found = read_profile(file, ReadOptions(unit="mm", kind=kind, origin=f"{at},5", smooth_mm=0.0))
    np.testing.assert_allclose(found.points, points, atol=2e-3)


def rounded_csv(digits, unit="mm", gap=0.0):
    """An S1002's lines and arcs, as a table would print them, the tread shifted up by a gap."""
    surface, scale = wheel("S1002").running_surface, {"mm": 1.0, "in": 25.4}[unit]
    rows = [f"# unit: {unit}", "# kind: wheel", "# origin: tape", "# up: yes", "name,type,x0,y0,x1,y1,xc,yc,turn"]
    for name, s in zip(surface.names, surface.segments, strict=True):
        ends = [(x / scale, (y + (gap if name == "tread_1:15" else 0.0)) / scale) for x, y in (s.start, s.end)]
        cells = [f"{c:.{digits}f}" for end in ends for c in end]
        if hasattr(s, "centre"):
            cells += [*(f"{c / scale:.{digits}f}" for c in s.centre), "left" if s.counter_clockwise else "right"]
        rows.append(",".join([name, "arc" if hasattr(s, "centre") else "line", *cells, *[""] * (7 - len(cells))]))
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize(("unit", "gap"), [("mm", 5e-4), ("mm", 9e-3), ("in", 5e-4)])
def test_small_gaps_are_closed_with_a_notice(unit, gap, tmp_path):
    """A gap of 0.0005 mm in a table of arcs is closed, which moves the surface by less than that, and is said."""
    found = read_profile(saved(tmp_path, "wheel.csv", rounded_csv(9, unit, gap)))
    assert any("gaps between lines and arcs are closed" in each for each in found.notices)
    points = wheel("S1002").running_surface.sampled(spacing=1.0)
    assert found.surface.closest(points)[2].max() < 1.05 * gap
    for segment in found.surface.segments:
        if hasattr(segment, "centre"):
            radii = [math.dist(segment.centre, end) for end in (segment.start, segment.end)]
            assert radii[0] == pytest.approx(radii[1], rel=1e-12)


def test_wide_gaps_are_refused_with_their_limit(tmp_path):
    """A gap above the tolerance is no rounding and is refused."""
    with pytest.raises(InputError, match=r"0\.05 from the end") as reason:
        read_profile(saved(tmp_path, "wheel.csv", rounded_csv(9, gap=0.05)))
    assert "0.01" in reason.value.allowed


def test_comments_are_read_without_a_colon_and_in_capitals(tmp_path):
    """``# unit in``, ``# Kind: Rail``, ``# MIRROR yes`` mean what they say; a wrong value is refused with its line."""
    rows = lines_of(points_of("rail") * [-1.0, 1.0] / 25.4)
    head = "# unit in\n# Kind: Rail\n# ORIGIN top\n# up yes\n# mirror: yes\n"
    found = read_profile(saved(tmp_path, "rail.txt", head + rows))
    assert (found.orientation.unit, found.kind, found.orientation.mirrored) == ("in", "rail", True)
    assert {found.orientation.how[key] for key in ("unit", "kind", "side", "origin")} == {"from the file"}
    with pytest.raises(InputError, match="furlong"):
        read_profile(saved(tmp_path, "rail.txt", "# unit furlong\n" + rows))
    path = saved(tmp_path, "rail.txt", "# unit of length is inch\n# unit: in\n# the unit of this file\n" + rows)
    unread = [each for each in read_profile(path).notices if "is not read" in each]
    assert len(unread) == 1
    assert "line 1" in unread[0]


WORDS = (
    "header.begin", "header.end", "spline.begin", "spline.end", "point.begin", "point.end", "units.len.f = 1000",
    "type = 1", "mirror.y = 1", "inversion = 1", "rotate = 1e300", "bound.y.min = -1", "bound.y.max = 1", "[FileInfo]",
    "MINIPROF", "ColumnDef=X,Y", "ColumnDef=X,Y,A,C", "XYPoints=20", "WheelDiameterTaperline=70", "XOffset=1,2", "",
    "name,type,x0,y0,x1,y1,xc,yc", "a,line,0,0,1,1", "a,arc,0,0,1,1,1,0", "x_mm,y_mm", "# unit: mm", "# kind: wheel",
    "# up: no", "# origin: tape", "# mirror", "# tape_mm: nan", "1;2", "1,5 2,5", "1e400 2", "-0.0 nan", "inf inf",
    "0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n0\n20\n0\n11\n1\n21\n1\n0\nENDSEC\n0\nEOF",
)  # fmt: skip
NUMBER = st.floats(-500.0, 500.0).map(lambda value: f"{value:.4g}") | st.floats().map(str) | st.just("0")
POINT = st.tuples(NUMBER, st.sampled_from([" ", "\t", ",", ";"]), NUMBER).map("".join)
LINE = st.sampled_from(WORDS) | POINT | st.text(string.printable, max_size=12)
TEXT = st.lists(LINE, max_size=40).map("\n".join)
NOT_SLOW = settings(suppress_health_check=list(HealthCheck))
COSTLY = settings(settings.get_profile("costly"), suppress_health_check=list(HealthCheck))


def refuse_empty_parts(error):
    assert error.given
    assert error.allowed
    assert error.advice


def read(folder, ending, content, options=None):
    path = folder / f"any{ending}"
    path.write_bytes(content)
    try:
        found = read_profile(path, options)
    except InputError as reason:
        return refuse_empty_parts(reason)
    assert isinstance(found, MeasuredProfile)
    assert np.isfinite(found.points).all()
    return found


@NOT_SLOW
@given(ending=st.sampled_from(sorted(FORMATS)), text=TEXT, kind=st.sampled_from([None, "rail", "wheel"]))
def test_random_lines(ending, text, kind, tmp_path):
    """Lines of words that the formats know, numbers and rubbish give a profile or a message of three parts."""
    read(tmp_path, ending, text.encode(), ReadOptions(unit="mm", kind=kind))


@functools.cache
def s1002(spacing):
    return wheel("S1002").running_surface.sampled(spacing=spacing)


ANY_WORD = st.sampled_from(["mm", "in", "m", "rail", "wheel", "tape", "top", "1,2"]) | st.text(string.printable + "üß€")
ANY_OPTIONS = st.one_of(
    st.builds(ReadOptions, unit=ANY_WORD),
    st.builds(ReadOptions, kind=ANY_WORD),
    st.builds(ReadOptions, origin=ANY_WORD),
    st.builds(ReadOptions, origin=st.tuples(st.floats(), st.floats()).map("{0[0]},{0[1]}".format)),
    st.builds(ReadOptions, origin=st.just("flange-back"), tape_mm=st.floats()),
    st.builds(ReadOptions, smooth_mm=st.floats()),
    st.builds(ReadOptions, limit_um=st.floats(), smooth_mm=st.just(5.0)),
)


@COSTLY
@given(options=ANY_OPTIONS)
def test_random_options(options, tmp_path):
    """Options of any value, for a sound file, give a profile or a message."""
    read(tmp_path, ".txt", sound_points(), options)


@functools.cache
def sound_points():
    return "\n".join(f"{x:.5f} {y:.5f}" for x, y in s1002(2.0)).encode()


@COSTLY
@given(
    ending=st.sampled_from([".csv", ".dxf", ".prw", ".whl", ".txt"]),
    changes=st.lists(
        st.tuples(st.floats(0.0, 1.0), st.sampled_from([*b'0123456789.-+eE,; \n#X"!%=']), st.integers(0, 40)),
        max_size=6,
    ),
)
def test_damaged_files_of_all_formats(ending, changes, tmp_path):
    """Sound files of all formats with bytes changed or cut out are read or refused."""
    content = bytearray(sound_file(ending))
    for place, byte, cut in changes:
        i = int(place * (len(content) - 1))
        content[i : i + cut] = bytes([byte])
    read(tmp_path, ending, bytes(content))


@functools.cache
def sound_file(ending):
    run = run_profile("S1002")
    return profile_text(run.profile, ending).encode()
