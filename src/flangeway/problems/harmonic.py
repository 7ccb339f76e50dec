"""Prisms and bodies of revolution under loads that vary as a cosine: one plane problem for each wavenumber.

In a prism along z the displacements are ``u_x = U cos kz, u_y = V cos kz, u_z = W sin kz`` with amplitudes U, V, W on
the plane mesh; in a body of revolution, x the radius and y the axis, ``u_x = U cos nt, u_y = V cos nt, u_t = W sin nt``
over the angle t (the harmonic, or semi-analytical, element: Wilson, 1965, AIAA J. 3; Zienkiewicz and Taylor, 2005, "The
Finite Element Method for Solid and Structural Mechanics", chapter 17). With the strains ``B = B0 + k B1`` of the
amplitudes the stiffness is ``K(k) = K0 + k K1 + k^2 K2``. The other parity (sin, sin, cos) is the wavenumber -k.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.checks import check_positive
from flangeway.elements import Reconstruction, batched, missed_mass, monomials
from flangeway.elements.monomials import n_monomials
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import Point
from flangeway.problems.elasticity_problem import Elasticity, StrainOperators, add_consistency, strain_operators
from flangeway.problems.loads import EdgeQuadrature, Scalar, check_scalar, edge_quadrature, entries_between, scalar_at
from flangeway.space import CellBatch, SymmetricMatrix
from flangeway.types import Bools, Floats, Ints

NAMES = ("xx", "yy", "zz", "xy", "yz", "xz")
"""Components of stress and strain; in a body of revolution z is the direction around the axis."""


def _strain_tables(*, revolution: bool) -> tuple[Floats, Floats]:
    """B0 and B1: each strain of `NAMES` by each amplitude and slot (d/dx, d/dy, value or value over r): (6, 3, 3)."""
    constant, linear = np.zeros((6, 3, 3)), np.zeros((6, 3, 3))
    for strain, amplitude, slot in ((0, 0, 0), (1, 1, 1), (3, 0, 1), (3, 1, 0), (4, 2, 1), (5, 2, 0)):
        constant[strain, amplitude, slot] = 1.0
    linear[2, 2, 2] = 1.0
    linear[4, 1, 2] = linear[5, 0, 2] = -1.0
    if revolution:
        constant[2, 0, 2] = 1.0
        constant[5, 2, 2] = -1.0
    return constant, linear


def at_wavenumber(parts: Sequence[SymmetricMatrix], wavenumber: float) -> SymmetricMatrix:
    """Stiffness ``K0 + k K1 + k^2 K2`` of three parts of one pattern."""
    constant, linear, square = (part.values for part in parts)
    return replace(parts[0], values=constant + wavenumber * (linear + wavenumber * square))


@dataclass(frozen=True)
class LongitudinalTraction:
    """Force per area on named edges along z, in a body of revolution around the axis.

    Parameters
    ----------
    edges
        Name of an edge set.
    value
        Amplitude of ``sin kz``: a number, or a function of points (n, 2) with values (n,).

    """

    edges: str
    value: Scalar

    def __post_init__(self) -> None:
        check_scalar(f"LongitudinalTraction on {short(self.edges)}", self.value)


@dataclass(frozen=True)
class Foundation:
    """Continuous elastic support of named edges, fixed at its other end.

    Parameters
    ----------
    edges
        Name of an edge set.
    x, y, z
        Pressure per displacement along each axis, >= 0.
    roll
        Moment about z per angle and length of a prism, > 0. The edges, along x, are then supported as one: by even
        pressures against their mean displacement, and linear ones along y against their mean rotation, see
        `mean_and_rotation`. Left out, each point is supported by itself.

    """

    edges: str
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    roll: float | None = None

    def __post_init__(self) -> None:
        if self.roll is not None:
            check_positive("Foundation", "roll", self.roll, advice="leave it out for separate points")
        values = np.array([self.x, self.y, self.z], dtype=np.float64)
        if not (np.isfinite(values).all() and values.min() >= 0.0 and values.max() > 0.0):
            raise InputError(
                f"Foundation({short(self.edges)}) with x={self.x}, y={self.y}, z={self.z}",
                "finite stiffnesses >= 0, and one of them positive",
                "give pressure per displacement along each axis",
            )


def mean_and_rotation(rule: EdgeQuadrature) -> tuple[Ints, Floats, float]:
    """Nodes of edges along x, and what takes their mean value and their slope over x from values at nodes.

    The same numbers are the nodal forces of a unit force, spread evenly, and of a unit moment about the middle, by
    forces across that grow linearly.

    Returns
    -------
    tuple
        Nodes (n,), mean and slope (2, n), and the edges' length.

    """
    length, x = float(rule.weights.sum()), rule.points[..., 0]
    arms = x - float((rule.weights * x).sum()) / length
    weights = np.stack((rule.weights / length, rule.weights * arms / (rule.weights * arms**2).sum()))
    nodes, numbers = np.unique(rule.nodes, return_inverse=True)
    on_nodes = [np.bincount(numbers.ravel(), (weight @ rule.shapes).ravel()) for weight in weights]
    shares = np.array(on_nodes, dtype=np.float64)
    return nodes.astype(np.int64), shares, length


@dataclass(frozen=True, eq=False)
class Harmonic:
    """A prism, or a body of revolution, under loads that vary as a cosine along it.

    Forces are per length of a prism and per radian of a body of revolution, as amplitudes. Chords of curves change them
    at every wavenumber by about the area beside the chords: the status of a solution names it from 1e-4 of the section.

    Parameters
    ----------
    elasticity
        Space, material, and loads whose amplitudes lie in the plane. An axisymmetric material makes a body of
        revolution, plane strain a prism. Supports are given here, not there.
    longitudinal
        Loads along z.
    foundations
        Elastic supports.
    held
        Components ``"x"``, ``"y"``, ``"z"``, or several of them, that do not move on edge sets and at points.

    Raises
    ------
    InputError
        If the material is one of plane stress, the problem has supports, thermal loads or a thickness, or a name is
        unknown.

    """

    elasticity: Elasticity
    longitudinal: Sequence[LongitudinalTraction] = ()
    foundations: Sequence[Foundation] = ()
    held: Mapping[str | Point, str] | None = None

    def __post_init__(self) -> None:
        problem = self.elasticity
        if problem.materials[0].hypothesis == "plane_stress":
            raise InputError("Harmonic in plane stress", "plane strain (a prism) or axisymmetric", "change hypothesis")
        if problem.supports or problem.thermal_loads or problem.thickness != 1.0:
            raise InputError(
                "Harmonic of an elasticity problem with supports, a change of temperature, or a thickness",
                "space, material and loads",
                "give supports as held=... and foundations=..., forces per length",
            )
        for name in [load.edges for load in self.longitudinal] + [foundation.edges for foundation in self.foundations]:
            problem.space.mesh.edge_set(name)
        if problem.axisymmetric and any(foundation.roll is not None for foundation in self.foundations):
            raise InputError("a foundation with roll in a body of revolution", "one of a prism", "leave roll out")
        for where, components in (self.held or {}).items():
            if not components or set(components) - set("xyz"):
                raise InputError(f"held {where!r} in {components!r}", "some of 'xyz'", "name the components")

    @property
    def revolution(self) -> bool:
        """Whether the body is one of revolution."""
        return self.elasticity.axisymmetric

    @cached_property
    def _tables(self) -> tuple[Floats, Floats]:
        return _strain_tables(revolution=self.revolution)

    @cached_property
    def _matrices(self) -> Floats:
        return np.stack([material.full_matrix for material in self.elasticity.materials], axis=-1)

    def matrices(self, batch: CellBatch) -> Floats:
        """Stresses per strain of cells, both as in `NAMES`, shape (6, 6, n_cells), or (6, 6, 1) if all are alike."""
        return self.elasticity.of_cells(self._matrices, batch)

    def depth(self, points: Floats) -> Floats | float:
        """Radius at points (..., 2) of a body of revolution, 1 in a prism: what a plane load is multiplied with."""
        radii: Floats = points[..., 0]
        return radii if self.revolution else 1.0

    # stiffness

    @cached_property
    def parts(self) -> tuple[SymmetricMatrix, SymmetricMatrix, SymmetricMatrix]:
        """K0 with the foundations, K1 and K2, on ``3 * dof + amplitude``, all of one pattern."""
        constant, linear, square = self.elasticity.space.assemble_each(self._cell_parts, n_components=3)
        for foundation in self.foundations:
            rows, columns, stiffness = self._foundation(foundation)
            lower = rows >= columns
            rows, columns, stiffness = rows[lower], columns[lower], stiffness[lower]
            if foundation.roll is not None:  # all nodes of the edges act on each other
                constant, linear, square = (part.widened(rows, columns) for part in (constant, linear, square))
            values = constant.values.copy()
            np.add.at(values, constant.places(rows, columns), stiffness)
            constant = replace(constant, values=values)
        return constant, linear, square

    def stiffness(self, wavenumber: float) -> SymmetricMatrix:
        """Stiffness of all amplitudes at a wavenumber (prism, per length) or harmonic (revolution, per radian)."""
        return at_wavenumber(self.parts, wavenumber)

    def slots(self, batch: CellBatch, reconstruction: Reconstruction) -> StrainOperators:
        """Derivatives by x and y and value (over r in a body of revolution) of one amplitude, as polynomials.

        Coefficients have the shape (n, 3, n_local, n_cells); integrals have the radius as weight in a body of
        revolution. A virtual element's value is taken to the degree of its strains, k - 1, but to 1 for order 1, where
        a constant would leave motions without energy.
        """
        if self.revolution:
            return strain_operators(batch, reconstruction, axisymmetric=True)
        order = reconstruction.order
        degree = order if reconstruction.exact or order == 1 else order - 1
        mass = monomials.mass(degree, reconstruction.moments)
        value = reconstruction.projected_value
        if degree < order:
            moments = np.einsum(
                "abe,bme->ame", monomials.mass(order, reconstruction.moments)[: len(mass), : len(value)], value
            )
            value = batched.solve(mass, moments)
        result = np.zeros((len(mass), 3, *value.shape[1:]))
        result[: n_monomials(order - 1), :2] = reconstruction.gradient
        result[:, 2] = value
        return StrainOperators(np.einsum("pqe,qbne->pbne", mass, result), mass, result)

    def _cell_parts(self, batch: CellBatch) -> tuple[Floats, Floats, Floats]:
        """K0, K1 and K2 of cells, each (3 n_local, 3 n_local, n_cells)."""
        reconstruction = batch.reconstruct()
        slots, stress = self.slots(batch, reconstruction.for_energy), self.matrices(batch)
        n, n_cells = reconstruction.n_local, len(batch.cells)
        b0, b1 = self._tables
        parts = np.zeros((3, n, 3, n, 3, n_cells))
        for power, pairs in enumerate((((b0, b0),), ((b0, b1), (b1, b0)), ((b1, b1),))):
            # T_iajb = sum over strains s, t of B_sia D_st B_tjb
            table = sum(np.einsum("sia,ste,tjb->iajbe", left, stress, right) for left, right in pairs)
            add_consistency(parts[power].transpose(1, 3, 0, 2, 4), np.asarray(table), slots)
        self._add_stabilisation(parts, batch, reconstruction)
        constant, linear, square = parts.reshape(3, 3 * n, 3 * n, n_cells)
        return constant, linear, square

    def _add_stabilisation(self, parts: Floats, batch: CellBatch, reconstruction: Reconstruction) -> None:
        """Add what the projections miss: of the gradients to K0, of the values to K2."""
        constant = parts[0].transpose(1, 3, 0, 2, 4)
        in_plane = batch.element.stabilise(reconstruction, constant[:2, :2])
        along = batch.element.stabilise(reconstruction, constant[2:, 2:])
        if in_plane is None or along is None:
            return
        factors = self.elasticity.stabilisation_factors(batch)
        for i, added in enumerate((factors * in_plane, factors * in_plane, along)):
            parts[0, :, i, :, i] += added
        square = missed_mass(reconstruction)
        if self.revolution:
            square /= batch.vertices[:, 0].mean(axis=0)  # the weight r of (u / r)^2
        stress = self.matrices(batch)
        for i, modulus in enumerate((stress[5, 5], stress[4, 4], stress[2, 2])):
            parts[2, :, i, :, i] += modulus * square

    def _foundation(self, foundation: Foundation) -> tuple[Ints, Ints, Floats]:
        """Rows, columns and entries of a foundation."""
        space = self.elasticity.space
        rule = edge_quadrature(space, space.mesh.edge_set(foundation.edges))
        stiffnesses = np.array([foundation.x, foundation.y, foundation.z])
        if foundation.roll is None:
            nodes = rule.nodes.astype(np.int64)
            matrices = stiffnesses[:, None, None, None] * rule.products(self.depth(rule.points))
        else:
            numbers, (mean, slope), length = mean_and_rotation(rule)
            nodes = numbers[None]
            matrices = (length * stiffnesses)[:, None, None, None] * np.outer(mean, mean)
            matrices[1] += foundation.roll * np.outer(slope, slope)
        return entries_between(3 * nodes + np.arange(3)[:, None, None], matrices)

    # loads and supports

    def load_vector(self) -> Floats:
        """Amplitudes of the forces on all unknowns, shape (n_dofs, 3)."""
        space = self.elasticity.space
        total = np.zeros((space.n_dofs, 3))
        around = 2.0 * np.pi if self.revolution else 1.0  # plane loads are summed around the axis
        for load in self.elasticity.loads:
            total[:, :2] += load.forces(self.elasticity) / around
        for item in self.longitudinal:
            rule = edge_quadrature(space, space.mesh.edge_set(item.edges))
            values = scalar_at(f"LongitudinalTraction on {item.edges!r}", item.value, rule.points.reshape(-1, 2))
            weights = rule.weights * self.depth(rule.points) * values.reshape(rule.weights.shape)
            np.add.at(total[:, 2], rule.nodes, np.einsum("eq,qm->em", weights, rule.shapes))
        return total

    def free(self, wavenumber: float) -> Bools:
        """Which amplitudes are free to move, shape (n_dofs, 3).

        On the axis of revolution they must be unique: V alone for n = 0, U = -W for n = 1 (U is then the free one),
        none for n >= 2.
        """
        space = self.elasticity.space
        free = np.ones((space.n_dofs, 3), dtype=bool)
        for where, components in (self.held or {}).items():
            for component in components:
                free[self.elasticity.nodes_at(where), "xyz".index(component)] = False
        if self.revolution:
            on_axis = self.axis_nodes
            free[on_axis, 1] &= wavenumber == 0
            free[on_axis, 0] &= abs(wavenumber) == 1
            free[on_axis, 2] = False
        return free

    @property
    def axis_nodes(self) -> Ints:
        """Nodes on the axis of revolution."""
        return self.elasticity.on_axis

    # stresses

    def cell_stresses(self, batch: CellBatch, amplitudes: Floats, wavenumber: float) -> tuple[Reconstruction, Floats]:
        """Amplitudes of the stresses inside cells as polynomials.

        Parameters
        ----------
        batch
            The cells.
        amplitudes
            All unknowns, shape (..., n_dofs, 3).
        wavenumber
            Theirs.

        Returns
        -------
        tuple
            The reconstruction, whose frame the polynomials are written in, and the coefficients of the components of
            `NAMES` (..., 6, n_monomials, n_cells): of ``cos kz`` for xx, yy, zz and xy, of ``sin kz`` for yz and xz.

        """
        reconstruction = batch.reconstruct()
        coefficients = self.slots(batch, reconstruction).coefficients
        b0, b1 = self._tables
        # e_sp = sum over amplitudes i, slots a and unknowns m of B_sia c_pam u_mi
        local = amplitudes[..., batch.dofs, :]
        strain = np.einsum("sia,pame,...mei->...spe", b0 + wavenumber * b1, coefficients, local, optimize=True)
        return reconstruction, np.einsum("ste,...tpe->...spe", self.matrices(batch), strain)
