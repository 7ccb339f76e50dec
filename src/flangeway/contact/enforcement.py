"""How the condition of no penetration is enforced."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from flangeway.checks import check_positive
from flangeway.contact.pairs import Pairs
from flangeway.errors import InputError, short
from flangeway.types import Floats


@dataclass(frozen=True)
class Penalty:
    """Contact pressure in proportion to the penetration (Moherdaui 2021, 2.66, signs of the errata).

    Parameters
    ----------
    value
        The penalty, > 0. There is no default: it depends on the material, the size of the elements and the accuracy
        that is wanted. A contact without it names a first choice for its bodies.
    per
        ``"node"``: force per penetration at each secondary node (Moherdaui 2021, 3.5), with `NodeToSegment` only.
        ``"length"``: pressure per penetration, so that the answer does not depend on the number of nodes (Moherdaui
        2021, 3.5.8).

    """

    value: float | None
    per: Literal["node", "length"]

    def __post_init__(self) -> None:
        _refuse_bad_penalty(type(self).__name__, self.value, self.per)

    def compliances(self, pairs: Pairs) -> Floats:
        """Penetration per force of each constraint, shape (m,)."""
        return _compliances(self.value, self.per, pairs.areas)

    @property
    def penetration(self) -> float:
        """Maximum penetration that is tolerated: any."""
        return np.inf


@dataclass(frozen=True)
class AugmentedLagrange:
    """A penalty about forces that are corrected until the penetration is within a tolerance (Uzawa's method).

    Parameters
    ----------
    value, per
        As in `Penalty`. The larger, the fewer corrections are needed.
    penetration
        Maximum penetration, and maximum gap under pressure, that is tolerated; a length > 0.

    """

    value: float | None
    per: Literal["node", "length"]
    penetration: float

    def __post_init__(self) -> None:
        _refuse_bad_penalty(type(self).__name__, self.value, self.per)
        advice = "a thousandth of the expected approach is a usual choice"
        check_positive("AugmentedLagrange", "penetration", self.penetration, "a positive length", advice)

    def compliances(self, pairs: Pairs) -> Floats:
        """Penetration per force about the last correction, shape (m,).

        Constraints that the primary faces in part are as stiff as whole ones, since the answer does not depend on it
        and corrections of softer ones would take long.
        """
        return _compliances(self.value, self.per, pairs.whole_areas)


@dataclass(frozen=True)
class Multiplier:
    """Forces as unknowns that leave no penetration (Lagrange multipliers with an active set)."""

    def compliances(self, pairs: Pairs) -> Floats:
        """Nothing gives, shape (m,)."""
        return np.zeros(len(pairs.keys))

    @property
    def penetration(self) -> float:
        """Maximum penetration that is tolerated; the solver's own tolerance decides."""
        return np.inf


Enforcement = Penalty | AugmentedLagrange | Multiplier


def _refuse_bad_penalty(name: str, value: float | None, per: str) -> None:
    if value is not None:
        advice = "start with ten times E / (1 - nu^2) over the size of the elements, per='length'"
        check_positive(name, "value", value, advice=advice)
    if per not in ("node", "length"):
        raise InputError(f"{name}(per={short(per)})", "'node' or 'length'", "choose one of these")


def _compliances(value: float | None, per: str, areas: Floats) -> Floats:
    assert value is not None  # a contact refuses a penalty without a value
    return np.full(len(areas), 1.0 / value) if per == "node" else 1.0 / (value * areas)
