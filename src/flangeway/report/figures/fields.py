"""Displacements and stresses of the parts in the axes of space, for pictures and files."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flangeway.mesh import PolyMesh
from flangeway.post import Stresses, cell_stresses
from flangeway.problems import ElasticField
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.wheelset_checks import above_the_web
from flangeway.railway.wheelset.wheelset_result import WheelsetResult
from flangeway.report.figures.series import placed_stresses, solution_frame, write_frame
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
    above_web
        Cells above a rail's web, (n_cells,), where the stresses of a slice may be believed; None: all of them.

    """

    name: str
    side: Side
    mesh: PolyMesh
    touch_points: Floats
    displacement: Floats
    stresses: Stresses
    above_web: NDArray[np.bool_] | None = None

    def points(self, factor: float = 1.0) -> Floats:
        """Points with all motion since first touch, rigid and elastic, multiplied by a factor."""
        motion = self.mesh.points + self.displacement - self.touch_points
        moved: Floats = self.touch_points + factor * motion
        return moved

    def at_points(self, cell_values: Floats) -> Floats:
        """Means of cells' values (n_cells,) about each point, weighted by area, shape (n_points,)."""
        mesh = self.mesh
        weights = np.repeat(mesh.cell_areas, mesh.cell_sizes)
        values = np.repeat(cell_values, mesh.cell_sizes)
        total = np.bincount(mesh.cell_points, weights, minlength=mesh.n_points)
        sums = np.bincount(mesh.cell_points, weights * values, minlength=mesh.n_points)
        means: Floats = sums / total
        return means


def part_fields(result: WheelsetResult) -> Iterator[PartFields]:
    """Fields of every part: left side first, wheels before rails."""
    model = result.model
    at_touch = dict(
        zip((part.name for part in model.system.parts), model.placements(model.rigid_position), strict=True)
    )
    for name, part in model.parts.items():
        placement, mesh = result.placements[name], part.body.space.mesh
        displacement = result.displacements[name]
        yield PartFields(
            name,
            "left" if name.endswith("left") else "right",
            mesh.placed(placement),
            at_touch[name].points(mesh.points),
            placement.vectors(displacement[: mesh.n_points]),
            placed_stresses(cell_stresses(part.body.elasticity, displacement), placement),
            above_the_web(model, name),
        )


def write_part(path: Path, result: WheelsetResult, name: str) -> None:
    """Write one part at its final position in space; the arrays are those of `field_arrays`.

    Displacements are elastic: a wheel's rigid displacement is in its position, so "Warp By Vector" with factor 1 shows
    the parts as they touch.
    """
    body, displacement = result.model.parts[name].body, result.displacements[name]
    field = ElasticField(body.elasticity, displacement)
    frame = solution_frame(field, part=name, unit="MPa", length_unit="mm", placement=result.placements[name])
    write_frame(path, frame, list(result.model.parts).index(name))
