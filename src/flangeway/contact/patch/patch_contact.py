"""Contact patch of two prisms or bodies of revolution in three dimensions, and its equivalent ellipses."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.contact.patch.normal_contact import Convolution, NormalContact, Pressing
from flangeway.contact.patch.patch_grid import (
    MIN_ACROSS,
    USUAL_ACROSS,
    GridGaps,
    PatchBody,
    PatchGrid,
    at_edge,
    gaps_of,
    grid_of,
    plane_modulus,
    separate_patches,
)
from flangeway.errors import InputError
from flangeway.exact import PointContact, contact_modulus
from flangeway.geometry.arrays import max_magnitude
from flangeway.results import Shown
from flangeway.solve import ComplianceTable, Status, SurfaceCells, compliance_table
from flangeway.system.disk_cache import Cache
from flangeway.types import Bools, Floats

# --- Separate patches of a contact: resultants, equivalent ellipses, and Hertz's contact beside them.


ROUND_OFF = 1e-6
"""Cosine of an axis that is zero but for round-off."""
MAX_PARABOLOID_DISTANCE = 0.05
"""Distance of gaps from a paraboloid relative to their range, above which Hertz's contact has no meaning."""
MIN_FITTED_CELLS = 3
"""Cells across and along a patch that a paraboloid needs."""
MIN_CELLS_OF_PATCH = 10
"""Cells across or along a patch below which its maximum pressure is uncertain by more than 2 %."""


@dataclass(frozen=True, eq=False)
class CellForces:
    """Normal forces on cells of a surface.

    Parameters
    ----------
    forces
        Shape (n_cells, n_strips).
    grid
        The cells.
    points, normals
        Middles of the cells and outward normals, each (n_cells, 2).
    gaps
        Of the deformed surfaces, shape as the forces.
    modulus
        Contact modulus.
    undeformed
        Gaps of the undeformed surfaces, shape as the forces.

    """

    forces: Floats
    grid: PatchGrid
    points: Floats
    normals: Floats
    gaps: Floats
    modulus: float
    undeformed: Floats

    @property
    def pressures(self) -> Floats:
        """Mean pressures of the cells, shape (n_cells, n_strips)."""
        return self.forces / self.grid.areas

    def patches(self, interiors: Sequence[Bools] | None = None) -> list["SpatialPatch"]:
        """Separate patches, or those of given cells, by falling force."""
        interiors = separate_patches(self.forces > 0.0) if interiors is None else interiors
        patches = [SpatialPatch(self, inside) for inside in interiors]
        return sorted(patches, key=lambda patch: -patch.normal_force_N)


@dataclass(frozen=True, eq=False)
class SpatialPatch(Shown):
    """One patch on cells, and the ellipse with the same second moments of pressure as Hertz's.

    - `cells`: forces on the cells of the surface.
    - `inside`: which of them are the patch, shape (n_cells, n_strips).
    """

    cells: CellForces
    inside: Bools

    @cached_property
    def forces(self) -> Floats:
        """Normal forces on its cells, 0 on others, shape (n_cells, n_strips)."""
        return np.where(self.inside, self.cells.forces, 0.0)

    @cached_property
    def fractions(self) -> Floats:
        """Fractions of all cells in its normal force, shape (n_cells, n_strips)."""
        return self.forces / self.forces.sum()

    @cached_property
    def _fractions_by_axis(self) -> tuple[Floats, Floats]:
        """Fractions of rows of cells (n_cells,) and of strips (n_strips,)."""
        total = float(self.forces.sum())
        return self.forces.sum(axis=1) / total, self.forces.sum(axis=0) / total

    @property
    def force(self) -> Floats:
        """Resultant on the second body, shape (2,)."""
        return self.forces.sum(axis=1) @ self.cells.normals

    @property
    def normal_force_N(self) -> float:  # noqa: N802
        """Size of the resultant of its normal forces."""
        return float(np.linalg.norm(self.force))

    @property
    def centre(self) -> Floats:
        """Centre of pressure (x, y, z), shape (3,)."""
        by_cell, by_strip = self._fractions_by_axis
        return np.append(by_cell @ self.cells.points, by_strip @ self.cells.grid.along)

    @property
    def station(self) -> float:
        """Length along the surface of the centre of pressure."""
        return float(self.fractions.sum(axis=1) @ self.cells.grid.stations)

    @cached_property
    def _principal(self) -> tuple[Floats, Floats]:
        """Principal second moments of its pressures, ascending, and their directions (z, s) as columns."""
        (by_cell, by_strip), grid = self._fractions_by_axis, self.cells.grid
        s, z = grid.stations - by_cell @ grid.stations, grid.along - by_strip @ grid.along
        # a cell's own second moments are those of its area
        mixed = float(s @ self.forces @ z) / float(self.forces.sum())
        moments = np.array(
            [[by_strip @ z**2 + grid.strip**2 / 12.0, mixed], [mixed, by_cell @ (s**2 + grid.widths**2 / 12.0)]]
        )
        values, vectors = np.linalg.eigh(moments)
        return values, vectors

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Longer and shorter semi-axis of the ellipse under a Hertzian pressure with the patch's second moments."""
        small, great = self._principal[0]
        return float(np.sqrt(5.0 * great)), float(np.sqrt(5.0 * small))

    @property
    def angle_rad(self) -> float:
        """From z to the longer semi-axis, towards the first body's tangent, within pi / 2.

        Counter-clockwise seen from above for a flat body: z up, x to the left.
        """
        # the cosine is not negative; where it is round-off, the sine is positive
        direction = self._principal[1][:, 1]
        across = abs(direction[0]) < ROUND_OFF
        direction = direction * (1.0 if direction[int(across)] >= 0.0 else -1.0)
        return float(np.arctan2(direction[1], direction[0]))

    @property
    def widths(self) -> tuple[float, float]:
        """Widths of the ellipse across and along z."""
        long, short = self.semi_axes
        cos, sin = np.cos(self.angle_rad), np.sin(self.angle_rad)
        return 2.0 * float(np.hypot(long * sin, short * cos)), 2.0 * float(np.hypot(long * cos, short * sin))

    @property
    def max_pressure(self) -> float:
        """Maximum mean pressure of a cell."""
        return float(self.cells.pressures[self.inside].max())

    @property
    def n_cells(self) -> tuple[int, int]:
        """Maximum numbers of cells across and along z."""
        return int(self.inside.sum(axis=0).max()), int(self.inside.sum(axis=1).max())

    @property
    def remark(self) -> str | None:
        """What limits the maximum pressure, None if nothing does."""
        across, along = self.n_cells
        return f"{across} by {along} cells" if min(across, along) < MIN_CELLS_OF_PATCH else None

    @cached_property
    def area(self) -> float:
        """Area of the polygon through the points at which its edge crosses the lines between middles, see `covered`."""
        cells, grid, inside = self.cells, self.cells.grid, self.inside
        steps, pressures = np.diff(grid.stations)[:, None], cells.pressures
        across = covered(inside, pressures, cells.gaps, cells.modulus / steps)
        along = covered(inside.T, pressures.T, cells.gaps.T, cells.modulus / grid.strip).T
        # rectangles between four middles: corners inside, and the covered parts a and b of the sides that meet there
        low, high = slice(None, -1), slice(1, None)
        corners = [(inside[i, j], across[:, j], along[i]) for i in (low, high) for j in (low, high)]
        number = sum(corner.astype(int) for corner, _, _ in corners)
        triangle = sum(corner * a * b for corner, a, b in corners) / 2.0
        cut = sum(~corner * (1.0 - a) * (1.0 - b) for corner, a, b in corners) / 2.0
        return float((np.where(number > 1, 1.0 - cut, triangle) * steps).sum() * grid.strip)

    @cached_property
    def hertz(self) -> PointContact | None:
        """Hertz's contact for its force and the curvatures of its gap; None where these vary too much.

        The curvatures are those of the paraboloid that fits the undeformed gaps of its cells best, which may be off by
        a fraction of their range, `MAX_PARABOLOID_DISTANCE`.
        """
        values = self.cells.undeformed[self.inside]
        height = float(np.ptp(values))
        if min(self.n_cells) < MIN_FITTED_CELLS or not height > 0.0:
            return None
        across, along = self.cells.grid.middles
        z, s = (coordinate[self.inside] for coordinate in np.meshgrid(along - self.centre[2], across - across.mean()))
        terms = np.stack((np.ones(len(s)), s, z, s**2, s * z, z**2), axis=1)
        fit, *_ = np.linalg.lstsq(terms, values)
        least, most = np.linalg.eigvalsh([[2.0 * fit[3], fit[4]], [fit[4], 2.0 * fit[5]]])
        if not least > 0.0 or np.abs(terms @ fit - values).max() > MAX_PARABOLOID_DISTANCE * height:
            return None
        return PointContact(self.normal_force_N, 1.0 / least, 1.0 / most, self.cells.modulus)


def covered(inside: Bools, pressures: Floats, gaps: Floats, stiffness: Floats | float) -> Floats:
    """Parts of the lines between middles of neighbours along the first axis that lie in a patch, shape (n - 1, m).

    At the distance d from the edge the pressure inside is ``p = K sqrt(d)``, and the gap outside is
    ``g = 4 K d^(3/2) / (3 E*)`` (Johnson, 1985, "Contact Mechanics", 5.1). Between middles at the distance h, of which
    one is under pressure and the other one open, the edge is at the part t with ``t^(1/2) / (1 - t)^(3/2) =
    4 h p / (3 E* g)``. It reaches a middle as that cell opens or closes: the edge moves on without a jump.

    - `inside`: cells of the patch, shape (n, m).
    - `pressures`, `gaps`: of all cells, shape (n, m).
    - `stiffness`: contact modulus over the distance, E* / h.
    """
    low, high = inside[:-1], inside[1:]
    pressure, gap = np.where(low, pressures[:-1], pressures[1:]), np.where(low, gaps[1:], gaps[:-1])
    ratio = 4.0 / 3.0 * pressure / (stiffness * np.maximum(gap, np.finfo(float).tiny))
    beyond = np.where(low, pressures[1:], pressures[:-1])
    ratio = np.where(beyond > 0.0, 2.0, ratio)  # the middle between it and another patch
    # u + u^3 = ratio with u^2 = t / (1 - t)
    u = np.sqrt(4.0 / 3.0) * np.sinh(np.arcsinh(np.sqrt(6.75) * ratio) / 3.0)
    return np.where(low & high, 1.0, np.where(low | high, u**2 / (1.0 + u**2), 0.0))


# --- Contact patch of two prisms or bodies of revolution in three dimensions.


MIN_WAVENUMBER = 1e-4
"""Per mm: a wave of 60 m, beyond which bodies that are held or on a foundation no longer change."""
MAX_EDGE_PER_CELL = 1.05
"""Maximum edge of a mesh relative to the cells on it: pressures on cells that are smaller than the edges oscillate."""
MAX_PHASE = np.pi
"""Maximum wavenumber times the width of the strips."""
MAX_GRIDS = 4

Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class PatchContact:
    """Pressures of two bodies on each other.

    Parameters
    ----------
    pair
        The bodies on their grid; ``pair.press`` solves for other loads.
    contact
        Forces on the cells, gaps of the deformed surfaces, and how the iteration ended; its ``approach`` is from the
        position as given.

    """

    pair: "PatchPair"
    contact: NormalContact

    @property
    def status(self) -> Status:
        """How the iteration ended, with the errors of the solution."""
        status = self.contact.status
        elsewhere = f"overlaps elsewhere up to {self.overlap:.1e}" if self.overlap > 0.0 else "no overlaps elsewhere"
        return Status(
            status.converged,
            f"{status.message}; gaps under pressure up to {self.closed_error:.1e} of the approach, {elsewhere}",
            status.iterations,
        )

    @cached_property
    def cells(self) -> CellForces:
        """Forces on the cells."""
        grid, gaps = self.pair.grid, self.pair.gaps
        modulus = contact_modulus(plane_modulus(self.pair.first), plane_modulus(self.pair.second))
        deformed = self.contact.gaps
        return CellForces(self.contact.forces, grid, gaps.points, gaps.normals, deformed, modulus, gaps.values)

    @property
    def pressures(self) -> Floats:
        """Mean pressures of the cells, shape (n_cells, n_strips)."""
        return self.cells.pressures

    @property
    def approach(self) -> float:
        """Approach along y from the position in which the rigid surfaces touch first."""
        return self.contact.approach - self.pair.gaps.first_touch

    @property
    def closed_error(self) -> float:
        """Maximum gap under pressure over the approach."""
        return max_magnitude(self.contact.gaps[self.loaded]) / max(self.approach, 1e-300)

    @property
    def overlap(self) -> float:
        """Maximum overlap without pressure over the approach."""
        return float(abs(self.contact.gaps[~self.loaded].min(initial=0.0))) / max(self.approach, 1e-300)

    @property
    def loaded(self) -> Bools:
        """Cells under pressure, shape (n_cells, n_strips)."""
        return self.contact.forces > 0.0

    @property
    def force(self) -> Floats:
        """Resultant on the second body, shape (2,)."""
        return self.contact.forces.sum(axis=1) @ self.pair.gaps.normals

    @cached_property
    def patches(self) -> list[SpatialPatch]:
        """Separate patches, by falling force."""
        return self.cells.patches()


@dataclass(frozen=True, eq=False)
class PatchPair:
    """Two bodies on a grid, ready to be pressed together.

    Parameters
    ----------
    first, second
        The bodies; the grid is on the first one, the second one is above it.
    grid
        The cells.
    tolerance
        See `flangeway.solve.compliance_table`.
    progress
        Called with a sentence at each stage.
    cache
        Where compliances are kept from one process to the next.

    """

    first: PatchBody
    second: PatchBody
    grid: PatchGrid
    tolerance: float = 1e-3
    progress: Progress = lambda _: None
    cache: Cache | None = None

    @cached_property
    def gaps(self) -> GridGaps:
        """Gaps as the bodies are placed."""
        gaps = gaps_of(self.first, self.second, self.grid)
        if not (np.isfinite(gaps.values).all() and np.isfinite(gaps.others).all()):
            raise InputError(
                f"a window of {np.ptp(self.grid.bounds):.4g} by {self.grid.strip * self.grid.n_strips:.4g} beyond the "
                f"contact surface of {self.second.name!r}",
                "a window within the contact surfaces of both bodies",
                "give a smaller window, or longer contact surfaces",
            )
        return gaps

    @cached_property
    def cells(self) -> tuple[SurfaceCells, SurfaceCells]:
        """The cells on the surfaces of the first and the second body, in the direction of each."""
        first, second = (self._cells(*ends) for ends in self._bounds)
        return first, second

    @property
    def _bounds(self) -> tuple[tuple[PatchBody, Floats], tuple[PatchBody, Floats]]:
        """Both bodies with the ends of the cells as lengths along their meshed surfaces."""
        return (self.first, self.grid.bounds), (self.second, self.gaps.others)

    def _cells(self, body: PatchBody, bounds: Floats) -> SurfaceCells:
        if body.placement.mirrored:
            bounds = body.length - bounds  # the same places in the body's own direction
        cells = SurfaceCells(body.problem, body.edges, np.sort(bounds))
        longest, narrowest = cells.longest_edge, float(self.grid.widths.min())
        if longest > MAX_EDGE_PER_CELL * narrowest:
            raise InputError(
                f"cells of {narrowest:.3g} on edges of the mesh of {body.name!r} of up to {longest:.3g}",
                "edges no longer than the cells",
                f"refine the mesh along the contact surface to {narrowest:.2g}, or take larger cells",
            )
        return cells

    @cached_property
    def tables(self) -> tuple[ComplianceTable, ComplianceTable]:
        """Compliances of the first and the second body on the cells."""
        return self._table(0), self._table(1)

    def _table(self, which: int) -> ComplianceTable:
        self.progress(f"compliance of {(self.first, self.second)[which].name} at many wavenumbers")
        top = MAX_PHASE / self.grid.strip
        return compliance_table(self.cells[which], MIN_WAVENUMBER, top, self.tolerance, cache=self.cache)

    def backwards(self, which: int) -> bool:
        """Whether the cells of the first (0) or second (1) body's table run against those of the grid."""
        body, bounds = self._bounds[which]
        return bool(bounds[-1] < bounds[0]) != body.placement.mirrored

    @cached_property
    def influence(self) -> Convolution:
        """Normal displacements of both bodies together by normal forces."""
        return Convolution(self.coefficients(self.grid.n_strips, (1,)))

    def coefficients(self, n_distances: int, axes: Sequence[int] = (0, 1, 2)) -> Floats:
        """Displacements of the second body less those of the first one by unit forces on cells of the second one.

        Along some of the axes t, n and z, at distances of 0, 1, 2... strips: (n_distances, m n_cells, m n_cells).
        """
        shape = n_distances, len(self.grid.widths), len(axes), len(self.grid.widths), len(axes)
        total = np.zeros(shape)
        for which, table in enumerate(self.tables):
            back = self.backwards(which)
            signs = np.array([-1.0 if back else 1.0, -1.0 if which else 1.0, 1.0])[list(axes)]
            influence = (
                table.influence(self.grid.strip, n_distances, axes).reshape(shape) * signs[:, None, None] * signs
            )
            total += influence[:, ::-1, :, ::-1] if back else influence
        return total.reshape(n_distances, shape[1] * shape[2], -1)

    def press(
        self, *, force: float | None = None, approach: float | None = None, start: Floats | None = None
    ) -> PatchContact:
        """Find the pressures.

        Parameters
        ----------
        force, approach
            Force on the second body along -y, or approach from first touch: one of them.
        start
            Forces to start from, as from another load, shape (n_cells, n_strips).

        Raises
        ------
        InputError
            If the force is not positive, or neither or both are given.

        """
        whole = None if approach is None else approach + self.gaps.first_touch
        return PatchContact(self, self.pressing(force, whole)(start=start))

    def pressing(self, force: float | None = None, approach: float | None = None) -> Pressing:
        """How they are pressed along -y by a force, or by an approach from the position as given."""
        return Pressing(self.influence, self.gaps.values, self.gaps.normals[:, 1:], force, approach)


def press_patch(
    first: PatchBody,
    second: PatchBody,
    *,
    force: float | None = None,
    approach: float | None = None,
    grid: PatchGrid | None = None,
    tolerance: float = 1e-3,
    progress: Progress = lambda _: None,
    cache: Cache | None = None,
) -> PatchContact:
    """Press two bodies together along y and find the pressures between them.

    ``contact = press_patch(lower, upper, force=100e3)`` chooses the cells itself. ``contact.patches[0]`` has semi-axes
    and maximum pressure; ``contact.pair.press(force=..., start=contact.contact.forces)`` solves for another load on the
    same cells.
    A grid of one's own is `PatchGrid`.

    Parameters
    ----------
    first
        The lower body, which the cells are on.
    second
        The upper body.
    force
        Force on the upper body along -y. Along x it is held.
    approach
        Instead of the force: approach from the position in which the rigid surfaces touch first.
    grid
        The cells; left out: 26 cells or more across each patch, and a window that is enlarged when the patch reaches
        its edge.
    tolerance
        See `flangeway.solve.compliance_table`.
    progress
        Called with a sentence at each stage.
    cache
        Where compliances are kept from one process to the next.

    Raises
    ------
    InputError
        If the force is not positive, the bodies touch nowhere, the patch reaches the edge of a given window or of a
        contact surface, the given cells are too large for it, or the meshes are coarser than the cells.

    """
    if (force is None) == (approach is None) or not ((force or 0.0) > 0.0 or (approach or 0.0) > 0.0):
        raise InputError(
            f"force={force} and approach={approach}",
            "a force > 0, or an approach > 0: otherwise the second body lifts off",
            "give one of them",
        )
    chosen = grid or grid_of(first, second, force=force, approach=approach)
    for attempt in range(MAX_GRIDS):
        contact = PatchPair(first, second, chosen, tolerance, progress, cache).press(force=force, approach=approach)
        if not contact.loaded.any():
            raise InputError("bodies that do not touch", "an approach that closes the gap", "give a larger one")
        edges = at_edge(contact.loaded)
        across = min(min(patch.n_cells) for patch in contact.patches)
        if not edges.any() and across >= MIN_ACROSS:
            break
        better = chosen.changed(np.where(edges, 1.5, 1.0), min(across / USUAL_ACROSS, 1.0), first.length)
        if grid is not None or attempt == MAX_GRIDS - 1:
            _refuse(chosen, edges, across)
        progress("a larger window" if edges.any() else "smaller cells")
        chosen = better
    return contact


def _refuse(grid: PatchGrid, edges: Bools, across: int) -> None:
    cell = min(float(grid.widths.min()), grid.strip)
    if edges.any():
        raise InputError(
            f"a contact patch that reaches the edge of its window of {np.ptp(grid.bounds):.4g} by "
            f"{grid.strip * grid.n_strips:.4g}",
            "a larger window",
            "give a larger one, or leave it out",
        )
    raise InputError(
        f"cells of {cell:.3g}: {across} across the patch",
        f"{MIN_ACROSS} or more",
        f"take cells of {cell * across / (MIN_ACROSS + 1):.2g}, or leave the grid out",
    )
