"""A half-space under uniform tractions on rectangles: displacements of its surface, and stresses inside."""

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
import scipy.fft

from flangeway.errors import InputError
from flangeway.types import Floats

# --- Displacements of a half-space's surface by uniform tractions on rectangles (Boussinesq, Cerruti; Love, 1929).
#
# With the distance ``r^2 = x^2 + z^2`` and the axes x, n (outwards) and z, unit point forces move the surface by
#
#     u_n = (1 - nu) / (2 pi G r),  u_x = (1 - 2 nu) x / (4 pi G r^2)          by a force along n,
#     u_x = ((1 - nu) / r + nu x^2 / r^3) / (2 pi G),  u_z = nu x z / (2 pi G r^3),
#     u_n = -(1 - 2 nu) x / (4 pi G r^2)                                        by a force along x
#
# (Johnson, 1985, "Contact Mechanics", 3.2 and 3.6), and alike by one along z. Every kernel is ``z^2 / r^3``, ``x z /
# r^3`` or ``x / r^2`` with x and z in either order. They are integrated in closed form, over the rectangle under load
# and, for the mean displacement, over the other one.


Primitive = Callable[[Floats, Floats, Floats], Floats]


def half_space_influence(
    young: float,
    poisson: float,
    bounds: Floats,
    strip: float,
    n_strips: int,
    axes: Sequence[int] = (0, 1, 2),
) -> Floats:
    """Mean displacements of cells by unit forces, spread evenly, on cells of strips at distances along z.

    Parameters
    ----------
    young, poisson
        Young's modulus and Poisson's ratio of the half-space.
    bounds
        Ends of the cells across, rising, shape (n_cells + 1,).
    strip
        Width dz of the strips.
    n_strips
        Number of distances 0, dz, 2 dz, ...
    axes
        Which of x, n, z.

    Returns
    -------
    Floats
        Shape (n_strips, m n_cells, m n_cells) for m axes, by displacement and force, as from
        `flangeway.solve.ComplianceTable.influence`.

    """
    pairs = list(product(axes, repeat=2))
    blocks = half_space_blocks(young, poisson, bounds, strip, n_strips, pairs)
    n_cells, m = len(bounds) - 1, len(axes)
    result = np.empty((n_strips, n_cells, m, n_cells, m))
    for (i, of), (j, by) in product(enumerate(axes), repeat=2):
        result[:, :, i, :, j] = blocks[of, by]
    return result.reshape(n_strips, n_cells * m, n_cells * m)


def half_space_blocks(
    young: float,
    poisson: float,
    bounds: Floats,
    strip: float,
    n_strips: int,
    pairs: Sequence[tuple[int, ...]],
) -> dict[tuple[int, ...], Floats]:
    """As `half_space_influence`, by some pairs of axes of displacement and force, (n_strips, n_cells, n_cells) each."""
    bounds = np.asarray(bounds, dtype=np.float64)
    if bounds.ndim != 1 or not (np.diff(bounds) > 0.0).all() or not (strip > 0.0 and n_strips >= 1):
        raise InputError(
            f"cells between {bounds.shape} ends and {n_strips} strips of {strip}",
            "rising ends, one strip or more of a width > 0",
            "give the ends of the cells",
        )
    # differences of a primitive over the corners under load, and over those of the displaced cell for its mean
    apart = bounds[:, None] - bounds
    # even cells have few distances: each is evaluated once, and that to the other side has its value or the opposite
    distances = np.abs(apart).ravel()
    _, first, of_distance = np.unique(np.round(distances / np.ptp(bounds), 12), return_index=True, return_inverse=True)
    x = np.maximum(distances[first], ZERO)
    z = np.maximum(strip * np.abs(np.arange(-1.0, n_strips + 1.0))[:, None], ZERO)
    x, z = np.broadcast_arrays(x, z)
    r = np.hypot(x, z)
    over = np.diff(bounds) * strip * (np.diff(bounds)[:, None] * strip)

    def integrated(primitive: Primitive, *, swapped: bool, odd_x: bool = False, odd_z: bool = False) -> Floats:
        values = primitive(z, x, r) if swapped else primitive(x, z, r)
        if odd_z:
            values[0] *= -1.0
        corners = np.diff(values, n=2, axis=0)[:, of_distance.reshape(apart.shape)]
        if odd_x:
            corners *= np.sign(apart)
        return -np.diff(np.diff(corners, axis=1), axis=2) / over

    square, mixed, odd = _PRIMITIVES
    xx_zz = integrated(square, swapped=True), integrated(square, swapped=False)  # of x^2 / r^3 and z^2 / r^3
    inverse = (1.0 - poisson) * (xx_zz[0] + xx_zz[1])
    shear = young / (2.0 + 2.0 * poisson)
    full: dict[tuple[int, ...], Floats] = {
        (0, 0): inverse + poisson * xx_zz[0],
        (1, 1): inverse,
        (2, 2): inverse + poisson * xx_zz[1],
    }
    half = 0.5 - poisson
    for indices, kernel, swapped in (((0, 1), odd, False), ((2, 1), odd, True)):
        if {indices, indices[::-1]} & set(pairs):
            full[indices] = half * integrated(kernel, swapped=swapped, odd_x=not swapped, odd_z=swapped)
            full[indices[::-1]] = -full[indices]
    if {(0, 2), (2, 0)} & set(pairs):
        full[0, 2] = full[2, 0] = poisson * integrated(mixed, swapped=False, odd_x=True, odd_z=True)
    return {pair: full[pair] / (2.0 * np.pi * shear) for pair in pairs}


ZERO = 1e-100
"""A length for none: where a logarithm or a quotient has no limit its factor is 0, and no square is too large."""
_PRIMITIVES: tuple[Primitive, Primitive, Primitive] = (
    lambda x, z, r: x**2 * z * (z / (6.0 * (r + z)) - z / (3.0 * (r + x)) + np.arcsinh(z / x) / 2.0),
    lambda x, z, r: (
        2.0 * (x * z) ** 2 / (3.0 * (r + x + z)) - (x**3 * np.arcsinh(z / x) + z**3 * np.arcsinh(x / z)) / 6.0
    ),
    lambda x, z, _: (
        (3.0 * z**2 * x * np.log1p((x / z) ** 2) - x**3 * np.log1p((z / x) ** 2)) / 12.0
        + z**3 * np.arctan(x / z) / 6.0
        + x**2 * z * np.arctan(z / x) / 2.0
    ),
)
"""Functions whose ``d4 / dx^2 dz^2`` are z^2 / r^3, x z / r^3 and x / r^2 at x, z > 0, as even or odd as these.

Terms that are linear in x or z, which the differences remove, are left out: of long cells they would be the largest.
"""


# --- Stresses inside a half-space under uniform tractions on rectangles.
#
# With the distance r from a point of the loaded surface, ``V = int p / r``, ``X = int p log(d + r)`` and
# ``W = int p (d log(d + r) - r)`` at the depth d, a pressure p gives (Love, 1929, Phil. Trans. R. Soc. A 228)
#
#     s_dd = (V_d - d V_dd) / (2 pi),       s_xd = -d V_xd / (2 pi),
#     s_xx = (2 nu V_d - d V_xx - (1 - 2 nu) X_xx) / (2 pi),   s_xz = -(d V_xz + (1 - 2 nu) X_xz) / (2 pi)
#
# and alike along z, and a shear traction p along x (Cerruti; Johnson, 1985, "Contact Mechanics", 3.7)
#
#     s_xx = (2 (1 + nu) V_x + 2 nu W_xxx - d X_xxx) / (2 pi),      s_dd = -d V_xd / (2 pi),
#     s_zz = (2 nu V_x + 2 nu W_xzz - d X_xzz) / (2 pi),            s_xd = (V_d - d V_xx) / (2 pi),
#     s_xz = (V_z + 2 nu W_xxz - d X_xxz) / (2 pi),                 s_dz = -d V_xz / (2 pi).
#
# Derivatives of the integrals are sums over the corners of a rectangle.


def half_space_stresses(
    x: Floats, z: Floats, pressures: Floats, points: Floats, poisson: float, shears: Floats | None = None
) -> Floats:
    """Stresses at points of a half-space, summed over rectangles under uniform tractions.

    Parameters
    ----------
    x, z
        Ends of the rectangles across (n, 2), and along z (m, 2).
    pressures
        Shape (n, m).
    points
        Points: x, depth > 0, z, shape (k, 3).
    poisson
        Poisson's ratio.
    shears
        Shear tractions on the half-space along x and z, shape (n, m, 2); none if left out.

    Returns
    -------
    Floats
        xx, dd, zz, xd, dz, xz with d along the depth, tension positive, shape (k, 6).

    """
    loads = pressures[:, :, None] if shears is None else np.concatenate((pressures[:, :, None], shears), axis=2)
    rows, columns = np.nonzero(loads.any(axis=2))
    px, depth, pz = points.T[:, :, None, None, None]
    kernels = _kernels(px - x[rows, :, None], pz - z[columns, None, :], depth, poisson, loads.shape[2])
    total = sum(kernel[..., 0, 0] @ loads[rows, columns, number] for number, kernel in enumerate(kernels))
    return np.asarray(total).T / (2.0 * np.pi)


def half_space_field(loads: Floats, cell: tuple[float, float], depths: Floats, poisson: float, margin: int) -> Floats:
    """Stresses below even cells under uniform tractions, at all depths under the middles of the cells.

    The sum over the cells is a convolution, ``s_ij = sum over kl of K_(i-k)(j-l) t_kl``, exact by FFT at each depth.

    Parameters
    ----------
    loads
        Tractions on the half-space: the pressure (n, m, 1), shears along x and z (n, m, 2), or all (n, m, 3).
    cell
        Width of the cells along x and z.
    depths
        At the surface 0 is allowed, shape (k,).
    poisson
        Poisson's ratio.
    margin
        Cells around the loaded ones of which the stresses are returned too.

    Returns
    -------
    Floats
        Components as `half_space_stresses`, shape (6, k, n + 2 margin, m + 2 margin).

    """
    n, m = loads.shape[:2]
    # distances from the ends of a cell to the middle of another one
    a, b = (
        width * (np.arange(-count - margin, count + margin, dtype=np.float64) + 0.5)
        for width, count in zip(cell, (n, m), strict=True)
    )
    a, d = a[:, None], depths[:, None, None]
    shape = [scipy.fft.next_fast_len(2 * (count + margin) - 1, real=True) for count in (n, m)]
    spectra = scipy.fft.rfft2(loads, shape, axes=(0, 1))
    total = sum(
        scipy.fft.rfft2(kernel, shape) * spectra[..., number]
        for number, kernel in enumerate(_kernels(a, b, d, poisson, loads.shape[2]))
    )
    field = scipy.fft.irfft2(total, shape)[..., n - 1 : 2 * (n + margin) - 1, m - 1 : 2 * (m + margin) - 1]
    return field / (2.0 * np.pi)


def _kernels(a: Floats, b: Floats, d: Floats, poisson: float, n_loads: int) -> list[Floats]:
    """Sums over the corners of rectangles under unit tractions, without ``1 / 2 pi``, each (6, ..., n, m).

    - `a`, `b`: distances from the ends of the rectangles along x and z, which fit each other, (..., n + 1, m + 1).
    - `n_loads`: 1: the pressure, 2: shears along x and z, 3: all of them in this order.
    """
    corners = [_by_pressure(a, b, d, poisson)] if n_loads != 2 else []
    if n_loads != 1:
        corners += [_by_shear(a, b, d, poisson), _by_shear(b, a, d, poisson)[[2, 1, 0, 4, 3, 5]]]
    return [np.diff(np.diff(kernel, axis=-2), axis=-1) for kernel in corners]


def _by_pressure(a: Floats, b: Floats, d: Floats, poisson: float) -> Floats:
    """The six sums at one corner of each rectangle, without ``1 / 2 pi``, shape (6, ...)."""
    r = np.sqrt(a**2 + b**2 + d**2)
    share = 1.0 - 2.0 * poisson
    first = -np.arctan2(a * b, d * r)  # V_d
    second = a * b * (r**2 + d**2) / (r * (a**2 + d**2) * (b**2 + d**2))  # V_dd
    # d V_xx = d a / (r (b + r)) and alike, without cancellation for b < 0: 1 / (b + r) = (r - b) / (a^2 + d^2)
    by_a, by_b = (r - b) / (r * (a**2 + d**2)), (r - a) / (r * (b**2 + d**2))
    # arctan(b / a) - arctan(d b / (a r)) as one angle
    x_aa = np.arctan2(a * b * (r - d), a**2 * r + d * b**2)
    x_bb = np.arctan2(a * b * (r - d), b**2 * r + d * a**2)
    return np.stack(
        np.broadcast_arrays(
            2.0 * poisson * first - d * a * by_a - share * x_aa,
            first - d * second,
            2.0 * poisson * first - d * b * by_b - share * x_bb,
            -(d**2) * by_a,
            -(d**2) * by_b,
            -(d / r + share * np.log(d + r)),
        )
    )


def _by_shear(a: Floats, b: Floats, d: Floats, poisson: float) -> Floats:
    """The same by a shear traction along x; what depends on one of a and b alone cancels between corners."""
    r = np.sqrt(a**2 + b**2 + d**2)
    by_a = (r - b) / (r * (a**2 + d**2))  # V_xx / a
    logs = [np.log(np.where(c > 0.0, c + r, (r**2 - c**2) / (r - np.minimum(c, 0.0)))) for c in (b, a)]  # V_x, V_z
    rest = (2.0 * poisson + d / r) / (d + r)
    return np.stack(
        np.broadcast_arrays(
            2.0 * logs[0] + b * rest + d**2 * by_a,
            -(d**2) * by_a,
            2.0 * poisson * logs[0] - b * rest,
            -np.arctan2(a * b, d * r) - d * a * by_a,
            -d / r,
            logs[1] - a * rest,
        )
    )
