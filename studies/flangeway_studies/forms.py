"""Problems of one's own, each on triangles, on dual polygons and on cells that are not convex, beside known values."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import scipy.linalg
from scipy.optimize import brentq

from flangeway.elements import Element, Lagrange, Virtual
from flangeway.forms import (
    Field,
    Plate,
    bilinear,
    interpolate,
    linear,
    load,
    mass,
    modes,
    newmark_steps,
    newton,
    solve,
    stiffness,
    stokes,
    stokes_matrix,
    theta_steps,
)
from flangeway.forms.weak import PointValues, Values
from flangeway.geometry import polygon, rectangle, square
from flangeway.geometry.arrays import angles_of, norms
from flangeway.materials import Elastic, J2Plasticity, NeoHooke
from flangeway.mesh import PolyMesh, agglomerated, doerfler_marking, dual, rectangle_grid, refined, triangulate
from flangeway.problems import Elasticity, PrescribedDisplacement, Pressure, Traction, fixed
from flangeway.solve import NonlinearSolution, StepSettings, solve_nonlinear
from flangeway.space import Space
from flangeway.types import Floats
from flangeway_studies.cook import of_unit_square
from flangeway_studies.study import Limit, Row, Run

Function = Callable[[Floats], Floats]
KINDS = ("triangles", "duals", "not convex")
FINER = {"triangles": 1, "duals": 1, "not convex": 3}
"""By how much triangles are finer than cells that are joined of them."""
L_SHAPE = polygon([(-1, -1), (0, -1), (0, 0), (1, 0), (1, 1), (-1, 1)])
CORNERS: dict[str, tuple[Callable[[], PolyMesh], float]] = {
    "L-shape, duals": (lambda: dual(triangulate(L_SHAPE, size=0.3)), 2.0 / 3.0),
    "L-shape, not convex": (lambda: agglomerated(triangulate(L_SHAPE, size=0.12), 60), 2.0 / 3.0),
    "slit, duals": (lambda: slit(dual), 0.5),
    "slit, not convex": (lambda: slit(lambda mesh: agglomerated(refined(mesh), 40)), 0.5),
}
"""Coarsest meshes, and the power of the radius in the solution."""
ORDERS, LEVELS, MAX_CELLS = (1, 2, 3, 4), 5, 1200  # cells over the order, at which the refinement at corners ends
LAST = 6  # meshes of which the order of convergence is taken
OPTIMAL = 0.9  # part of the optimal order that is asked for
MAX_RATIO, MIN_ROUNDNESS = 0.55, 0.03  # diameters from level to level; area over diameter squared, 0.43 of triangles
WAVE_NUMBER, BETA = 6.0, np.array([5.0, -3.0])
YOUNG, POISSON, YIELD, OUTER, PRESSURE = 210.0, 0.3, 0.24, 2.0, 0.17
"""The thick cylinder from radius 1: first yield at 0.104, collapse at 0.192."""


def square_of(kind: str, n: int) -> PolyMesh:
    """The unit square, about n cells on a side."""
    return _of_kind(kind, triangulate(square(1.0, (0.5, 0.5)), size=1.0 / (FINER[kind] * n)), 2 * n * n)


def mapped(kind: str, n: int, m: int, to: Function) -> PolyMesh:
    """The unit square of n by m cells, mapped."""
    grid = rectangle_grid(1.0, 1.0, FINER[kind] * n, FINER[kind] * m)
    return _of_kind(kind, replace(grid, points=to(grid.points)), n * m)


def _of_kind(kind: str, triangles: PolyMesh, n_cells: int) -> PolyMesh:
    """Triangles as they are, their dual cells, or about as many groups of them as given."""
    if kind == "not convex":
        return agglomerated(triangles, n_cells)
    return dual(triangles) if kind == "duals" else triangles


def element_of(kind: str, order: int) -> Element:
    """Lagrange's on triangles, virtual on polygons."""
    return Lagrange(order) if kind == "triangles" else Virtual(order)


def slit(make: Callable[[PolyMesh], PolyMesh]) -> PolyMesh:
    """A square with a slit from its centre to the right: an upper and a lower half that share points left of it."""
    upper = make(triangulate(rectangle(2.0, 1.0, (0.0, 0.5)), size=0.25))
    on_axis = (upper.points[:, 1] == 0.0) & (upper.points[:, 0] <= 1e-9)
    number = np.where(on_axis, np.arange(upper.n_points), upper.n_points + np.cumsum(~on_axis) - 1)
    rows = [row.tolist() for row in np.split(upper.cell_points, upper.cell_offsets[1:-1])]
    mirrored = upper.points[~on_axis] * [1.0, -1.0]
    mesh = PolyMesh.from_cells(np.vstack((upper.points, mirrored)), rows + [number[row[::-1]].tolist() for row in rows])
    axis = mesh.points[mesh.boundary_edges][:, :, 1]
    return mesh.with_edge_set("crack", mesh.boundary_edges[(axis == 0.0).all(axis=1)])


def corner_errors(name: str, order: int) -> tuple[list[int], list[float]]:
    """Unknowns, and errors of the gradient of ``r^a sin(a phi)`` on meshes that are refined by the cells' errors."""
    make, power = CORNERS[name]
    mesh, sizes, errors = make(), [], []
    while mesh.n_cells < MAX_CELLS // order:
        space = Space(mesh, Virtual(order), cracks=["crack"] if "slit" in name else [])
        values = interpolate(space, lambda p: _polar(p)[0] ** power * np.sin(power * _polar(p)[1]))
        u = solve(stiffness(space), np.zeros(space.n_dofs), space.boundary_dofs(), values)
        squares = np.zeros(mesh.n_cells)
        for batch in space.batches():
            points, weights = batch.quadrature(2 * order + 6)
            radius, angle = _polar(points.swapaxes(1, 2).reshape(-1, 2))
            direction = np.stack((np.sin((power - 1.0) * angle), np.cos((power - 1.0) * angle)), axis=1)
            miss = Field(space, u).on(batch, points).gradient - (power * radius ** (power - 1.0))[:, None] * direction
            squares[batch.cells] = ((miss**2).sum(axis=1).reshape(weights.shape) * weights).sum(axis=0)
        sizes.append(space.n_dofs)
        errors.append(np.sqrt(squares.sum()))
        mesh = refined(mesh, doerfler_marking(np.sqrt(squares), 0.7), most_hanging=1)
    return sizes, errors


def _polar(points: Floats) -> tuple[Floats, Floats]:
    return norms(points), np.mod(angles_of(points), 2.0 * np.pi)


def corners(run: Run) -> Iterator[Row]:
    """Orders at corners, and shapes of cells on five levels."""
    for name, (make, _) in CORNERS.items():
        for order in ORDERS[1:2] if run.quick else ORDERS:
            sizes, errors = corner_errors(name, order)
            run.curve("corners", name, f"order {order}", sizes, errors, "o-")
            rate = -np.polyfit(np.log(sizes[-LAST:]), np.log(errors[-LAST:]), 1)[0]
            yield at_least("corners", f"{name}, V{order}", "order of the error by unknowns", rate, order / 2.0)
        mesh, diameters = make(), []
        levels = 3 if run.quick else LEVELS
        for _ in range(levels):
            diameters.append(mesh.cell_diameters.max())
            mesh = refined(mesh)
        diameters.append(mesh.cell_diameters.max())
        ratio = np.divide(diameters[1:], diameters[:-1]).max()
        roundness = (mesh.cell_areas / mesh.cell_diameters**2).min()
        limit = Limit(f"<= {MAX_RATIO}", ratio <= MAX_RATIO)
        yield Row("refinement", name, f"largest ratio of diameters of {levels} levels", "1", ratio, 0.5, limit)
        limit = Limit(f">= {MIN_ROUNDNESS}", roundness >= MIN_ROUNDNESS)
        yield Row("refinement", name, "least area over squared diameter", "1", roundness, 0.0, limit)


def rate_of(errors: Iterable[float], meshes: Sequence[PolyMesh]) -> float:
    """Order of convergence between two meshes by the mean size of their cells."""
    coarse, fine = errors
    sizes = [mesh.cell_areas.mean() for mesh in meshes]
    return 2.0 * np.log(coarse / fine) / np.log(sizes[0] / sizes[1])


def at_least(table: str, code: str, quantity: str, rate: float, optimal: float) -> Row:
    """An order of convergence, which may be better than the optimal one."""
    return Row(table, code, quantity, "1", rate, optimal, Limit(f">= {OPTIMAL * optimal:g}", rate >= OPTIMAL * optimal))


def l2_error(space: Space, dofs: Values, exact: Function) -> float:
    """Relative error in L2."""
    points, weights, values = Field(space, dofs).at_quadrature()
    wanted = exact(points)
    return np.sqrt(weights @ np.abs(values.value - wanted) ** 2 / (weights @ np.abs(wanted) ** 2))


def bubble(p: Floats) -> Floats:
    """``sin(pi x) sin(pi y)``."""
    return np.sin(np.pi * p).prod(axis=1)


def bubble_gradient(p: Floats) -> Floats:
    """Its gradient, (n, 2)."""
    return np.pi * np.cos(np.pi * p) * np.sin(np.pi * p[:, ::-1])


def advection(space: Space) -> float:
    """Error of ``-div grad u + beta . grad u = f``."""
    matrix = stiffness(space) + bilinear(space, lambda u, v, _: (BETA * u.gradient).sum(axis=1) * v.value)
    rhs = load(space, lambda p: 2.0 * np.pi**2 * bubble(p) + bubble_gradient(p) @ BETA)
    return l2_error(space, solve(matrix, rhs, space.boundary_dofs()), bubble)


def nonlinear_poisson(space: Space) -> float:
    """Error of ``-div((1 + u^2) grad u) = f`` by Newton's method."""

    def source(p: Floats) -> Floats:
        u, slope = bubble(p), bubble_gradient(p)
        return 2.0 * np.pi**2 * u * (1.0 + u**2) - 2.0 * u * (slope**2).sum(axis=1)

    def form(u: PointValues, v: PointValues, _: object) -> Floats:
        flux = (1.0 + u.value**2)[:, None] * u.gradient
        return np.asarray((flux * v.gradient).sum(axis=1))

    solution = newton(
        space,
        form,
        np.zeros(space.n_dofs),
        fixed=space.boundary_dofs(),
        load=load(space, source),
    )
    return l2_error(space, solution.dofs, bubble) if solution.status.converged else np.inf


def helmholtz(space: Space) -> float:
    """Error of a plane wave that an absorbing boundary lets in and out: ``du/dn - i k u = g``."""
    direction = np.array([0.8, 0.6])

    def wave(p: Floats) -> Floats:
        return np.exp(1j * WAVE_NUMBER * (p @ direction))

    matrix = stiffness(space) - WAVE_NUMBER**2 * mass(space)
    rhs = np.zeros(space.n_dofs, dtype=complex)
    for name, normal in {"bottom": (0, -1), "right": (1, 0), "top": (0, 1), "left": (-1, 0)}.items():
        matrix = matrix - 1j * WAVE_NUMBER * mass(space, on=name)
        factor = 1j * WAVE_NUMBER * (direction @ normal - 1.0)
        rhs += factor * linear(space, lambda v, w: wave(w.points) * v.value, on=name)
    return l2_error(space, solve(matrix, rhs), wave)


def heat(space: Space) -> float:
    """Error of the decay ``exp(-2 pi^2 t)`` of Crank and Nicolson's method at t = 0.05."""
    number, end = 100, 0.05
    steps = theta_steps(
        mass(space), stiffness(space), interpolate(space, bubble), end / number, number, fixed=space.boundary_dofs()
    )
    *_, (_, u) = steps
    return l2_error(space, u, lambda p: np.exp(-2.0 * np.pi**2 * end) * bubble(p))


def wave_energy(space: Space) -> float:
    """Largest relative change of the energy of a vibration in 100 steps of Newmark's method."""
    weight, matrix, start = mass(space), stiffness(space), interpolate(space, bubble)
    energies = [(start @ (matrix @ start))]
    steps = newmark_steps(weight, matrix, start, np.zeros_like(start), 0.01, 100, fixed=space.boundary_dofs())
    energies += [(u @ (matrix @ u) + v @ (weight @ v)) for _, u, v in steps]
    return max(abs(energy / energies[0] - 1.0) for energy in energies)


SCALAR = {"advection and diffusion": advection, "nonlinear Poisson": nonlinear_poisson, "Helmholtz": helmholtz}


def fields() -> Iterator[Row]:
    """Equations with one unknown, by elements of order 2."""
    for kind in KINDS:
        spaces = [Space(square_of(kind, n), element_of(kind, 2)) for n in (5, 10)]
        for name, error in SCALAR.items():
            rate = rate_of(map(error, spaces), [space.mesh for space in spaces])
            yield at_least(name, kind, "order of the error in L2", rate, 3.0)
        yield Row("heat", kind, "error in L2 at t = 0.05", "1", heat(spaces[1]), 0.0, 2e-3)
        yield Row("wave", kind, "change of the energy in 100 steps", "1", wave_energy(spaces[1]), 0.0, 1e-10)


def flow(p: Floats) -> Floats:
    """A velocity without divergence that vanishes on the boundary of the unit square."""
    x, y = np.pi * p.T
    return np.stack((np.sin(x) ** 2 * np.sin(2 * y), -np.sin(2 * x) * np.sin(y) ** 2), axis=1)


def flow_force(p: Floats) -> Floats:
    """Minus its Laplacian, and the gradient of ``cos(2 x) y``."""
    (x, y), (a, b) = p.T, np.pi * p.T
    along = 2.0 * np.cos(2 * a) * np.sin(2 * b) - 4.0 * np.sin(a) ** 2 * np.sin(2 * b)
    across = 4.0 * np.sin(2 * a) * np.sin(b) ** 2 - 2.0 * np.sin(2 * a) * np.cos(2 * b)
    return -(np.pi**2) * np.stack((along, across), axis=1) + np.stack((-2 * np.sin(2 * x) * y, np.cos(2 * x)), axis=1)


def inf_sup(mesh: PolyMesh, order: int) -> float:
    """Smallest singular value of the divergence between the norms of energy and L2, but that of a constant pressure."""
    space = Space(mesh, Virtual(order))
    matrix = stokes_matrix(space, 0.5, 1.0).toarray()
    n_pressures = mesh.n_cells * order * (order + 1) // 2
    free = np.ones(len(matrix) - n_pressures, dtype=bool)
    free[(2 * space.boundary_dofs()[:, None] + np.arange(2)).ravel()] = False
    energy, weight = matrix[:-n_pressures, :-n_pressures][free][:, free], -matrix[-n_pressures:, -n_pressures:]
    divergence = matrix[-n_pressures:, :-n_pressures][:, free]
    return np.sqrt(scipy.linalg.eigh(divergence @ np.linalg.solve(energy, divergence.T), weight, eigvals_only=True)[1])


def stokes_rows() -> Iterator[Row]:
    """Order k + 1 of the velocity in L2, and the inf-sup constant on finer meshes."""
    for kind in KINDS:
        for order in (2, 3):
            meshes, errors = [square_of(kind, n) for n in (6, 12)], []
            for mesh in meshes:
                points, weights, u, _, _ = stokes(mesh, order, flow_force, velocity=flow).at_quadrature(2 * order + 2)
                errors.append(np.sqrt(weights @ ((u - flow(points)) ** 2).sum(axis=1)))
            rate = rate_of(errors, meshes)
            yield at_least("Stokes", f"{kind}, V{order}", "order of the velocity in L2", rate, order + 1.0)
        constants = [inf_sup(square_of(kind, n), 2) for n in (2, 4)]
        ratio = constants[1] / constants[0]
        yield Row("Stokes", kind, "inf-sup constant", "1", constants[1], 0.0, Limit("> 0.1", constants[1] > 0.1))
        yield Row(
            "Stokes", kind, "ratio of inf-sup constants on halved cells", "1", ratio, 0.0, Limit("> 0.75", ratio > 0.75)
        )


def clamped_frequency(degree: int = 12) -> float:
    """Lowest frequency of the clamped unit square plate by Ritz's method with polynomials, an upper bound.

    Of (1 - s^2)^2 P_i(s), s from -1 to 1, for the frequency over ``sqrt(D / m)``.
    """
    points, weights = np.polynomial.legendre.leggauss(2 * degree + 6)
    bubble_ = np.polynomial.Polynomial([1.0, 0.0, -2.0, 0.0, 1.0])
    functions = [
        bubble_ * np.polynomial.Polynomial(np.polynomial.legendre.leg2poly([0.0] * i + [1.0])) for i in range(degree)
    ]
    values, first, second = (np.array([f.deriv(d)(points) if d else f(points) for f in functions]) for d in (0, 1, 2))
    g, g1, g2 = ((functions * weights) @ functions.T for functions in (values, first, second))
    energy = np.kron(g2, g) + np.kron(g, g2) + 2.0 * np.kron(g1, g1)
    # sides of two: lengths are half of the unit square's
    return 4.0 * np.sqrt(scipy.linalg.eigh(energy, np.kron(g, g), eigvals_only=True)[0])


def plate_curvature(p: Floats) -> Floats:
    """Second derivatives (n, 2, 2) of ``(1 - cos 2 pi x) (1 - cos 2 pi y) / 4``."""
    (a, b), (s, t) = 1.0 - np.cos(2.0 * np.pi * p.T), np.sin(2.0 * np.pi * p.T)
    return np.pi**2 * np.array([[(1.0 - a) * b, s * t], [s * t, a * (1.0 - b)]]).transpose(2, 0, 1)


def plate_pressure(p: Floats) -> Floats:
    """Pressure under which a clamped plate of stiffness one bends so."""
    a, b = 1.0 - np.cos(2.0 * np.pi * p.T)
    return np.asarray(4.0 * np.pi**4 * (-(1.0 - a) * b + 2.0 * (1.0 - a) * (1.0 - b) - a * (1.0 - b)))


def plates() -> Iterator[Row]:
    """Orders of clamped plates, their frequency, and the deflection and frequency of simply supported ones."""
    clamped = clamped_frequency()
    for kind in KINDS:
        for order in (2, 3):
            meshes, errors = [square_of(kind, n) for n in (8, 16)], []
            for mesh in meshes:
                plate = Plate(mesh, order)
                matrix, held = plate.stiffness(), plate.boundary_dofs()
                bent = solve(matrix, plate.load(plate_pressure), held)
                points, weights, _, second = plate.at_quadrature(bent, 2 * order + 2)
                miss = second - plate_curvature(points)
                errors.append(np.sqrt(weights @ (miss**2).sum(axis=(1, 2))))
            weight, simply = plate.mass(), plate.boundary_dofs("simple")
            frequencies = np.sqrt(modes(plate, matrix, weight, 1, held)[0][0])
            code, limit = f"{kind}, order {order}", 0.03 if order == 2 else 5e-4
            yield at_least("plate", code, "order of the second derivatives", rate_of(errors, meshes), order - 1.0)
            yield Row("plate", code, "frequency, clamped", "sqrt(D/m)", frequencies, clamped, limit)
            simple = np.sqrt(modes(plate, matrix, weight, 1, simply)[0][0])
            yield Row("plate", code, "frequency, simply supported", "sqrt(D/m)", simple, 2.0 * np.pi**2, limit)
            middle = plate.at_quadrature(solve(matrix, plate.load(1.0), simply), 4)[2].max()
            yield Row("plate", code, "deflection under pressure, simply supported", "p/D", middle, 0.00406235, limit)


def ring(p: Floats) -> Floats:
    """A quarter of the thick cylinder from the unit square."""
    radius, angle = 1.0 + (OUTER - 1.0) * p[:, 0], p[:, 1] * np.pi / 2.0
    return np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=1)


def half_plastic(space: Space) -> tuple[NonlinearSolution, float]:
    """The thick cylinder beyond first yield on a mesh of `ring`, and the mean motion of its rim."""
    steel = J2Plasticity(Elastic(YOUNG, POISSON), YIELD)
    supports = [PrescribedDisplacement("bottom", y=0.0), PrescribedDisplacement("top", x=0.0)]
    problem = Elasticity(space, steel.elastic, loads=[Pressure("left", 1.0)], supports=supports)
    solution = solve_nonlinear(problem, steel, [0.13, PRESSURE])[-1]
    rim = np.unique(space.edge_nodes(space.mesh.edge_set("right")))
    return solution, float(np.linalg.norm(solution.displacements[rim], axis=1).mean())


def rim_displacement() -> float:
    """Motion of the rim (Hill 1950, V.2): plastic up to radius c, the elastic ring outside."""
    shear_yield = YIELD / np.sqrt(3.0)

    def pressure(c: float) -> float:
        return float(shear_yield * (1.0 - (c / OUTER) ** 2 + 2.0 * np.log(c)) - PRESSURE)

    return float(2.0 * (1.0 - POISSON**2) * shear_yield * brentq(pressure, 1.0, OUTER) ** 2 / (YOUNG * OUTER))


def cylinder(run: Run) -> Iterator[Row]:
    """Motion of the rim of a thick cylinder beyond first yield."""
    for kind in KINDS:
        solution, moved = half_plastic(Space(mapped(kind, 8, 16, ring), element_of(kind, 2)))
        run.check(f"thick cylinder, {kind}", solution.status)
        quantity = "displacement of the rim, half plastic"
        yield Row("thick cylinder", kind, quantity, "1", moved, rim_displacement(), 0.005)


def membrane(p: Floats) -> Floats:
    """Cook's membrane from the unit square, with smaller cells at its upper clamped corner."""
    return of_unit_square(np.stack((p[:, 0] ** 1.5, 1.0 - (1.0 - p[:, 1]) ** 1.5), axis=1))


def cook(run: Run) -> Iterator[Row]:
    """Rise of the corner of Cook's membrane, nearly incompressible and at finite strain."""
    rubber = NeoHooke(Elastic(240.565, 0.4999))
    for kind in KINDS[:2] if run.quick else KINDS:
        n = 12 if kind == "triangles" else 6
        space = Space(mapped(kind, n, n, membrane), element_of(kind, 3))
        loads, supports = [Traction("right", (0.0, 6.25))], [fixed("left")]
        problem = Elasticity(space, rubber.elastic, loads=loads, supports=supports)
        solution = solve_nonlinear(problem, rubber, steps=StepSettings(first=1.0 / 16.0))[-1]
        run.check(f"Cook's membrane, {kind}", solution.status)
        rise = solution.displacements[problem.node_at((48.0, 60.0)), 1]
        yield Row("Cook's membrane", kind, "rise of the corner", "mm", rise, 6.9, 0.01)


def rows(run: Run) -> Iterator[Row]:
    """All problems."""
    yield from corners(run)
    for part in (fields, stokes_rows, plates):
        yield from part()
    yield from cylinder(run)
    yield from cook(run)
