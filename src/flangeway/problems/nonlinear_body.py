"""Bodies of nonlinear materials: forces, tangents and history at the points of quadrature inside cells.

Finite and virtual elements of any order take the gradient of the displacement from their reconstruction, so that the
material sees polynomials of degree k - 1 (Artioli et al., 2017, Comput. Mech. 60, part II; Wriggers et al., 2017,
Comput. Mech. 60). What they miss is stabilised with the scale of the tangent: of the undeformed body if the material
has no history, so that it returns on its path, and else of the last step, added up over the steps.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flangeway.elements import Reconstruction, monomials
from flangeway.errors import InputError, short
from flangeway.materials import NonlinearMaterial
from flangeway.materials.elastic import bulk_limited
from flangeway.mesh.mesh_checks import set_numbers
from flangeway.problems.body import Body
from flangeway.problems.elasticity_problem import Elasticity
from flangeway.problems.loads import PrescribedDisplacement, RigidHandle, Support
from flangeway.space import CellBatch, Space
from flangeway.space.functions import cell_quadrature
from flangeway.types import Floats

MaterialByCells = NonlinearMaterial | Mapping[str, NonlinearMaterial]


@dataclass(frozen=True, eq=False)
class Linearised(Elasticity):
    """A nonlinear body at given displacements as an elastic one, by its tangent.

    Parameters
    ----------
    tangents
        Stiffness of the cells of each batch, by the number of its first cell.

    """

    tangents: Mapping[int, Floats] | None = None

    def cell_stiffness(self, batch: CellBatch) -> Floats:
        """See `Elasticity.cell_stiffness`."""
        assert self.tangents is not None
        return self.tangents[int(batch.cells[0])]


@dataclass(frozen=True, eq=False)
class LinearisedBody(Body):
    """A body in contact with the stiffness of `Linearised`; springs are not part of the tangents."""

    tangents: Mapping[int, Floats] = field(default_factory=dict)

    @cached_property
    def elasticity(self) -> Linearised:
        """See `Body.elasticity`."""
        space = Space(self.mesh, self.element)
        settings = {"supports": self.springs, "name": self.name, "tangents": self.tangents}
        return Linearised(space, self.material, self.thickness, **settings)  # type: ignore[arg-type]

    @property
    def content(self) -> tuple[object, ...]:
        """See `LinearBody.content`."""
        return *super().content, *self.tangents.values()


@dataclass(frozen=True, eq=False)
class MaterialState:
    """What a body remembers after a step.

    Parameters
    ----------
    displacements
        All unknowns, (n_dofs, 2).
    history
        History at the points of each batch, (n_points, n_history).
    stabilisation
        Stiffness (n_local, n_local, n_cells) of what the cells of each batch miss, None where nothing is.
    missed_forces
        Its forces (n_local, 2, n_cells).

    """

    displacements: Floats
    history: list[Floats]
    stabilisation: list[Floats | None]
    missed_forces: list[Floats]


@dataclass(frozen=True, eq=False)
class _Points:
    """Points of quadrature of a batch: derivatives of the local functions (2, q, m, e) and weights (q, e)."""

    batch: CellBatch
    reconstruction: Reconstruction
    at: Floats  # (q, 2, e)
    slopes: Floats
    weights: Floats
    numbers: np.ndarray  # material of each point, (q * e,)


class NonlinearBody:
    """An elastic body's space, thickness, loads and supports with nonlinear materials.

    Parameters
    ----------
    problem
        The body in plane strain; its elastic materials are replaced.
    material
        Material of all cells, or of each named cell set.

    Raises
    ------
    InputError
        If the problem is not one of plane strain, has thermal loads, or a material is none.

    """

    def __init__(self, problem: Elasticity, material: MaterialByCells) -> None:
        self.materials = list(material.values()) if isinstance(material, Mapping) else [material]
        if not all(isinstance(material, NonlinearMaterial) for material in self.materials):
            raise InputError(f"the material {short(material)}", "a NonlinearMaterial", "make a J2Plasticity, ...")
        if problem.materials[0].hypothesis != "plane_strain" or problem.thermal_loads:
            raise InputError(
                f"nonlinear materials of body `{problem.name}` in {problem.materials[0].hypothesis} or with heat",
                "plane strain, without changes of temperature",
                "make the Elasticity problem with the elasticity of the material",
            )
        mesh = problem.space.mesh
        elastic = (
            {name: nonlinear.elastic for name, nonlinear in material.items()} if isinstance(material, Mapping) else None
        )
        self.problem = replace(problem, material=elastic or self.materials[0].elastic)
        numbers = set_numbers(mesh, material, "material") if isinstance(material, Mapping) else np.zeros(mesh.n_cells)
        self.n_history = max(material.n_history for material in self.materials)
        self._points = [self._batch_points(batch, numbers.astype(int)) for batch in problem.space.batches()]

    @staticmethod
    def _batch_points(batch: CellBatch, numbers: np.ndarray) -> _Points:
        reconstruction = batch.reconstruction
        energetic = reconstruction.for_energy
        degree = energetic.order - 1
        if degree == 0:  # constant strains: one point stands for the cell
            at, weights = energetic.frame.origin[None], energetic.areas[None]
        else:
            at, weights = cell_quadrature(batch, 2 * degree)
        values = monomials.evaluate(degree, energetic.frame.local(at))
        # d_x B_m(q) = sum over monomials a of p_a(x_q) g_axm
        slopes = np.einsum("aqe,axme->xqme", values, energetic.gradient)
        return _Points(batch, reconstruction, at, slopes, weights, np.tile(numbers[batch.cells], len(weights)))

    @property
    def points(self) -> Floats:
        """Points of quadrature, (n_points, 2), batch by batch."""
        return np.concatenate([part.at.swapaxes(1, 2).reshape(-1, 2) for part in self._points])

    def start(self) -> MaterialState:
        """The undeformed body."""
        rest = np.zeros((self.problem.space.n_dofs, 2))
        history = [np.zeros((part.weights.size, self.n_history)) for part in self._points]
        missed = [np.zeros((*part.batch.dofs.shape, 2)).swapaxes(1, 2) for part in self._points]
        state = MaterialState(rest, history, [None] * len(history), missed)
        return self._stabilised(state)

    def _response(self, part: _Points, displacements: Floats, history: Floats) -> tuple[Floats, Floats, Floats]:
        """Stress (n, 2, 2), tangent (n, 2, 2, 2, 2) and history after at the points of a batch."""
        # grad u_ix(q) = sum over m of d_x B_m(q) u_mi
        local = displacements[part.batch.dofs]
        # a translation, which has no gradient, would cost digits
        local = local - part.reconstruction.monomial_dofs[:, 0, :, None] * local[0]
        gradient = np.einsum("xqme,mei->qeix", part.slopes, local, optimize=True).reshape(-1, 2, 2)
        stress, tangent, after = np.empty_like(gradient), np.empty((len(gradient), 2, 2, 2, 2)), history.copy()
        for number, material in enumerate(self.materials):
            rows = np.flatnonzero(part.numbers == number)
            response = material.respond(gradient[rows], history[rows, : material.n_history])
            stress[rows], tangent[rows], after[rows, : material.n_history] = response
        return stress, tangent, after

    def _consistency(self, part: _Points, tangent: Floats) -> Floats:
        """Stiffness of the reconstructed displacement, (n_local, 2, n_local, 2, n_cells)."""
        weighted = tangent.reshape(*part.weights.shape, 2, 2, 2, 2) * part.weights[..., None, None, None, None]
        n = len(part.batch.dofs)
        result = np.empty((n, 2, n, 2, part.weights.shape[1]))
        for i, j in np.ndindex(2, 2):
            right = np.einsum("qexy,yqne->xqne", weighted[:, :, i, :, j, :], part.slopes, optimize=True)
            result[:, i, :, j] = np.einsum("xqme,xqne->mne", part.slopes, right, optimize=True)
        return result

    def _stabilised(self, state: MaterialState) -> MaterialState:
        """Take the stabilisation of the tangent at a state."""
        stabilisation = []
        for part, history in zip(self._points, state.history, strict=True):
            tangent = self._response(part, state.displacements, history)[1]
            by_component = self._consistency(part, tangent).transpose(1, 3, 0, 2, 4)
            added = part.batch.element.stabilise(part.reconstruction, by_component)
            if added is not None:
                mean = np.einsum("qe,qeijkl->ijkle", part.weights, tangent.reshape(*part.weights.shape, 2, 2, 2, 2))
                added = added * bulk_limited(mean)
            stabilisation.append(added)
        return replace(state, stabilisation=stabilisation)

    def _missed(self, number: int, state: MaterialState, displacements: Floats) -> Floats:
        """Forces of the stabilisation on the cells of a batch, (n_local, 2, n_cells)."""
        stiffness = state.stabilisation[number]
        if stiffness is None:
            return state.missed_forces[number]
        moved = (displacements - state.displacements)[self._points[number].batch.dofs]
        return state.missed_forces[number] + np.einsum("mne,nei->mie", stiffness, moved)

    def linearised(self, state: MaterialState, displacements: Floats) -> tuple[dict[int, Floats], Floats]:
        """Tangents of `Linearised`, and internal forces (n_dofs, 2), at given displacements after a state."""
        depth, tangents, forces = self.problem.thickness, {}, np.zeros_like(displacements)
        for number, (part, history) in enumerate(zip(self._points, state.history, strict=True)):
            stress, tangent, _ = self._response(part, displacements, history)
            weighted = stress.reshape(*part.weights.shape, 2, 2) * part.weights[..., None, None]
            block = np.einsum("xqme,qeix->mie", part.slopes, weighted, optimize=True)
            block += self._missed(number, state, displacements)
            matrix = self._consistency(part, tangent)
            added = state.stabilisation[number]
            if added is not None:
                matrix[:, 0, :, 0] += added
                matrix[:, 1, :, 1] += added
            np.add.at(forces, part.batch.dofs, depth * block.swapaxes(1, 2))
            n = 2 * len(block)
            tangents[int(part.batch.cells[0])] = depth * matrix.reshape(n, n, -1)
        return tangents, forces

    def committed(self, state: MaterialState, displacements: Floats) -> MaterialState:
        """The state after a step to given displacements."""
        pairs = list(enumerate(zip(self._points, state.history, strict=True)))
        history = [self._response(part, displacements, before)[2] for _, (part, before) in pairs]
        if not self.n_history:
            return state
        missed = [self._missed(number, state, displacements) for number, _ in pairs]
        return self._stabilised(MaterialState(displacements, history, state.stabilisation, missed))

    def stresses(self, before: MaterialState, displacements: Floats) -> tuple[Floats, Floats]:
        """Stress (n_points, 2, 2) and history (n_points, n_history) at `points`, after a step from a state."""
        pairs = zip(self._points, before.history, strict=True)
        responses = [self._response(part, displacements, history) for part, history in pairs]
        return np.concatenate([response[0] for response in responses]), np.concatenate(
            [response[2] for response in responses]
        )


def scaled(support: Support, motion: float, force: float) -> Support:
    """A support whose prescribed motions and forces are multiplied by factors; springs stay."""
    if isinstance(support, PrescribedDisplacement):
        x, y = (
            (lambda p, value=value: motion * value(p)) if callable(value) else value and motion * value
            for value in (support.x, support.y)
        )
        return replace(support, x=x, y=y)
    if isinstance(support, RigidHandle):
        x, y, rotation = (value and motion * value for value in support.prescribed)
        forces = (force * support.force[0], force * support.force[1])
        return replace(support, x=x, y=y, rotation=rotation, force=forces, moment=force * support.moment)
    return support
