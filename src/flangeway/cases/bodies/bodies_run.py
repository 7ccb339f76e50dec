"""What came out of a case of bodies that are pressed, pulled and held: one kind of result for all of them."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from flangeway.cases.case import Case
from flangeway.cases.wheelset.summary import plain_numbers
from flangeway.contact import ContactSolution, LoadStep
from flangeway.exact import LineContact
from flangeway.geometry import Placement
from flangeway.post import PressurePatch, cell_stresses, corner_stresses, pressure_patches
from flangeway.problems import ElasticField
from flangeway.solve import Status
from flangeway.system.memory_limits import peak_memory_bytes
from flangeway.system.versions import versions
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class BodyResult:
    """One body.

    Parameters
    ----------
    field
        Elastic displacements in the body's frame, mm.
    placement
        Rigid motion of the body's frame.

    """

    field: ElasticField
    placement: Placement = dataclasses.field(default_factory=Placement)

    def moved(self, points: Floats, displacements: Floats) -> Floats:
        """Whole motion in space of points (n, 2) of the body with elastic displacements (n, 2), shape (n, 2)."""
        motion: Floats = self.placement.points(points + displacements) - points
        return motion


@dataclass(frozen=True, eq=False)
class BodiesRun:
    """A case and what came out of it.

    Parameters
    ----------
    case
        The inputs.
    status
        How it ended.
    summary
        What ``summary.json`` holds.
    bodies
        Displacements by the names of the bodies.
    contact
        The contacts, None for bodies without.
    theory
        Hertz's solution, where the case has one.

    """

    case: Case
    status: Status
    summary: dict[str, Any]
    bodies: Mapping[str, BodyResult]
    contact: ContactSolution | None = None
    theory: LineContact | None = None

    @property
    def patches(self) -> list[PressurePatch]:
        """Regions of contact."""
        return [] if self.contact is None else pressure_patches(self.contact.system, self.contact.state)

    def at_step(self, step: LoadStep) -> dict[str, BodyResult]:
        """Displacements of all bodies at one of the load steps of `contact`; those in no contact bear its share."""
        contact, state = self.contact, step.state
        assert contact is not None
        found = {
            name: BodyResult(ElasticField(body.field.problem, step.share * body.field.displacements), body.placement)
            for name, body in self.bodies.items()
        }
        rotations = contact.response.rotations(state.placements)
        fields = contact.response.fields(rotations, state.nodal_forces)
        for part, all_loads, field, placement in zip(
            contact.system.parts, self._fields_of_loads, fields, state.placements, strict=True
        ):
            # the response is that under all loads, and the bodies are linear
            displacements = field - (1.0 - step.share) * all_loads
            found[part.name] = BodyResult(ElasticField(self.bodies[part.name].field.problem, displacements), placement)
        return found

    @cached_property
    def _fields_of_loads(self) -> list[Floats]:
        """Displacements of the bodies in contact under all loads without contact forces, each (n_dofs, 2)."""
        assert self.contact is not None
        response, state = self.contact.response, self.contact.state
        return response.fields(response.rotations(state.placements), np.zeros_like(state.nodal_forces))


def summarise_bodies(
    case: Case,
    status: Status,
    bodies: Mapping[str, BodyResult],
    contact: ContactSolution | None,
    results: Mapping[str, Any],
    timings_s: Mapping[str, float],
    notices: list[str],
) -> dict[str, Any]:
    """Return what ``summary.json`` holds of such a case: plain numbers with their units in the keys.

    Parameters
    ----------
    case
        The inputs.
    status
        How it ended.
    bodies
        Displacements by the names of the bodies.
    contact
        The contacts, if there are any.
    results
        What this case is about, shown first.
    timings_s
        Seconds by stage.
    notices
        What the reader should know.

    """
    summary: dict[str, Any] = {
        "status": {"converged": status.converged, "message": status.message},
        "results": dict(results),
        "contacts": [] if contact is None else _contacts(contact),
        "bodies": [_body(name, body) for name, body in bodies.items()],
        "notices": notices,
        "timings_s": dict(timings_s),
        "peak_memory_MB": peak_memory_bytes() / 1e6,
        "case": {"name": case.name, **case.model_dump()},
        "versions": versions(),
    }
    plain: dict[str, Any] = plain_numbers(summary)
    return plain


def _body(name: str, body: BodyResult) -> dict[str, Any]:
    problem, values = body.field.problem, body.field.displacements
    space = problem.space
    of = cell_stresses if space.order == 1 else corner_stresses
    stresses = of(problem, values)
    motion = body.moved(space.nodes, values[: space.n_nodes])
    return {
        "name": name,
        "cells": space.mesh.n_cells,
        "unknowns": 2 * space.n_nodes,
        "max_displacement_mm": np.hypot(*motion.T).max(),
        "max_von_mises_MPa": stresses.von_mises.max(),
        "min_principal_MPa": stresses.principal[:, 2].min(),
        "max_in_plane_shear_MPa": stresses.in_plane_shear.max(),
    }


def _contacts(contact: ContactSolution) -> list[dict[str, Any]]:
    patches = pressure_patches(contact.system, contact.state)
    rows = []
    for number, each in enumerate(contact.system.contacts):
        mine = [patch for patch in patches if patch.contact == number]
        most = max(mine, key=lambda patch: float(patch.pressures.max()), default=None)
        rows.append(
            {
                "secondary": each.secondary.part.name,
                "primary": each.primary.part.name,
                "force_on_secondary_N": contact.forces[number],
                "initial_penetration_mm": contact.initial_penetration[number],
                "max_pressure_MPa": 0.0 if most is None else most.pressures.max(),
                "max_pressure_remark": None if most is None else most.remark,
                "patches": [
                    {
                        "centre_mm": patch.centre,
                        "half_width_mm": patch.half_width,
                        "max_pressure_MPa": patch.pressures.max(),
                        "max_pressure_remark": patch.remark,
                        "force_N": patch.force,
                        "reaches_an_end": patch.at_edge,
                    }
                    for patch in mine
                ],
            }
        )
    return rows
