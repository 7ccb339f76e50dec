"""Plane elasticity with a displacement that is given on the whole boundary."""

from flangeway.materials import Material
from flangeway.problems import BodyForce, Elasticity, PrescribedDisplacement
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space


def bounded(space: Space, material: Material, exact, body_force=None) -> Elasticity:
    """The problem; `exact` and `body_force` are functions of points (n, 2)."""
    mesh = space.mesh.with_edge_set("boundary", space.mesh.boundary_edges)
    support = PrescribedDisplacement("boundary", lambda p: exact(p)[:, 0], lambda p: exact(p)[:, 1])
    loads = [] if body_force is None else [BodyForce(body_force)]
    return Elasticity(Space(mesh, space.element), material, loads=loads, supports=[support])


def solved(space: Space, material: Material, exact, body_force=None) -> ElasticitySolution:
    """Its solution."""
    return solve_elasticity(bounded(space, material, exact, body_force))
