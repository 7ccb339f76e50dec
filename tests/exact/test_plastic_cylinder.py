"""Thick cylinder of a perfectly plastic steel beyond first yield, in plane strain, beside its closed form."""

import numpy as np
import pytest
from scipy.optimize import brentq

from flangeway.elements import Lagrange, StabilisationFree, Virtual
from flangeway.materials import Elastic, J2Plasticity
from flangeway.mesh import PolyMesh, agglomerated, dual, rectangle_grid
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure
from flangeway.solve import solve_nonlinear
from flangeway.space import Space

INNER, OUTER, YOUNG, POISSON, YIELD = 1.0, 2.0, 210.0, 0.3, 0.24
SHEAR_YIELD = YIELD / np.sqrt(3.0)
STEEL = J2Plasticity(Elastic(YOUNG, POISSON), YIELD)
PRESSURES = (0.13, 0.17)  # first yield at 0.104, collapse at 0.192


def quarter(n):
    grid = rectangle_grid(1.0, 1.0, n, 2 * n)
    radius, angle = INNER + (OUTER - INNER) * grid.points[:, 0], grid.points[:, 1] * np.pi / 2.0
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=1)
    return PolyMesh(points, grid.cell_offsets, grid.cell_points, edge_sets=grid.edge_sets)


def rim_displacement(pressure):
    """Hill (1950, The Mathematical Theory of Plasticity, V.2): plastic up to radius c, the elastic ring outside."""

    def inside(c):
        return SHEAR_YIELD * (1.0 - (c / OUTER) ** 2 + 2.0 * np.log(c / INNER))

    c = brentq(lambda c: inside(c) - pressure, INNER, OUTER)
    return 2.0 * (1.0 - POISSON**2) * SHEAR_YIELD * c**2 / (YOUNG * OUTER)


CASES = {
    "triangles of order 2": (lambda: quarter(8), Lagrange(2), 5e-3),
    "duals of order 3": (lambda: dual(quarter(5)), Virtual(3), 4e-3),
    "cells that are not convex, order 2": (lambda: agglomerated(quarter(16), 60), Virtual(2), 5e-3),
    "duals without stabilisation": (lambda: dual(quarter(8)), StabilisationFree(1), 5e-3),
}


@pytest.mark.parametrize("case", CASES)
def test_the_rim_moves_as_the_closed_form_says(case):
    """Beyond first yield the radial displacement of the rim is within 0.5 % of Hill's, on all kinds of cells."""
    make, element, tolerance = CASES[case]
    space = Space(make(), element)
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    problem = Elasticity(space, STEEL.elastic, loads=[Pressure("left", 1.0)], supports=supports)
    solutions = solve_nonlinear(problem, STEEL, PRESSURES)
    rim = np.unique(space.edge_nodes(space.mesh.edge_set("right")))
    for pressure, solution in zip(PRESSURES, solutions, strict=True):
        assert solution.status.converged
        moved = np.linalg.norm(solution.displacements[rim], axis=1).mean()
        assert moved == pytest.approx(rim_displacement(pressure), rel=tolerance)
    history = solutions[-1].history
    assert history[np.linalg.norm(solutions[-1].points, axis=1) < 1.3, 4].min() > 0.0
