"""Pressures and friction of a wheelset on the running surfaces of its rails, in three dimensions, for the viewer."""

import numpy as np

from flangeway.cases.wheelset.wheelset_quantities import patch_name
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.mesh import PolyMesh
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.report.rolling.rolling_maps import shown_fields
from flangeway.report.spatial.patch_map import strip_ends, strip_mesh
from flangeway.report.viewer import Scene, ShownField, ShownPart, View
from flangeway.report.wheelset.running_surface_files import friction_fields
from flangeway.types import Floats

RAISED_MM_PER_MPA = 0.01
SPACING_MM = 1.5
"""Of the surface's points away from the patches."""
ROUND_MM = 12.0
"""Length of rail that is shown ahead of the patches and behind them."""
DEEP_MM, BELOW_MM = 14.0, 5.0
"""Depth of the heads that is shown, and at least below what is in contact."""
NEAR = 40.0
"""Width of the view of a patch in mm."""
PRESSURE = "pressure_MPa"


def pressure_scene(run: WheelsetRun) -> Scene:
    """Running surfaces of both rails, raised where there is pressure, and a view of each patch."""
    patches = run.space.patches
    views = [View(patch_name(patch), (patch.centre_mm[0], patch.centre_mm[2]), NEAR) for patch in patches]
    note = (
        "Running surfaces of the rails in the track's axes: x to the right, z ahead of the axle, y up. For the eye "
        f"they are raised where there is pressure, by {RAISED_MM_PER_MPA:g} mm for 1 MPa; y is that of the raised "
        "surface, without the rail's deflection. Pressures are means over the cells of the contact, as in the VTU "
        "files of the rails."
    )
    z = np.concatenate([state.grid.grid.z for state in run.space.equilibrium.state.sides.values()])
    ends = float(z.min()) - ROUND_MM, float(z.max()) + ROUND_MM
    if run.space.rolling:
        note += " Tractions and slip velocities are shown by their sizes."
    parts = [_part(run.space, side, ends) for side in SIDES]
    return Scene(
        [part for part, _ in parts],
        parts[0][1],
        views,
        notes=(note,),
        axes=("x", "z", "y"),
    )


def _part(result: SpatialResult, side: Side, ends: tuple[float, float]) -> tuple[ShownPart, list[ShownField]]:
    """Running surface of a rail with its fields."""
    state = result.equilibrium.state.sides[side]
    surfaces, cells = state.grid.surfaces, state.cells
    depths = surfaces.rail_points(surfaces.rail_stations[:, 1])[0][:, 1]
    lowest = min(-DEEP_MM, float(cells.points[:, 1].min()) - BELOW_MM)
    stations = surfaces.rail_stations[depths > lowest, 1]
    nodes = _with_coarse(np.unique(cells.cells), float(stations.min()), float(stations.max()))
    strips = strip_ends(cells)
    z = _with_coarse(strips, *ends)
    shape = len(nodes) - 1, len(z) - 1
    first = np.searchsorted(z, strips[0])
    window = np.searchsorted(nodes, cells.cells[:, 0]), slice(first, first + len(cells.z))
    later = np.ones(shape)
    later[window] = 0.0
    fields, found = shown_fields({PRESSURE: cells.pressures} | friction_fields(result, side, "rail"))
    arrays = {name: np.zeros(shape) for name in found}
    for name, values in found.items():
        arrays[name][window] = values
    around = np.pad(arrays[PRESSURE], 1)
    at_nodes = (around[1:, 1:] + around[:-1, 1:] + around[1:, :-1] + around[:-1, :-1]) / 4.0
    points, _ = surfaces.rail_points(nodes)
    heights = np.repeat(points[:, 1], len(z)) + RAISED_MM_PER_MPA * at_nodes.ravel()
    mesh = strip_mesh(SIDE_SIGN[side] * points[:, 0], z)
    # first the cells of the contact, with the numbers of the VTU file
    order = np.argsort(later.ravel(), kind="stable")
    corners = mesh.cell_points.reshape(-1, 4)[order]
    # lengths along the surface run to the gauge side: the cells of the right rail are turned over
    corners = corners if side == "left" else corners[:, [1, 0, 3, 2]]
    mesh = PolyMesh(mesh.points, mesh.cell_offsets, corners.ravel())
    ordered = {name: values.reshape(-1, 1)[order] for name, values in arrays.items()}
    return ShownPart(f"rail-{side}", mesh, cell_arrays=ordered, side=side, heights=heights), fields


def _with_coarse(fine: Floats, low: float, high: float) -> Floats:
    """Fine rising values, and coarser ones in their gaps and out to two ends."""
    ends = np.unique(np.concatenate(([min(low, fine[0])], fine, [max(high, fine[-1])])))
    steps = np.ceil(np.diff(ends) / SPACING_MM - 1e-9).astype(np.int64)
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends[:-1], ends[1:], steps, strict=True)]
    return np.append(np.concatenate(parts), ends[-1])
