"""St. Venant's torsion: from a space and shear moduli to stiffness, load and torsional rigidity.

Displacements are ``u = -theta' z y``, ``v = theta' z x``, ``w = theta' psi(x, y)``; all results are for a rate of
twist ``theta' = 1``. Equations of Moherdaui (2021) are as corrected: (2.99) with ``+2 G theta'``, (2.103) with a minus
sign.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from flangeway.elements import Reconstruction, energy_stiffness, monomials
from flangeway.elements.monomials import Frame, n_monomials
from flangeway.elements.quadrature import edge_rule
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import IntArray, frozen
from flangeway.mesh.connectivity import first_connected, next_in_row
from flangeway.mesh.mesh_checks import positive_by_cells
from flangeway.problems.loads import edge_quadrature
from flangeway.space import CellBatch, Space, SymmetricMatrix
from flangeway.types import Floats, floats

Formulation = Literal["warping", "prandtl"]
Load = Literal["projected", "vertex_mean"]

_CHOICES = {
    "formulation": ("warping", "prandtl"),
    "load": ("projected", "vertex_mean"),
}


@dataclass(frozen=True, eq=False)
class SectionBoundary:
    """Directed boundary edges in connected groups; loops that touch at a point are one group.

    Edges around the parts of the section (m, 2), edges around each hole, and areas of the holes (n_holes,).
    """

    outer: IntArray
    holes: tuple[IntArray, ...]
    hole_areas: Floats


def boundary_of(space: Space) -> SectionBoundary:
    """Sort the boundary edges of a space's mesh into the outer boundary and holes, by the areas inside their edges."""
    mesh = space.mesh
    pairs = mesh.boundary_edges
    labels = np.unique(first_connected(pairs, mesh.n_points)[pairs[:, 0]], return_inverse=True)[1]
    rule = edge_quadrature(space, pairs, space.order)
    # half the integral of the position times the normal along the edges, polynomials of their order
    offsets = rule.points - mesh.points.mean(axis=0)
    areas = np.bincount(labels, np.einsum("eq,eqi,eqi->e", rule.weights, offsets, rule.normals)) / 2.0
    holes = np.flatnonzero(areas <= 0.0)
    around = tuple(pairs[labels == hole] for hole in holes)
    return SectionBoundary(pairs[areas[labels] > 0.0], around, frozen(-areas[holes]))


@dataclass(frozen=True, eq=False)
class Torsion:
    """Uniform torsion of a cross-section of any shape, with holes or of several materials.

    Parameters
    ----------
    space
        Space of the unknown function.
    shear_modulus
        Shear modulus G > 0 of all cells, or of each named cell set, which must then cover the mesh once.
    formulation
        ``"warping"``: the warping function (Neumann's problem, Moherdaui (2021) 2.93). ``"prandtl"``: the stress
        function, zero on the outer boundary and constant on each hole's, whose value is an unknown (Moherdaui 2021,
        2.98).
    load
        How Prandtl's function is integrated, for the load and for the torsional rigidity: ``"projected"`` by the
        L2 projection (Moherdaui 2021, 3.81), or ``"vertex_mean"``, area times the mean of the vertices' values (order 1
        only; less accurate on polygons, the same on triangles).

    Raises
    ------
    InputError
        If a modulus is not positive, the sets do not cover the mesh once, or a choice is unknown.

    """

    space: Space
    shear_modulus: float | Mapping[str, float] = 1.0
    formulation: Formulation = "warping"
    load: Load = "projected"

    def __post_init__(self) -> None:
        for name, allowed in _CHOICES.items():
            if getattr(self, name) not in allowed:
                raise InputError(
                    f"Torsion({name}={short(getattr(self, name))})", " or ".join(allowed), "choose one of them"
                )
        if self.load == "vertex_mean" and (self.space.order > 1 or self.formulation != "prandtl"):
            raise InputError(
                f"Torsion(load='vertex_mean') with {self.formulation!r} of order {self.space.order}",
                "formulation='prandtl' of order 1",
                "leave load='projected', which is more accurate",
            )
        _ = self.cell_moduli

    @cached_property
    def cell_moduli(self) -> Floats:
        """Shear modulus of each cell, shape (n_cells,)."""
        return frozen(positive_by_cells(self.space.mesh, "Torsion", "shear_modulus", self.shear_modulus))

    @property
    def mean_modulus(self) -> float:
        """Mean shear modulus over the area; the modulus itself if there is one."""
        areas = self.space.element_mesh.cell_areas
        return float(self.cell_moduli @ areas / areas.sum())

    @cached_property
    def centre(self) -> Floats:
        """Centroid weighted by the shear modulus, shape (2,): the origin of the warping function."""
        mesh = self.space.element_mesh
        weights = self.cell_moduli * mesh.cell_areas
        base = mesh.points[0]
        return base + weights @ (mesh.cell_centroids - base) / weights.sum()

    @cached_property
    def boundary(self) -> SectionBoundary:
        """Outer boundary and holes."""
        return boundary_of(self.space)

    def stiffness(self) -> SymmetricMatrix:
        """Integrals of ``G grad . grad`` (warping) or ``grad . grad / G`` (Prandtl), no unknown held."""
        return self.space.assemble(self.cell_stiffness, n_components=1)

    def cell_stiffness(self, batch: CellBatch) -> Floats:
        """Stiffness of cells: consistency (Moherdaui 2021, 3.69) plus stabilisation, (n_local, n_local, n_cells)."""
        reconstruction = batch.reconstruct()
        moduli = self.cell_moduli[batch.cells]
        if self.formulation == "prandtl":
            moduli = 1.0 / moduli
        return energy_stiffness(batch.element, reconstruction, moduli)

    def load_vector(self) -> Floats:
        """Right-hand side, shape (n_dofs,); the holes' part of Prandtl's is in `reduced`."""
        return self._warping_load() if self.formulation == "warping" else self._prandtl_load()

    def _warping_load(self) -> Floats:
        """Integrals ``int G grad v . (y, -x)``, as ``G v (x dx + y dy)`` along the edges where G jumps."""
        mesh, space = self.space.mesh, self.space
        sign = np.where(mesh.cell_points < mesh.cell_points[next_in_row(mesh.cell_offsets)], 1.0, -1.0)
        moduli = np.repeat(self.cell_moduli, mesh.cell_sizes)
        jumps = np.bincount(mesh.cell_edges, sign * moduli, minlength=mesh.n_edges)
        edges = np.flatnonzero(jumps)
        nodes = space.edge_nodes(mesh.edges[edges])
        arms = space.nodes[nodes] - self.centre
        weights, shapes, slopes = edge_rule(space.order, 3 * space.order // 2 + 1)
        along = np.einsum("eqx,eqx->eq", shapes @ arms, slopes @ arms)
        local = jumps[edges, None] * ((along * weights) @ shapes)
        return floats(np.bincount(nodes.ravel(), local.ravel(), minlength=space.n_dofs))

    def _prandtl_load(self) -> Floats:
        """Integrals ``2 int v`` in the reading chosen by ``load``."""
        n_dofs = self.space.n_dofs
        load = np.zeros(n_dofs)
        for batch in self.space.batches():
            if self.load == "vertex_mean":
                areas = self.space.element_mesh.cell_areas[batch.cells]
                local = np.broadcast_to(2.0 * areas / len(batch.dofs), batch.dofs.shape)
            else:
                reconstruction = batch.reconstruction
                value = reconstruction.projected_value
                local = 2.0 * np.einsum("ae,ame->me", reconstruction.moments[: len(value)], value)
            load += np.bincount(batch.dofs.ravel(), local.ravel(), minlength=n_dofs)
        return load

    def torsional_rigidity(self, function: Floats) -> float:
        """Torque per rate of twist of a warping or a Prandtl function (Moherdaui 2021, 2.103 and 2.106).

        Parameters
        ----------
        function
            Unknowns, shape (n_dofs,); Prandtl's is zero on the outer and constant on each hole's boundary.

        """
        if self.formulation == "prandtl":
            holes = sum(
                2.0 * area * function[pairs[0, 0]]
                for area, pairs in zip(self.boundary.hole_areas, self.boundary.holes, strict=True)
            )
            return float(self._prandtl_load() @ function + holes)
        total = 0.0
        for batch in self.space.batches():
            reconstruction, stress = self.cell_shear_stresses(batch, function)
            position = self._positions(reconstruction.frame)
            mass = monomials.mass(max(self.space.order - 1, 1), reconstruction.moments)[:3, : stress.shape[1]]
            torque = np.einsum("ae,abe,be->", position[0], mass, stress[1])
            total += float(torque - np.einsum("ae,abe,be->", position[1], mass, stress[0]))
        return total

    def _positions(self, frame: Frame) -> Floats:
        """Coordinates about `centre` as polynomials of degree 1 in cells' frames, (2, 3, n_cells)."""
        return np.concatenate(((frame.origin - self.centre[:, None])[:, None], frame.inverse), axis=1)

    def cell_shear_stresses(self, batch: CellBatch, function: Floats) -> tuple[Reconstruction, Floats]:
        """Shear stresses inside cells for ``theta' = 1``, from the projection that is orthogonal in energy.

        Warping: ``G (psi,x - y)``, ``G (psi,y + x)``, of degree max(k - 1, 1).
        Prandtl: ``phi,y``, ``-phi,x``, of degree k - 1.

        Parameters
        ----------
        batch
            The cells.
        function
            Unknowns, shape (n_dofs,).

        Returns
        -------
        tuple
            The reconstruction, whose frame the polynomials are written in, and the coefficients of ``tau_zx`` and
            ``tau_zy``, shape (2, n_monomials(degree), n_cells).

        """
        reconstruction = batch.reconstruct()
        gradient = np.einsum("aime,me->iae", reconstruction.value_gradient, function[batch.dofs])
        if self.formulation == "prandtl":
            return reconstruction, np.stack((gradient[1], -gradient[0]))
        degree = max(self.space.order - 1, 1)
        stress = np.zeros((2, n_monomials(degree), gradient.shape[-1]))
        stress[:, : gradient.shape[1]] = gradient
        position = self._positions(reconstruction.frame)
        stress[0, :3] -= position[1]
        stress[1, :3] += position[0]
        return reconstruction, stress * self.cell_moduli[batch.cells]
