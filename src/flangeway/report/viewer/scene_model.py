"""What the viewer shows: parts with their arrays, fields made of these, and places to fly to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from flangeway.mesh import PolyMesh
from flangeway.types import Floats, Ints
from flangeway.units import Units, us_unit

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

    def in_units(self, units: Units) -> "Scene":
        """Return it in a system of units: lengths, and arrays by the unit of the fields that are made of them."""
        length = us_unit(self.unit) if units == "us" else None
        if length is None:
            return self
        of_array = {shown.array: us_unit(shown.unit) for shown in self.fields} | {DISPLACEMENT: length}

        def converted(arrays: Mapping[str, Floats]) -> dict[str, Floats]:
            return {
                name: values / (float(unit.metric) if (unit := of_array.get(name)) else 1.0)
                for name, values in arrays.items()
            }

        inch = float(length.metric)
        parts = [
            replace(
                part,
                mesh=replace(part.mesh, points=part.mesh.points / inch),
                point_arrays=converted(part.point_arrays),
                cell_arrays=converted(part.cell_arrays),
                approach=None if part.approach is None else part.approach / inch,
                heights=None if part.heights is None else part.heights / inch,
            )
            for part in self.parts
        ]
        fields = [
            replace(shown, unit=unit.name if (unit := us_unit(shown.unit)) else shown.unit) for shown in self.fields
        ]
        views = [
            View(view.name, (view.centre[0] / inch, view.centre[1] / inch), view.width / inch) for view in self.views
        ]
        return replace(self, parts=parts, fields=fields, views=views, unit=length.name)
