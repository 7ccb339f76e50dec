"""Newton's method for bodies of nonlinear materials, along a path of the load."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from flangeway.checks import MIN_POSITIVE, as_numbers
from flangeway.errors import InputError
from flangeway.geometry.arrays import max_magnitude
from flangeway.problems import ElasticField, Elasticity
from flangeway.problems.loads import GivenForces
from flangeway.problems.nonlinear_body import (
    Linearised,
    MaterialByCells,
    MaterialState,
    NonlinearBody,
    scaled,
)
from flangeway.solve.solutions import ElasticitySolution, forces_on_handles, solve_elasticity
from flangeway.solve.status import NewtonSettings, Status, StepSettings, follow
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class NonlinearSolution(ElasticField[Any]):
    """A body of nonlinear materials under a load.

    Parameters
    ----------
    problem, displacements
        See `flangeway.problems.ElasticField`.
    status
        How Newton's method ended.
    factor
        Factor of the loads and of prescribed motions.
    nodal_forces
        Forces of supports without springs on the nodes, shape (n_nodes, d).
    points
        Points of quadrature, (n_points, d).
    stress
        First Piola-Kirchhoff stress there (the stress itself at small strains), (n_points, d, d).
    history
        History of the material there, (n_points, n_history).
    residuals
        Norm of the unbalanced forces in each iteration, relative to that of the forces at nodes.
    state
        What the body remembers.

    """

    status: Status
    factor: float
    nodal_forces: Floats
    points: Floats
    stress: Floats
    history: Floats
    residuals: tuple[float, ...]
    state: MaterialState


def solve_nonlinear(
    problem: Elasticity[Any],
    material: MaterialByCells,
    factors: Sequence[float] = (1.0,),
    *,
    steps: StepSettings | None = None,
    settings: NewtonSettings | None = None,
) -> tuple[NonlinearSolution, ...]:
    """Load a body of nonlinear materials along a path.

    Parameters
    ----------
    problem
        Space, thickness, loads and supports; loads are dead loads on the undeformed body. Its materials are replaced.
    material
        Nonlinear material of all cells, or of each named cell set.
    factors
        Factors of all loads and prescribed motions, from 0 to the first, then from each to the next.
    steps
        Sizes of the steps between two factors; a step that does not converge is halved. Left out: one step.
    settings
        Limits of Newton's method; the tolerance is that of the unbalanced force over the maximum force of a node, or of
        the last change of the displacements over their maximum.

    Returns
    -------
    tuple of NonlinearSolution
        The solution at each factor; where the smallest step did not converge, the failed attempt is the last.

    Raises
    ------
    InputError
        If the body is one of plane stress or of revolution, or can move as a whole.

    """
    body, settings = NonlinearBody(problem, material), settings or NewtonSettings(tolerance=1e-9)
    loads, state = problem.load_vector(), body.start()
    rest = Status(True, "at rest", 0)
    nodes, stress, history = (
        np.zeros((problem.space.n_nodes, problem.dimension)),
        *body.stresses(state, state.displacements),
    )
    reached = NonlinearSolution(
        body.problem, state.displacements, rest, 0.0, nodes, body.points, stress, history, (), state
    )
    done: list[NonlinearSolution] = []
    for last in as_numbers("factors", list(factors)).tolist():
        way = last - reached.factor

        def solve_at(
            share: float, start: NonlinearSolution | None, first: float = reached.factor, way: float = way
        ) -> NonlinearSolution:
            assert start is not None
            return _solved(body, start, loads, first + share * way, settings)

        reached = follow(solve_at, reached, steps)
        done.append(reached)
        if not reached.status.converged:
            break
    return tuple(done)


def _solved(
    body: NonlinearBody, start: NonlinearSolution, loads: Floats, factor: float, settings: NewtonSettings
) -> NonlinearSolution:
    """Newton's method with full steps; each linear problem is one of `solve_elasticity`, for the increment.

    A loop of its own: it keeps to the path of the load by shorter loads, as damped steps could leave it.
    """
    problem, n_nodes, state, u = body.problem, body.problem.space.n_nodes, start.state, start.displacements.copy()
    d = problem.dimension
    springs = sum(map(problem.spring_stiffness, problem.springs), sp.csc_array((d * n_nodes, d * n_nodes)))
    step: ElasticitySolution | None = None
    residuals: list[float] = []
    change, size, reach = np.inf, MIN_POSITIVE, MIN_POSITIVE  # scales: those of the whole step, which may end at zero
    for _ in range(settings.max_iterations + 1):
        tangents, forces, works = body.linearised(state, u)
        unbalanced = factor * loads - forces
        size = max(size, max_magnitude(forces), max_magnitude(factor * loads))
        reach = max(reach, max_magnitude(u))
        reactions = -unbalanced[:n_nodes]
        unbalanced[:n_nodes] -= (springs @ u[:n_nodes].ravel()).reshape(-1, d)
        if step is not None:  # the supports hold from the first step on
            applied, _ = forces_on_handles(step.problem, step.constraints)
            free = step.constraints.transform.T @ unbalanced[:n_nodes].ravel() + applied, unbalanced[n_nodes:]
            residuals.append(max(max_magnitude(part) for part in free) / size)
            # near nu = 1/2 round-off of the forces is above the tolerance, but the displacements have settled
            change = max_magnitude(step.displacements) / reach
            if not min(residuals[-1], change) > settings.tolerance:
                break
        motion = factor - start.factor if step is None else 0.0
        supports = [scaled(support, motion, factor) for support in problem.supports]
        linear = Linearised(
            problem.space,
            problem.material,
            problem.thickness,
            [GivenForces(unbalanced)],
            supports,
            problem.name,
            tangents,
        )
        try:
            step = solve_elasticity(linear)
        except InputError:
            if not residuals:
                raise
            break  # the tangent is not positive: a shorter step keeps to the stable path
        u += step.displacements
    converged = min(residuals[-1], change) <= settings.tolerance  # False for what is not a number
    status = Status(converged, f"forces are balanced to {residuals[-1]:.1e}", len(residuals))
    # not where the step ends at zero
    status = status.with_stabilisation(float(works[1] / max(works.sum(), size * reach)))
    stress, history = body.stresses(state, u)
    after = body.committed(state, u) if converged else state
    status = status.with_notices(body.locking(after))
    return NonlinearSolution(
        problem, u, status, factor, reactions, body.points, stress, history, tuple(residuals), after
    )
