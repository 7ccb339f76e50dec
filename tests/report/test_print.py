"""Printed reports on A4 and Letter: every number inside of the paper, pictures in their size, numbered full sheets."""

import io
import re
import shutil
import subprocess
from collections import Counter

import numpy as np
import pytest
from matplotlib.axis import Axis
from matplotlib.text import Text
from PIL import Image

from flangeway.cases.case_file import CASES, write_template
from flangeway.cases.wheelset.wheelset_quantities import SPATIAL_FURTHER, SPATIAL_MAIN
from flangeway.report.figures import drawing
from flangeway.report.figures.drawing import DPI, PAGE_IN, png
from flangeway.report.page.html_page import report_page
from flangeway.report.page.record import Again, Report, SummaryTable

UNREADABLE = re.compile(r"-?\d[\d.]*e\+\d+|-0(\.0*)?%?")
CELLS = "[...document.querySelectorAll('td, .facts .value')].map(cell => cell.textContent.trim())"
NUMBER = re.compile(r"[-+]?\d[\d.,]*(?:e[-+]?\d+)?")
OPENED = "document.querySelectorAll('section > details').forEach(fold => { fold.open = %s; })"
SHOWN = """[...document.querySelectorAll('header, main section:not([aria-labelledby=fields]), footer')]
    .map(part => [...part.querySelectorAll(':scope > details > summary .soft')].reduce(
        (text, inside) => text.replace(inside.innerText, ''), part.innerText)).join('\\n')"""
BOXES = """[...document.querySelectorAll('td, th, .facts li, .given div')].filter(cell => cell.checkVisibility())
    .map(cell => { const box = cell.getBoundingClientRect(); return [box.left, box.right, box.top, box.bottom]; })"""
SCALES = f"""[...document.querySelectorAll('figure img')].map(image => image.width / image.naturalWidth * {DPI} / 96)"""
"""Sizes of pictures relative to those in which they are drawn."""
SCREEN_PX = 900
PAPER = {"A4": 186.0, "Letter": 191.9}
"""Widths between the margins of 12 mm, mm."""

pytestmark = pytest.mark.skipif(shutil.which("pdftotext") is None, reason="pdftotext is not installed")


def refuse_cut(browser, page_file):
    """Refuse a page of which a printed number is missing, beside the paper, or below another cell."""
    page = browser.new_page(viewport={"width": 1400, "height": 900})
    page.goto(page_file.as_uri())
    page.evaluate(OPENED % "true")
    expected = Counter(NUMBER.findall(page.evaluate(SHOWN)))
    page.evaluate(OPENED % "false")
    assert len(expected) > 5
    assert page.evaluate("document.documentElement.scrollHeight") <= 2.0 * SCREEN_PX
    assert not [cell for cell in page.evaluate(CELLS) if UNREADABLE.fullmatch(cell)]
    for paper in PAPER:
        pdf = page_file.with_suffix(".pdf")
        page.pdf(path=pdf, format=paper)
        text = subprocess.run(["pdftotext", "-layout", pdf, "-"], capture_output=True, text=True, check=True).stdout
        text = re.sub(r"-\n\s*(?=\d)", "-", text)  # names such as AAR-1B may be broken behind their hyphen
        assert expected - Counter(NUMBER.findall(text)) == Counter()
        sheets = text.removesuffix("\f").split("\f")
        numbers = [re.search(r"(\d+) ?/ ?(\d+)\s*$", sheet).groups() for sheet in sheets]
        assert numbers == [(str(number), str(len(sheets))) for number in range(1, len(sheets) + 1)]
        refuse_blank(pdf, len(sheets))
    page.emulate_media(media="print")
    for width_mm in PAPER.values():
        page.set_viewport_size({"width": int(width_mm * 96.0 / 25.4), "height": 900})
        assert all(scale > 0.985 for scale in page.evaluate(SCALES))
        left, right, top, bottom = np.array(page.evaluate(BOXES)).T
        assert left.min() >= -0.5
        assert right.max() <= page.viewport_size["width"] + 0.5
        across = np.minimum(right[:, None], right) - np.maximum(left[:, None], left)
        down = np.minimum(bottom[:, None], bottom) - np.maximum(top[:, None], top)
        assert np.count_nonzero((across > 1.0) & (down > 1.0)) == len(left)  # each with itself only
    page.close()


def checked_png(figure):
    """Return the file of a picture; refuse one wider than a sheet, letters below 8 pt, and texts beyond its edges."""
    assert figure.get_figwidth() <= PAGE_IN
    content = png(figure)
    ticks = {
        label
        for axes in figure.findobj(Axis)
        for tick in axes.get_major_ticks()
        for label in (tick.label1, tick.label2)
    }
    texts = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    assert min(text.get_fontsize() for text in texts) >= 8.0
    texts = [text for text in texts if text not in ticks]  # those beyond the limits of axes are not drawn
    renderer, (width, height) = figure.canvas.get_renderer(), figure.bbox.size
    for text in texts:
        box = text.get_window_extent(renderer)
        assert -2.0 <= box.x0 <= box.x1 <= width + 2.0, text.get_text()
        assert -2.0 <= box.y0 <= box.y1 <= height + 2.0, text.get_text()
    return content


def refuse_blank(pdf, n_sheets):
    """Refuse a sheet, other than the last one, whose lower half is empty."""
    for number in range(1, n_sheets):
        command = ["pdftoppm", "-r", "30", "-gray", "-f", str(number), "-l", str(number), pdf]
        picture = subprocess.run(command, capture_output=True, check=True).stdout
        grey = np.asarray(Image.open(io.BytesIO(picture)))
        rows = np.flatnonzero(grey[: int(0.94 * len(grey))].min(axis=1) < 200)
        assert rows[-1] > 0.5 * len(grey), f"sheet {number}"


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
def test_no_report_is_cut(browser, tmp_path, call, command, monkeypatch):
    """Reports of all kinds have two screens, all their numbers on the paper, and pictures with letters of 8 pt."""
    monkeypatch.setattr(drawing, "png", checked_png)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    status, _, error = call(*command, "--out", "out", "-q")
    assert status == 0, error
    pages = list((tmp_path / "out").rglob("report.html"))
    assert pages
    for page in pages:
        refuse_cut(browser, page)
