"""An independent program on the same triangles: scikit-fem."""

from typing import Any

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Arc, Line, Outline, Placement, rectangle, square
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, triangulate
from flangeway.post import check_contact, pressure_patches
from flangeway.problems import Body, BodyForce, Elasticity, Part, StiffnessBody, Traction, fixed
from flangeway.solve import solve_elasticity
from flangeway.space import Space

skfem = pytest.importorskip("skfem")
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


RADIUS, SINKING = 50.0, 0.05
STEEL = Elastic(210e3, 0.3)
ARC = Arc((-RADIUS, RADIUS), (RADIUS, RADIUS), (0.0, RADIUS), counter_clockwise=True)
ROLLER = Outline.from_segments([ARC, Line((RADIUS, RADIUS), (-RADIUS, RADIUS))], ["arc", "cut"])
ZONE = np.array([[-1.5, 0.0], [1.5, 0.0]])


def rolled(bodies: Any, edges: Any) -> ContactSolution:
    """A roller and a block as bodies, pressed together along edges (n, 2) near the contact."""
    parts = [Part(name, body) for name, body in zip(("roller", "block"), bodies, strict=True)]
    surfaces = [Surface(parts[0], edges[0], curve=ROLLER), Surface(parts[1], edges[1])]
    contact = Contact(*surfaces, SegmentToSegment(), Multiplier())
    return press([contact], {parts[0]: Placement(0.0, (0.0, -SINKING))})


def from_scikit_fem(name: str, mesh: PolyMesh, order: int, held_set: str) -> StiffnessBody:
    """The body with scikit-fem's stiffness, nodes and numbers, its whole boundary a closed surface."""
    theirs = skfem.MeshTri(mesh.points.T.copy(), mesh.cell_points.reshape(-1, 3).T.astype(np.int64).copy())
    basis = skfem.Basis(theirs, skfem.ElementVector({1: skfem.ElementTriP1, 2: skfem.ElementTriP2}[order]()))
    stiffness = skfem.asm(helpers.linear_elasticity(*helpers.lame_parameters(STEEL.young, STEEL.poisson)), basis)
    rows = np.hstack([basis.nodal_dofs, basis.facet_dofs]).T if order == 2 else basis.nodal_dofs.T
    facets = {tuple(ends): mesh.n_points + number for number, ends in enumerate(theirs.facets.T.tolist())}
    following = dict(mesh.boundary_edges.tolist())
    line = [int(mesh.boundary_edges[0, 0])]
    while len(line) == 1 or line[-1] != line[0]:
        start, end = line[-1], following[line[-1]]
        line += [facets[min(start, end), max(start, end)], end] if order == 2 else [end]
    held = rows[np.unique(mesh.edge_sets[held_set])].ravel()
    if order == 2:
        middles = [facets[min(edge), max(edge)] for edge in mesh.edge_sets[held_set].tolist()]
        held = np.append(held, rows[middles].ravel())
    places = basis.doflocs[:, rows[:, 0]].T
    return Body.from_stiffness(name, stiffness, places, {"boundary": line}, order=order, rows=rows, held=held)


@pytest.mark.parametrize("order", [1, 2])
def test_same_contact_of_a_roller_on_a_block(order: int) -> None:
    """Forces, pressures and displacements with scikit-fem's stiffness are those of our own mesh to 1e-10."""
    block = rectangle(100.0, 60.0, centre=(0.0, -30.0))
    meshes = [
        triangulate(outline, size=16.0, refinements=(Refinement(ZONE, size, 0.5),))
        for outline, size in ((ROLLER, 0.2), (block, 0.23))
    ]
    edges = []
    for mesh, name in zip(meshes, ("arc", "top"), strict=True):
        middles = mesh.points[mesh.edge_sets[name]].mean(axis=1)
        edges.append(mesh.edge_sets[name][(np.abs(middles) < (1.5, 0.5)).all(axis=1)])
    given = list(zip(("roller", "block"), meshes, ("cut", "bottom"), strict=True))
    ours = rolled([Body(name, mesh, Lagrange(order), STEEL, held) for name, mesh, held in given], edges)
    theirs = rolled([from_scikit_fem(name, mesh, order, held) for name, mesh, held in given], edges)
    assert ours.status.converged
    assert theirs.status.message == ours.status.message
    np.testing.assert_allclose(theirs.forces[0, 1], ours.forces[0, 1], rtol=1e-10)
    (own,), (other,) = (pressure_patches(each.system, each.state) for each in (ours, theirs))
    np.testing.assert_allclose(other.pressures, own.pressures, atol=1e-10 * own.pressures.max())
    assert check_contact(theirs.system, theirs.state, [other], ["roller on block"]).errors == ()
    for part, mine in zip(theirs.system.parts, ours.system.parts, strict=True):
        moved = theirs.unknowns(part)[np.asarray(part.body.rows)]
        field = ours.field(mine).displacements
        count = meshes[theirs.system.parts.index(part)].n_points
        np.testing.assert_allclose(moved[:count], field[:count], atol=1e-10 * np.abs(field).max())


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


def test_same_contact_of_a_punch_of_revolution() -> None:
    """A cylinder on a block about the axis: force, pressures and displacements are our mesh's to 1e-10."""
    steel = Elastic(210e3, 0.3, "axisymmetric")
    outlines = rectangle(1.0, 1.0, centre=(0.5, 0.5)), rectangle(4.0, 4.0, centre=(2.0, -2.0))
    zone = np.array([[0.0, 0.0], [1.2, 0.0]])
    meshes = [triangulate(each, size=0.6, refinements=(Refinement(zone, 0.1, 0.3),)) for each in outlines]
    found = []
    for foreign in (False, True):
        parts = []
        for name, mesh, held_set in zip(("punch", "block"), meshes, ("top", "bottom"), strict=True):
            body: Any = Body(name, mesh, Lagrange(1), steel, held_set)
            if foreign:
                basis, matrix = revolved_stiffness(mesh.points, mesh.cell_points.reshape(-1, 3), steel)
                held = np.union1d(basis.nodal_dofs[:, np.unique(mesh.edge_sets[held_set])],
                                  basis.nodal_dofs[0, mesh.points[:, 0] == 0.0])  # fmt: skip
                line = [*mesh.boundary_edges[:1, 0].tolist()]
                following = dict(mesh.boundary_edges.tolist())
                while len(line) == 1 or line[-1] != line[0]:
                    line.append(following[line[-1]])
                given = matrix, mesh.points, {"boundary": line}
                body = Body.from_stiffness(name, *given, rows=basis.nodal_dofs.T, held=held, axisymmetric=True)
            parts.append(Part(name, body))
        sides = [
            Surface(part, mesh.edge_sets[side])
            for part, mesh, side in zip(parts, meshes, ("bottom", "top"), strict=True)
        ]
        contact = Contact(*sides, SegmentToSegment(), Multiplier(), 0.2)
        found.append(press([contact], {parts[0]: Placement(0.0, (0.0, -0.01))}))
    ours, theirs = found
    assert ours.status.converged
    assert theirs.status.message == ours.status.message
    assert ours.dissipated_work[0] > 0.0
    np.testing.assert_allclose(theirs.forces[0, 1], ours.forces[0, 1], rtol=1e-10)
    np.testing.assert_allclose(theirs.state.forces, ours.state.forces, atol=1e-10 * ours.state.forces.max())
    for mine, part in zip(ours.system.parts, theirs.system.parts, strict=True):
        field = ours.field(mine).displacements
        moved = theirs.unknowns(part)[np.asarray(part.body.rows)]
        np.testing.assert_allclose(moved, field[: len(moved)], atol=1e-10 * np.abs(field).max())
