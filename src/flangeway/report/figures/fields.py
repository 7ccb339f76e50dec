"""Displacements and stresses of the parts in the axes of space, for pictures and files."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from flangeway.geometry import Placement
from flangeway.mesh import PolyMesh
from flangeway.post import Stresses, cell_stresses
from flangeway.problems import ElasticField
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.series import placed_stresses, solution_frame, write_frame
from flangeway.report.figures.stress_picture import DrawnBody
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class PartFields:
    """One part at its final position in space.

    Parameters
    ----------
    name
        Name of the part: ``wheel-left`` and so on.
    side
        Side of the track.
    mesh
        Undeformed mesh at the part's final place; a mirrored part is mirrored.
    touch_points
        The mesh's points when the wheelset first touches the rails, shape (n_points, 2).
    displacement
        Elastic displacement of the points, axes of space, shape (n_points, 2). A wheel's rigid motion is not in it:
        that is in its place.
    stresses
        Mean stresses of the cells, axes of space.

    """

    name: str
    side: Side
    mesh: PolyMesh
    touch_points: Floats
    displacement: Floats
    stresses: Stresses


def part_fields(result: WheelsetResult) -> Iterator[PartFields]:
    """Fields of every part: left side first, wheels before rails."""
    at_touch = _at_touch(result)
    for name, part in result.model.parts.items():
        placement, mesh = result.placements[name], part.body.space.mesh
        displacement = result.displacements[name]
        yield PartFields(
            name,
            "left" if name.endswith("left") else "right",
            mesh.placed(placement),
            at_touch[name].points(mesh.points),
            placement.vectors(displacement[: mesh.n_points]),
            placed_stresses(cell_stresses(part.body.elasticity, displacement), placement),
        )


def _at_touch(result: WheelsetResult) -> dict[str, Placement]:
    """Placements of the parts when the wheelset first touches the rails."""
    model = result.model
    names = (part.name for part in model.system.parts)
    return dict(zip(names, model.placements(model.rigid_position), strict=True))


def drawn_parts(result: WheelsetResult, side: Side, factor: float = 1.0) -> dict[str, DrawnBody]:
    """Wheel and rail of a side by their names, all motion since first touch multiplied by a factor."""
    at_touch = _at_touch(result)

    def placed(name: str, points: Floats, moved: Floats) -> Floats:
        start: Floats = at_touch[name].points(points)
        return start + factor * (result.placements[name].points(points + moved) - start)

    return {
        name: DrawnBody(ElasticField(part.body.elasticity, result.displacements[name]), partial(placed, name))
        for name, part in result.model.parts.items()
        if name.endswith(side)
    }


def write_part(path: Path, result: WheelsetResult, name: str) -> None:
    """Write one part at its final position in space; the arrays are those of `field_arrays`.

    Displacements are elastic: a wheel's rigid displacement is in its position, so "Warp By Vector" with factor 1 shows
    the parts as they touch.
    """
    body, displacement = result.model.parts[name].body, result.displacements[name]
    field = ElasticField(body.elasticity, displacement)
    frame = solution_frame(field, part=name, unit="MPa", length_unit="mm", placement=result.placements[name])
    write_frame(path, frame, list(result.model.parts).index(name))
