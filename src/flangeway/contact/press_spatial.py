"""Bodies of polyhedra pressed on rigid surfaces and on each other: small displacements, no friction.

With the constraints' forces p >= 0, the gaps g of the loaded bodies without contact, and motions r of what contact
alone holds, the gaps are ``M p + N r + g``, and the motions' equations ``N^T p + e = 0`` with the loads e along them.
These are the equations of `flangeway.solve.active_set`, in the plane as in space. M is the sum of ``G K^-1 G^T`` over
the bodies with the derivatives G of the gaps; where supports leave motions free, as many unknowns are held as there are
such motions, which carry nothing once the motions are in equilibrium.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr

from flangeway.checks import are_all, are_finite
from flangeway.contact.pairs import Multiplier
from flangeway.contact.solution_checks import MAX_RESIDUAL, spatial_cells
from flangeway.contact.spatial_contact import RigidSurface, Solid, SpatialContact, Vector
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import max_magnitude, norms, starts_of
from flangeway.mesh import PolyhedralMesh
from flangeway.problems import ElasticField
from flangeway.results import Result, ResultTable
from flangeway.solve.active_set import Answer, DenseEquations, Laws, Motions, solve
from flangeway.solve.constraints import find_constraints, unheld_velocities
from flangeway.solve.linear import cholesky
from flangeway.solve.status import Checks, Status
from flangeway.types import Floats

COLUMNS = 256
"""Constraints whose displacements are computed at a time."""
SPRING, MAX_STEPS = 1e-2, 100
"""Springs that hold motions in a step, relative to the stiffness of a constraint, and how many steps are made."""
MAX_GAP = 1e-3
"""Gap under pressure, and overlap, relative to the maximum displacement, above which a solution is wrong."""
MIN_NODES = 9
"""Nodes of a contact under pressure below which a message says that they are few."""


class LoadedBody:
    """A body with its loads and supports: displacements without contact, and by forces on its nodes.

    - `gradients`: derivatives of gaps by the displacements of its nodes, (m, 3 n_nodes).
    """

    def __init__(self, body: Solid, gradients: sp.csr_array) -> None:
        constraints, self.size = find_constraints(body), body.size
        self._free, self._stiffness = constraints.transform, body.stiffness()
        for spring in body.springs:
            self._stiffness = self._stiffness.plus(body.spring_stiffness(spring))
        self.velocities = unheld_velocities(body, constraints)
        kept, n = np.ones(self._free.shape[1], dtype=bool), self.velocities.shape[1]
        if n:  # a force on what is held displaces nothing: that is not where contact acts
            away = np.setdiff1d(np.arange(len(kept)), self._free[gradients.indices].indices)
            kept[away[qr((self._free.T @ self.velocities)[away].T, mode="r", pivoting=True)[1][:n]]] = False
        self._transform = sp.csr_array(self._free[:, kept])
        self._factor = cholesky(self._stiffness.transformed(self._transform), constraints.groups[kept])
        self.load = (body.load_vector() + body.thermal_load_vector()).ravel()
        self.unloaded = constraints.shift + self.by_forces(self.load - self._stiffness.times(constraints.shift))

    def by_forces(self, forces: Floats) -> Floats:
        """Displacements (3 n_nodes, ...) by forces on the nodes, of the same shape."""
        return np.asarray(self._transform @ self._factor.solve(np.ascontiguousarray(self._transform.T @ forces)))

    def unbalanced(self, field: Floats, forces: Floats) -> float:
        """Maximum force that displacements and contact forces (3 n_nodes,) leave where no support holds."""
        return max_magnitude(self._free.T @ (self._stiffness.times(field) - self.load - forces))


class LoadedSurface:
    """A rigid surface that a force moves along its direction, by the names of `LoadedBody`."""

    def __init__(self, load: Vector, size: float) -> None:
        self.load, self.size, self.unloaded = np.array(load, dtype=np.float64), size, np.zeros(3)
        self.velocities = self.load[:, None] / np.linalg.norm(load)

    def by_forces(self, forces: Floats) -> Floats:
        """No displacements."""
        return 0.0 * forces

    def unbalanced(self, field: Floats, forces: Floats) -> float:  # noqa: ARG002 (it is not elastic)
        """Sum of forces along the direction of the load."""
        return max_magnitude(self.velocities.T @ (self.load + forces))


@dataclass(frozen=True, eq=False)
class SpatialForces:
    """Forces of one contact.

    Parameters
    ----------
    contact
        The contact.
    forces
        Normal force on each node of ``contact.pairs``, >= 0, shape (m,).

    """

    contact: SpatialContact
    forces: Floats

    @property
    def points(self) -> Floats:
        """Nodes of the constraints on the undeformed secondary, shape (m, 3)."""
        return self.contact.secondary.body.space.nodes[self.contact.pairs.keys]

    @property
    def pressures(self) -> Floats:
        """Nodal forces over the areas that belong to the nodes, shape (m,)."""
        return self.forces / self.contact.pairs.areas

    @property
    def resultant(self) -> Floats:
        """Force on the secondary, shape (3,)."""
        return self.forces @ self.contact.pairs.normals

    @property
    def area(self) -> float:
        """Area of the nodes under pressure."""
        return float(self.contact.pairs.areas[self.forces > 0.0].sum())

    def semi_axes(self, centre: Vector | None = None) -> tuple[float, float]:
        """Longer and shorter semi-axis of the ellipse under a Hertzian pressure with the same second moments.

        A force is the integral of pressure times a function that is linear between nodes, by which the squares of arms
        are larger by a sixth of the node's area in both directions along the surface.

        - `centre`: of a half or a quarter of a body the point in its planes of symmetry, which are those of the
          coordinates; left out: the centre of pressure.
        """
        fractions = self.forces / self.forces.sum()
        arms = self.points - (fractions @ self.points if centre is None else centre)
        moments = (fractions * arms.T) @ arms
        values = np.linalg.eigvalsh(moments if centre is None else np.diag(np.diag(moments)))[:0:-1]
        long, short = np.sqrt(5.0 * (values - fractions @ self.contact.pairs.areas / 6.0)).tolist()
        return long, short


@dataclass(frozen=True, eq=False)
class SpatialSolution(Result):
    """Solution of `press_spatial`.

    Parameters
    ----------
    contacts
        Forces of each contact.
    displacements
        Displacements of the nodes of each body, (n_nodes, 3), and of each loaded rigid surface, (1, 3).
    status
        How the computation ended; what was measured is in ``status.checks``.

    """

    contacts: tuple[SpatialForces, ...]
    displacements: Mapping[Solid | RigidSurface, Floats]
    status: Status

    @property
    def table(self) -> ResultTable:
        """Nodes under pressure."""
        rows = [
            {"contact": number, "point": point.tolist(), "normal_force": force, "pressure": pressure}
            for number, solved in enumerate(self.contacts)
            for point, force, pressure in zip(solved.points, solved.forces, solved.pressures, strict=True)
            if force > 0.0
        ]
        return ResultTable.of_rows(rows)

    def field(self, body: Solid) -> ElasticField[PolyhedralMesh]:
        """Displacements of a body, for stresses and pictures."""
        return ElasticField(body, self.displacements[body])


def press_spatial(
    contacts: Sequence[SpatialContact], loads: Mapping[RigidSurface, Vector] | None = None
) -> SpatialSolution:
    """Press bodies of polyhedra on rigid surfaces and on each other, without friction.

    Displacements are small against the bodies and against the radii of the surfaces. Loads and supports are those of
    the bodies (`flangeway.problems.Elasticity`); rigid motions that their supports leave free are held by contact.

    Parameters
    ----------
    contacts
        Contacts among the bodies and with rigid surfaces.
    loads
        Force (x, y, z) on a rigid surface, which then moves along it until contact balances it. Other rigid surfaces
        stay in place: one that starts inside of a body presses on it.

    Raises
    ------
    InputError
        If there is no contact, or a load is none of a rigid surface in contact.

    """
    loads = loads or {}
    _refuse_bad_inputs(contacts, loads)
    both_sides = [mover for contact in contacts for mover in (contact.secondary.body, contact.mover)]
    bodies = dict.fromkeys(mover for mover in both_sides if not isinstance(mover, RigidSurface))
    movers: list[Solid | RigidSurface] = [*bodies, *loads]
    gradients = {mover: sp.csr_array(sp.vstack([contact.gradients(mover) for contact in contacts])) for mover in movers}
    loaded: dict[Solid | RigidSurface, LoadedBody | LoadedSurface]
    loaded = {body: LoadedBody(body, gradients[body]) for body in bodies}
    size = max(response.size for response in loaded.values())
    loaded |= {surface: LoadedSurface(load, size) for surface, load in loads.items()}
    offset = np.concatenate([contact.pairs.gaps for contact in contacts])
    compliances, barriers = (
        np.concatenate([getattr(contact.enforcement, name)(contact.pairs) for contact in contacts])
        for name in ("compliances", "barriers")
    )
    matrix, m = np.diag(compliances), len(offset)
    for mover, response in loaded.items():
        offset += gradients[mover] @ response.unloaded
        for start in range(0, m, COLUMNS):
            forces = gradients[mover][start : start + COLUMNS].T.toarray()
            matrix[:, start : start + COLUMNS] += gradients[mover] @ response.by_forces(forces)
    counts = [response.velocities.shape[1] for response in loaded.values()]
    by_motion = np.hstack([gradients[mover] @ response.velocities for mover, response in loaded.items()])
    n = by_motion.shape[1]
    motions = Motions(
        by_motion,
        by_motion.T,
        np.zeros((n, n)),
        np.concatenate([response.velocities.T @ response.load for response in loaded.values()]),
        np.repeat(np.arange(len(counts)), counts),
        np.repeat([response.size for response in loaded.values()], counts),
    )
    answer = _answer((matrix + matrix.T) / 2.0, offset, barriers, motions)
    forces, moved = (np.zeros(m), np.zeros(n)) if answer is None else (answer.forces, answer.motions)
    by_contact = {mover: gradients[mover].T @ forces for mover in loaded}
    fields = {
        mover: response.unloaded + response.by_forces(by_contact[mover]) + response.velocities @ motion
        for (mover, response), motion in zip(loaded.items(), np.split(moved, np.cumsum(counts)[:-1]), strict=True)
    }
    rows = starts_of([len(contact.pairs.keys) for contact in contacts])
    solved = tuple(SpatialForces(contact, forces[rows[i] : rows[i + 1]]) for i, contact in enumerate(contacts))
    unbalanced = max(response.unbalanced(fields[mover], by_contact[mover]) for mover, response in loaded.items())
    scale = max(max_magnitude(forces), *(max_magnitude(response.load) for response in loaded.values())) or 1.0
    displacements = {mover: field.reshape(-1, 3) for mover, field in fields.items()}
    status = _status(solved, displacements, unbalanced / scale)
    if answer is None:
        advice = "check that loads press the bodies on each other, and that supports or contacts hold every motion"
        message = f"not converged: the laws of contact have no solution; {advice}"
        status = replace(status, converged=False, message=message)
    return SpatialSolution(solved, displacements, status)


def _answer(matrix: Floats, offset: Floats, barriers: Floats, motions: Motions) -> Answer | None:
    """Forces and motions; None if there are none.

    Where contact alone holds motions, springs hold them in steps until it does (proximal points, R. T. Rockafellar,
    1976, SIAM J. Control Optim. 14).
    """
    start, travelled, none = np.ones(len(offset)), np.zeros(len(motions.residual)), np.zeros(len(offset))
    exact = Laws(none, barriers, matrix.diagonal())
    for _ in range(MAX_STEPS):
        answer = solve(exact, DenseEquations(matrix, offset, exact, motions), start)
        if answer is not None or not len(travelled):
            return answer
        sprung = motions.sprung(matrix.diagonal(), SPRING)
        laws = Laws(none, barriers, matrix.diagonal() + sprung.compliances())
        step = solve(laws, DenseEquations(matrix, offset + motions.by_motion @ travelled, laws, sprung), start)
        if step is None:
            break
        start, travelled = step.forces, travelled + step.motions
    return None


def _status(
    contacts: Sequence[SpatialForces], fields: Mapping[Solid | RigidSurface, Floats], unbalanced: float
) -> Status:
    """What is measured on displacements and forces, apart from the equations that gave them."""
    errors: list[str] = []
    warnings: list[str] = []
    solids = {body: field for body, field in fields.items() if not isinstance(body, RigidSurface)}
    displaced = max(map(max_magnitude, solids.values())) or 1.0
    gap, slide, moment, overlap = 0.0, 0.0, 0.0, 0.0
    for solved in contacts:
        contact, closed = solved.contact, solved.forces > 0.0
        pairs, (arms, deepest) = contact.pairs, contact.measured(fields)
        gaps = np.einsum("mi,mi->m", arms, pairs.normals)
        slides = norms(arms - gaps[:, None] * pairs.normals) / np.sqrt(pairs.areas)
        left = solved.forces @ np.cross(arms, pairs.normals)  # by action and reaction at two points
        moment = max(
            moment, max_magnitude(left) / ((solved.forces.max(initial=0.0) or 1.0) * contact.secondary.body.size)
        )
        if isinstance(contact.enforcement, Multiplier) and closed.any():
            gap = max(gap, float(np.abs(gaps) @ solved.forces / solved.forces.sum()) / displaced)
            overlap = max(overlap, deepest / displaced)
        slide = max(slide, float(slides[closed].max(initial=0.0)))
        if closed.sum() < MIN_NODES:
            name = contact.secondary.body.name
            warnings.append(f"{closed.sum()} nodes of {name} are under pressure: take smaller cells where it touches")
    cells = [spatial_cells(body, field, errors, warnings) for body, field in solids.items()]
    inverted, strain, turn = (max(values) for values in zip(*cells, strict=True))
    for value, limit, what in (
        (unbalanced, MAX_RESIDUAL, "forces are unbalanced by {:.1e} of the maximum one"),
        (gap, MAX_GAP, "gaps under pressure are {:.1e} of the maximum displacement: bodies turn or slide too far"),
        (
            overlap,
            MAX_GAP,
            "a boundary enters the other one by {:.1e} of the maximum displacement: add it to a contact",
        ),
    ):
        if not value <= limit:
            errors.append(what.format(value))
    warnings += filter(None, [body.locking for body in solids])
    checks = Checks(
        unbalanced,
        moment,
        gap,
        slide,
        overlap * displaced,
        inverted,
        strain,
        turn,
        errors=tuple(errors),
        warnings=tuple(warnings),
    )
    message = "; ".join([f"forces are balanced to {unbalanced:.1e} of the maximum one", *warnings])
    return Status(not errors, f"not converged: {'; '.join(errors)}" if errors else message, 1, checks=checks)


def _refuse_bad_inputs(contacts: Sequence[SpatialContact], loads: Mapping[RigidSurface, Vector]) -> None:
    if not contacts or not are_all(contacts, SpatialContact):
        raise InputError(f"press_spatial({short(contacts)})", "a list of SpatialContact, one or more", "make one")
    surfaces = [contact.primary for contact in contacts]
    for surface, load in loads.items():
        if surface not in surfaces or not are_finite(load, 3) or not any(load):
            raise InputError(
                f"press_spatial(loads={{{short(surface)}: {short(load)}}})",
                "a force (x, y, z) on the rigid surface of a contact",
                "loads on bodies belong to Elasticity(loads=...)",
            )
