"""Uniform strains on meshes with curved edges, at the boundary and between materials."""

from functools import cache

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import Region, Section, Spline, circle
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, curved, dual, dual_section, triangulate, triangulate_section
from flangeway.post import cell_stresses
from flangeway.problems import Elasticity
from flangeway.space import Space
from tests.given_displacement import solved

GRADIENT = np.array([[1.2e-3, -0.7e-3], [2.1e-3, 0.4e-3]])
SHIFT = np.array([0.3e-3, -0.1e-3])
OUTER, INNER = circle(2.0), circle(1.0, (0.2, 0.0))


@cache
def mesh_of(name: str) -> PolyMesh:
    """A ring with coarse arcs, a disc in a ring, and a closed spline."""
    if name == "interface":
        section = Section({"ring": Region(OUTER, (INNER,)), "disc": Region(INNER)})
        return dual_section(curved(triangulate_section(section, size=0.9), section))
    mesh = triangulate(OUTER, size=0.9, holes=[INNER])
    if name == "spline":
        angle = np.linspace(0.0, 2.0 * np.pi, 9)
        wave = np.stack(((2.0 + 0.1 * np.cos(4.0 * angle)) * np.cos(angle), 2.0 * np.sin(angle)), axis=1)
        wave[-1] = wave[0]
        return dual(curved(mesh, [Spline(wave), INNER]))
    return curved(mesh, [OUTER, INNER]) if name == "triangles" else dual(mesh, outline=[OUTER, INNER])


CASES = [("ring", Virtual(k)) for k in (1, 2, 3, 4, 5, 6)]
CASES += [(name, Virtual(k)) for name in ("interface", "spline") for k in (2, 4)]
CASES += [("triangles", element) for element in (Lagrange(2), Lagrange(3), Virtual(2))]


@pytest.mark.parametrize(("name", "element"), CASES, ids=repr)
def test_a_linear_displacement_is_reproduced_on_curved_edges(name: str, element) -> None:
    """Displacements are linear to 1e-10 and stresses uniform to 1e-8, for every order, with a few coarse arcs."""
    mesh = mesh_of(name)
    assert mesh.curves is not None
    space = Space(mesh, element)
    material = Elastic(210e3, 0.3)
    solution = solved(space, material, lambda p: p @ GRADIENT.T + SHIFT)
    wanted = space.nodes @ GRADIENT.T + SHIFT
    assert np.abs(solution.displacements[: space.n_nodes] - wanted).max() < 1e-10 * np.abs(wanted).max()
    stress = np.einsum("ijkl,kl->ij", material.stiffness, GRADIENT)
    found = cell_stresses(solution.problem, solution.displacements).components[:, :3]
    assert np.abs(found - stress[[0, 1, 0], [0, 1, 1]]).max() < 1e-8 * np.abs(stress).max()


@pytest.mark.parametrize(
    ("name", "element"), [("ring", Virtual(3)), ("interface", Virtual(2)), ("triangles", Lagrange(2))]
)
def test_rigid_motions_cost_nothing_on_curved_edges(name: str, element) -> None:
    """Both translations and the rotation have no force on any unknown, and nothing else is without energy."""
    space = Space(mesh_of(name), element)
    matrix = Elasticity(space, Elastic(1.0, 0.3)).stiffness()
    values = np.linalg.eigvalsh(matrix.full().toarray())
    assert np.abs(values[:3]).max() < 1e-11 * values[-1]
    assert values[3] > 1e-6 * values[-1]
