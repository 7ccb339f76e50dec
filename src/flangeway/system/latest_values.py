"""Values that are costly to compute, of which the last ones are kept."""

from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class LatestValues(Generic[T]):
    """The values that were used last, by key.

    - `capacity`: number of values that are kept.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity, self._values = capacity, OrderedDict[str, T]()

    def get(self, key: str, compute: Callable[[], T]) -> T:
        """Return the value of a key, computed if it is not kept."""
        if key not in self._values:
            self._values[key] = compute()
            while len(self._values) > self._capacity:
                self._values.popitem(last=False)
        self._values.move_to_end(key)
        return self._values[key]
