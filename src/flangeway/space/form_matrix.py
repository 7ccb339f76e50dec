"""Matrices of forms, as SciPy arrays that know the round-off of their entries."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from flangeway.space.symmetric import over_last_bit
from flangeway.types import Floats


class FormMatrix(sp.csr_array):  # type: ignore[misc]  # SciPy has no types
    """A sum of forms; with other arrays, and times a number, it stays one.

    Attributes
    ----------
    round_off
        Round-off of each row's entries over that of the last bit, 1 or more: of virtual elements of high order on thin
        cells it is many times larger. Rows, columns and `block_array` keep it; products lose it: they have 1.

    """

    round_off: Floats | float = 1.0

    @classmethod
    def measured(
        cls, matrix: sp.sparray, motions: Floats, forces: Floats | None = None, least: Floats | float = 1.0
    ) -> "FormMatrix":
        """Measure the round-off by the forces of motions (n,) or (n, m) without energy, or given ones of a part."""
        result = cls(matrix)
        zeros = result @ motions if forces is None else forces
        found = over_last_bit(zeros, abs(result) @ np.abs(motions)).reshape(result.shape[0], -1).max(axis=1)
        result.round_off = np.maximum(found, least)
        return result

    def __getitem__(self, key: Any) -> Any:
        result = super().__getitem__(key)
        if isinstance(result, FormMatrix) and result.ndim == 2:
            rows = key[0] if isinstance(key, tuple) else key
            result.round_off = np.broadcast_to(self.round_off, self.shape[:1])[rows].ravel()
        return result

    def _kept(self, result: Any, other: Any = None) -> Any:
        if isinstance(result, FormMatrix):
            result.round_off = np.maximum(self.round_off, getattr(other, "round_off", 1.0))
        return result

    def __add__(self, other: Any) -> Any:
        return self._kept(super().__add__(other), other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self._kept(super().__sub__(other), other)

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        return self._kept(super().__mul__(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self._kept(super().__truediv__(other))

    def __neg__(self) -> Any:
        return self._kept(super().__neg__())


def block_array(blocks: Sequence[Sequence[Any]]) -> FormMatrix:
    """SciPy's function of this name, for forms of several fields: blocks keep the round-off of their entries.

    Parameters
    ----------
    blocks
        Rows of matrices, None where there is nothing; unknowns are numbered field by field.

    """
    result = FormMatrix(sp.block_array(blocks, format="csr"))
    rows = []
    for row in blocks:
        given = [each for each in row if each is not None]
        own = [np.broadcast_to(getattr(each, "round_off", 1.0), given[0].shape[:1]) for each in given]
        rows.append(np.max(own, axis=0))
    result.round_off = np.concatenate(rows)
    return result
