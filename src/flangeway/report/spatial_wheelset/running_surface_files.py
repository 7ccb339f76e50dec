"""Files of a wheelset in three dimensions: surfaces for ParaView, patches and stresses below them as tables."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from flangeway.cases.summary import ENDINGS
from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetRun
from flangeway.cases.wheelset.spatial_wheelset_summary import WheelPatchSummary
from flangeway.formats import write_vtu
from flangeway.mesh import PolyMesh
from flangeway.railway.spatial.side_contact import SideState
from flangeway.railway.spatial.spatial_result import SpatialResult
from flangeway.railway.spatial.wheel_gap import FAR_MM, wheel_gap
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDE_SIGN, Side
from flangeway.report.spatial.patch_map import surface_mesh
from flangeway.report.spatial_wheelset.wheelset_patches import lines_below
from flangeway.results import ResultTable
from flangeway.types import Bools, Floats

PARTS: tuple[tuple[Side, Role], ...] = tuple((side, role) for role in ROLES for side in ("left", "right"))
DIGITS = 6


def write_surface(result: SpatialResult, side: Side, role: Role, path: Path) -> None:
    """Write pressure and gap on the running surface of a rail, or where the wheel is opposite to it.

    The points are in the track's axes, z ahead of the axle: the rail's as it is bent, the wheel's in its place, both
    without the indentation at the contact. The gap is nan where no wheel is opposite.
    """
    state = result.equilibrium.state.sides[side]
    nodes, z, mesh = surface_mesh(state.cells)
    on_rail, on_wheel, met = _corners(state, nodes, z)
    places = on_wheel if role == "wheel" else on_rail
    places[..., 0] *= SIDE_SIGN[side]
    corners = mesh.cell_points.reshape(-1, 4)
    opposite = met.ravel()[corners].all(axis=1)
    chosen = opposite if role == "wheel" else np.ones_like(opposite)
    used, numbers = np.unique(corners[chosen], return_inverse=True)
    offsets = 4 * np.arange(chosen.sum() + 1, dtype=np.int32)
    mesh = PolyMesh(mesh.points[used], offsets, numbers.ravel().astype(np.int32))
    gaps = np.where(opposite, state.gaps.ravel(), np.nan)
    values = {"pressure_MPa": state.cells.pressures.ravel(), "gap_mm": gaps}
    arrays = {key: np.repeat(each[chosen], 4) for key, each in values.items()}
    write_vtu(path, mesh, corner_data=arrays, positions=places.reshape(-1, 3)[used], body_id=PARTS.index((side, role)))


def _corners(state: SideState, nodes: Floats, z: Floats) -> tuple[Floats, Floats, Bools]:
    """Points of rail and wheel at the corners of cells, each (k, m, 3), and where the wheel is opposite, (k, m)."""
    surfaces, stations = state.grid.surfaces, state.grid.grid.stations
    points, normals = surfaces.rail_points(nodes)
    moved = state.points - surfaces.rail_points(stations)[0]
    points = points + np.stack([np.interp(nodes, stations, moved[:, axis]) for axis in (0, 1)], axis=1)
    gap = wheel_gap(surfaces.wheel, state.pose.middle, state.pose.axis, points, normals, z)
    rail = np.concatenate(
        (np.repeat(points[:, None], len(z), axis=1), np.tile(z[:, None], (len(nodes), 1, 1))), axis=-1
    )
    wheel = gap.arms + np.append(state.pose.middle, 0.0)
    return rail, wheel, gap.gaps < FAR_MM


def patches_table(patches: Sequence[WheelPatchSummary]) -> str:
    """Return the numbers of all patches as CSV, a row each; empty where there is no number."""
    return ResultTable.of_rows([asdict(patch) for patch in patches], ENDINGS).csv(DIGITS)


def below_table(run: SpatialWheelsetRun) -> str:
    """Return the stresses on the normals below the centres of pressure as CSV, a row for each depth."""
    rows: list[dict[str, object]] = []
    for patch, role in lines_below(run.result):
        line = patch.below(role)
        where = {"side": patch.side, "region": patch.region, "body": role}
        columns = ResultTable({"depth_mm": line.depths, **line.stresses.by_name})
        rows += [{**where, **dict(zip(columns.columns, row, strict=True))} for row in columns.rows()]
    return ResultTable.of_rows(rows).csv(DIGITS)
