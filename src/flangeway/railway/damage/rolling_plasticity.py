"""Repeated rolling of a line contact with plasticity, in the moving frame: residual stress, shakedown, ratchetting.

Axes: x along the surface, material moves towards -x under a contact that rolls to +x; z is the depth. Plane strain. The
stress of a cell i at one layer is

    s_i = s_elastic_i + sum over j of G_(i-j) pi_j + s_residual(z),

with the plastic strain pi_j of all cells, 0 ahead of the contact, and the residual stress that the passages before
left, which depends on the depth alone. G is the stress of eigenstrains in a half-plane: waves along x, quadratic
elements over the depth. Deviators have three components, in the base
``(xx - zz) / sqrt 2, (xx + zz - 2 yy) / sqrt 6, sqrt 2 xz``.

J2 flow with kinematic hardening (Prager), implicit along the path: with ``eta = s - C pi`` and the strain increment
``d_i = pi_i - pi_(i-1)`` from the cell ahead, ``eta_i = P(eta_i + r d_i)``, where P projects on von Mises' circle of
radius ``sqrt 2 k``; one semismooth Newton solves it for all cells that yield in a passage. r is the shear modulus: with
twice of it cells leave and enter the set of those that yield without end at ``p0 / k = 5``. Melan's limit of repeated
rolling is what passages show: shakedown where increments vanish, ratchetting where shear strain grows.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

import annotated_types as at
import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flangeway.checks import check_integer
from flangeway.exact import LineContact
from flangeway.records import NotNegative, Positive, Record
from flangeway.types import Floats

BASE = np.array(
    [
        [np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0],
        [np.sqrt(1.0 / 6.0), np.sqrt(1.0 / 6.0), -np.sqrt(2.0 / 3.0), 0.0],
        [0.0, 0.0, 0.0, np.sqrt(2.0)],
    ]
)
"""From stresses xx, zz, yy, xz to the deviator's components, whose squares sum to s : s."""
WINDOW_HALF_LENGTH = 8.0
"""Half length of the periodic window, and depth of its elements, relative to the half width of the contact."""
SKIN_THICKNESS = 0.2
"""Thickness of the uppermost layer relative to that of the others: where it flows, tractions are beyond yield in shear.

With 8 to 20 cells it flows within 3 % of ``p0 / k = 1 / mu``; thinner layers of perfectly plastic steel have increments
that Newton's method does not find."""
NEWTON_TOLERANCE, MAX_NEWTON = 1e-10, 60
"""Residual relative to the radius of yield at which a passage is solved."""
MIN_PLASTIC_STRAIN = 1e-5
"""Plastic strain of a passage over k / G below which it is none."""
MAX_STEADY_CHANGE = 1e-3
"""Change of the plastic strain from a passage to the next, relative to it, below which it is steady."""

State = Literal["elastic", "shakedown", "plastic shakedown", "ratchetting", "not settled"]


class RollingSteel(Record):
    """Steel under repeated rolling."""

    shear_yield_MPa: Positive  # noqa: N815
    """yield strength in shear k; the yield strength / 1.732"""
    young_MPa: Positive = 210e3  # noqa: N815
    """Young's modulus"""
    poisson: Annotated[float, at.Ge(0.0), at.Lt(0.5)] = 0.3
    """Poisson's ratio"""
    hardening_MPa: NotNegative = 0.0  # noqa: N815
    """back stress over plastic strain C; 0: perfectly plastic"""

    @property
    def shear_modulus(self) -> float:
        """G in MPa."""
        return self.young_MPa / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True, eq=False)
class RepeatedRolling:
    """What repeated passages leave.

    - `depths`: middles of the layers over the half width, shape (n,).
    - `residual_MPa`: residual stresses xx and yy (axial) after the last passage, shape (n, 2).
    - `strains`: plastic shear strain gamma_xz of one passage at the end, forward (as the traction drives the surface)
      positive, shape (n,).
    - `increments`: maximum plastic strain that a passage adds, over k / G, of each passage.
    - `state`: what they settle to.
    - `newton`: Newton steps of each passage.
    """

    depths: Floats
    residual_MPa: Floats  # noqa: N815
    strains: Floats
    increments: Floats
    state: State
    newton: tuple[int, ...]

    @property
    def ratchetting_depth(self) -> float | None:
        """Depth of the greatest shear strain of a passage over the half width; None: there is none."""
        return float(self.depths[np.abs(self.strains).argmax()]) if self.state == "ratchetting" else None


class RollingLine(Record):
    """A Hertz line contact that rolls over a half-plane again and again."""

    load_factor: Positive
    """p0 / k"""
    friction: Annotated[float, at.Ge(-1.0), at.Le(1.0)]
    """traction over pressure; positive where it drives the surface towards +x, the direction of rolling"""
    steel: RollingSteel
    """material"""
    cells: Annotated[int, at.Ge(4), at.Le(20)] = 12
    """cells over the half width along x; layers have the same thickness, but for `SKIN_THICKNESS`"""
    depth: Annotated[float, at.Gt(0.0), at.Le(WINDOW_HALF_LENGTH / 2.0)] = 1.25
    """depth of the layers over the half width"""

    @cached_property
    def _x(self) -> Floats:
        """Middles of the columns in the order in which material passes them: from +x to -x."""
        reach = 2 * self.cells
        return (np.arange(reach, -reach, -1, dtype=np.float64) - 0.5) / self.cells

    @cached_property
    def depths(self) -> Floats:
        """Middles of the layers over the half width."""
        return np.asarray((self._edges[1:] + self._edges[:-1]) / 2.0)

    @cached_property
    def _edges(self) -> Floats:
        """Bounds of the layers: the uppermost one is a skin, whose stress is that of the surface."""
        even = np.arange(int(np.ceil(self.depth * self.cells)) + 1) / self.cells
        return np.insert(even, 1, SKIN_THICKNESS / self.cells)

    @cached_property
    def elastic(self) -> Floats:
        """Deviators of the elastic stress over k, shape (n_z, n_x, 3)."""
        z, x = self.depths[:, None], self._x[None, :]
        factor = self.load_factor
        xx, zz, xz = np.moveaxis(LineContact(0.5 * np.pi * factor, 1.0, 2.0 * factor).stresses(x, z), -1, 0)
        # a traction q p gives zz as a pressure gives xz, and xz as it gives xx (Johnson, 1985, 7.5 to 7.8)
        along = self.friction * factor * _along_by_traction(x, z)
        xx, zz, xz = xx + along, zz + self.friction * xz, xz + self.friction * xx
        return np.asarray(np.stack((xx, zz, self.steel.poisson * (xx + zz), xz), axis=-1) @ BASE.T)

    @cached_property
    def _influence(self) -> Floats:
        """Deviators by unit plastic strain of a cell, in k by k / G, shape (n_lags, n_z, 3, n_z, 3).

        Lags are numbers of columns of the strained cell behind the other one, from -n_x to n_x of the window.
        """
        n_z, width, window = len(self.depths), 1.0 / self.cells, 2.0 * WINDOW_HALF_LENGTH
        columns = round(window / width)
        waves = np.arange(4 * columns // 2)
        q = 2.0 * np.pi * waves / window
        lags = width * np.arange(-columns, columns + 1)
        below = np.geomspace(self._edges[-1] + width, WINDOW_HALF_LENGTH, 2 + int(8 * np.log2(WINDOW_HALF_LENGTH)))
        edges = np.concatenate((self._edges, below))
        spectrum = np.stack([_layer_response(wavenumber, edges, n_z, self.steel.poisson) for wavenumber in q])
        # means over cells of what is constant in cells
        weights = np.where(waves == 0, 1.0, 2.0) * np.sinc(q * width / (2.0 * np.pi)) ** 2 * width / window
        total = (np.exp(1j * np.outer(lags, q)) * weights) @ spectrum.reshape(len(q), -1)
        return np.asarray(total.real.reshape(len(lags), n_z, 3, n_z, 3))

    @cached_property
    def _behind(self) -> Floats:
        """Deviators by a unit strain that a cell gets and all cells behind it keep.

        Shape (n_x, n_z, 3, n_x, n_z, 3): of a cell, by a cell, columns in the order of the path.
        """
        columns, n_x = round(2.0 * WINDOW_HALF_LENGTH * self.cells), len(self._x)
        sums = np.cumsum(self._influence, axis=0)
        first = (columns - n_x) // 2  # column of the window at which the layer's cells begin
        i, j = np.arange(n_x)[:, None], np.arange(n_x)[None, :]
        last = columns - 1 - first  # the end of the window, in numbers of the layer's columns
        behind = sums[columns + last - i] - sums[columns + j - i - 1]
        return np.moveaxis(behind, 1, 3)

    def residual_of(self, strain: Floats) -> Floats:
        """Residual stresses xx and yy over k by plastic strains (n_z, 3) that depend on the depth, (n_z, 2)."""
        nu = self.steel.poisson
        xx, _, yy, _ = (strain @ BASE).T
        stiffness = 2.0 / (1.0 - nu)  # E / (1 - nu^2) over G
        return -stiffness * np.stack((xx + nu * yy, yy + nu * xx), axis=1)

    def passage(self, strain: Floats, start: Floats | None = None) -> tuple[Floats, int]:
        """Plastic strains (n_x, n_z, 3), over k / G, that cells get from those ahead in one passage; and Newton steps.

        - `strain`: (n_z, 3) of the passages before.
        - `start`: increments to start from.
        """
        residual = self.residual_of(strain)
        none = np.zeros(len(residual))
        known = (
            self.elastic.transpose(1, 0, 2) + np.stack((residual[:, 0], none, residual[:, 1], none), axis=1) @ BASE.T
        )
        hardening = self.steel.hardening_MPa / self.steel.shear_modulus
        known = (known - hardening * strain).reshape(-1, 3)
        n_x, n_z = len(self._x), len(self.depths)
        shape = (n_x * n_z, 3, n_x * n_z, 3)
        matrix = self._behind.reshape(shape)
        column = np.repeat(np.arange(n_x), n_z)
        layer = np.tile(np.arange(n_z), n_x)
        radius, three = np.sqrt(2.0), np.arange(3)
        increments = np.zeros_like(known) if start is None else start.reshape(-1, 3).copy()
        for number in range(1, MAX_NEWTON + 1):
            used = np.flatnonzero(increments.any(axis=1))
            eta = known + np.einsum("icjd,jd->ic", matrix[:, :, used], increments[used])
            eta -= hardening * np.cumsum(increments.reshape(n_x, n_z, 3), axis=0).reshape(-1, 3)
            trial = eta + increments
            size = np.linalg.norm(trial, axis=1)
            active = np.flatnonzero(size > radius)
            error = np.where(
                (size > radius)[:, None], eta - radius * trial / np.maximum(size, radius)[:, None], increments
            )
            if np.abs(error).max() <= NEWTON_TOLERANCE * radius:
                return increments.reshape(n_x, n_z, 3), number
            n, ratio = trial[active] / size[active, None], radius / size[active]
            projected = ratio[:, None, None] * (np.eye(3) - n[:, :, None] * n[:, None, :])
            block = matrix[np.ix_(active, three, active, three)].copy()
            same = (layer[active, None] == layer[active]) & (column[active, None] >= column[active])
            block -= hardening * same[:, None, :, None] * np.eye(3)[None, :, None, :]
            tangent = block - np.einsum("icd,idje->icje", projected, block)
            diagonal = np.arange(len(active))
            tangent[diagonal, :, diagonal] -= projected
            moved = np.zeros_like(increments)
            # cells that leave the active set lose their increments, which moves the others
            gone = np.setdiff1d(used, active)
            moved[gone] = -increments[gone]
            by_gone = np.einsum("icjd,jd->ic", matrix[np.ix_(active, three, gone, three)], moved[gone])
            by_gone -= np.einsum("icd,id->ic", projected, by_gone)
            right = -(error[active] + by_gone)
            size_a = 3 * len(active)
            if size_a:
                solved = scipy.linalg.solve(tangent.reshape(size_a, size_a), right.ravel(), check_finite=False)
                moved[active] = solved.reshape(-1, 3)
            increments = increments + moved
        return increments.reshape(n_x, n_z, 3), MAX_NEWTON

    def repeated(self, passages: int = 400) -> RepeatedRolling:
        """Roll until passages add nothing, add always the same, or their number is reached."""
        check_integer("RollingLine.repeated", "passages", passages, 1)
        strain = np.zeros((len(self.depths), 3))
        sizes: list[float] = []
        steps: list[int] = []
        added = np.zeros_like(strain)
        state: State = "not settled"
        increments: Floats | None = None
        for _ in range(passages):
            increments, number = self.passage(strain, increments)
            steps.append(number)
            if number == MAX_NEWTON:
                break
            last, added = added, increments.sum(axis=0)
            strain = strain + added
            sizes.append(float(np.linalg.norm(increments, axis=2).sum(axis=0).max()))
            grown = float(np.abs(added).max())
            if sizes[-1] <= MIN_PLASTIC_STRAIN:
                state = "elastic" if len(sizes) == 1 else "shakedown"
                break
            if np.abs(added - last).max() <= MAX_STEADY_CHANGE * max(grown, MIN_PLASTIC_STRAIN):
                state = "ratchetting" if grown > MIN_PLASTIC_STRAIN else "plastic shakedown"
                break
        residual = self.steel.shear_yield_MPa * self.residual_of(strain)
        unit = self.steel.shear_yield_MPa / self.steel.shear_modulus
        shear = (added @ BASE)[:, 3] * unit
        return RepeatedRolling(self.depths, residual, shear, np.array(sizes), state, tuple(steps))


def _along_by_traction(x: Floats, z: Floats) -> Floats:
    """Stress xx by a traction ``sqrt(1 - x^2)`` towards +x (Johnson, 1985, 7.6)."""
    part = 1.0 - x**2 + z**2
    root = np.hypot(part, 2.0 * x * z)
    m, n = np.sqrt(np.maximum(root + part, 0.0) / 2.0), np.copysign(np.sqrt(np.maximum(root - part, 0.0) / 2.0), x)
    return np.asarray(n * (2.0 - (z**2 - m**2) / root) - 2.0 * x)


def _layer_response(q: float, edges: Floats, n_z: int, poisson: float) -> NDArray[np.complex128]:
    """Mean deviators of layers by plastic strains exp(i q x) of layers, shear modulus 1, shape (n_z, 3, n_z, 3).

    With ``u = -i U(z), w = W(z)`` times exp(i q x) strains are ``q U, W', -i (U' - q W)``: a real stiffness on
    quadratic elements between the edges, clamped at the last one.
    """
    lame = 2.0 * poisson / (1.0 - 2.0 * poisson)
    stiffness = np.array([[lame + 2.0, lame, 0.0], [lame, lame + 2.0, 0.0], [0.0, 0.0, 1.0]])
    gauss, weights = np.polynomial.legendre.leggauss(3)
    shape = np.stack((gauss * (gauss - 1.0) / 2.0, 1.0 - gauss**2, gauss * (gauss + 1.0) / 2.0), axis=1)
    slope = np.stack((gauss - 0.5, -2.0 * gauss, gauss + 0.5), axis=1)
    lengths = np.diff(edges)
    n_dofs = 2 * (2 * len(lengths) + 1)
    whole = np.zeros((n_dofs, n_dofs))
    loads = np.zeros((n_dofs, n_z, 3))
    means = []
    for number, length in enumerate(lengths):
        b = np.zeros((3, 3, 6))  # Gauss point, strain, U and W of three nodes
        b[:, 0, ::2], b[:, 1, 1::2] = q * shape, slope * 2.0 / length
        b[:, 2, ::2], b[:, 2, 1::2] = slope * 2.0 / length, -q * shape
        rows = 4 * number + np.arange(6)
        scaled = weights * length / 2.0
        whole[np.ix_(rows, rows)] += np.einsum("g,gsi,st,gtj->ij", scaled, b, stiffness, b)
        if number < n_z:
            mean = np.einsum("g,gsi->si", scaled / length, b)
            means.append((rows, mean))
            # stress of eigenstrains without volume: 2 xx, 2 zz, and the shear
            loads[rows, number] += length * mean.T @ np.diag([2.0, 2.0, 1.0])
    kept = n_dofs - 2
    moved = np.zeros_like(loads)
    moved[:kept] = scipy.linalg.solve(whole[:kept, :kept], loads[:kept].reshape(kept, -1), assume_a="pos").reshape(
        kept, n_z, 3
    )
    stress = np.zeros((n_z, 4, n_z, 4), dtype=np.complex128)
    for i, (rows, mean) in enumerate(means):
        strain = np.einsum("si,ijt->sjt", mean, moved[rows])
        response = np.einsum("st,tjk->sjk", stiffness, strain)
        stress[i, 0, :, [0, 1]], stress[i, 1, :, [0, 1]] = (response[s][:, :2].T for s in (0, 1))
        stress[i, 2, :, [0, 1]] = lame * (strain[0] + strain[1])[:, :2].T
        # shear strains enter as i gamma, shear stress leaves as -i tau
        stress[i, :2, :, 3] = 1j * response[:2, :, 2]
        stress[i, 2, :, 3] = 1j * lame * (strain[0] + strain[1])[:, 2]
        stress[i, 3, :, [0, 1]] = -1j * response[2][:, :2].T
        stress[i, 3, :, 3] = response[2, :, 2]
    unit_strains = np.diag([2.0, 2.0, 2.0, 1.0])
    for i in range(n_z):
        stress[i, :, i] -= unit_strains
    return np.asarray(np.einsum("as,isjt,bt->iajb", BASE, stress, BASE))
