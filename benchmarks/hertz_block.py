"""A half cylinder pressed on a block: Hertz's line contact, on the same nodes for flangeway and its peers.

The half cylinder (R = 100 mm) is moved as a whole along its cut, the block (100 mm by 100 mm) is held along its base.
The gap is measured between the drawn circle and the drawn line. The approach that bears the load is an unknown of
Newton's method beside the contact forces.
"""

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flangeway.contact import (
    Contact,
    ContactState,
    ContactSystem,
    Multiplier,
    SegmentToSegment,
    Surface,
    solve_contact,
)
from flangeway.elements import Lagrange
from flangeway.exact import LineContact, contact_modulus
from flangeway.geometry import Line, Outline, Placement
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, triangulate
from flangeway.problems import Body, Part
from flangeway.problems.body_records import BodyTable, body_shape
from flangeway.solve import CondensedBodies, Handle, NewtonSettings

Floats = NDArray[np.float64]

STEEL = Elastic(210e3, 0.3)
RADIUS, HALF_SIZE, LOAD = 100.0, 50.0, 2000.0  # mm, mm, N/mm
FINE, ZONE = 3.0, 2.0  # half widths of what is finely meshed and of what can touch; the contact's is 1.49
TOP, BASE = "top", "base"
FORCE_ERROR = 1e-9
"""Relative error of the force up to which the approach is found."""
STEP_TOLERANCE = 1e-5
"""Tolerance of Newton's method at load steps on the way, as the peers have it."""

HERTZ = LineContact(LOAD, 1.0 / RADIUS, contact_modulus(STEEL.plane_modulus, STEEL.plane_modulus))


@dataclass(frozen=True)
class Block:
    """Meshes of both bodies, for elements of order 2.

    Parameters
    ----------
    circle, outline
        Outlines of the half cylinder and of the block, whose upper side is at y = 0.
    upper, lower
        Meshes of the cylinder and of the block.

    """

    circle: Outline
    outline: Outline
    upper: PolyMesh
    lower: PolyMesh

    @property
    def n_nodes(self) -> int:
        """Nodes of both bodies at order 2."""
        return sum(mesh.n_points + len(mesh.edges) for mesh in (self.upper, self.lower))

    def zone(self, mesh: PolyMesh, name: str) -> NDArray[np.int32]:
        """Edges of an edge set that can touch."""
        edges = mesh.edge_sets[name]
        return edges[(np.abs(mesh.points[edges][..., 0]) <= ZONE).all(axis=1)]


def mesh_block(size: float, growth: float) -> Block:
    """Mesh both bodies with triangles that have a size at the contact and grow with the distance from it."""
    arc_deg = 2.0 * float(np.degrees(np.arcsin(FINE / RADIUS)))
    half = {"radius_mm": RADIUS, "centre_mm": [0.0, RADIUS], "half": "lower", "arc_deg": arc_deg}
    finer = {"edges": "arc", "size_mm": size, "growth": growth}
    table = {"name": "cylinder", "disc": half, "size_mm": 10.0, "fine": [finer]}
    cylinder = body_shape(BodyTable.model_validate(table), "cylinder", [])
    w, h = HALF_SIZE, 2.0 * HALF_SIZE
    corners = [(-w, -h), (w, -h), (w, 0.0), (FINE, 0.0), (-FINE, 0.0), (-w, 0.0)]
    lines = [Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    outline = Outline.from_segments(lines, [BASE, "side", "rest", TOP, "rest", "side"])
    x = np.linspace(-FINE, FINE, int(np.ceil(FINE / (2.0 * size))) + 1)
    fine = Refinement(np.column_stack((x, np.zeros_like(x))), size, growth)
    return Block(cylinder.loops[0], outline, cylinder.mesh, triangulate(outline, size=10.0, refinements=(fine,)))


@dataclass(frozen=True, eq=False)
class Pressed:
    """A contact found by any program.

    Parameters
    ----------
    seconds
        Time from meshes to displacements of all nodes and the pressure.
    x, pressures
        Places of the cylinder's nodes before the deformation, and their contact pressures, shape (n,).
    force
        Force per length that the pressure bears.
    force_error
        Relative error of the sum of the contact forces on either side from the load, None where the approach was given.
    approach
        How much nearer cut and base came.
    note
        What else is to be told.
    tractions, tangential_force
        Tangential tractions of the nodes, and the resultant, where there is friction.
    cpu_seconds
        The same time of the processors; None where it was not taken.

    """

    seconds: float
    x: Floats
    pressures: Floats
    force: float
    force_error: float | None = None
    approach: float = 0.0
    note: str = ""
    tractions: Floats | None = None
    tangential_force: float = 0.0
    cpu_seconds: float | None = None

    def centre_traction_error(self, friction: float) -> float:
        """Relative error of the tangential traction at the centre from Cattaneo's and Mindlin's for the forces found.

        It is the mean over the middle fifth of the contact, of both.
        """
        assert self.tractions is not None
        theory, x = self.theory, self.x
        inside = np.abs(x) < 0.1 * theory.half_width
        stick = np.sqrt(1.0 - self.tangential_force / (friction * self.force))
        narrow = stick * np.sqrt(1.0 - (x[inside] / (stick * theory.half_width)) ** 2)
        whole = np.sqrt(1.0 - (x[inside] / theory.half_width) ** 2)
        exact = friction * theory.max_pressure * (whole - narrow)
        return float(np.abs(self.tractions[inside]).mean() / exact.mean() - 1.0)

    def traction_difference(self, finer: "Pressed", friction: float) -> float:
        """Root mean square difference of the tangential tractions from those on a finer mesh, over mu p0 of each.

        It is taken over the nodes in the middle 95 % of the contact: beyond, a node's traction is that of an edge which
        is partly open.
        """
        x, tractions = self._without_units(friction)
        fine_x, fine = finer._without_units(friction)
        inside = np.abs(x) < 0.95
        return float(np.sqrt(np.mean((tractions - np.interp(x, fine_x, fine))[inside] ** 2)))

    def _without_units(self, friction: float) -> tuple[Floats, Floats]:
        """Places over the half width and tangential tractions over mu p0, both by Hertz, in the order of places."""
        assert self.tractions is not None
        order, theory = np.argsort(self.x), self.theory
        return self.x[order] / theory.half_width, np.abs(self.tractions[order]) / (friction * theory.max_pressure)

    @property
    def theory(self) -> LineContact:
        """Hertz's contact under the force that was found."""
        return LineContact(self.force, HERTZ.relative_curvature, HERTZ.modulus)

    @property
    def peak_error(self) -> float:
        """Relative error of the maximum pressure."""
        return float(self.pressures.max()) / self.theory.max_pressure - 1.0

    @property
    def half_width_error(self) -> float:
        """Relative error of the half width where the parabola through the squares of the pressures vanishes.

        It takes the pressures above three tenths of the largest, as the last loaded nodes carry only what their
        functions reach under the contact.
        """
        inside = self.pressures > 0.3 * self.pressures.max()
        c, b, a = np.polynomial.polynomial.polyfit(self.x[inside], self.pressures[inside] ** 2, 2)
        half_width = float(np.sqrt(b**2 - 4.0 * a * c) / (2.0 * abs(a)))
        return half_width / self.theory.half_width - 1.0


def press_block(block: Block, n_steps: int = 1) -> Pressed:
    """Press with flangeway: elements of order 2, averaged gaps and multipliers, bodies condensed to their surfaces."""
    start = time.perf_counter()
    upper = Part("cylinder", Body("cylinder", block.upper, Lagrange(2), STEEL, "cut"))
    lower = Part("block", Body("block", block.lower, Lagrange(2), STEEL, BASE))
    contact = Contact(
        Surface(upper, block.zone(block.upper, "arc"), block.circle),
        Surface(lower, block.zone(block.lower, TOP), block.outline),
        SegmentToSegment(weighting="dual"),
        Multiplier(),
    )
    system = ContactSystem([contact])
    response = CondensedBodies(system.surface_nodes)
    state, approach = None, _first_approach()
    taken: list[tuple[float, float]] = []
    for step in range(1, n_steps):
        state = _touch(approach * step / n_steps, response, system, state)
        taken.append((approach * step / n_steps, _force(response, state)))
    if len(taken) > 1:  # the force is nearly a power of the approach
        (first, less), (last, more) = np.log(taken[-2:])
        approach = float(np.exp(last + (np.log(LOAD) - more) * (last - first) / (more - less)))
    state, approach = _bear(approach, response, system, state)
    response.fields(response.rotations(state.placements), state.nodal_forces)
    x, pressures = _pressures(contact, state)
    seconds = time.perf_counter() - start
    above, below = (state.nodal_forces[response.body_of_node == side, 1].sum() for side in (0, 1))
    error = max(abs(above / LOAD - 1.0), abs(below / LOAD + 1.0))
    return Pressed(seconds, x, pressures, float(above), float(error), approach)


def _first_approach() -> float:
    """Approach of a half cylinder and a block by Johnson (1985), equations 5.57 and 5.58, for a first guess."""
    cylinder = 2.0 * np.log(4.0 * RADIUS / HERTZ.half_width) - 1.0
    ratio = STEEL.poisson / (1.0 - STEEL.poisson)
    block = 2.0 * np.log(4.0 * HALF_SIZE / HERTZ.half_width) - ratio
    return float(LOAD * (cylinder + block) / (np.pi * STEEL.plane_modulus))


def _touch(
    approach: float,
    response: CondensedBodies,
    system: ContactSystem,
    start: ContactState | None,
    tolerance: float = STEP_TOLERANCE,
) -> ContactState:
    """Contact at an approach."""
    placements = (Placement(0.0, (0.0, -approach)), Placement())
    state = solve_contact(response, system, placements, start=start, settings=NewtonSettings(tolerance=tolerance))
    if not state.status.converged:
        raise RuntimeError(f"the block's contact: {state.status.message}")
    return state


def _force(response: CondensedBodies, state: ContactState) -> float:
    """Force on the cylinder."""
    return float(state.nodal_forces[response.body_of_node == 0, 1].sum())


def _bear(
    approach: float, response: CondensedBodies, system: ContactSystem, start: ContactState | None
) -> tuple[ContactState, float]:
    """Contact under the load, and its approach: the cylinder slides down on a handle, from a first approach."""
    placements = (Placement(0.0, (0.0, -approach)), Placement())
    handle = Handle(
        (system.parts[0],), np.zeros(2), np.array([[0.0, 1.0]]), turns=False, load=np.array([0.0, -LOAD, 0.0])
    )
    before = None if start is None else replace(start, motions=np.zeros(1))
    settings = NewtonSettings(tolerance=FORCE_ERROR / 10.0)
    state = solve_contact(response, system, placements, handles=[handle, None], start=before, settings=settings)
    if not state.status.converged:
        raise RuntimeError(f"the block's contact: {state.status.message}")
    return state, approach - float(state.motions[0])


def _pressures(contact: Contact, state: ContactState) -> tuple[Floats, Floats]:
    """Places of the loaded nodes before the deformation, and their pressures."""
    lin = state.linearisation
    pairs, surface = lin.pairs[0], contact.secondary
    loaded = state.forces > 0.0
    x = surface.part.body.space.nodes[surface.nodes[pairs.nodes[loaded]], 0]
    return x, state.forces[loaded] / pairs.areas[loaded]
