"""Files of a wheelset in three dimensions: surfaces, sections and volumes for ParaView, and lines below patches."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from flangeway.cases.wheelset.wheelset_case import SpatialWheelsetRun
from flangeway.formats import write_vtu, write_vtu_grids
from flangeway.mesh import PolyMesh
from flangeway.railway.track.placements import SIDE_SIGN, Side
from flangeway.railway.track.wheelset_problem import ROLES, Role
from flangeway.railway.wheelset.side_contact import FAR_MM, SideState, wheel_gap
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.railway.wheelset.supported_rail import RailAlongTrack
from flangeway.railway.wheelset.wheel_patch import WheelPatch
from flangeway.railway.wheelset.whole_sections import WholeSection
from flangeway.report.patch_maps import PatchMap, at_corners, cell_columns, cell_fields, normal_fields, strip_mesh
from flangeway.results import ResultTable
from flangeway.types import Bools, Floats

# --- What pictures and files share.


def foot_stresses(rail: RailAlongTrack) -> Floats:
    """Normal stress along the track in the middle of the base, MPa, shape (n_z,)."""
    points = rail.stresses.points_mm
    foot = np.flatnonzero(rail.stresses.regions == "foot")
    lowest = foot[points[foot, 1] <= points[foot, 1].min() + 1e-6]
    middle = lowest[np.argmin(np.abs(points[lowest, 0] - points[lowest, 0].mean()))]
    stresses: Floats = rail.stresses.along_MPa[:, middle]
    return stresses


def patch_map(result: SpatialResult, side: Side) -> PatchMap:
    """Patches of a side from above, right of the track to the right; lengths from the middle of the rail's profile."""
    state = result.equilibrium.state.sides[side]
    surfaces = state.grid.surfaces
    arcs, stations = surfaces.rail_stations.T
    at = surfaces.rail.at(arcs)
    middle = surfaces.rail_frame.inverse().points(np.stack((at.x, at.y), axis=1))[:, 0]
    patches = [patch for patch in result.patches if patch.side == side]
    return PatchMap(state.cells, patches, float(np.interp(0.0, middle, stations)), SIDE_SIGN[side])


def lines_below(result: SpatialResult) -> list[tuple[WheelPatch, Role]]:
    """Patches and the bodies below them whose stresses differ: rail and wheel have the same in one material."""
    ratios = {role: result.problem.material_of(role).poisson for role in ROLES}
    roles: tuple[Role, ...] = ("rail",) if len(set(ratios.values())) == 1 else ROLES[::-1]
    return [(patch, role) for patch in result.patches for role in roles]


# --- Files of a wheelset in three dimensions: surfaces and sections for ParaView, patches and lines below as tables.


PARTS: tuple[tuple[Side, Role], ...] = tuple((side, role) for role in ROLES for side in ("left", "right"))
DIGITS = 6
DEPTH = 2.0
"""Depth of the stresses that are written relative to the shorter semi-axis: deeper, normals of a gauge corner cross."""


def write_surface(result: SpatialResult, side: Side, role: Role, path: Path) -> None:
    """Write pressure and gap on the running surface of a rail, or where the wheel is opposite to it.

    The points are in the track's axes, z ahead of the axle: the rail's as it is bent, the wheel's in its place, both
    without the indentation at the contact. The gap is nan where no wheel is opposite. With friction also the tractions
    on this body, the slip velocity of the wheel, the frictional power per area, and the state: 0 no contact,
    1 sticks, 2 slips.
    """
    state = result.equilibrium.state.sides[side]
    nodes, z = state.grid.grid.bounds, state.grid.grid.strip_bounds
    mesh = strip_mesh(nodes, z)
    on_rail, on_wheel, met = _corners(state, nodes, z)
    positions = on_wheel if role == "wheel" else on_rail
    positions[..., 0] *= SIDE_SIGN[side]
    corners = mesh.cell_points.reshape(-1, 4)
    opposite = met.ravel()[corners].all(axis=1)
    chosen = opposite if role == "wheel" else np.ones_like(opposite)
    used, numbers = np.unique(corners[chosen], return_inverse=True)
    mesh = PolyMesh.from_cells(mesh.points[used], numbers.reshape(-1, 4))
    gaps = np.where(opposite.reshape(state.gaps.shape), state.gaps, np.nan)
    values = {"pressure_MPa": state.cells.pressures, "gap_mm": gaps} | friction_fields(result, side, role)
    arrays = {key: values[np.repeat(chosen, 4)] for key, values in at_corners(values).items()}
    write_vtu(
        path, mesh, corner_data=arrays, positions=positions.reshape(-1, 3)[used], body_id=PARTS.index((side, role))
    )


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
    stress_fields = [(patch, patch.stress_fields[role]) for patch in result.patches if patch.side == side]
    grids: list[Floats] = []
    stresses: list[Floats] = []
    mises: list[Floats] = []
    for patch, field in stress_fields:
        # a column for each row of cells, which are wider than the columns of the field, and that of the maximum
        at = np.append(patch.state.grid.grid.stations, field.max_von_mises.position[0])
        at = at[(at >= field.along[0]) & (at <= field.along[-1])]
        columns = np.unique(np.abs(field.along[:, None] - at).argmin(axis=0))
        shown = np.ix_(field.depths <= DEPTH * patch.semi_axes[1], columns)
        depths, along, z = np.meshgrid(field.depths[shown[0].ravel()], field.along[columns], field.z, indexing="ij")
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
    state = result.equilibrium.state.sides[side]
    # directions t (across) and z of the cells in the track's axes
    axes = np.zeros((len(state.normals), 2, 3))
    axes[:, 0, :2] = np.stack((-SIDE_SIGN[side] * state.normals[:, 1], state.normals[:, 0]), axis=1)
    axes[:, 1, 2] = 1.0
    fields = friction_of_cells(result, side)
    fields |= {name: np.einsum("nma,nax->nmx", values, axes) for name, values in fields.items() if values.ndim > 2}
    if role == "rail" and fields:
        fields["traction_MPa"] = -fields["traction_MPa"]
    return fields


def friction_of_cells(result: SpatialResult, side: Side) -> dict[str, Floats]:
    """Arrays of friction of the wheel on the cells of a side, (n, n_z) or vectors along t and z, (n, n_z, 2)."""
    shape, total = result.equilibrium.state.sides[side].forces.shape, dict[str, Floats]()
    for patch, creep in result.rolling:
        if creep.cells is None:
            continue
        for name, values in cell_fields(creep.cells, creep.speed).items():
            here = patch.on_side(creep, values) if patch.side == side else np.zeros((*shape, *values.shape[2:]))
            total[name] = total.get(name, 0.0) + here
    return total


def cells_table(run: SpatialWheelsetRun) -> str:
    """Return all cells under pressure as CSV, a row for each, with the tractions on the wheel and its slip.

    Points are those of the deflected rail in the track's axes; ``along_surface`` is the length from the middle of the
    rail's profile to the right. Components of vectors are along the surface to the right, and ahead.
    """
    rows: list[dict[str, object]] = []
    for patch in run.result.patches:
        state, sign, shown = patch.state, SIDE_SIGN[patch.side], patch_map(run.result, patch.side)
        fields = normal_fields(state.cells)
        for name, values in friction_of_cells(run.result, patch.side).items():
            fields[name] = values * (-sign, 1.0) if values.ndim > 2 else values  # t runs to the gauge side
        row, strip = np.nonzero(patch.inside)
        stations, z = state.grid.grid.middles
        x, y = (state.points * (sign, 1.0))[row].T
        positions = {"along_surface_mm": shown.across(stations[row]), "x_mm": x, "y_mm": y, "z_mm": z[strip]}
        columns = positions | cell_columns(state.grid.grid, fields, patch.inside)
        rows += _labelled(columns, side=patch.side, region=patch.region)
    return ResultTable.of_rows(rows).in_units(run.case.units).csv(DIGITS)


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


def below_table(run: SpatialWheelsetRun) -> str:
    """Return the stresses on the normals below the centres of pressure as CSV, a row for each depth."""
    rows: list[dict[str, object]] = []
    for patch, role in lines_below(run.result):
        line = patch.lines[role]
        columns = {"depth_mm": line.depths, **line.stresses.by_name}
        rows += _labelled(columns, side=patch.side, region=patch.region, body=role)
    return ResultTable.of_rows(rows).in_units(run.case.units).csv(DIGITS)


def _labelled(columns: Mapping[str, Floats], **words: str) -> list[dict[str, object]]:
    """Return the rows of columns, behind words that all of them have."""
    return [words | dict(zip(columns, row, strict=True)) for row in ResultTable(columns).rows()]
