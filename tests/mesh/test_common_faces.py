"""Interfaces of two meshes cut into common faces, meshes joined there, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import PolyhedralMesh, check_polyhedra, joined, matched, octree, rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement, Traction
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from flangeway_studies.polyhedra import tilted_blocks


def _shifted(mesh: PolyhedralMesh, *shift: float) -> PolyhedralMesh:
    return replace(mesh, points=mesh.points + shift)


def _cubes(n: int) -> PolyhedralMesh:
    return octree((1.0, 1.0, 1.0), (n, n, n), finer=lambda _, sides: sides < 0.0, levels=0)


def test_both_meshes_have_the_same_faces_on_the_interface():
    """Cells keep their volumes and stay closed, and each face of one side has all its points on one of the other."""
    blocks = tilted_blocks()
    cut = matched(blocks[0], "z+", blocks[1], "z-")
    faces = []
    for before, after, name in zip(blocks, cut, ("z+", "z-"), strict=True):
        check_polyhedra(after)
        assert after.cell_volumes == pytest.approx(before.cell_volumes, rel=1e-12)
        areas = np.linalg.norm(after.face_vectors[after.face_set(name)], axis=1)
        assert areas.sum() == pytest.approx(400.0 / np.cos(np.deg2rad(20.0)), rel=1e-12)
        loops = [np.round(after.points[after.loop(face)], 8) + 0.0 for face in after.face_set(name)]
        faces.append({frozenset(map(tuple, loop.tolist())) for loop in loops})
    assert faces[0] == faces[1]


def test_bonded_blocks_are_stretched_like_one():
    """Tension through an inclined interface of meshes that do not match strains every cell of both alike."""
    first, second = tilted_blocks()
    mesh = joined(dict(zip(("lower", "upper"), matched(first, "z+", second, "z-"), strict=True)))
    supports = [
        PrescribedDisplacement((0.0, 0.0, 0.0), x=0.0, y=0.0, z=0.0),
        PrescribedDisplacement((20.0, 0.0, 0.0), y=0.0, z=0.0),
        PrescribedDisplacement((0.0, 20.0, 0.0), z=0.0),
    ]
    loads = [Traction("upper z+", (0.0, 0.0, 100.0)), Traction("lower z-", (0.0, 0.0, -100.0))]
    solution = solve_elasticity(
        Elasticity(Space(mesh, Virtual(1)), Elastic(210000.0, 0.3), loads=loads, supports=supports)
    )
    exact = 100.0 / 210000.0 * mesh.points * (-0.3, -0.3, 1.0)
    assert np.abs(solution.displacements - exact).max() < 1e-11 * np.abs(exact).max()


def test_joined_meshes_keep_names_of_cells_and_of_the_boundary():
    """Cells are sets of their mesh's name; faces that are bonded are no boundary."""
    first, second = tilted_blocks()
    mesh = joined(dict(zip(("lower", "upper"), matched(first, "z+", second, "z-"), strict=True)))
    assert (mesh.cell_sets["lower"] == np.arange(first.n_cells)).all()
    assert {"lower z-", "upper z+"} <= mesh.face_sets.keys()
    assert mesh.face_sets.keys() & {"lower z+", "upper z-"} == set()


def test_what_faces_do_not_have_in_common_stays_their_own():
    """Of shifted blocks that are joined at what they share, the rest of both faces is on the boundary."""
    first, second = _cubes(2), _shifted(_cubes(3), 0.4, 0.0, 1.0)
    mesh = joined(dict(zip("ab", matched(first, "z+", second, "z-"), strict=True)))
    check_polyhedra(mesh)
    areas = {name: np.linalg.norm(mesh.face_vectors[mesh.face_set(name)], axis=1).sum() for name in ("a z+", "b z-")}
    assert areas == pytest.approx({"a z+": 0.4, "b z-": 0.4}, rel=1e-12)


def test_what_cannot_be_cut_is_refused():
    """Faces in two planes, and a face with a whole one of the other mesh inside, are errors that say so."""
    cubes = _cubes(1)
    with pytest.raises(InputError, match="off their plane"):
        matched(cubes, "z+", _shifted(cubes, 0.0, 0.0, 1.1), "z-")
    small = PolyhedralMesh.extruded(
        rectangle_grid(0.2, 0.2, 1, 1, cells="quadrilaterals", origin=(0.4, 0.4)), [1.0, 1.2]
    )
    with pytest.raises(InputError, match="inside"):
        matched(cubes, "z+", small, "z-")
