"""Pressures and friction of a wheelset on the running surfaces of its rails, in three dimensions, for the viewer."""

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from flangeway.cases.wheelset.wheelset_quantities import patch_name
from flangeway.cases.wheelset.wheelset_run import WheelsetRun
from flangeway.mesh import PolyMesh
from flangeway.quantities import measured
from flangeway.railway.track.placements import SIDE_SIGN, SIDES, Side
from flangeway.railway.wheelset.spatial_result import SpatialResult
from flangeway.report.rolling.rolling_maps import shown_fields
from flangeway.report.spatial.patch_map import strip_mesh
from flangeway.report.viewer import Scene, ShownField, ShownPart, View
from flangeway.report.wheelset.running_surface_files import friction_fields
from flangeway.types import Floats
from flangeway.units import Units, sentence

RAISED_MM_PER_MPA = 0.01
SPACING_MM = 1.5
"""Of the surface's points away from the patches."""
ROUND_MM = 12.0
"""Length of rail that is shown ahead of the patches and behind them."""
DEEP_MM, LOWER_MM = 14.0, 5.0
"""Depth of the heads that is shown, and at least below what is in contact."""
NEAR = 40.0
"""Width of the view of a patch in mm."""
PRESSURE = "pressure_MPa"
BELOW_MM = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0)
"""Depths at which the stress is shown."""
MISES = "von_mises_MPa"


def pressure_scene(run: WheelsetRun) -> Scene:
    """Running surfaces of both rails, raised where there is pressure, stresses below, and a view of each patch."""
    patches = run.space.patches
    views = [View(patch_name(patch), (patch.centre_mm[0], patch.centre_mm[2]), NEAR) for patch in patches]
    note = sentence(
        "Running surfaces of the rails in the track's axes: x to the right, z ahead of the axle, y up. For the eye "
        "they are raised where there is pressure, by {:g mm} for {1 MPa}; y is that of the raised "
        "surface, without the rail's deflection. Pressures are means over the cells of the contact, as in the VTU "
        "files of the rails.",
        RAISED_MM_PER_MPA,
    )
    z = np.concatenate([state.grid.grid.along for state in run.space.equilibrium.state.sides.values()])
    ends = float(z.min()) - ROUND_MM, float(z.max()) + ROUND_MM
    if run.space.rolling:
        note += " Tractions and slip velocities are shown by their sizes."
    note += (
        " Von Mises stresses are those of the rail below each cell, along the surface's normal: the largest one of all "
        "depths, and those at some depths; the VTU files of stresses have the volume."
    )
    parts = [_part(run.space, side, ends, run.case.units) for side in SIDES]
    return Scene(
        [part for part, _ in parts],
        parts[0][1],
        views,
        notes=(note,),
        axes=("x", "z", "y"),
    )


def _part(
    result: SpatialResult, side: Side, ends: tuple[float, float], units: Units
) -> tuple[ShownPart, list[ShownField]]:
    """Running surface of a rail with its fields."""
    state = result.equilibrium.state.sides[side]
    surfaces, cells, grid = state.grid.surfaces, state.cells, state.grid.grid
    depths = surfaces.rail_points(surfaces.rail_stations[:, 1])[0][:, 1]
    lowest = min(-DEEP_MM, float(cells.points[:, 1].min()) - LOWER_MM)
    stations = surfaces.rail_stations[depths > lowest, 1]
    nodes = _with_coarse(grid.bounds, float(stations.min()), float(stations.max()))
    z = _with_coarse(grid.strip_bounds, *ends)
    shape = len(nodes) - 1, len(z) - 1
    first, row = np.searchsorted(z, grid.strip_bounds[0]), np.searchsorted(nodes, grid.bounds[0])
    window = slice(row, row + len(grid.widths)), slice(first, first + grid.n_strips)
    later = np.ones(shape)
    later[window] = 0.0
    fields, found = shown_fields({PRESSURE: cells.pressures} | friction_fields(result, side, "rail"))
    fields, found = fields + below_fields(units), found | stresses_below(result, side)
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
    mesh = PolyMesh.from_cells(mesh.points, corners)
    ordered = {name: values.reshape(-1, 1)[order] for name, values in arrays.items()}
    return ShownPart(f"rail-{side}", mesh, cell_arrays=ordered, side=side, heights=heights), fields


def below_fields(units: Units) -> list[ShownField]:
    """Fields of the von Mises stress of the rail below the cells."""
    depths = [f"at a depth of {measured(depth, 'mm', units)}" for depth in BELOW_MM]
    names = [f"{MISES}:{number}" for number in range(len(depths) + 1)]
    words = ("largest at any depth", *depths)
    return [
        ShownField(name, f"von Mises stress, {each}", "MPa", "Below the patches", name, "value")
        for name, each in zip(names, words, strict=True)
    ]


def stresses_below(result: SpatialResult, side: Side) -> dict[str, Floats]:
    """Arrays of `below_fields` on the cells of a side, (n, n_z)."""
    grid = result.equilibrium.state.sides[side].grid.grid
    total = np.zeros((len(BELOW_MM) + 1, len(grid.stations), grid.n_strips))
    for patch in (each for each in result.patches if each.side == side):
        field = result.stress_fields[patch]["rail"]
        place = np.searchsorted(field.depths, BELOW_MM).clip(1, len(field.depths) - 1)
        part = (BELOW_MM - field.depths[place - 1]) / np.diff(field.depths)[place - 1]
        low, high = field.von_mises[place - 1], field.von_mises[place]
        values = np.concatenate(
            (field.von_mises.max(axis=0)[None], low + part.clip(0.0, 1.0)[:, None, None] * (high - low))
        )
        surface = RegularGridInterpolator(
            (field.along, field.z), np.moveaxis(values, 0, 2), bounds_error=False, fill_value=0.0
        )
        on_cells = surface(np.stack(np.meshgrid(*grid.middles, indexing="ij"), axis=-1))
        total = np.maximum(total, np.moveaxis(on_cells, 2, 0))
    return {field.array: values for field, values in zip(below_fields("metric"), total, strict=True)}


def _with_coarse(fine: Floats, low: float, high: float) -> Floats:
    """Fine rising values, and coarser ones in their gaps and out to two ends."""
    ends = np.unique(np.concatenate(([min(low, fine[0])], fine, [max(high, fine[-1])])))
    steps = np.ceil(np.diff(ends) / SPACING_MM - 1e-9).astype(np.int64)
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends[:-1], ends[1:], steps, strict=True)]
    return np.append(np.concatenate(parts), ends[-1])
