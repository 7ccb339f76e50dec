"""Influence among cells of a surface, as if there were half-spaces between each two of them."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from flangeway.exact import half_space_blocks
from flangeway.materials import Elastic
from flangeway.types import Floats


def half_spaces_on(
    materials: Sequence[Elastic],
    bounds: Floats,
    frames: Floats | None,
    strip: float,
    n_strips: int,
    axes: Sequence[int] = (0, 1, 2),
) -> Floats:
    """Influence among cells of a curved surface, as if there were half-spaces between each two of them.

    Parameters
    ----------
    materials
        Of one body; or of two in contact: displacements of the second one less those of the first by forces on the
        second, whose cells are those of the first one.
    bounds
        Ends of the cells as lengths along the surface, rising, shape (n + 1,).
    frames
        Axes tangent, first body on the left, outward normal and z of the cells, rows of (n, 3, 3); None: the surface is
        a plane.
    strip, n_strips
        Width and number of the strips along z.
    axes
        Components of displacements and forces along the frames: 0 tangent, 1 normal, 2 z.

    Returns
    -------
    Floats
        By distance, displacement with its axis, and force with its axis: shape (n_strips, n, m, n, m) for m axes.

    """
    # for the second body, the other side of the surface, n and the angles change their signs: of equal bodies
    # displacements along n by forces along the surface are the opposite of each other
    signs = {
        (of, by): 1.0 if (of == 1) == (by == 1) else -1.0
        for of, by in product((0, 1, 2) if 2 in axes else (0, 1), repeat=2)
    }
    if len(materials) == 2 and materials[0] == materials[1]:
        signs = {pair: sign for pair, sign in signs.items() if sign > 0.0}
    flat = {
        each: half_space_blocks(each.young, each.poisson, bounds, strip, n_strips, list(signs))
        for each in dict.fromkeys(materials)
    }
    one = np.ones((len(bounds) - 1,) * 2)
    turn = {(0, 0): one, (1, 1): one, (2, 2): one}
    if frames is not None:
        # each frame is turned by half of the angle a between both from that of the plane: T E T for the first body
        tangents = frames[:, 0, :2] @ np.array([1.0, 1j])
        half = np.sqrt(tangents / tangents[:, None])  # exp(i a / 2)
        turn |= {(0, 0): half.real, (1, 1): half.real, (0, 1): half.imag, (1, 0): -half.imag}
    total = np.zeros((len(axes), len(axes), n_strips, *one.shape))
    for (row, column), sign in signs.items():
        both = flat[materials[0]][row, column]
        for other in materials[1:]:
            both = both + sign * flat[other][row, column]
        for (i, of), (j, by) in product(enumerate(axes), repeat=2):
            if (of, row) in turn and (column, by) in turn:
                total[i, j] += turn[of, row] * turn[column, by] * both
    return total.transpose(2, 3, 0, 4, 1)
