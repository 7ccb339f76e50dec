"""Printed reports: on A4 and Letter every number of the page is there, inside of the paper and not on another one."""

import re
import shutil
import subprocess
from collections import Counter

import numpy as np
import pytest

from flangeway.cases.case_file import CASES, write_template
from flangeway.cases.wheelset.wheelset_quantities import SPATIAL_FURTHER, SPATIAL_MAIN
from flangeway.report.page.html_page import report_page
from flangeway.report.page.record import Again, Report, SummaryTable

NUMBER = re.compile(r"[-+]?\d[\d.,]*(?:e[-+]?\d+)?")
SHOWN = """[...document.querySelectorAll('header, main section:not([aria-labelledby=fields]), footer')]
    .map(part => part.innerText).join('\\n')"""
BOXES = """[...document.querySelectorAll('td, th, .facts li, .given div')].filter(cell => cell.checkVisibility())
    .map(cell => { const box = cell.getBoundingClientRect(); return [box.left, box.right, box.top, box.bottom]; })"""
PAPER = {"A4": 186.0, "Letter": 191.9}
"""Widths between the margins of 12 mm, mm."""

pytestmark = pytest.mark.skipif(shutil.which("pdftotext") is None, reason="pdftotext is not installed")


def refuse_cut(browser, page_file):
    """Refuse a page of which a printed number is missing, beside the paper, or below another cell."""
    page = browser.new_page(viewport={"width": 1400, "height": 900})
    page.goto(page_file.as_uri())
    folded = "document.querySelectorAll('.tables > details').forEach(each => { each.open = %s; })"
    page.evaluate(folded % "true")
    expected = Counter(NUMBER.findall(page.evaluate(SHOWN)))
    page.evaluate(folded % "false")
    assert len(expected) > 5
    for paper in PAPER:
        pdf = page_file.with_suffix(".pdf")
        page.pdf(path=pdf, format=paper)
        text = subprocess.run(["pdftotext", "-layout", pdf, "-"], capture_output=True, text=True, check=True).stdout
        text = re.sub(r"-\n\s*(?=\d)", "-", text)  # names such as AAR-1B may be broken behind their hyphen
        assert expected - Counter(NUMBER.findall(text)) == Counter()
    page.emulate_media(media="print")
    for width_mm in PAPER.values():
        page.set_viewport_size({"width": int(width_mm * 96.0 / 25.4), "height": 900})
        left, right, top, bottom = np.array(page.evaluate(BOXES)).T
        assert left.min() >= -0.5
        assert right.max() <= page.viewport_size["width"] + 0.5
        across = np.minimum(right[:, None], right) - np.maximum(left[:, None], left)
        down = np.minimum(bottom[:, None], bottom) - np.maximum(top[:, None], top)
        assert np.count_nonzero((across > 1.0) & (down > 1.0)) == len(left)  # each with itself only
    page.close()


@pytest.mark.parametrize("n_patches", range(1, 9))
def test_no_number_of_a_patch_is_cut(browser, tmp_path, n_patches):
    """All numbers of one to eight patches are on the paper, from -99999.9999 to words of ten letters."""
    random = np.random.default_rng(n_patches)
    names = [
        f"{side} {part}" for side in ("left", "right") for part in ("field corner", "crown", "gauge corner", "lip")
    ]

    def table(caption, quantities):
        heads = [label for quantity in quantities for label in quantity.labels() if label]
        digits = random.integers(1, 5, (len(heads), n_patches))
        cells = random.normal(0.0, 3e4, digits.shape)
        rows = [
            (head, *(f"{value:.{digit}f}" for value, digit in zip(*line, strict=True)))
            for head, *line in zip(heads, cells, digits, strict=True)
        ]
        rows.append(("shakedown state", *n_patches * ["ratchetting"]))
        return SummaryTable(caption, ("", *names[:n_patches]), tuple(rows))

    results, further = table("Results", SPATIAL_MAIN), table("Patches", SPATIAL_FURTHER)
    record = Report(
        name="w", title="A wheelset", subtitle="", converged=True, message="", results=results, tables=[further],
        summary={}, again=Again("flangeway run wheelset"),
    )  # fmt: skip
    (tmp_path / "report.html").write_text(report_page(record), encoding="utf-8")
    refuse_cut(browser, tmp_path / "report.html")


DAMAGE = """
[inputs]
size_scale = 8
order = 1
support = "continuous"
axle = "rigid"
patch_cells = 10
friction = 0.3
theory = "fastsim"
curve.speed_km_h = 80
[[states]]
share = 1
curve.radius_m = 1200
[wear.wheel]
kind = "energy"
constant = 0.5
unit = "mm3/kJ"
[evolution]
end = 100
"""
FILES = {
    "bodies.toml": write_template(CASES["two-bodies"]).replace("size_mm = 0.08", "size_mm = 1.0"),
    "spatial.toml": write_template(CASES["spatial"]),
    "sweep.toml": 'case = "wheelset-tangent"\n[inputs]\nsize_scale = 8\n[vary]\nlateral_mm = [-1, 0, 1]\n',
    "line.toml": DAMAGE,
}
ROLLS = {
    "rolling.friction": 0.3,
    "load.curve": "{ radius_m = 500, speed_km_h = 80, superelevation_mm = 60 }",
    "size_scale": 6,
    "order": 1,
    "patch_cells": 10,
    "rolling.theory": "fastsim",
}


@pytest.mark.parametrize(
    "command",
    [
        ("run", "wheelset", *(word for key, value in ROLLS.items() for word in ("--set", f"{key}={value}"))),
        ("run", "wheelset-tangent", "--size-scale", "6"),
        ("run", "wheelset-tangent", "--size-scale", "6", "--units", "us"),
        ("run", "bodies.toml"),
        ("run", "spatial.toml"),
        ("run", "stack"),
        ("run", "rolling-patch"),
        ("section", "60E1"),
        ("profile", "S1002"),
        ("geometry", "s1002-60e1"),
        ("converge", "wheelset-tangent", "--size-scale", "8"),
        ("reproduce", "torsion", "--quick"),
        ("campaign", "sweep.toml", "--workers", "1"),
        ("damage", "line.toml"),
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_no_report_is_cut(browser, tmp_path, call, command):
    """Reports of all kinds have all their numbers on the paper."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    status, _, error = call(*command, "--out", "out", "-q")
    assert status == 0, error
    pages = list((tmp_path / "out").rglob("report.html"))
    assert pages
    for page in pages:
        refuse_cut(browser, page)
