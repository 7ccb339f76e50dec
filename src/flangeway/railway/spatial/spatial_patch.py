"""Contact patch of a wheel on a rail in three dimensions: both sections as prisms, the wheel's curvature in the gap."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flangeway.contact import Surface
from flangeway.contact.patch.normal_contact import Convolution, NormalContact, solve_normal
from flangeway.errors import InputError
from flangeway.geometry import Placement, crossing_shares
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import ComplianceTable, SurfaceCells, compliance_table
from flangeway.types import Floats

LEAST_ACROSS = 20
"""Cells across the patch from which semi-axes are within 0.3 % of Hertz's."""
DRAWN_MM = 0.02
"""Chords of the drawn profiles: on a radius of 10 mm they are within 5e-6 mm."""
CHANGE = 1e-9
"""Change of the forces, over their sum, at which the iteration ends: single pressures are then within 1e-7."""
LEAST_WAVENUMBER = 1e-4
"""Per mm: a wave of 60 m, beyond which bodies that are held or on a foundation no longer change."""


@dataclass(frozen=True, eq=False)
class SpatialPatch:
    """A contact patch on a grid of cells on the rail.

    Parameters
    ----------
    points
        Middles of the cells in the axes of the track, shape (n_cells, 2).
    normals
        Outward normals of the rail there, shape (n_cells, 2).
    along
        Middles of the strips along the track, shape (n_strips,).
    pressures
        In MPa, shape (n_cells, n_strips).
    contact
        Forces, approach and gaps.
    tables
        Compliances of rail and wheel, for other forces and positions near by.

    """

    points: Floats
    normals: Floats
    along: Floats
    pressures: Floats
    contact: NormalContact
    tables: tuple[ComplianceTable, ComplianceTable]

    @property
    def size(self) -> tuple[float, float]:
        """Length along the track and width across of the area in contact, in mm: extents of the loaded cells."""
        loaded = self.pressures > 0.0
        strip = float(self.along[1] - self.along[0])
        widths = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        across = np.flatnonzero(loaded.any(axis=1))
        return strip * float(loaded.any(axis=0).sum()), float(widths[across[0] : across[-1] + 1].sum())

    @property
    def force(self) -> Floats:
        """Resultant on the wheel in the axes of the track, shape (2,)."""
        total: Floats = self.contact.forces.sum(axis=1) @ self.normals
        return total


def spatial_patch(
    model: WheelsetModel,
    side: Side,
    force: float,
    *,
    cell_mm: float = 0.5,
    window_mm: tuple[float, float] = (16.0, 24.0),
    tolerance: float = 1e-3,
    progress: Callable[[str], None] = lambda _: None,
) -> SpatialPatch:
    """Press a wheel on its rail vertically, from the position in which the rigid wheelset touches.

    Parameters
    ----------
    model
        Meshed wheelset and track.
    side
        Side of the track.
    force
        Vertical force in N.
    cell_mm
        Size of the square cells.
    window_mm
        Width across and length along the track of the grid.
    tolerance
        See `flangeway.solve.compliance_table`.
    progress
        Called with a sentence at each stage.

    Raises
    ------
    InputError
        If the window is larger than the meshed contact zone, the patch reaches its edge, or the cells are too large.

    """
    contact = model.contact(side)
    wheel, rail = contact.secondary, contact.primary
    if wheel.part.name.startswith("rail"):
        wheel, rail = rail, wheel
    placement = model.rigid_position.placement(model.problem.wheelset, side)
    placements = {"wheel": placement, "rail": rail.part.placement}
    chains = {role: _chain(surface, placements[role]) for role, surface in (("wheel", wheel), ("rail", rail))}
    drawn = {role: _drawn(surface, placements[role]) for role, surface in (("wheel", wheel), ("rail", rail))}
    n_cells, n_strips = (int(np.ceil(length / cell_mm)) for length in window_mm)

    station = _closest(chains["rail"], drawn["wheel"])
    bounds: Floats = station + cell_mm * (np.arange(n_cells + 1, dtype=np.float64) - n_cells / 2.0)
    on_rail, rail_normals = _along(chains["rail"], bounds)
    # rays from the meshed rail, along which the drawn rail and the drawn wheel are met
    distances = _cast(on_rail, rail_normals, drawn["wheel"])[0] - _cast(on_rail, rail_normals, drawn["rail"])[0]
    reached, on_wheel = _cast(on_rail, rail_normals, chains["wheel"])
    if not (np.isfinite(distances) & np.isfinite(reached)).all():
        raise InputError(
            f"a window of {window_mm[0]:g} mm across, beyond the meshed surface of the wheel",
            "a window within the contact zones of both meshes",
            "give a narrower window, or mesh wider zones",
        )
    influence = np.zeros((n_strips, n_cells, n_cells))
    tables = []
    for surface, limits, role in ((rail, bounds, "rail"), (wheel, on_wheel, "wheel")):
        body = surface.part.body
        if placements[role].mirrored:
            limits = _stations(chains[role])[-1] - limits  # noqa: PLW2901 (the same places in the body's own direction)
        backwards = bool(limits[-1] < limits[0])
        progress(f"compliance of the {role} at many wavenumbers")
        problem = Harmonic(
            Elasticity(body.space, body.material, name=body.name), held=dict.fromkeys(body.supports, "xyz")
        )
        cells = SurfaceCells(problem, surface.edges.astype(np.int64), np.sort(limits))
        _refuse_coarse_mesh(cells, role, cell_mm)
        tables.append(compliance_table(cells, LEAST_WAVENUMBER, 2.0 * np.pi / cell_mm, tolerance))
        found = tables[-1].influence(cell_mm, n_strips, axes=(1,))
        influence += found[:, ::-1, ::-1] if backwards else found

    middles: Floats = (on_rail[1:] + on_rail[:-1]) / 2.0
    normals: Floats = (rail_normals[1:] + rail_normals[:-1]) / 2.0
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    along: Floats = cell_mm * (np.arange(n_strips, dtype=np.float64) - (n_strips - 1) / 2.0)
    gaps: Floats = ((distances[1:] + distances[:-1]) / 2.0)[:, None] + _recess(model, middles, normals, along)
    result = solve_normal(Convolution(influence), gaps, force=force, share=normals[:, 1:], tolerance=CHANGE)
    _refuse_poor_grid(result.forces, cell_mm)
    return SpatialPatch(middles, normals, along, result.forces / cell_mm**2, result, (tables[0], tables[1]))


def _chain(surface: Surface, placement: Placement) -> Floats:
    """Corners of a placed surface's mesh, body on the left, shape (n_edges + 1, 2)."""
    points, edges = surface.part.body.mesh.points, surface.edges
    chain = placement.points(np.concatenate((points[edges[:, 0]], points[edges[-1:, 1]])))
    return chain[::-1] if placement.mirrored else chain


def _drawn(surface: Surface, placement: Placement) -> Floats:
    """The placed surface as it is drawn, as a polyline, shape (n, 2)."""
    assert surface.curve is not None
    points: Floats = placement.points(surface.curve.sampled(spacing=DRAWN_MM))
    return points


def _stations(chain: Floats) -> Floats:
    """Lengths along a chain of points at each of them, shape (n,)."""
    return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(chain, axis=0), axis=1))))


def _along(chain: Floats, stations: Floats) -> tuple[Floats, Floats]:
    """Points and outward unit normals of a chain, body on its left, at lengths along it, each (n, 2)."""
    chords = np.diff(chain, axis=0)
    ends = _stations(chain)
    if stations[0] < 0.0 or stations[-1] > ends[-1]:
        raise InputError(
            f"a window from {stations[0]:g} to {stations[-1]:g} mm on a meshed surface of {ends[-1]:g} mm",
            "a window within it",
            "give a narrower window, or mesh a wider zone",
        )
    points = np.stack([np.interp(stations, ends, chain[:, axis]) for axis in range(2)], axis=1)
    # normals of the edges belong to their middles, between which they turn
    middles = (ends[1:] + ends[:-1]) / 2.0
    normals = np.stack((chords[:, 1], -chords[:, 0]), axis=1) / np.diff(ends)[:, None]
    found = np.stack([np.interp(stations, middles, normals[:, axis]) for axis in range(2)], axis=1)
    return points, found / np.linalg.norm(found, axis=1)[:, None]


def _closest(chain: Floats, other: Floats) -> float:
    """Length along a chain at which another one is closest to it."""
    stations = np.linspace(0.0, _stations(chain)[-1], 8 * len(chain))[1:-1]
    points, normals = _along(chain, stations)
    distances, _ = _cast(points, normals, other)
    return float(stations[np.nanargmin(np.where(np.isfinite(distances), distances, np.inf))])


def _cast(points: Floats, normals: Floats, chain: Floats) -> tuple[Floats, Floats]:
    """Signed distances from points along normals to a chain, and the lengths along it where they meet, each (n,)."""
    start, chords = chain[:-1], np.diff(chain, axis=0)
    ends = _stations(chain)
    distance, share = crossing_shares(points[:, None], normals[:, None], start, chords)
    meets = (share >= 0.0) & (share <= 1.0)
    distance = np.where(meets, distance, np.inf)
    nearest = np.abs(distance).argmin(axis=1)
    rows = np.arange(len(points))
    return distance[rows, nearest], ends[nearest] + share[rows, nearest] * np.diff(ends)[nearest]


def _recess(model: WheelsetModel, points: Floats, normals: Floats, along: Floats) -> Floats:
    """How far the wheel's surface of revolution is behind its section at places along the track, (n_cells, n_strips).

    A point of the radius r rises towards the axle by ``r - sqrt(r^2 - z^2)``.
    """
    axle = np.array(model.rigid_position.axle(model.problem.wheelset))
    roll = model.rigid_position.roll_rad
    axis = np.array([np.cos(roll), np.sin(roll)])
    outward = points - axle - ((points - axle) @ axis)[:, None] * axis
    radii = np.linalg.norm(outward, axis=1)
    rise = radii[:, None] - np.sqrt(np.maximum(radii[:, None] ** 2 - along**2, 0.0))
    inclined = -np.einsum("ci,ci->c", outward / radii[:, None], normals)
    return rise * inclined[:, None]


def _refuse_coarse_mesh(cells: SurfaceCells, role: str, cell_mm: float) -> None:
    """Refuse cells smaller than the edges below them, whose pressures oscillate."""
    longest = cells.longest_edge
    if longest > (1.0 + 1e-6) * cell_mm:
        raise InputError(
            f"cells of {cell_mm:g} mm on edges of the {role}'s mesh of up to {longest:.3g} mm",
            "edges no longer than the cells",
            "make contact_size_mm smaller (order 2 doubles it), or cell_mm larger",
        )


def _refuse_poor_grid(forces: Floats, cell_mm: float) -> None:
    loaded = forces > 0.0
    if loaded[[0, -1]].any() or loaded[:, [0, -1]].any():
        raise InputError("a contact patch that reaches the edge of its window", "a larger window", "give window_mm")
    narrow = min(int(loaded.any(axis=0).sum()), int(loaded.any(axis=1).sum()))
    if narrow < LEAST_ACROSS:
        raise InputError(
            f"cells of {cell_mm:g} mm: {narrow} across the patch",
            f"{LEAST_ACROSS} or more",
            f"take cell_mm={cell_mm * narrow / (LEAST_ACROSS + 1):.2g}",
        )
