"""Kirchhoff's plate by the virtual element of class C1 (Brezzi and Marini, 2013, CMAME 253), orders 2 and 3.

Along edges the deflection is cubic and its normal derivative of degree k - 1. Unknowns: at each point of the mesh the
deflection and two slopes times the size of the cells there, and of order 3 the normal derivative in the middle of
each edge times its length. Slopes at the boundary are along and across it, at corners along both edges, so that a
simple support of one of them holds one. All are those of one scalar field: `solve`, `Factor` and `modes` take them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.checks import check_finite, check_positive
from flangeway.elements import Function, Virtual, batched, monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.projection import principal_frame
from flangeway.elements.quadrature import gauss
from flangeway.errors import InputError
from flangeway.forms.weak import scattered
from flangeway.geometry.arrays import chords_of, joined_columns, steps_around
from flangeway.mesh import PolyMesh
from flangeway.space import CellBatch, FormMatrix, Space
from flangeway.space.functions import at_points, function_of
from flangeway.types import Bools, Floats, Indices, Ints

CORNER_SINE = np.sin(np.radians(20.0))
"""Sine of the angle between the boundary's edges at a point above which it is a corner, with a slope along each."""


@dataclass(frozen=True, eq=False)
class PlateCells:
    """Polynomials of a batch of cells as linear maps of the local unknowns, which are on the axis before the last."""

    batch: CellBatch
    numbers: Ints  # of the unknowns, (n_local, n_cells)
    frame: Frame
    moments: Floats  # of monomials up to degree 2 k
    curvature: Floats  # coefficients of the second derivatives, (n_monomials(k - 2), 2, 2, n_local, n_cells)
    value: Floats  # projection orthogonal in energy, (n_monomials(k), n_local, n_cells)
    dofs: Floats  # unknowns of the monomials, (n_local, n_monomials(k), n_cells)


@dataclass(frozen=True, eq=False)
class Plate:
    """A thin plate on any polygons with straight edges.

    Parameters
    ----------
    mesh
        The mesh.
    order
        Order k, 2 or 3: errors of second derivatives fall like h^(k - 1), of eigenvalues like h^(2 k - 2).
    rigidity
        Bending stiffness ``E t^3 / 12 / (1 - nu^2)`` > 0.
    poisson
        Poisson's ratio, -1 < nu < 1.

    Raises
    ------
    InputError
        If the order is neither 2 nor 3, a value is out of its range, or edges are curved.

    """

    mesh: PolyMesh
    order: int = 2
    rigidity: float = 1.0
    poisson: float = 0.3

    def __post_init__(self) -> None:
        if self.order not in (2, 3) or self.mesh.curves is not None:
            raise InputError(
                f"Plate of order {self.order}, or with curved edges", "2 or 3, straight edges", "take mesh.straight()"
            )
        check_positive("Plate", "rigidity", self.rigidity, advice="give E t^3 / 12 / (1 - nu^2)")
        if not abs(check_finite("Plate", "poisson", self.poisson)) < 1.0:
            raise InputError(f"Plate: poisson={self.poisson}", "-1 < nu < 1", "give Poisson's ratio")

    @property
    def n_dofs(self) -> int:
        """Number of unknowns: ``3 * point + (0, 1, 2)``, then those of edges."""
        return 3 * self.mesh.n_points + (len(self.mesh.edges) if self.order == 3 else 0)

    @cached_property
    def _sizes(self) -> Floats:
        """Mean size of the cells at each point, (n_points,)."""
        sizes = np.repeat(np.sqrt(self.mesh.cell_areas), np.diff(self.mesh.cell_offsets))
        total = np.bincount(self.mesh.cell_points, sizes, self.mesh.n_points)
        return total / np.maximum(np.bincount(self.mesh.cell_points, minlength=self.mesh.n_points), 1)

    @cached_property
    def _axes(self) -> tuple[Floats, Bools]:
        """Directions of the two slopes at each point, (n_points, 2 slopes, 2), and where the boundary has a corner."""
        edges = self.mesh.boundary_edges
        along = chords_of(self.mesh.points[edges])
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        before, after = np.tile([1.0, 0.0], (2, self.mesh.n_points, 1))
        before[edges[:, 1]], after[edges[:, 0]] = along, along
        corner = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) > CORNER_SINE
        back = (before * after).sum(axis=1) < 0.0  # around the end of a slit
        tangent = before + np.where(back[:, None], -after, after)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        across = tangent[:, ::-1] * [-1.0, 1.0]
        return np.where(corner[:, None, None], np.stack((before, after), 1), np.stack((tangent, across), 1)), corner

    def boundary_dofs(self, support: str = "clamped", on: str | None = None) -> Ints:
        """Unknowns that a support holds: ``"clamped"`` or ``"simple"``, along an edge set or the whole boundary."""
        if support not in ("clamped", "simple"):
            raise InputError(f"a plate whose boundary is {support!r}", "'clamped' or 'simple'", "choose one of them")
        pairs = self.mesh.boundary_edges if on is None else self.mesh.edge_set(on)
        first, last = pairs.T
        # the deflection, and the slopes along the edges: at a corner an edge's own
        held = [3 * first, 3 * last, 3 * last + 1, 3 * first + 1 + self._axes[1][first]]
        if support == "clamped":
            held += [3 * end + slope for end in (first, last) for slope in (1, 2)]
            if self.order == 3:
                held.append(3 * self.mesh.n_points + self.mesh.edge_numbers(pairs))
        return np.unique(np.concatenate(held)).astype(np.int64)

    def cells(self) -> Iterator[PlateCells]:
        """Reconstruct in batches of cells."""
        for batch in Space(self.mesh, Virtual(1)).batches():
            yield self._reconstruct(batch)

    def _traces(self, batch: CellBatch, normals: Floats, lengths: Floats) -> tuple[Floats, Floats]:
        """Value (q, v, n_local, e) and gradient (q, v, 2, n_local, e) at Gauss points of edges."""
        corners, n = batch.dofs, len(batch.dofs)
        tangents = -batched.turned_right(normals)
        s = gauss(4)[0]
        hermite = np.array([1 - 3 * s**2 + 2 * s**3, s - 2 * s**2 + s**3, 3 * s**2 - 2 * s**3, s**3 - s**2])
        slopes = np.array([6 * s**2 - 6 * s, 1 - 4 * s + 3 * s**2, 6 * s - 6 * s**2, 3 * s**2 - 2 * s])
        middle = 4.0 * s * (1.0 - s) if self.order == 3 else 0.0 * s
        linear = np.array([1.0 - s - middle / 2.0, s - middle / 2.0])
        # gradient = sum over c of dual_c unknown_c / size, where axis_b . dual_c = d_bc
        dual = np.linalg.inv(self._axes[0][corners]).swapaxes(-1, -2) / self._sizes[corners][..., None, None]
        value = np.zeros((len(s), n, 3 * n + (n if self.order == 3 else 0), corners.shape[1]))
        along, across = np.zeros_like(value), np.zeros_like(value)
        for v in range(n):
            for end, point in enumerate((v, (v + 1) % n)):
                value[:, v, 3 * point] += hermite[2 * end][:, None]
                along[:, v, 3 * point] += slopes[2 * end][:, None] / lengths[v]
                for c in range(2):
                    axis = dual[point, :, c].T
                    by_tangent, by_normal = (axis * tangents[v]).sum(axis=0), (axis * normals[v]).sum(axis=0)
                    value[:, v, 3 * point + 1 + c] += hermite[2 * end + 1][:, None] * lengths[v] * by_tangent
                    along[:, v, 3 * point + 1 + c] += slopes[2 * end + 1][:, None] * by_tangent
                    across[:, v, 3 * point + 1 + c] += linear[end][:, None] * by_normal
            if self.order == 3:
                across[:, v, 3 * n + v] = middle[:, None] * self._signs(corners)[v] / lengths[v]
        gradient = along[:, :, None] * tangents[None, :, :, None] + across[:, :, None] * normals[None, :, :, None]
        return value, gradient

    @staticmethod
    def _signs(corners: Indices) -> Floats:
        """Sign of the outward normal on an edge's own, which is on the right from the lower to the higher point."""
        return np.where(corners < np.roll(corners, -1, axis=0), 1.0, -1.0)

    def _reconstruct(self, batch: CellBatch) -> PlateCells:
        k, vertices, corners = self.order, batch.vertices, batch.dofs
        frame, n, n_cells = principal_frame(vertices), len(vertices), vertices.shape[-1]
        along = steps_around(vertices)
        lengths = np.sqrt((along**2).sum(axis=1))
        normals = batched.turned_right(along) / lengths[:, None]
        moments = monomials.integrals(2 * k, frame.local(vertices), 1.0 / frame.determinant)
        value, gradient = self._traces(batch, normals, lengths)
        s, weights = gauss(4)
        points = vertices + s[:, None, None, None] * along
        at = monomials.evaluate(k, frame.local(points))  # (a, q, v, e)
        weighted = np.einsum("q,ve,vie->qvie", weights, lengths, normals)
        low, n_low = at[: n_monomials(k - 2)], n_monomials(k - 2)
        slopes = np.einsum("lje,lda->jdae", frame.map, monomials.derivatives(k))  # of monomials, in space
        # int m_b d_ij v = int_boundary m_b n_i d_j v - int_boundary d_i m_b n_j v, for degree k - 2 <= 1
        second = np.einsum("bqve,qvie,qvjme->bijme", low, weighted, gradient, optimize=True)
        if k == 3:
            flux = np.einsum("qvje,qvme->jme", weighted, value, optimize=True)
            second -= np.einsum("ibe,jme->bijme", slopes[:, 0, :n_low], flux)
        mass = monomials.mass(k - 2, moments)
        curvature = batched.solve(mass, second.reshape(n_low, -1, n_cells)).reshape(second.shape)
        # second derivatives of the monomials, (i, j, coefficient b, monomial a)
        bent = np.einsum("jbde,idae->ijbae", slopes[:, :n_low, : n_monomials(k - 1)], slopes, optimize=True)[..., 3:, :]
        gram = np.einsum("ijbae,bce,ijcde->ade", bent, mass, bent, optimize=True)
        rhs = np.einsum("ijbae,bijme->ame", bent, second, optimize=True)
        projection = np.zeros((n_monomials(k), *second.shape[3:]))
        projection[3:] = batched.solve(gram, rhs)
        # mean gradient, then the mean of the vertices
        means = np.einsum("qvie,qvme->ime", weighted, value, optimize=True) / moments[0]
        means -= np.einsum(
            "idae,de,ame->ime", slopes[:, :, 3:], moments[: slopes.shape[1]] / moments[0], projection[3:]
        )
        projection[1:3] = np.einsum("ile,ime->lme", frame.inverse, means)
        at_vertices = monomials.evaluate(k, frame.local(vertices))  # (a, v, e)
        projection[0, 0 : 3 * n : 3] = 1.0 / n
        projection[0] -= np.einsum("ae,ame->me", at_vertices[1:].mean(axis=1), projection[1:])

        dofs = np.zeros((second.shape[3], n_monomials(k), n_cells))
        dofs[0 : 3 * n : 3] = at_vertices.swapaxes(0, 1)
        steep = np.einsum("jdae,dve->jvae", slopes, at_vertices[: slopes.shape[1]])
        for c in range(2):
            axis = self._axes[0][corners, c] * self._sizes[corners][..., None]  # (v, e, 2)
            dofs[1 + c : 3 * n : 3] = np.einsum("vej,jvae->vae", axis, steep)
        numbers = [3 * corners.astype(np.int64)[:, None] + np.arange(3)[:, None]]
        if k == 3:
            half = monomials.evaluate(k - 1, frame.local(vertices + along / 2.0))
            scale = normals * (self._signs(corners) * lengths)[:, None]
            dofs[3 * n :] = np.einsum("vje,jdae,dve->vae", scale, slopes, half, optimize=True)
            entries = self.mesh.cell_offsets[batch.cells] + np.arange(n)[:, None]
            numbers.append(3 * self.mesh.n_points + self.mesh.cell_edges[entries][:, None])
        joined = np.concatenate([number.reshape(-1, n_cells) for number in numbers])
        return PlateCells(batch, joined, frame, moments, curvature, projection, dofs)

    def moments_per_curvature(self, curvature: Floats) -> Floats:
        """``D ((1 - nu) w_ij + nu w_kk d_ij)`` of second derivatives (n, 2, 2, ...)."""
        trace = curvature[:, 0, 0] + curvature[:, 1, 1]
        result = (1.0 - self.poisson) * curvature
        result[:, 0, 0] += self.poisson * trace
        result[:, 1, 1] += self.poisson * trace
        return self.rigidity * result

    def stiffness(self) -> sp.csr_array:
        """Integrals of bending moments times curvatures, shape (n_dofs, n_dofs)."""

        def matrix(cells: PlateCells) -> Floats:
            stress = self.moments_per_curvature(cells.curvature)
            mass = monomials.mass(self.order - 2, cells.moments)
            consistent = np.einsum("aijme,abe,bijne->mne", cells.curvature, mass, stress, optimize=True)
            missed = np.eye(len(cells.numbers))[:, :, None] - np.einsum("iae,ame->ime", cells.dofs, cells.value)
            return consistent + batched.symmetric_product(missed, missed) * (self.rigidity / cells.moments[0])

        lifted = np.zeros(self.n_dofs)
        lifted[0 : 3 * self.mesh.n_points : 3] = 1.0
        return FormMatrix.measured(self._assembled([(cells.numbers, matrix(cells)) for cells in self.cells()]), lifted)

    def mass(self, density: float = 1.0) -> sp.csr_array:
        """Integrals of products of deflections, times a mass per area."""
        matrices = []
        for cells in self.cells():
            weighted = np.einsum("abe,bme->ame", monomials.mass(self.order, cells.moments), cells.value) * density
            matrices.append((cells.numbers, batched.symmetric_product(cells.value, weighted)))
        return self._assembled(matrices)

    def _assembled(self, matrices: list[tuple[Ints, Floats]]) -> sp.csr_array:
        return scattered(((m, m, local) for m, local in matrices), (self.n_dofs, self.n_dofs))

    def load(self, pressure: Function | ArrayLike) -> Floats:
        """Forces of a pressure, a number or a function of points (n, 2) with values (n,); shape (n_dofs,)."""
        result, given = np.zeros(self.n_dofs), function_of("a pressure", pressure, self.mesh.points[:1])
        for cells in self.cells():
            points, weights = cells.batch.quadrature(2 * self.order + 2)
            values = at_points(given, points)
            at = monomials.evaluate(self.order, cells.frame.local(points))
            np.add.at(result, cells.numbers, np.einsum("aqe,qe,ame->me", at, values * weights, cells.value))
        return result

    def at_quadrature(self, dofs: Floats, degree: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Points (n, 2), weights (n,), deflection (n,) and second derivatives (n, 2, 2), by projections."""
        parts = []
        for cells in self.cells():
            points, weights = cells.batch.quadrature(degree)
            at, local = monomials.evaluate(self.order, cells.frame.local(points)), dofs[cells.numbers]
            value = np.einsum("aqe,ame,me->qe", at, cells.value, local, optimize=True)
            low = at[: len(cells.curvature)]
            bent = np.einsum("aqe,aijme,me->qeij", low, cells.curvature, local, optimize=True)
            parts.append((points.swapaxes(1, 2).reshape(-1, 2), weights.ravel(), value.ravel(), bent.reshape(-1, 2, 2)))
        at, weight, deflection, second = joined_columns(parts)
        return at, weight, deflection, second
