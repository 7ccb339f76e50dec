"""Files of meshes in space: polyhedra written and read again, elements and named faces of Gmsh, and what is refused."""

import meshio
import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.formats import read_polyhedra, write_vtu_polyhedra
from flangeway.mesh import check_polyhedra
from tests.polyhedra import BOX, boxes, tetrahedra

MESHES = boxes()


@pytest.mark.parametrize("name", MESHES)
def test_polyhedra_are_read_as_they_were_written(name, tmp_path):
    """Points, volumes, faces and sets of cells of a VTU file are those of the mesh, but for the order of cells."""
    mesh = MESHES[name].with_cell_set("low", np.arange(0, MESHES[name].n_cells, 2))
    path = tmp_path / "mesh.vtu"
    write_vtu_polyhedra(path, mesh, {"place": mesh.points}, {"volume": mesh.cell_volumes})
    read = read_polyhedra(path)
    check_polyhedra(read)
    assert read.points == pytest.approx(mesh.points, abs=0.0)
    assert np.sort(read.cell_volumes) == pytest.approx(np.sort(mesh.cell_volumes), rel=1e-14)
    assert (read.n_faces, len(read.boundary_faces)) == (mesh.n_faces, len(mesh.boundary_faces))
    low = read.cell_volumes[read.cell_set("low")]
    assert np.sort(low) == pytest.approx(np.sort(mesh.cell_volumes[mesh.cell_set("low")]), rel=1e-14)
    data = meshio.read(path)
    assert data.point_data["place"] == pytest.approx(mesh.points, abs=0.0)
    assert np.concatenate(data.cell_data["volume"]) == pytest.approx(read.cell_volumes, rel=1e-12)


@pytest.mark.parametrize(("ending", "kind"), [("msh", "gmsh22"), ("vtu", "vtu"), ("mesh", "medit")])
def test_elements_and_named_faces_are_read(ending, kind, tmp_path):
    """Tetrahedra keep their volume; groups of cells and of triangles on the boundary are sets; lines are left out."""
    points, cells = tetrahedra()
    below = MESHES["tetrahedra"]
    triangles = np.array([below.loop(face) for face in below.face_set("z-")])
    blocks = [("tetra", cells), ("triangle", triangles), ("line", triangles[:1, :2])]
    numbers = [np.where(points[cells, 0].mean(axis=1) < 0.5, 1, 2), np.full(len(triangles), 7), np.array([9])]
    array = {"msh": "gmsh:physical", "vtu": "part", "mesh": "medit:ref"}[ending]
    data = {array: numbers} | ({"gmsh:geometrical": numbers} if ending == "msh" else {})
    path = tmp_path / f"mesh.{ending}"
    meshio.Mesh(np.vstack((points, [[9.0, 9.0, 9.0]])), blocks, cell_data=data).write(path, file_format=kind)
    mesh = read_polyhedra(path)
    check_polyhedra(mesh)
    before = "part_" if ending == "vtu" else ""
    assert mesh.n_points == len(points)
    assert mesh.cell_volumes.sum() == pytest.approx(np.prod(BOX[3:]), rel=1e-12)
    assert len(mesh.cell_set(f"{before}1")) == (numbers[0] == 1).sum()
    assert np.linalg.norm(mesh.face_vectors[mesh.face_set(f"{before}7")], axis=1).sum() == pytest.approx(2.0)


def test_faces_that_are_not_plane_are_divided(tmp_path):
    """A hexahedron with a corner off its faces' planes becomes a polyhedron with triangles."""
    cube = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
    cube[7] += 0.2
    path = tmp_path / "mesh.vtk"
    meshio.Mesh(cube, [("hexahedron", np.array([[0, 1, 3, 2, 4, 5, 7, 6]]))]).write(path)
    mesh = read_polyhedra(path)
    check_polyhedra(mesh)
    assert (mesh.n_cells, mesh.n_faces) == (1, 9)


def test_files_without_solid_cells_are_refused(tmp_path):
    """A plane mesh, a file that is not there, and an empty one are errors that name the file."""
    path = tmp_path / "plane.vtu"
    meshio.Mesh(np.eye(3), [("triangle", np.array([[0, 1, 2]]))]).write(path)
    with pytest.raises(InputError, match=r"plane\.vtu: no solid cells"):
        read_polyhedra(path)
    with pytest.raises(InputError, match=r"none\.msh"):
        read_polyhedra(tmp_path / "none.msh")
    (tmp_path / "empty.msh").touch()
    with pytest.raises(InputError, match=r"empty\.msh"):
        read_polyhedra(tmp_path / "empty.msh")
