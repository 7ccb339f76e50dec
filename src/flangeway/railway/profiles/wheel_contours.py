"""Running surfaces from formulas and arcs: S1002, a heavy-haul wheel of nine arcs, the reference profiles of EN 15302.

They go from the flange's back to the rim, in the frame of a right-hand wheel: x from the tape line, y up, mm.
"""

import math
from functools import cache
from typing import TypeAlias

import numpy as np

from flangeway.formats.drawn_section import DrawnSegment
from flangeway.geometry import Arc, Contour, FloatArray, Line, Point, Segment
from flangeway.railway.profiles.formats.segment_files import GAP_MM, closed_gaps
from flangeway.railway.profiles.smoothing import biarcs
from flangeway.system.file_content import packaged_rows

DATA = "flangeway.railway.profiles"

Named: TypeAlias = tuple[str, Segment]

FINE_TOLERANCE_MM = 1e-6
"""The same where the curvature matters: pressures of patches are then within 0.2 %, and 1 % with 5e-5 mm."""
POLYNOMIAL_TOLERANCE_MM = 5e-5  # maximum distance between the polynomials of an S1002 and the arcs that stand for them

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


@cache  # its fine arcs take 0.2 s
def s1002_contour(tolerance_mm: float = POLYNOMIAL_TOLERANCE_MM) -> Contour:
    """Return the S1002 from its back face to the end of its tread, 60 mm outside of the tape line.

    Lines and circles are the standard's; its two polynomials are followed by arcs within a tolerance.
    """
    rows: list[Named] = [
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


def _on_circle(name: str, y: float) -> Point:
    (y_centre, z_centre), radius, sign = _CIRCLES[name]
    return y, -(z_centre + sign * math.sqrt(max(radius**2 - (y - y_centre) ** 2, 0.0)))


def _circle_piece(name: str, first: float, last: float) -> Arc:
    (y_centre, z_centre), _, sign = _CIRCLES[name]
    # z points down: the flange's arcs are convex, the flange root's is hollow
    return Arc(_on_circle(name, first), _on_circle(name, last), (y_centre, -z_centre), sign > 0.0)


def _on_polynomial(coefficients: tuple[float, ...], y: float) -> Point:
    return y, -float(np.polynomial.polynomial.polyval(y, coefficients))


def _polynomial_pieces(
    name: str, coefficients: tuple[float, ...], first: float, last: float, tolerance_mm: float
) -> list[Named]:
    slopes = np.polynomial.polynomial.polyder(coefficients)

    def curve(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        heights = np.polynomial.polynomial.polyval(y, coefficients)
        directions = np.column_stack([np.ones_like(y), -np.polynomial.polynomial.polyval(y, slopes)])
        return np.column_stack([y, -heights]), directions

    breaks = np.linspace(first, last, 9)
    return [(name, piece) for piece in biarcs(curve, breaks, tolerance_mm)]


HEAVY_HAUL_TAPE_MM = 70.0
"""Distance of the tape line from the flange's back of the heavy-haul wheel, which its source does not give."""

_NAMES = (
    "flange_back", "flange_tip_back", "flange_tip_front", "flange_face", "flange_root_R14", "flange_root_R39",
    "tread_R1335", "tread_R608", "rim_edge",
)  # fmt: skip


def heavy_haul_contour() -> Contour:
    """Return the nine arcs of the heavy-haul wheel from the flange's back over the rim's edge."""
    rows = packaged_rows(DATA, "heavy_haul_wheel_arcs.csv")
    back = float(rows[0]["yc"]) - float(rows[0]["R"])
    tape = back + HEAVY_HAUL_TAPE_MM
    tread = rows[6]
    radius = float(tread["rc"]) + math.sqrt(float(tread["R"]) ** 2 - (tape - float(tread["yc"])) ** 2)

    def point(row: dict[str, str], end: str) -> Point:
        return float(row[f"y{end}"]) - tape, radius - float(row[f"r{end}"])

    arcs = []
    for row in rows:
        ends = sorted((point(row, "0"), point(row, "1")))
        if row is rows[-1]:  # the edge of the rim turns back
            ends = [point(row, "0"), point(row, "1")]
        arcs.append(Arc(ends[0], ends[1], point(row, "c"), row["curvature"] == "convex"))
    return Contour.from_segments(arcs, _NAMES)


def reference_contour(name: str) -> Contour:
    """Return a reference profile of EN 15302, a wheel's running surface, or the rail's head as it is inclined by 1:20.

    The rounding of its formulas leaves gaps of micrometres between the pieces; they are closed in their middle.
    """
    drawn = []
    for row in (row for row in packaged_rows(DATA, "EN15302_profiles.csv") if row["profile"] == name):
        height, ends = float(row["z_mm"]), (float(row["y0_mm"]), float(row["y1_mm"]))
        if row["slope"]:
            start, end = ((y, -(height + float(row["slope"]) * y)) for y in ends)
            drawn.append(DrawnSegment(start, end, name=row["name"]))
            continue
        middle, radius, root = (float(row[column]) for column in ("y_mm", "radius_mm", "root"))
        start, end = ((y, -(height + root * math.sqrt(max(radius**2 - (y - middle) ** 2, 0.0)))) for y in ends)
        drawn.append(DrawnSegment(start, end, (middle, -height), root > 0.0, name=row["name"]))
    closed = closed_gaps(drawn, GAP_MM)[0]
    return Contour.from_segments([segment.checked() for segment in closed], [segment.name for segment in closed])
