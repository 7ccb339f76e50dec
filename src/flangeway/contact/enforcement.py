"""How the condition of no penetration is enforced."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Penalty:
    """Contact pressure in proportion to the penetration (seed 2.66, signs of the errata).

    Parameters
    ----------
    value
        The penalty, > 0. There is no default: it depends on the material, the size of the elements and the accuracy
        that is wanted. Ten times the plane modulus over the size of the elements is a usual first choice.
    per
        ``"node"``: force per penetration at each secondary node (seed 3.5). ``"length"``: pressure per penetration,
        so that the answer does not depend on the number of nodes (seed 3.5.8).

    """

    value: float
    per: Literal["node", "length"]

    def __post_init__(self) -> None:
        if not (np.isfinite(self.value) and self.value > 0.0):
            raise InputError(
                f"Penalty(value={self.value})",
                "a positive number",
                "start with ten times E / (1 - nu^2) over the size of the elements, per='length'",
            )
        if self.per not in ("node", "length"):
            raise InputError(f"Penalty(per={self.per!r})", "'node' or 'length'", "choose one of these")

    def compliances(self, areas: Floats) -> Floats:
        """Penetration per force of nodes with tributary areas (length times thickness)."""
        if self.per == "node":
            return np.full(len(areas), 1.0 / self.value)
        return 1.0 / (self.value * areas)
