"""What a campaign leaves, plane or in space: rows, tables that can be read back, pictures, an animation."""

import csv
import io
import json
import re
import sqlite3
import struct
from collections import Counter
from concurrent.futures import Future
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flangeway.campaign import Campaign, CampaignProgress, campaign_run, results
from flangeway.campaign.campaign import Row
from flangeway.campaign.campaign_run import Outcome, RowTask, compute
from flangeway.campaign.database import CampaignDatabase, RowResult, export_writers
from flangeway.cases import load_case
from flangeway.errors import InputError
from flangeway.report.campaign_figures import ROUGH, campaign_figures
from flangeway.report.campaign_outputs import campaign_record, write_export
from flangeway.report.page.html_page import write_record
from flangeway.report.page.record import print_record
from flangeway.system.disk_cache import LatestValues
from flangeway.system.output_folder import versions
from tests.campaign.conftest import computed, read

SWEEP = """
case = "wheelset-tangent"
[inputs]
size_scale = 8
[vary]
lateral_mm = { from = -2, to = 2, n = 12 }
"""


def record_of(_campaign, found):
    """What the command shows of a campaign that has ended."""
    counts = dict(Counter(found.rows["status"]))
    end = CampaignProgress(len(found.rows["row"]), counts, None)
    return campaign_record(end, found, "csv", "flangeway campaign c.toml", 1.0)


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """One sweep over the lateral motion, shared by the tests of this file."""
    return computed(tmp_path_factory.mktemp("sweep"), SWEEP)


def test_a_row_is_in_equilibrium_and_its_patches_add_up(sweep):
    """Forces of both wheels carry the load; those of the patches of a side are those of the row; L/V is their ratio."""
    _, found = sweep
    assert set(found.rows["status"]) == {"converged"}
    assert np.allclose(
        found.numbers("left_vertical_force_kN") + found.numbers("right_vertical_force_kN"), 300.0, rtol=1e-6
    )
    sides, rows = np.array(found.patches["side"]), np.array(found.patches["row"])
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for kind in ("normal_force_kN", "lateral_force_kN"):
            forces = np.array(found.patches[kind], dtype=float)
            sums = [forces[(sides == side) & (rows == row)].sum() for row in found.rows["row"]]
            assert found.numbers(f"{side}_{kind}") == pytest.approx(sums)
        ratio = sign * found.numbers(f"{side}_lateral_force_kN") / found.numbers(f"{side}_vertical_force_kN")
        assert found.numbers(f"{side}_lateral_over_vertical") == pytest.approx(ratio)
    # mirrored positions: what is left is right
    left, right = found.numbers("left_max_pressure_MPa"), found.numbers("right_max_pressure_MPa")
    assert left == pytest.approx(right[::-1], rel=0.02)


def test_many_positions_together_are_each_as_computed_alone(sweep, tmp_path):
    """A row computed with others differs little from one alone, whose mesh is fine near its own contact only."""
    campaign, found = sweep
    row = campaign.rows[7]
    alone = compute(RowTask(row)).result
    for name in ("vertical_mm", "left_max_pressure_MPa", "right_rail_position_x_mm", "right_half_width_mm"):
        assert found.rows[name][7] == pytest.approx(alone.values[name], rel=0.08), name
    for name in ("left_vertical_force_kN", "right_vertical_force_kN"):
        assert found.rows[name][7] == pytest.approx(alone.values[name], rel=5e-3), name
    of_segments = [text for text in alone.warnings if "segments wide" in text]
    assert len(of_segments) == 2
    assert [each for each in json.loads(found.rows["warnings"][7]) if "segments wide" in each] == of_segments


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_tables_come_back_as_they_were_written(sweep, tmp_path, kind):
    """Both tables are the same after a way through a file: names, order, every number exactly."""
    campaign, found = sweep
    files = write_export(found, tmp_path, kind)
    assert [file.name for file in files] == [f"results.{kind}", f"patches.{kind}"]
    for file, columns in zip(files, (found.rows, found.patches), strict=True):
        if kind == "csv":
            with file.open(newline="") as lines:
                header, *read = csv.reader(lines)
            assert header == list(columns)
            expected = [
                ["" if cell is None else str(cell) for cell in row] for row in zip(*columns.values(), strict=True)
            ]
            assert read == expected
        else:
            parquet = pytest.importorskip("pyarrow.parquet")
            assert parquet.read_table(file).to_pydict() == columns
    assert list(found.patches) == list(campaign.patch_columns)
    assert set(campaign.known_columns) | {"row", "status", "message", "warnings"} == set(found.rows)


def test_chosen_columns_alone_are_exported_and_the_database_keeps_all(tmp_path):
    """The key results.columns chooses what is exported, in its order."""
    text = 'case = "wheelset-tangent"\n[inputs]\nsize_scale = 8\n[vary]\ninclination = [0.025]\n'
    columns = ["right_max_pressure_MPa", "vertical_mm"]
    _, found = computed(tmp_path, text + f"[results]\ncolumns = {columns}\n")
    assert list(found.rows) == ["row", "status", "inclination", *columns, "message", "warnings"]
    with sqlite3.connect(tmp_path / "c.sqlite") as connection:
        assert json.loads(connection.execute("SELECT result FROM rows").fetchone()[0])["values"][
            "left_rail_position_x_mm"
        ]


def test_other_cases_give_all_single_numbers_of_their_summary(tmp_path):
    """A Hertz case varies like a wheelset; its columns are the numbers of its summary; there is no picture."""
    _, found = computed(tmp_path, 'case = "torsion"\n[inputs]\nsection = "60E1"\nsize = 20\n[vary]\norder = [1, 2]\n')
    assert found.rows["status"] == ["converged", "converged"], found.rows["message"]
    numbers = [name for name in found.rows if "torsion_constant" in name]
    assert numbers
    first, second = found.numbers(numbers[0])
    assert first == pytest.approx(second, rel=0.05)
    assert campaign_figures(found) == {}


@pytest.mark.ci
def test_pictures_are_chosen_by_what_varies(sweep, tmp_path):
    """One input gives curves and the locus."""
    campaign, found = sweep
    files = write_record(record_of(campaign, found), tmp_path)
    names = {file.name for file in files}
    pictures = {"contact-locus.png", "max-pressure.png", "lateral-over-vertical.png", "forces.png"}
    assert names == pictures | {"results.csv", "patches.csv", "report.html", "summary.json"}
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"{found.numbers('left_max_pressure_MPa').max():.5g}" in page
    assert page.count("<img") == len(pictures)
    (axes, *_), offsets = campaign_figures(found)["contact-locus.png"]().axes, found.patches
    drawn = axes.collections[0].get_offsets()
    left = [place for place, side in enumerate(offsets["side"]) if side == "left"]
    assert np.asarray(drawn)[:, 1] == pytest.approx(np.array([offsets["wheel_position_x_mm"][place] for place in left]))


def test_two_inputs_give_a_map_with_each_pressure_in_its_place(tmp_path):
    """A grid of two inputs is drawn as a map whose cells are the rows' pressures."""
    text = 'case = "wheelset-tangent"\n[inputs]\nsize_scale = 8\n[vary]\n'
    text += "lateral_mm = { from = -1, to = 1, n = 2 }\naxle_load_kN = [100, 200]\n"
    _, found = computed(tmp_path, text)
    figure = campaign_figures(found)["max-pressure-map.png"]()
    drawn = figure.axes[0].collections[0].get_array()
    pressures = found.numbers("left_max_pressure_MPa").reshape(2, 2)
    assert np.asarray(drawn).reshape(2, 2) == pytest.approx(pressures.T)


def test_failures_are_grouped_by_reason(tmp_path):
    """A row that fails says why, has no numbers, and is reported at the end with others of the same reason."""
    text = 'case = "wheelset"\n[inputs]\nsize_scale = 8\ncontact = "plane"\n[vary]\nvertical_mm = [-0.5, 30.0, 31.0]\n'
    campaign, found = computed(tmp_path, text)
    assert found.rows["status"][0] == "converged"
    assert "converged" not in found.rows["status"][1:]
    assert found.rows["left_max_pressure_MPa"][1:] == [None, None]
    ((status, message), rows), *others = found.failures().items()
    assert not others
    assert rows == [2, 3]
    from rich.console import Console  # noqa: PLC0415

    said = io.StringIO()
    record = record_of(campaign, found)
    print_record(Console(file=said, width=200), record)
    assert said.getvalue().startswith(f"{found.name}: NOT converged with ")
    assert f"2 {status}: {message}" in said.getvalue()
    assert "rows 2, 3" in said.getvalue()


def test_a_changed_campaign_is_refused_until_it_is_fresh(sweep, tmp_path):
    """Results of another campaign are not mixed: the message says what differs; fresh drops them."""
    for name, values in (("a", "[0, 1]"), ("b", "[0, 2]"), ("c", "[1, 0]")):
        (tmp_path / f"{name}.toml").write_text(f'case = "wheelset-tangent"\n[vary]\nlateral_mm = {values}\n')
    one, other, turned = (Campaign.from_file(tmp_path / f"{name}.toml") for name in "abc")
    database = tmp_path / "x.sqlite"
    with CampaignDatabase(database) as store:
        store.begin(one)
    with CampaignDatabase(database) as store:
        with pytest.raises(InputError, match="1 of 2 rows are not in it, 1 of it are not wanted") as caught:
            store.begin(other)
        assert "--fresh" in caught.value.advice
        with pytest.raises(InputError, match="another order"):
            store.begin(turned)
    with CampaignDatabase(database, fresh=True) as store:
        store.begin(other)
        assert store.waiting() == {1, 2}


def test_another_database_is_neither_used_nor_dropped(tmp_path):
    """A database that is no campaign is refused, fresh or not; one that cannot be read is, unless it is made anew."""
    other, text = tmp_path / "other.sqlite", tmp_path / "text.sqlite"
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE mine (a)")
    connection.close()
    text.write_text("not a database" * 100)
    for path, refused in ((other, (False, True)), (text, (False,))):
        before = path.read_bytes()
        for fresh in refused:
            with pytest.raises(InputError, match=re.escape(str(path))):
                CampaignDatabase(path, fresh=fresh)
        with pytest.raises(InputError, match=re.escape(str(path))):
            results(path)
        assert path.read_bytes() == before
    campaign = tmp_path / "c.toml"
    campaign.write_text('case = "cook"\n[vary]\nbodies.membrane.order = [1]\n', encoding="utf-8")
    with CampaignDatabase(text, fresh=True) as store:
        store.begin(Campaign.from_file(campaign))
        assert store.waiting() == {1}


def test_a_result_is_stored_once(sweep, tmp_path):
    """A row that has a result keeps it, should a second one come."""
    campaign, _ = sweep
    row: Row = campaign.rows[0]
    with CampaignDatabase(tmp_path / "x.sqlite") as store:
        store.begin(campaign)
        result = compute(RowTask(row)).result
        assert result.status == "converged"
        assert store.store(row, result)
        before = results(tmp_path / "x.sqlite")
        assert not store.store(row, result)
    after = results(tmp_path / "x.sqlite")
    assert (after.rows, after.patches) == (before.rows, before.patches)
    assert not after.is_done


def test_a_finished_campaign_prints_its_numbers_as_json_with_an_export(sweep, call, tmp_path):
    """Nothing is computed, the tables are written, and standard output is the JSON of the record."""
    (tmp_path / "c.toml").write_text(SWEEP, encoding="utf-8")
    campaign = Campaign.from_file(tmp_path / "c.toml")
    with CampaignDatabase(tmp_path / "out" / "c" / "campaign.sqlite") as store:
        store.begin(campaign)
        for row in campaign.rows:
            store.store(row, RowResult("converged", "done", values={"lateral_mm": 0.0}))
    status, out, err = call("campaign", "c.toml", "--export", "csv", "--json")
    assert status == 0, err
    assert json.loads(out)["rows"] == len(sweep[0].rows) == 12
    assert (tmp_path / "out" / "c" / "results.csv").is_file()


CAMPAIGN = (
    'case = "torsion"\n[inputs]\nsection = "60E1"\nsize = 20.0\n[vary]\norder = [1, 2]\nmethod = ["fem", "vem"]\n'
)


def exported(database: Path) -> bytes:
    file = database.with_name("results.csv")
    export_writers(results(database), "csv")["results.csv"](file)
    return file.read_bytes()


def change(database: Path, statement: str) -> None:
    with closing(sqlite3.connect(database)) as connection:
        connection.execute(statement)
        connection.commit()


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    computed(folder, CAMPAIGN)
    return folder / "c.sqlite"


def test_nothing_of_the_run_is_in_the_results(database: Path) -> None:
    """No column depends on the machine or on what it computed before."""
    names = list(results(database).rows)
    assert any("torsion_constant" in name for name in names)
    assert not [name for name in names if "memory" in name or "timing" in name or "seconds" in name]


def test_deleted_rows_are_computed_again(database: Path) -> None:
    """A row that was deleted waits, and its result is byte for byte the same."""
    before = exported(database)
    change(database, 'DELETE FROM rows WHERE "row" IN (2, 3)')
    assert exported(database) != before
    computed(database.parent, CAMPAIGN)
    assert exported(database) == before


def test_a_changed_bit_does_not_reach_the_table(database: Path) -> None:
    """Of any bit of a row or a patch that changes in the file, the row is refused, and computed anew to the last byte.

    Bits of numbers, statuses and messages are changed at random.
    """
    before, random = exported(database), np.random.default_rng(3)
    for _ in range(6):
        with closing(sqlite3.connect(database)) as connection:
            row, *cells = connection.execute("SELECT * FROM rows ORDER BY random() LIMIT 1").fetchone()
            names = [name for _, name, *_ in connection.execute("PRAGMA table_info(rows)")][1:]
            given = [(name, cell) for name, cell in zip(names, cells, strict=True) if isinstance(cell, float | str)]
            name, cell = given[random.integers(len(given))]
            if isinstance(cell, float):
                (bits,) = struct.unpack("<Q", struct.pack("<d", cell))
                changed = struct.unpack("<d", struct.pack("<Q", bits ^ (1 << int(random.integers(64)))))[0]
            else:
                at = int(random.integers(len(cell)))
                changed = f"{cell[:at]}{chr(ord(cell[at]) ^ 1)}{cell[at + 1 :]}"
            connection.execute(f'UPDATE rows SET "{name}" = ? WHERE "row" = ?', (changed, row))
            connection.commit()
        with pytest.raises(InputError, match=rf"row {row}\b"):
            results(database)
        computed(database.parent, CAMPAIGN)
        assert exported(database) == before, name


def test_a_changed_patch_is_computed_anew(sweep, tmp_path: Path) -> None:
    """A number of a patch belongs to the checksum of its row."""
    computed(tmp_path, SWEEP.replace("n = 12", "n = 2"))
    before = results(tmp_path / "c.sqlite").patches
    patch = "json_set(result, '$.patches[0].max_pressure_MPa', 1.0)"
    change(tmp_path / "c.sqlite", f'UPDATE rows SET result = {patch} WHERE "row" = 2')
    with pytest.raises(InputError, match="row 2"):
        results(tmp_path / "c.sqlite")
    assert computed(tmp_path, SWEEP.replace("n = 12", "n = 2"))[1].patches == before


def test_an_empty_file_is_a_campaign_that_begins(tmp_path: Path, call) -> None:
    """A database without a byte, as a full disk leaves it, is made anew by the command."""
    (tmp_path / "c.toml").write_text(CAMPAIGN)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "campaign.sqlite").touch()
    status, _, error = call("campaign", "c.toml", "--out", "out", "--workers", "1", "--no-pictures", "-q")
    assert status == 0, error
    assert results(tmp_path / "out" / "campaign.sqlite").is_done


class Here:
    """Workers that are this thread, each work done when it is asked for."""

    n_at_once = 1

    def submit(self, work):
        done = Future()
        done.set_result(campaign_run.compute(work))
        return done

    def result(self, future):
        return future.result()

    def stop(self):
        pass


def test_each_row_is_stored_as_it_ends(monkeypatch, tmp_path: Path) -> None:
    """Of rows with the same bodies each one is in the file before the next one begins, in their order."""
    stored: list[int] = []

    def one(_):
        if (tmp_path / "c.sqlite").is_file():
            stored.append(results(tmp_path / "c.sqlite").rows["status"].count("converged"))
        return Outcome(RowResult("converged", "done"), versions()["flangeway"])

    monkeypatch.setattr(campaign_run, "compute", one)
    monkeypatch.setattr(campaign_run, "LocalWorkers", lambda *_: Here())
    campaign = read(tmp_path, FILE.replace("[-1.0, 1.0]", "{ from = -3, to = 3, n = 13 }"))
    assert max(len(rows) for _, rows in campaign.chunks) > 1
    campaign_run.run_campaign(campaign, tmp_path / "c.sqlite", workers=1)
    assert stored == list(range(26))


FILE = """
case = "wheelset"
[inputs]
mesh.size_scale = 8.0
mesh.order = 1
track.support = "fixed"
contact.patch_cells = 12
[vary]
lateral_mm = [-1.0, 1.0]
yaw_mrad = [0.0, 5.0]
"""


LOADS = ("vertical_force_kN", "longitudinal_creep_force_kN", "frictional_power_W", "t_gamma_N", "share_of_nadal_limit")


@pytest.fixture(scope="module")
def spatial_sweep(tmp_path_factory):
    """Four positions, computed in this process."""
    return computed(tmp_path_factory.mktemp("spatial"), FILE)


def test_rows_carry_the_load_and_have_the_columns_of_both_models(spatial_sweep):
    """Both wheels carry the load; the columns that plane wheelsets have too mean the same; mirrored rows agree."""
    campaign, found = spatial_sweep
    assert set(found.rows["status"]) == {"converged"}, found.rows["message"]
    assert set(campaign.known_columns) <= set(found.rows)
    assert list(found.patches) == list(campaign.patch_columns)
    left, right = (found.numbers(f"{side}_vertical_force_kN") for side in ("left", "right"))
    assert np.allclose(left + right, campaign.rows[0].case.load.axle_load_kN, rtol=1e-7)
    for side in ("left", "right"):
        mine = np.array(found.patches["side"]) == side
        forces = np.array(found.patches["normal_force_kN"])[mine]
        assert np.bincount(np.array(found.patches["row"])[mine], forces)[1:] == pytest.approx(
            found.numbers(f"{side}_normal_force_kN")
        )
    # rows 1 and 3: at -1 and +1 mm without yaw
    for name in ("max_pressure_MPa", "semi_axes_a_mm", "contact_angle_deg", "rolling_radius_mm", "head_vertical_mm"):
        one, other = found.numbers(f"left_{name}")[0], found.numbers(f"right_{name}")[2]
        assert one == pytest.approx(other, rel=1e-6)
    assert found.numbers("left_head_lateral_mm")[0] == pytest.approx(-found.numbers("right_head_lateral_mm")[2])
    # with yaw the right wheel is ahead
    assert (found.numbers("right_longitudinal_position_mm")[1::2] > 1.0).all()


def marked_points(found, name):
    """Rows that a picture of both sides marks as rough: the abscissae of each side."""
    axes = campaign_figures(found)[name]().axes[:2]
    lines = [[line for line in panel.lines if line.get_label() == ROUGH] for panel in axes]
    return [sorted({float(x) for line in of_panel for x in line.get_xdata()}) for of_panel in lines]


@pytest.mark.parametrize("name", ["max-pressure.png", "max-pressure-map.png"])
def test_only_rough_pressures_are_marked(spatial_sweep, sweep, name):
    """Pressures without a remark have no mark; those with one, here invented for two rows, are marked.

    Of both models no remark is None, as any other number that is not there.
    """
    _, found = spatial_sweep
    fine = {**found.rows, **{f"{side}_max_pressure_remark": [None] * 4 for side in ("left", "right")}}
    assert marked_points(replace(found, rows=fine), name) == [[], []]
    fine["left_max_pressure_remark"] = [None, "8 by 5 cells", "9 by 6 cells", None]
    assert marked_points(replace(found, rows=fine), name) == [[-1.0, 1.0], []]
    for table in (found, sweep[1]):
        cells = [cell for column in (*table.rows.values(), *table.patches.values()) for cell in column]
        assert "" not in cells
    assert set(found.rows["left_max_pressure_remark"]) == {None}


def test_rows_that_roll_have_their_creep_forces(tmp_path):
    """Lateral and vertical forces contain creep forces: they carry the load, and no torque is left without one."""
    rolling = 'rolling = { friction = 0.3, speed_km_h = 80, theory = "fastsim" }\n[vary]'
    campaign = read(tmp_path, FILE.partition("lateral_mm =")[0].replace("[vary]", rolling) + "lateral_mm = [2.0]\n")
    first, rows = campaign.chunks[0]
    found = compute(RowTask(rows[0], first)).result
    assert found.status == "converged", found.message
    assert set(campaign.known_columns) == set(found.values)
    assert {"row", *found.patches[0]} == set(campaign.patch_columns)
    left, right = ({name: found.values[f"{side}_{name}"] for name in LOADS} for side in ("left", "right"))
    load = campaign.rows[0].case.load.axle_load_kN
    assert left["vertical_force_kN"] + right["vertical_force_kN"] == pytest.approx(load, rel=1e-7)
    assert left["longitudinal_creep_force_kN"] == pytest.approx(-right["longitudinal_creep_force_kN"], rel=0.05)
    assert abs(left["longitudinal_creep_force_kN"]) > 0.01 * load
    for each in (left, right):
        assert each["frictional_power_W"] == pytest.approx(each["t_gamma_N"] * 80.0 / 3.6)
        assert each["share_of_nadal_limit"] is None or each["share_of_nadal_limit"] < 1.0


@pytest.mark.ci
def test_a_row_is_that_of_a_run_and_does_not_depend_on_the_others(spatial_sweep, monkeypatch):
    """A row computed alone in a worker that prepared nothing has the same bytes; `flangeway run` has its numbers."""
    campaign, found = spatial_sweep
    first, rows = campaign.chunks[0]
    monkeypatch.setattr(campaign_run, "_prepared", LatestValues(1))
    alone = compute(RowTask(rows[2], first)).result
    for name, value in alone.values.items():
        if name not in ("lateral_mm", "yaw_mrad"):
            assert found.rows[name][2] == value
    run = rows[2].case.run()
    assert run.result.equilibrium.position.vertical_mm == pytest.approx(alone.values["vertical_mm"], rel=1e-12)
    assert run.patches[0].max_pressure == pytest.approx(alone.values["left_max_pressure_MPa"], rel=1e-9)
    assert run.wheels[1].head[0] == pytest.approx(alone.values["right_head_lateral_mm"], rel=1e-9)


def test_positions_share_their_bodies_and_plane_rows_are_those_of_plane_wheelsets(tmp_path):
    """Position, yaw and load leave the bodies; sleepers and profiles do not; plane rows are plane wheelsets."""
    text = 'case = "wheelset"\n[vary]\n{} = {}\n'
    rolling = text.replace("[vary]", "[inputs.rolling]\nspeed_km_h = 80\n[vary]")
    assert len(read(tmp_path, rolling.format("rolling.friction", "[0.2, 0.4]")).chunks) == 1
    for key, values in (("lateral_mm", "[0, 1]"), ("yaw_mrad", "[0, 1]"), ("axle_load_kN", "[100, 200]")):
        assert len(read(tmp_path, text.format(key, values)).chunks) == 1
    for key, values in (
        ("section", '["rim", "whole"]'),
        ("support.position", "[0, 0.5]"),
        ("rail", '["60E1", "136RE"]'),
    ):
        assert len(read(tmp_path, text.format(key, values)).chunks) == 2
    both = read(tmp_path, text.format("contact", '["plane", "spatial"]'))
    plane = compute(RowTask(both.rows[0])).result
    assert set(plane.values) == set(load_case("wheelset-tangent").columns())
    assert {"left_half_width_mm", "left_semi_axes_a_mm"} <= set(both.known_columns)


def test_a_position_that_cannot_be_reached_fails_alone(tmp_path):
    """A row beyond the rails reports the reason, in its own row."""
    campaign = read(tmp_path, FILE.replace("[-1.0, 1.0]", "[0.0, 90.0]").replace("[0.0, 5.0]", "[0.0]"))
    ((first, rows),) = campaign.chunks
    good, bad = (compute(RowTask(row, first)).result for row in rows)
    assert (good.status, bad.status) == ("converged", "not converged")
    assert "derail" in bad.message
