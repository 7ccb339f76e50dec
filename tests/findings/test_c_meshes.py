"""Wrong points, arcs and decks end in errors that name them."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import Arc, Line
from flangeway.mesh import PolyMesh, read_mesh, rectangle_grid


@pytest.mark.parametrize("direction", [None, "left", 1, 0.0])
def test_c_an_arc_without_direction_is_refused(direction):
    """An arc whose direction is left out, or is no truth value, is an input error."""
    with pytest.raises(InputError, match="counter_clockwise"):
        Arc((1.0, 0.0), (0.0, 1.0), (0.0, 0.0), direction)
    with pytest.raises(InputError, match="counter_clockwise"):
        Arc((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))


@pytest.mark.parametrize("point", [("0", "1"), (True, False), (True, 1.0), (None, 1.0), (1j, 0.0), "ab"])
def test_c_coordinates_are_numbers(point):
    """Texts, truth values and complex numbers are no coordinates, in segments and in meshes."""
    with pytest.raises(InputError, match="numbers"):
        Line(point, (5.0, 5.0))
    with pytest.raises(InputError, match="numbers"):
        PolyMesh([point, (1.0, 0.0), (0.0, 1.0)], [0, 3], [0, 1, 2])


@pytest.mark.parametrize(("row", "line"), [("4, 0.0, oops", 6), ("x, 0.0, 1.0", 6), ("4, 0.0", 6), ("2, 0.0, 1.0", 6)])
def test_c_a_wrong_node_is_named_with_its_own_line(tmp_path, row, line):
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


def test_c_messages_write_places_as_numbers():
    """Messages of meshes write points as numbers between parentheses, not as objects of Python or NumPy."""
    grid = rectangle_grid(2.0, 1.0, 2, 1)
    for wrong in ([[0, 2]], [[1, 4]]):
        with pytest.raises(InputError) as caught:
            grid.with_edge_set("a", np.array(wrong))
        assert "[" not in str(caught.value)
        assert "np." not in str(caught.value)
        assert "near (" in str(caught.value)
