"""Wrong points, arcs and decks end in errors that name them."""

import pytest

from flangeway.cases.bodies.bodies_shape import body_shape
from flangeway.cases.bodies.bodies_tables import BodyTable
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.formats import read_mesh, write_vtu
from flangeway.geometry import Arc, Line, Placement
from flangeway.mesh import PolyMesh, rectangle_grid
from flangeway.space import Space


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
        assert ["made one" in notice for notice in read.notices] == [True] * (n_points == 15)
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
