"""Pairing of two surfaces, and the constraints that it finds; a new pairing is a subclass of `Pairing`."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flangeway.contact.slip import Slides
from flangeway.contact.surface import Surface
from flangeway.errors import InputError
from flangeway.types import Bools, Floats, Ints


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
