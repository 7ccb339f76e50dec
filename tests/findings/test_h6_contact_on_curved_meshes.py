"""H6: contact of order 1 on a curved mesh is measured on the curve."""

import numpy as np
import pytest

from flangeway import (
    Body,
    Contact,
    Elastic,
    Lagrange,
    Multiplier,
    NodeToSegment,
    Part,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.contact import Pairing
from flangeway.geometry import Arc, Line, Outline, Placement
from flangeway.mesh import triangulate
from flangeway.post import pressure_patches

MATERIAL = Elastic(1000.0, 0.3)
RADIUS, OUTER, INTERFERENCE = 10.0, 20.0, 0.01


def lame_pressure() -> float:
    """Pressure of a shaft in a ring with a smaller bore, plane strain (Timoshenko and Goodier, 1970, section 28)."""
    modulus, ratio = MATERIAL.young / (1.0 - MATERIAL.poisson**2), MATERIAL.poisson / (1.0 - MATERIAL.poisson)
    squares = (OUTER**2 + RADIUS**2) / (OUTER**2 - RADIUS**2)
    return INTERFERENCE / RADIUS * modulus / ((squares + ratio) + (1.0 - ratio))


def quarter(radius: float, bore: float = 0.0) -> Outline:
    """The part of a disc, or of a ring, in the first quadrant."""
    o, x, y = (0.0, 0.0), (radius, 0.0), (0.0, radius)
    segments, names = [Arc(x, y, o, True)], ["rim"]
    if not bore:
        return Outline.from_segments([*segments, Line(y, o), Line(o, x)], [*names, "left", "bottom"])
    inner_x, inner_y = (bore, 0.0), (0.0, bore)
    rest = [Line(y, inner_y), Arc(inner_y, inner_x, o, False), Line(inner_x, x)]
    return Outline.from_segments([*segments, *rest], [*names, "left", "bore", "bottom"])


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("pairing", [NodeToSegment(), SegmentToSegment()], ids=repr)
def test_h6_a_shaft_in_a_ring(pairing: Pairing, mirrored: bool) -> None:
    """An interference of a fifth of the sagitta presses as Lame's theory says, where chords gave 0 or 40 times it."""
    placement = Placement(0.0, (0.0, 0.0), mirrored)
    surfaces = []
    for name, outline, size, side in (
        ("shaft", quarter(RADIUS + INTERFERENCE), 2.0, "rim"),
        ("ring", quarter(OUTER, RADIUS), 2.3, "bore"),
    ):
        mesh = triangulate(outline, size=size, outline=outline)
        part = Part(name, Body(name, mesh, Lagrange(1), MATERIAL, {"left": "x", "bottom": "y"}), placement)
        surfaces.append(Surface(part, mesh.edge_sets[side]))
    solution = press([Contact(surfaces[0], surfaces[1], pairing, Multiplier())], {})
    assert solution.status.converged
    (patch,) = pressure_patches(solution.system, solution.state)
    assert patch.pressures == pytest.approx(np.full(len(patch.pressures), lame_pressure()), rel=0.1)
    assert patch.pressures.mean() == pytest.approx(lame_pressure(), rel=0.02)
