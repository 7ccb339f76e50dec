"""Pairing of two surfaces, and the constraints that it finds; a new pairing is a subclass of `Pairing`."""

from abc import ABC, abstractmethod
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from flangeway.contact.surface import Surface
from flangeway.types import Floats, Ints


class Pairs(Protocol):
    """m constraints of one contact; their gaps are sums over p terms that touch w nodes each.

    The force of a constraint is the pressure times its area, its gap a length: an average over that area.
    """

    @property
    def keys(self) -> Ints:
        """Identity of each constraint within the contact, shape (m,)."""

    @property
    def partners(self) -> Ints:
        """Primary edge that each constraint is against, shape (m,); -1 where it may be several."""

    @property
    def nodes(self) -> Ints:
        """Place in the secondary surface of each constraint's node, shape (m,)."""

    @property
    def gaps(self) -> Floats:
        """Gaps, open where positive, shape (m,)."""

    @property
    def areas(self) -> Floats:
        """Area of each constraint, length times thickness, where the primary faces it, shape (m,)."""

    @property
    def whole_areas(self) -> Floats:
        """Area of each constraint if the primary faced all of it, shape (m,)."""

    @property
    def guarded(self) -> NDArray[np.bool_]:
        """Whether each constraint is that of a guarded node, besides the pairing's, shape (m,)."""

    @property
    def secondary_members(self) -> Ints:
        """Places in the secondary surface of the points of each term, see `Surface.contact_places`: (p, w)."""

    @property
    def primary_edges(self) -> Ints:
        """Primary edge of each term, shape (p,); its points follow the secondary ones."""

    @property
    def rows(self) -> Ints:
        """Constraints to which each term adds, shape (p, r)."""

    @property
    def gradients(self) -> Floats:
        """What it adds to the derivatives of their gaps by the positions of its points, shape (p, r, w, 2)."""

    def curvatures(self, forces: Floats) -> tuple[Ints, Floats]:
        """Terms under load, shape (q,), and their ``sum force * second derivative``, shape (q, 2 w, 2 w)."""

    def opposite_points(self, edges: Floats) -> Floats:
        """Points that the constraints touch on primary edges with points ``edges`` (n_edges, order + 1, 2): (m, 2)."""


class Pairing(ABC):
    """How two surfaces are compared: which constraints they have, and what the gap of each is."""

    averages: ClassVar[bool]
    """Whether the gap of a constraint is an average over its area; False: it is that of a node or point."""

    @abstractmethod
    def node_areas(self, secondary: Surface) -> Floats:
        """Areas that belong to the nodes of a surface, length times thickness, shape (n_nodes,)."""

    @abstractmethod
    def key_nodes(self, secondary: Surface) -> Ints:
        """Places in a surface of the nodes of all constraints that it can have, by key, shape (n_keys,)."""

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
            Current positions of the secondary nodes and, after them, of its edges' middles that stand for a curve, see
            `Surface.contact_places`, shape (n_points, 2).
        primary_edges
            Current positions of the primary edges' points, shape (n_edges, order + 1, 2).
        kept
            Partner that each constraint had before, -1 for none, shape (n_keys,).
        settle
            Whether the iteration went round in circles, so that constraints should keep their partners if they can.

        """
