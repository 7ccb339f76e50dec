"""A curve of lines and arcs through few exact points, or near rounded ones, as profiles are drawn.

Between two points lie cells of constant curvature that meet tangentially. Of all such curves the one is taken whose
curvature changes least: the sum of ``weight |jump|^0.9`` over all cells is minimal, by reweighted least squares
(I. Daubechies, R. DeVore, M. Fornasier and C. S. Guentuerk, "Iteratively reweighted least squares minimization for
sparse recovery", Communications on Pure and Applied Mathematics 63, 2010). An exponent of one or less leaves few jumps
in place of waves: lines and arcs with three or more points stay what they are, and a joint lies where both sides meet.
The weights follow from the points alone (H. Zou, "The adaptive lasso", JASA 101, 2006): a jump costs most where three
neighbours lie on a line or four on an arc. Where the points are rounded, they are displaced across the curve as far as
rounding displaced them: the root mean square of the displacements is that of the rounding.

Points and directions are complex numbers in here, x + iy.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csr_matrix, diags, eye_array
from scipy.sparse.linalg import splu

from flangeway.types import Floats, Ints

Complex = NDArray[np.complex128]

_CELL_MM = 0.5  # maximum length of a cell: a joint between two points is located to a fraction of it
_MAX_CELLS = 32  # cells between two points
_POWER = 0.55  # of the reweighting: 0.5 is the sum of all jumps, 1 their number
_ROUNDS, _LENGTH_ROUNDS = 25, 12
_ROUND_OFF_PER_MM = 1e-5  # difference of two curvatures below which they are the same
_FIRST_JUMP_PER_MM, _JUMP_DECREASE, _LAST_JUMP_PER_MM = 0.06, 0.55, 1e-7
"""Jump below which all jumps count alike: in the first round, its factor from round to round, in the last one."""
_JOINT_PER_MM = 5e-3  # jumps from here on are joints
_ROUNDING_OF_CURVATURE = 4.5  # noise of the difference of two curvatures, in that of the points over spacing squared
_MAX_TURN_RAD = 1.0  # of a cell: lengths of arcs are found for it
_MIN_SIGMA_MM = 1e-10
_COST_POWER = 0.25
"""Cost of a jump is its size by the points to the power of minus this: with more, three points at the inflection of two
arcs, which happen to lie on a line, count as one; with less, lines get waves."""
_LINE_OF_THREE = 3.0  # bend of three points relative to a change from three to three: they agree by chance more often
_CORNER_COST = 3.0  # of a corner of a radian, in the median cost of a jump of the curvature of 1 per mm
_CORNER_RAD, _SAME_MM = 1e-4, 1e-9


@dataclass(frozen=True, eq=False)
class ArcChain:
    """Arcs that meet tangentially, but for corners.

    - `lengths`: length along the chain at which each arc begins, and its end, (n + 1,).
    - `origins`, `angles`, `curvatures`: start, angle of the tangent there, and curvature of each arc, (n,).
    - `points`: points (m, 2) of the curve that belong to the input points.
    - `offsets`: distances (m,) of the input points from the curve in mm, positive to the left of it.
    """

    lengths: Floats
    origins: Complex
    angles: Floats
    curvatures: Floats
    points: Floats
    offsets: Floats

    def at(self, lengths: Floats) -> tuple[Floats, Floats]:
        """Return points and unit tangents (k, 2) at increasing lengths (k,) along the chain.

        At a corner the first length has the tangent after it, the last one that before it.
        """
        inside = np.append(lengths[:-1], lengths[-1] - _SAME_MM)
        arc = np.clip(np.searchsorted(self.lengths, inside, side="right") - 1, 0, len(self.angles) - 1)
        chords, turns = _chords(lengths - self.lengths[arc], self.curvatures[arc])
        start = np.exp(1j * self.angles[arc])
        return _real(self.origins[arc] + chords * start), _real(start * np.exp(1j * turns))

    @property
    def joints(self) -> Floats:
        """Lengths of both ends, of corners, and of joints at which the curvature jumps by `_JOINT_PER_MM` or more."""
        turns = self.angles[1:] - self.angles[:-1] - self.curvatures[:-1] * np.diff(self.lengths)[:-1]
        corners = np.abs(np.exp(1j * turns) - 1.0) > _CORNER_RAD
        jumps = (np.abs(np.diff(self.curvatures)) >= _JOINT_PER_MM) | corners
        return self.lengths[np.pad(jumps, 1, constant_values=True)]


def _real(numbers: Complex) -> Floats:
    return np.column_stack((numbers.real, numbers.imag))


def _chords(lengths: Floats, curvatures: Floats) -> tuple[Complex, Floats]:
    """Chords (n,) of arcs that start along x, and the angles (n,) by which they turn."""
    turns = curvatures * lengths
    return lengths * np.sinc(0.5 * turns / np.pi) * np.exp(0.5j * turns), turns


@dataclass(frozen=True, eq=False)
class _Cells:
    """Cells of constant curvature between points: `interval` of each (n,), and number of its `first` cell (m,)."""

    interval: Ints
    first: Ints

    @classmethod
    def of(cls, spacing: Floats) -> "_Cells":
        """Cells in intervals (m,), two or more in each."""
        counts = np.clip(np.ceil(spacing / _CELL_MM), 2, _MAX_CELLS).astype(np.int64)
        return cls(np.repeat(np.arange(len(counts)), counts), np.cumsum(counts) - counts)

    def shape(self, curvatures: Floats, spacing: Floats) -> tuple[Floats, Complex, Floats, Floats]:
        """Shape of cells with curvatures (n,) in the frames of the chords of their intervals, of lengths (m,).

        Returned: lengths, starts and angles of the tangents there (n,); angles at the ends of the intervals (m,).
        """
        lengths = (spacing / np.bincount(self.interval))[self.interval]
        for _ in range(_LENGTH_ROUNDS):
            steps, turns = _chords(lengths, curvatures)
            angles = self._summed(turns)
            steps = steps * np.exp(1j * angles)
            ends = np.add.reduceat(steps, self.first)
            lengths = lengths * (spacing / np.abs(ends))[self.interval]
        first = -np.angle(ends)
        starts = self._summed(steps) * np.exp(1j * first)[self.interval]
        return lengths, starts, angles + first[self.interval], first + np.add.reduceat(turns, self.first)

    def _summed(self, values: NDArray) -> NDArray:  # type: ignore[type-arg]
        """Sums (n,) of the values of the cells before each in its interval."""
        before = np.cumsum(values) - values
        return before - before[self.first][self.interval]


def arc_chain(points: Floats, sigma_mm: float = 0.0) -> ArcChain:
    """Return the chain of arcs through points (n, 2) in mm, or near them.

    - `points`: in order along the curve, ten or more, neighbours differing.
    - `sigma_mm`: standard deviation of the noise of the points, as of rounding; 0 for a curve through all of them.
    """
    sigma, drawn = max(sigma_mm, _MIN_SIGMA_MM), points @ np.array([1.0, 1.0j])
    steps: Complex = np.diff(drawn)
    cells = _Cells.of(np.abs(steps))
    interval, n_points, n_cells = cells.interval, len(points), len(cells.interval)
    normals = np.gradient(drawn) * 1.0j
    normals /= np.abs(normals)
    jumps = diags([-1.0, 1.0], [0, 1], shape=(n_cells - 1, n_cells), format="csr")
    costs, corner_costs = _costs(steps, interval, sigma)
    left, right = np.flatnonzero(interval < n_points - 2), np.flatnonzero(interval > 0)
    entries = np.append(interval[left], interval[right] - 1), np.append(left, right)
    curvatures, offsets = np.zeros(n_cells), np.zeros(n_points)
    stiffness, threshold, weights, corners = 1.0, _FIRST_JUMP_PER_MM, costs, np.zeros(n_points - 2)
    both = eye_array(n_points - 2, format="csr")
    for _ in range(_ROUNDS):
        steps = np.diff(drawn + offsets * normals)
        spacing = np.abs(steps)
        lengths, starts, angles, ends = cells.shape(curvatures, spacing)
        # the tangents of both sides of a point agree: sum_k from_end_k kappa_k + sum_k from_start_k kappa_k = turn
        middles = starts.real + 0.5 * lengths * np.cos(angles + 0.5 * curvatures * lengths)
        from_end = lengths * middles / spacing[interval]
        equations = csr_matrix((np.append(from_end[left], (lengths - from_end)[right]), entries))
        bends = [1.0 / spacing[:-1], -1.0 / spacing[:-1] - 1.0 / spacing[1:], 1.0 / spacing[1:]]
        displaced = diags(bends, [0, 1, 2], shape=(n_points - 2, n_points))
        kinks = ends[:-1] - angles[cells.first[1:]] - np.angle(steps[1:] / steps[:-1])
        hold = corner_costs * (corners**2 + threshold**2) ** -_POWER
        blocks = [
            [jumps.T @ diags(weights) @ jumps, None, None, equations.T],
            [None, diags(np.full(n_points, stiffness)), None, -sigma * displaced.T],
            [None, None, diags(hold), both],
            [equations, -sigma * displaced, both, None],
        ]
        load = np.zeros(n_cells + 3 * n_points - 4)
        load[2 - n_points :] = equations @ curvatures - displaced @ offsets - kinks
        solution = splu(bmat(blocks, format="csc")).solve(load)
        curvatures, offsets, corners, _ = np.split(solution, np.cumsum([n_cells, n_points, n_points - 2]))
        offsets = sigma * offsets
        curvatures = np.clip(curvatures, -_MAX_TURN_RAD / lengths, _MAX_TURN_RAD / lengths)
        stiffness *= float(np.clip(np.sqrt(np.mean(offsets**2)) / sigma, 0.5, 2.0))
        weights = costs * ((jumps @ curvatures) ** 2 + threshold**2) ** -_POWER
        threshold = max(_JUMP_DECREASE * threshold, _LAST_JUMP_PER_MM)
    on_curve = drawn + offsets * normals
    steps = np.diff(on_curve)
    lengths, starts, angles, _ = cells.shape(curvatures, np.abs(steps))
    origins = on_curve[interval] + starts * (steps / np.abs(steps))[interval]
    angles = angles + np.angle(steps)[interval]
    return ArcChain(np.append(0.0, lengths.cumsum()), origins, angles, curvatures, _real(on_curve), -offsets)


def _costs(steps: Complex, interval: Ints, sigma: float) -> tuple[Floats, Floats]:
    """Costs of jumps of the curvature behind each cell (n - 1,), in the median one, and of corners at points (m - 1,).

    Jumps cost most where they contradict the points: inside of three on a line, or four on an arc. Corners cost least
    between such lines and arcs.

    - `steps`: from each point to the next (m,).
    - `interval`: of each cell (n,).
    """
    behind, ahead = steps[:-1], steps[1:]
    circles = 2.0 * (behind.conj() * ahead).imag / np.abs(behind * ahead * (behind + ahead))
    bend = np.pad(_LINE_OF_THREE * np.abs(circles), 1, constant_values=np.inf)  # of three points, by the middle one
    change = np.pad(np.abs(np.diff(circles)), 2, constant_values=np.inf)  # of four points, by the interval after it
    round_off = _ROUND_OFF_PER_MM + _ROUNDING_OF_CURVATURE * sigma / np.abs(steps) ** 2
    at_points = np.minimum.reduce([bend[1:-1], change[1:-2], change[2:-1]]) + round_off[1:]
    between = np.minimum.reduce([bend[:-1], bend[1:], change[:-2], change[1:-1], change[2:]]) + round_off
    inner = interval[:-1]
    jump = np.where(inner == interval[1:], between[inner], np.append(at_points, np.inf)[inner])
    corners = _CORNER_COST * np.sqrt(np.maximum(between[:-1], between[1:]) / at_points)
    costs = jump**-_COST_POWER
    return costs / float(np.median(costs)), corners
