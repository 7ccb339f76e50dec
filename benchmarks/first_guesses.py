"""Random nonlinear problems from five guesses each: the same solution to 1e-6, or not converged.

``python -m benchmarks.first_guesses [NUMBER] [SEED]``: diffusion with random laws from random first guesses, neo-Hooke
bodies along different paths to one load, and plastic bodies that are unloaded in part and loaded again; orders 1 to 3
on Voronoi, dual, square and non-convex cells.
"""

import sys
from collections.abc import Callable

import numpy as np

from flangeway import Elastic, Elasticity, Space, Virtual
from flangeway.forms import newton
from flangeway.geometry import square
from flangeway.materials import J2Plasticity, NeoHooke
from flangeway.mesh import PolyMesh, agglomerated, dual, rectangle_grid, triangulate, voronoi
from flangeway.problems import Traction, fixed
from flangeway.solve import StepSettings, solve_nonlinear
from flangeway.types import Floats

UNIT = square(1.0, (0.5, 0.5))
TOLERANCE = 1e-6
MESHES: dict[str, Callable[[], PolyMesh]] = {
    "voronoi": lambda: voronoi(UNIT, 20, iterations=3),
    "duals": lambda: dual(triangulate(UNIT, size=0.3)),
    "squares": lambda: rectangle_grid(1.0, 1.0, 4, 4, cells="quadrilaterals"),
    "not convex": lambda: agglomerated(triangulate(UNIT, size=0.15), 15),
}
LAWS = {
    "1 + c u^2": lambda u, c: 1.0 + c * u.value**2,
    "exp(c u / 4)": lambda u, c: np.exp(c * u.value / 4.0),
    "1 + c |grad u|^2": lambda u, c: 1.0 + c * (u.gradient**2).sum(axis=1),
    "c u^2": lambda u, c: c * u.value**2,
}


def diffusion(space: Space, random: np.random.Generator) -> tuple[str, list[Floats]]:
    """Solutions from five guesses with random values on the boundary."""
    name = str(random.choice(list(LAWS)))
    c, edges = random.uniform(0.2, 4.0), space.boundary_dofs()
    values = 1.0 + random.uniform(0.2, 0.8) * np.sin(random.uniform(1.0, 4.0) * space.nodes @ random.normal(size=2))
    solutions = []
    for guess in random.choice([0.1, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0], 5, replace=False):
        start = guess * space.constant
        start[edges] = values[edges]
        found = newton(
            space,
            lambda u, v, _: LAWS[name](u, c) * (u.gradient * v.gradient).sum(axis=1),
            start,
            fixed=edges,
            max_iterations=40,
        )
        solutions += [found.dofs] * found.status.converged
    return name, solutions


def rubber(space: Space, random: np.random.Generator) -> tuple[str, list[Floats]]:
    """Solutions at one load along five paths."""
    material = NeoHooke(Elastic(200.0, random.uniform(0.1, 0.45)))
    return "neo-Hooke", _along(space, material, random.normal(size=2) * 8.0, random.uniform(0.2, 1.2, 5), apart=True)


def metal(space: Space, random: np.random.Generator) -> tuple[str, list[Floats]]:
    """Solutions at one load, after unloading in part and loading again five times.

    Where a point yields in reverse while the load is lowered the path counts: later solutions are compared alone.
    """
    material = J2Plasticity(Elastic(200.0, 0.3), 0.3, random.uniform(0.0, 8.0), random.uniform(0.0, 8.0))
    return "J2", _along(space, material, random.normal(size=2) * 0.08, random.uniform(0.7, 0.99, 5), apart=False)


def _along(space: Space, material: NeoHooke | J2Plasticity, load: Floats, ways: Floats, *, apart: bool) -> list[Floats]:
    """Displacements at the factor 1 after each of some other factors: on a path of its own, or all on one."""
    traction = Traction("top", (float(load[0]), float(load[1])))
    problem = Elasticity(space, material.elastic, loads=[traction], supports=[fixed("bottom")])
    paths = [[way, 1.0] for way in ways] if apart else [[1.0, *np.column_stack((ways, np.ones(5))).ravel()]]
    solutions: list[Floats] = []
    for path in paths:
        history = np.empty((0, 0))
        for step in solve_nonlinear(problem, material, path, steps=StepSettings(smallest=1 / 16)):
            if not apart and step.factor < 1.0 and not np.array_equal(step.history, history):
                solutions = []
            history = step.history
            solutions += [step.displacements] * (step.status.converged and step.factor == 1.0)
    return solutions


def main(number: int = 100, seed: int = 0) -> int:
    """Print what differs, and return the number of problems with different solutions."""
    spaces = {(name, order): Space(make(), Virtual(order)) for name, make in MESHES.items() for order in (1, 2, 3)}
    wrong = converged = 0
    for problem in range(number):
        random = np.random.default_rng([seed, problem])
        mesh, order = str(random.choice(list(MESHES))), int(random.integers(1, 4))
        kind = (diffusion, rubber, metal)[problem % 3]
        law, solutions = kind(spaces[mesh, order], random)
        converged += len(solutions)
        if len(solutions) < 2:
            print(f"{problem}: {law}, {mesh}, order {order}: {len(solutions)} converged")
            continue
        difference = np.ptp(solutions, axis=0).max() / np.abs(solutions[0]).max()
        if difference > TOLERANCE:
            wrong += 1
            print(f"{problem}: {law}, {mesh}, order {order}: solutions differ by {difference:.1e}")
    print(f"{number} problems: {converged} solutions converged, {wrong} problems with different ones")
    return wrong


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
