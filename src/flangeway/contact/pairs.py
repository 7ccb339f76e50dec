"""Pairing of two surfaces, and how the condition of no penetration is enforced; new ones are subclasses."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, Protocol

import numpy as np

from flangeway.checks import check_positive
from flangeway.contact.kinematics import Slides
from flangeway.contact.surface import Surface
from flangeway.errors import InputError, short
from flangeway.types import Bools, Floats, Ints

# --- Pairing of two surfaces, and the constraints that it finds; a new pairing is a subclass of `Pairing`.


@dataclass(frozen=True, eq=False)
class Constraints(ABC):
    """m constraints of one contact; their gaps are sums over p terms that touch w nodes each.

    The force of a constraint is the pressure times its area, its gap a length: an average over that area.

    Parameters
    ----------
    keys
        Identity of each constraint within the contact, shape (m,).
    partners
        Primary edge that each constraint is against, shape (m,); -1 where it may be several.
    nodes
        Position in `Surface.nodes` of the secondary of each constraint's node, shape (m,).
    gaps
        Gaps, open where positive, shape (m,).
    areas
        Area of each constraint, length times thickness, where the primary faces it, shape (m,).
    whole_areas
        Area of each constraint if the primary faced all of it, shape (m,).
    secondary_members
        Secondary points of each term, numbered as in `Surface.contact_places`, shape (p, w_s).
    primary_edges
        Primary edge of each term, shape (p,); its points follow the secondary ones.
    rows
        Constraints to which each term adds, shape (p, r).

    """

    keys: Ints
    partners: Ints
    nodes: Ints
    gaps: Floats
    areas: Floats
    whole_areas: Floats
    secondary_members: Ints
    primary_edges: Ints
    rows: Ints

    @property
    @abstractmethod
    def parts(self) -> Sequence["Pairs"]:
        """The pairing's constraints, then those of guarded nodes, as they follow each other."""

    @property
    def guarded(self) -> Bools:
        """Whether each constraint is that of a guarded node, in addition to the pairing's, shape (m,)."""
        return np.arange(len(self.keys)) >= len(self.parts[0].keys)

    @abstractmethod
    def opposite_points(self, edges: Floats) -> Floats:
        """Points that the constraints touch on primary edges with points ``edges`` (n_edges, order + 1, 2): (m, 2)."""


class Pairs(Constraints):
    """Constraints of one kind, with their derivatives."""

    @property
    def parts(self) -> Sequence["Pairs"]:
        """See `Constraints.parts`."""
        return (self,)

    @property
    @abstractmethod
    def gradients(self) -> Floats:
        """What each term adds to the derivatives of the gaps by the positions of its points, shape (p, r, w, 2)."""

    @abstractmethod
    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """Terms under load, shape (q,), and their ``sum force * second derivative``, shape (q, 2 w, 2 w)."""

    def slides(self, points: Floats, before: Floats) -> Slides:  # noqa: ARG002 (for subclasses)
        """Slips since an earlier position, by the positions of the terms' points now and then, each (p, w, 2)."""
        raise InputError(
            f"friction of constraints {type(self).__name__}",
            "a pairing whose constraints have slips",
            "write Pairs.slides, or take NodeToSegment or SegmentToSegment",
        )


class Pairing(ABC):
    """How two surfaces are compared: which constraints they have, and what the gap of each is."""

    averages: ClassVar[bool]
    """Whether the gap of a constraint is an average over its area; False: it is that of a node or point."""

    def node_areas(self, secondary: Surface) -> Floats:
        """Areas that belong to the nodes of a surface, length times thickness, shape (n_nodes,)."""
        return secondary.tributary_areas

    def key_nodes(self, secondary: Surface) -> Ints:
        """Positions in `Surface.nodes` of the nodes of all possible constraints, by key, shape (n_keys,): all nodes."""
        return np.arange(len(secondary.nodes))

    @abstractmethod
    def pair(
        self,
        secondary: Surface,
        primary: Surface,
        positions: Floats,
        primary_edges: Floats,
        kept: Ints,
        *,
        settle: bool = False,
    ) -> Pairs:
        """Find the constraints within reach.

        Parameters
        ----------
        secondary, primary
            The surfaces.
        positions
            Current positions of the secondary nodes and of the points of `Surface.bends`, shape (n_points, 2).
        primary_edges
            Current positions of the primary edges' points, shape (n_edges, order + 1, 2).
        kept
            Partner that each constraint had before, -1 for none, shape (n_keys,).
        settle
            Whether the iteration cycles, so that constraints should keep their partners if they can.

        """


# --- How the condition of no penetration is enforced; a new way is a subclass of `Enforcement`.


class HasAreas(Protocol):
    """What laws ask of constraints in the plane and in space: see `Constraints`."""

    @property
    def keys(self) -> Ints: ...  # noqa: D102
    @property
    def areas(self) -> Floats: ...  # noqa: D102
    @property
    def whole_areas(self) -> Floats: ...  # noqa: D102


class Enforcement(ABC):
    """Relation of the force of a constraint to its penetration.

    About the gaps of an iteration the penetration is ``offset + compliance * force`` with the law's own derivative.
    """

    approximates: ClassVar[bool] = False
    """Whether the law stands for surfaces that do not penetrate, so that its penetration is an error."""

    @abstractmethod
    def compliances(self, pairs: HasAreas) -> Floats:
        """Derivative of the penetration by the force of each constraint, shape (m,); 0 where none is allowed."""

    def offsets(self, pairs: HasAreas) -> Floats:
        """Penetration at which the law's tangent has no force, shape (m,): 0 where the law is a line through zero.

        With the penetration d, the force F(d) and its derivative F', the compliance is ``1 / F'`` and this is
        ``d - F / F'``.
        """
        return np.zeros(len(pairs.keys))

    def barriers(self, pairs: HasAreas) -> Floats:
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

    approximates: ClassVar[bool] = True
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

    def compliances(self, pairs: HasAreas) -> Floats:
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

    def compliances(self, pairs: HasAreas) -> Floats:
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

    def compliances(self, pairs: HasAreas) -> Floats:
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

    approximates: ClassVar[bool] = True
    value: float
    reach: float

    def __post_init__(self) -> None:
        advice = "a thousandth of the expected pressure times the approach is a usual choice"
        check_positive("Barrier", "value", self.value, "a positive force per length", advice)
        check_positive("Barrier", "reach", self.reach, "a positive length", "take the expected approach")

    def compliances(self, pairs: HasAreas) -> Floats:
        """No penetration, shape (m,)."""
        return np.zeros(len(pairs.keys))

    def barriers(self, pairs: HasAreas) -> Floats:
        """See `Enforcement.barriers`."""
        return np.column_stack((self.value * pairs.areas, np.full(len(pairs.keys), self.reach)))
