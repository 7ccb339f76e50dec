"""Published tables: frequencies of square plates (Leissa, 1973, J. Sound Vib. 31), torsion (Moherdaui, 2021, 4 to 7).

Leissa's ``omega a^2 sqrt(m / D)`` are exact with two opposite sides simply supported; the others are upper bounds by
Ritz's method with 36 products of beam functions, up to 1 % high with free sides.
"""

import numpy as np
import pytest

from flangeway.forms import Plate, modes
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway_studies.torsion import SECTIONS, solve_code

TRIANGLES = triangulate(square(1.0, (0.5, 0.5)), size=1.0 / 8.0)
TURN = np.array([[0.8, -0.6], [0.6, 0.8]])
SUPPORTS = {"C": "clamped", "S": "simple"}
EXACT = {"SSSS": (19.7392, 49.3480, 49.3480), "SCSC": (28.951, 54.743, 69.327), "SFSF": (9.6314, 16.1348, 36.7256)}
RITZ = {
    "CCCC": (35.992, 73.413, 73.413),
    "CCCF": (24.020, 40.039, 63.493),
    "CFFF": (3.4917, 8.5246, 21.429),
    "FFFF": (0.0, 0.0, 0.0, 13.489, 19.789, 24.432),
}


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("cells", ["triangles", "duals"])
@pytest.mark.parametrize("sides", [*EXACT, *RITZ])
def test_frequencies_are_leissas(sides, cells, turned):
    """Left, bottom, right and top side: 0.15 % from exact ones, -1 % to 0.1 % from upper bounds, turned or not."""
    mesh = TRIANGLES if cells == "triangles" else dual(TRIANGLES)
    if turned:
        mesh = PolyMesh(mesh.points @ TURN.T, mesh.cell_offsets, mesh.cell_points, edge_sets=mesh.edge_sets)
    plate = Plate(mesh, 3, poisson=0.3)
    names = zip(sides, ("left", "bottom", "right", "top"), strict=True)
    held = [plate.boundary_dofs(SUPPORTS[side], name) for side, name in names if side != "F"]
    published = np.array((EXACT | RITZ)[sides])
    fixed = np.unique(np.concatenate(held)) if held else None
    squares, _ = modes(plate, plate.stiffness(), plate.mass(), len(published), fixed)
    low, high = (-1.5e-3, 1.5e-3) if sides in EXACT else (-0.01, 1e-3)
    ratio = np.sqrt(squares[published > 0.0]) / published[published > 0.0]
    assert (ratio > 1.0 + low).all()
    assert (ratio < 1.0 + high).all()
    assert np.abs(squares[published == 0.0]).max(initial=0.0) < 1e-5


@pytest.mark.parametrize(("level", "error", "published"), [(1, 9.35e-3, 0.0152), (4, 6.29e-4, 0.00102)])
def test_projected_load_is_more_accurate_than_the_published_reading(level, error, published):
    """With the load as written in (3.81), VVSO1 of Prandtl's function has 0.6 times the published error."""
    constant = solve_code(f"VVSM{level}O1", "prandtl").torsion_constant
    assert abs(constant / SECTIONS["S"][1].torsion_constant - 1.0) == pytest.approx(error, rel=0.05)
    assert error < 0.7 * published
