"""Smooth curves as chains of arcs that are tangent to each other.

Each piece of the curve, with its ends and the tangents there, gets two arcs that meet tangentially (K. M. Bolton,
"Biarc curves", Computer-Aided Design 7, 1975); of the family of such pairs the one with equal distances from the ends
to the corner points of the tangents is taken. The error falls with the third power of the length of a piece.
"""

import itertools
import math
from collections.abc import Callable

import numpy as np

from flangeway.errors import InputError
from flangeway.geometry.arrays import FloatArray, as_point, cross_product, turned_right, units_of
from flangeway.geometry.segments import Arc, Line, Segment

Curve = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Points (n, 2) and tangents (n, 2), not zero, at parameters (n,)."""

_FRACTIONS = np.linspace(0.0, 1.0, 40)  # between them the error grows by a few percent at most
_FLAT_SAGITTA = 1e-7
_FLAT_CURVATURE = 2e-6  # flatter arcs are lines: their centres would have no digits
_MAX_DEPTH = 14


def biarcs(curve: Curve, breaks: FloatArray, tolerance: float) -> list[Segment]:
    """Return arcs and lines along a curve, tangent to each other.

    A loop of its own: pieces are halved one by one, in the order of the chain. An `InputError` if the curve turns so
    sharply that pieces of a thousandth of those between the breaks do not suffice.

    - `curve`: smooth between the breaks; where the tangent jumps there must be a break, with the tangent of either side
      for parameters inside it.
    - `breaks`: parameters (n,), increasing; joints of the chain are at all of them.
    - `tolerance`: maximum distance between curve and arcs.
    """
    arcs: list[Segment] = []
    for first, last in itertools.pairwise(breaks.tolist()):
        pending = [(first, last, 0)]
        while pending:
            low, high, depth = pending.pop()
            pieces, error = _pair(curve, low, high)
            if error <= tolerance:
                arcs += pieces
            elif depth == _MAX_DEPTH:
                x, y = curve(np.array([low]))[0][0]
                raise InputError(
                    f"a curve that turns too sharply for arcs at ({x:.6g}, {y:.6g})",
                    "a smooth curve",
                    "smooth more, or remove the points about this place",
                )
            else:
                middle = 0.5 * (low + high)
                pending += [(middle, high, depth + 1), (low, middle, depth + 1)]
    return arcs


def _pair(curve: Curve, low: float, high: float) -> tuple[list[Segment], float]:
    """Return two arcs between parameters and their maximum distance from the curve."""
    points, tangents = curve(low + (high - low) * _FRACTIONS)
    tangents = units_of(tangents)
    start, end, t0, t1 = points[0], points[-1], tangents[0], tangents[-1]
    chord = end - start
    along = float(chord @ (t0 + t1))
    bend = 2.0 * (1.0 - float(t0 @ t1))
    reach = along + math.sqrt(along**2 + bend * float(chord @ chord))
    # tangents that lead backwards have no short pair of arcs
    if not reach > 1e-3 * math.hypot(*chord) or min(chord @ t0, chord @ t1) <= 0.0:
        return [], math.inf
    step = float(chord @ chord) / reach
    joint = 0.5 * (start + step * t0 + end - step * t1)
    # the second arc is found from its end, backwards, so that both have the curve's tangents
    pieces = [_tangent_piece(start, joint, t0), _tangent_piece(end, joint, -t1).reversed()]
    distances = np.min([piece.closest(points)[1] for piece in pieces], axis=0)
    return pieces, float(distances.max())


def _tangent_piece(start: FloatArray, end: FloatArray, tangent: FloatArray) -> Segment:
    """Return the arc between two points with a tangent at its start."""
    chord = end - start
    turn = 2.0 * float(cross_product(tangent, chord)) / float(chord @ chord)
    if abs(turn) < max(_FLAT_CURVATURE, 8.0 * _FLAT_SAGITTA / float(chord @ chord)):
        return Line(as_point(start), as_point(end))
    centre = start - turned_right(tangent) / turn
    return Arc(as_point(start), as_point(end), as_point(centre), turn > 0.0)
