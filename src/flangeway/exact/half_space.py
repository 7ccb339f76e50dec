"""Displacements of a half-space's surface by uniform tractions on rectangles (Boussinesq, Cerruti; Love, 1929).

With the distance ``r^2 = x^2 + z^2`` and the axes x, n (outwards) and z, unit point forces move the surface by

    u_n = (1 - nu) / (2 pi G r),  u_x = (1 - 2 nu) x / (4 pi G r^2)          by a force along n,
    u_x = ((1 - nu) / r + nu x^2 / r^3) / (2 pi G),  u_z = nu x z / (2 pi G r^3),
    u_n = -(1 - 2 nu) x / (4 pi G r^2)                                        by a force along x

(Johnson, 1985, "Contact Mechanics", 3.2 and 3.6), and alike by one along z. Every kernel is ``z^2 / r^3``,
``x z / r^3`` or ``x / r^2`` with x and z in either order. They are integrated in closed form, over the rectangle under
load and, for the mean displacement, over the other one.
"""

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from flangeway.errors import InputError
from flangeway.types import Floats

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
    # even cells have few distances: each is evaluated once
    _, first, places = np.unique(np.round(apart / np.ptp(bounds), 12), return_index=True, return_inverse=True)
    x = apart.ravel()[first]
    z = strip * np.arange(-1.0, n_strips + 1.0)[:, None]
    x, z = np.broadcast_arrays(x, z)
    r = np.hypot(x, z)
    over = np.diff(bounds) * strip * (np.diff(bounds)[:, None] * strip)
    square, mixed, odd = _PRIMITIVES

    def integrated(primitive: Primitive, *, swapped: bool) -> Floats:
        corners = np.diff(primitive(z, x, r) if swapped else primitive(x, z, r), n=2, axis=0)
        corners = np.diff(np.diff(corners[:, places.reshape(apart.shape)], axis=1), axis=2)
        return -corners / over

    xx_zz = integrated(square, swapped=True), integrated(square, swapped=False)  # of x^2 / r^3 and z^2 / r^3
    inverse = (1.0 - poisson) * (xx_zz[0] + xx_zz[1])
    shear = young / (2.0 + 2.0 * poisson)
    full: dict[tuple[int, ...], Floats] = {
        (0, 0): inverse + poisson * xx_zz[0],
        (1, 1): inverse,
        (2, 2): inverse + poisson * xx_zz[1],
    }
    half = 0.5 - poisson
    for place, kernel, swapped in (((0, 1), odd, False), ((2, 1), odd, True)):
        if {place, place[::-1]} & set(pairs):
            full[place] = half * integrated(kernel, swapped=swapped)
            full[place[::-1]] = -full[place]
    if {(0, 2), (2, 0)} & set(pairs):
        full[0, 2] = full[2, 0] = poisson * integrated(mixed, swapped=False)
    return {pair: full[pair] / (2.0 * np.pi * shear) for pair in pairs}


def _times_log(factor: Floats, value: Floats) -> Floats:
    """``factor log(value)``, 0 where the value is 0 (the factor is then 0 too)."""
    return factor * np.log(np.where(value > 0.0, value, 1.0))


def _sum(x: Floats, r: Floats, other: Floats) -> Floats:
    """``x + r`` without cancellation for x < 0, where ``r^2 = x^2 + other^2``."""
    return np.where(x >= 0.0, r + x, other**2 / np.where(x < 0.0, r - x, 1.0))


_PRIMITIVES: tuple[Primitive, Primitive, Primitive] = (
    lambda x, z, r: r**3 / 6.0 - x**2 * r / 2.0 + _times_log(x**2 * z, _sum(z, r, x)) / 2.0,
    lambda x, z, r: -(x * z * r + (_times_log(x**3, _sum(z, r, x)) + _times_log(z**3, _sum(x, r, z))) / 2.0) / 3.0,
    lambda x, z, r: (
        _times_log(x * (3.0 * z**2 - x**2) / 6.0, r) + z**3 * _arctan(x, z) / 6.0 + x**2 * z * _arctan(z, x) / 2.0
    ),
)
"""Functions whose ``d4 / dx^2 dz^2`` are z^2 / r^3, x z / r^3 and x / r^2."""


def _arctan(y: Floats, x: Floats) -> Floats:
    """``arctan(y / x)``, 0 for x = 0."""
    return np.arctan(y / np.where(x == 0.0, np.inf, x))
