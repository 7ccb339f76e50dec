"""Campaign files: what they vary, and what is reported about wrong ones before anything is computed."""

import re
from pathlib import Path

import pytest

from flangeway import campaign
from flangeway.campaign import Campaign
from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import rail


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
    assert {row.case.track.rail for row in campaign.rows} == {"60E1"}
    assert [row.case.load.axle_load_kN for row in campaign.rows[:2]] == [100.0, 150.0]
    assert [row.number for row in campaign.rows] == list(range(1, 15))


def test_a_range_by_step_ends_at_its_end(tmp_path):
    """A step gives the same values as the number that leads to the same end."""
    text = 'case = "wheelset-tangent"\n[vary]\nposition.lateral_mm = {{ from = 2, to = -1, {} }}\n'
    by_step = read(tmp_path, text.format("step = -0.5"))
    by_number = read(tmp_path, text.format("n = 7"))
    assert by_step.identity == by_number.identity
    assert by_step.rows[-1].varied["position.lateral_mm"] == -1.0


@pytest.mark.parametrize("separator", [",", ";"])
def test_a_table_gives_a_row_each_and_is_combined_with_lists(tmp_path, separator):
    """Lines of a CSV table are rows, each with all values of the lists; it may be named in the last table as well."""
    table = "lateral_mm,track.rail\n-1.5,136RE\n\n2,60E1\n".replace(",", separator)
    campaign = read(
        tmp_path,
        'case = "wheelset-tangent"\n[vary]\ninclination = [0.025, 0.05]\ntable = "rows.csv"\n',
        rows_csv=table,
    )
    assert campaign.keys == ("lateral_mm", "track.rail", "inclination")
    assert [tuple(row.varied.values()) for row in campaign.rows] == [
        (-1.5, "136RE", 0.025), (-1.5, "136RE", 0.05), (2, "60E1", 0.025), (2, "60E1", 0.05),
    ]  # fmt: skip
    above = read(tmp_path, 'case = "wheelset-tangent"\ntable = "rows.csv"\n[vary]\ninclination = [0.025, 0.05]\n')
    assert above.identity == campaign.identity


def test_inputs_in_us_units_vary(tmp_path):
    """Lists and tables may have US units; the rows are those of the same metric inputs, whatever the results' units."""
    text = 'case = "wheelset-tangent"\n[inputs]\n{}\n[vary]\n{}\ntable = "rows.csv"\n'
    metric = read(tmp_path, text.format("gauge_mm = 1435.1", "lateral_mm = [0, 2.54]"), rows_csv="axle_load_kN\n150\n")
    us = read(
        tmp_path,
        text.format('gauge_in = 56.5\nunits = "us"', "lateral_in = [0, 0.1]"),
        rows_csv=f"axle_load_kip\n{150 / 4.4482216152605!r}\n",
    )
    assert us.keys == ("axle_load_kip", "lateral_in")
    assert us.rows[1].varied["axle_load_kip"] == pytest.approx(150 / 4.4482216152605)
    assert [row.case.load.axle_load_kN for row in us.rows] == pytest.approx([150.0, 150.0])
    assert [row.bodies for row in us.rows] == [row.bodies for row in metric.rows]


def test_a_case_file_is_a_base_and_inputs_inside_its_tables_vary(tmp_path):
    """A case file gives inputs; those of a body vary by its name; profiles are found beside the campaign's file."""
    base = 'case = "wheelset"\n[track]\ngauge_mm = 1602\n[load]\naxle_load_kN = 120\n'
    campaign = read(tmp_path, 'case = "base.toml"\n[vary]\nlateral_mm = [0, 1]\n', base_toml=base)
    assert [row.case.track.gauge_mm for row in campaign.rows] == [1602.0, 1602.0]
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
    many = read(tmp_path, head + "lateral_mm = { from = -1, to = 1, n = 386 }\ninclination = [0.025, 0.05]\n")
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
    head = profile.outline.part(profile.running_names).sampled(spacing=0.5) - [0.0, 172.0]
    lines = "\n".join(f"{x:.4f} {y:.4f}" for x, y in head)
    (tmp_path / "sub").mkdir()
    for name in ("a.txt", "sub/a.txt"):
        (tmp_path / name).write_text(lines)
    identities = [read(tmp_path, text.format(name)).identity for name in ("a.txt", "sub/a.txt")]
    assert identities[0] == identities[1]
    (tmp_path / "a.txt").write_text("\n".join(f"{x:.4f} {y - 0.01 * (abs(x) < 5):.4f}" for x, y in head))
    assert read(tmp_path, text.format("a.txt")).identity != identities[0]


def test_each_row_of_the_same_bodies_is_checked_before_anything_is_computed(tmp_path):
    """Friction of a later row that is below the kinetic coefficient is refused with its row, when the file is read."""
    text = 'case = "wheelset"\n[inputs]\nrolling.speed_km_h = 80.0\nrolling.falling.kinetic = 0.2\n[vary]\n'
    read(tmp_path, text + "rolling.friction = [0.3, 0.25]\n")
    with pytest.raises(InputError, match=r"row 2 \(rolling\.friction = 0\.1\): rolling\.falling\.kinetic: "):
        read(tmp_path, text + "rolling.friction = [0.3, 0.1]\n")


def test_campaigns_know_no_kind_of_case():
    """They ask a case for its columns, bodies and positions: no module of theirs imports a kind of case.

    A damage file is none: its combinations are strategies.
    """
    modules = [*Path(campaign.__file__).parent.glob("*.py")]
    imported = {name for module in modules for name in re.findall(r"flangeway\.cases\.(\w+)", module.read_text())}
    assert modules
    assert imported == {"case", "case_file", "damage_file", "summary"}
