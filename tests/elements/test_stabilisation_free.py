"""The element without stabilisation in stretched cells."""

import numpy as np
import pytest

from flangeway.elements import StabilisationFree
from flangeway.forms import interpolate, stiffness
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, rectangle_grid, voronoi
from flangeway.space import Space

MESHES = {
    "quadrilaterals": rectangle_grid(1.0, 1.0, 3, 3, cells="quadrilaterals"),
    "voronoi": voronoi(square(1.0, (0.5, 0.5)), 20, iterations=3),
}


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("kind", sorted(MESHES))
def test_the_energy_does_not_depend_on_the_stretch(kind, order):
    """A mesh and a material that are stretched together keep the energy to 1e-5 up to an aspect ratio of a million."""
    mesh, energies = MESHES[kind], []
    for aspect in (1.0, 1e3, 1e6):
        stretched = PolyMesh(mesh.points * [1.0, 1.0 / aspect], mesh.cell_offsets, mesh.cell_points, {}, {})
        space = Space(stretched, StabilisationFree(order))
        u = interpolate(space, lambda p, a=aspect: np.sin(2.0 * p[:, 0]) * np.exp(p[:, 1] * a))
        energies.append(aspect * (u @ (stiffness(space, np.diag([1.0, aspect**-2.0])) @ u)))
    np.testing.assert_allclose(energies[1:], energies[0], rtol=1e-4 if kind == "voronoi" else 1e-5)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("aspect", [1e3, 1e6])
def test_displacements_in_stretched_cells_have_three_rigid_motions(aspect, order):
    """Rectangles of 1:1000 and more are accepted for elasticity; a body under tension has its energy."""
    mesh = MESHES["quadrilaterals"]
    stretched = PolyMesh(mesh.points * [1.0, 1.0 / aspect], mesh.cell_offsets, mesh.cell_points, {}, {})
    space = Space(stretched, StabilisationFree(order))
    material = Elastic(1.0, 0.0)  # round-off of isotropic energies is eps times the square of the aspect
    u = interpolate(space, lambda p: np.stack((p[:, 0], 0.0 * p[:, 0]), axis=1)).ravel()
    assert aspect * (u @ (stiffness(space, material.stiffness) @ u)) == pytest.approx(
        1.0, rel=1e-10 + 1e-14 * aspect**2
    )
