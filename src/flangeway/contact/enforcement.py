"""How the condition of no penetration is enforced; a new way is a subclass of `Enforcement`."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flangeway.checks import check_positive
from flangeway.contact.pairs import Pairing, Pairs
from flangeway.errors import InputError, short
from flangeway.types import Floats


class Enforcement(ABC):
    """Relation of the force of a constraint to its penetration.

    The force of a closed constraint is its penetration over its compliance. Where the compliance depends on the gap,
    it is taken anew at each iteration (a secant).
    """

    @abstractmethod
    def compliances(self, pairs: Pairs) -> Floats:
        """Penetration per force of each constraint, shape (m,); 0 where none is allowed."""

    def barriers(self, pairs: Pairs) -> Floats:
        """Force times gap w of each constraint, and the gap r from which there is no force, shape (m, 2).

        A force p acts at the gap ``w / (p + w / r)``, less its penetration. Zero and infinite: there is none.
        """
        return np.tile((0.0, np.inf), (len(pairs.keys), 1))

    def tolerance(self) -> float:
        """Maximum penetration up to which forces are corrected (Uzawa's method); infinite: they are not corrected."""
        return np.inf

    def check(self, pairing: Pairing, penalty: float, node_area: float, bodies: str) -> None:  # noqa: B027 (optional)
        """Refuse what does not fit to a contact.

        Parameters
        ----------
        pairing
            Pairing of the contact.
        penalty
            Penalty that suits its bodies and meshes, pressure per length.
        node_area
            Mean area of its secondary nodes.
        bodies
            Names of its bodies, for the message.

        Raises
        ------
        InputError
            If the two do not go together.

        """


@dataclass(frozen=True)
class _WithPenalty(Enforcement):
    """What a penalty and its augmentation share; `Penalty` has the parameters."""

    value: float | None
    per: Literal["node", "length"]

    def __post_init__(self) -> None:
        if self.value is not None:
            advice = "start with ten times E / (1 - nu^2) over the size of the elements, per='length'"
            check_positive(type(self).__name__, "value", self.value, advice=advice)
        if self.per not in ("node", "length"):
            raise InputError(
                f"{type(self).__name__}(per={short(self.per)})", "'node' or 'length'", "choose one of these"
            )

    def check(self, pairing: Pairing, penalty: float, node_area: float, bodies: str) -> None:
        """See `Enforcement.check`."""
        name = type(self).__name__
        if self.per == "node" and pairing.averages:
            raise InputError(
                f"{type(pairing).__name__} with {name}(per='node') of {bodies}",
                "per='length': the gap is averaged over the surface, not taken at nodes",
                "take per='length', or NodeToSegment",
            )
        if self.value is None:
            first = penalty * (node_area if self.per == "node" else 1.0)
            raise InputError(
                f"{name} without a value for {bodies}",
                "a number > 0",
                f"for these bodies and meshes start with {name}({first:.2g}, per={self.per!r}); "
                "a larger one penetrates less",
            )

    def _compliances(self, areas: Floats) -> Floats:
        assert self.value is not None  # a contact refuses a penalty without a value
        return np.full(len(areas), 1.0 / self.value) if self.per == "node" else 1.0 / (self.value * areas)


class Penalty(_WithPenalty):
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

    def compliances(self, pairs: Pairs) -> Floats:
        """Penetration per force of each constraint, shape (m,)."""
        return self._compliances(pairs.areas)


@dataclass(frozen=True)
class AugmentedLagrange(_WithPenalty):
    """A penalty about forces that are corrected until the penetration is within a tolerance (Uzawa's method).

    Parameters
    ----------
    value, per
        As in `Penalty`. The larger, the fewer corrections are needed.
    penetration
        Maximum penetration, and maximum gap under pressure, that is tolerated; a length > 0.

    """

    penetration: float

    def __post_init__(self) -> None:
        super().__post_init__()
        advice = "a thousandth of the expected approach is a usual choice"
        check_positive("AugmentedLagrange", "penetration", self.penetration, "a positive length", advice)

    def compliances(self, pairs: Pairs) -> Floats:
        """Penetration per force about the last correction, shape (m,).

        Constraints that the primary faces in part are as stiff as whole ones, since the answer does not depend on it
        and corrections of softer ones would take long.
        """
        return self._compliances(pairs.whole_areas)

    def tolerance(self) -> float:
        """See `Enforcement.tolerance`."""
        return self.penetration


@dataclass(frozen=True)
class Multiplier(Enforcement):
    """Forces as unknowns that leave no penetration (Lagrange multipliers with an active set)."""

    def compliances(self, pairs: Pairs) -> Floats:
        """No penetration, shape (m,)."""
        return np.zeros(len(pairs.keys))


@dataclass(frozen=True)
class Barrier(Enforcement):
    """Forces of a logarithmic barrier, which keeps the surfaces apart (interior points; Moherdaui 2021, 8.1).

    The pressure at a gap g below the reach r is ``value (1 / g - 1 / r)``, the derivative of ``-value (ln(g / r) - g /
    r)``; beyond the reach it is zero. There is always a gap under pressure, of ``value`` over the pressure where that
    is high. As the value goes to zero, pressures and forces tend to those of `Multiplier` in proportion to it. Bodies
    may overlap where an iteration starts.

    Parameters
    ----------
    value
        Pressure times gap, a force per length > 0. The gap that a pressure leaves is to be small beside the elastic
        sinking of the surfaces: a thousandth of the expected pressure times the approach is a usual choice.
    reach
        Gap from which there is no pressure, a length > 0.

    """

    value: float
    reach: float

    def __post_init__(self) -> None:
        advice = "a thousandth of the expected pressure times the approach is a usual choice"
        check_positive("Barrier", "value", self.value, "a positive force per length", advice)
        check_positive("Barrier", "reach", self.reach, "a positive length", "take the expected approach")

    def compliances(self, pairs: Pairs) -> Floats:
        """No penetration, shape (m,)."""
        return np.zeros(len(pairs.keys))

    def barriers(self, pairs: Pairs) -> Floats:
        """See `Enforcement.barriers`."""
        return np.column_stack((self.value * pairs.areas, np.full(len(pairs.keys), self.reach)))
