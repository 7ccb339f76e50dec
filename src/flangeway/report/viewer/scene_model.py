"""What the viewer shows: parts with their arrays, fields made of these, and places to fly to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from flangeway.mesh import PolyMesh
from flangeway.types import Floats, Ints

Formula = Literal[
    "value", "x", "y", "magnitude",
    "von-mises", "principal-1", "principal-2", "principal-3", "in-plane-shear", "xx", "yy", "xy", "zz",
]  # fmt: skip
"""How a value follows from the components of its array: one number, a vector x, y, or stresses xx, yy, xy, zz."""

DISPLACEMENT = "displacement"
"""Name of the array that deforms the picture."""


@dataclass(frozen=True)
class ShownField:
    """A field to choose.

    Parameters
    ----------
    key
        Name of the field, that of its array in the VTU file where it has one; of a component with ``:x`` or ``:y``
        behind.
    name
        What readers see.
    unit
        Unit of the values.
    group
        Heading in the list of fields.
    array
        Name of the array of each part that it is made of.
    formula
        How.

    """

    key: str
    name: str
    unit: str
    group: str
    array: str
    formula: Formula


@dataclass(frozen=True, eq=False)
class ShownPart:
    """A part as the viewer draws it; points and cells have the numbers of its VTU file.

    Parameters
    ----------
    name
        Name of the part.
    mesh
        The cells that are drawn.
    point_arrays
        Arrays (n_points, n_components) by name, or (n_steps, n_points, n_components);
        ``displacement``, with 2 components, deforms the picture.
    cell_arrays
        Arrays (n_cells, n_components) by name, or (n_steps, n_cells, n_components).
    side
        Name of the group that the part stands with; the viewer can bring groups together.
    approach
        Rigid motion (n_points, 2) that brought the points where the mesh has them and is drawn as part of the
        deformation; none if left out.
    places
        Number of each point's place, shape (n_points,), where cells have points of their own, so that values may jump;
        as many places as numbers.
    n_rim_places
        The places below this number lie on the rims of the problem's cells, the others inside; all if left out.
    cells
        Number of the problem's cell that each cell is a piece of, shape (n_cells,), if they are pieces.
    heights
        Heights of the points over the plane of the picture, shape (n_points,); with any the picture can be turned.

    """

    name: str
    mesh: PolyMesh
    point_arrays: Mapping[str, Floats] = field(default_factory=dict)
    cell_arrays: Mapping[str, Floats] = field(default_factory=dict)
    side: str = ""
    approach: Floats | None = None
    places: Ints | None = None
    n_rim_places: int | None = None
    cells: Ints | None = None
    heights: Floats | None = None


@dataclass(frozen=True)
class View:
    """A place to which a button of the viewer flies.

    Parameters
    ----------
    name
        Text of the button.
    centre
        Middle of the view (x, y), in the axes of the parts.
    width
        Width of what is shown.

    """

    name: str
    centre: tuple[float, float]
    width: float


@dataclass(frozen=True, eq=False)
class Scene:
    """All that one viewer shows.

    Parameters
    ----------
    parts
        One part or more.
    fields
        One field or more; the first is shown first.
    views
        Places with a button each, beside the one for all parts.
    unit
        Unit of all lengths.
    notes
        Sentences on what the values are.
    steps
        Names of the steps to choose from, such as ``1 of 4: 25 %``, the last shown first; empty where there is one.
    steps_note
        Sentence on steps that are left out.
    axes
        Names of the axes of the picture, to the right and up, and of the heights.

    """

    parts: Sequence[ShownPart]
    fields: Sequence[ShownField]
    views: Sequence[View] = ()
    unit: str = "mm"
    notes: Sequence[str] = ()
    steps: Sequence[str] = ()
    steps_note: str = ""
    axes: Sequence[str] = ("x", "y")
