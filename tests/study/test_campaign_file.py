"""Campaign files: what they vary, and what is told about wrong ones before anything is computed."""

import pytest

from flangeway.errors import InputError
from flangeway.railway.profiles import rail
from flangeway.study.campaign import Campaign


def read(folder, text, **files):
    for name, content in files.items():
        (folder / name.replace("_", ".")).write_text(content, encoding="utf-8")
    (folder / "c.toml").write_text(text, encoding="utf-8")
    return Campaign.from_file(folder / "c.toml")


def test_a_grid_has_all_combinations_in_the_order_written(tmp_path):
    """Lists and ranges give all combinations, the last key fastest; fixed inputs reach every row; ranges are round."""
    campaign = read(
        tmp_path,
        'case = "wheelset-tangent"\n[inputs]\nrail = "60E1"\n[vary]\nlateral_mm = { from = -0.3, to = 0.3, n = 7 }\n'
        "axle_load_kN = [100, 150]\n",
    )
    assert campaign.keys == ("lateral_mm", "axle_load_kN")
    varied = [(row.varied["lateral_mm"], row.varied["axle_load_kN"]) for row in campaign.rows]
    assert varied == [(x, load) for x in (-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3) for load in (100, 150)]
    assert {row.case.rail for row in campaign.rows} == {"60E1"}
    assert [row.case.axle_load_kN for row in campaign.rows[:2]] == [100.0, 150.0]
    assert [row.number for row in campaign.rows] == list(range(1, 15))


def test_a_range_by_step_ends_at_its_end(tmp_path):
    """A step gives the same values as the number that leads to the same end."""
    text = 'case = "wheelset-tangent"\n[vary]\nlateral_mm = {{ from = 2, to = -1, {} }}\n'
    by_step = read(tmp_path, text.format("step = -0.5"))
    by_number = read(tmp_path, text.format("n = 7"))
    assert by_step.identity == by_number.identity
    assert by_step.rows[-1].varied["lateral_mm"] == -1.0


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_gives_a_row_each_and_is_combined_with_lists(tmp_path, separator):
    """Lines of a CSV table are rows, each with all values of the lists; it may be named in the last table as well."""
    table = "lateral_mm,rail\n-1.5,136RE\n\n2,60E1\n".replace(",", separator)
    campaign = read(
        tmp_path, 'case = "wheelset-tangent"\n[vary]\ncant = [0.025, 0.05]\ntable = "rows.csv"\n', rows_csv=table
    )
    assert campaign.keys == ("lateral_mm", "rail", "cant")
    assert [tuple(row.varied.values()) for row in campaign.rows] == [
        (-1.5, "136RE", 0.025), (-1.5, "136RE", 0.05), (2, "60E1", 0.025), (2, "60E1", 0.05),
    ]  # fmt: skip
    above = read(tmp_path, 'case = "wheelset-tangent"\ntable = "rows.csv"\n[vary]\ncant = [0.025, 0.05]\n')
    assert above.identity == campaign.identity


def test_a_case_file_is_a_base_and_inputs_inside_its_tables_vary(tmp_path):
    """A case file gives inputs; those of a body vary by its name; profiles are found beside the campaign's file."""
    base = 'case = "wheelset-tangent"\ngauge_mm = 1602\naxle_load_kN = 120\n'
    campaign = read(tmp_path, 'case = "base.toml"\n[vary]\nlateral_mm = [0, 1]\n', base_toml=base)
    assert [row.case.gauge_mm for row in campaign.rows] == [1602.0, 1602.0]
    bodies = """
case = "two-bodies"
[[bodies]]
name = "plate"
rectangle = { width_mm = 20.0, height_mm = 10.0 }
size_mm = 5.0
[[supports]]
body = "plate"
edges = "left"
[[loads]]
body = "plate"
edges = "right"
traction_MPa = [1.0, 0.0]
"""
    text = 'case = "bodies.toml"\n[vary]\nbodies.plate.size_mm = [5.0, 4.0]\n'
    campaign = read(tmp_path, text, bodies_toml=bodies)
    assert [row.case.bodies[0].size_mm for row in campaign.rows] == [5.0, 4.0]


def test_what_is_computed_together_depends_on_the_campaign_alone(tmp_path):
    """Positions of the same bodies form chunks of 12 to 48; other rows are alone; equal inputs are one identity."""
    head = 'case = "wheelset-tangent"\n[vary]\n'
    many = read(tmp_path, head + "lateral_mm = { from = -1, to = 1, n = 386 }\ncant = [0.025, 0.05]\n")
    assert [len(rows) for _, rows in many.chunks] == [48] * 8 + [2] + [48] * 8 + [2]
    assert [first.number for first, _ in many.chunks] == [1] * 9 + [2] * 9
    some = read(tmp_path, head + "lateral_mm = { from = -1, to = 1, n = 20 }\n")
    assert [len(rows) for _, rows in some.chunks] == [12, 8]
    few = read(tmp_path, head + "lateral_mm = [0, 1]\naxle_load_kN = [100, 200]\n")
    assert [(first, len(rows)) for first, rows in few.chunks] == [(None, 1)] * 4
    again = read(tmp_path, "# the same\n" + head + "lateral_mm = [0.0, 1.0]\naxle_load_kN = [100.0, 200.0]\n")
    assert again.identity == few.identity
    other = read(tmp_path, head + "lateral_mm = [0, 1]\naxle_load_kN = [100, 201]\n")
    assert other.identity != few.identity


def test_a_file_counts_by_what_is_in_it(tmp_path):
    """A profile in a file may be moved; another content makes another row."""
    text = 'case = "wheelset-tangent"\n[inputs]\nrail = "{}"\n[vary]\nlateral_mm = [0, 1]\n'
    profile = rail("60E1")
    head = profile.outline.part(profile.head_names).sampled(spacing=0.5) - [0.0, 172.0]
    lines = "\n".join(f"{x:.4f} {y:.4f}" for x, y in head)
    (tmp_path / "sub").mkdir()
    for name in ("a.txt", "sub/a.txt"):
        (tmp_path / name).write_text(lines)
    identities = [read(tmp_path, text.format(name)).identity for name in ("a.txt", "sub/a.txt")]
    assert identities[0] == identities[1]
    (tmp_path / "a.txt").write_text("\n".join(f"{x:.4f} {y - 0.01 * (abs(x) < 5):.4f}" for x, y in head))
    assert read(tmp_path, text.format("a.txt")).identity != identities[0]


TOP = 'case = "wheelset-tangent"\n'
WRONG = {
    "no file": (None, "c.toml", "correct the name"),
    "no TOML": ("case = \n", "not TOML", "correct the place"),
    "no case": ("[vary]\ncant = [0, 0.1]\n", "no key case", "flangeway cases"),
    "unknown case": ('case = "wheelset-tangnt"\n[vary]\ncant = [0, 0.1]\n', "line 1", "did you mean wheelset-tangent?"),
    "unknown key": (TOP + 'tabel = "x.csv"\n', "line 2: tabel", "did you mean table?"),
    "an input at the top": (TOP + "gauge_mm = 1435\n[vary]\ncant = [0, 0.1]\n", "gauge_mm", "[inputs] or [vary]"),
    "nothing varies": (TOP + "[inputs]\ncant = 0.1\n", "nothing varies", "add one"),
    "unknown input": (TOP + "[inputs]\ngage_mm = 1435\n[vary]\ncant = [0, 0.1]\n", "line 3", "did you mean gauge_mm?"),
    "unknown varied": (TOP + "[vary]\ngage_mm = [1435, 1436]\n", "line 3: row 1: ", "did you mean gauge_mm?"),
    "out of range": (TOP + "[vary]\ncant = [0, 0.1, 0.5]\n", "line 3: row 3: cant = 0.5", "leave cant out"),
    "wrong combination": (TOP + "[vary]\nspeed_km_h = [50, 70]\n", "row 1 (speed_km_h = 50)", "give the other one"),
    "a load that is wrong in the last row": (
        TOP + "[vary]\nsuperelevation_mm = [0, 30, 3000]\n", "row 3 (superelevation_mm = 3000)", "3 cm is 30",
    ),
    "unknown profile": (TOP + '[vary]\nrail = ["136RE", "60E2"]\n', "row 2 (rail = '60E2')", ""),
    "missing profile": (TOP + '[vary]\nrail = ["136RE", "worn.csv"]\n', "worn.csv", "copy the file"),
    "one value": (TOP + "[vary]\ncant = 0.1\n", "vary.cant = 0.1", "[inputs]"),
    "no value": (TOP + "[vary]\ncant = []\n", "vary.cant = []", "leave the key out"),
    "a value twice": (TOP + "[vary]\ncant = [0.1, 0.1]\n", "0.1 twice", "leave one out"),
    "fixed and varied": (TOP + "[inputs]\ncant = 0.1\n[vary]\ncant = [0, 0.1]\n", "line 5: cant", "remove one"),
    "range without end": (TOP + "[vary]\ncant = { from = 0, n = 3 }\n", "vary.cant", "has 141 values"),
    "range of one": (TOP + "[vary]\ncant = { from = 0, to = 0.1, n = 1 }\n", "vary.cant.n = 1", "another"),
    "range with a wrong key": (TOP + "[vary]\ncant = { from = 0, to = 1, stp = 3 }\n", "cant.stp", "mean step?"),
    "range of text": (TOP + '[vary]\ncant = { from = "0", to = 1, n = 3 }\n', "cant.from = '0'", "quotation"),
    "a step that misses": (TOP + "[vary]\ncant = { from = 0, to = 0.1, step = 0.03 }\n", "step = 0.03", "give n"),
    "too many rows": (
        TOP + "[vary]\ncant = { from = 0, to = 0.1, n = 2000 }\ngauge_mm = { from = 1430, to = 1440, n = 2000 }\n",
        "4000000 rows", "several campaigns",
    ),
    "no such table": (TOP + 'table = "x.csv"\n', "x.csv", "correct the path"),
    "an empty table": (TOP + 'table = "empty.csv"\n', "with 1 lines", "add rows"),
    "a short line": (TOP + 'table = "short.csv"\n', "short.csv, line 3: 1 cells", "complete the line"),
    "an empty cell": (TOP + 'table = "gap.csv"\n', "gap.csv, line 2: an empty cell", "complete the line"),
    "a column twice": (TOP + 'table = "twice.csv"\n', "the column cant twice", "first line"),
    "a row twice": (TOP + 'table = "same.csv"\n', "rows 1 and 3 with the same inputs", "leave one"),
    "a wrong cell": (TOP + 'table = "wrong.csv"\n', "table: row 2: cant = '9'", "leave cant out"),
    "in both": (TOP + 'table = "same.csv"\n[vary]\ncant = [0, 0.1]\n', "cant under [vary] and in", "remove one"),
    "unknown results": (TOP + "[vary]\ncant = [0, 0.1]\n[results]\nrows = []\n", "results.rows", "choose one"),
    "unknown column": (
        TOP + '[vary]\ncant = [0, 0.1]\n[results]\ncolumns = ["left_max_presure_MPa"]\n', "left_max_presure_MPa",
        "did you mean left_max_pressure_MPa?",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "given", "advice"), WRONG.values(), ids=WRONG)
def test_wrong_files_are_told_in_three_parts(tmp_path, text, given, advice):
    """A wrong file: the message names file and place, what is allowed, and what to do."""
    tables = {
        "empty_csv": "cant\n", "short_csv": "cant,gauge_mm\n0,1435\n0.1\n", "gap_csv": "cant,gauge_mm\n0,\n",
        "twice_csv": "cant,cant\n0,1\n", "same_csv": "cant\n0.0\n0.1\n0\n", "wrong_csv": "cant\n0\n9\n",
    }  # fmt: skip
    if text is not None:
        (tmp_path / "c.toml").write_text(text, encoding="utf-8")
    for name, content in tables.items():
        (tmp_path / name.replace("_", ".")).write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        Campaign.from_file(tmp_path / "c.toml")
    assert given in caught.value.given
    assert str(tmp_path) in caught.value.given or "campaign c" in caught.value.given
    assert caught.value.allowed
    assert advice in caught.value.advice
