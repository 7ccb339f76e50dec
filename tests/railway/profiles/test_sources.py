"""Tables of bundled wheels against the formulas and numbers from which they were written."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from flangeway.geometry import Arc, Contour, Line
from flangeway.geometry.biarcs import biarcs
from flangeway.railway.profiles.bundled import REFERENCE_WHEELS, wheel

# EN 13715, S1002: y from the tape line towards the flange negative, z from the tread at the tape line down
_TREAD = (
    0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8, -1.562379023e-8, 5.309217349e-15,
    -5.957839843e-12, 2.646656573e-13,
)  # fmt: skip
_FLANGE_ROOT = (
    -4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875, -2.054332446e-1, -4.169739389e-3, -4.687195829e-5,
    -2.252755540e-7,
)  # fmt: skip
_Y = {"rim": 60.0, "A": 32.15796, "B": -26.0, "C": -35.0, "D": -38.426669071, "E": -39.764473993}
_Y |= {"F": -49.662510381, "G": -62.764705882, "back": -70.0}
_CIRCLES = {
    "flange_root_R13": ((-26.210665, 16.446), 13.0, -1.0),
    "flange_front_R20": ((-58.558326413, 8.834924130), 20.0, 1.0),
    "flange_tip_R12": ((-55.0, 16.0), 12.0, 1.0),
    "flange_back_R20.5": ((-49.5, 9.519259302), 20.5, 1.0),
}


def s1002_contour(tolerance_mm):
    """Return the S1002 from its back face to the end of its tread, 60 mm outside of the tape line.

    Lines and circles are the standard's; its two polynomials are followed by arcs within a tolerance.
    """
    rows = [
        ("flange_back_R20.5", _circle_piece("flange_back_R20.5", _Y["back"], _Y["G"])),
        ("flange_tip_R12", _circle_piece("flange_tip_R12", _Y["G"], _Y["F"])),
        ("flange_front_R20", _circle_piece("flange_front_R20", _Y["F"], _Y["E"])),
        ("flange_face_70deg", Line(_on_circle("flange_front_R20", _Y["E"]), _on_circle("flange_root_R13", _Y["D"]))),
        ("flange_root_R13", _circle_piece("flange_root_R13", _Y["D"], _Y["C"])),
        *_polynomial_pieces("flange_root", _FLANGE_ROOT, _Y["C"], _Y["B"], tolerance_mm),
        *_polynomial_pieces("tread", _TREAD, _Y["B"], _Y["A"], tolerance_mm),
        ("tread_1:15", Line(_on_polynomial(_TREAD, _Y["A"]), (_Y["rim"], _Y["rim"] / 15.0 - 1.364323640))),
    ]
    return Contour.named(rows)


def _on_circle(name, y):
    (y_centre, z_centre), radius, sign = _CIRCLES[name]
    return y, -(z_centre + sign * math.sqrt(max(radius**2 - (y - y_centre) ** 2, 0.0)))


def _circle_piece(name, first, last):
    (y_centre, z_centre), _, sign = _CIRCLES[name]
    # z points down: the flange's arcs are convex, the flange root's is hollow
    return Arc(_on_circle(name, first), _on_circle(name, last), (y_centre, -z_centre), sign > 0.0)


def _on_polynomial(coefficients, y):
    return y, -float(np.polynomial.polynomial.polyval(y, coefficients))


def _polynomial_pieces(name, coefficients, first, last, tolerance_mm):
    slopes = np.polynomial.polynomial.polyder(coefficients)

    def curve(y):
        heights = np.polynomial.polynomial.polyval(y, coefficients)
        directions = np.column_stack([np.ones_like(y), -np.polynomial.polynomial.polyval(y, slopes)])
        return np.column_stack([y, -heights]), directions

    breaks = np.linspace(first, last, 9)
    return [(name, piece) for piece in biarcs(curve, breaks, tolerance_mm)]


@pytest.mark.parametrize(("surface", "tolerance_mm"), [("outline", 5e-5), ("fine", 1e-6)])
def test_the_s1002_is_that_of_its_formulas(surface, tolerance_mm):
    """Lines and circles are the standard's, and arcs follow its polynomials to the tolerance of the table."""
    profile = wheel("S1002")
    table = profile.fine if surface == "fine" else profile.outline.part(profile.running_names)
    contour = s1002_contour(tolerance_mm)
    assert table.names == contour.names
    for one, other in zip(table.segments, contour.segments, strict=True):
        np.testing.assert_allclose([one.start, one.end], [other.start, other.end], rtol=0.0, atol=1e-9)
        assert one.length == pytest.approx(other.length, rel=1e-9)
    y = np.linspace(_Y["B"] + 0.3, _Y["A"], 4001)  # its polynomials are 0.04 µm apart at their joint
    points = np.column_stack([y, -np.polynomial.polynomial.polyval(y, _TREAD)])
    assert table.closest(points)[2].max() <= 1.05 * tolerance_mm


def source_rows(file):
    """Rows of the numbers of a source, without its comments."""
    lines = (Path(__file__).parent / "sources" / file).read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def test_the_heavy_haul_wheel_has_the_arcs_of_its_source():
    """The source's radii from the axle and lateral places, from a tape line 70 mm from the flange's back."""
    rows = source_rows("heavy_haul_wheel_arcs.csv")
    tape = float(rows[0]["yc"]) - float(rows[0]["R"]) + 70.0
    radius = float(rows[6]["rc"]) + math.sqrt(float(rows[6]["R"]) ** 2 - (tape - float(rows[6]["yc"])) ** 2)
    for row, arc in zip(rows, wheel("heavy-haul").running_surface.segments, strict=True):
        point = {end: (float(row[f"y{end}"]) - tape, radius - float(row[f"r{end}"])) for end in "01c"}
        ends = [point["0"], point["1"]] if row["arc"] == "9" else sorted([point["0"], point["1"]])
        np.testing.assert_allclose([arc.start, arc.end, arc.centre], [*ends, point["c"]], rtol=0.0, atol=2e-5)
        assert arc.counter_clockwise == (row["curvature"] == "convex")


@pytest.mark.parametrize("name", REFERENCE_WHEELS)
def test_reference_wheels_follow_the_formulas_of_the_standard(name):
    """Every line and arc of EN 15302 is that of its formula, to the rounding of a micrometre that its joints need."""
    rows = [row for row in source_rows("EN15302_profiles.csv") if row["profile"] == name]
    running = wheel(name).running_surface
    assert running.names == tuple(row["name"] for row in rows)
    for row, segment in zip(rows, running.segments, strict=True):
        y = np.linspace(float(row["y0_mm"]), float(row["y1_mm"]), 11)
        z = float(row["z_mm"]) + (
            float(row["slope"]) * y
            if row["slope"]
            else float(row["root"])
            * np.sqrt(np.maximum(float(row["radius_mm"]) ** 2 - (y - float(row["y_mm"])) ** 2, 0.0))
        )
        assert running.closest(np.column_stack([y, -z]))[2].max() < 5e-4
        assert isinstance(segment, Line if row["slope"] else Arc)
