"""What each support of a case of bodies bears."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.bodies.bodies_model import BodiesModel, BodyModel
from flangeway.cases.bodies.bodies_run import BodyResult
from flangeway.contact import ContactSolution
from flangeway.post import nodal_residual
from flangeway.problems import ElasticField, Elasticity, PrescribedDisplacement

if TYPE_CHECKING:
    from flangeway.cases.bodies.two_bodies import TwoBodiesCase


def support_rows(
    case: "TwoBodiesCase", model: BodiesModel, results: Mapping[str, BodyResult], contact: ContactSolution | None
) -> list[dict[str, Any]]:
    """Force of each support on its body in space, in the order of the case's tables.

    Supports that hold the same component of a node share its reaction.
    """
    carried_load = {name: iter(_reactions(body, results[name], contact)) for name, body in model.bodies.items()}
    return [
        {"number": number, "body": table.body, "force_N": next(carried_load[table.body])}
        for number, table in enumerate(case.supports, 1)
    ]


def _reactions(body: BodyModel, result: BodyResult, contact: ContactSolution | None) -> list[list[float]]:
    """Force of each support of a body, x and y."""
    problem = body.problem
    forces = np.zeros((problem.space.n_nodes, 2))
    if body.part is not None and contact is not None:
        forces = result.placement.inverse().vectors(contact.nodal_forces(body.part))
    left = nodal_residual(ElasticField(problem, result.field.displacements), forces)[: problem.space.n_nodes]
    held = [_held(problem, support) for support in problem.prescribed]
    shares = left / np.maximum(np.sum(held, axis=0), 1)
    return result.placement.vectors([(shares * mine).sum(axis=0) for mine in held]).tolist() if held else []


def _held(problem: Elasticity, support: PrescribedDisplacement) -> NDArray[np.int64]:
    """Which components of which nodes a support holds: 1 or 0, shape (n_nodes, 2)."""
    held = np.zeros((problem.space.n_nodes, 2), dtype=np.int64)
    nodes = problem.support_nodes(support)
    for component, value in enumerate((support.x, support.y)):
        if value is not None:
            held[nodes, component] = 1
    return held
