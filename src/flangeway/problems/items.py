"""Items: what adds forces to unknowns, with a residual, a tangent and a history."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import scipy.sparse as sp

from flangeway.types import Floats, Ints


class Item(ABC):
    """What adds forces to some unknowns."""

    @property
    @abstractmethod
    def unknowns(self) -> Ints:
        """Numbers of the unknowns that it acts on, each once, shape (m,)."""

    @property
    def linear(self) -> bool:
        """Whether the tangent is the same for every state."""
        return False

    @abstractmethod
    def residual(self, state: Floats) -> Floats:
        """Internal less external forces (m,) for the values (m,) of its unknowns, from the history it has."""

    @abstractmethod
    def tangent(self, state: Floats) -> sp.csr_array:
        """Derivative of the residual by the values of its unknowns, symmetric, shape (m, m)."""

    def commit(self, state: Floats) -> Self:  # noqa: ARG002 (items without history do not use it)
        """Return the item with the history of an accepted state (m,); itself if it has no history."""
        return self


@dataclass(frozen=True, eq=False)
class LinearItem(Item):
    """Linear forces ``stiffness u - load``: an elastic body, springs, dead loads."""

    numbers: Ints  # numbers of the unknowns, (m,)
    stiffness: sp.csr_array  # (m, m), symmetric
    load: Floats  # external forces, (m,)

    @property
    def unknowns(self) -> Ints:
        """See `Item.unknowns`."""
        return self.numbers

    @property
    def linear(self) -> bool:
        """See `Item.linear`."""
        return True

    def residual(self, state: Floats) -> Floats:
        """See `Item.residual`."""
        forces: Floats = self.stiffness @ state - self.load
        return forces

    def tangent(self, state: Floats) -> sp.csr_array:  # noqa: ARG002 (the same for every state)
        """See `Item.tangent`."""
        return self.stiffness
