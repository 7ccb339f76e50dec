"""Files of a wheelset in three dimensions: surfaces and sections for ParaView, patches and lines below as tables."""

from pathlib import Path

import numpy as np

from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.contact.rolling.fastsim import SimplifiedRolling
from flangeway.contact.rolling.rolling_result import Rolling
from flangeway.formats import write_vtu, write_vtu_grids
from flangeway.mesh import PolyMesh
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDE_SIGN, Side
from flangeway.railway.wheelset.side_contact import FAR_MM, SideState, wheel_gap
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.whole_sections import WholeSection
from flangeway.report.rolling.rolling_maps import cell_fields
from flangeway.report.spatial.patch_map import at_corners, strip_mesh
from flangeway.report.wheelset.wheelset_patches import lines_below
from flangeway.results import ResultTable
from flangeway.types import Bools, Floats

PARTS: tuple[tuple[Side, Role], ...] = tuple((side, role) for role in ROLES for side in ("left", "right"))
DIGITS = 6
DEPTH = 2.0
"""Depth of the stresses that are written over the shorter semi-axis: deeper, normals of a gauge corner cross."""


def write_surface(result: SpatialResult, side: Side, role: Role, path: Path) -> None:
    """Write pressure and gap on the running surface of a rail, or where the wheel is opposite to it.

    The points are in the track's axes, z ahead of the axle: the rail's as it is bent, the wheel's in its place, both
    without the indentation at the contact. The gap is nan where no wheel is opposite. With friction also the tractions
    on this body, the slip velocity of the wheel, the frictional power over the area, and the state: 0 no contact,
    1 sticks, 2 slips.
    """
    state = result.equilibrium.state.sides[side]
    nodes, z = state.grid.grid.bounds, state.grid.grid.strip_bounds
    mesh = strip_mesh(nodes, z)
    on_rail, on_wheel, met = _corners(state, nodes, z)
    places = on_wheel if role == "wheel" else on_rail
    places[..., 0] *= SIDE_SIGN[side]
    corners = mesh.cell_points.reshape(-1, 4)
    opposite = met.ravel()[corners].all(axis=1)
    chosen = opposite if role == "wheel" else np.ones_like(opposite)
    used, numbers = np.unique(corners[chosen], return_inverse=True)
    mesh = PolyMesh.from_cells(mesh.points[used], numbers.reshape(-1, 4))
    gaps = np.where(opposite.reshape(state.gaps.shape), state.gaps, np.nan)
    values = {"pressure_MPa": state.cells.pressures, "gap_mm": gaps} | friction_fields(result, side, role)
    arrays = {key: each[np.repeat(chosen, 4)] for key, each in at_corners(values).items()}
    write_vtu(path, mesh, corner_data=arrays, positions=places.reshape(-1, 3)[used], body_id=PARTS.index((side, role)))


def write_section(section: WholeSection, side: Side, role: Role, path: Path) -> None:
    """Write displacement and stresses of a whole section of a body, each cell with points of its own.

    A rail is drawn unloaded, a wheel in its place: "Warp By Vector" shows them as they touch.
    """
    arrays = {
        "displacement_mm": section.displacement[section.mesh.cell_points],
        "stress_MPa": section.stresses.components,
        "von_mises_MPa": section.stresses.von_mises,
    }
    number = PARTS.index((side, role))
    write_vtu(path, section.mesh, corner_data=arrays, positions=section.positions, body_id=number)


def write_stresses(result: SpatialResult, side: Side, role: Role, path: Path) -> None:
    """Write the stresses in the volumes below the patches of a body, of a half-space under the tractions of all cells.

    The points are in the track's axes; components of the stress are those across (x), normal to the surface (y) and
    along the track (z) at each patch.
    """
    found = [(each, result.stress_fields[each][role]) for each in result.patches if each.side == side]
    grids: list[Floats] = []
    stresses: list[Floats] = []
    mises: list[Floats] = []
    for patch, field in found:
        # beyond the last cells the surface has no points of its own
        low, high = patch.state.grid.grid.stations[[0, -1]]
        shown = np.ix_(field.depths <= DEPTH * patch.ellipse.semi_axes[1], (field.along >= low) & (field.along <= high))
        depths, along, z = np.meshgrid(
            field.depths[shown[0].ravel()], field.along[shown[1].ravel()], field.z, indexing="ij"
        )
        grids.append(patch.points_below(role, along.ravel(), depths.ravel(), z.ravel()).reshape(*z.shape, 3))
        stresses.append(field.components[shown])
        mises.append(field.von_mises[shown])
    # seven digits are enough for stresses, and halve the files
    arrays = {
        name: [part.astype(np.float32) for part in parts]
        for name, parts in (("stress_MPa", stresses), ("von_mises_MPa", mises))
    }
    write_vtu_grids(path, grids, arrays, body_id=PARTS.index((side, role)))


def friction_fields(result: SpatialResult, side: Side, role: Role) -> dict[str, Floats]:
    """Arrays of friction on the cells of a side, (n, n_z) or vectors (n, n_z, 3); none without it."""
    state, total = result.equilibrium.state.sides[side], dict[str, Floats]()
    # directions t (across) and z of the cells in the track's axes
    axes = np.zeros((len(state.normals), 2, 3))
    axes[:, 0, :2] = np.stack((-SIDE_SIGN[side] * state.normals[:, 1], state.normals[:, 0]), axis=1)
    axes[:, 1, 2] = 1.0
    for patch in result.rolling:
        found = patch.forces
        if not isinstance(found, Rolling | SimplifiedRolling):
            continue
        for name, values in cell_fields(found, patch.speed_m_s).items():
            here = patch.patch.side == side
            whole = patch.on_side(values) if here else np.zeros((*state.forces.shape, *values.shape[2:]))
            if values.ndim > 2:
                whole = np.einsum("nma,nax->nmx", whole, axes)
            total[name] = total.get(name, 0.0) + (-whole if name == "traction_MPa" and role == "rail" else whole)
    return total


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


def below_table(run: WheelsetRun) -> str:
    """Return the stresses on the normals below the centres of pressure as CSV, a row for each depth."""
    rows: list[dict[str, object]] = []
    for patch, role in lines_below(run.space):
        line = patch.below(role, run.space.tractions_of(patch.side))
        where = {"side": patch.side, "region": patch.region, "body": role}
        columns = ResultTable({"depth_mm": line.depths, **line.stresses.by_name})
        rows += [{**where, **dict(zip(columns.columns, row, strict=True))} for row in columns.rows()]
    return ResultTable.of_rows(rows).in_units(run.case.units).csv(DIGITS)
