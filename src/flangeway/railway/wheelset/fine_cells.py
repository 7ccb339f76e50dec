"""Cells of a side that are fine enough for its patches."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid, pairs_of, separate_patches
from flangeway.railway.track.wheelset_problem import PATCH_CELLS
from flangeway.railway.wheelset.side_contact import GriddedSide, SideState
from flangeway.types import Bools, Floats, Ints

MAX_SIZE_RATIO = 1.3
"""Size of cells relative to the one that is wanted, at most."""
SIZES_PER_DOUBLING = 8
"""Sizes of cells from one to its double."""
MIN_PEAK_FALL = 1e-3
"""Fall of the pressure beside a local maximum, relative to it, below which that is no narrow peak."""
PEAK_CELLS, MAX_DIVISION = 0.3, 4.0
"""Cells across half a narrow peak of the pressure relative to those across a patch, and parts of a cell there, at
most."""
MARGIN = 0.2
"""Width of the window beyond a patch on each side relative to the patch."""
BROAD_MARGIN = 0.6
"""The same for a patch that has come to the end of its window."""
MAX_CELL_RATIO = 6.0
"""Longer side over shorter side of a cell, at most."""
MAX_STRIPS_RATIO = 1.8
"""Strips along the longest patch relative to those wanted along the shortest, at most."""
MIN_UNLOADED_SIZE, GAP_FRACTION = 2.0, 0.25
"""Least size of cells without force relative to that of strips; part of a small gap up to which they reach along z."""
MAX_ON_A_SIDE, MORE_CELLS_FACTOR = 5000, 2.0
"""Cells in the windows of a side, at most, and the factor on them where more cells across a patch are wanted."""
CELL_TOLERANCE = 1e-6
"""Distance of cells relative to the width of strips that is round-off."""
MIN_MAIN_FRACTION = 0.05
"""Share of a side's force above which a patch has its cells counted."""


@dataclass(frozen=True)
class _Window:
    """A patch on a grid.

    - `ends`, `planes`: along the rail's surface and along z.
    - `across`, `along`: widths of the ellipse by the second moments of the pressure, which do not jump between cells.
    - `share`: of the side's force.
    - `rows`: its rows of cells.
    - `peaks`: where the maximum pressure of rows has its local maxima, and half the widths of the parabolas through
      these, each (m, 2).
    """

    ends: tuple[float, float]
    planes: tuple[float, float]
    across: float
    along: float
    share: float
    rows: Ints
    peaks: Floats

    @property
    def is_main(self) -> bool:
        """Whether its cells are counted."""
        return self.share > MIN_MAIN_FRACTION

    def sizes(self, cells: Floats, size: float, n_across: int) -> Floats:
        """Widths that cells (n, 2) should have where those of the patch have a size: smaller at narrow peaks."""
        wanted = np.full(len(cells), size)
        for middle, half in self.peaks:
            near = (cells[:, 1] > middle - half) & (cells[:, 0] < middle + half)
            wanted[near] = np.minimum(wanted[near], max(half / (PEAK_CELLS * n_across), size / MAX_DIVISION))
        return wanted


def _span(bounds: Floats, inside: Bools, axis: int) -> tuple[float, float]:
    """From the first to the last of the intervals between bounds (n + 1,) of an axis in which some cells are."""
    first, last = np.flatnonzero(inside.any(axis=1 - axis))[[0, -1]]
    return float(bounds[first]), float(bounds[last + 1])


def _windows(state: SideState, interiors: Sequence[Bools] | None) -> list[_Window]:
    """One for each patch."""
    grid, pressures = state.grid.grid, state.cells.pressures
    windows: list[_Window] = []
    for patch in state.cells.patches(interiors):
        rows = np.flatnonzero(patch.inside.any(axis=1))
        highest = np.where(patch.inside, pressures, 0.0).max(axis=1)
        windows.append(
            _Window(
                _span(grid.bounds, patch.inside, 0),
                _span(grid.strip_bounds, patch.inside, 1),
                *patch.widths,
                float(state.forces[patch.inside].sum() / state.forces.sum()),
                rows,
                _peaks(grid.stations, highest, float(grid.widths[rows].max())),
            )
        )
    return windows


def _further(state: SideState, near: tuple[float, float], windows: Sequence[_Window]) -> list[_Window]:
    """Windows outside of others, across, where there are forces or small gaps; theirs have no force.

    Along z they are half as long as where gaps are small: about as long as a patch would be there.
    """
    grid, further, (within, way) = state.grid.grid, list[_Window](), near
    gaps = state.gaps - way * np.abs(state.normals[:, :1])
    apart = np.ones(len(grid.widths), dtype=np.bool_)
    for window in windows:
        apart &= (grid.cells[:, 1] <= window.ends[0]) | (grid.cells[:, 0] >= window.ends[1])
    for inside in separate_patches(((state.forces > 0.0) | (gaps < within)) & apart[:, None]):
        least = float(gaps[inside].min())
        close = (state.forces > 0.0) | (gaps <= least + GAP_FRACTION * max(within - least, 0.0))
        ends, planes = _span(grid.bounds, inside, 0), _span(grid.strip_bounds, inside & close, 1)
        none = np.zeros(0, dtype=np.int64), np.zeros((0, 2))
        further.append(_Window(ends, planes, ends[1] - ends[0], planes[1] - planes[0], 0.0, *none))
    return further


def _peaks(stations: Floats, values: Floats, size: float) -> Floats:
    """Local maxima above half of the maximum, and half the widths of the parabolas through them, (m, 2).

    - `size`: distance of the values that such a parabola goes through, the same on cells that were divided.
    """
    inner = values[1:-1]
    at = 1 + np.flatnonzero((inner > values[:-2]) & (inner >= values[2:]) & (inner > 0.5 * values.max()))
    middle = stations[at]
    # v (1 - x^2 / a^2) falls by v (h / a)^2 at the distance h
    falls = values[at] - (np.interp(middle - size, stations, values) + np.interp(middle + size, stations, values)) / 2.0
    return np.column_stack((middle, size * np.sqrt(values[at] / np.maximum(falls, MIN_PEAK_FALL * values[at]))))


def finer(
    state: SideState,
    n_across: int = PATCH_CELLS,
    interiors: Sequence[Bools] | None = None,
    coarse: SideState | None = None,
    near: tuple[float, float] = (0.0, 0.0),
) -> GriddedSide:
    """Grid with enough cells across each patch and room around it; the same grid if it is one already.

    Cells end at multiples of their size along the rail's surface and along z, and sizes are powers of one number: so
    the cells at a position do not depend on how it was reached. At narrow peaks of the pressure, as at jumps of a
    profile's curvature, cells are divided.

    - `n_across`: cells across a patch, and along it.
    - `interiors`: cells of the patches, (n, n_z) each; left out: those that are apart.
    - `coarse`: contact on coarse cells; what touches there has cells too, whether it is loaded here or not.
    - `near`: gap in mm on coarse cells up to which it has some too, after a way across the track in mm.
    """
    old, grid = state.grid, state.grid.grid
    if not (state.forces > 0.0).any():
        return old
    windows = _windows(state, interiors)
    windows += [] if coarse is None else _further(coarse, near, windows)
    windows.sort(key=lambda window: window.ends)
    sizes, at_edge = _Sizes.required(windows, n_across), old.cuts(state.forces)
    if not at_edge and sizes.are_met_by(grid, windows) and _all_within(grid, windows):
        return old
    margin = BROAD_MARGIN if at_edge else MARGIN
    spans = _spans(grid, windows, sizes, margin)
    factor = _coarsening(windows, sizes, spans)
    strip = _rounded(factor * sizes.strip)
    limits = np.sort(old.surfaces.rail_stations[[0, -1], 1])
    parts = _divided_spans(windows, spans, n_across, factor, limits)
    planes = _planes(grid, windows, strip, margin)
    return GriddedSide(
        old.surfaces, PatchGrid.on_planes(_joined(parts, CELL_TOLERANCE * strip), strip, *planes), state.pose
    )


class _Sizes(NamedTuple):
    """Sizes of cells that windows require: of the strips, and across in each window without its peaks."""

    n_across: int
    strip: float
    widths: Sequence[float]

    @classmethod
    def required(cls, windows: Sequence[_Window], n_across: int) -> "_Sizes":
        """Sizes for a number of cells across each patch, and along it."""
        lengths = [window.along for window in windows if window.is_main]
        strip = max(min(lengths) / n_across, max(lengths) / (n_across * MAX_STRIPS_RATIO))
        least = [strip / MAX_CELL_RATIO if window.share else MIN_UNLOADED_SIZE * strip for window in windows]
        widths = [
            min(max(window.across / n_across, low), MAX_CELL_RATIO * strip)
            for window, low in zip(windows, least, strict=True)
        ]
        return cls(n_across, strip, widths)

    def are_met_by(self, grid: PatchGrid, windows: Sequence[_Window]) -> bool:
        """Whether the cells of a grid are not larger in the main patches."""
        return grid.strip <= MAX_SIZE_RATIO * self.strip and all(
            (
                grid.widths[window.rows] <= MAX_SIZE_RATIO * window.sizes(grid.cells[window.rows], width, self.n_across)
            ).all()
            for window, width in zip(windows, self.widths, strict=True)
            if window.is_main
        )


class _Span(NamedTuple):
    """Stretch of the rail's surface with cells of one width, but for peaks."""

    low: float
    high: float
    width: float


def _all_within(grid: PatchGrid, windows: Sequence[_Window]) -> bool:
    """Whether the middle of each window is in cells of a grid that do not only fill the stretch between patches."""
    middles = np.array([np.mean(window.ends) for window in windows])
    fine = grid.widths[:, None] <= MAX_SIZE_RATIO * MAX_CELL_RATIO * grid.strip
    within = (grid.cells[:, :1] <= middles) & (grid.cells[:, 1:] >= middles) & fine
    return bool(within.any(axis=0).all())


def _spans(grid: PatchGrid, windows: Sequence[_Window], sizes: _Sizes, margin: float) -> list[_Span]:
    """Windows with a margin on each side, by their ends; those that overlap share one."""
    spans: list[_Span] = []
    reached = -np.inf
    for window, width in zip(windows, sizes.widths, strict=True):
        first, last = window.ends
        more = max(margin * (last - first), 0.6 * float(grid.widths[window.rows].max(initial=0.0)))
        span = _Span(first - more, last + more, width)
        if first < reached:
            previous = spans.pop()
            span = _Span(previous.low, max(previous.high, span.high), min(previous.width, width))
        elif spans and span.low < spans[-1].high:  # each patch has its own cells, up to the middle between them
            middle = (first + reached) / 2.0
            spans[-1], span = spans[-1]._replace(high=middle), span._replace(low=middle)
        spans.append(span)
        reached = max(last, reached)
    return spans


def _coarsening(windows: Sequence[_Window], sizes: _Sizes, spans: Sequence[_Span]) -> float:
    """Factor on all sizes by which there are no more cells than a factorisation takes, at least 1."""
    strips = sum(window.planes[1] - window.planes[0] for window in windows) / len(windows) / sizes.strip
    most = min(max(sizes.n_across / PATCH_CELLS, 1.0) ** 2, MORE_CELLS_FACTOR) * MAX_ON_A_SIDE
    return float(np.sqrt(max(sum((span.high - span.low) / span.width for span in spans) * strips / most, 1.0)))


def _divided_spans(
    windows: Sequence[_Window], spans: Sequence[_Span], n_across: int, factor: float, limits: Floats
) -> list[Floats]:
    """Bounds of the cells of each span between the ends of the running surface, divided at peaks.

    - `factor`: see `_coarsening`.
    """
    parts, end = [], limits[0]
    for low, high, width in spans:
        ends = _multiples(_rounded(factor * width), low, high)
        ends = ends[(ends >= limits[0]) & (ends <= limits[1])]
        if ends[0] < end:  # beside another patch's cells: one of another width fills what is between
            ends = np.append(end, ends[ends > end + 0.5 * width])
        if len(ends) < 2:  # the other patch's cells hold all of it
            continue
        end = ends[-1]
        widths = np.min([window.sizes(pairs_of(ends), factor * width, n_across) for window in windows], axis=0)
        parts.append(_divided(ends, widths))
    return parts


def _planes(grid: PatchGrid, windows: Sequence[_Window], strip: float, margin: float) -> tuple[int, int]:
    """First and last multiple of the width of strips that all windows have, with a margin."""
    first, last = min(window.planes[0] for window in windows), max(window.planes[1] for window in windows)
    more = max(margin * (last - first), 0.6 * grid.strip)
    return int(np.floor((first - more) / strip)), int(np.ceil((last + more) / strip))


def _joined(parts: Sequence[Floats], same: float) -> Floats:
    """Bounds of all cells; one more cell fills what is between two parts: patches roll on one grid."""
    bounds = np.concatenate(parts)
    return bounds[np.append(np.diff(bounds) > same, True)]


def divided(state: SideState, n_across: int) -> GriddedSide:
    """Grid with cells divided at narrow peaks of the pressure, as `finer` has them; the same grid if there are none.

    Coarser cells do not show such peaks: they are looked for on the cells that were chosen by them.
    """
    old, grid = state.grid, state.grid.grid
    sizes = grid.widths
    for window in _windows(state, None):
        rows, whole = window.rows, float(grid.widths[window.rows].max())
        if window.is_main:
            sizes[rows] = window.sizes(grid.cells[rows], whole, n_across)
    bounds = _divided(grid.bounds, sizes)
    return old if len(bounds) == len(grid.bounds) else GriddedSide(old.surfaces, replace(grid, bounds=bounds), old.pose)


def _rounded(size: float) -> float:
    """The closest one of the sizes that cells may have."""
    return float(2.0 ** (np.round(np.log2(size) * SIZES_PER_DOUBLING) / SIZES_PER_DOUBLING))


def _multiples(size: float, low: float, high: float) -> Floats:
    """Multiples of a size about an interval."""
    return size * np.arange(np.floor(low / size), np.ceil(high / size) + 1.0)


def _divided(bounds: Floats, sizes: Floats) -> Floats:
    """Bounds of cells (n + 1,) with more between them, halved until cells are not wider than sizes (n,)."""
    halvings = np.ceil(np.log2(np.diff(bounds) / (MAX_SIZE_RATIO * sizes)))
    counts = 2 ** np.maximum(halvings, 0).astype(int)
    ends = [
        np.linspace(low, high, count, endpoint=False)
        for (low, high), count in zip(pairwise(bounds.tolist()), counts.tolist(), strict=True)
    ]
    return np.append(np.concatenate(ends), bounds[-1])
