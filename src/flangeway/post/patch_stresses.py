"""Stresses inside the bodies of a contact patch in three dimensions, on sections z = const and along depths."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.polynomial.chebyshev import chebvander

from flangeway.contact.patch.patch_contact import MIN_WAVENUMBER, PatchContact, SpatialPatch
from flangeway.contact.patch.patch_grid import PatchBody, points_along
from flangeway.elements import Reconstruction
from flangeway.exact.half_space import half_space_field, half_space_stresses
from flangeway.geometry.arrays import run_of
from flangeway.post.stress import corner_values, values_inside, von_mises
from flangeway.problems.harmonic import NAMES, Harmonic
from flangeway.solve.surface_compliance import StripForces, wave_sums, waves
from flangeway.space import CellBatch
from flangeway.types import Bools, Floats, Progress

TO_AXES = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])
"""Signs of the components of a half-space in the axes of a `DepthProfile`, in which the depth is -y."""
CELLS_AROUND = 3
"""Cells around a patch below which stresses are computed: tension is greatest at its edge."""
BELOW_BOUND = 1.0 - 1e-9
"""Part of a bound that counts as reaching it, for round-off."""
FAR_NODES, FAR_BLOCKS = (5, 7), 8.0
"""Points across and along the patch at which stresses by loads that are far away are computed, and distance of these
relative to the blocks that they are taken together in: within 0.5 % of what they add."""
FAR_DEPTH = 1e-3
"""Depth relative to these blocks that is the surface: there sums in line with their ends are lost in round-off."""
ROUND_OFF = 1e-6
"""Part of the width of a cell that is none."""


@dataclass(frozen=True, eq=False)
class SpatialStresses:
    """Stresses in three dimensions.

    Parameters
    ----------
    components
        xx, yy, zz, xy, yz, xz in the common axes, tension positive, shape (n, 6).

    """

    components: Floats

    def turned(self, turn: Floats) -> "SpatialStresses":
        """In axes that are turned by a matrix, x and y by one of (2, 2), all by one of (3, 3)."""
        whole = np.eye(3)
        whole[: len(turn), : len(turn)] = turn
        return SpatialStresses((whole @ self.tensors @ whole.T)[:, (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)])

    @property
    def tensors(self) -> Floats:
        """The stresses as matrices, shape (n, 3, 3)."""
        return self.components[:, ((0, 3, 5), (3, 1, 4), (5, 4, 2))]

    @cached_property
    def principal(self) -> Floats:
        """Principal stresses, descending, shape (n, 3)."""
        tensors = self.tensors
        defined = np.isfinite(tensors).all(axis=(1, 2))
        principal = np.full((len(tensors), 3), np.nan)
        principal[defined] = np.linalg.eigvalsh(tensors[defined])[:, ::-1]
        return principal

    @cached_property
    def von_mises(self) -> Floats:
        """Von Mises stress, shape (n,)."""
        return von_mises(self.components)

    @property
    def by_name(self) -> dict[str, Floats]:
        """Components, principal and equivalent stresses, each (n,), by the names of arrays in files."""
        stresses = {f"stress_{name}_MPa": self.components[:, number] for number, name in enumerate(NAMES)}
        stresses |= {f"principal_{number + 1}_MPa": self.principal[:, number] for number in range(3)}
        return {"von_mises_MPa": self.von_mises, "tresca_MPa": self.tresca, **stresses}

    @property
    def tresca(self) -> Floats:
        """Tresca's stress, twice the maximum shear stress: the first less the third principal stress, shape (n,)."""
        return self.principal[:, 0] - self.principal[:, 2]


def summed_stresses(problem: Harmonic, batch: CellBatch, even: Floats, odd: Floats) -> tuple[Reconstruction, Floats]:
    """Reconstruction and stresses (..., 6, n_monomials, n_cells) of a batch, of sums of all wavenumbers.

    Stresses are linear in the wavenumber and in the amplitudes, so that their sums, and those times the wavenumber, of
    what varies as the cosine and as the sine, each (2, ..., n_dofs, 3), are enough.
    """
    sums = []
    for fields, kept in ((even, slice(0, 4)), (odd, slice(4, 6))):
        constant, linear = (problem.cell_stresses(batch, fields[1], wavenumber)[1] for wavenumber in (0.0, 1.0))
        reconstruction, total = problem.cell_stresses(batch, fields[0], 0.0)
        sums.append((total + linear - constant)[..., kept, :, :])
    return reconstruction, np.concatenate(sums, axis=-3)


@dataclass(frozen=True, eq=False)
class SectionStresses:
    """Stresses of one body in the plane of a z.

    Parameters
    ----------
    body
        The body.
    z
        Of the plane.
    even, odd
        Amplitudes of cosine and sine with their weights: the sum of all wavenumbers, and the sum times the wavenumber,
        shape (2, n_dofs, 3).

    """

    body: PatchBody
    z: float
    even: Floats
    odd: Floats

    def polynomials(self, batch: CellBatch) -> tuple[Reconstruction, Floats]:
        """Reconstruction and stresses (6, n_monomials, n_cells) in the frame of the section of a batch."""
        return summed_stresses(self.body.problem, batch, self.even, self.odd)

    def corners(self) -> SpatialStresses:
        """Stresses at the cells' corners, each from its own cell, in the order of ``mesh.cell_points``."""
        components = corner_values(self.body.problem.elasticity.space, self.polynomials, 6)
        return SpatialStresses(components).turned(self.body.placement.matrix)

    def at(self, points: Floats) -> SpatialStresses:
        """Stresses at points (n, 2) of the common axes; not-a-number outside of the body."""
        local = self.body.placement.inverse().points(points)
        components = values_inside(self.body.problem.elasticity.space, local, self.polynomials, 6)
        return SpatialStresses(components).turned(self.body.placement.matrix)


def patch_stresses(
    contact: PatchContact, which: int, z: float | None = None, progress: Progress = lambda _: None
) -> SectionStresses:
    """Stresses in a body by the pressures of a contact.

    Parameters
    ----------
    contact
        The contact, with its pressures.
    which
        0 for the first (lower) body, 1 for the second one.
    z
        The plane; left out: that of the centre of pressure of the first patch.
    progress
        Called with a sentence at each stage.

    """
    pair = contact.pair
    body, cells, grid = (pair.first, pair.second)[which], pair.cells[which], pair.grid
    plane = float(contact.patches[0].centre[2]) if z is None else z
    progress(f"stresses in {body.name}")
    forces = contact.contact.forces[::-1] if pair.backwards(which) else contact.contact.forces
    on_cells = np.stack((np.zeros_like(forces), -forces, np.zeros_like(forces)), axis=1)
    loaded = StripForces(cells, on_cells, plane - grid.along, grid.strip)
    ((even, odd),) = wave_sums([loaded], waves(MIN_WAVENUMBER, grid.strip))
    return SectionStresses(body, plane, even, odd)


@dataclass(frozen=True, eq=False)
class DepthProfile:
    """Stresses below a patch along the inward normal of a body's surface.

    Parameters
    ----------
    depths
        Rising from near the surface, shape (n,).
    stresses
        At the depths, in the axes of the patch: x along the surface, y along its normal, z.

    """

    depths: Floats
    stresses: SpatialStresses

    def maximum(self, values: Floats) -> tuple[float, float]:
        """Maximum of a stress (n,) of the profile, MPa, and its depth in mm."""
        at = int(np.nanargmax(values))
        return float(values[at]), float(self.depths[at])


def depth_profile(section: SectionStresses, patch: SpatialPatch, depths: Floats) -> DepthProfile:
    """Stresses at depths (n,) below the centre of pressure of a patch."""
    chain = section.body.chain
    station = shapely.line_locate_point(shapely.LineString(chain), shapely.Point(patch.centre[:2]))
    (foot,), (outward,) = points_along(chain, np.array([station]))
    inward = -patch.force / np.linalg.norm(patch.force)
    if inward @ outward > 0.0:
        inward = -inward
    stresses = section.at(foot + depths[:, None] * inward)
    turn = np.array([[inward[1], -inward[0]], [inward[0], inward[1]]])
    return DepthProfile(depths, stresses.turned(turn))


def half_space_profile(
    rectangles: tuple[Floats, Floats],
    pressures: Floats,
    position: tuple[float, float],
    depths: Floats,
    poisson: float,
    shears: Floats | None = None,
) -> DepthProfile:
    """Stresses below a place (x, z) of a half-space under pressures and shear tractions on rectangles.

    See `flangeway.exact.half_space.half_space_stresses`; the rectangles are its x and z.
    """
    points = np.stack((np.full(len(depths), position[0]), depths, np.full(len(depths), position[1])), axis=1)
    stresses = half_space_stresses(*rectangles, pressures, points, poisson, shears)
    return DepthProfile(depths, SpatialStresses(stresses * TO_AXES))


@dataclass(frozen=True, eq=False)
class StressMaximum:
    """Maximum of a stress in a volume: its value in MPa, and the length along the surface, depth and z in mm."""

    value: float
    position: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class StressField:
    """Stresses in the volume below a patch, of a half-space under the tractions of all cells.

    Parameters
    ----------
    along, z
        Middles of the columns: lengths along the surface (n,) and places along z (m,).
    depths
        Rising from 0 at the surface, shape (k,).
    components
        xx, yy, zz, xy, yz, xz in the axes of a `DepthProfile`, tension positive, shape (k, n, m, 6).

    """

    along: Floats
    z: Floats
    depths: Floats
    components: Floats

    @cached_property
    def stresses(self) -> SpatialStresses:
        """At all points, in the order of the components, (k n m, 6)."""
        return SpatialStresses(self.components.reshape(-1, 6))

    @cached_property
    def max_von_mises(self) -> StressMaximum:
        """Maximum von Mises stress."""
        return self._maximum(self.von_mises.ravel())

    @property
    def von_mises(self) -> Floats:
        """Von Mises stress, shape (k, n, m)."""
        return self.stresses.von_mises.reshape(self.components.shape[:3])

    @cached_property
    def max_tresca(self) -> StressMaximum:
        """Maximum of Tresca's stress, twice the shear stress."""
        mises = self.stresses.von_mises
        # Tresca's stress is between von Mises' and 2 / sqrt(3) of it
        return self._maximum_of(mises >= np.sqrt(0.75) * mises.max() * BELOW_BOUND, lambda part: part.tresca)

    @cached_property
    def max_tension(self) -> StressMaximum:
        """Maximum of the first principal stress."""
        normal, mises = self.stresses.components[:, :3], self.stresses.von_mises
        # the first principal stress is not less than the normal stresses, nor above their mean and 2/3 of von Mises'
        possible = normal.mean(axis=1) + 2.0 / 3.0 * mises >= normal.max() - (1.0 - BELOW_BOUND) * mises.max()
        return self._maximum_of(possible, lambda part: part.principal[:, 0])

    def nearest(self, position: tuple[float, float, float]) -> tuple[int, int, int]:
        """Numbers of the point nearest to a length along the surface, depth and z."""
        row, depth, strip = (
            int(np.abs(values - at).argmin())
            for values, at in zip((self.along, self.depths, self.z), position, strict=True)
        )
        return row, depth, strip

    def column(self, at: tuple[int, int, int]) -> DepthProfile:
        """Stresses on the normal through a point."""
        return DepthProfile(self.depths, SpatialStresses(self.components[:, at[0], at[2]]))

    def _maximum_of(self, possible: Bools, values: Callable[[SpatialStresses], Floats]) -> StressMaximum:
        """Maximum of what is costly to compute, from the points (k n m,) at which it is possible."""
        whole = np.full(len(possible), -np.inf)
        whole[possible] = values(SpatialStresses(self.stresses.components[possible]))
        return self._maximum(whole)

    def _maximum(self, values: Floats) -> StressMaximum:
        at = int(values.argmax())
        depth, row, strip = np.unravel_index(at, self.components.shape[:3])
        return StressMaximum(
            float(values[at]), (float(self.along[row]), float(self.depths[depth]), float(self.z[strip]))
        )


def stress_field(
    ends: Floats, z: Floats, tractions: Floats, inside: Bools, depths: Floats, poisson: float
) -> StressField:
    """Stresses in the volume below a patch.

    Parameters
    ----------
    ends
        Ends of the rows of cells along the surface, rising, shape (n, 2).
    z
        Middles of the strips, all of one width, shape (m,).
    tractions
        Pressure on the half-space, and shears along the surface and z where there are some, (n, m, 1) or (n, m, 3).
    inside
        Cells of the patch, shape (n, m). Loads of the others count too.
    depths
        Rising, shape (k,).
    poisson
        Poisson's ratio.

    """
    rows, strips = (np.flatnonzero(inside.any(axis=axis)) for axis in (1, 0))
    widths, strip = np.diff(ends, axis=1)[:, 0], float(z[1] - z[0])
    first, last, width = ends[rows[0], 0], ends[rows[-1], 1], float(widths[rows].min())
    box = np.array([[first, last], [z[strips[0]], z[strips[-1]]]])
    box += np.outer((width, strip), (-CELLS_AROUND, CELLS_AROUND))
    middles = ends.mean(axis=1), z
    ways = [np.maximum(np.maximum(low - at, at - high), 0.0) for at, (low, high) in zip(middles, box, strict=True)]
    # stresses by loads farther from there than it is wide, and than half of its length, are smooth
    apart, far = np.hypot(ways[0][:, None], ways[1]), max(float(np.ptp(box[0])), float(np.ptp(box[1])) / 2.0)
    distant = (apart > far)[..., None] * tractions
    tractions, z_ends = tractions - distant, z - strip / 2.0
    # even rows from an end of the patch on, as far as there are loads; rows of other patches share theirs by overlap
    loaded, window = np.flatnonzero(tractions.any(axis=(1, 2))), run_of(tractions.any(axis=(0, 2)))
    tractions, z, strips = tractions[:, window], z[window], strips - window.start
    before = int(np.ceil((first - ends[loaded[0], 0]) / width - ROUND_OFF))
    count = before + int(np.ceil((ends[loaded[-1], 1] - first) / width - ROUND_OFF))
    edges = first + width * (np.arange(count + 1, dtype=np.float64) - before)
    overlap = np.minimum(edges[1:, None], ends[:, 1]) - np.maximum(edges[:-1, None], ends[:, 0])
    even = np.einsum("ij,jzc->izc", np.maximum(overlap, 0.0) / width, tractions)
    field = half_space_field(even, (width, strip), depths, poisson, CELLS_AROUND)
    along_surface = edges[0] + width * (np.arange(count + 2 * CELLS_AROUND) - CELLS_AROUND + 0.5)
    near = np.flatnonzero((along_surface > box[0, 0]) & (along_surface < box[0, 1]))
    # the field's strips begin `CELLS_AROUND` ones before the first
    along = slice(int(strips[0]), int(strips[-1]) + 2 * CELLS_AROUND + 1)
    every: Floats = z[0] + strip * (np.arange(len(z) + 2 * CELLS_AROUND) - CELLS_AROUND)
    below = along_surface[near], every[along]
    part = field[:, :, near[0] : near[-1] + 1, along]
    if distant.any():
        cells = ends, np.stack((z_ends, z_ends + strip), axis=1)
        size = float(apart[distant.any(axis=2)].min()) / FAR_BLOCKS
        part = part + _by_distant(cells, distant, size, below, np.maximum(depths, FAR_DEPTH * size), poisson)
    return StressField(*below, depths, np.moveaxis(part, 0, -1) * TO_AXES)


def _by_distant(
    cells: tuple[Floats, Floats],
    tractions: Floats,
    size: float,
    below: tuple[Floats, Floats],
    depths: Floats,
    poisson: float,
) -> Floats:
    """Stresses by cells that are far away, taken together in blocks, from a few points: (6, k, n, m).

    - `cells`: their ends across and along z, (n_cells, 2) and (n_strips, 2).
    - `size`: of the blocks.
    - `below`: lengths along the surface and z of the points, (n,) and (m,).
    """
    forces = tractions * np.diff(cells[0], axis=1)[:, :, None] * np.diff(cells[1], axis=1)[:, 0, None]
    blocks, nodes, weights = [], [], []
    for axis, (ends, at, count) in enumerate(zip(cells, below, FAR_NODES, strict=True)):
        _, begin = np.unique(np.floor((ends[:, 0] - ends[0, 0]) / size), return_index=True)
        forces = np.add.reduceat(forces, begin, axis=axis)
        blocks.append(np.stack((ends[begin, 0], ends[np.append(begin[1:], len(ends)) - 1, 1]), axis=1))
        middle, half = (at[-1] + at[0]) / 2.0, max((at[-1] - at[0]) / 2.0, ROUND_OFF * size)
        local = np.cos(np.pi * (np.arange(count) + 0.5) / count)
        nodes.append(middle + half * local)
        weights.append(chebvander((at - middle) / half, count - 1) @ np.linalg.inv(chebvander(local, count - 1)))
    means = forces / np.diff(blocks[0], axis=1)[:, :, None] / np.diff(blocks[1], axis=1)[:, 0, None]
    points = np.stack(np.meshgrid(nodes[0], depths, nodes[1], indexing="ij"), axis=-1).reshape(-1, 3)
    shears = means[..., 1:] if means.shape[2] > 1 else None
    stresses = half_space_stresses(blocks[0], blocks[1], means[..., 0], points, poisson, shears)
    # s_pkij = sum over nodes a, b of W_ia W_jb s_akbp
    at_nodes = stresses.reshape(FAR_NODES[0], len(depths), FAR_NODES[1], 6)
    return np.asarray(np.einsum("ia,jb,akbp->pkij", *weights, at_nodes, optimize=True))
