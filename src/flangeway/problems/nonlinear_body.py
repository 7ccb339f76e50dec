"""Bodies of nonlinear materials: forces, tangents and history at the points of quadrature inside cells.

Finite and virtual elements of any order take the gradient of the displacement from their reconstruction, so that the
material sees polynomials of degree k - 1 (Artioli et al., 2017, Comput. Mech. 60, part II; Wriggers et al., 2017,
Comput. Mech. 60). What they miss has the elastic stabilisation S times a factor t that follows the material. It is a
secant, which is continuous where the tangent jumps: with the deviators s of the stress and e of the gradient,

    t = |s| / |s_0 + 2 G r e|,   f = t S z,   z = z_0 + r u,

where u and e are increments since the state at the start of the step, in which the stress s_0, the amplitude z_0 and
the shear modulus r G against unloading are known. A step ends with the amplitude t z: forces of what is missed relax by
plastic flow as the deviator does in a radial return. So they are bounded where the deviator is, by steps of any size,
and never without stiffness. Materials without history have no other state than the undeformed body, z_0 = 0 and r = 1.
Tangents leave out how t changes: the residual, which has the current t, then falls about ten times an iteration.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from flangeway.elements import Reconstruction, monomials
from flangeway.errors import InputError, short
from flangeway.materials import NonlinearMaterial
from flangeway.mesh.mesh_checks import items_by_cells
from flangeway.problems.body import Body
from flangeway.problems.elasticity_problem import SPATIAL_STRAIN_PLACES, SPATIAL_STRAINS, Elasticity
from flangeway.problems.loads import PrescribedDisplacement, RigidHandle, Support
from flangeway.space import CellBatch, Space
from flangeway.types import Floats

MaterialByCells = NonlinearMaterial | Mapping[str, NonlinearMaterial]

DEVIATORS = np.array([[[0.5, 0.0], [0.0, -0.5]], [[0.0, 0.5], [0.5, 0.0]]])
"""Half of the difference of xx and yy, and the mean of xy and yx. Of a deformation they are half of the difference of
its principal stretches, however it turns."""
_X, _Y, _Z, *_SHEARS = SPATIAL_STRAINS
SPATIAL_DEVIATORS = np.stack([(_X - _Y) / 2.0, (_X + _Y - 2.0 * _Z) / np.sqrt(12.0), *np.array(_SHEARS) / 2.0])
"""The same in space: of the same size, and orthogonal to each other."""
MIN_STRAIN, VOLUME_WEIGHT = 1e-6, 0.01
"""Strain, and fraction of the change of volume, in both norms of the secant: without a deviator it is the elastic one.
"""
MIN_MODULUS = 1e-6
"""Minimum shear modulus of a damaged material relative to the elastic one."""


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
        All unknowns, (n_dofs, d).
    history
        History at the points of each batch, (n_points, n_history).
    deviators
        Deviators of the stress at the points of each batch, (n_points, 2), in space (n_points, 5).
    amplitudes
        Elastic displacements that make the forces of what the cells of each batch miss, (n_local, d, n_cells).
    moduli
        Twice the shear modulus against unloading at the points of each batch, (n_points,).

    """

    displacements: Floats
    history: list[Floats]
    deviators: list[Floats]
    amplitudes: list[Floats]
    moduli: list[Floats]


@dataclass(frozen=True, eq=False)
class _Points:
    """Points of quadrature of a batch: derivatives of the local functions (d, q, m, e) and weights (q, e)."""

    batch: CellBatch
    reconstruction: Reconstruction
    at: Floats  # (q, d, e)
    slopes: Floats
    weights: Floats
    numbers: np.ndarray  # material of each point, (q * e,)
    shear: Floats  # twice the elastic shear modulus of each point, (q * e,)
    stabilisation: Floats | None  # of the elastic material, (m, m, e)

    def gradient(self, displacements: Floats) -> Floats:
        """Gradients (q * e, d, d) of displacements (m, e, d)."""
        d = len(self.slopes)
        return np.einsum("xqme,mei->qeix", self.slopes, displacements, optimize=True).reshape(-1, d, d)

    def mean(self, values: Floats) -> Floats:
        """Means over the cells of values at points (q * e,), shape (e,)."""
        result: Floats = (self.weights * values.reshape(self.weights.shape)).sum(axis=0) / self.weights.sum(axis=0)
        return result


class NonlinearBody:
    """An elastic body's space, thickness, loads and supports with nonlinear materials.

    Parameters
    ----------
    problem
        The body in plane strain or in space; its elastic materials are replaced.
    material
        Material of all cells, or of each named cell set.

    Raises
    ------
    InputError
        If the problem is one of plane stress or axisymmetric, has thermal loads, or a material is none.

    """

    def __init__(self, problem: Elasticity[Any], material: MaterialByCells) -> None:
        self.materials = items_by_cells(material)
        if not all(isinstance(material, NonlinearMaterial) for material in self.materials):
            raise InputError(f"the material {short(material)}", "a NonlinearMaterial", "make a J2Plasticity, ...")
        if problem.materials[0].hypothesis != "plane_strain" or problem.thermal_loads:
            raise InputError(
                f"nonlinear materials of body `{problem.name}` in {problem.materials[0].hypothesis} or with heat",
                "plane strain, without changes of temperature",
                "make the Elasticity problem with the elasticity of the material",
            )
        elastic: Any = [nonlinear.elastic for nonlinear in self.materials]
        elastic = dict(zip(material, elastic, strict=True)) if isinstance(material, Mapping) else elastic[0]
        self.problem = replace(problem, material=elastic)
        numbers, self.dimension = self.problem.cell_material, problem.dimension
        self.deviators = DEVIATORS if self.dimension == 2 else SPATIAL_DEVIATORS
        self.n_history = max(material.n_history for material in self.materials)
        self._points = [self._batch_points(batch, numbers) for batch in problem.space.batches()]

    def _batch_points(self, batch: CellBatch, numbers: np.ndarray) -> _Points:
        reconstruction = batch.reconstruction
        energetic = reconstruction.for_energy
        degree = energetic.order - 1
        if degree == 0:  # constant strains: one point stands for the cell
            at, weights = energetic.frame.origin[None], energetic.areas[None]
        else:
            at, weights = batch.quadrature(2 * degree)
        values = monomials.evaluate(degree, energetic.frame.local(at))
        # d_x B_m(q) = sum over monomials a of p_a(x_q) g_axm
        slopes = np.einsum("aqe,axme->xqme", values, energetic.gradient)
        of_points = np.tile(numbers[batch.cells], len(weights))
        shear = 2.0 * np.array([material.elastic.shear_modulus for material in self.materials])[of_points]
        points = _Points(batch, reconstruction, at, slopes, weights, of_points, shear, None)
        plane, places = self.dimension == 2, SPATIAL_STRAIN_PLACES
        tensors = [
            material.elastic.stiffness if plane else material.elastic.full_matrix[places[:, :, None, None], places]
            for material in self.materials
        ]
        elastic = np.stack(tensors)[of_points]
        consistency = self._consistency(points, elastic).transpose(1, 3, 0, 2, 4)
        added = batch.element.stabilise(reconstruction, consistency)
        if added is None:
            return points
        return replace(points, stabilisation=added * self.problem.stabilisation_factors(batch))

    @property
    def points(self) -> Floats:
        """Points of quadrature, (n_points, d), batch by batch."""
        return np.concatenate([part.at.swapaxes(1, 2).reshape(-1, self.dimension) for part in self._points])

    def locking(self, state: MaterialState) -> str | None:
        """Sentence about cells that lock, since they are nearly incompressible or flow; None where few of them do."""
        flows = any(history.any() for history in state.history)
        if not flows or self.problem.space.locks.mean() < 0.5:
            return self.problem.locking
        return (
            f"{self.problem.name} locks: plastic flow keeps its volume, and elements of order 1 make the forces "
            "too large; take order 2, or virtual elements on polygons"
        )

    def start(self) -> MaterialState:
        """The undeformed body."""
        d = self.dimension
        rest = np.zeros((self.problem.space.n_dofs, d))
        history = [np.zeros((part.weights.size, self.n_history)) for part in self._points]
        return self._state(
            rest, history, [np.zeros((*part.batch.dofs.shape, d)).swapaxes(1, 2) for part in self._points]
        )

    def _state(self, displacements: Floats, history: list[Floats], amplitudes: list[Floats]) -> MaterialState:
        """The state of displacements, history and amplitudes of what is missed."""
        deviators, moduli = [], []
        for part, of_part in zip(self._points, history, strict=True):
            stress, tangent, _ = self._response(part, displacements, of_part)
            deviators.append(np.einsum("aij,nij->na", self.deviators, stress))
            # of a yielding material the largest one: that across the flow, which is the elastic one
            shear = np.linalg.eigvalsh(np.einsum("aij,nijkl,bkl->nab", self.deviators, tangent, self.deviators))[:, -1]
            moduli.append(np.maximum(2.0 * shear, MIN_MODULUS * part.shear) if self.n_history else part.shear)
        return MaterialState(displacements, history, deviators, amplitudes, moduli)

    def _response(self, part: _Points, displacements: Floats, history: Floats) -> tuple[Floats, Floats, Floats]:
        """Stress (n, d, d), tangent (n, d, d, d, d) and history after at the points of a batch."""
        # grad u_ix(q) = sum over m of d_x B_m(q) u_mi
        local = displacements[part.batch.dofs]
        # a translation, which has no gradient, would cost digits
        local = local - part.reconstruction.monomial_dofs[:, 0, :, None] * local[0]
        gradient = part.gradient(local)
        d = self.dimension
        stress, tangent, after = np.empty_like(gradient), np.empty((len(gradient), d, d, d, d)), history.copy()
        for number, material in enumerate(self.materials):
            rows = np.flatnonzero(part.numbers == number)
            response = material.respond(gradient[rows], history[rows, : material.n_history])
            stress[rows], tangent[rows], after[rows, : material.n_history] = response
        return stress, tangent, after

    def _consistency(self, part: _Points, tangent: Floats) -> Floats:
        """Stiffness of the reconstructed displacement, (n_local, d, n_local, d, n_cells)."""
        d = self.dimension
        weighted = tangent.reshape(*part.weights.shape, d, d, d, d) * part.weights[..., None, None, None, None]
        n = len(part.batch.dofs)
        result = np.empty((n, d, n, d, part.weights.shape[1]))
        for i, j in np.ndindex(d, d):
            right = np.einsum("qexy,yqne->xqne", weighted[:, :, i, :, j, :], part.slopes, optimize=True)
            result[:, i, :, j] = np.einsum("xqme,xqne->mne", part.slopes, right, optimize=True)
        return result

    def _missed(
        self, number: int, state: MaterialState, displacements: Floats, stress: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Forces, amplitudes after the step (n_local, d, n_cells) and moduli (n_cells,) of what a batch misses."""
        part, shear = self._points[number], state.moduli[number]
        assert part.stabilisation is not None
        local = (displacements - state.displacements)[part.batch.dofs]
        gradient = part.gradient(local)
        deviator, strain = (np.einsum("aij,nij->na", self.deviators, tensor) for tensor in (stress, gradient))
        trial = state.deviators[number] + shear[:, None] * strain
        regular = part.shear * np.hypot(MIN_STRAIN, VOLUME_WEIGHT * np.trace(gradient, axis1=1, axis2=2))
        secant = np.sqrt(((deviator**2).sum(axis=1) + regular**2) / ((trial**2).sum(axis=1) + regular**2))
        if self.n_history:  # kinematic hardening may pass through zero
            secant = np.minimum(secant, 1.0)
        factor, modulus = (part.mean(values) for values in (secant, shear / part.shear))
        amplitudes = factor * (state.amplitudes[number] + modulus * local.swapaxes(1, 2))
        return np.einsum("mne,nie->mie", part.stabilisation, amplitudes), amplitudes, factor * modulus

    def linearised(self, state: MaterialState, displacements: Floats) -> tuple[dict[int, Floats], Floats, Floats]:
        """Linearise at displacements (n_dofs, d) after a state.

        Tangents of `Linearised`, internal forces (n_dofs, d), and the works of the material's and of the
        stabilisation's along the displacements, summed over the cells without signs.
        """
        depth, tangents, forces = self.problem.thickness, {}, np.zeros_like(displacements)
        works = np.zeros(2)
        for number, (part, history) in enumerate(zip(self._points, state.history, strict=True)):
            stress, tangent, _ = self._response(part, displacements, history)
            weighted = stress.reshape(*part.weights.shape, self.dimension, -1) * part.weights[..., None, None]
            block = np.einsum("xqme,qeix->mie", part.slopes, weighted, optimize=True)
            local = displacements[part.batch.dofs].swapaxes(1, 2)
            works[0] += np.abs(np.einsum("mie,mie->e", block, local)).sum()
            matrix = self._consistency(part, tangent)
            if part.stabilisation is not None:
                missed, _, modulus = self._missed(number, state, displacements, stress)
                works[1] += np.abs(np.einsum("mie,mie->e", missed, local)).sum()
                block += missed
                for component in range(self.dimension):
                    matrix[:, component, :, component] += modulus * part.stabilisation
            np.add.at(forces, part.batch.dofs, depth * block.swapaxes(1, 2))
            n = self.dimension * len(block)
            tangents[int(part.batch.cells[0])] = depth * matrix.reshape(n, n, -1)
        return tangents, forces, works

    def committed(self, state: MaterialState, displacements: Floats) -> MaterialState:
        """The state after a step to given displacements."""
        if not self.n_history:
            return state
        history, amplitudes = [], []
        for number, part in enumerate(self._points):
            stress, _, after = self._response(part, displacements, state.history[number])
            history.append(after)
            if part.stabilisation is None:
                amplitudes.append(state.amplitudes[number])
            else:
                amplitudes.append(self._missed(number, state, displacements, stress)[1])
        return self._state(displacements, history, amplitudes)

    def stresses(self, before: MaterialState, displacements: Floats) -> tuple[Floats, Floats]:
        """Stress (n_points, d, d) and history (n_points, n_history) at `points`, after a step from a state."""
        pairs = zip(self._points, before.history, strict=True)
        responses = [self._response(part, displacements, history) for part, history in pairs]
        return np.concatenate([response[0] for response in responses]), np.concatenate(
            [response[2] for response in responses]
        )


def scaled(support: Support, motion: float, force: float) -> Support:
    """A support whose prescribed motions and forces are multiplied by factors; springs stay."""
    if isinstance(support, PrescribedDisplacement):
        x, y, z = (
            (lambda p, value=value: motion * value(p)) if callable(value) else value and motion * value
            for value in support.components
        )
        return replace(support, x=x, y=y, z=z)
    if isinstance(support, RigidHandle):
        x, y, rotation = (value and motion * value for value in support.prescribed)
        forces = (force * support.force[0], force * support.force[1])
        return replace(support, x=x, y=y, rotation=rotation, force=forces, moment=force * support.moment)
    return support
