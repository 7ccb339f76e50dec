"""Plane and axisymmetric elasticity: from a space, materials, loads and supports to stiffness and load, and fields."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np
import scipy.sparse as sp

from flangeway.checks import check_kind, check_positive
from flangeway.elements import Reconstruction, batched, monomials
from flangeway.elements.monomials import exponents, index, n_monomials
from flangeway.elements.quadrature import edge_points, edge_rule, edge_unknowns, gauss_lobatto
from flangeway.errors import InputError
from flangeway.geometry.arrays import (
    ROUGH_ANGLE,
    chords_of,
    diagonal,
    facet_depths,
    frozen,
    norms,
    point_text,
    steps_around,
)
from flangeway.materials import Material
from flangeway.mesh.connectivity import chain_starts, ordered_pairs
from flangeway.mesh.mesh_checks import items_by_cells, set_numbers
from flangeway.problems.loads import (
    AppliedLoad,
    PrescribedDisplacement,
    RigidHandle,
    Spring,
    Support,
    TemperatureChange,
    axes,
    boundary_quadrature,
    entries_between,
)
from flangeway.results import Result, ResultTable, Shown
from flangeway.space import CellBatch, CondensedMatrix, Mesh, Space, SymmetricMatrix, assemble_condensed
from flangeway.types import Bools, Floats, Ints

# --- Strains of cells as polynomials of degree k - 1: in the plane, and about an axis with the radius as weight.


STRAIN_PLACES = np.array([[0, 2, 3], [2, 1, -1]])
"""Place among xx, yy, 2 xy, zz of the strain that is a component's (row) derivative by x, by y, or its hoop strain."""
SPATIAL_STRAIN_PLACES = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
"""Place among xx, yy, zz, 2 xy, 2 yz, 2 xz of the strain that is a component's (row) derivative by x, y, z."""
STRAINS = np.array([strain == STRAIN_PLACES for strain in range(4)], dtype=np.float64)
"""Each strain in the plane by component and derivative, shape (4, 2, 3)."""
SPATIAL_STRAINS = np.array([strain == SPATIAL_STRAIN_PLACES for strain in range(6)], dtype=np.float64)
"""The same in space, shape (6, 3, 3)."""


@dataclass(frozen=True, eq=False)
class StrainOperators:
    """Derivatives of one component by x and y, and in a body of revolution its hoop strain, on a batch of cells.

    The strains of a discrete displacement are their projections onto polynomials of degree k - 1, orthogonal in L2,
    with the radius as weight in a body of revolution (Moherdaui 2021, 3.84 to 3.88).

    Parameters
    ----------
    moments
        Weighted integrals times the monomials of degree k - 1, shape (n_monomials(k - 1), 2 or 3, n_local, n_cells).
    mass
        Weighted integrals of the products of these monomials, shape (n, n, n_cells).
    exact_coefficients
        The polynomials where they are known without solving, shape as `moments`.

    """

    moments: Floats
    mass: Floats
    exact_coefficients: Floats | None = None

    @cached_property
    def coefficients(self) -> Floats:
        """Coefficients of the polynomials, shape as `moments`."""
        if self.exact_coefficients is not None:
            return self.exact_coefficients
        flat = self.moments.reshape(len(self.moments), -1, self.moments.shape[-1])
        return batched.solve(self.mass, flat).reshape(self.moments.shape)

    def products(self, first: int, second: int) -> Floats:
        """Weighted integrals of products of two of the derivatives, shape (n_local, n_local, n_cells)."""
        left, right = self.moments[:, first], self.coefficients[:, second]
        if first == second:
            return batched.symmetric_product(left, right)
        return np.einsum("ame,ane->mne", left, right)


def add_consistency(blocks: Floats, tensor: Floats, strains: StrainOperators) -> None:
    """Add the integrals of ``sum_ab T_iajb d_a v d_b u`` for all local functions v and u.

    - `blocks`: to which they are added, by components i and j, (m, m, n_local, n_local, n_cells).
    - `tensor`: T, symmetric, for the derivatives a and b of `strains`, (m, n_slots, m, n_slots, n_cells or 1).
    """
    n_slots = tensor.shape[1]
    for a in range(n_slots):
        for b in range(a, n_slots):
            used = np.argwhere(tensor[:, a, :, b].any(axis=-1)).tolist()
            product = strains.products(a, b) if used else np.empty(0)
            for i, j in used:
                block = tensor[i, a, j, b] * product
                blocks[i, j] += block
                if a != b:
                    blocks[j, i] += block.swapaxes(0, 1)


def strain_operators(batch: CellBatch, reconstruction: Reconstruction, *, axisymmetric: bool) -> StrainOperators:
    """Strains of a batch of cells; x is the radius if ``axisymmetric``."""
    if axisymmetric:
        return _about_axis(batch, reconstruction)
    gradient, mass = reconstruction.gradient, reconstruction.mass
    moments = reconstruction.gradient_moments
    if moments is None:
        moments = np.einsum("abe,bsme->asme", mass, gradient)
    return StrainOperators(moments, mass, gradient)


def _about_axis(batch: CellBatch, reconstruction: Reconstruction) -> StrainOperators:
    """Operators with the radius r = x as weight.

    ``int r p u,j = int_boundary r p u n_j - int u (r p),j`` holds the moments of u up to degree k - 1 only, which the
    enhanced space gives for every order, and so does the hoop strain's ``int r p (u / r) = int p u``.
    """
    order = reconstruction.order
    n_low, n_below = n_monomials(order - 1), n_monomials(order - 2)
    radius = _radius(reconstruction)
    all_moments, value = reconstruction.moments, reconstruction.projected_value
    value_moments = np.einsum("abe,bme->ame", monomials.mass(order, all_moments)[:n_low, : len(value)], value)
    moments = np.empty((n_low, 3, *value_moments.shape[1:]))
    moments[:, :2] = _boundary_moments(batch, reconstruction)
    moments[:, 0] -= value_moments
    moments[:, 2] = value_moments
    if n_below:
        weighted = _times_radius(value_moments, order - 2, radius)
        in_space = np.einsum("jie,jba->abie", reconstruction.frame.map, monomials.derivatives(order - 1))
        moments[:, :2] -= np.einsum("abie,bme->aime", in_space, weighted)
    products = exponents(order - 1)[:, None] + exponents(order - 1)
    weighted_moments = _times_radius(all_moments, 2 * (order - 1), radius)
    return StrainOperators(moments, weighted_moments[index(products)])


def _radius(reconstruction: Reconstruction) -> Floats:
    """Coefficients of x as a polynomial of degree 1 in the local coordinates, shape (3, n_cells)."""
    return np.concatenate((reconstruction.frame.origin[:1], reconstruction.frame.inverse[0]))


def _times_radius(moments: Floats, degree: int, radius: Floats) -> Floats:
    """Moments with monomials up to a degree times the radius, from moments up to one degree more, first axis."""
    powers = exponents(degree)
    result = np.zeros((len(powers), *moments.shape[1:]))
    for step, factor in zip(((0, 0), (1, 0), (0, 1)), radius, strict=True):
        result += factor * moments[index(powers + np.array(step))]
    return result


def _boundary_moments(batch: CellBatch, reconstruction: Reconstruction) -> Floats:
    """Integrals of r times monomials of degree k - 1 times traces times the normal, (n, 2, n_local, n_cells)."""
    order, degree = batch.element.order, reconstruction.order - 1
    vertices, outline = batch.vertices, batch.outline
    n_vertices, _, n_cells = vertices.shape
    # degree k of r, k - 1 of the normal, k of the trace, and k - 1 times k of the monomials
    n_points = (order * (order + 2) + 1) // 2
    if outline.ndim == 3:
        n_points, along = (order + degree) // 2 + 2, steps_around(vertices)
        outline = vertices[:, None] + gauss_lobatto(order + 1)[0][:-1, None, None] * along[:, None]
    weights, shapes, slopes = edge_rule(order, n_points)
    result = np.zeros((n_monomials(degree), 2, reconstruction.n_local, n_cells))
    for edge, local in enumerate(edge_unknowns(order, n_vertices)):
        nodes = edge_points(outline)[edge] - vertices[edge]
        points, tangents = (np.einsum("qj,jie->qie", table, nodes) for table in (shapes, slopes))
        points += vertices[edge]
        values = monomials.evaluate(degree, reconstruction.frame.local(points))
        right = batched.turned_right(tangents) * weights[:, None, None]
        result[:, :, local] += np.einsum("aqe,qe,qie,qn->aine", values, points[:, 0], right, shapes, optimize=True)
    return result


# --- Plane and axisymmetric elasticity: from a space, materials, loads and supports to stiffness and forces.


Kind = TypeVar("Kind")

ON_AXIS = 1e-12
"""Radius relative to the size of the mesh below which a node lies on the axis."""
SAME_PLACE = 1e-6
"""Distance relative to the size of the mesh within which a given point is a node."""


LOCKING_BULK = 20.0
"""Bulk over shear modulus in the plane from which linear triangles lock, nu = 0.475 in plane strain: there a clamped
block of ten layers is 9 % too stiff, and twice as much at 0.487."""


MAX_FACET_AREA = 1e-4
"""Area between chords and their curves relative to the section, from which a sentence names it."""


def _of_kind(items: Sequence[AppliedLoad | Support], kind: type[Kind]) -> tuple[Kind, ...]:
    return tuple(item for item in items if isinstance(item, kind))


@dataclass(frozen=True, eq=False)
class Elasticity(Shown, Generic[Mesh]):
    """A linear elastic body; unknowns: displacements numbered ``d * dof + component`` (Moherdaui 2021, 3.2.6, 3.3.7).

    On a mesh of polyhedra it is a body in space, d = 3, whose loads and supports are on named faces.

    Parameters
    ----------
    space
        Space of one displacement component.
    material
        Material of all cells, or of each named cell set, which must then cover the mesh once. All share one hypothesis:
        plane strain, plane stress, or axisymmetric, with x the radius, y the axis, forces summed around the axis, and
        nodes on the axis kept there.
    thickness
        Length out of the plane; forces are then forces, not forces per length. Leave 1 for axisymmetric bodies.
    loads
        Loads, see `flangeway.problems.loads`.
    supports
        Prescribed displacements, springs and rigid handles, see `flangeway.problems.loads`.
    name
        Name for messages.

    Raises
    ------
    InputError
        If a name of edges or cells is unknown, the sets do not cover the mesh once, or a value is wrong.

    """

    space: Space[Mesh]
    material: Material | Mapping[str, Material]
    thickness: float = 1.0
    loads: Sequence[AppliedLoad] = ()
    supports: Sequence[Support] = ()
    name: str = "body"

    def __post_init__(self) -> None:
        self._check_types()
        object.__setattr__(self, "loads", tuple(self.loads))
        object.__setattr__(self, "supports", tuple(self.supports))
        check_positive("Elasticity", "thickness", self.thickness, "a positive length", "take 1 for forces per length")
        _ = self.cell_material
        hypotheses = sorted({material.hypothesis for material in self.materials})
        if len(hypotheses) > 1:
            raise InputError(
                f"materials of body `{self.name}` with {' and '.join(hypotheses)}",
                "one hypothesis",
                "choose one of them",
            )
        if self.axisymmetric:
            self._check_axis()
        if self.dimension == 3:
            self._check_spatial()
        self._check_items()

    def _check_types(self) -> None:
        check_kind("Elasticity", "space", self.space, Space, "a Space", "write Space(mesh, element)")
        allowed, advice = "a Material, or one for each cell set", "make an Elastic or an Orthotropic"
        for material in self.materials:
            check_kind("Elasticity", "material", material, Material, allowed, advice)

    def _check_axis(self) -> None:
        if self.thickness != 1.0:
            raise InputError(
                f"Elasticity(thickness={self.thickness}) of an axisymmetric body",
                "1",
                "forces are summed around the axis",
            )
        least = float(self.space.mesh.points[:, 0].min())
        if least < -ON_AXIS * self.size:
            raise InputError(
                f"an axisymmetric body with a point at x = {least:g}", "radii x >= 0", "move the mesh, or mirror it"
            )

    def _check_spatial(self) -> None:
        """Refuse what only bodies in the plane have."""
        has = {
            f"the hypothesis {self.materials[0].hypothesis}": self.materials[0].hypothesis != "plane_strain",
            "a thickness": self.thickness != 1.0,
            "a rigid handle": bool(self.handles),
            "a support with an angle": any(getattr(support, "angle", 0.0) for support in self.supports),
        }
        for what, given in has.items():
            if given:
                raise InputError(f"body `{self.name}` in space with {what}", "bodies in the plane", "leave it out")

    def _check_items(self) -> None:
        for load in self.loads:
            check_kind(
                "Elasticity", "a load", load, AppliedLoad, "items of flangeway.problems.loads", "make a Traction, ..."
            )
            load.check(self)
        for support in self.supports:
            kinds = "PrescribedDisplacement, Spring or RigidHandle"
            check_kind("Elasticity", "a support", support, Support, kinds, "make one of them")
            self.support_nodes(support)

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials."""
        return items_by_cells(self.material)

    @cached_property
    def cell_material(self) -> Ints:
        """Number of each cell's material, shape (n_cells,)."""
        if isinstance(self.material, Mapping):
            return frozen(set_numbers(self.space.mesh, self.material, "material"))
        return frozen(np.zeros(self.space.mesh.n_cells, dtype=np.int64))

    @property
    def locking(self) -> str | None:
        """Sentence about nearly incompressible cells that lock, see `Element.locks`; None where few of them do.

        Triangles constrain a volume for every half node; polygons have two nodes each or more.
        """
        ratios = np.array([material.bulk_ratio for material in self.materials])
        nearly = ratios[self.cell_material] > LOCKING_BULK
        if not nearly.any() or self.space.locks[nearly].mean() < 0.5:
            return None
        return (
            f"{self.name} locks: its volume is nearly constant (bulk over shear modulus {ratios.max():.3g}), and "
            "elements of order 1 make the forces too large; take order 2, or virtual elements on polygons"
        )

    @property
    def facets(self) -> str | None:
        """Sentence about straight edges that stand for a smooth curve; None where they change the section by little."""
        mesh = self.space.plane_mesh
        pairs = ordered_pairs(mesh.boundary_edges, "boundary")
        straight = (mesh.curve_rows[mesh.edge_numbers(pairs)] < 0) | (self.space.order == 1)
        ends, loops = mesh.points[pairs], chain_starts(pairs)[1:]
        depths = np.concatenate([facet_depths(loop, ROUGH_ANGLE) for loop in np.split(ends, loops)])
        # a chord and its arc have 2/3 of the product of their distance and length between them
        fraction = np.sum(straight * depths * norms(chords_of(ends))) / 1.5 / mesh.cell_areas.sum()
        if fraction < MAX_FACET_AREA:
            return None
        return (
            f"{self.name} has straight edges that look like chords of a curve, and {fraction:.1e} of its section lies "
            "between them and the curve; take order 2 or more and curved(mesh, outline), or more edges there"
        )

    @property
    def dimension(self) -> int:
        """Number of coordinates and of components of displacements, 2 or 3."""
        return self.space.dimension

    @property
    def strains_by_derivative(self) -> Floats:
        """Each strain by component and derivative, see `STRAINS`."""
        return STRAINS if self.dimension == 2 else SPATIAL_STRAINS

    @property
    def axisymmetric(self) -> bool:
        """Whether the body is one of revolution, x its radius."""
        return self.materials[0].hypothesis == "axisymmetric"

    @cached_property
    def size(self) -> float:
        """Diagonal of the mesh's bounding box."""
        return diagonal(self.space.mesh.points)

    @property
    def motion_scale(self) -> Floats:
        """Units (3,) of motions along x and y and of a rotation by the size of the body, in space of x, y and z."""
        return np.array([1.0, 1.0, self.size if self.dimension == 2 else 1.0])

    @cached_property
    def on_axis(self) -> Ints:
        """Nodes on the axis of a body of revolution."""
        return np.flatnonzero(self.space.nodes[:, 0] <= ON_AXIS * self.size)

    def depth(self, points: Floats) -> Floats | float:
        """Length out of the plane at points (..., 2), shape (...): the thickness, or the circumference."""
        if self.axisymmetric:
            return 2.0 * np.pi * points[..., 0]
        return self.thickness

    @property
    def _depth_factor(self) -> float:
        return 2.0 * np.pi if self.axisymmetric else self.thickness

    def cells_in(self, name: str | None) -> Bools:
        """Which cells belong to a set, shape (n_cells,); None is all."""
        if name is None:
            return np.ones(self.space.mesh.n_cells, dtype=bool)
        inside = np.zeros(self.space.mesh.n_cells, dtype=bool)
        inside[self.space.mesh.cell_set(name)] = True
        return inside

    def node_at(self, point: Sequence[float]) -> int:
        """Node at a given place; an InputError where there is none."""
        apart = norms(self.space.nodes - np.asarray(point))
        node = int(apart.argmin())
        if apart[node] > SAME_PLACE * self.size:
            raise InputError(
                f"the point {point_text(np.asarray(point))}",
                f"a node of the mesh; the nearest is {point_text(self.space.nodes[node])}",
                "give the place of a node, or make the mesh with a point there",
            )
        return node

    def support_nodes(self, support: Support) -> Ints:
        """Nodes of a support, each once, in rising order."""
        return self.nodes_at(support.edges if isinstance(support, RigidHandle) else support.where)

    def nodes_at(self, where: str | Sequence[float]) -> Ints:
        """Nodes of an edge set, each once, in rising order, or the node at a given place."""
        if isinstance(where, str):
            return self.space.nodes_along(where)
        return np.array([self.node_at(where)])

    # stiffness

    def stiffness(self) -> SymmetricMatrix:
        """Stiffness matrix of the whole body on all its unknowns, no unknown held, without springs."""
        return self.space.assemble(self.cell_stiffness, n_components=self.dimension)

    def condensed_stiffness(self) -> CondensedMatrix:
        """Stiffness with the unknowns inside cells eliminated, no unknown held, without springs."""
        return assemble_condensed(self.space, self.cell_stiffness, n_components=self.dimension)

    def spring_stiffness(self, spring: Spring) -> sp.csc_array:
        """Stiffness of a spring on the displacements at nodes, shape (d n_nodes, d n_nodes)."""
        d, frame = self.dimension, axes(spring.angle, self.dimension)
        tensor = frame.T @ np.diag([spring.x, spring.y, spring.z][:d]) @ frame
        parts = [(self.nodes_at(spring.where)[None], np.ones((1, 1, 1)))]
        if isinstance(spring.where, str):
            rules = boundary_quadrature(self.space, spring.where)
            parts = [(rule.nodes.astype(np.int64), rule.products(self.depth(rule.points))) for rule in rules]
        shape = (d * self.space.n_nodes,) * 2
        total = sp.csc_array(shape)
        for nodes, mass in parts:
            unknowns = (d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), -1)
            blocks = np.einsum("emn,ij->eminj", mass, tensor).reshape(*unknowns.shape, -1)
            rows, columns, entries = entries_between(unknowns, blocks)
            total += sp.csc_array((entries, (rows, columns)), shape=shape)
        return total

    def strains(self, batch: CellBatch, reconstruction: Reconstruction) -> StrainOperators:
        """Strains of cells as polynomials."""
        return strain_operators(batch, reconstruction, axisymmetric=self.axisymmetric)

    @cached_property
    def _matrices(self) -> Floats:
        """Matrix of each material, shape (4, 4, n_materials), in space (6, 6, n_materials)."""
        plane = self.dimension == 2
        return np.stack([material.matrix if plane else material.full_matrix for material in self.materials], axis=-1)

    def matrices(self, batch: CellBatch) -> Floats:
        """Stresses xx, yy, xy, zz per strain xx, yy, 2 xy, zz of cells, (4, 4, n_cells), or (4, 4, 1) if all alike.

        In space xx, yy, zz, xy, yz, xz, with sixes in place of the fours.
        """
        return self.of_cells(self._matrices, batch)

    def stabilisation_factors(self, batch: CellBatch) -> Floats:
        """Factors of the stabilisation of cells, (n_cells,), or (1,) if all alike."""
        return self.of_cells(np.array([material.stabilisation_factor for material in self.materials]), batch)

    def of_cells(self, values: Floats, batch: CellBatch) -> Floats:
        """Values of cells from those of the materials, which are on the last axis; kept if there is one material."""
        return values if len(self.materials) == 1 else values[..., self.cell_material[batch.cells]]

    def cell_stiffness(self, batch: CellBatch) -> Floats:
        """Stiffness of cells: consistency (Moherdaui 2021, 3.93) and stabilisation, (d n_local, d n_local, n_cells)."""
        reconstruction = batch.reconstruct()
        strains = self.strains(batch, reconstruction.for_energy)
        n, d = reconstruction.n_local, self.dimension
        table = self.strains_by_derivative[..., : strains.moments.shape[1]]
        result = np.zeros((n, d, n, d, len(batch.cells)))
        by_component = result.transpose(1, 3, 0, 2, 4)
        # T_iajb = sum over strains s, t of B_sia D_st B_tjb
        add_consistency(by_component, np.einsum("sia,ste,tjb->iajbe", table, self.matrices(batch), table), strains)
        stabilisation = batch.element.stabilise(reconstruction, by_component)
        if stabilisation is not None:
            stabilisation *= self.stabilisation_factors(batch)
            for component in range(d):
                by_component[component, component] += stabilisation
        result *= self._depth_factor
        return result.reshape(d * n, d * n, -1)

    # loads

    def load_vector(self) -> Floats:
        """Forces of all loads but changes of temperature on all unknowns, shape (n_dofs, d)."""
        return self._forces([load for load in self.loads if not isinstance(load, TemperatureChange)])

    def thermal_load_vector(self) -> Floats:
        """Forces of the stresses that would undo the thermal strains on all unknowns, shape (n_dofs, d)."""
        return self._forces(self.thermal_loads)

    def _forces(self, loads: Sequence[AppliedLoad]) -> Floats:
        return sum((load.forces(self) for load in loads), np.zeros((self.space.n_dofs, self.dimension)))

    def thermal_energy(self) -> float:
        """Strain energy of the held body's thermal stresses."""
        energy = 0.0
        for batch in self.space.batches() if self.thermal_loads else ():
            reconstruction = batch.reconstruction
            mass = self.strains(batch, reconstruction).mass
            moments = self.cell_temperature(batch, reconstruction, self.thermal_loads)
            squares = np.einsum("ae,ae->e", moments, batched.solve(mass, moments[:, None])[:, 0])
            energy += 0.5 * self._depth_factor * float(np.sum(self.of_cells(self._thermal_energies, batch) * squares))
        return energy

    @property
    def thermal_loads(self) -> tuple[TemperatureChange, ...]:
        """The changes of temperature among the loads."""
        return _of_kind(self.loads, TemperatureChange)

    def cell_temperature(
        self, batch: CellBatch, reconstruction: Reconstruction, loads: Sequence[TemperatureChange]
    ) -> Floats:
        """Weighted integrals of the rise of temperature times monomials of degree k - 1, (n_monomials, n_cells)."""
        order = reconstruction.order
        points, weights = batch.quadrature(2 * order + 1)
        rows = points.swapaxes(1, 2)
        change = np.zeros(weights.shape)
        for load in loads:
            inside = self.cells_in(load.cells)[batch.cells]
            change[:, inside] += load.at(rows[:, inside].reshape(-1, self.dimension)).reshape(len(rows), -1)
        weighted = change * weights * (points[:, 0] if self.axisymmetric else 1.0)
        return np.einsum("aqe,qe->ae", reconstruction.at(points)[: n_monomials(order - 1)], weighted)

    def thermal_forces(
        self, batch: CellBatch, reconstruction: Reconstruction, loads: Sequence[TemperatureChange]
    ) -> Floats:
        """Forces of the stresses that would undo the thermal strains, shape (d, n_local, n_cells)."""
        coefficients = self.strains(batch, reconstruction).coefficients
        stress = self._depth_factor * self._thermal_stress(batch)
        moments = self.cell_temperature(batch, reconstruction, loads)
        table = self.strains_by_derivative[..., : coefficients.shape[1]]
        return np.einsum("sia,pame,spe->ime", table, coefficients, stress[:, None] * moments, optimize=True)

    @cached_property
    def _heated(self) -> tuple[Material | None, ...]:
        """Each material that a change of temperature acts on, None for the others."""
        heated = np.zeros(len(self.materials), dtype=bool)
        for load in self.thermal_loads:
            heated[self.cell_material[self.cells_in(load.cells)]] = True
        return tuple(material if hot else None for material, hot in zip(self.materials, heated, strict=True))

    @cached_property
    def _thermal_energies(self) -> Floats:
        """Thermal strain times thermal stress of each material, shape (n_materials,)."""
        return np.array([strain @ stress for strain, stress in map(self._thermal, self._heated)])

    def _thermal(self, material: Material | None) -> tuple[Floats, Floats]:
        """Free strains of a material per rise of temperature, and stresses that would undo them; None has none."""
        if material is None:
            none = np.zeros(len(self._matrices))
            return none, none
        if self.dimension == 2:
            return material.thermal_strain, material.thermal_stress
        return material.full_thermal_strain, material.full_matrix @ material.full_thermal_strain

    def _thermal_stress(self, batch: CellBatch) -> Floats:
        """Stress of cells per rise of temperature, shape (4 or 6, n_cells or 1); zero for unheated materials."""
        return self.of_cells(np.stack([self._thermal(material)[1] for material in self._heated], axis=-1), batch)

    # stresses

    def cell_stresses(self, batch: CellBatch, displacement: Floats) -> tuple[Reconstruction, Floats]:
        """Stresses inside cells as polynomials of degree k - 1, from the reconstruction.

        Parameters
        ----------
        batch
            The cells.
        displacement
            All unknowns, shape (d n_dofs,) or (n_dofs, d).

        Returns
        -------
        tuple
            The reconstruction, whose frame the polynomials are written in, and the coefficients of the components
            xx, yy, xy, zz (zz: out of the plane, or the hoop stress), in space xx, yy, zz, xy, yz, xz; shape
            (4 or 6, n_monomials(k - 1), n_cells).

        """
        reconstruction = batch.reconstruct()
        strains = self.strains(batch, reconstruction)
        local = displacement.reshape(-1, self.dimension)[batch.dofs]
        derivatives = np.einsum("pame,mei->iape", strains.coefficients, local)
        strain = np.einsum("sia,iape->spe", self.strains_by_derivative[..., : derivatives.shape[1]], derivatives)
        stress = np.einsum("ste,tae->sae", self.matrices(batch), strain)
        if self.thermal_loads:
            moments = self.cell_temperature(batch, reconstruction, self.thermal_loads)
            temperature = batched.solve(strains.mass, moments[:, None])[:, 0]
            stress -= self._thermal_stress(batch)[:, None] * temperature
        return reconstruction, stress

    @property
    def springs(self) -> tuple[Spring, ...]:
        """The springs among the supports."""
        return _of_kind(self.supports, Spring)

    @property
    def handles(self) -> tuple[RigidHandle, ...]:
        """The rigid handles among the supports."""
        return _of_kind(self.supports, RigidHandle)

    @property
    def prescribed(self) -> tuple[PrescribedDisplacement, ...]:
        """The prescribed displacements among the supports."""
        return _of_kind(self.supports, PrescribedDisplacement)


# --- Displacements of an elastic body, however they were found.


@dataclass(frozen=True, eq=False)
class ElasticField(Result, Generic[Mesh]):
    """Displacements of an elastic body: what stresses and pictures need.

    Parameters
    ----------
    problem
        The elastic problem.
    displacements
        All unknowns, shape (n_dofs, d); the first ``space.n_nodes`` are those at ``space.nodes``.

    """

    problem: Elasticity[Mesh]
    displacements: Floats

    @property
    def space(self) -> Space[Mesh]:
        """Space of the displacements."""
        return self.problem.space

    @property
    def table(self) -> ResultTable:
        """Places and displacements of the nodes."""
        nodes = self.space.nodes
        places, displacements = nodes.T, self.displacements[: len(nodes)].T
        names = "xyz"[: len(places)]
        columns = dict(zip(names, places, strict=True))
        return ResultTable(columns | {f"displacement_{x}": u for x, u in zip(names, displacements, strict=True)})
