"""Own forms and solutions beside scikit-fem on the same triangles: values at the points to 1e-10."""

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from flangeway.elements import Lagrange
from flangeway.forms import (
    Factor,
    bilinear,
    interpolate,
    linear,
    mass,
    newmark_steps,
    stiffness,
    theta_steps,
)
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import BodyForce, Elasticity, Traction, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space

skfem = pytest.importorskip("skfem")

MESH = triangulate(square(1.0, (0.5, 0.5)), size=0.15)
THEIRS = skfem.MeshTri(MESH.points.T, MESH.cell_points.reshape(-1, 3).T)
SPACE = Space(MESH, Lagrange(2))
BASIS = skfem.Basis(THEIRS, skfem.ElementTriP2(), intorder=6)
FACETS = skfem.FacetBasis(THEIRS, skfem.ElementTriP2(), intorder=6)
FIXED, DIRICHLET = SPACE.boundary_dofs(), BASIS.get_dofs().all()


def at_points(theirs):
    """Values of scikit-fem's solution at the points of the mesh."""
    return theirs[BASIS.nodal_dofs[0]]


@skfem.BilinearForm
def laplace(u, v, _):
    return u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1]


@skfem.BilinearForm
def value(u, v, _):
    return u * v


@skfem.LinearForm
def source(v, w):
    return np.sin(3.0 * w.x[0]) * v


def our_source(v, w):
    return np.sin(3.0 * w.points[:, 0]) * v.value


def test_helmholtz_with_absorbing_boundary():
    """A complex matrix with a form along the boundary."""
    matrix = laplace.assemble(BASIS) - 25.0 * value.assemble(BASIS) - 5.0j * value.assemble(FACETS)
    theirs = skfem.solve(matrix, source.assemble(BASIS).astype(complex))
    boundary = sum(mass(SPACE, on=name) for name in MESH.edge_sets)
    found = Factor(stiffness(SPACE) - 25.0 * mass(SPACE) - 5.0j * boundary).solve(linear(SPACE, our_source, degree=6))
    np.testing.assert_allclose(found[: MESH.n_points], at_points(theirs), atol=1e-10 * np.abs(theirs).max())


def test_transient_heat():
    """Twenty steps of Crank and Nicolson from the same start."""
    K, M, b = laplace.assemble(BASIS), value.assemble(BASIS), source.assemble(BASIS)
    theirs = np.zeros(BASIS.N)
    for _ in range(20):
        rhs = (M - 0.005 * K) @ theirs + 0.01 * b
        theirs = skfem.solve(*skfem.condense(M + 0.005 * K, rhs, D=DIRICHLET))
    rhs = linear(SPACE, our_source, degree=6)
    *_, (_, ours) = theta_steps(mass(SPACE), stiffness(SPACE), np.zeros(SPACE.n_dofs), 0.01, 20, load=rhs, fixed=FIXED)
    np.testing.assert_allclose(ours[: MESH.n_points], at_points(theirs), atol=1e-10 * np.abs(theirs).max())


def test_a_wave():
    """Twenty steps of Newmark's method from a bump at rest, with a load; accelerations are theirs at each step."""
    K, M, b = laplace.assemble(BASIS), value.assemble(BASIS), source.assemble(BASIS)
    step, inside = 0.02, np.setdiff1d(np.arange(BASIS.N), DIRICHLET)

    def bump(p):
        return np.sin(np.pi * p[0]) * np.sin(np.pi * p[1])

    u, v = bump(BASIS.doflocs), np.zeros(BASIS.N)
    u[DIRICHLET] = 0.0
    a = skfem.solve(*skfem.condense(M, b - K @ u, I=inside))
    for _ in range(20):
        predicted, rate = u + step * v + step**2 / 4.0 * a, v + step / 2.0 * a
        a = skfem.solve(*skfem.condense(M + step**2 / 4.0 * K, b - K @ predicted, I=inside))
        u, v = predicted + step**2 / 4.0 * a, rate + step / 2.0 * a
    start = interpolate(SPACE, lambda p: bump(p.T))
    start[FIXED] = 0.0
    rhs = linear(SPACE, our_source, degree=6)
    *_, (_, ours, speed) = newmark_steps(
        mass(SPACE), stiffness(SPACE), start, 0.0 * start, step, 20, load=rhs, fixed=FIXED
    )
    np.testing.assert_allclose(ours[: MESH.n_points], at_points(u), atol=1e-10 * np.abs(u).max())
    np.testing.assert_allclose(speed[: MESH.n_points], at_points(v), atol=1e-10 * np.abs(v).max())


def test_stokes_of_taylor_and_hood():
    """Two fields of different order in one system: velocity of order 2, pressure of order 1, driven by a force."""
    vector = skfem.ElementVector(skfem.ElementTriP2())
    velocity, pressure = (skfem.Basis(THEIRS, e, intorder=6) for e in (vector, skfem.ElementTriP1()))

    @skfem.BilinearForm
    def stretch(u, v, _):
        return (u.grad * v.grad).sum(axis=(0, 1))

    @skfem.BilinearForm
    def outflow(u, q, _):
        return -(u.grad[0, 0] + u.grad[1, 1]) * q

    stiff, flow = stretch.assemble(velocity), outflow.assemble(velocity, pressure)

    @skfem.LinearForm
    def push(v, w):
        return np.sin(3.0 * w.x[1]) * v[0]

    whole = skfem.bmat([[stiff, flow.T], [flow, None]], format="csr")
    held = np.concatenate((velocity.get_dofs().all(), [velocity.N]))
    rhs = np.concatenate((push.assemble(velocity), np.zeros(pressure.N)))
    theirs = skfem.solve(*skfem.condense(whole, rhs, D=held))

    low = Space(MESH, Lagrange(1))
    ours_stiff = bilinear(SPACE, lambda u, v, w: (u.gradient * v.gradient).sum(axis=(1, 2)), components=2)
    ours_flow = bilinear(
        SPACE, lambda u, q, w: -np.einsum("nii->n", u.gradient) * q.value, components=2, test=low, test_components=1
    )
    ours_rhs = linear(SPACE, lambda v, w: np.sin(3.0 * w.points[:, 1]) * v.value[:, 0], components=2, degree=6)
    fixed = np.zeros(2 * SPACE.n_dofs + low.n_dofs, dtype=bool)
    fixed[(2 * FIXED[:, None] + np.arange(2)).ravel()] = fixed[2 * SPACE.n_dofs] = True
    matrix = sp.csr_array(sp.block_array([[ours_stiff, ours_flow.T], [ours_flow, None]]))
    found = Factor(matrix, fixed).solve(np.concatenate((ours_rhs.ravel(), np.zeros(low.n_dofs))))
    at_vertices = found[: 2 * MESH.n_points].reshape(-1, 2)
    np.testing.assert_allclose(at_vertices, theirs[velocity.nodal_dofs].T, atol=1e-10 * np.abs(theirs).max())
    np.testing.assert_allclose(found[2 * SPACE.n_dofs :], theirs[velocity.N :], atol=1e-10 * np.abs(theirs).max())


helpers = pytest.importorskip("skfem.models.elasticity")

FORCE, TRACTION = (0.3, -1.1), (0.7, 0.4)


def by_scikit_fem(mesh, order: int, material: Elastic) -> tuple[np.ndarray, np.ndarray]:
    """Points and displacements, both (n, 2), of the same problem by scikit-fem."""
    theirs = skfem.MeshTri(mesh.points.T.copy(), mesh.cell_points.reshape(-1, 3).T.astype(np.int64).copy())
    element = skfem.ElementVector({1: skfem.ElementTriP1, 2: skfem.ElementTriP2}[order]())
    basis = skfem.Basis(theirs, element, intorder=4)
    lame, shear = helpers.lame_parameters(material.young, material.poisson)
    stiffness = skfem.asm(helpers.linear_elasticity(lame, shear), basis)
    body = skfem.LinearForm(lambda v, _: FORCE[0] * v[0] + FORCE[1] * v[1])
    edge = skfem.LinearForm(lambda v, _: TRACTION[0] * v[0] + TRACTION[1] * v[1])
    right = theirs.facets_satisfying(lambda x: np.isclose(x[0], 0.5))
    load = skfem.asm(body, basis) + skfem.asm(edge, skfem.FacetBasis(theirs, element, facets=right, intorder=4))
    held = basis.get_dofs(lambda x: np.isclose(x[0], -0.5))
    solution = skfem.solve(*skfem.condense(stiffness, load, D=held))
    first, second = np.arange(0, basis.N, 2), np.arange(1, basis.N, 2)
    assert np.array_equal(basis.doflocs[:, first], basis.doflocs[:, second])
    return basis.doflocs[:, first].T, np.stack((solution[first], solution[second]), axis=1)


@pytest.mark.parametrize("order", [1, 2])
def test_same_displacements(order: int) -> None:
    """On the same triangles, displacements of both programs agree at all nodes to 1e-10."""
    mesh, material = triangulate(square(1.0), size=0.1), Elastic(100.0, 0.3)
    problem = Elasticity(
        Space(mesh, Lagrange(order)),
        material,
        loads=[BodyForce(FORCE), Traction("right", TRACTION)],
        supports=[fixed("left")],
    )
    ours = solve_elasticity(problem).displacements
    points, theirs = by_scikit_fem(mesh, order, material)
    apart = np.linalg.norm(points[:, None] - problem.space.nodes, axis=2)
    nodes = apart.argmin(axis=1)
    assert apart.min(axis=1).max() < 1e-12
    assert len(np.unique(nodes)) == problem.space.n_nodes
    assert np.abs(ours[nodes] - theirs).max() < 1e-10 * np.abs(theirs).max()


def revolved_stiffness(points: np.ndarray, triangles: np.ndarray, material: Elastic) -> tuple[Any, Any]:
    """Basis and stiffness about y by scikit-fem; one point of quadrature has our mean hoop strain."""
    lame, shear = helpers.lame_parameters(material.young, material.poisson)

    @skfem.BilinearForm
    def form(u, v, w):
        radius = w.x[0]
        strains = [(a.grad[0][0], a.grad[1][1], a[0] / radius, a.grad[0][1] + a.grad[1][0]) for a in (u, v)]
        (a_r, a_y, a_t, a_s), (b_r, b_y, b_t, b_s) = strains
        work = lame * (a_r + a_y + a_t) * (b_r + b_y + b_t) + 2.0 * shear * (a_r * b_r + a_y * b_y + a_t * b_t)
        return 2.0 * np.pi * radius * (work + shear * a_s * b_s)

    mesh = skfem.MeshTri(points.T.copy(), triangles.T.astype(np.int64).copy())
    middle = np.full((2, 1), 1.0 / 3.0), np.array([0.5])
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP1()), quadrature=middle)
    return basis, form.assemble(basis)


def test_same_stiffness_of_a_body_of_revolution() -> None:
    """On the same triangles, the stiffness about an axis that the body touches is theirs to 1e-10."""
    steel, mesh = Elastic(210e3, 0.3, "axisymmetric"), triangulate(square(1.0, (0.5, 0.0)), size=0.2)
    basis, theirs = revolved_stiffness(mesh.points, mesh.cell_points.reshape(-1, 3), steel)
    ours = Elasticity(Space(mesh, Lagrange(1)), steel).stiffness().full()
    rows = basis.nodal_dofs.T.ravel()
    assert abs(theirs[rows][:, rows] - ours).max() < 1e-10 * abs(ours).max()
