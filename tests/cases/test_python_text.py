"""Case files as Python: the text of constructors makes the same record again."""

import ast
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flangeway.cases import Wheelset, load_case
from flangeway.cases.case_file import CASE_FILES, CASES, write_case_file, write_python
from flangeway.errors import InputError
from flangeway.railway import wheel


def made(text):
    names = {}
    exec(compile(text, "case.py", "exec"), names)
    return names["case"]


@pytest.mark.parametrize("name", [*CASE_FILES, *CASES])
def test_the_python_of_a_bundled_case_makes_the_same_record(name):
    """Every bundled case, of wheelsets and of bodies, is equal to what its Python text makes."""
    case = CASES[name].from_values(CASES[name].example) if name in CASES else load_case(name)
    assert made(write_python(case)) == case


NUMBERS = st.floats(1.0, 50.0)
SUPPORTS = st.one_of(
    st.just("fixed"),
    st.fixed_dictionaries({"kind": st.just("continuous"), "vertical_kN_per_mm": NUMBERS}),
    st.fixed_dictionaries({"spacing_mm": st.floats(500.0, 700.0), "position": st.floats(0.0, 0.9)}),
)
LOADS = st.one_of(
    st.fixed_dictionaries({"axle_load_kN": st.floats(50.0, 300.0), "lateral_force_kN": st.floats(-20.0, 20.0)}),
    st.fixed_dictionaries({"car": st.fixed_dictionaries({"mass_t": st.floats(20.0, 90.0)})}),
    st.fixed_dictionaries(
        {
            "curve": st.fixed_dictionaries(
                {
                    "radius_m": st.floats(300.0, 900.0),
                    "speed_km_h": st.floats(20.0, 90.0),
                    "superelevation_mm": st.one_of(st.floats(0.0, 100.0), st.just({"kind": "from-speed"})),
                }
            )
        }
    ),
)
TREES = st.fixed_dictionaries(
    {},
    optional={
        "track": st.fixed_dictionaries(
            {},
            optional={
                "rail": st.sampled_from(["60E1", "136RE"]),
                "support": SUPPORTS,
                "left": st.fixed_dictionaries({"inclination": st.floats(0.0, 0.1)}, optional={"support": SUPPORTS}),
            },
        ),
        "wheelset": st.fixed_dictionaries(
            {},
            optional={
                "wheel": st.just({"file": 'worn "left".whl', "mirror": True}),
                "axle": st.sampled_from(["rigid", {"diameters_mm": [[0.0, 180.0]]}]),
                "section": st.just("whole"),
            },
        ),
        "load": LOADS,
        "position": st.fixed_dictionaries({"lateral_mm": st.floats(-8.0, 8.0)}),
        "contact": st.fixed_dictionaries({"patch_cells": st.integers(10, 60)}),
        "mesh": st.fixed_dictionaries({"order": st.integers(1, 2), "size_scale": st.floats(0.5, 4.0)}),
    },
)


@pytest.mark.hypothesis
@given(TREES)
def test_random_wheelsets_are_the_same_in_python(tree):
    """The Python text of a random tree of inputs makes an equal record, with the same case file."""
    case = Wheelset.from_values(tree)
    again = made(write_python(case))
    assert again == case
    assert write_case_file(again) == write_case_file(case)


@pytest.mark.parametrize(
    ("inputs", "kind"),
    [({"spacing_mm": 500.0}, "sleepers"), ({"vertical_kN_per_mm": 20.0}, "sleepers"), ({"kind": "fixed"}, "fixed")],
)
def test_a_kind_without_default_is_the_first_that_has_the_inputs(inputs, kind):
    """What one rail stands on has no default of its own: its kind is told by its inputs, and sleepers come first."""
    assert Wheelset.from_values({"track": {"left": {"support": inputs}}}).track.left.support.kind == kind


def test_inputs_of_no_kind_are_refused():
    """A table whose inputs no kind has is refused, and the kinds are named."""
    with pytest.raises(InputError) as reason:
        Wheelset.from_values({"track": {"left": {"support": {"gap_mm": 3.0}}}})
    assert "track.left.support.kind" in reason.value.given
    assert all(kind in reason.value.allowed for kind in ("sleepers", "continuous", "fixed"))


def test_defaults_are_left_out():
    """A wheelset by default has no argument, one changed input one."""
    assert write_python(Wheelset()) == "from flangeway import Wheelset\n\ncase = Wheelset()\n"
    assert "case = Wheelset(position=Position(lateral_mm=3.0))" in write_python(load_case("wheelset", lateral_mm=3.0))


def test_a_profile_of_a_script_is_refused():
    """A profile that a script made has no name to write."""
    with pytest.raises(InputError, match="script"):
        write_python(Wheelset.from_values({"wheelset": {"wheel": wheel("S1002")}}))


def test_the_command_writes_a_script_of_a_case_and_of_a_file(call, tmp_path):
    """`init --python` writes NAME.py for a case and for a case file; it begins with imports and computes the case."""
    status, out, err = call("init", "wheelset-curve", "--python")
    assert status == 0, err
    assert "python wheelset-curve.py" in out
    script = (tmp_path / "wheelset-curve.py").read_text(encoding="utf-8")
    assert isinstance(ast.parse(script).body[-1], ast.Expr)
    assert made(script.replace("print(case.run())", "")) == load_case("wheelset-curve")
    (tmp_path / "mine.toml").write_text('case = "torsion"\n', encoding="utf-8")
    assert call("init", "mine.toml", "--python")[0] == 0
    done = subprocess.run([sys.executable, "mine.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "SectionRun" in done.stdout
    assert call("init", "torsion", "--python", "--units", "us", "--to", "us.py")[0] == 2
