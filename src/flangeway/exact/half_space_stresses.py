"""Stresses inside a half-space under uniform pressures on rectangles (Love, 1929, Phil. Trans. R. Soc. A 228).

With the distance r from a point of the loaded surface, ``V = int p / r`` and ``X = int p log(d + r)`` at the depth d,

    s_dd = (V_d - d V_dd) / (2 pi),       s_xd = -d V_xd / (2 pi),
    s_xx = (2 nu V_d - d V_xx - (1 - 2 nu) X_xx) / (2 pi),   s_xz = -(d V_xz + (1 - 2 nu) X_xz) / (2 pi)

and alike along z. Second derivatives are sums over the corners of a rectangle.
"""

import numpy as np

from flangeway.types import Floats


def pressure_stresses(x: Floats, z: Floats, pressures: Floats, places: Floats, poisson: float) -> Floats:
    """Stresses at points of a half-space, summed over rectangles under uniform pressure.

    Parameters
    ----------
    x, z
        Ends of the rectangles across (n, 2), and along z (m, 2).
    pressures
        Shape (n, m).
    places
        Points: x, depth > 0, z, shape (k, 3).
    poisson
        Poisson's ratio.

    Returns
    -------
    Floats
        xx, dd, zz, xd, dz, xz with d along the depth, tension positive, shape (k, 6).

    """
    rows, columns = np.nonzero(pressures)
    loads = pressures[rows, columns]
    total = np.zeros((len(places), 6))
    depth = places[:, 1, None]
    for end, sign_x in ((0, 1.0), (1, -1.0)):
        for other, sign_z in ((0, 1.0), (1, -1.0)):
            a, b = places[:, 0, None] - x[rows, end], places[:, 2, None] - z[columns, other]
            total += sign_x * sign_z * np.einsum("skc,c->ks", _at_corner(a, b, depth, poisson), loads)
    result: Floats = total / (2.0 * np.pi)
    return result


def _at_corner(a: Floats, b: Floats, d: Floats, poisson: float) -> Floats:
    """The six sums at one corner of each rectangle, without ``1 / 2 pi``, shape (6, k, n)."""
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
        (
            2.0 * poisson * first - d * a * by_a - share * x_aa,
            first - d * second,
            2.0 * poisson * first - d * b * by_b - share * x_bb,
            -(d**2) * by_a,
            -(d**2) * by_b,
            -(d / r + share * np.log(d + r)),
        )
    )
