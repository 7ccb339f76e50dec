"""Adaptive refinement of polygons around a singularity: the orders of convergence that triangles have."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.forms import Field, interpolate, solve, stiffness
from flangeway.geometry import polygon
from flangeway.mesh import agglomerated, doerfler_marking, dual, refined, triangulate
from flangeway.space import Space
from flangeway.space.functions import cell_quadrature
from studies.forms import slit

L_SHAPE = polygon([(-1, -1), (0, -1), (0, 0), (1, 0), (1, 1), (-1, 1)])


DOMAINS = {
    "L, duals": (lambda: dual(triangulate(L_SHAPE, size=0.3)), 2.0 / 3.0),
    "L, agglomerates": (lambda: agglomerated(triangulate(L_SHAPE, size=0.12), 60), 2.0 / 3.0),
    "slit, duals": (lambda: slit(dual), 0.5),
    "slit, agglomerates": (lambda: slit(lambda mesh: agglomerated(refined(mesh), 40)), 0.5),
}


@pytest.mark.parametrize(
    ("domain", "order"),
    [
        ("L, agglomerates", 1),
        ("slit, duals", 2),
        *(pytest.param(*case, marks=pytest.mark.ci) for case in (("L, duals", 4), ("slit, agglomerates", 3))),
    ],
)
def test_errors_fall_with_the_unknowns_to_minus_half_the_order(domain, order):
    """``r^a sin(a phi)``: the error of the gradient falls like ``n^(-k / 2)``, within a tenth or faster."""
    make, power = DOMAINS[domain]

    def polar(p):
        angle = np.arctan2(p[:, 1], p[:, 0])
        return np.hypot(*p.T), np.where(angle < 0.0, angle + 2.0 * np.pi, angle)

    def exact(p):
        radius, angle = polar(p)
        return radius**power * np.sin(power * angle)

    def gradient(p):
        radius, angle = polar(p)
        direction = np.stack((np.sin((power - 1.0) * angle), np.cos((power - 1.0) * angle)), axis=1)
        return (power * radius ** (power - 1.0))[:, None] * direction

    mesh, sizes, errors = make(), [], []
    cracks = ["crack"] if "slit" in domain else []
    while mesh.n_cells < 1500 // order:
        space = Space(mesh, Virtual(order), cracks=cracks)
        values = interpolate(space, exact)
        u = solve(stiffness(space), np.zeros(space.n_dofs), space.boundary_dofs(), values)
        squares = np.zeros(mesh.n_cells)
        for batch in space.batches():
            points, weights = cell_quadrature(batch, 2 * order + 6)
            found = Field(space, u).on(batch, points).gradient
            miss = found - gradient(points.swapaxes(1, 2).reshape(-1, 2))
            squares[batch.cells] = ((miss**2).sum(axis=1).reshape(weights.shape) * weights).sum(axis=0)
        sizes.append(space.n_dofs)
        errors.append(np.sqrt(squares.sum()))
        mesh = refined(mesh, doerfler_marking(np.sqrt(squares), 0.7), most_hanging=1)
    rate = np.polyfit(np.log(sizes[-6:]), np.log(errors[-6:]), 1)[0]
    assert rate < -0.9 * order / 2.0
    assert mesh.cell_sizes.max() <= 14
