"""Integrals of the gap over pieces of straight edges, in closed form with their first derivatives.

Between straight edges the gap along the secondary's normal is linear over a piece. In the axes of the secondary edge
(t along it, n its outward normal) the ends of the primary edge are at ``(a_t, a_n)`` and ``(b_t, b_n)``, their feet at
the parameters ``A = a_t / L`` and ``B = b_t / L``, and

    g(xi) = a_n h_a(xi) + b_n h_b(xi),   h_a = (B - xi) / (B - A),   h_b = (xi - A) / (B - A),

whose derivatives by ``a_n, b_n, A, B`` are ``h_a, h_b, -m h_a, -m h_b`` with the slope ``m = (b_n - a_n) / (B - A)``.
"""

import numpy as np

from flangeway.types import Bools, Floats


def straight_integrals(
    limits: tuple[Floats, Floats],
    feet: tuple[Bools, Bools],
    secondary: Floats,
    primary: Floats,
    edge_lengths: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Integrate the gap with both hat functions over p pieces.

    Parameters
    ----------
    limits
        Parameters of the pieces' starts and ends on the secondary edges, each (p,).
    feet
        Whether a start is the foot of the primary edge's end, and an end that of its start, each (p,).
    secondary, primary
        Positions of each piece's edges' ends, shapes (p, 2, 2).
    edge_lengths
        Undeformed lengths of the secondary edges, shape (p,).

    Returns
    -------
    tuple
        ``int phi_r g ds``, shape (2, p); its derivatives by the secondary's and then the primary's ends, (2, p, 8);
        ``int phi_r ds``, (2, p); ``int phi_r N_a ds`` with the primary's functions N, (2, p, 2).

    """
    chord = secondary[:, 1] - secondary[:, 0]
    length = np.hypot(chord[:, 0], chord[:, 1])
    tx, ty = chord[:, 0] / length, chord[:, 1] / length
    (a_t, a_n), (b_t, b_n) = (_local(primary[:, end] - secondary[:, 0], tx, ty) for end in range(2))
    foot_a, foot_b = a_t / length, b_t / length
    start, end = limits

    width = end - start
    middle = (start + end) / 2.0
    spread = width**2 / 12.0  # of a parameter's square about its mean, by the width
    reach = foot_b - foot_a
    slope = (b_n - a_n) / reach
    # means over the piece of the hats phi_1 = xi, phi_0 = 1 - xi and of their products with h_a and h_b
    mean_b = (middle - foot_a) / reach
    with_b = np.stack(((1.0 - middle) * mean_b - spread / reach, middle * mean_b + spread / reach))
    hats = np.stack((1.0 - middle, middle))
    scale = width * edge_lengths
    lengths = hats * scale
    by_b = with_b * scale
    by_a = lengths - by_b
    values = by_a * a_n + by_b * b_n

    at_a = np.where(feet[1], edge_lengths * a_n, 0.0)
    at_b = np.where(feet[0], edge_lengths * b_n, 0.0)
    foot_a_by = np.stack(((1.0 - foot_a) * at_a, foot_a * at_a)) - slope * by_a
    foot_b_by = -np.stack(((1.0 - foot_b) * at_b, foot_b * at_b)) - slope * by_b
    along_a, along_b = foot_a_by / length, foot_b_by / length
    turn = by_a * a_t + by_b * b_t - along_a * a_n - along_b * b_n
    gradient = np.empty((*values.shape, 4, 2))
    _into(gradient[:, :, 2], along_a, by_a, tx, ty)
    _into(gradient[:, :, 3], along_b, by_b, tx, ty)
    _into(gradient[:, :, 1], -(along_a * foot_a + along_b * foot_b), -turn / length, tx, ty)
    gradient[:, :, 0] = -gradient[:, :, 1:].sum(axis=2)  # gaps do not change when all moves alike
    return values, gradient.reshape(*values.shape, 8), lengths, np.stack((by_a, by_b), axis=-1)


def _local(vector: Floats, tx: Floats, ty: Floats) -> tuple[Floats, Floats]:
    """Components along t and along ``n = (t_y, -t_x)``."""
    return vector[:, 0] * tx + vector[:, 1] * ty, vector[:, 0] * ty - vector[:, 1] * tx


def _into(target: Floats, along: Floats, across: Floats, tx: Floats, ty: Floats) -> None:
    """Put a vector of components along t and n into the axes of space."""
    target[..., 0] = along * tx + across * ty
    target[..., 1] = along * ty - across * tx
