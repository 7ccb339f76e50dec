"""Whatever a file holds: every reader gives a profile or a clear error, never another exception."""

import functools
import string

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flangeway.cases.profile.profile_run import run_profile
from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import wheel
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import FORMATS, MeasuredProfile, profile_text, read_profile

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
