"""Contact patches as they are drawn, and fields of their cells for pictures, files and the viewer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.contact.patch.patch_contact import CellForces, SpatialPatch
from flangeway.contact.patch.patch_grid import PatchGrid, pairs_of
from flangeway.contact.rolling.fast_theories import SimplifiedRolling
from flangeway.contact.rolling.rolling_contact import NO_CONTACT, STRIPS_BEYOND, Rolling
from flangeway.geometry.arrays import framed
from flangeway.mesh import PolyMesh
from flangeway.report.viewer import ShownField
from flangeway.types import Bools, Floats, Ints

# --- Patches on the cells of a surface from above, and the surface as a mesh.


MARGIN = 0.08
"""About what is under pressure, relative to its longer side."""


@dataclass(frozen=True, eq=False)
class PatchMap:
    """Pressures on cells, to be drawn with lengths along the surface to the right and z up.

    - `cells`: forces on the cells.
    - `patches`: on these cells.
    - `origin`: length along the surface that is drawn at zero.
    - `sign`: 1 where rising lengths along the surface run to the left, else -1.
    """

    cells: CellForces
    patches: Sequence[SpatialPatch]
    origin: float
    sign: float = 1.0

    def across(self, stations: Floats) -> Floats:
        """Places to the right of lengths along the surface."""
        return self.sign * (self.origin - stations)

    def centre(self, patch: SpatialPatch) -> Floats:
        """Centre of pressure of a patch as it is drawn, shape (2,)."""
        return np.array([self.across(np.array(patch.station)), patch.centre[2]])

    def tilt(self, patch: SpatialPatch) -> float:
        """Angle in radians from the right to the longer semi-axis as it is drawn."""
        # in a patch from z towards rising lengths, which run to the left
        return np.pi / 2.0 + self.sign * patch.angle_rad

    @property
    def box(self) -> Floats:
        """Corners (2, 2) of what is under pressure, with a margin; of all cells without pressure."""
        cells, loaded = self.cells, self.cells.forces > 0.0
        rows, strips = (np.flatnonzero(loaded.any(axis=1 - axis)) if loaded.any() else [0, -1] for axis in (0, 1))
        ends = np.sort(self.across(cells.grid.cells[[rows[0], rows[-1]], [0, 1]]))
        ahead = pairs_of(cells.grid.strip_bounds)[[strips[0], strips[-1]], [0, 1]]
        return framed(np.column_stack((ends, ahead)), MARGIN)

    @property
    def cells_drawn(self) -> "DrawnCells":
        """The cells under pressure as they are drawn."""
        grid = self.cells.grid
        return DrawnCells.between(self.across(grid.bounds), grid.strip_bounds, self.cells.forces > 0.0)


@dataclass(frozen=True, eq=False)
class DrawnCells:
    """Cells of a patch as polygons: what the live page, pictures and the viewer draw, and files hold.

    - `points`: corners of all cells, shape (n_points, 2).
    - `corners`: numbers of the points of the chosen cells, by rows and strips, shape (n_chosen, 4).
    - `chosen`: which of the cells these are, shape (n_cells, n_strips).
    """

    points: Floats
    corners: Ints
    chosen: Bools

    @classmethod
    def between(cls, across: Floats, ahead: Floats, chosen: Bools) -> "DrawnCells":
        """Cells between neighbouring ends (n_cells + 1,) across and (n_strips + 1,) ahead, which may be uneven."""
        points = np.stack(np.meshgrid(across, ahead, indexing="ij"), axis=-1).reshape(-1, 2)
        # point (i, j) has the number i * (n_strips + 1) + j
        first = np.arange(len(across) - 1)[:, None] * len(ahead) + np.arange(len(ahead) - 1)
        last = first + len(ahead)
        return cls(points, np.stack((first, last, last + 1, first + 1), axis=-1)[chosen], chosen)

    @property
    def polygons(self) -> Floats:
        """Corners of the chosen cells, shape (n_chosen, 4, 2)."""
        return self.points[self.corners]

    @property
    def outline(self) -> Floats:
        """Sides of chosen cells that border on no other one, shape (n_sides, 2, 2)."""
        sides = np.stack((self.corners, np.roll(self.corners, -1, axis=1)), axis=-1).reshape(-1, 2)
        unique, count = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
        return self.points[unique[count == 1]]


def strip_mesh(nodes: Floats, z: Floats) -> PolyMesh:
    """Mesh of k times m points (length, z), with cells between neighbours."""
    drawn = DrawnCells.between(nodes, z, np.ones((len(nodes) - 1, len(z) - 1), dtype=np.bool_))
    return PolyMesh.from_cells(drawn.points, drawn.corners)


def at_corners(cells: Mapping[str, Floats]) -> dict[str, Floats]:
    """Arrays of a mesh of quadrilaterals at the corners of its cells, from those of the cells (n, n_z, ...)."""
    return {name: np.repeat(values.reshape(-1, *values.shape[2:]), 4, axis=0) for name, values in cells.items()}


# --- Patches that roll with friction from above, and fields of their cells.


ROLLING_MARGIN = 0.06
FIELDS = {
    "pressure_MPa": ("contact pressure", "MPa"),
    "traction_MPa": ("traction", "MPa"),
    "slip_velocity_m_s": ("slip velocity", "m/s"),
    "slip_mm": ("slip", "mm"),
    "flash_temperature_K": ("flash temperature", "K"),
    "frictional_power_W_mm2": ("frictional power density", "W/mm²"),
    "frictional_work_N_mm": ("frictional work density", "N/mm"),
}
"""Words and units of fields of cells by the names of their arrays, for the viewer."""


@dataclass(frozen=True, eq=False)
class ShownRolling:
    """One patch that rolls, drawn with a direction across to the right and z up.

    - `name`: of the patch.
    - `forces`: creep forces with tractions, slip and states of its cells.
    - `speed_m_s`: speed of rolling.
    - `origin`: length along the first body's surface that is drawn at zero.
    - `sign`: 1 where rising lengths run to the left, else -1, as `flangeway.report.patch_maps.PatchMap`.
    """

    name: str
    forces: Rolling | SimplifiedRolling
    speed_m_s: float
    origin: float
    sign: float = 1.0

    @property
    def edges(self) -> tuple[Floats, Floats]:
        """Ends of the cells, to the right and up."""
        grid = self.forces.contact.grid
        return self.sign * (self.origin - grid.bounds), grid.strip_bounds

    @property
    def box(self) -> Floats:
        """Corners (2, 2) of the cells under pressure, with a margin."""
        both = zip(self.edges, self.forces.contact.box, strict=True)
        corners = np.stack([np.sort(edges[[cells.start, cells.stop]]) for edges, cells in both], axis=1)
        return framed(corners, ROLLING_MARGIN)

    @property
    def cells_drawn(self) -> DrawnCells:
        """The cells in contact as they are drawn."""
        return DrawnCells.between(*self.edges, self.forces.states != NO_CONTACT)

    @property
    def tractions(self) -> Floats:
        """Tractions on the second body to the right and up, shape (n_cells, n_strips, 2)."""
        return self.forces.tractions * (-self.sign, 1.0)


def cell_fields(forces: Rolling | SimplifiedRolling, speed_m_s: float) -> dict[str, Floats]:
    """Arrays on the cells (n_cells, n_strips[, 2]) by their names in files; vectors t, z are those of the second body.

    Of a shift they are slip and work in the place of velocity and power. The exact theory has displacements: of the
    second body less those of the first one.
    """
    rolls = forces.motion.rolls
    scale = speed_m_s / abs(forces.motion.speed) if rolls else 1.0
    slip, power = ("slip_velocity_m_s", "frictional_power_W_mm2") if rolls else ("slip_mm", "frictional_work_N_mm")
    fields = {
        "traction_MPa": forces.tractions,
        slip: scale * forces.slip_velocities,
        power: scale * forces.power_density,
    }
    if isinstance(forces, Rolling):
        fields["tangential_displacement_mm"] = forces.displacements[0][..., STRIPS_BEYOND:-STRIPS_BEYOND].swapaxes(1, 2)
    if forces.flash_temperatures is not None:
        fields["flash_temperature_K"] = forces.flash_temperatures
    return fields | {"stick_slip_state": forces.states.astype(np.float64)}


def normal_fields(cells: CellForces, closing: Floats | float = 0.0) -> dict[str, Floats]:
    """Arrays on the cells (n, n_z) along their normals: pressure, gaps, and displacement of the surfaces apart.

    - `closing`: motion of the bodies towards each other that `cells.undeformed` leaves out.
    """
    undeformed = cells.undeformed - closing
    fields = {"pressure_MPa": cells.pressures, "gap_mm": cells.gaps, "undeformed_gap_mm": undeformed}
    return fields | {"normal_displacement_mm": cells.gaps - undeformed}


def cell_columns(grid: PatchGrid, fields: Mapping[str, Floats], inside: Bools) -> dict[str, Floats]:
    """Columns of some cells: areas, fields (n, n_z), and components of vectors (n, n_z, 2) to the right and ahead."""
    chosen = {"area_mm2": np.broadcast_to(grid.areas, inside.shape)[inside]}
    for name, values in fields.items():
        if values.ndim == 2:
            chosen[name] = values[inside]
            continue
        unit = next(unit for unit in ("_MPa", "_m_s", "_mm") if name.endswith(unit))
        stem, vectors = name.removesuffix(unit), values[inside]
        chosen |= {f"{stem}_{word}{unit}": vectors[:, axis] for axis, word in ((1, "ahead"), (0, "right"))}
    return chosen


def shown_fields(fields: Mapping[str, Floats]) -> tuple[list[ShownField], dict[str, Floats]]:
    """Fields of cells (n_cells, n_strips[, 3]) for the viewer, which shows vectors by their sizes, and their arrays."""
    known = {name: values for name, values in fields.items() if name in FIELDS}
    arrays = {name: np.linalg.norm(values, axis=2) if values.ndim > 2 else values for name, values in known.items()}
    return [ShownField(name, *FIELDS[name], "Contact", name, "value") for name in arrays], arrays
