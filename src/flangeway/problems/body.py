"""A linear elastic body that is held along named parts of its boundary."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.checks import are_all, check_kind, check_positive
from flangeway.elements import Element
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import IntArray, Point, box_middle
from flangeway.materials import Material
from flangeway.mesh import PolyMesh
from flangeway.mesh.mesh_checks import items_by_cells
from flangeway.problems.elasticity_problem import Elasticity
from flangeway.problems.loads import Spring
from flangeway.problems.stiffness_body import LinearBody, RigidFreedom, StiffnessBody
from flangeway.space import CondensedMatrix, DifferenceProduct, Space, SymmetricMatrix
from flangeway.types import Bools, Floats, Indices

Components = Literal["x", "y", "xy"]

MIN_SPRING_STIFFNESS = 1e-12
"""Stiffness of the springs against a rigid motion, relative to the maximum, below which they leave it free."""


@dataclass(frozen=True, eq=False)
class Body(LinearBody):
    """A meshed elastic body in its own frame, in which its held edges do not move; see `LinearBody`.

    Parameters
    ----------
    name
        Name for messages and results.
    mesh
        Mesh in the body's frame.
    element
        Element of all cells, or of each named cell set, which must then cover the mesh once.
    material
        Material of all cells, or of each named cell set, in plane strain, in plane stress or axisymmetric: then x is
        the radius, y the axis, forces are summed around it, nodes on it stay there, and the body only moves along it.
    held
        Name of the mesh's edge set that stays rigid with the frame; or edge sets, and points of the mesh ``(x, y)``,
        with the components that do not move in the frame's axes, ``"x"``, ``"y"`` or ``"xy"``. What is held in one
        component slides along the other, as on a line of symmetry or a greased plate. Motions that this leaves free,
        all three where nothing is held (None), are decided by the contacts and the loads of `press`: sliding, turning
        about one held point, or both.
    thickness
        Length out of the plane.
    springs
        Elastic supports on named edges or points, whose other ends are on the frame.

    Raises
    ------
    InputError
        If a name, point or component is unknown, a body of revolution has a thickness, or springs leave a motion free
        other than along an axis.

    """

    name: str
    mesh: PolyMesh
    element: Element | Mapping[str, Element]
    material: Material | Mapping[str, Material]
    held: str | Mapping[str | Point, Components] | None = None
    thickness: float = 1.0
    springs: Sequence[Spring] = ()

    def __post_init__(self) -> None:
        check_positive("Body", "thickness", self.thickness, "a positive length", "take 1 for forces per length")
        self._check_held()
        for material in items_by_cells(self.material):
            check_kind(
                "Body", "material", material, Material, "a material, or one by each cell set", "write Elastic(...)"
            )
        if not are_all(self.springs, Spring):
            raise InputError(
                f"Body {self.name!r} springs={short(self.springs)}", "a list of Spring(...)", "make each one"
            )
        object.__setattr__(self, "springs", tuple(self.springs))
        if self.axisymmetric and self.thickness != 1.0:
            raise InputError(
                f"body {self.name!r} of revolution with the thickness {self.thickness:g}",
                "1: forces are summed around the axis",
                "leave the thickness out",
            )

    def _check_held(self) -> None:
        if self.held is not None and (not isinstance(self.held, str | Mapping) or not self.held):
            raise InputError(
                f"Body {self.name!r} held={self.held!r}",
                "the name of an edge set, components by at least one edge set or point, or None",
                "write 'base' or {'base': 'y', (0.0, 1.0): 'x'}, or leave held out for a body that contact alone holds",
            )
        for where, components in self.supports.items():
            if components not in get_args(Components):
                raise InputError(
                    f"Body {self.name!r} held along {where!r} in {components!r}",
                    "'x', 'y' or 'xy'",
                    "choose one of them",
                )
            if isinstance(where, str) and len(self.mesh.edge_sets.get(where, ())) == 0:
                raise InputError(
                    f"Body {self.name!r} held along {where!r}",
                    f"one of its mesh's edge sets: {', '.join(sorted(self.mesh.edge_sets))}",
                    "name the edges with mesh.with_edge_set",
                )

    @property
    def supports(self) -> Mapping[str | Point, Components]:
        """Components held along each edge set and at each point."""
        return {self.held: "xy"} if isinstance(self.held, str) else self.held or {}

    @cached_property
    def elasticity(self) -> Elasticity:
        """The elastic problem of the body."""
        space = Space(self.mesh, self.element)
        return Elasticity(space, self.material, self.thickness, supports=self.springs, name=self.name)

    @property
    def nodes(self) -> Floats:
        """See `LinearBody.nodes`."""
        return self.space.nodes

    @property
    def boundary_edges(self) -> IntArray:
        """See `LinearBody.boundary_edges`."""
        return self.mesh.boundary_edges

    @property
    def edge_sets(self) -> Mapping[str, IntArray]:
        """See `LinearBody.edge_sets`."""
        return self.mesh.edge_sets

    def edge_nodes(self, pairs: Indices) -> IntArray:
        """See `LinearBody.edge_nodes`."""
        return self.space.edge_nodes(pairs)

    @property
    def size(self) -> float:
        """See `LinearBody.size`."""
        return self.elasticity.size

    @property
    def modulus(self) -> float:
        """See `LinearBody.modulus`."""
        return max(float(material.matrix.diagonal().max()) for material in self.elasticity.materials)

    @property
    def softness(self) -> float:
        """See `LinearBody.softness`."""
        compliances = [np.linalg.inv(material.matrix[:3, :3]).diagonal() for material in self.elasticity.materials]
        return max(float(compliance[:2].max()) for compliance in compliances)

    @property
    def hypothesis(self) -> str | None:
        """See `LinearBody.hypothesis`."""
        hypothesis: str = items_by_cells(self.material)[0].hypothesis
        return hypothesis

    @property
    def held_by(self) -> str:
        """See `LinearBody.held_by`."""
        return short(self.held)

    @property
    def content(self) -> tuple[object, ...]:
        """See `LinearBody.content`."""
        mesh, supports = self.mesh, dict(self.supports)
        held = {name: mesh.edge_sets[name] for name in supports if isinstance(name, str)}
        parts: tuple[object, ...] = held, dict(mesh.cell_sets), self.element, self.material, supports, self.thickness
        if self.springs:  # as a matrix: two sets of edges of one name differ
            added = self._springs
            parts = *parts, added.indptr, added.indices, added.data
        return mesh.points, mesh.cell_offsets, mesh.cell_points, *parts

    @cached_property
    def free(self) -> Bools:
        """Which unknowns at nodes are free to move in the body's frame, shape (2 n_nodes,).

        Those inside cells are condensed.
        """
        free = ~self.supported
        for node, components in self.freedom.pins.items():
            free[node, ["xy".index(component) for component in components]] = False
        return free.ravel()

    @cached_property
    def supported(self) -> Bools:
        """See `LinearBody.supported`."""
        held = np.zeros((self.space.n_nodes, 2), dtype=bool)
        for where, components in self.supports.items():
            for component in components:
                held[self.elasticity.nodes_at(where), "xy".index(component)] = True
        if self.axisymmetric:
            held[self.elasticity.on_axis, 0] = True
        return held

    @cached_property
    def freedom(self) -> RigidFreedom:
        """Rigid motions that what is held leaves free: it slides, turns about its one held point, or both."""
        if self.springs:
            return self._freedom_on_springs()
        nodes = np.flatnonzero(self.supported.any(axis=1))
        axes = "".join(axis for number, axis in enumerate("xy") if not self.supported[:, number].any())
        points, corners = self.space.nodes, np.unique(self.mesh.boundary_edges)
        if self.axisymmetric:
            return self._slide(int(corners[0]), axes.replace("x", ""))
        if len(nodes) > 1:
            return self._slide(int(nodes[0]), axes)
        first = int(nodes[0] if len(nodes) else corners[points[corners].sum(axis=1).argmin()])
        arms = points[corners] - points[first]
        # far along one axis and close to it, so that strains do not turn the body in its frame
        far, across = np.unravel_index((np.abs(arms[:, ::-1]) - 3.0 * np.abs(arms)).argmax(), arms.shape)
        pivot = points[first] if len(nodes) else box_middle(points[corners])
        return RigidFreedom(pivot, axes, True, {first: "xy", int(corners[far]): "xy"[across]})

    def _freedom_on_springs(self) -> RigidFreedom:
        """The one slide that neither what is held nor the springs resist, if there is one."""
        points, corners = self.space.nodes, np.unique(self.mesh.boundary_edges)
        arms = (points - points.mean(axis=0)) / self.size
        zero, one = np.zeros(len(points)), np.ones(len(points))
        motions = np.stack((one, zero, zero, one, -arms[:, 1], arms[:, 0])).reshape(3, 2, -1).transpose(2, 1, 0)
        resisted = motions.reshape(-1, 3).T @ (self._springs @ motions.reshape(-1, 3))
        unit = float(resisted.diagonal().max()) or 1.0
        held = motions[self.supported] if not self.axisymmetric else np.eye(3)[[0, 2]]
        free = [axis for axis, motion in zip("xy", np.eye(3)[:2], strict=True) if not np.any(held @ motion)]
        energies, directions = np.linalg.eigh(resisted + unit * held.T @ held)
        loose = directions[:, energies <= MIN_SPRING_STIFFNESS * unit]
        axes = "".join(axis for axis in free if np.allclose(np.abs(loose[["x", "y"].index(axis)]).sum(), 1.0))
        if loose.shape[1] > 1 or len(axes) < loose.shape[1]:
            raise InputError(
                f"Body {self.name!r}, which its springs and what is held leave free to turn, or to slide obliquely",
                "springs that hold all motions but one along x or y",
                "add a spring against it, or hold more in Body(held=...)",
            )
        return self._slide(int(corners[0]), axes)

    def _slide(self, node: int, axes: str) -> RigidFreedom:
        """Freedom along axes, in which a node is pinned."""
        return RigidFreedom(self.space.nodes[node], axes, False, {node: axes} if axes else {})

    @cached_property
    def _springs(self) -> sp.csc_array:
        """Stiffness of the springs on the displacements at nodes."""
        none = sp.csc_array((2 * self.space.n_nodes, 2 * self.space.n_nodes))
        return sum((self.elasticity.spring_stiffness(spring) for spring in self.springs), none)

    @cached_property
    def condensed(self) -> CondensedMatrix:
        """Stiffness at nodes without springs, no unknown held; unknowns inside cells are condensed."""
        return self.elasticity.condensed_stiffness()

    @cached_property
    def stiffness(self) -> SymmetricMatrix:
        """Stiffness of the free unknowns at nodes, in their order; those inside cells are condensed."""
        matrix = self.condensed.matrix
        return (matrix.plus(self._springs) if self.springs else matrix).restricted(self.free)

    @property
    def product(self) -> DifferenceProduct:
        """See `LinearBody.product`."""
        kept = sp.eye_array(len(self.free), format="csr")[:, np.flatnonzero(self.free)]
        added = self._springs if self.springs else None
        return DifferenceProduct(self.condensed.matrix, kept, axisymmetric=self.axisymmetric, springs=added)

    def field(self, values: Floats) -> Floats:
        """All displacements (n_dofs, 2) from those of the free unknowns (n_free,), without body forces."""
        at_nodes = np.zeros(len(self.free))
        at_nodes[self.free] = values
        return self.condensed.recover(at_nodes)

    def unknowns(self, field: Floats) -> Floats:
        """See `LinearBody.unknowns`; the matrix is that of `Elasticity.stiffness`."""
        return field.ravel()

    @staticmethod
    def from_stiffness(
        name: str,
        stiffness: Any,
        coordinates: ArrayLike,
        surfaces: Mapping[str, ArrayLike],
        *,
        order: int = 1,
        rows: ArrayLike | None = None,
        held: ArrayLike | None = None,
        thickness: float = 1.0,
        axisymmetric: bool = False,
    ) -> StiffnessBody:
        """Return a body of a stiffness matrix that another program has assembled; `StiffnessBody` has the arguments."""
        return StiffnessBody(name, stiffness, coordinates, surfaces, order, rows, held, thickness, axisymmetric)
