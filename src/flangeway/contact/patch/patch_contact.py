"""Contact patch of two prisms or bodies of revolution in three dimensions."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.contact.patch.contact_ellipse import CellForces, ContactEllipse
from flangeway.contact.patch.normal_contact import Convolution, NormalContact, Pressing
from flangeway.contact.patch.patch_body import PatchBody
from flangeway.contact.patch.patch_grid import (
    LEAST_ACROSS,
    USUAL_ACROSS,
    GridGaps,
    PatchGrid,
    at_edge,
    gaps_of,
    grid_of,
    plane_modulus,
)
from flangeway.errors import InputError
from flangeway.exact import PointContact, contact_modulus
from flangeway.solve import ComplianceTable, Status, SurfaceCells, compliance_table
from flangeway.system.disk_cache import Cache
from flangeway.types import Bools, Floats

LEAST_WAVENUMBER = 1e-4
"""Per mm: a wave of 60 m, beyond which bodies that are held or on a foundation no longer change."""
LONGER_EDGE = 1.05
"""Maximum edge of a mesh over the cells on it: pressures on cells that are smaller than the edges oscillate."""
MAX_PHASE = np.pi
"""Maximum wavenumber times the width of the strips."""
MOST_GRIDS = 4

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
        return CellForces(self.contact.forces, grid, gaps.points, gaps.normals, self.contact.gaps, modulus)

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
        return float(np.abs(self.contact.gaps[self.loaded]).max(initial=0.0)) / max(self.approach, 1e-300)

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
    def patches(self) -> list[ContactEllipse]:
        """Separate patches, by falling force."""
        return self.cells.patches()

    def hertz(self, patch: ContactEllipse) -> PointContact | None:
        """Hertz's contact for the force of a patch and the curvatures of its gap; None where these vary too much."""
        return self.cells.hertz(patch, self.pair.gaps.values, self.approach)


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
        found = gaps_of(self.first, self.second, self.grid)
        if not (np.isfinite(found.values).all() and np.isfinite(found.others).all()):
            raise InputError(
                f"a window of {np.ptp(self.grid.bounds):.4g} by {self.grid.strip * self.grid.n_strips:.4g} beyond the "
                f"contact surface of {self.second.name!r}",
                "a window within the contact surfaces of both bodies",
                "give a smaller window, or longer contact surfaces",
            )
        return found

    @cached_property
    def cells(self) -> tuple[SurfaceCells, SurfaceCells]:
        """The cells on the surfaces of the first and the second body, in the direction of each."""
        bounds = ((self.first, self.grid.bounds), (self.second, self.gaps.others))
        first, second = (self._cells(*each) for each in bounds)
        return first, second

    def _cells(self, body: PatchBody, bounds: Floats) -> SurfaceCells:
        if body.placement.mirrored:
            bounds = body.length - bounds  # the same places in the body's own direction
        cells = SurfaceCells(body.problem, body.edges, np.sort(bounds))
        longest, narrowest = cells.longest_edge, float(self.grid.widths.min())
        if longest > LONGER_EDGE * narrowest:
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
        return compliance_table(self.cells[which], LEAST_WAVENUMBER, top, self.tolerance, cache=self.cache)

    def backwards(self, which: int) -> bool:
        """Whether the cells of the first (0) or second (1) body's table run against those of the grid."""
        body, bounds = ((self.first, self.grid.bounds), (self.second, self.gaps.others))[which]
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
            found = table.influence(self.grid.strip, n_distances, axes).reshape(shape) * signs[:, None, None] * signs
            total += found[:, ::-1, :, ::-1] if back else found
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

    ``press_patch(lower, upper, force=100e3)`` chooses the cells itself. ``found.patches[0]`` has semi-axes and maximum
    pressure; ``found.pair.press(force=..., start=found.contact.forces)`` solves for another load on the same cells.
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
    for attempt in range(MOST_GRIDS):
        found = PatchPair(first, second, chosen, tolerance, progress, cache).press(force=force, approach=approach)
        if not found.loaded.any():
            raise InputError("bodies that do not touch", "an approach that closes the gap", "give a larger one")
        edges = at_edge(found.loaded)
        across = min(min(each.cells) for each in found.patches)
        if not edges.any() and across >= LEAST_ACROSS:
            break
        better = chosen.changed(np.where(edges, 1.5, 1.0), min(across / USUAL_ACROSS, 1.0), first.length)
        if grid is not None or attempt == MOST_GRIDS - 1:
            _refuse(chosen, edges, across)
        progress("a larger window" if edges.any() else "smaller cells")
        chosen = better
    return found


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
        f"{LEAST_ACROSS} or more",
        f"take cells of {cell * across / (LEAST_ACROSS + 1):.2g}, or leave the grid out",
    )
