"""Stiffness matrices that CalculiX writes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.errors import InputError, short
from flangeway.types import Floats, Ints


@dataclass(frozen=True, eq=False)
class CalculixMatrix:
    """A stiffness matrix of CalculiX, without the unknowns that its supports hold.

    Parameters
    ----------
    matrix
        Stiffness, both triangles, shape (n, n).
    nodes
        Number of the node of each row, shape (n,).
    directions
        Direction of each row, 1 for x and 2 for y, shape (n,).

    """

    matrix: sp.csr_array
    nodes: Ints
    directions: Ints

    def rows(self, numbers: ArrayLike) -> Ints:
        """Row of the x and the y component of nodes by their numbers (n,), -1 for one that is held, shape (n, 2)."""
        given = np.asarray(numbers)
        order = np.lexsort((self.directions, self.nodes))
        keys = 2 * self.nodes[order] + self.directions[order] - 1
        wanted = 2 * given[:, None] + np.arange(2)
        places = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return np.where(keys[places] == wanted, order[places], -1).astype(np.int64)


def read_calculix_matrix(path: str | Path) -> CalculixMatrix:
    """Read the files ``.sti`` and ``.dof`` that ``*FREQUENCY, SOLVER=MATRIXSTORAGE`` writes.

    Lines of the first have a row, a column and a value of the upper triangle, those of the second ``node.direction``
    of a row each. They have 14 digits.

    Parameters
    ----------
    path
        Either file, or their common name without an ending.

    Raises
    ------
    InputError
        If a file is not there or not of this form, or the model is not plane.

    """
    stem = Path(path)
    stem = stem.with_suffix("") if stem.suffix in (".sti", ".dof", ".mas", ".inp") else stem
    entries, numbers = (
        _columns(stem.with_name(stem.name + ending), width) for ending, width in ((".sti", 3), (".dof", 2))
    )
    nodes, directions = numbers.T.astype(np.int64)
    n = len(nodes)
    if not np.isin(directions, (1, 2)).all():
        raise InputError(
            f"{stem}.dof with the direction {directions.max()}",
            "1 and 2: a plane model",
            "take plane elements (CPE3, CPE6, CPS3, CPS6)",
        )
    first, second = entries[:, :2].T.astype(np.int64) - 1
    if len(entries) == 0 or min(first.min(), second.min()) < 0 or max(first.max(), second.max()) >= n:
        raise InputError(
            f"{stem}.sti with rows other than the {n} of {stem}.dof", "two files of one run", "run CalculiX once more"
        )
    upper = sp.csr_array(sp.coo_array((entries[:, 2], (np.minimum(first, second), np.maximum(first, second))), (n, n)))
    return CalculixMatrix(sp.csr_array(upper + sp.triu(upper, 1).T), nodes, directions)


def _columns(path: Path, width: int) -> Floats:
    """Numbers of a file, (n_lines, width); a point separates those of ``.dof``."""
    try:
        text = path.read_text(encoding="ascii")
        values = np.array((text if width == 3 else text.replace(".", " ")).split(), dtype=np.float64)
        return values.reshape(-1, width)
    except OSError as reason:
        advice = "run CalculiX with *FREQUENCY, SOLVER=MATRIXSTORAGE, which writes it"
        raise InputError(f"{path}: {reason.strerror}", "files .sti and .dof of one run", advice) from reason
    except ValueError as reason:
        form = "row, column and value" if width == 3 else "node.direction"
        raise InputError(f"{path}: {short(str(reason))}", f"lines of {form}", "take the file of CalculiX") from reason
