"""Bodies that are moved against each other: the contact problem as a user states it."""

import itertools
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from flangeway.checks import MIN_POSITIVE, are_all, are_finite, check_integer, check_tolerance, refused
from flangeway.contact.contact_state import ContactState
from flangeway.contact.newton import solve_contact
from flangeway.contact.solution_checks import BodyOverlap, body_overlaps, check_solution, passages
from flangeway.contact.surface import Surface
from flangeway.contact.system import ROUND_OFF, Contact, ContactSystem, nodal_forces_of
from flangeway.errors import InputError, short
from flangeway.geometry import Placement
from flangeway.geometry.arrays import box_middle, cross_product, max_magnitude
from flangeway.problems import Body, ElasticField, Part, PointForce, Pressure, Traction
from flangeway.problems.loads import GivenForces, refuse_held
from flangeway.problems.nonlinear_body import LinearisedBody, MaterialByCells, MaterialState, NonlinearBody
from flangeway.results import Result, ResultTable
from flangeway.solve import (
    BodyResponse,
    CondensedBodies,
    Handle,
    NewtonSettings,
    SparseBodies,
    Status,
    StepSettings,
    condensed_bytes,
    follow,
)
from flangeway.solve.body_response import BodyLoad, loads_on
from flangeway.types import Floats

# --- Bodies that are moved against each other: the contact problem as a user states it.


MAX_DENSE_BYTES = 4e9
"""Bytes of dense matrices up to which bodies are condensed to their surfaces where nothing else is said."""

ITERATION_COPIES = 8
"""Dense matrices of all surface unknowns that exist at a time in an iteration with friction where all nodes touch."""

LANDING = 1e-3
"""Part of the first motion and of the loads under which parts on handles land without friction."""

FRICTION_ERROR = 1e-4
"""Error of a step with friction, see `StepSettings`, where nothing else is said."""

Load = tuple[float | None, float | None, float | None]
"""Force x, y and moment; None: no motion of this kind."""

PATHS: dict[str, Callable[..., BodyResponse]] = {"condensed": CondensedBodies, "sparse": SparseBodies}


@dataclass(frozen=True, eq=False)
class LoadStep:
    """A converged load step.

    Parameters
    ----------
    share
        Share of the motion, 0 < share <= 1; of a path of motions 1.5 is the middle of the second one.
    state
        The solution there.

    """

    share: float
    state: ContactState


@dataclass(frozen=True, eq=False)
class ContactSolution(Result):
    """Solution of `press`.

    Parameters
    ----------
    system
        The contacts.
    response
        The bodies without loads; give it to another `press` of the same contacts to save their condensation.
    state
        The final state, or the attempt that failed.
    steps
        Converged load steps.
    initial_penetration
        Maximum penetration of each contact before any motion and deformation, shape (n_contacts,); 0 if it was open.
    """

    system: ContactSystem
    response: BodyResponse
    state: ContactState
    steps: tuple[LoadStep, ...]
    initial_penetration: Floats

    @property
    def status(self) -> Status:
        """How the computation ended, with the digits that round-off leaves of the bodies' displacements."""
        return self.state.status.with_digits(self.response.digits)

    @cached_property
    def overlaps(self) -> tuple[BodyOverlap, ...]:
        """How deep each pair of parts overlaps, measured on the whole deformed boundaries; without those apart."""
        return body_overlaps(self.system, self._loaded, self.state, self._fields)

    def checked(self, given: Sequence[tuple[Placement, Handle | None]]) -> "ContactSolution":
        """Itself with what `check_solution` measures in the status, which is that of a failure if there are errors.

        Parameters
        ----------
        given
            Placement of each part before its handle moved it, and the handle with its loads.

        """
        checks = check_solution(self.system, self._loaded, self.state, self._fields, self.overlaps, given)
        errors = [*checks.errors, *passages(self.system, [step.state for step in self.steps])]
        message = (
            "not converged: " + "; ".join(errors) if errors else "; ".join((self.status.message, *checks.warnings))
        )
        checks = replace(checks, errors=tuple(errors))
        status = replace(self.state.status, converged=not errors, message=message, checks=checks)
        return replace(self, state=replace(self.state, status=status))

    @property
    def table(self) -> ResultTable:
        """Parts and forces of the contacts."""
        (x, y), penetrations = self.forces.T, self.initial_penetration
        sides = [(contact.secondary.part.name, contact.primary.part.name) for contact in self.system.contacts]
        secondary, primary = zip(*sides, strict=True)
        return ResultTable(
            {
                "secondary": secondary, "primary": primary, "force_on_secondary_x": x, "force_on_secondary_y": y,
                "initial_penetration": penetrations,
            }
        )  # fmt: skip

    @property
    def forces(self) -> Floats:
        """Resultant of each contact on its secondary side, shape (n_contacts, 2)."""
        return self.resultants[:, 0, :2]

    @cached_property
    def resultants(self) -> Floats:
        """Force x, y and moment about the origin on each contact's secondary and primary side: (n_contacts, 2, 3).

        Of bodies of revolution y is the force along the axis; x and the moment are sums of what acts radially.
        """
        state, at = self.state, self.state.positions
        slides = None if state.friction is None else state.linearisation.slides(at, at)
        tangential = np.zeros(len(state.forces)) if state.friction is None else state.friction.forces
        result = np.zeros((len(self.system.contacts), 2, 3))
        for number, solved in enumerate(self.system.solved(state.linearisation, state.forces)):
            forces_of_contact = np.zeros(len(state.forces))
            forces_of_contact[solved.inside] = 1.0
            forces = nodal_forces_of(
                state.linearisation, forces_of_contact * state.forces, slides, forces_of_contact * tangential, len(at)
            )
            for side, surface in enumerate(solved.contact.sides):
                nodes = self.system.nodes_of(surface)
                result[number, side, :2] = forces[nodes].sum(axis=0)
                result[number, side, 2] = cross_product(at[nodes], forces[nodes]).sum()
        return result

    @property
    def friction_table(self) -> ResultTable:
        """Each closed constraint: its place, forces, pressure, tangential traction, slip in the last step, and state.

        Tangential forces are those on the secondary, tractions the same over the area, and slips those of the
        secondary, positive along the primary's edges, whose body is on their left.
        """
        friction, solved = self.state.friction, self.system.solved(self.state.linearisation, self.state.forces)
        closed = self.state.forces > 0.0
        numbers = np.repeat(np.arange(len(solved)), [len(contact.forces) for contact in solved])
        positions = [self.system.nodes_of(contact.contact.secondary)[contact.pairs.nodes] for contact in solved]
        points = self.state.positions[np.concatenate(positions)]
        areas = np.concatenate([contact.pairs.areas for contact in solved])
        nothing = np.zeros(len(closed))
        tangential, slips = (nothing, nothing) if friction is None else (friction.forces, friction.slips)
        sticks = nothing > 0.0 if friction is None else friction.sticks
        columns = {
            "contact": numbers, "x": points[:, 0], "y": points[:, 1], "normal_force": self.state.forces,
            "tangential_force": tangential, "pressure": self.state.forces / areas, "traction": tangential / areas,
            "slip": slips, "sticks": sticks,
        }  # fmt: skip
        return ResultTable({name: values[closed] for name, values in columns.items()})

    @property
    def dissipated_work(self) -> Floats:
        """Work that friction dissipated in each of the steps, >= 0, shape (n_steps,)."""
        return np.array([0.0 if step.state.friction is None else step.state.friction.work for step in self.steps])

    @property
    def dissipated_by_contact(self) -> Floats:
        """Work that friction dissipated in each contact in all steps, >= 0, shape (n_contacts,)."""
        total = np.zeros(len(self.system.contacts))
        for step in self.steps:
            if (friction := step.state.friction) is not None:
                total += [
                    friction.works[contact.inside].sum()
                    for contact in self.system.solved(step.state.linearisation, step.state.forces)
                ]
        return total

    def nodal_forces(self, part: Part) -> Floats:
        """Contact forces on the nodes of a part in space, shape (n_nodes, 2)."""
        number = self._number(part)
        first, last = self.response.offsets[number : number + 2]
        forces = np.zeros_like(part.body.nodes)
        forces[self.system.surface_nodes[number].nodes] = self.state.nodal_forces[first:last]
        return forces

    def field(self, part: Part) -> ElasticField:
        """Elastic displacements of a part in its own frame, with its loads, for stresses and pictures."""
        number = self._number(part)
        return ElasticField(self._loaded.problem(number, self.state.placements[number]), self._fields[number])

    def placement(self, part: Part) -> Placement:
        """Placement of a part's frame, with what is held of it."""
        return self.state.placements[self._number(part)]

    def unknowns(self, part: Part) -> Floats:
        """Displacements of a part in its own frame, in the order of its body's stiffness matrix, shape (n,)."""
        return part.body.unknowns(self._fields[self._number(part)])

    def _number(self, part: Part) -> int:
        _refuse_without_contact(self.system, part, "a result")
        return self.system.parts.index(part)

    @cached_property
    def _fields(self) -> list[Floats]:
        rotations = self.response.rotations(self.state.placements)
        return self._loaded.fields(rotations, self.state.nodal_forces)

    @property
    def _loaded(self) -> BodyResponse:
        """The bodies with the loads of the state."""
        return self.state.response or self.response


def press(
    contacts: Sequence[Contact],
    motion: Mapping[Part, Placement] | Sequence[Mapping[Part, Placement]] | None = None,
    *,
    loads: Mapping[Part, Load] | None = None,
    body_loads: Mapping[Part, Sequence[BodyLoad]] | None = None,
    handles: Sequence[Handle] = (),
    steps: StepSettings | Sequence[StepSettings] | None = None,
    path: Literal["condensed", "sparse"] | None = None,
    response: BodyResponse | None = None,
    settings: NewtonSettings | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> ContactSolution:
    """Move parts against each other and find the contact forces.

    The status reports whether the equations are solved and `flangeway.contact.solution_checks` finds no fault; what it
    measured is in ``status.checks``.
    `flangeway.post.pressure` finds further reasons to doubt an answer, such as too few elements in the contact.

    Parameters
    ----------
    contacts
        Contacts among the parts.
    motion
        Rigid motion in space of each part that moves, after its own placement; left out, loads alone act. At a share
        of the path its angle and its shift are that share. A sequence of them is a path: press, then push, then
        reverse; each follows those before it. With friction the result depends on the path, and slip is counted from
        one step to the next, from the first placements on: a point that closes in a step has slipped since the
        step began.
        Parts on handles that have a gap at the start first find their equilibrium without friction, under a thousandth
        of the loads and of the motion.
    loads
        Force x, y and moment on the held edges and points of parts, which then move together as a rigid handle where
        the contacts hold it, by part; None in place of a number: the handle does not move in that way, or by its
        ``motion``. The force acts at the middle of what is held and keeps its direction. It grows with the first
        motion. Parts of which nothing is held need no entry: contacts and `body_loads` act on them.
    body_loads
        Loads on the body of each part: `flangeway.problems.Traction`, `Pressure`, `PointForce`, `BodyForce`, `Gravity`
        and `TemperatureChange`, and `PrescribedDisplacement` of what is held, relative to its handle or frame. Edges,
        points and functions of them are those of the body's own frame. Pressures turn with the body, other forces keep
        their direction in space. They grow with the first motion, which may be empty, and act on handles too.
    handles
        Rigid motions that contacts, loads and springs decide, each shared by one or more parts that are held: two
        wheels on an axle, bodies bolted together. Their pivots are those at the parts' own placements; a motion, the
        same for all parts of a handle, takes pivot and springs along. Loads on them grow with the first motion.
    steps
        Sizes of the load steps; left out: one step, halved where it does not converge, and with friction until it
        agrees with its two halves. A sequence of them is one for each motion of the path.
    path
        ``"condensed"``: on the surfaces alone. ``"sparse"``: on all unknowns, the same answer. Left out: condensed
        where its dense matrices need less than 4 GB, up to about 8,000 unknowns on the surfaces of a body, or with
        friction 7,000 on all surfaces; else sparse.
    response
        The bodies of an earlier `press` of the same contacts, in place of ``path``.
    settings
        Limits of Newton's method.
    progress
        Called with a sentence after each step.

    Raises
    ------
    InputError
        If a moved or loaded part has no contact, a motion is mirrored, a load does not fit its body, a force or a
        handle is on a part that is not held fully, nothing is held of a moved one, a part has two handles, parts of a
        handle move differently, there are not as many step sizes as motions, or the path is unknown.

    """
    system, loads, on_bodies = ContactSystem(contacts), loads or {}, body_loads or {}
    motions = [motion or {}] if isinstance(motion, Mapping | None) else motion
    _refuse_bad_inputs(system, motions, loads, on_bodies, handles)
    handle_of = {part: handle for handle in handles for part in handle.parts}
    handle_of |= {part: alone for part in system.parts if (alone := _handle_of(part, loads.get(part)))}

    def handles_at(placements: Sequence[Placement], share: float) -> list[Handle | None]:
        """Handle of each part at placements, with a share of its load."""
        at_parts = dict(zip(system.parts, placements, strict=True))
        moved = {handle: _carried(handle, at_parts, share) for handle in handle_of.values()}
        return [moved[handle_of[part]] if part in handle_of else None for part in system.parts]

    settings_of = _step_settings(system, len(motions), steps)
    if not isinstance(settings, NewtonSettings | None):
        raise refused("press", "settings", settings, "NewtonSettings(...)", "leave it out")
    bodies = _bodies(system, response, path, floating=bool(handle_of))
    displaced = [loads_on(part.body, on_bodies[part]) if on_bodies.get(part) else None for part in system.parts]
    done: list[LoadStep] = []

    placed = tuple(part.placement for part in system.parts)
    gaps, first_placements = _gaps(system, bodies.undeformed(placed)), placed
    reached: ContactState | None = None
    for number, (leg, sizes) in enumerate(zip(motions, settings_of, strict=True)):

        def solve_at(
            share: float,
            start: ContactState | None,
            leg: Mapping[Part, Placement] = leg,
            number: int = number,
            placed: tuple[Placement, ...] = placed,
            among: ContactSystem = system,
        ) -> ContactState:
            placements = _moved(system.parts, placed, leg, share)
            growth = min(number + share, 1.0)
            handles = handles_at(placements, growth)
            loaded = bodies.loaded(displaced, placements, growth) if any(displaced) else bodies
            state = solve_contact(
                loaded, among, placements, handles=handles, start=start, settings=settings, origin=first_placements
            )
            if among is not system:
                return state
            # where contacts or loads decide the place of a part, one in which it overlaps is on a branch of its own
            if (
                state.status.converged
                and (any(handles) or any(displaced))
                and (errors := _errors_of_step(system, loaded, start, state))
            ):
                status = replace(state.status, converged=False, message=f"not converged: {'; '.join(errors)}")
                state = replace(state, status=status)
            which = f"motion {number + 1}" if len(motions) > 1 else "the motion"
            progress(f"{100.0 * share:.4g} % of {which}: {state.status.message}")
            return state

        def keep(share: float, state: ContactState, number: int = number) -> None:
            done.append(LoadStep(number + share, state))

        if number == 0 and _falls(system, gaps, handle_of):
            landed = solve_at(LANDING, None, among=system.without_friction)
            reached = landed if landed.status.converged else None
        reached = follow(solve_at, reached, sizes, keep, _uncertain)
        placed = _moved(system.parts, placed, leg, 1.0)
        if not reached.status.converged:
            break
    assert reached is not None
    state = reached
    if state.status.converged and not state.nodal_forces.any():
        state = replace(state, status=replace(state.status, message=f"{state.status.message}; nothing touches"))
    solution = ContactSolution(system, bodies, state, tuple(done), _penetrations(gaps))
    if not state.status.converged:
        return solution
    return solution.checked(list(zip(placed, handles_at(placed, 1.0), strict=True)))


def _errors_of_step(
    system: ContactSystem, response: BodyResponse, start: ContactState | None, state: ContactState
) -> list[str]:
    """Why a solution is none that the path leads to: bodies overlap, or one has moved through another one."""
    states = [state] if start is None else [start, state]
    overlaps = body_overlaps(system, response, state)
    return [*(str(overlap) for overlap in overlaps if not overlap.is_explained), *passages(system, states)]


def _uncertain(state: ContactState) -> float:
    """Sum of the forces that tolerated penetrations leave open."""
    lin, closed = state.linearisation, (state.forces > 0.0) & np.isfinite(state.linearisation.tolerances)
    return float((lin.tolerances[closed] / lin.compliances[closed]).sum())


def _step_settings(
    system: ContactSystem, n_motions: int, steps: StepSettings | Sequence[StepSettings] | None
) -> list[StepSettings | None]:
    """Sizes of the steps of each motion; with friction, where nothing is said, by their error."""
    if steps is None and any(contact.friction_coefficient for contact in system.contacts):
        steps = StepSettings(error=FRICTION_ERROR)
    settings_of: list[StepSettings | None] = list(steps) if isinstance(steps, Sequence) else [steps] * n_motions
    if len(settings_of) != n_motions:
        raise InputError(
            f"press(steps=...) of {len(settings_of)} motions for a path of {n_motions}",
            "one StepSettings for all motions, or one for each",
            "give as many as there are motions",
        )
    for value in settings_of:
        if not isinstance(value, StepSettings | None):
            raise refused("press", "steps", value, "StepSettings(...)", "leave it out")
    return settings_of


def _bodies(system: ContactSystem, response: BodyResponse | None, path: str | None, *, floating: bool) -> BodyResponse:
    """The bodies of an earlier `press`, or new ones, see there."""
    if not isinstance(response, BodyResponse | None):
        raise refused("press", "response", response, "that of an earlier press of the same contacts", "leave it out")
    path = _usual_path(system, floating=floating) if path is None else path
    if not isinstance(path, str) or path not in PATHS:
        raise refused("press", "path", path, " or ".join(map(repr, PATHS)), "leave it out")
    return response or PATHS[path](system.surface_nodes)


def _usual_path(system: ContactSystem, *, floating: bool) -> Literal["condensed", "sparse"]:
    """The path where nothing else is said, see `press`; `floating`: whether a part is on a handle."""
    needed = condensed_bytes(system.surface_nodes)
    if any(contact.friction_coefficient for contact in system.contacts) and not floating:
        needed += (
            8 * ITERATION_COPIES * sum(2 * len(surface_nodes.nodes) for surface_nodes in system.surface_nodes) ** 2
        )
    return "condensed" if needed <= MAX_DENSE_BYTES else "sparse"


def _moved(
    parts: Sequence[Part], placed: Sequence[Placement], motion: Mapping[Part, Placement], share: float
) -> tuple[Placement, ...]:
    """Placements after a share of a motion."""
    return tuple(
        motion[part].part(share).after(before) if part in motion else before
        for part, before in zip(parts, placed, strict=True)
    )


def _refuse_bad_inputs(
    system: ContactSystem,
    motions: Sequence[Mapping[Part, Placement]],
    loads: Mapping[Part, Load],
    body_loads: Mapping[Part, Sequence[BodyLoad]],
    handles: Sequence[Handle],
) -> None:
    for name, given in (("loads", loads), ("body_loads", body_loads)):
        if not isinstance(given, Mapping):
            raise refused("press", name, given, "a dictionary by part", f"write {name}={{part: ...}}")
    _refuse_bad_motions(system, motions)
    _refuse_bad_loads(system, motions, loads)
    for part, items in body_loads.items():
        _refuse_without_contact(system, part, "loads on the body")
        if not isinstance(items, list | tuple):
            raise refused("press", "body_loads", body_loads, "lists of loads by part", "write {part: [load]}")
    _refuse_bad_handles(system, motions, list(loads), handles)
    for part, items in body_loads.items():
        driven = part in loads or any(part in handle.parts for handle in handles)  # a free handle carries loads on it
        for item in () if driven or not isinstance(part.body, Body) else items:
            if isinstance(item, Traction | Pressure | PointForce):
                refuse_held(item, part.body.elasticity, part.body.supported)


def _refuse_without_contact(system: ContactSystem, part: Part, what: str) -> None:
    """Raise `InputError` if a part has no contact, or is none."""
    if part not in system.parts:
        raise InputError(
            f"{what} of part {part.name if isinstance(part, Part) else short(part)!r}, which has no contact",
            f"parts in contact: {', '.join(known.name for known in system.parts)}",
            "add a contact of this part, or leave it out",
        )


def _refuse_bad_motions(system: ContactSystem, motions: Sequence[Mapping[Part, Placement]]) -> None:
    if not are_all(motions, Mapping) or not motions:
        raise InputError(
            f"press(motion={short(motions)})",
            "a motion {part: Placement(...)}, or a path of at least one",
            "write [{part: Placement(...)}, {part: Placement(...)}]",
        )
    for part, moved in (moved_part for motion in motions for moved_part in motion.items()):
        if not isinstance(part, Part) or not isinstance(moved, Placement):
            raise InputError(
                f"motion={{{short(part)}: {short(moved)}}}",
                "a Placement by its Part",
                "write {part: Placement(angle, (x, y))}",
            )
        _refuse_without_contact(system, part, "a motion")
        if moved.mirrored:
            raise InputError(
                f"a mirrored motion of part {part.name!r}",
                "a rotation and a translation",
                "mirror the part itself: Part(..., placement=Placement(mirrored=True))",
            )
        part.check_placement("a motion", moved)


def _refuse_bad_loads(
    system: ContactSystem, motions: Sequence[Mapping[Part, Placement]], loads: Mapping[Part, Load]
) -> None:
    for part, load in loads.items():
        _refuse_without_contact(system, part, "a load")
        numbers = [value for value in load if value is not None] if isinstance(load, tuple | list) else []
        if not numbers or len(load) != 3 or not are_finite(numbers, len(numbers)):
            raise InputError(
                f"loads={{{part.name!r}: {short(load)}}}",
                "three finite numbers, force x, y and moment, or None where the part does not move; not three None",
                "write (0.0, -1000.0, None)",
            )
        if part.body.axisymmetric and (load[0] is not None or load[2] is not None):
            raise InputError(
                f"loads={{{part.name!r}: {short(load)}}} of a body of revolution",
                "a force along its axis y",
                "write (None, -1000.0, None)",
            )
        if part.body.freedom.n_motions:
            raise InputError(
                f"a load on part {part.name!r}, of which {part.body.held_by} is held",
                "parts whose held edges or points hold them fully: they are the handle on which a load acts",
                "name the edges on which the force acts in Body(held=...)",
            )
    for part in itertools.chain(*motions):
        freedom = part.body.freedom
        if freedom.turns and freedom.axes == "xy":
            raise InputError(
                f"a motion of part {part.name!r}, of which nothing is held",
                "motions of what is held",
                "leave the motion out: contact moves this part; or hold edges of it",
            )


def _refuse_bad_handles(
    system: ContactSystem,
    motions: Sequence[Mapping[Part, Placement]],
    loaded: Sequence[Part],
    handles: Sequence[Handle],
) -> None:
    if not are_all(handles, Handle):
        raise refused("press", "handles", handles, "a list of Handle(...)", "leave it out")
    with_handle = list(loaded)
    for handle, part in ((handle_of_part, part) for handle_of_part in handles for part in handle_of_part.parts):
        named, body = f"a handle of part {part.name!r}", part.body
        along_axis = len(handle.directions) == 1 and handle.directions[0, 0] == 0.0 and not handle.turns
        _refuse_without_contact(system, part, "a handle")
        if part in with_handle:
            raise InputError(f"{named}, which has another, or a load", "one handle for each part", "put the load on it")
        if body.freedom.n_motions:
            raise InputError(
                f"{named}, of which {body.held_by} is held",
                "parts that are held fully: what is held of them moves with the handle",
                "name the edges that are fixed to the handle in Body(held=...)",
            )
        if body.axisymmetric and not along_axis:
            raise InputError(
                f"{named}, a body of revolution", "a slide along its axis", "write directions=[(0.0, 1.0)], turns=False"
            )
        if any(leg.get(part) != leg.get(handle.parts[0]) for leg in motions):
            raise InputError(
                f"{named}, which does not move as part {handle.parts[0].name!r}, on the same handle",
                "the same motion for all parts of a handle",
                "move all of them, or none",
            )
        with_handle.append(part)


def _handle_of(part: Part, load: Load | None) -> Handle | None:
    """Handle of a part alone where it is placed, with its load; None if it only moves as motions say."""
    freedom, placement = part.body.freedom, part.placement
    if load is not None:
        held = part.body.nodes[part.body.supported.any(axis=1)]
        (pivot,) = placement.points([box_middle(held)])
        free = [value is not None for value in load]
        forces = np.array([value or 0.0 for value in load])
        return Handle((part,), pivot, np.eye(2)[free[:2]], free[2], forces, soft_motions="kept")
    if freedom.n_motions == 0:
        return None
    axes = placement.vectors(np.eye(2)[["xy".index(axis) for axis in freedom.axes]].reshape(-1, 2))
    return Handle((part,), placement.points([freedom.pivot])[0], axes, freedom.turns, soft_motions="kept")


def _carried(handle: Handle, placements: Mapping[Part, Placement], share: float) -> Handle:
    """A handle with a share of its load, where motions took it: its parts are at placements."""
    part = handle.parts[0]
    motion, point = placements[part].after(part.placement.inverse()), handle.load_point
    return replace(
        handle,
        pivot=motion.points([handle.pivot])[0],
        # the axes along which a body slides are its own, those of a handle that of space
        directions=motion.vectors(handle.directions) if part.body.freedom.n_motions else handle.directions,
        load=share * handle.load,
        load_point=None if point is None else motion.points([point])[0],
    )


def _gaps(system: ContactSystem, positions: Floats) -> Floats:
    """Minimum gap of each contact at positions of the surface nodes, infinite where nothing is within reach."""
    lin = system.linearise(positions, None)
    return np.array([float(pairs.gaps.min(initial=np.inf)) for pairs in lin.pairs])


def _penetrations(gaps: Floats) -> Floats:
    """Depths > 0 where gaps are negative, 0 elsewhere."""
    return np.abs(np.minimum(gaps, 0.0))


def _falls(system: ContactSystem, gaps: Floats, parts: Container[Part]) -> bool:
    """Whether contacts with friction are open at the start that parts on handles are to close."""
    return any(
        contact.friction_coefficient > 0.0
        and gap > ROUND_OFF * min(part.body.size for part in contact.parts)
        and any(part in parts for part in contact.parts)
        for contact, gap in zip(system.contacts, gaps.tolist(), strict=True)
    )


# --- Contact of bodies of nonlinear materials: Newton's method around the contact of their linearised bodies.


@dataclass(frozen=True, eq=False)
class NonlinearContact:
    """Bodies of nonlinear materials in contact.

    Parameters
    ----------
    contact
        The contact of the linearised bodies.
    displacements
        Of the nonlinear parts, (n_dofs, 2).
    status
        How the iteration of the bodies ended; where contacts were not solved, with their message.
    states
        What the nonlinear parts remember, where the next motion starts.

    """

    contact: ContactSolution
    displacements: dict[Part, Floats]
    status: Status
    states: dict[Part, MaterialState]

    @property
    def converged(self) -> bool:
        """Whether the last contact and the iteration of the bodies converged."""
        return self.status.converged

    @property
    def nodal_forces(self) -> Floats:
        """Contact forces on the surface nodes, shape (n_nodes, 2)."""
        return self.contact.state.nodal_forces


def press_nonlinear(
    contacts: Sequence[Contact],
    motion: Mapping[Part, Placement],
    materials: Mapping[Part, MaterialByCells],
    *,
    start: Mapping[Part, MaterialState] | None = None,
    steps: StepSettings | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 30,
) -> NonlinearContact:
    """Move parts against each other, some of them of nonlinear materials.

    In each iteration the nonlinear bodies are replaced by their tangents with the forces ``K u - r``, and the contact
    of these linear bodies is found from that of the iteration before; at the end it is that of the nonlinear ones. A
    tangent need not be definite, since contact may hold what it does not.

    Parameters
    ----------
    contacts, motion
        As of `press`; one motion, from the undeformed bodies. Friction starts at rest in each step.
    materials
        Nonlinear material of parts; the others stay elastic.
    start
        The `states` of the motion before; left out, the material has no history.
    steps
        Sizes of the steps of the motion; a step that does not converge is halved. Left out: one step.
    tolerance
        Change of the displacements over their maximum that ends the iteration.
    max_iterations
        Number of contacts that are solved in a step.

    Raises
    ------
    InputError
        If a part with a nonlinear material is no meshed body in plane strain, or has no contact, the start is not that
        of the same parts, the motion is a path, or `press` refuses the contacts.

    """
    system = ContactSystem(contacts)
    if not isinstance(motion, Mapping):
        raise refused("press_nonlinear", "motion", motion, "one motion {part: Placement(...)}", "give one at a time")
    if not isinstance(materials, Mapping) or not materials:
        raise refused("press_nonlinear", "materials", materials, "{part: NeoHooke(...)}", "take press without any")
    if not isinstance(steps, StepSettings | None):
        raise refused("press_nonlinear", "steps", steps, "StepSettings(...)", "leave it out")
    check_tolerance("press_nonlinear", tolerance)
    check_integer("press_nonlinear", "max_iterations", max_iterations, 1, advice="leave it out")
    _refuse_bad_inputs(system, [motion], {}, {}, ())
    bodies, states = {}, {}
    for part, material in materials.items():
        _refuse_without_contact(system, part, "a nonlinear material")
        if not isinstance(part.body, Body):
            raise InputError(f"a nonlinear material of {part.name!r}", "a meshed Body", "make it of mesh and element")
        bodies[part] = NonlinearBody(part.body.elasticity, material)
        states[part] = bodies[part].start() if start is None else _start_of(part, bodies[part], start)

    def solve_at(fraction: float, reached: NonlinearContact | None) -> NonlinearContact:
        return _pressed(contacts, motion, fraction, bodies, reached or states, tolerance, max_iterations)

    return follow(solve_at, None, steps or StepSettings(smallest=1.0 / 64.0))


def _start_of(part: Part, body: NonlinearBody, start: Mapping[Part, MaterialState]) -> MaterialState:
    """State of a part where a motion starts."""
    state, fresh = start.get(part) if isinstance(start, Mapping) else None, body.start()
    if not isinstance(state, MaterialState) or state.displacements.shape != fresh.displacements.shape:
        raise refused(
            "press_nonlinear", "start", start, f"the states of the motion before, with {part.name!r}", "leave it out"
        )
    return state


def _pressed(
    contacts: Sequence[Contact],
    motion: Mapping[Part, Placement],
    fraction: float,
    bodies: Mapping[Part, NonlinearBody],
    reached: NonlinearContact | Mapping[Part, MaterialState],
    tolerance: float,
    max_iterations: int,
) -> NonlinearContact:
    """Newton's method for nonlinear bodies at a fraction of a motion, from a solution or from states.

    A loop of its own: each step is a whole contact problem; where steps do not converge `follow` shortens the motion.
    """
    if isinstance(reached, NonlinearContact):
        states, fields, solution = reached.states, reached.displacements, reached.contact
    else:
        states, fields, solution = dict(reached), {part: state.displacements for part, state in reached.items()}, None
    change, failure, works = np.inf, "", np.zeros(2)
    for iteration in range(1, max_iterations + 1):  # noqa: B007 (used after the loop)
        tangents = {part: body.linearised(states[part], fields[part]) for part, body in bodies.items()}
        works = sum((of_body for _, _, of_body in tangents.values()), np.zeros(2))
        if turned := [part.name for part, (_, forces, _) in tangents.items() if not np.isfinite(forces).all()]:
            failure = f"; a point of {turned[0]!r} is turned inside out"
            break
        try:
            solution, linear = _linear_contact(contacts, motion, fraction, bodies, fields, tangents, solution)
        except (InputError, ArithmeticError) as error:
            if solution is None:
                raise
            failure = f"; its tangent is singular: {str(error).splitlines()[0]}"
            break
        if not solution.status.converged:
            failure = f"; the contact is {solution.status.message}"
            break
        after = {part: solution.field(linear[part]).displacements for part in bodies}
        size = max(max_magnitude(displaced) for displaced in after.values()) or 1.0
        change = max(max_magnitude(after[part] - fields[part]) for part in bodies) / size
        fields = after
        if not change > tolerance:
            solution = solution.checked([(placement, None) for placement in solution.state.placements])
            failure = "" if solution.status.converged else f"; the contact is {solution.status.message}"
            break
    assert solution is not None
    converged = change <= tolerance and not failure
    if converged:
        states = {part: body.committed(states[part], fields[part]) for part, body in bodies.items()}
    message = f"displacements change by {change:.1e} of their maximum{failure}"
    status = Status(converged, message, iteration).with_stabilisation(float(works[1] / max(works.sum(), MIN_POSITIVE)))
    status = status.with_notices(*(body.locking(states[part]) for part, body in bodies.items()))
    return NonlinearContact(solution, fields, status, states)


def _linear_contact(
    contacts: Sequence[Contact],
    motion: Mapping[Part, Placement],
    fraction: float,
    bodies: Mapping[Part, NonlinearBody],
    fields: Mapping[Part, Floats],
    tangents: Mapping[Part, tuple[dict[int, Floats], Floats, Floats]],
    before: ContactSolution | None,
) -> tuple[ContactSolution, dict[Part, Part]]:
    """Contact of the linearised bodies, from that of the iteration before, and the linearised parts."""
    linear, loads = {}, {}
    for part, (matrices, forces, _) in tangents.items():
        names = "name", "mesh", "element", "held", "thickness", "springs"
        settings = {name: getattr(part.body, name) for name in names}
        body = LinearisedBody(material=bodies[part].problem.material, **settings, tangents=matrices)
        linear[part] = replace(part, body=body)
        offset = body.elasticity.stiffness().times(fields[part].ravel()).reshape(-1, 2) - forces
        loads[linear[part]] = loads_on(body, [GivenForces(offset)])
    surfaces = [[_on(surface, linear) for surface in contact.sides] for contact in contacts]
    system = ContactSystem(
        [
            replace(contact, secondary=secondary, primary=primary)
            for contact, (secondary, primary) in zip(contacts, surfaces, strict=True)
        ]
    )
    response, placed = SparseBodies(system.surface_nodes), tuple(part.placement for part in system.parts)
    motions = {linear.get(part, part): placement for part, placement in motion.items()}
    placements = _moved(system.parts, placed, motions, fraction)
    at_parts = dict(zip(system.parts, placements, strict=True))
    alone = [_handle_of(part, None) for part in system.parts]
    handles = [None if handle is None else _carried(handle, at_parts, 1.0) for handle in alone]
    loaded = response.loaded([loads.get(part) for part in system.parts], placements, 1.0)
    # slip is counted from the undeformed bodies
    friction = any(contact.friction_coefficient for contact in contacts)
    start = None if before is None or friction else before.state
    state = solve_contact(loaded, system, placements, handles=handles, start=start, origin=placed)
    steps = (LoadStep(fraction, state),)
    gaps = _gaps(system, response.undeformed(placed))
    return ContactSolution(system, response, state, steps, _penetrations(gaps)), linear


def _on(surface: Surface, now: Mapping[Part, Part]) -> Surface:
    """The surface on the linearised body."""
    return replace(surface, part=now.get(surface.part, surface.part))
