"""Bending of a wheelset's axle by the forces on its wheels, by beam theory."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import as_numbers, check_positive
from flangeway.elements.quadrature import gauss
from flangeway.errors import InputError
from flangeway.types import Floats
from flangeway.units import sentence

INCH = 25.4  # mm

CLASS_F = (
    (0.0, 7.375), (23.625, 7.875), (23.625, 8.75), (31.25, 8.75), (31.25, 7.53), (34.25, 7.53), (34.25, 6.19),
    (44.8, 6.19),
)  # fmt: skip
"""Half of an axle of class F (6 1/2 x 12) of the AAR: distance from the middle and diameter in inches."""


@dataclass(frozen=True)
class Axle:
    """An axle, symmetric about its middle, on two journals that carry the load.

    Class F of the AAR (Manual of Standards, Section G-II, table of axle journal dimensions) by default: journals 79 in
    apart and of 6.19 in, wheel seats of 8.75 in, a body of 7.875 in that tapers to 7.375 in. The ends of the wheel
    seats are inferred from 62.5 in between their outer ends and their length of 7.625 in.

    Parameters
    ----------
    journals_mm
        Distance between the middles of the journals; less than that of the wheels for inside journals.
    diameters_mm
        Distances from the middle, from 0 on and not falling, and diameters there; linear between them.
    young
        Young's modulus in MPa.

    Raises
    ------
    InputError
        If a dimension is not positive, or the distances fall.

    """

    journals_mm: float = 79.0 * INCH
    diameters_mm: tuple[tuple[float, float], ...] = tuple((INCH * x, INCH * d) for x, d in CLASS_F)
    young: float = 210e3

    def __post_init__(self) -> None:
        for name in ("journals_mm", "young"):
            check_positive("Axle", name, getattr(self, name))
        drawn = as_numbers("Axle: diameters_mm", self.diameters_mm)
        if drawn.ndim != 2 or drawn.shape[1] != 2 or drawn[0, 0] != 0.0 or (np.diff(drawn[:, 0]) < 0.0).any():
            raise InputError(
                f"Axle: diameters_mm of shape {drawn.shape}", "pairs (distance, diameter) from 0", "order them"
            )
        if not (np.isfinite(drawn).all() and (drawn[:, 1] > 0.0).all()):
            raise InputError("Axle: diameters_mm that are not all positive", "positive diameters", "correct them")

    def tilts(self, places: Floats, forces: Floats) -> Floats:
        """Rotations of both wheel seats against the line through them, in rad, counter-clockwise.

        Parameters
        ----------
        places
            Places of the left and the right wheel along the axle from its middle, in mm, (2,); rising.
        forces
            What acts on each at the axle's centre line: the force upwards in N, and the counter-clockwise moment in
            N mm; (2, 2). Forces along the axle do not bend it. The journals keep the equilibrium.

        Raises
        ------
        InputError
            If the wheels are not left and right of each other on the axle.

        """
        drawn = np.array(self.diameters_mm)
        left, right = (float(place) for place in places)
        if not -drawn[-1, 0] <= left < right <= drawn[-1, 0]:
            raise InputError(
                sentence("wheels at {:g (mm)} and {:g mm} on an axle that ends at {:g mm}", left, right, drawn[-1, 0]),
                "the left wheel before the right one, both on the axle",
                "correct the places, or give a longer axle",
            )
        half = self.journals_mm / 2.0
        up, moments = forces.T
        turning = float(up @ places + moments.sum()) / half
        journals = np.array([turning - up.sum(), -turning - up.sum()]) / 2.0
        ends = np.unique(np.clip([left, right, half, -half, *drawn[:, 0], *-drawn[:, 0]], left, right))
        points, weights = gauss(8)
        x = ends[:-1, None] + np.diff(ends)[:, None] * points
        # of what acts on the right of x
        bending = sum(np.maximum(at - x, 0.0) * force for at, force in zip((-half, half), journals, strict=True))
        bending = bending + (right - x) * up[1] + moments[1]
        diameter = np.interp(abs(x), drawn[:, 0], drawn[:, 1])
        turned = np.diff(ends)[:, None] * weights * bending / (self.young * np.pi * diameter**4 / 64.0)
        share = (x - left) / (right - left)
        return np.array([-((1.0 - share) * turned).sum(), (share * turned).sum()])
