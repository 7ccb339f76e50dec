"""A linear elastic body that is held along a named part of its boundary."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flangeway.elements import Element
from flangeway.errors import InputError
from flangeway.materials import Material
from flangeway.mesh import PolyMesh
from flangeway.problems.elasticity import Elasticity
from flangeway.space import CondensedMatrix, Space, SymmetricMatrix

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Body:
    """An elastic body in its own frame, in which its held edges do not move.

    The body is linear in that frame. Placing the frame in space, and moving it if the edges are a handle, costs nothing
    and strains nothing, however large the motion.

    Parameters
    ----------
    name
        Name for messages and results.
    mesh
        Mesh in the body's frame.
    element
        Element of all cells.
    material
        Material of all cells, or of each named cell set, in plane strain or plane stress.
    held
        Name of the mesh's edge set that stays rigid with the frame.
    thickness
        Length out of the plane.

    """

    name: str
    mesh: PolyMesh
    element: Element
    material: Material | Mapping[str, Material]
    held: str
    thickness: float = 1.0

    def __post_init__(self) -> None:
        if self.held not in self.mesh.edge_sets or len(self.mesh.edge_sets[self.held]) == 0:
            raise InputError(
                f"Body {self.name!r} held along {self.held!r}",
                f"one of its mesh's edge sets: {', '.join(sorted(self.mesh.edge_sets))}",
                "name the edges with mesh.with_edge_set",
            )
        materials = self.material.values() if isinstance(self.material, Mapping) else (self.material,)
        if any(material.hypothesis == "axisymmetric" for material in materials):
            raise InputError(
                f"body {self.name!r} of an axisymmetric material",
                "plane strain or plane stress: contact is per thickness",
                "take Elasticity for a body of revolution without contact",
            )

    @cached_property
    def elasticity(self) -> Elasticity:
        """The elastic problem of the body."""
        return Elasticity(Space(self.mesh, self.element), self.material, self.thickness, name=self.name)

    @property
    def space(self) -> Space:
        """Space of one displacement component."""
        return self.elasticity.space

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """Which unknowns at nodes are free to move in the body's frame, shape (2 n_nodes,)."""
        nodes = self.space.edge_nodes(self.mesh.edge_sets[self.held])
        free = np.ones((self.space.n_nodes, 2), dtype=np.bool_)
        free[nodes.ravel()] = False
        return free.ravel()

    @cached_property
    def _condensed(self) -> CondensedMatrix:
        return self.elasticity.condensed_stiffness()

    @cached_property
    def stiffness(self) -> SymmetricMatrix:
        """Stiffness of the free unknowns at nodes, in their order; those inside cells are condensed."""
        return self._condensed.matrix.restricted(self.free)

    def field(self, values: Floats) -> Floats:
        """All displacements (n_dofs, 2) from those of the free unknowns (n_free,), without body forces."""
        at_nodes = np.zeros(len(self.free))
        at_nodes[self.free] = values
        return self._condensed.recover(at_nodes)

    @property
    def free_nodes(self) -> NDArray[np.int32]:
        """Node of each free unknown, shape (n_free,): the unknowns of a node are ordered together."""
        return (np.flatnonzero(self.free) // 2).astype(np.int32)

    def free_numbers(self, nodes: NDArray[np.integer]) -> NDArray[np.int32]:
        """Numbers among the free unknowns of nodes' components, shape (2 n_nodes,)."""
        dofs = (2 * np.asarray(nodes)[:, None] + np.arange(2)).ravel()
        if not self.free[dofs].all():
            raise InputError(
                f"body {self.name!r}: a contact surface that touches the held edges {self.held!r}",
                "surfaces apart from them",
                "shorten the surface or hold the body elsewhere",
            )
        numbers = np.cumsum(self.free) - 1
        return numbers[dofs].astype(np.int32)
