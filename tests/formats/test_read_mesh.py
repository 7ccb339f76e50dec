"""Meshes read from files of other programs, sound ones, those with small faults, and broken ones."""

import functools
import tempfile
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.formats import read_mesh, write_vtu
from flangeway.geometry import Arc, Line, Placement
from flangeway.mesh import PolyMesh, check, conforming, rectangle_grid, refined
from flangeway.problems.body_records import BodyTable, body_shape
from flangeway.space import Space

# two squares, the right one of two triangles; the left one is clockwise
ABAQUS = """*Heading
 two squares
** a comment
*Part, name=body
*Node, nset=every
1, 0.0, 0.0
2, 1.0, 0.0
3, 2.0, 0.
4, 0.0, 1.0D0
5, 1.0, 1.0
6, 2.0, 1.0
7, 5.0, 5.0
*Element, type=CPE4R, elset=square
10, 1, 4, 5, 2
*ELEMENT, TYPE=CPS3,
 ELSET=halves
20, 2, 3, 6
21, 2, 6, 5
*Nset, nset="left side"
1, 4
*Nset, nset=bottom, generate
1, 3, 1
*Nset, nset=corner
6
*Elset, elset=Steel
square, 20
*Surface, type=ELEMENT, name=top
10, S2
21, S2
*Surface, name=rim
halves,
*End Part
*Assembly, name=all
*Instance, name=body-1, part=body
*End Instance
*Nset, nset=right, instance=body-1
3, 6
*End Assembly
*Material, name=steel
*Elastic
 210000., 0.3
"""


@pytest.fixture(scope="module")
def two_parts():
    """Gmsh's model of two rectangles side by side, with named, shared and nameless physical groups."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    model, occ = gmsh.model, gmsh.model.occ
    left, right = occ.addRectangle(0, 0, 0, 2, 1), occ.addRectangle(2, 0, 0, 1, 1)
    occ.fragment([(2, left)], [(2, right)])
    occ.synchronize()

    def curves(x):
        return [tag for _, tag in model.getEntitiesInBoundingBox(x - 0.1, -0.1, -0.1, x + 0.1, 1.1, 0.1, 1)]

    model.addPhysicalGroup(2, [left], name="left part")
    model.addPhysicalGroup(2, [right], tag=77)
    model.addPhysicalGroup(2, [left, right], name="all")
    model.addPhysicalGroup(1, curves(0), name="held")
    model.addPhysicalGroup(1, curves(3), name="all")
    model.addPhysicalGroup(1, curves(2), name="seam")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
    model.mesh.generate(2)
    yield gmsh
    gmsh.finalize()


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("version", "binary"), [(2.2, 0), (2.2, 1), (4.1, 0), (4.1, 1)])
def test_gmsh_groups_become_sets(two_parts, tmp_path, version, binary, order):
    """Physical surfaces and curves come back by name, or number, from each version, also those of one name."""
    two_parts.model.mesh.setOrder(order)
    two_parts.option.setNumber("Mesh.MshFileVersion", version)
    two_parts.option.setNumber("Mesh.Binary", binary)
    file = tmp_path / "two.msh"
    two_parts.write(str(file))
    read = read_mesh(file)
    mesh = read.mesh
    check(mesh, region_area=3.0, area_tolerance=1e-9)
    assert set(mesh.cell_sets) == {"left part", "77", "all"}
    assert mesh.cell_areas[mesh.cell_set("left part")].sum() == pytest.approx(2.0)
    assert mesh.cell_areas[mesh.cell_set("77")].sum() == pytest.approx(1.0)
    assert len(mesh.cell_set("all")) == mesh.n_cells
    assert set(mesh.edge_sets) == {"held", "all"}
    assert np.all(mesh.points[mesh.edge_set("held"), 0] == 0.0)
    assert np.all(mesh.points[mesh.edge_set("all"), 0] == 3.0)
    reported = " ".join(read.notices)
    assert "'seam'" in reported
    assert ("second or higher order" in reported) == (order == 2)


def test_abaqus_sets_and_surfaces_become_sets(tmp_path):
    """Element sets, faces, rims and node sets are found, the clockwise square is turned, the spare node left out."""
    file = tmp_path / "two.inp"
    file.write_text(ABAQUS)
    read = read_mesh(file)
    mesh = read.mesh
    check(mesh, region_area=2.0)
    assert mesh.n_points == 6
    assert mesh.cell_sizes.tolist() == [4, 3, 3]
    assert {name: cells.tolist() for name, cells in mesh.cell_sets.items()} == {
        "square": [0],
        "halves": [1, 2],
        "Steel": [0, 1],
    }

    def ends(name):
        return sorted(map(tuple, mesh.points[np.unique(mesh.edge_set(name))].tolist()))

    assert ends("left side") == [(0.0, 0.0), (0.0, 1.0)]
    assert ends("bottom") == [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]
    assert ends("top") == [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0)]
    assert ends("right") == [(2.0, 0.0), (2.0, 1.0)]
    assert len(mesh.edge_set("rim")) == 3
    assert "corner" not in mesh.edge_sets
    reported = " ".join(read.notices)
    for words in ("1 cell clockwise", "1 point of no cell", "'rim': 1 edge", "'corner'"):
        assert words in reported


def test_abaqus_second_order_and_lines_from_gmsh(two_parts, tmp_path):
    """CPS6 and T3D3 are read as corners and ends, the same mesh as of first order."""
    meshes = []
    for order in (1, 2):
        two_parts.model.mesh.setOrder(order)
        file = tmp_path / f"two{order}.inp"
        two_parts.write(str(file))
        meshes.append(read_mesh(file).mesh)
    assert meshes[0].n_points == meshes[1].n_points
    np.testing.assert_array_equal(meshes[0].cell_points, meshes[1].cell_points)
    assert np.all(meshes[1].points[meshes[1].edge_set("held"), 0] == 0.0)


def test_sides_of_cells_of_its_own_points_are_joined_or_not(tmp_path):
    """Two squares with their own points at the common side are one body, with a notice, or two if asked."""
    square = rectangle_grid(1.0, 1.0, 1, 1, cells="quadrilaterals")
    beside = square.placed(Placement(0.0, (1.0, 0.0)))
    write_vtu(tmp_path / "two.vtu", square.merged(beside))
    joined = read_mesh(tmp_path / "two.vtu")
    assert joined.mesh.n_points == 6
    assert "2 points at the place of another one" in joined.notices[0]
    apart = read_mesh(tmp_path / "two.vtu", merge_points=False)
    assert not apart.notices
    assert apart.mesh.n_points == 8
    assert len(apart.mesh.boundary_edges) == 8


@pytest.mark.parametrize("kind", ["vtk", "vtu", "mesh", "off", "avs", "bdf"])
def test_other_formats_by_way_of_meshio(tmp_path, kind):
    """A triangulation comes back from formats that meshio writes and reads without further packages."""
    mesh = rectangle_grid(2.0, 1.0, 3, 2)
    file = tmp_path / f"a.{kind}"
    points = np.column_stack([mesh.points, np.zeros(mesh.n_points)])
    meshio.Mesh(points, [("triangle", mesh.cell_points.reshape(-1, 3))]).write(file)
    read = read_mesh(str(file)).mesh
    check(read, region_area=2.0)
    assert np.array_equal(read.cell_points, mesh.cell_points)


def test_hanging_nodes_of_other_programs_make_polygons(tmp_path):
    """A square below two halves that share a node inside its upper side becomes a pentagon, with a notice."""
    points = [*SQUARE, [0.5, 1, 0], [0.5, 2, 0], [0, 2, 0], [1, 2, 0]]
    cells = [("quad", [[0, 1, 2, 3], [3, 4, 5, 6], [4, 2, 7, 5]])]
    read = read_mesh(written(tmp_path / "a.vtu", points, cells))
    assert read.mesh.cell_sizes.tolist() == [5, 4, 4]
    check(read.mesh, region_area=2.0)
    assert "1 point hanging on edges" in read.notices[0]
    drawn = PolyMesh(
        np.array(points)[:, :2], [0, 4, 8, 12], np.ravel(cells[0][1]), {}, {"up": [[2, 3]], "low": [[0, 1]]}
    )
    assert set(conforming(drawn).edge_sets) == {"low"}  # the other one lies inside the body now


@settings.get_profile("costly")
@given(seed=st.integers(0, 2**31))
def test_conforming_finds_the_points_that_refinement_added(seed):
    """Polygons of a refined grid without their hanging points get them back; sets keep the boundary's edges."""
    random = np.random.default_rng(seed)
    mesh = rectangle_grid(2.0, 1.0, 4, 2, cells="quadrilaterals")
    for _ in range(2):
        mesh = refined(mesh, random.random(mesh.n_cells) < 0.4)
    rows = np.split(mesh.cell_points, mesh.cell_offsets[1:-1])
    corners = []
    for row in rows:
        before, after = mesh.points[np.roll(row, 1)], mesh.points[np.roll(row, -1)]
        step, other = mesh.points[row] - before, after - mesh.points[row]
        corners.append(row[np.abs(step[:, 0] * other[:, 1] - step[:, 1] * other[:, 0]) > 1e-12])
    offsets = np.cumsum([0, *map(len, corners)])
    changed = PolyMesh(mesh.points, offsets, np.concatenate(corners), edge_sets=mesh.edge_sets)
    whole = conforming(changed)
    check(whole, region_area=2.0)
    assert np.array_equal(whole.edge_set("top"), mesh.edge_set("top"))
    assert np.array_equal(whole.cell_sizes, mesh.cell_sizes)


def written(path, points, cells):
    meshio.Mesh(np.array(points, dtype=float), cells).write(path)
    return path


SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    ("points", "cells", "word"),
    [
        ([[*p[:2], 2.5] for p in SQUARE], [("quad", [[0, 1, 2, 3]])], "z = 2.5"),
        (SQUARE, [("triangle", [[0, 1, 2], [0, 2, 3], [2, 3, 0]])], "1 cell given a second time"),
        (SQUARE, [("quad", [[0, 1, 2, 2], [0, 2, 3, 3]])], "2 cells with one point several times"),
        (SQUARE, [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 2, 2]])], "fewer than three different points"),
    ],
)
def test_small_faults_are_mended_with_a_notice(tmp_path, points, cells, word):
    """A height that is the same everywhere, cells given twice, repeated and collapsed points still make the square."""
    read = read_mesh(written(tmp_path / "a.vtu", points, cells))
    assert read.mesh.cell_areas.sum() == 1.0
    assert any(word in notice for notice in read.notices)


@pytest.mark.parametrize(
    ("name", "content", "word"),
    [
        ("a.msh", b"", "empty"),
        ("a.vtu", b"<VTKFile type='UnstructuredGrid'><UnstructuredGrid/></VTKFile>", "No Piece"),
        ("a.inp", b"\x00\x01\x02", "binary"),
        ("a.inp", b"*HEADING\nno mesh", r"without \*NODE"),
        ("a.inp", b"*NODE\n1, 0, 0\n*NGEN\n1, 5\n", "NGEN in line 3"),
        ("a.inp", b"*INSTANCE, PART=a\n0., 1.\n", "moved"),
        (
            "a.inp",
            b"*PART, NAME=a\n*NODE\n1, 0, 0\n2, 1, 0\n*ELEMENT, TYPE=CPE3\n1, 1, 2\n*END PART\n"
            b"*ASSEMBLY\n*INSTANCE, NAME=b, PART=a\n*END INSTANCE\n*END ASSEMBLY\n",
            "ELEMENT in line 5",
        ),
        ("a.inp", b"*NODE\n1, 0, 0\n*NSET, NSET=a, GENERATE\n1\n", "first, last and step"),
    ],
)
def test_broken_files_are_refused(tmp_path, capfd, name, content, word):
    """Missing, empty, unknown, truncated and wrong files end in an InputError, and nothing is printed."""
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(InputError, match=word):
        read_mesh(file)
    assert capfd.readouterr() == ("", "")


KINDS = ("gmsh22", "gmsh", "vtk42", "vtk", "vtu", "medit", "off", "nastran", "abaqus")
ENDINGS = {"gmsh22": "msh", "gmsh": "msh", "vtk42": "vtk", "medit": "mesh", "nastran": "bdf", "abaqus": "inp"}


@functools.cache
def sound_mesh(kind):
    """Bytes of a sound file of some cells."""
    if kind == "abaqus":
        return ABAQUS.encode()
    mesh = rectangle_grid(2.0, 1.0, 3, 2)
    points = np.column_stack([mesh.points, np.zeros(mesh.n_points)])
    drawn = meshio.Mesh(points, [("triangle", mesh.cell_points.reshape(-1, 3)), ("line", mesh.edge_set("top"))])
    if kind in ("off", "vtk42", "vtk", "gmsh"):
        drawn = meshio.Mesh(points, drawn.cells[:1])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "a"
        drawn.write(file, file_format=kind, **({} if kind in ("medit", "off", "nastran") else {"binary": False}))
        return file.read_bytes()


@settings(suppress_health_check=list(HealthCheck))
@given(
    kind=st.sampled_from(KINDS),
    changes=st.lists(
        st.tuples(st.floats(0.0, 1.0), st.sampled_from([*b"0123456789.-+eE,; \n$*<>nx"]), st.integers(0, 30)),
        min_size=1,
        max_size=4,
    ),
)
def test_damaged_meshes_are_read_or_refused(tmp_path, kind, changes):
    """Sound files with bytes changed, put in or cut out give a mesh of positive cells or an InputError."""
    content = bytearray(sound_mesh(kind))
    for place, byte, cut in changes:
        i = int(place * (len(content) - 1))
        content[i : i + cut] = bytes([byte])
    file = tmp_path / f"damaged.{ENDINGS.get(kind, kind)}"
    file.write_bytes(content)
    mesh, refused = None, None
    try:
        mesh = read_mesh(file).mesh
    except InputError as reason:
        refused = reason
    if mesh is None:
        assert str(file) in refused.given
        return
    assert np.isfinite(mesh.points).all()
    assert (mesh.cell_areas > 0.0).all()


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Arc((1.0, 0.0), (0.0, 1.0), (0.0, 0.0)), "counter_clockwise"),
        (lambda: Arc((1.0, 0.0), (0.0, 1.0), (0.0, 0.0), 1), "counter_clockwise"),
        *((lambda p=p: Line(p, (5.0, 5.0)), "numbers") for p in [("0", "1"), (True, 1.0), (1j, 0.0)]),
        *(
            (lambda p=p: PolyMesh([p, (1.0, 0.0), (0.0, 1.0)], [0, 3], [0, 1, 2]), "numbers")
            for p in [("0", "1"), (True, 1.0), (1j, 0.0)]
        ),
    ],
)
def test_arcs_have_a_direction_and_points_numbers(make, word):
    """A direction left out, or no truth value; texts, truth values and complex numbers, in segments and in meshes."""
    with pytest.raises(InputError, match=word):
        make()


@pytest.mark.parametrize(("row", "line"), [("4, 0.0, oops", 6), ("2, 0.0, 1.0", 6)])
def test_a_wrong_node_is_named_with_its_own_line(tmp_path, row, line):
    """A wrong entry of a block of nodes is found at its own line, comments counted."""
    file = tmp_path / "a.inp"
    rows = ["*NODE", "1, 0., 0.", "2, 1., 0.", "** corner", "3, 1., 1.", row, "*ELEMENT, TYPE=CPS4", "1, 1, 2, 3, 4"]
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=f"line {line} in the block of .NODE in line 1"):
        read_mesh(file)
    part = ["*PART, NAME=p", *rows, "*END PART", "*ASSEMBLY, NAME=a", "*INSTANCE, NAME=i, PART=p", "2., 0., 0."]
    file.write_text("\n".join([*part, "*END INSTANCE", "*END ASSEMBLY"]) + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=f"line {line + 1} in the block of .NODE in line 2"):
        read_mesh(file)


@pytest.mark.parametrize("size", [1.0, 1e-4])
@pytest.mark.parametrize("gap", [0.0, 9e-7, -9e-7])
def test_reading_joins_what_a_space_refuses(tmp_path, gap, size):
    """Points that touch within the tolerance of the check are joined with a notice; those beyond it stay apart.

    The tolerance is 1e-6 of the sides, and 1e-9 of the mesh where sides are short.
    """
    square = rectangle_grid(size, size, 2, 2)
    for distance, n_points in ((0.5 * gap * size, 15), (max(4e-6 * size, 2.4e-8), 18)):
        both = square.merged(square.placed(Placement(0.0, (size + distance, 0.3 * distance))))
        far = rectangle_grid(1.0, 1.0, 1, 1).placed(Placement(0.0, (5.0, 0.0)))
        write_vtu(tmp_path / "two.vtu", both.merged(far))
        read = read_mesh(tmp_path / "two.vtu")
        assert read.mesh.n_points == n_points + 4
        assert sum("made one" in notice for notice in read.notices) == (n_points == 15)
        Space(read.mesh, Virtual(1))


def test_cell_sets_of_one_body_are_joined(tmp_path):
    """Blocks with points of their own at one place, named together as one body of a case, are one body."""
    x, lines = [0.0, 1.0, 1.0 + 3e-7, 2.0], ["*NODE"]
    lines += [f"{4 * j + i + 1}, {x[i]:.9f}, {j}.0" for j in (0, 1) for i in range(4)]
    lines += ["*ELEMENT, TYPE=CPE4, ELSET=ONE", "1, 1, 2, 6, 5", "*ELEMENT, TYPE=CPE4, ELSET=OTHER", "2, 3, 4, 8, 7"]
    lines += ["*NSET, NSET=BASE", "1, 2, 3, 4"]
    (tmp_path / "a.inp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    notices: list[str] = []
    table = BodyTable(name="a", file=str(tmp_path / "a.inp"), cells=["ONE", "OTHER"], method="vem")
    mesh = body_shape(table, "bodies.1", notices).mesh
    assert (mesh.n_points, mesh.n_cells) == (6, 2)
    assert len(mesh.edge_set("BASE")) == 2
    assert set(mesh.cell_sets) == {"ONE", "OTHER"}
    assert any("made one" in notice for notice in notices)
    Space(mesh, Virtual(1))
