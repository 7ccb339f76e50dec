"""What a rail stands on in three dimensions: fastenings on sleepers, or their stiffness spread along the rail."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from flangeway.checks import check_integer, check_positive, is_finite, refused
from flangeway.errors import InputError, short
from flangeway.materials import Elastic
from flangeway.problems import Elasticity, Foundation, Harmonic
from flangeway.problems.edges import edge_quadrature
from flangeway.space import Space
from flangeway.types import Floats

SAME = 1e-6
"""Height of a base, over the size of a section, that is round-off."""


@dataclass(frozen=True)
class RailSupport:
    """Support of a rail in its own frame: each rail seat with its fastening, half of the sleeper and the ballast below.

    A seat acts on the base by pressures that are even, or linear for the moment, across it, against its mean
    displacement and mean rotation. Along the rail its stiffness is spread out, as it is everywhere if it is continuous.

    Parameters
    ----------
    kind
        ``"sleepers"``, or ``"continuous"``: stiffnesses over the spacing.
    spacing_mm
        Distance of the sleepers. 600: usual on main lines (UIC Code 713).
    vertical_kN_per_mm
        Stiffness of one seat. 30: pads of 100 on ballast and soil of 43 in series, a track modulus of 50 N/mm^2.
        Assumed, in the range of 10 to 100 N/mm^2 of ballasted track (Esveld, 2001, "Modern railway track").
    lateral_kN_per_mm
        40, assumed with the roll so that the gauge widens by 6.3 mm under 89 kN and 62 kN
        outwards on each: "typical good track will increase in total gage by as much as 1/4 inch" (49 CFR 213.110, note
        2 of the table; loads of the measuring car in Thompson et al., Federal Railroad Administration).
    longitudinal_kN_per_mm
        10; assumed: a resistance of about 10 kN a seat is reached at 0.5 to 2 mm (UIC Code 774-3).
    roll_kNm_per_rad
        Moment about the rail per angle. 300, see `lateral_kN_per_mm`; of this the pad of 100 kN/mm, b = 150 mm wide,
        gives ``k b^2 / 12`` = 190. The sleeper hardly turns.
    position
        Distance of the wheel from the last sleeper over the spacing: 0 over it, 0.5 in the middle, below 1.
    pad_length_mm
        Length of the seat along the rail.
    n_sleepers
        Sleepers that act one by one, about the wheel; odd, 5 to 101. There must be as many as carry load.

    Raises
    ------
    InputError
        If a value is not positive, or out of its range.

    """

    kind: Literal["sleepers", "continuous"] = "sleepers"
    spacing_mm: float = 600.0
    vertical_kN_per_mm: float = 30.0  # noqa: N815 (units)
    lateral_kN_per_mm: float = 40.0  # noqa: N815
    longitudinal_kN_per_mm: float = 10.0  # noqa: N815
    roll_kNm_per_rad: float = 300.0  # noqa: N815
    position: float = 0.0
    pad_length_mm: float = 150.0
    n_sleepers: int = 21

    def __post_init__(self) -> None:
        owner = "RailSupport"
        if self.kind not in ("sleepers", "continuous"):
            raise refused(owner, "kind", self.kind, "'sleepers' or 'continuous'", "choose one of these")
        for name in ("spacing_mm", "vertical_kN_per_mm", "lateral_kN_per_mm", "longitudinal_kN_per_mm"):
            check_positive(owner, name, getattr(self, name), advice="a rail needs support along all axes")
        check_positive(owner, "roll_kNm_per_rad", self.roll_kNm_per_rad, advice="a rail needs support against roll")
        check_positive(owner, "pad_length_mm", self.pad_length_mm)
        if self.pad_length_mm > self.spacing_mm:
            raise refused(owner, "pad_length_mm", self.pad_length_mm, "at most spacing_mm", "shorten the pads")
        if not (is_finite(self.position) and 0.0 <= self.position < 1.0):
            raise refused(owner, "position", self.position, "0 (over a sleeper) to 1, excluded", "give the share")
        check_integer(owner, "n_sleepers", self.n_sleepers, 5, 101)
        if self.n_sleepers % 2 == 0:
            raise refused(owner, "n_sleepers", self.n_sleepers, "an odd number", "add one")

    @property
    def of_seat(self) -> Floats:
        """Stiffnesses of a seat along x, y and in roll in N/mm, N/mm and N mm/rad, shape (3,)."""
        return np.array([1e3 * self.lateral_kN_per_mm, 1e3 * self.vertical_kN_per_mm, 1e6 * self.roll_kNm_per_rad])

    @property
    def per_length(self) -> Floats:
        """The same over the spacing, shape (3,)."""
        return self.of_seat / self.spacing_mm

    @property
    def sleepers_mm(self) -> Floats:
        """Places of the sleepers along z from the wheel, shape (n_sleepers,); none if the support is continuous."""
        if self.kind == "continuous":
            return np.empty(0)
        half = self.n_sleepers // 2
        # the last sleeper is behind the wheel, at z < 0; about as many are before as behind it
        first = -half if self.position <= 0.5 else -half + 1
        places: Floats = self.spacing_mm * (np.arange(first, first + self.n_sleepers, dtype=np.float64) - self.position)
        return places


def rail_problem(
    space: Space, material: Elastic, base_edges: str, support: RailSupport, name: str = "rail"
) -> Harmonic:
    """Put a rail on its support, spread along z.

    What discrete sleepers change of it is `sleeper_compliance`.

    Parameters
    ----------
    space
        Section in its own frame, x across, y up.
    material
        Its material.
    base_edges
        Edge set of the whole base.
    support
        The support.
    name
        For messages.

    Raises
    ------
    InputError
        If the edges are not the whole of a flat base.

    """
    mesh = space.mesh
    rule = edge_quadrature(space, mesh.edge_set(base_edges))
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    near = SAME * float(np.linalg.norm(high - low))
    bottom = mesh.points[mesh.boundary_edges]
    bottom = bottom[(bottom[..., 1] <= low[1] + near).all(axis=1)]
    whole, length = float(np.ptp(bottom[..., 0])) if len(bottom) else 0.0, float(rule.weights.sum())
    if float(rule.points[..., 1].max()) > low[1] + near or abs(length - whole) > near:
        raise InputError(
            f"edges {short(base_edges)} of {length:g} mm as the base of `{name}`, which is {whole:g} mm wide",
            "all edges of a flat base, and no others",
            "check the names of the outline's segments",
        )
    lateral, vertical, roll = support.per_length
    along = 1e3 * support.longitudinal_kN_per_mm / support.spacing_mm
    foundation = Foundation(base_edges, lateral / length, vertical / length, along / length, roll)
    return Harmonic(Elasticity(space, material, name=name), foundations=[foundation])
