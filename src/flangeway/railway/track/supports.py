"""What rails stand on, and axles that bend: their stiffness as inputs."""

# ruff: noqa: N815 (units in names)
from typing import Annotated, Literal, TypeAlias

import annotated_types as at
import numpy as np
from pydantic import Field, Strict, model_validator

from flangeway.elements.quadrature import gauss
from flangeway.errors import InputError
from flangeway.records import Pair, Positive, Record, refused_by_check
from flangeway.types import Floats

PAD_MM = 150.0
"""Usual length of a rail seat along the rail."""


class Seats(Record):
    """Rail seats, each with its fastening, half of the sleeper and the ballast below, in the frame of the rail.

    A seat acts on the base by pressures that are even, or linear for the moment, across it, against its mean
    displacement and mean rotation. Along the rail its stiffness is spread out, as it is everywhere if it is continuous.

    Sources: spacing of main lines (UIC Code 713); vertical 30 kN/mm: pads of 100 on ballast and soil of 43 in series, a
    track modulus of 50 N/mm^2, assumed in the range of 10 to 100 N/mm^2 of ballasted track (Esveld, 2001, "Modern
    railway track"). Lateral 40 and roll 300, assumed so that the gauge widens by 6.3 mm under 89 kN and 62 kN outwards
    on each: "typical good track will increase in total gage by as much as 1/4 inch" (49 CFR 213.110, note 2 of the
    table; loads of the measuring car in Thompson et al., Federal Railroad Administration); of the roll the pad of 100
    kN/mm, b = 150 mm wide, gives ``k b^2 / 12`` = 190. Longitudinal 10, assumed: a resistance of about 10 kN a seat is
    reached at 0.5 to 2 mm (UIC Code 774-3).
    """

    spacing_mm: Annotated[float, at.Ge(PAD_MM)] = 600.0
    """distance of the sleepers"""
    vertical_kN_per_mm: Positive = 30.0
    """vertical stiffness of rail seat, sleeper and ballast"""
    lateral_kN_per_mm: Positive = 40.0
    """their lateral stiffness"""
    longitudinal_kN_per_mm: Positive = 10.0
    """their longitudinal stiffness"""
    roll_kNm_per_rad: Positive = 300.0
    """their stiffness against roll of the rail"""

    @property
    def of_seat(self) -> Floats:
        """Stiffnesses of a seat along x, y and in roll in N/mm, N/mm and N mm/rad, shape (3,)."""
        return np.array([1e3 * self.lateral_kN_per_mm, 1e3 * self.vertical_kN_per_mm, 1e6 * self.roll_kNm_per_rad])

    @property
    def per_length(self) -> Floats:
        """The same over the spacing, shape (3,)."""
        return self.of_seat / self.spacing_mm


class Sleepers(Seats):
    """Rail seats at a distance."""

    kind: Literal["sleepers"] = "sleepers"
    """seats of sleepers"""
    position: Annotated[float, at.Ge(0.0), at.Lt(1.0)] = 0.0
    """distance of the wheelset from the last sleeper relative to the spacing: 0 over it, 0.5 between two"""
    pad_length_mm: Positive = PAD_MM
    """length of a seat along the rail"""

    @model_validator(mode="after")
    def _pads_have_room(self) -> "Sleepers":
        if self.pad_length_mm > self.spacing_mm:
            given = f"pad_length_mm = {self.pad_length_mm:g} with spacing_mm = {self.spacing_mm:g}"
            raise refused_by_check(given, "pads that are not longer than the spacing", "shorten the pads")
        return self

    def sleepers_mm(self, number: int) -> Floats:
        """Places along z from the wheel of an odd number of sleepers about it, shape (number,)."""
        half = number // 2
        # the last sleeper is behind the wheel, at z < 0; about as many are before as behind it
        first = -half if self.position <= 0.5 else -half + 1
        positions: Floats = self.spacing_mm * (np.arange(first, first + number, dtype=np.float64) - self.position)
        return positions


class Continuous(Seats):
    """The stiffnesses of rail seats over their spacing, the same everywhere along the rail."""

    kind: Literal["continuous"] = "continuous"
    """a continuous foundation"""


class Fixed(Record):
    """A rail whose base does not move."""

    kind: Literal["fixed"] = "fixed"
    """a fixed base"""


Support: TypeAlias = Annotated[Sleepers | Continuous | Fixed, Field(discriminator="kind")]
"""What a rail stands on."""


# --- Axles.


INCH = 25.4
CLASS_F = (
    (0.0, 7.375), (23.625, 7.875), (23.625, 8.75), (31.25, 8.75), (31.25, 7.53), (34.25, 7.53), (34.25, 6.19),
    (44.8, 6.19),
)  # fmt: skip
"""Half of an axle of class F (6 1/2 x 12) of the AAR: distance from the middle and diameter in inches."""


class ElasticAxle(Record):
    """An axle, symmetric about its middle, on two journals that carry the load.

    Class F of the AAR (Manual of Standards, Section G-II, table of axle journal dimensions) by default: journals 79 in
    apart and of 6.19 in, wheel seats of 8.75 in, a body of 7.875 in that tapers to 7.375 in. The ends of the wheel
    seats are inferred from 62.5 in between their outer ends and their length of 7.625 in.
    """

    kind: Literal["elastic"] = "elastic"
    """an axle that bends between its journals"""
    journals_mm: Positive = 79.0 * INCH
    """distance between the middles of the journals; less than that of the wheels for inside journals"""
    diameters_mm: Annotated[tuple[Pair, ...], Strict(False)] = tuple(
        (round(INCH * x, 6), round(INCH * d, 6)) for x, d in CLASS_F
    )
    """distances from the middle, from 0 on and not falling, and diameters there; linear between them (default: AAR
    class F)"""
    young_MPa: Positive = 210e3
    """Young's modulus"""

    @model_validator(mode="after")
    def _is_drawn(self) -> "ElasticAxle":
        drawn = np.array(self.diameters_mm, dtype=np.float64).reshape(-1, 2)
        if not len(drawn) or drawn[0, 0] != 0.0 or (np.diff(drawn[:, 0]) < 0.0).any() or (drawn[:, 1] <= 0.0).any():
            raise refused_by_check(
                f"diameters_mm = {self.diameters_mm}",
                "pairs of a distance, from 0 on and not falling, and a diameter above 0",
                "order them from the middle outwards",
            )
        return self

    def compliance(self, positions: Floats) -> Floats:
        """Deflection in mm and tilt in rad of both wheel seats against the line through the journals, shape (4, 4).

        Columns are the force upwards in N and the counter-clockwise moment in N mm at the left seat, then at the right
        one; rows what they do there. With the bending moments m of unit loads on a beam that stands on its journals
        ``C_ij = integral m_i m_j / (E I) dx``: symmetric (Maxwell, 1864). Forces along the axle do not bend it.

        Parameters
        ----------
        positions
            Positions of the left and the right seat along the axle from its middle, in mm, (2,); rising.

        Raises
        ------
        InputError
            If the wheels are not left and right of each other on the axle.

        """
        drawn, half = np.array(self.diameters_mm), self.journals_mm / 2.0
        left, right = (float(position) for position in positions)
        if not -drawn[-1, 0] <= left < right <= drawn[-1, 0]:
            raise InputError(
                f"wheels at {left:g} mm and {right:g} mm on an axle that ends at {drawn[-1, 0]:g} mm",
                "the left wheel before the right one, both on the axle",
                "correct the positions, or give a longer axle",
            )
        corners = np.array([left, right, half, -half])
        ends = np.unique(np.clip([*corners, *drawn[:, 0], *-drawn[:, 0]], corners.min(), corners.max()))
        points, weights = gauss(8)
        x = (ends[:-1, None] + np.diff(ends)[:, None] * points).ravel()
        moments = []
        for seat in (left, right):
            for force, moment in ((1.0, 0.0), (0.0, 1.0)):
                at_right = -(force * (seat + half) + moment) / self.journals_mm
                journals = at_right * np.maximum(half - x, 0.0) - (force + at_right) * np.maximum(-half - x, 0.0)
                # of what acts on the right of x
                moments.append(force * np.maximum(seat - x, 0.0) + moment * (x < seat) + journals)
        rigidity = self.young_MPa * np.pi * np.interp(abs(x), drawn[:, 0], drawn[:, 1]) ** 4 / 64.0
        return np.asarray(moments * ((np.diff(ends)[:, None] * weights).ravel() / rigidity) @ np.transpose(moments))


class RigidAxle(Record):
    """An axle that does not bend."""

    kind: Literal["rigid"] = "rigid"
    """a rigid axle"""

    def compliance(self, _positions: Floats) -> Floats:
        """See `ElasticAxle.compliance`: zero, (4, 4)."""
        return np.zeros((4, 4))


Axle: TypeAlias = Annotated[ElasticAxle | RigidAxle, Field(discriminator="kind")]
"""How an axle bends."""


# --- Sections of wheels.


class WholeWheel(Record):
    """Dimensions of a monobloc wheel inside of its running surface, x from the tape line, held at its bore.

    Those by default are assumed: a wheel of 920 mm of usual proportions, with a straight conical web and a wheel seat
    of 200 mm. No public source gives a drawing.
    """

    kind: Literal["whole"] = "whole"
    """the whole wheel with web and hub"""
    rim_mm: Positive = 65.0
    """thickness of the rim above the tape line"""
    web_mm: Annotated[tuple[Positive, Positive], Strict(False)] = (22.0, 30.0)
    """thickness of the web at the rim and at the hub"""
    web_middle_mm: Pair = (0.0, -25.0)
    """place x of the web's middle at the rim and at the hub"""
    fillet_mm: Positive = 35.0
    """radius of the four fillets between the web, rim and hub"""
    hub_mm: Pair = (-115.0, 65.0)
    """places x of the hub's inner and outer face"""
    hub_radius_mm: Positive = 140.0
    """radius of the hub"""
    bore_radius_mm: Positive = 100.0
    """radius of its bore"""

    @model_validator(mode="after")
    def _hub_has_steel(self) -> "WholeWheel":
        if not (self.hub_mm[0] < self.hub_mm[1] and self.bore_radius_mm < self.hub_radius_mm):
            raise refused_by_check(
                f"a hub from {self.hub_mm[0]:g} to {self.hub_mm[1]:g} mm and radii of {self.bore_radius_mm:g} and "
                f"{self.hub_radius_mm:g} mm",
                "an inner face left of the outer one, and a bore smaller than the hub",
                "exchange or correct them",
            )
        return self


class RimSection(Record):
    """The rim of a wheel, held at its cut."""

    kind: Literal["rim"] = "rim"
    """the rim alone, held at its cut"""


WheelSection: TypeAlias = Annotated[RimSection | WholeWheel, Field(discriminator="kind")]
"""What of a wheel is elastic."""
