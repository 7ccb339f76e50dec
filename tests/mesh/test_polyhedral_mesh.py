"""Meshes of polyhedra: connections, volumes, named faces, and what is refused with its place."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import PolyhedralMesh, check_polyhedra, rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement, RigidHandle, Traction, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space
from flangeway_studies.polyhedra import ball_octant
from tests.polyhedra import BOX, boxes, voronoi_box

CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
OPEN = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [2, 6, 7, 3]]
FLAT = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]
HEXAHEDRON = [[0, 1, 3, 2, 4, 5, 7, 6]]


def cube(points=CUBE) -> PolyhedralMesh:
    return PolyhedralMesh.from_elements(points, HEXAHEDRON)


@pytest.mark.parametrize("name", boxes())
def test_cells_fill_the_box_and_sides_are_its_boundary(name):
    """Volumes sum up to that of the box, areas of named sides to its surface, and each inner face has two cells."""
    mesh = boxes()[name]
    check_polyhedra(mesh)
    x, y, z = BOX[3:]
    assert mesh.cell_volumes.sum() == pytest.approx(x * y * z, rel=1e-13)
    areas = np.linalg.norm(mesh.face_vectors, axis=1)
    sides = {side: areas[mesh.face_set(side)].sum() for side in ("x-", "x+", "y-", "y+", "z-", "z+")}
    assert sides == pytest.approx(
        {"x-": y * z, "x+": y * z, "y-": x * z, "y+": x * z, "z-": x * y, "z+": x * y}, rel=1e-12
    )
    assert len(mesh.cell_neighbours) == mesh.n_faces - len(mesh.boundary_faces)
    outward = mesh.face_vectors * mesh.face_sides[:, None]
    assert outward[mesh.boundary_faces].sum(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_an_extruded_mesh_has_the_names_of_its_section():
    """Edge sets become face sets, cell sets stay, and the ends have names."""
    plane = rectangle_grid(2.0, 1.0, 2, 1, cells="quadrilaterals").with_cell_set("left", [0])
    solid = PolyhedralMesh.extruded(plane, [0.0, 1.0, 3.0])
    areas = np.linalg.norm(solid.face_vectors, axis=1)
    assert {name: areas[faces].sum() for name, faces in solid.face_sets.items()} == pytest.approx(
        {"bottom": 6.0, "top": 6.0, "left": 3.0, "right": 3.0, "z-": 2.0, "z+": 2.0}
    )
    assert solid.cell_volumes[solid.cell_set("left")].sum() == pytest.approx(3.0)


def test_faces_that_are_not_plane_are_divided_without_a_gap():
    """Hexahedra on a ball become polyhedra with triangles, closed, and fill what their triangles enclose."""
    mesh = ball_octant(np.linspace(1.0, 2.0, 5), 4)
    check_polyhedra(mesh)
    exact = np.pi / 6.0 * (8.0 - 1.0)
    assert mesh.cell_volumes.sum() == pytest.approx(exact, rel=0.03)
    assert set(np.diff(mesh.face_offsets)) == {3, 4}


def dented() -> tuple[np.ndarray, list[list[list[int]]]]:
    """A cube whose top is a pyramid that goes down below the mean of its points."""
    points = np.concatenate((CUBE, [[0.5, 0.5, 0.1]]))
    sides = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [2, 6, 7, 3], [0, 4, 6, 2]]
    return points, [[*sides, [4, 5, 8], [5, 7, 8], [7, 6, 8], [6, 4, 8]]]


def shifted(row: int, step: tuple[float, float, float]) -> np.ndarray:
    points = CUBE.copy()
    points[row] += step
    return points


@pytest.mark.parametrize(
    ("mesh", "named"),
    [
        (lambda: cube(shifted(7, (0.1, 0.2, 0.3))), "face"),
        (lambda: PolyhedralMesh.from_elements(FLAT, [[0, 1, 2, 3]]), "cell 0, which is open or flat"),
        (lambda: cube(CUBE * (1.0, 1.0, 0.0)), "face"),
        (
            lambda: PolyhedralMesh.from_cells(
                CUBE, [[[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [2, 6, 7, 3]]]
            ),
            "cell 0, which is open or flat",
        ),
        (lambda: PolyhedralMesh.from_elements(CUBE, HEXAHEDRON * 2), "2 cells"),
        (lambda: PolyhedralMesh.from_cells(*dented()), "cell 0, which is open or flat"),
    ],
)
def test_a_broken_mesh_is_refused_with_its_place(mesh, named):
    """Bent faces, flat, open and doubled cells are refused by number and place."""
    with pytest.raises(InputError) as error:
        check_polyhedra(mesh())
    assert named in str(error.value)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Space(cube(), Virtual(2)), "Virtual(1)"),
        (lambda: Space(cube(), Lagrange(1)), "Virtual(1)"),
        (lambda: cube().face_set("top"), "top"),
        (lambda: cube().with_face_set("none", lambda p: p[:, 0] > 5.0), "none"),
        (lambda: PolyhedralMesh.voronoi([[0.5, 0.5, 2.0]], (0, 0, 0, 1, 1, 1)), "inside"),
        (lambda: PolyhedralMesh.from_elements(CUBE, [[0, 1, 2]]), "(1, 3)"),
        (lambda: PolyhedralMesh.extruded(rectangle_grid(1.0, 1.0, 1, 1), [1.0, 0.0]), "heights"),
        (lambda: Elasticity(Space(cube(), Virtual(1)), Elastic(1.0, 0.3, "plane_stress")), "plane_stress"),
        (lambda: Elasticity(Space(cube(), Virtual(1)), Elastic(1.0, 0.3), thickness=2.0), "thickness"),
        (
            lambda: Elasticity(Space(cube(), Virtual(1)), Elastic(1.0, 0.3), supports=[RigidHandle("top")]),
            "rigid handle",
        ),
    ],
)
def test_what_has_no_form_in_space_is_refused(make, named):
    """Elements, hypotheses, thickness and handles of the plane, unknown names, wrong shapes are refused by name."""
    with pytest.raises(InputError) as error:
        make()
    assert named in str(error.value)


def test_a_load_with_two_components_is_refused_in_space():
    """A traction in space has three components."""
    mesh = cube().with_face_set("top", lambda p: p[:, 2] > 0.9).with_face_set("base", lambda p: p[:, 2] < 0.1)
    problem = Elasticity(
        Space(mesh, Virtual(1)), Elastic(1.0, 0.3), loads=[Traction("top", (1.0, 0.0))], supports=[fixed("base", 3)]
    )
    with pytest.raises(InputError, match="3 numbers"):
        solve_elasticity(problem)


def test_the_motions_that_nothing_holds_are_named():
    """A body that slides on a plane can slide in x and y and turn about z, and no other motion is named."""
    mesh = voronoi_box()
    problem = Elasticity(Space(mesh, Virtual(1)), Elastic(1.0, 0.3), supports=[PrescribedDisplacement("z-", z=0.0)])
    with pytest.raises(InputError) as error:
        solve_elasticity(problem)
    assert "slide in x, slide in y, turn about z" in str(error.value)
    assert "slide in z" not in str(error.value)
