"""Contact of bodies of nonlinear materials: Newton's method around the contact of their linearised bodies."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from flangeway.contact.contact_pair import Contact
from flangeway.contact.press import ContactSolution, press
from flangeway.contact.surface import Surface
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.problems import Body, Part
from flangeway.problems.loads import GivenForces
from flangeway.problems.nonlinear_body import LinearisedBody, MaterialByCells, MaterialState, NonlinearBody
from flangeway.types import Floats


class NonlinearContact(NamedTuple):
    """Bodies of nonlinear materials in contact.

    Parameters
    ----------
    contact
        The contact of the linearised bodies.
    displacements
        Of the nonlinear parts, (n_dofs, 2).
    converged
        Whether both the last contact and the iteration converged.
    states
        What the nonlinear parts remember, where the next motion starts.

    """

    contact: ContactSolution
    displacements: dict[Part, Floats]
    converged: bool
    states: dict[Part, MaterialState]


def press_nonlinear(
    contacts: Sequence[Contact],
    motion: Mapping[Part, Placement],
    materials: Mapping[Part, MaterialByCells],
    *,
    start: Mapping[Part, MaterialState] | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 20,
) -> NonlinearContact:
    """Move parts against each other in one step, some of them of nonlinear materials.

    In each iteration the nonlinear bodies are replaced by their tangents with the forces ``K u - r``, and `press` finds
    the contact of these linear bodies; at the end it is that of the nonlinear ones.

    Parameters
    ----------
    contacts, motion
        As of `press`; one motion, from the undeformed bodies. Friction starts at rest.
    materials
        Nonlinear material of parts; the others stay elastic.
    start
        The `states` of the motion before; left out, the material has no history.
    tolerance
        Change of the displacements over their maximum that ends the iteration.
    max_iterations
        Number of contacts that are solved.

    Raises
    ------
    InputError
        If a part with a nonlinear material is no meshed body in plane strain, or `press` refuses the contacts.

    """
    bodies, states, fields = {}, {}, {}
    for part, material in materials.items():
        if not isinstance(part.body, Body):
            raise InputError(f"a nonlinear material of {part.name!r}", "a meshed Body", "make it of mesh and element")
        bodies[part] = NonlinearBody(part.body.elasticity, material)
        states[part] = bodies[part].start() if start is None else start[part]
        fields[part] = states[part].displacements
    converged = False
    for _ in range(max_iterations):
        now, loads = {}, {}
        for part, body in bodies.items():
            tangents, forces = body.linearised(states[part], fields[part])
            own = {
                name: getattr(part.body, name) for name in ("name", "mesh", "element", "held", "thickness", "springs")
            }
            linear = LinearisedBody(material=body.problem.material, **own, tangents=tangents)
            now[part] = replace(part, body=linear)
            offset = linear.elasticity.stiffness().times(fields[part].ravel()).reshape(-1, 2) - forces
            if offset.any():
                loads[now[part]] = [GivenForces(offset)]
        moved = [replace(each, secondary=_on(each.secondary, now), primary=_on(each.primary, now)) for each in contacts]
        motions = {now.get(part, part): placement for part, placement in motion.items()}
        solution = press(moved, motions, body_loads=loads, path="sparse")
        found = {part: solution.field(now[part]).displacements for part in bodies}
        size = max(float(np.abs(each).max()) for each in found.values()) or 1.0
        change = max(float(np.abs(found[part] - fields[part]).max()) for part in bodies) / size
        fields = found
        if not np.isfinite(change) or (converged := solution.status.converged and change <= tolerance):
            break
    after = {part: body.committed(states[part], fields[part]) for part, body in bodies.items()} if converged else states
    return NonlinearContact(solution, fields, converged, after)


def _on(surface: Surface, now: Mapping[Part, Part]) -> Surface:
    """The surface on the linearised body."""
    return replace(surface, part=now.get(surface.part, surface.part))
