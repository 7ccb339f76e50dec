"""Reports in US units: every number of tables, pictures, CSV files and the viewer is the metric one in its unit."""

import csv
import re
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from matplotlib.text import Text
from matplotlib.ticker import NullLocator

from flangeway.cases import load_case
from flangeway.cases.profile_run import run_profile
from flangeway.cases.rigid_run import find_geometry_case, run_geometry
from flangeway.railway.profiles.bundled import wheel
from flangeway.railway.profiles.formats.two_column import write_two_column
from flangeway.report.case_outputs import case_record
from flangeway.report.figures.drawing import colour_bar, name_axes, new_figure, shade_of
from flangeway.report.page.record import METRIC_FILES
from flangeway.report.profile_outputs import profile_record
from flangeway.report.rigid_outputs import geometry_record
from flangeway.results import ResultTable
from flangeway.units import us_key, us_unit

INPUTS = {
    "wheelset": {
        "rolling": {"friction": 0.3, "theory": "fastsim"},
        "load": {"curve": {"radius_m": 600.0, "speed_km_h": 50.0}},
        "mesh": {"size_scale": 6.0, "order": 1},
        "contact": {"patch_cells": 10},
        "track": {"support": "continuous"},
        "wheelset": {"axle": "rigid"},
    },
    "wheelset-tangent": {
        "axle_load_kN": 350.0,
        "superelevation_mm": -20.0,
        "size_scale": 8.0,
        "penalty_factor": 0.3,
    },
    "stack": {},
    "shrink-fit": {},
    "profile": {},
    "crane-wheel": {"order": 1},
    "rolling-patch": {"cells_along": 10, "cells_across": 10, "curve_points": 3},
    "torsion": {"size": 40.0, "order": 1},
    "geometry": {"step_mm": 0.5, "maximum_lateral_mm": 4.0, "maximum_amplitude_mm": 3.5},
}
NUMBER = re.compile(r"[-+−]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")
STANDARD = "at 3 mm"  # the amplitude of EN 15302
METRIC = re.compile(r"\d (?:mm|kN|N|MPa|m|km/h|kNm|Nm)\b|[, ](?:mm|kN|MPa|kNm)[²³⁴]?$")


def geometry(units):
    return geometry_record(run_geometry("a pair", find_geometry_case("s1002-60e1", INPUTS["geometry"] | units)), "")


@pytest.fixture(scope="module", params=INPUTS)
def records(request, tmp_path_factory):
    """Records of one run in both systems of units."""
    if request.param == "geometry":
        return geometry({}), geometry({"units": "us"})
    if request.param == "profile":
        file = tmp_path_factory.mktemp("profile") / "noisy.txt"
        points = wheel("S1002").running_surface.sampled(spacing=0.25)
        noise = np.random.default_rng(1).normal(scale=0.03, size=points.shape)
        file.write_text(write_two_column(points + noise + [0.0, 1.5], "wheel", "noisy", 65.0), encoding="utf-8")
        run = run_profile(str(file))
        return profile_record(run, ""), profile_record(run, "", "us")
    run = load_case(request.param, **INPUTS[request.param]).run()
    return case_record(run), case_record(replace(run, case=run.case.model_copy(update={"units": "us"})))


def rounding(text):
    """Half a unit of the last digit of a number in a text."""
    return float(Decimal(5).scaleb(Decimal(text.replace(",", "").replace("−", "-")).as_tuple().exponent - 1))


def compared(metric, us, unit):
    """Compare the numbers of two texts, and return how many there are."""
    factor = float(unit.metric) if unit else 1.0
    numbers = [*zip(NUMBER.findall(metric), NUMBER.findall(us), strict=True)]
    for one, other in numbers:
        values = [float(text.replace(",", "").replace("−", "-")) for text in (one, other)]
        assert values[0] == pytest.approx(factor * values[1], abs=1.01 * (rounding(one) + factor * rounding(other)))
    return len(numbers)


def unit_of(label):
    """Unit in the US of the numbers behind a label such as "force, kN", or of a key."""
    return us_unit(label.rpartition(", ")[2]) or us_key(label)


def test_tables_and_tiles(records):
    """Numbers are within rounding, and their labels and units are those in the US."""
    metric, us = records
    tables = [
        (a, b)
        for chapter in metric.chapters
        for a, b in zip(metric.chapters[chapter], us.chapters[chapter], strict=True)
    ]
    tables += [(metric.results, us.results), *zip(metric.tables, us.tables, strict=True)]
    n = 0
    for one, other in [*tables, *zip(metric.inputs, us.inputs, strict=True)]:
        columns = [unit_of(name) for name in one.header]
        for row, converted in zip(one.rows, other.rows, strict=True):
            unit = unit_of(row[0].strip())
            assert converted[0].rpartition(", ")[2] == (
                unit.name if unit and us_unit(row[0].rpartition(", ")[2]) else converted[0].rpartition(", ")[2]
            )
            for place, cells in enumerate(zip(row[1:], converted[1:], strict=True), 1):
                own = cells[0].partition(" ")[2] if re.fullmatch(rf"{NUMBER.pattern} \S+", cells[0]) else ""
                # the last column of inputs has their meanings
                if (not one.of_words or unit) and one.header[place] != "meaning":
                    n += compared(*cells, us_unit(own) or unit or columns[place])
    pairs = [(text, other) for (text, _), (other, _) in zip(metric.facts, us.facts, strict=True)]
    for text, converted in [*pairs, *zip(metric.given.values(), us.given.values(), strict=True)]:
        value, _, words = text.rpartition(" ")
        n += compared(value, converted.rpartition(" ")[0], us_unit(words)) if value else 0
    assert n > 10
    labels = [*us.given.values(), *(row[0] for _, other in tables for row in other.rows)]
    assert not [text for text in labels if METRIC.search(text) and STANDARD not in text]


def sentences_of(record):
    """All that a record says in sentences."""
    notes = record.scene().in_units(record.units).notes if record.scene else ()
    said = [record.title, record.subtitle, record.message, *record.warnings, *record.notes]
    return [*said, *(text for text in record.assumptions if text != METRIC_FILES), *notes]


def test_sentences(records):
    """Titles, messages, warnings, notes and assumptions are the same, with their metric numbers."""
    metric, us = map(sentences_of, records)
    assert us == metric
    assert METRIC.search(" ".join(us))


@pytest.mark.ci
def test_pictures(records):
    """Data is the same, every tick of an axis with a unit is at its number, and no text has a metric unit."""
    for one, other in zip(*(record.pictures() for record in records), strict=True):
        metric, us = one.draw(), other.draw()
        us.draw_without_rendering()
        assert not [text.get_text() for text in us.findobj(Text) if METRIC.search(text.get_text())]
        for axes, converted in zip(metric.axes, us.axes, strict=True):
            for line, same in zip(axes.lines, converted.lines, strict=True):
                np.testing.assert_array_equal(line.get_xydata(), same.get_xydata())
            for axis, now in ((axes.xaxis, converted.xaxis), (axes.yaxis, converted.yaxis)):
                unit = unit_of(axis.get_label_text())
                if unit is None or axis.get_scale() != "linear" or isinstance(now.get_major_locator(), NullLocator):
                    continue
                assert now.get_label_text().endswith(f", {unit.name}")
                numbers = [text.get_text().replace("−", "-") for text in now.get_ticklabels()]
                shown = [(place, text) for place, text in zip(now.get_majorticklocs(), numbers, strict=True) if text]
                places = [place / float(unit.metric) for place, _ in shown]
                np.testing.assert_allclose(places, [float(text) for _, text in shown], atol=1e-6)


def test_csv_files(records, tmp_path):
    """Every column has the name and the numbers of its unit; words are the same."""
    for name in [name for name in records[0].files() if name.endswith(".csv")]:
        tables = []
        for number, record in enumerate(records):
            record.files()[name](tmp_path / f"{number}.csv")
            tables.append([*csv.reader((tmp_path / f"{number}.csv").read_text(encoding="utf-8").splitlines())])
        (header, *rows), (converted, *others) = tables
        units = [us_key(column) for column in header]
        assert converted == [unit.name if unit else column for unit, column in zip(units, header, strict=True)]
        for row, other in zip(rows, others, strict=True):
            for cell, now, unit in zip(row, other, units, strict=True):
                if unit is None or not cell:
                    assert cell == now
                else:
                    assert float(now) == pytest.approx(float(cell) / float(unit.metric), rel=2e-5, abs=1e-12)


def test_viewer(records):
    """Points and arrays are those of the metric scene in the units of lengths and of fields."""
    if records[0].scene is None:
        return
    metric, us = (record.scene().in_units(record.units) for record in records)
    length = float(us_unit(metric.unit).metric)
    assert us.unit == us_unit(metric.unit).name
    for field, now in zip(metric.fields, us.fields, strict=True):
        unit = us_unit(field.unit)
        assert now.unit == (unit.name if unit else field.unit)
        for part, converted in zip(metric.parts, us.parts, strict=True):
            np.testing.assert_allclose(length * converted.mesh.points, part.mesh.points, rtol=1e-12)
            for arrays, others in (
                (part.point_arrays, converted.point_arrays),
                (part.cell_arrays, converted.cell_arrays),
            ):
                if field.array in arrays:
                    factor = float(unit.metric) if unit else 1.0
                    np.testing.assert_allclose(factor * others[field.array], arrays[field.array], rtol=1e-12)


def test_an_axis_in_inches_has_ticks_at_whole_inches():
    """An axis in mm has ticks at whole inches in their places, a bar of colours at ksi; what has no unit stays."""
    figure = new_figure(8.0, 4.0, "us")
    axes = figure.subplots()
    axes.plot([0.0, 101.6], [0.0, 5.0])
    name_axes(axes, ("x", "mm"), ("creepage", "%"))
    bar = colour_bar(shade_of(np.array([0.0, 100.0])), axes, "stress", "MPa")
    figure.draw_without_rendering()
    for axis, factor in ((axes.xaxis, 25.4), (bar.ax.yaxis, 6.894757293168361)):
        numbers = [float(text.get_text()) for text in axis.get_ticklabels()]
        np.testing.assert_allclose(axis.get_majorticklocs(), factor * np.array(numbers), atol=1e-9)
    assert (axes.get_xlabel(), axes.get_ylabel(), bar.ax.get_ylabel()) == ("x, in", "creepage, %", "stress, ksi")


def test_one_column_of_a_quantity_is_left():
    """An input that was given in US units is the column of the metric one; words and missing numbers stay."""
    table = ResultTable({"lateral_in": [0.1], "lateral_mm": [2.54], "force_N": [None], "rail": ["a 10 mm.csv"]})
    assert table.in_units("us").columns == {
        "lateral_in": [pytest.approx(0.1)],
        "force_lbf": [None],
        "rail": ["a 10 mm.csv"],
    }
