"""Displacements and stresses of the parts in the axes of space, for pictures and files."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from flangeway.post import cell_stresses
from flangeway.problems import ElasticField
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.series import placed_stresses, solution_frame, write_frame
from flangeway.report.figures.stress_picture import DrawnBody
from flangeway.report.viewer.scene_model import DISPLACEMENT, ShownPart
from flangeway.types import Floats


def part_fields(result: WheelsetResult) -> Iterator[ShownPart]:
    """Parts at their final places in space, left side first, wheels before rails; mirrored parts are mirrored.

    The displacements of the points are elastic, the stresses are means over the cells, both in the axes of space. The
    rigid motion of a wheel since the first touch of wheels and rails is its approach.
    """
    touches = result.model.placements(result.model.rigid_position)
    at_touch = {part.name: place for part, place in zip(result.model.system.parts, touches, strict=True)}
    for name, part in result.model.parts.items():
        placement, mesh = result.placements[name], part.body.space.mesh
        displacement = result.displacements[name]
        moved = placement.vectors(displacement[: mesh.n_points])
        stresses = placed_stresses(cell_stresses(part.body.elasticity, displacement), placement)
        placed, touch = mesh.placed(placement), at_touch[name].points(mesh.points)
        arrays = {DISPLACEMENT: moved}, {"stresses": stresses.components}
        yield ShownPart(name, placed, *arrays, side=name.rpartition("-")[2], approach=placed.points - touch)


def drawn_parts(result: WheelsetResult) -> dict[str, DrawnBody]:
    """Deformed wheels and rails by their names, where they are in the track."""

    def placed(name: str, points: Floats, moved: Floats) -> Floats:
        return result.placements[name].points(points + moved)

    return {
        name: DrawnBody(ElasticField(part.body.elasticity, result.displacements[name]), partial(placed, name))
        for name, part in result.model.parts.items()
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
