"""Rigid motions in a stiffness matrix that another program has assembled: they strain nothing, so K r = 0."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from flangeway.types import Bools, Floats, Ints

MAX_FORCE = 1e-4
"""Force of a rigid motion on a row over the sum of its terms' magnitudes: above what seven printed digits leave."""

MAX_WRONG = 0.5
"""Fraction of rows with such a force from which K does not belong to the nodes; fewer are springs to the ground."""

NEIGHBOURS = 9
"""Nodes, with the node itself, within twice whose distance a missing unknown may have been coupled to the node."""


def wrong_rows(matrix: sp.csr_array, nodes: Floats, rows: Ints, *, axisymmetric: bool) -> float:
    """Fraction of the nodes on which a rigid motion of the body makes a force; below `MAX_WRONG` that is explained.

    Forces of translations may be those of springs to the ground, or of unknowns that K is without or has decoupled:
    they count away from such unknowns, and on most nodes. Where translations make no force, nothing explains a
    rotation's: the fraction is 1.

    Parameters
    ----------
    matrix
        Symmetric stiffness K, shape (n, n).
    nodes
        Coordinates, shape (n_nodes, 2).
    rows
        Row of K of each component of each node, -1 where K is without it, shape (n_nodes, 2).
    axisymmetric
        Whether the only rigid motion is that along y.

    """
    off_diagonal = sp.csr_array(abs(matrix) - sp.diags_array(abs(matrix.diagonal())))
    decoupled = np.asarray(off_diagonal.sum(axis=1)).ravel() == 0.0
    clear = _far_from(nodes, ((rows < 0) | decoupled[rows]).any(axis=1))
    x, y = (nodes - nodes.mean(axis=0)).T
    motions = [(0.0 * x, 0.0 * x + 1.0)]
    if not axisymmetric:
        motions += [(0.0 * x + 1.0, 0.0 * x), (-y, x)]
    there = rows >= 0
    known = np.zeros(matrix.shape[0], dtype=bool)
    known[rows[there]] = True
    wrong = np.zeros(rows.shape, dtype=bool)
    for components in motions:
        motion = np.zeros(matrix.shape[0])
        motion[rows[there]] = np.column_stack(components)[there]
        if not known.all():  # unknowns inside of cells follow: K_ii r_i = -K_ib r_b
            inner = sp.csc_array(matrix[~known][:, ~known])
            motion[~known] = spsolve(inner, -(matrix[~known] @ motion))
        forces: Floats = np.abs(matrix @ motion)
        terms: Floats = abs(matrix) @ np.abs(motion)
        unequal = np.greater(forces[rows], MAX_FORCE * terms[rows]) & there
        if len(motions) == 3 and components is motions[2] and (unequal & ~wrong).any():
            return 1.0
        wrong |= unequal
    return float(np.asarray(wrong.any(axis=1))[clear].mean()) if clear.any() else 0.0


def _far_from(nodes: Floats, missing: Bools) -> Bools:
    """Nodes farther from missing ones than twice the distance of their next `NEIGHBOURS`."""
    if not missing.any():
        return ~missing
    around = cKDTree(nodes).query(nodes, k=min(NEIGHBOURS, len(nodes)))[0]
    return cKDTree(nodes[missing]).query(nodes)[0] > 2.0 * around[:, -1]
