"""Two half discs pressed together: Hertz's contact of parallel cylinders (Moherdaui 2021, 6.2.2)."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from flangeway.contact import (
    Contact,
    ContactLinearisation,
    ContactSolution,
    ContactSystem,
    NodeToSegment,
    SegmentToSegment,
    Surface,
    press,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.errors import InputError
from flangeway.exact import LineContact, contact_modulus
from flangeway.geometry import Placement
from flangeway.post import PressurePatch, cell_stresses, corner_stresses, pressure_patches
from flangeway.problems import ElasticField, Part
from flangeway.solve import BodyResponse, CondensedBodies, Status, StepSettings
from flangeway.types import Floats
from flangeway.validation.hertz.half_disc import HalfDisc, Side

ZONE = 0.85
"""Half width of the candidate zone over that of the lens in which the undeformed discs would overlap.

Elastic discs touch on little more than half of it; contact that reaches the zone's end counts as not converged.
"""
ZONE_EDGES = 3
"""Edges by which the zone is wider, for coarse meshes."""


@dataclass(frozen=True)
class HertzProblem:
    """Two half discs that touch at the origin and whose cuts approach each other, both components prescribed.

    Parameters
    ----------
    secondary, primary
        The disc above, which gives nodes, and the disc below, which gives segments.
    enforcement
        How the condition of no penetration is enforced.
    pairing
        How the surfaces are compared.
    approach
        How much nearer the cuts come.
    thickness
        Length out of the plane.
    n_steps
        Equal load steps.
    curved
        Whether the gap is measured between the circles. The meshes' straight edges make them polygons, whose corners
        show in the pressure.

    """

    secondary: HalfDisc
    primary: HalfDisc
    enforcement: Enforcement
    pairing: NodeToSegment | SegmentToSegment = field(default_factory=NodeToSegment)
    approach: float = 0.05
    thickness: float = 1.0
    n_steps: int = 10
    curved: bool = False

    def __post_init__(self) -> None:
        for name in ("approach", "thickness", "n_steps"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"HertzProblem({name}={value})", "a positive number", "leave it out")

    @property
    def relative_curvature(self) -> float:
        """Sum of the curvatures."""
        return 1.0 / self.secondary.radius + 1.0 / self.primary.radius

    @property
    def modulus(self) -> float:
        """Contact modulus E*."""
        return contact_modulus(self.secondary.material.plane_modulus, self.primary.material.plane_modulus)

    def theory(self, force: float) -> LineContact:
        """Hertz's contact under a force."""
        return LineContact(force / self.thickness, self.relative_curvature, self.modulus)

    @property
    def zone_half_width(self) -> float:
        """Half width of the candidate zone."""
        lens = np.sqrt(2.0 * self.approach / self.relative_curvature)
        return float(ZONE * lens) + ZONE_EDGES * max(self.secondary.size, self.primary.size)


@dataclass(frozen=True, eq=False)
class SurfacePressure:
    """Pressure at the nodes of the secondary surface that face the primary, from left to right.

    Parameters
    ----------
    x
        Places before the deformation, as Hertz's theory has them, shape (n,): by a second-order effect that it leaves
        out, the surface moves towards the middle (by 1.1 % in the published problem).
    forces
        Contact forces, shape (n,).
    values
        Pressures, shape (n,): for node-to-segment the forces over the nodes' influence widths, half of the way to
        either neighbour, for segment-to-segment those of the multipliers' field.

    """

    x: Floats
    forces: Floats
    values: Floats

    def maximum_difference(self, theory: LineContact, margin: float = 0.0) -> float:
        """Maximum difference from Hertz's curve over p0 at nodes farther than `margin` from the contact's ends."""
        inside = np.abs(np.abs(self.x) - theory.half_width) > margin
        return float(np.abs(self.values - theory.pressure(self.x))[inside].max()) / theory.max_pressure

    @property
    def oscillation(self) -> float:
        """Root mean square difference between a loaded node and the mean of its neighbours, over the greatest pressure.

        The two loaded nodes at each end are left out, where the pressure falls steeply.
        """
        loaded = self.values[self.values > 0.0]
        if len(loaded) < 7:
            return 0.0
        apart = loaded[1:-1] - (loaded[:-2] + loaded[2:]) / 2.0
        return float(np.sqrt(np.mean(apart[1:-1] ** 2))) / float(loaded.max())


@dataclass(frozen=True, eq=False)
class HertzModel:
    """Meshed discs and their contact.

    Parameters
    ----------
    problem
        What is modelled.
    contact
        The contact of both parts' arcs.

    """

    problem: HertzProblem
    contact: Contact

    @property
    def parts(self) -> tuple[Part, Part]:
        """The secondary and the primary part."""
        return self.contact.secondary.part, self.contact.primary.part

    @property
    def n_unknowns(self) -> int:
        """Unknowns of both bodies, those inside cells included, those held left out."""
        spaces = [part.body.space for part in self.parts]
        inside = sum(2 * (space.n_dofs - space.n_nodes) for space in spaces)
        return inside + sum(int(part.body.free.sum()) for part in self.parts)

    @property
    def motion(self) -> dict[Part, Placement]:
        """What moves: the secondary disc, by the approach."""
        return {self.parts[0]: Placement(0.0, (0.0, -self.problem.approach))}


@dataclass(frozen=True, eq=False)
class HertzSolution:
    """Contact of two half discs.

    Parameters
    ----------
    model
        The discs.
    contact
        The solution of their contact.
    fields
        Displacements of the secondary and the primary disc.
    timings_s
        Seconds for meshing, assembly, condensation (of the condensed path), contact, and recovery of the fields.

    """

    model: HertzModel
    contact: ContactSolution
    fields: tuple[ElasticField, ElasticField]
    timings_s: dict[str, float]

    @property
    def status(self) -> Status:
        """How it ended; contact that reaches the end of its zone is none that converged."""
        status = self.contact.status
        if status.converged and (self.patch is None or self.patch.at_edge):
            where = "is nowhere" if self.patch is None else "reaches the end of its candidate zone"
            return Status(False, f"contact {where}; check the approach and the radii", status.iterations)
        return status

    @cached_property
    def patch(self) -> PressurePatch | None:
        """The region of contact on the secondary disc, None where there is none."""
        patches = pressure_patches(self.contact.system, self.contact.state)
        return max(patches, key=lambda patch: float(patch.normal_forces.sum()), default=None)

    @property
    def iterations(self) -> tuple[int, ...]:
        """Newton iterations of each load step."""
        return tuple(step.state.status.iterations for step in self.contact.steps)

    @property
    def force(self) -> float:
        """Force that presses the discs together."""
        return float(self.contact.forces[0, 1])

    @property
    def theory(self) -> LineContact:
        """Hertz's contact under the same force."""
        return self.model.problem.theory(self.force)

    @cached_property
    def pressure(self) -> SurfacePressure:
        """Pressure at the nodes of the zone."""
        lin = self.contact.state.linearisation
        assert isinstance(lin, ContactLinearisation)
        surface, pairs = self.model.contact.secondary, lin.pairs[0]
        x = surface.part.body.space.nodes[surface.nodes][:, 0]
        forces, areas = np.zeros(len(x)), np.zeros(len(x))
        np.add.at(forces, pairs.nodes, self.contact.state.forces)
        np.add.at(areas, pairs.nodes, pairs.areas)
        known = np.flatnonzero(areas > 0.0)
        known = known[np.argsort(x[known])]
        if isinstance(self.model.problem.pairing, NodeToSegment):
            areas[known] = _influence_widths(x[known]) * self.model.problem.thickness
        return SurfacePressure(x[known], forces[known], forces[known] / areas[known])

    @cached_property
    def extremes(self) -> dict[str, float]:
        """Least principal stress, greatest shear stress in the plane and greatest von Mises stress of both discs.

        As published they are of each cell at order 1, and unaveraged at all corners above.
        """
        of = cell_stresses if self.fields[0].problem.space.order == 1 else corner_stresses
        both = [of(field.problem, field.displacements) for field in self.fields]
        return {
            "principal_3": min(float(stresses.principal[:, 2].min()) for stresses in both),
            "in_plane_shear": max(float(stresses.in_plane_shear.max()) for stresses in both),
            "von_mises": max(float(stresses.von_mises.max()) for stresses in both),
        }


def build_hertz(problem: HertzProblem) -> HertzModel:
    """Mesh both discs and pair the zones of their arcs where contact can be.

    Raises
    ------
    InputError
        If the zone is wider than a disc's fine arc, or an element does not fit the cells.

    """
    surfaces = []
    sides: tuple[tuple[str, HalfDisc, Side], ...] = (
        ("secondary", problem.secondary, "above"),
        ("primary", problem.primary, "below"),
    )
    for name, disc, side in sides:
        part = Part(name, disc.body(name, side, problem.thickness))
        curve = disc.outline(side) if problem.curved else None
        surfaces.append(Surface(part, disc.zone(part.body.mesh, problem.zone_half_width), curve))
    return HertzModel(problem, Contact(surfaces[0], surfaces[1], problem.pairing, problem.enforcement))


def solve_hertz(
    problem: HertzProblem | HertzModel,
    *,
    path: Literal["condensed", "sparse"] = "condensed",
    progress: Callable[[str], None] = lambda _: None,
) -> HertzSolution:
    """Press the discs together in equal load steps.

    Parameters
    ----------
    problem
        What is pressed, or its meshed model.
    path
        ``"condensed"`` to the contact zones, or ``"sparse"`` on all unknowns.
    progress
        Called with a sentence at each stage.

    Returns
    -------
    HertzSolution
        Its status says whether it converged.

    """
    timings: dict[str, float] = {}
    with _timed(timings, "meshing"):
        if isinstance(problem, HertzProblem):
            progress("meshing the discs")
            model = build_hertz(problem)
        else:
            model = problem
    with _timed(timings, "assembly"):
        progress("assembling the stiffness")
        for part in model.parts:
            _ = part.body.stiffness
    response: BodyResponse | None = None
    if path == "condensed":
        with _timed(timings, "condensation"):
            progress("condensing the discs to their contact zones")
            response = CondensedBodies(ContactSystem([model.contact]).surface_nodes)
    step = 1.0 / model.problem.n_steps
    with _timed(timings, "contact"):
        contact = press(
            [model.contact],
            model.motion,
            steps=StepSettings(first=step, maximum=step, smallest=step / 1024.0),
            path=path,
            response=response,
            progress=progress,
        )
    with _timed(timings, "recovery"):
        fields = (contact.field(model.parts[0]), contact.field(model.parts[1]))
    return HertzSolution(model, contact, fields, timings)


def _influence_widths(x: Floats) -> Floats:
    """Widths that belong to nodes, half of the way to either neighbour (Moherdaui 2021, Figures 24 and 63)."""
    ends = np.concatenate((x[:1], (x[:-1] + x[1:]) / 2.0, x[-1:]))
    return np.diff(ends)


@contextmanager
def _timed(timings: dict[str, float], stage: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    timings[stage] = time.perf_counter() - start
