"""Sets and curved sides of meshes in files: numbers of materials, what `write_vtu` keeps, sides of second order."""

import math

import gmsh
import meshio
import numpy as np
import pytest

from flangeway.cases import find_case
from flangeway.errors import InputError
from flangeway.formats import read_mesh, write_vtu
from flangeway.geometry import circle
from flangeway.mesh import PolyMesh, curved, dual, triangulate
from flangeway.mesh.structured import rectangle_grid
from flangeway.problems.body_records import body_shape

SQUARES = [[0, 1, 4, 3], [1, 2, 5, 4]]
POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]])


@pytest.mark.parametrize(
    ("ending", "array", "names"),
    [
        (".mesh", "medit:ref", ["3", "7"]),
        (".vtk", "material", ["material_3", "material_7"]),
        (".vtu", "material", ["material_3", "material_7"]),
        (".vtu", "gmsh:physical", ["3", "7"]),
    ],
)
def test_numbers_of_materials_become_cell_sets(tmp_path, ending, array, names):
    """Two squares with the numbers 7 and 3 are two cell sets, in the files of three formats that meshio writes."""
    file = tmp_path / f"two{ending}"
    meshio.Mesh(POINTS, [("quad", SQUARES)], cell_data={array: [np.array([7, 3])]}).write(file)
    mesh = read_mesh(file).mesh
    assert {name: mesh.cell_sets[name].tolist() for name in sorted(mesh.cell_sets)} == {names[0]: [1], names[1]: [0]}


def test_references_of_lines_become_edge_sets(tmp_path):
    """Edges of a Medit file with a reference are an edge set of its number."""
    blocks = [("quad", np.array(SQUARES)), ("line", np.array([[0, 1], [1, 2], [5, 2]]))]
    numbers = {"medit:ref": [np.array([1, 1]), np.array([4, 4, 9])]}
    meshio.Mesh(POINTS[:, :2], blocks, cell_data=numbers).write(tmp_path / "two.mesh")
    mesh = read_mesh(tmp_path / "two.mesh").mesh
    assert {name: len(pairs) for name, pairs in mesh.edge_sets.items()} == {"4": 2, "9": 1}


def mesh_with_sets(seed):
    rng = np.random.default_rng(seed)
    mesh = [
        lambda: rectangle_grid(3.0, 2.0, 5, 4),
        lambda: triangulate(circle(2.0), size=0.7),
        lambda: dual(triangulate(circle(2.0), size=0.7)),
        lambda: curved(triangulate(circle(2.0), size=0.7), circle(2.0)),
    ][seed % 4]()
    for name in ("steel & <größe>", "part 2", "all"):
        mesh = mesh.with_cell_set(name, rng.random(mesh.n_cells) < rng.choice([0.1, 0.5, 1.0]))
    for name in ('"left"', "rim'"):
        edges = mesh.boundary_edges
        mesh = mesh.with_edge_set(name, edges[rng.random(len(edges)) < 0.5])
    return mesh


def ends(mesh, name):
    return np.sort(np.sort(mesh.points[mesh.edge_sets[name]].round(9).view(complex)[..., 0], axis=1), axis=0)


@pytest.mark.parametrize("corners", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_what_is_written_has_its_sets_when_it_is_read(tmp_path, seed, corners):
    """Every cell set and edge set of a written mesh is there again, with points of its own for each cell too."""
    mesh = mesh_with_sets(seed)
    data = {"field": np.arange(len(mesh.cell_points), dtype=float)} if corners else None
    write_vtu(tmp_path / "mesh.vtu", mesh, corner_data=data)
    read = read_mesh(tmp_path / "mesh.vtu").mesh
    sets = {name: cells.tolist() for name, cells in mesh.cell_sets.items() if len(cells)}
    assert {name: cells.tolist() for name, cells in read.cell_sets.items()} == sets
    assert set(read.edge_sets) == set(mesh.edge_sets)
    if mesh.curves is None:
        for name in mesh.edge_sets:
            assert np.array_equal(ends(mesh, name), ends(read, name))
    lengths = [
        sum(np.linalg.norm(np.diff(m.points[pairs], axis=1)[:, 0], axis=1).sum() for pairs in m.edge_sets.values())
        for m in (mesh, read)
    ]
    assert lengths[1] == pytest.approx(lengths[0], rel=1e-9 if mesh.curves is None else 0.05)


@pytest.fixture
def drawn_by_gmsh(tmp_path):
    """Write a disc of radius 2 about (1, 0), in two named halves, in a version and order of Gmsh."""

    def write(version, order):
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        geo, file = gmsh.model.occ, tmp_path / f"disc_{version}_{order}.msh"
        disc, half = geo.addDisk(1, 0, 0, 2, 2), geo.addRectangle(-1, -2, 0, 4, 2)
        pieces, _ = geo.fragment([(2, disc)], [(2, half)])
        geo.synchronize()
        inside = [tag for _, tag in pieces if max(gmsh.model.getBoundingBox(2, tag)[4] for _ in (0,)) < 2.5]
        inside = [tag for tag in inside if abs(gmsh.model.occ.getCenterOfMass(2, tag)[0] - 1) < 0.1]
        upper = [tag for tag in inside if gmsh.model.occ.getCenterOfMass(2, tag)[1] > 0.5]
        lower = [tag for tag in inside if -1.0 < gmsh.model.occ.getCenterOfMass(2, tag)[1] < -0.5]
        gmsh.model.addPhysicalGroup(2, upper, 5, "upper half")
        gmsh.model.addPhysicalGroup(2, lower, 6)
        rim = [tag for _, tag in gmsh.model.getBoundary([(2, tag) for tag in upper], oriented=False)]
        gmsh.model.addPhysicalGroup(1, rim, 5, "rim of it")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.7)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(file))
        gmsh.finalize()
        return file

    return write


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("version", [2.2, 4.0, 4.1])
def test_versions_of_gmsh_are_the_same_mesh(drawn_by_gmsh, version, order):
    """The versions 2.2, 4.0 and 4.1 give the same cells and groups; sides of second order have the disc's area."""
    mesh = read_mesh(drawn_by_gmsh(version, order)).mesh
    halves = [mesh.cell_areas[mesh.cell_set(name)].sum() for name in ("upper half", "6")]
    assert halves == pytest.approx([2.0 * math.pi] * 2, rel=1e-7 if order == 2 else 0.05)
    assert "rim of it" in mesh.edge_sets


def quadratic_ring(inner, outer, n, turn=0.0, kind="triangle6"):
    """Points and cells of second order of a ring about the origin, their middles on circles."""
    angles = turn + math.pi * np.arange(2 * n) / n
    middle = (inner + outer) / 2.0
    points = np.vstack(
        [radius * np.column_stack((np.cos(angles), np.sin(angles))) for radius in (inner, middle, outer)]
    )

    def at(level, step):
        return level * 2 * n + step % (2 * n)

    cells = []
    for k in range(0, 2 * n, 2):
        corners = [at(0, k), at(2, k), at(2, k + 2), at(0, k + 2)]
        if kind == "quad8":
            cells.append([*corners, at(1, k), at(2, k + 1), at(1, k + 2), at(0, k + 1)])
        elif kind == "quad9":
            cells.append([*corners, at(1, k), at(2, k + 1), at(1, k + 2), at(0, k + 1), at(1, k + 1)])
        else:
            a, b, c, d = corners
            cells += [
                [a, b, c, at(1, k), at(2, k + 1), at(1, k + 1)],
                [a, c, d, at(1, k + 1), at(1, k + 2), at(0, k + 1)],
            ]
    return points, np.array(cells)


@pytest.mark.parametrize("kind", ["triangle6", "quad8", "quad9"])
@pytest.mark.parametrize("ending", [".vtu", ".vtk", ".msh", ".inp"])
def test_sides_of_second_order_are_arcs(tmp_path, kind, ending):
    """A ring of eight cells around has the area of its circles to rounding, where sides of chords miss ten per cent."""
    points, cells = quadratic_ring(1.0, 2.0, 8, kind=kind)
    file = tmp_path / f"ring{ending}"
    if ending == ".inp":
        name = {"triangle6": "CPE6", "quad8": "CPS8", "quad9": "M3D9"}[kind]
        rows = [f"{n}, {x:.17g}, {y:.17g}" for n, (x, y) in enumerate(points, 1)]
        elements = [", ".join(map(str, [n, *(cell + 1)])) for n, cell in enumerate(cells, 1)]
        file.write_text("\n".join(["*NODE", *rows, f"*ELEMENT, TYPE={name}", *elements]))
    else:
        space = np.column_stack((points, np.zeros(len(points))))
        meshio.Mesh(space, [(kind, cells)]).write(file, file_format="gmsh" if ending == ".msh" else None)
    mesh = read_mesh(file).mesh
    assert mesh.cell_areas.sum() == pytest.approx(3.0 * math.pi, rel=1e-6)
    assert mesh.straight().cell_areas.sum() < 2.8 * math.pi


def deck(tmp_path, bodies):
    """An Abaqus deck of several bodies, an element set each."""
    nodes, elements, n_nodes, n_elements = [], [], 0, 0
    for name, (points, cells) in bodies.items():
        nodes += [f"{n_nodes + n}, {x:.17g}, {y:.17g}" for n, (x, y) in enumerate(points, 1)]
        kind = {4: "CPE4", 6: "CPE6", 8: "CPE8"}[cells.shape[1]]
        elements.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        elements += [", ".join(map(str, [n_elements + n, *(n_nodes + 1 + cell)])) for n, cell in enumerate(cells, 1)]
        n_nodes, n_elements = n_nodes + len(points), n_elements + len(cells)
    file = tmp_path / "deck.inp"
    file.write_text("\n".join(["*NODE", *nodes, *elements]))
    return file


@pytest.mark.parametrize("turn", [0.0, 0.1, 0.2])
def test_rings_whose_chords_cross_are_two_bodies(tmp_path, turn):
    """A shaft in a hub with a thin gap, or none, or an interference, is read for any turn; each has its area."""
    for gap in (1e-3, 0.0, -1e-3):
        bodies = {"SHAFT": quadratic_ring(1.0, 2.0, 8), "HUB": quadratic_ring(2.0 + gap, 3.0, 8, turn)}
        read = read_mesh(deck(tmp_path, bodies), merge_points=False)
        for name, (inner, outer) in {"SHAFT": (1.0, 2.0), "HUB": (2.0 + gap, 3.0)}.items():
            body = read.part(name).mesh
            assert body.cell_areas.sum() == pytest.approx(math.pi * (outer**2 - inner**2), rel=1e-6)
            assert body.curves is not None


def test_a_body_that_overlaps_itself_is_refused(tmp_path):
    """Squares that lie on each other are two bodies, but not one."""
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), np.array([[0, 1, 2, 3]])
    other = square[0] * 1.1 + 0.3, square[1]
    file = deck(tmp_path, {"ONE": square, "OTHER": other})
    read = read_mesh(file, merge_points=False)
    assert [read.part(name).mesh.n_cells for name in ("ONE", "OTHER")] == [1, 1]
    with pytest.raises(InputError, match="cross"):
        read.part("ONE", "OTHER")
    with pytest.raises(InputError, match="cross"):
        read_mesh(file)


def sets_of(text, tmp_path):
    file = tmp_path / "deck.inp"
    grid = "*NODE\n1,0,0\n2,1,0\n3,2,0\n4,0,1\n5,1,1\n6,2,1\n*ELEMENT,TYPE=CPE4\n1,1,2,5,4\n2,2,3,6,5\n"
    file.write_text(grid + text)
    return read_mesh(file)


@pytest.mark.parametrize("words", ["1.0, 2.0", "1., 2.", "1, 2.00", "+1, 2"])
def test_sets_of_decimals_are_sets(tmp_path, words):
    """An element set written as 1.0, 2.0 has both elements."""
    assert sets_of(f"*ELSET, ELSET=G\n{words}\n", tmp_path).mesh.cell_sets["G"].tolist() == [0, 1]


@pytest.mark.parametrize("words", ["1.5, 2", "1e0, 2", "1_0", "x, 2", "0x1"])
def test_sets_of_other_words_are_refused(tmp_path, words):
    """What is neither a whole number nor a set is refused."""
    with pytest.raises(InputError, match=r"\*ELSET"):
        sets_of(f"*ELSET, ELSET=G\n{words}\n", tmp_path)


def test_numbers_of_no_element_are_reported(tmp_path):
    """A set that names elements of which there are none says how many, and has the others."""
    read = sets_of("*ELSET, ELSET=G, GENERATE\n1, 9\n*NSET, NSET=N\n77\n", tmp_path)
    assert read.mesh.cell_sets["G"].tolist() == [0, 1]
    assert any("7 of 9" in notice for notice in read.notices)
    assert any("1 of 1" in notice for notice in read.notices)


def test_coordinates_have_no_underscores(tmp_path):
    """6_0 is no number."""
    with pytest.raises(InputError, match="a number and coordinates"):
        sets_of("*NODE\n7, 6_0.0, 0.0\n", tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "*ELSET, ELSET=G, GENERATE\n1, 6000000000\n",
        "*ELSET, ELSET=G, GENERATE\n1, 999999999999999999, 2\n",
        "*NSET, NSET=G, GENERATE\n-6000000000, 1\n",
        "*ELSET, ELSET=G0, GENERATE\n1, 1000\n"
        + "".join(f"*ELSET, ELSET=G{n}\n" + f"G{n - 1}\n" * 10 for n in range(1, 30)),
    ],
)
def test_sets_are_bounded_before_they_are_made(tmp_path, text):
    """Ranges of thousands of millions, and sets of sets of sets, are refused at once."""
    with pytest.raises(InputError, match="numbers"):
        sets_of(text, tmp_path)


def test_a_polygon_with_curves_keeps_them_as_a_part(tmp_path):
    """Placed in inches, a curved ring of a file is a body whose area is that of its circles in mm."""
    file = deck(tmp_path, {"RING": quadratic_ring(1.0, 2.0, 8)})
    case = find_case("two-bodies").from_values(
        {
            "bodies": [{"name": "ring", "file": str(file), "cells": "RING", "unit": "in", "method": "vem"}],
            "loads": [{"body": "ring", "force_N": [0.0, 1.0], "edges": "outer"}],
        }
    )
    mesh: PolyMesh = body_shape(case.bodies[0], "bodies[1]", []).mesh
    assert mesh.cell_areas.sum() == pytest.approx(3.0 * math.pi * 25.4**2, rel=1e-6)
