"""Case files: templates, every kind of mistake, settings, the schema, and text of all kinds."""

import json
import tomllib
from datetime import timedelta

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flangeway.errors import InputError
from flangeway.study import CASES, WheelsetCurveCase, WheelsetTangentCase, load_case, schema, write_template
from flangeway.study.case_file import FORMAT, check_case, read_case
from flangeway.study.case_template import toml_value

COARSE = {
    "wheelset-tangent": {"size_scale": 4.0},
    "wheelset-curve": {"size_scale": 4.0},
    "hertz": {"size_mm": 0.4},
    "contact-patch": {"upper_size_mm": 5.0},
    "cook": {"level": 1},
    "torsion": {"size": 20.0},
    "two-bodies": {"bodies.cylinder.size_mm": 20.0, "bodies.2.size_mm": 20.0},
}


def file_of(folder, text, name="case.toml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", CASES)
def test_a_new_file_is_the_case_with_its_defaults(tmp_path, name):
    """What `init` writes is read, checked, and has the values of the case without inputs (or of its example)."""
    case = load_case(file_of(tmp_path, write_template(CASES[name])))
    assert type(case) is CASES[name]
    check_case(case)
    without = CASES[name].from_values(CASES[name].example)
    assert case == without


@pytest.mark.parametrize("name", CASES)
def test_a_new_file_explains_every_key(name):
    """The file names each key once, set or as a comment, below a line with its meaning and its range."""
    lines = write_template(CASES[name]).splitlines()
    assert max(map(len, lines)) <= 220
    for caption, rows in CASES[name].tables_of_inputs():
        if caption.count(".") or not rows:
            continue
        for key, _, allowed, meaning in rows:
            tables = any(line.strip("# ") in (f"[[{key}]]", f"[{key}]") for line in lines)
            found = [n for n, line in enumerate(lines) if line.lstrip("# ").startswith(f"{key} =")]
            assert found or tables, key
            if not tables:
                above = " ".join(line.strip("# ") for line in lines[max(found[0] - 5, 0) : found[0]])
                assert meaning.split()[0] in above, key
                assert allowed.split()[0] in above, key


@pytest.mark.parametrize("name", CASES)
def test_every_case_runs_from_its_file(tmp_path, name):
    """Each case runs on a coarse mesh from its file, converges, and tells its inputs in a summary of plain numbers."""
    run = read_case(file_of(tmp_path, write_template(CASES[name])), COARSE[name]).run()
    assert run.status.converged
    assert run.summary["status"]["converged"] is True
    assert run.summary["case"]["name"] == name
    json.dumps(run.summary, allow_nan=False)


def test_a_file_of_few_lines_is_the_same_as_python(tmp_path):
    """Seven lines of TOML with one's own profile names give the case that Python gives with the same inputs."""
    text = 'case = "wheelset-curve"\nrail = "60E1"\nwheel = "S1002"\ngauge_mm = 1435.0\nspeed_km_h = 70\n'
    found = load_case(file_of(tmp_path, text + 'curve_radius_m = 400\nsuperelevation_mm = "from-speed"\n'))
    inputs = {"rail": "60E1", "wheel": "S1002", "gauge_mm": 1435.0, "speed_km_h": 70, "curve_radius_m": 400}
    assert found == WheelsetCurveCase.from_values({**inputs, "superelevation_mm": "from-speed"})
    assert found == load_case("wheelset-curve", **inputs, superelevation_mm="from-speed")


def test_files_are_found_beside_the_case_file(tmp_path, monkeypatch):
    """A relative path of an outline counts from the case file's folder, from wherever it is run."""
    (tmp_path / "cases" / "drawn").mkdir(parents=True)
    drawing = 'unit = "mm"\n[outer]\npoints = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]\n'
    file_of(tmp_path / "cases" / "drawn", drawing, "box.toml")
    path = file_of(tmp_path / "cases", 'case = "torsion"\nsection = "drawn/box.toml"\nsize = 1.0\n')
    monkeypatch.chdir(tmp_path)
    case = load_case("cases/case.toml")
    check_case(case, path)
    assert case.run().summary["area_mm2"] == pytest.approx(12.0)


def test_settings_go_before_the_file(tmp_path):
    """A setting replaces the file's value, also inside tables, by number or by name."""
    path = file_of(tmp_path, write_template(CASES["two-bodies"]))
    case = read_case(path, {"thickness_mm": "3", "bodies.block.poisson": "0.25", "motions.1.push_N": "[0.0, -5.0]"})
    assert case.thickness_mm == 3.0
    assert [body.poisson for body in case.bodies] == [0.3, 0.25]
    assert case.motions[0].push_N == (0.0, -5.0)


TWO = """case = "two-bodies"
[[bodies]]
name = "a"
rectangle = { width_mm = 2.0, height_mm = 1.0 }
[[bodies]]
name = "b"
young_MPa = 1.0
rectangle = { width_mm = 2.0, height_mm = 1.0, centre_mm = [0.0, -1.0] }
"""

WRONG = {
    "not TOML": ("case = wheelset", ["not TOML", "line 1"], "quotation marks"),
    "twice": ('case = "hertz"\nradius_mm = 1\nradius_mm = 2\n', ["not TOML", "line 3"], "correct the place"),
    "no case": ("gauge_mm = 1435.0\n", ["no key case"], "flangeway cases"),
    "an outline": ("[outer]\npoints = [[0, 0]]\n", ["no key case"], "flangeway section"),
    "unknown case": ('\ncase = "wheelset-tangnt"\n', ["line 2", "wheelset-tangnt"], "did you mean wheelset-tangent?"),
    "case is a number": ("case = 3\n", ["line 1", "'3'"], "choose one of these"),
    "unknown key": ('case = "hertz"\n# radius\nradus_mm = 3.0\n', ["line 3", "radus_mm"], "did you mean radius_mm?"),
    "unknown table": ('case = "hertz"\n[wheel]\nx = 1\n', ["line 2", "'wheel'"], "choose one of these"),
    "text": ('case = "hertz"\nradius_mm = "wide"\n', ["line 2", "radius_mm = 'wide'", "a number above 0"], "take 40"),
    "switch": ('case = "hertz"\nradius_mm = true\n', ["line 2", "radius_mm = true", "a number above 0"], "take 40"),
    "list": ('case = "hertz"\nradius_mm = [1.0]\n', ["line 2", "radius_mm = [1.0]"], "leave radius_mm out"),
    "date": ('case = "hertz"\nradius_mm = 2020-01-01\n', ["line 2", "radius_mm = "], "leave radius_mm out"),
    "range": ('case = "cook"\nlevel = 9\n', ["line 2", "level = 9", "from 1 up to 6"], "leave level out"),
    "infinite": ('case = "hertz"\nradius_mm = inf\n', ["line 2", "radius_mm = inf"], "leave radius_mm out"),
    "choice": ('case = "hertz"\nmethod = "fvm"\n', ["line 2", "method = 'fvm'", "fem or vem"], "take fem"),
    "two mistakes": ('case = "hertz"\norder = 7\nradius_mm = -1\n', ["line 2", "line 3", "order = 7"], "take 40"),
    "newer format": ("flangeway = 2\ncase = 'hertz'\n", ["line 1", "newer", "up to 1"], "install a newer flangeway"),
    "format is text": ('flangeway = "1"\ncase = "hertz"\n', ["line 1", "flangeway = '1'"], "leave it out"),
    "missing file": ('case = "wheelset-curve"\n\nrail = "worn.txt"\n', ["line 3", "worn.txt"], "correct the path"),
    "missing rail": ('case = "wheelset-curve"\nrail = "UIC33"\n', ["case.toml", "'UIC33'", "136RE"], "choose"),
    "both forces": ('case = "hertz"\nforce_N = 9\nindentation_mm = 1\n', ["force_N and indentation_mm"], "leave one"),
    "too wide": ('case = "hertz"\nindentation_mm = 39.0\n', ["a contact that may reach"], "smaller"),
    "order": ('case = "cook"\nmethod = "fem"\norder = 4\n', ["line 3", "order = 4"], "vem"),
    "no section": ('case = "torsion"\nsection = "137RE"\n', ["137RE"], ""),
    "no body": ('case = "two-bodies"\n', ["no bodies"], "give bodies"),
    "no name": ('case = "two-bodies"\n[[bodies]]\npoisson = 0.2\n', ["line 2", "bodies[1].name"], "give name"),
    "no shape": ('case = "two-bodies"\n[[bodies]]\nname = "a"\n', ["line 3", "no shape"], "rectangle"),
    "inner key": (TWO + "youngs_MPa = 3.0\n", ["line 9", "'youngs_MPa' in bodies[2]"], "did you mean young_MPa?"),
    "inner range": (TWO.replace("MPa = 1.0", "MPa = 0.0"), ["line 7", "bodies[2].young_MPa = 0.0"], "take 210000"),
    "deep key": (TWO.replace("centre_mm", "center_mm"), ["line 8", "'center_mm' in bodies[2].rectangle"], "centre_mm?"),
    "point of 3": (TWO.replace("-1.0]", "-1.0, 2.0]"), ["line 8", "centre_mm", "[a number, a number]"], "leave"),
    "name twice": (TWO.replace('"b"', '"a"'), ["line 6", "for the second time"], "rename"),
    "support of nobody": (TWO + '[[supports]]\nbody = "c"\nedges = "top"\n', ["line 10", "'c'"], "choose one"),
    "no place": (TWO + '[[supports]]\nbody = "a"\n', ["line 9", "supports[1] without a place"], "say where"),
    "no such edges": (
        TWO + '[[supports]]\nbody = "a"\nedges = "topp"\n', ["line 11", "supports[1].edges = 'topp'"], "mean top?",
    ),
    "empty box": (TWO + '[[supports]]\nbody = "a"\nbox_mm = [8, 8, 9, 9]\n', ["line 9", "no boundary edge"], "correct"),
    "no such point": (TWO + '[[supports]]\nbody = "a"\npoint_mm = [0.3, 9]\n', ["line 11", "nearest"], "corner"),
    "moved but free": (
        TWO + '[[supports]]\nbody = "a"\nedges = "top"\nhold = "x"\ny_mm = 1\n', ["line 13", "supports[1].y_mm"], "xy",
    ),
    "no load": (TWO + '[[loads]]\nbody = "a"\nedges = "top"\n', ["line 9", "loads[1] with no load"], "make each"),
    "two loads": (
        TWO + '[[loads]]\nbody = "a"\nedges = "top"\npressure_MPa = 1\nforce_N = [0, 1]\n', ["line 9", "and force_N"],
        "make each",
    ),
    "contact unsupported": (
        TWO + '[[contacts]]\nsecondary = "a"\nprimary = "b"\n', ["body 'a' in contact without supports"], "push_N",
    ),
    "contact with itself": (
        TWO + '[[supports]]\nbody = "a"\nedges = "top"\n[[contacts]]\nsecondary = "a"\nprimary = "a"\n',
        ["line 12", "with itself"], "two parts",
    ),
    "motion without contact": (TWO + '[[motions]]\nbody = "a"\n', ["line 10", "in no contact"], "x_mm"),
    "bytes": ("\0", ["not TOML"], "correct the place"),
    "deep": ("a = " + "[" * 5000, ["not TOML"], "correct the place"),
    "long number": ('case = "hertz"\nradius_mm = ' + "9" * 5000, ["not TOML"], "correct the place"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "told", "advice"), WRONG.values(), ids=WRONG)
def test_a_mistake_is_told_with_file_line_key_and_what_to_do(tmp_path, text, told, advice):
    """Every mistake is refused by one error that names the file, the line where there is one, and what to do."""
    path = file_of(tmp_path, text)
    with pytest.raises(InputError) as caught:
        check_case(load_case(path), path)
    message = str(caught.value)
    assert str(path) in caught.value.given
    for words in told:
        assert words in message
    assert advice in caught.value.advice
    assert len(message) < 4000


def test_a_missing_or_unreadable_file_is_refused(tmp_path):
    """A file that is not there, a folder, and bytes that are no text are refused with what to do."""
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "latin.toml").write_bytes(b'case = "\xe9"')
    for name, word in (("none.toml", "No such file"), ("folder.toml", "directory"), ("latin.toml", "no text")):
        with pytest.raises(InputError, match=word):
            load_case(tmp_path / name)


def test_wrong_settings_are_told_without_a_line(tmp_path):
    """A mistake in a setting names the setting, not a line of the file."""
    path = file_of(tmp_path, 'case = "hertz"\nradius_mm = 3.0\n')
    with pytest.raises(InputError) as caught:
        read_case(path, {"radius_mm": "-3"})
    assert "line" not in caught.value.given
    two = file_of(tmp_path, TWO, "two.toml")
    for name in ("bodies.c.poisson", "bodies.3.poisson", "bodies.1", "steps.a.b"):
        with pytest.raises(InputError, match=f"--set {name}"):
            read_case(two, {name: "1"})


def test_older_and_missing_formats_are_read(tmp_path):
    """The key of the format may be left out."""
    with_key = load_case(file_of(tmp_path, f'flangeway = {FORMAT}\ncase = "cook"\n'))
    assert with_key == load_case(file_of(tmp_path, 'case = "cook"\n')) == load_case("cook")


def test_the_schema_has_every_key_with_its_range():
    """The JSON Schema lists all cases, refuses other keys, and has descriptions and bounds of the inputs."""
    found = json.loads(json.dumps(schema()))
    by_name = {each["properties"]["case"]["const"]: each for each in found["oneOf"]}
    assert set(by_name) == set(CASES)
    for name, case in CASES.items():
        assert set(by_name[name]["properties"]) == {"flangeway", "case", *case.model_fields}
        assert by_name[name]["additionalProperties"] is False
        assert all("description" in value for value in by_name[name]["properties"].values())
    assert by_name["cook"]["properties"]["level"]["maximum"] == 6
    assert by_name["hertz"]["properties"]["radius_mm"]["exclusiveMinimum"] == 0.0
    assert by_name["two-bodies"]["required"] == ["case", "bodies"]
    assert found["$defs"]["BodyTable"]["additionalProperties"] is False
    references = {word for word in json.dumps(found).split('"') if word.startswith("#/$defs/")}
    assert {word.removeprefix("#/$defs/") for word in references} <= set(found["$defs"])


def test_every_unit_is_in_its_name():
    """Inputs that are lengths, forces, stresses or angles bear their unit; the rest has none."""
    without = {
        *("cant", "poisson", "growth", "penalty_factor", "size_scale", "size", "lower_poisson", "wheel_poisson"),
        *("rail_poisson", "hold"),
    }
    units = ("_mm", "_MPa", "_N", "_kN", "_rad", "_deg", "_in", "_m", "_t", "_km_h", "_MPa_mm", "_N_mm3")
    for case in CASES.values():
        for _, rows in case.tables_of_inputs():
            for key, _, allowed, _ in rows:
                if "a number" in allowed and "table" not in allowed:
                    assert key in without or key.endswith(units), key


PLAIN = st.one_of(st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.dates())
TABLES = st.dictionaries(st.text(max_size=5), PLAIN, max_size=3)
VALUES = st.recursive(PLAIN | TABLES, lambda inner: st.lists(inner, max_size=3), max_leaves=6)
KEYS = st.sampled_from(sorted({key for case in CASES.values() for key in case.model_fields})) | st.text(max_size=6)


@settings(deadline=timedelta(seconds=5), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.sampled_from(sorted(CASES)), values=st.dictionaries(KEYS, VALUES, max_size=4))
def test_any_values_give_a_case_or_an_input_error(name, values):
    """Whatever stands in a file, the checker ends with a case or with an error for the user."""
    case, refused = None, None
    try:
        case = CASES[name].from_values(values)
    except InputError as error:
        refused = error
    assert refused.advice if case is None else case.name == name


@settings(deadline=timedelta(seconds=5), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=st.text(alphabet=st.characters(codec="utf-8"), max_size=60), name=st.sampled_from(sorted(CASES)))
def test_any_text_gives_a_case_or_an_input_error(tmp_path, text, name):
    """Any text below the name of a case is read or refused with an error for the user."""
    path = file_of(tmp_path, f'case = "{name}"\n{text}')
    case, refused = None, None
    try:
        case = load_case(path)
    except InputError as error:
        refused = error
    assert str(path) in refused.given if case is None else case.name == name


def test_values_are_written_as_toml_reads_them():
    """What a template writes is read back as the same value."""
    for value in (True, 3, -2.5, 1e-7, 'with "quotes" and \\', [1.0, [2.0, "x"]], {"a": 1, "b": [1.5]}):
        assert tomllib.loads(f"value = {toml_value(value)}")["value"] == value
    with pytest.raises(ValueError, match="no number"):
        toml_value(float("nan"))


def test_the_old_way_stays():
    """Cases by name, without a file, are what they were."""
    assert load_case("wheelset-tangent", method="vem") == WheelsetTangentCase.from_values({"method": "vem"})
