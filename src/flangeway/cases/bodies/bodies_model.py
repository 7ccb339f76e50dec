"""From the tables of a case file to bodies, loads, supports and contacts."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flangeway.cases.bodies.bodies_shape import (
    BodyShape,
    Where,
    body_shape,
    edges_at,
    free_edges,
    keys_of_place,
    point_at,
)
from flangeway.cases.bodies.bodies_tables import (
    BodiesInputs,
    BodyTable,
    ContactTable,
    LoadTable,
    MotionTable,
    PlaceTable,
    SpringTable,
    SupportTable,
    elastic,
)
from flangeway.cases.case import closest
from flangeway.contact import (
    AugmentedLagrange,
    Barrier,
    Contact,
    ContactSystem,
    Multiplier,
    NodeToNode,
    NodeToSegment,
    Penalty,
    SegmentToSegment,
    Surface,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.elements import Element, Lagrange, TraceStabilisation, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Placement
from flangeway.materials import Material
from flangeway.mesh import PolyMesh
from flangeway.mesh.insertion import match_all
from flangeway.problems import (
    Body,
    BodyForce,
    Elasticity,
    Gravity,
    Part,
    PointForce,
    PrescribedDisplacement,
    Pressure,
    Spring,
    TemperatureChange,
    Traction,
)
from flangeway.problems.body import Components
from flangeway.problems.loads import Load
from flangeway.solve import Handle
from flangeway.solve.body_loads import BodyLoad
from flangeway.solve.free_motions import refuse_floating
from flangeway.space import Space
from flangeway.types import Floats

Ints = NDArray[np.int32]

USED_BY = (
    ("enforcement", ("penalty", "augmented-lagrange"), ("penalty_MPa_mm", "nodal_penalty_N_per_mm")),
    ("enforcement", ("augmented-lagrange",), ("penetration_mm",)),
    ("enforcement", ("barrier",), ("barrier_N_per_mm", "barrier_reach_mm")),
    ("pairing", ("segment-to-segment",), ("weighting",)),
    ("pairing", ("node-to-segment",), ("slack",)),
)
"""Choice of a contact, the values of it that use further inputs, and these."""

LOAD_KEYS = ("pressure_MPa", "traction_MPa", "force_N", "body_force_N_mm3", "gravity_m_s2", "temperature_K")
WHOLE_BODY = ("body_force_N_mm3", "gravity_m_s2", "temperature_K")
MM_PER_M = 1e3


def elements_of(body: BodyTable, *, mixed: bool = False) -> Element | dict[str, Element]:
    """Elements of a body, by cell set where they differ; `mixed` of triangles some of which have got more nodes."""
    virtual = Virtual(body.order, TraceStabilisation() if body.stabilisation == "trace" else None)
    if body.method != "fem":
        return virtual
    lagrange = Lagrange(body.order)
    return {"triangles": lagrange, "polygons": virtual} if mixed or body.halved_side is not None else lagrange


@dataclass(frozen=True, eq=False)
class BodyModel:
    """One body with its supports and loads, in contact or not."""

    name: str  # its name
    problem: Elasticity  # elastic problem with supports and loads, without contact
    part: Part | None  # the body in contact; None without contact
    load_N: Floats  # noqa: N815 (the unit newton)
    """Resultant of the loads, shape (2,)."""

    @property
    def loads(self) -> list[BodyLoad]:
        """Loads and displacements of supports that are not zero."""
        return [*self.problem.loads, *(each for each in self.problem.prescribed if each.x or each.y)]


@dataclass(frozen=True, eq=False)
class BodiesModel:
    """All bodies, their contacts and their motions."""

    bodies: Mapping[str, BodyModel]  # bodies by name
    contacts: tuple[Contact, ...]  # contacts
    legs: tuple[Mapping[Part, Placement], ...]  # rigid motions of the supports of parts, one leg of the path each
    push: Handle | None  # force on the supports of one part, which slide along it
    notices: tuple[str, ...]  # what was repaired or assumed

    @property
    def motion(self) -> Mapping[Part, Placement]:
        """Motions of the first leg."""
        return self.legs[0]

    @property
    def body_loads(self) -> dict[Part, list[BodyLoad]]:
        """Loads of the bodies in contact."""
        return {body.part: body.loads for body in self.bodies.values() if body.part is not None and body.loads}


def build_bodies(case: BodiesInputs) -> BodiesModel:
    """Mesh the bodies and find supports, loads and contact surfaces on them.

    It is an `InputError` if a name is unknown, a position has no edges, or keys contradict each other; the message
    names the table.
    """
    return _Builder(case).model()


class _Builder:
    """One call of `build_bodies`."""

    def __init__(self, case: BodiesInputs) -> None:
        self.case = case
        self.notices: list[str] = []
        self.tables = {body.name: body for body in case.bodies}
        if not case.bodies:
            raise InputError("bodies = []", "one body or more", "add [[bodies]] with a name and a shape")
        names = [body.name for body in case.bodies]
        for number, body in enumerate(case.bodies):
            if body.name in names[:number]:
                raise InputError(
                    f"bodies[{number + 1}].name = {body.name!r} for the second time", "a name for each", "rename one"
                )
        self.shapes: dict[str, BodyShape] = {}
        self.meshes: dict[str, PolyMesh] = {}
        self.mixed: set[str] = set()
        self.in_contact = {name for table in case.contacts for name in (table.secondary, table.primary)}

    def model(self) -> BodiesModel:
        self._refuse_unknown()
        for number, table in enumerate(self.case.bodies, 1):
            key = f"bodies[{number}]"
            try:
                self.shapes[table.name] = body_shape(table, key, self.notices)
                self.meshes[table.name] = self.shapes[table.name].mesh
            except InputError as reason:
                if reason.given.startswith("bodies["):
                    raise
                raise InputError(f"{key} {table.name!r}: {reason.given}", reason.allowed, reason.advice) from reason
        self._match_boundaries()
        held = {name: self._held(name) for name in self.tables}
        loads = {name: self._loads(name) for name in self.tables}
        springs = {name: self._springs(name) for name in self.tables}
        bodies = {name: self._body(name, held[name], loads[name], springs[name]) for name in self.tables}
        contacts = tuple(
            self._contact(table, f"contacts[{n}]", bodies) for n, table in enumerate(self.case.contacts, 1)
        )
        if contacts:
            ContactSystem(contacts)  # refuses contacts that do not go together, before anything is solved
        model = BodiesModel(bodies, contacts, *self._motions(bodies), tuple(self.notices))
        parts = [body.part for body in bodies.values() if body.part is not None]
        on_springs = {table.body for table in self.case.springs}
        if parts and not any(part.body.supported.any() or part.name in on_springs for part in parts):
            raise InputError(
                "bodies in contact of which none has supports or springs",
                "supports of one of them at least",
                "add [[supports]]; to press a body by a force, fix it and add [[motions]] with push_N",
            )
        for part in parts:
            refuse_floating(part.body)
        return model

    def _match_boundaries(self) -> None:
        """Give bodies in node-to-node contact each other's nodes; triangles with more nodes become virtual elements."""
        pairs = []
        for number, table in enumerate(self.case.contacts, 1):
            if table.pairing != "node-to-node":
                continue
            key, names = f"contacts[{number}]", []
            for role in ("secondary", "primary"):
                name, edges, box = (getattr(table, f"{role}{end}") for end in ("", "_edges", "_box_mm"))
                found = edges_at(self.meshes[name], name, edges, box, (None, None), key, f"{role}_edges")
                self.meshes[name] = self.meshes[name].with_edge_set(f"{key}.{role}", found)
                names += [name, f"{key}.{role}"]
            orders = [self.tables[name].order for name in names[::2]]
            if orders[0] != orders[1]:
                raise InputError(
                    f"{key}.pairing = 'node-to-node' of bodies with order = {orders[0]} and order = {orders[1]}",
                    "one order for both bodies",
                    "change one of them, or take segment-to-segment",
                )
            pairs.append(names)
        try:
            self.meshes = match_all(self.meshes, [(a, b, c, d) for a, b, c, d in pairs])
        except InputError as reason:
            raise InputError(f"contacts: {reason.given}", reason.allowed, reason.advice) from reason
        for name in {each for names in pairs for each in names[::2]}:
            polygons = self.meshes[name].cell_sizes > 3
            if self.tables[name].method == "fem" and polygons.any():
                self.mixed.add(name)
                mesh = self.meshes[name].with_cell_set("triangles", ~polygons)
                self.meshes[name] = mesh.with_cell_set("polygons", polygons)

    def _refuse_unknown(self) -> None:
        """Refuse tables for bodies that are not there."""
        rows = [(f"supports[{n}].body", table.body) for n, table in enumerate(self.case.supports, 1)]
        rows += [(f"springs[{n}].body", spring.body) for n, spring in enumerate(self.case.springs, 1)]
        rows += [(f"loads[{n}].body", load.body) for n, load in enumerate(self.case.loads, 1)]
        rows += [(f"motions[{n}].body", motion.body) for n, motion in enumerate(self.case.motions, 1)]
        for n, pair in enumerate(self.case.contacts, 1):
            rows += [(f"contacts[{n}].secondary", pair.secondary), (f"contacts[{n}].primary", pair.primary)]
        for key, name in rows:
            if name not in self.tables:
                known = list(self.tables)
                raise InputError(f"{key} = {name!r}", f"the bodies {', '.join(known)}", closest(name, known))

    def _held(self, name: str) -> list[tuple[SupportTable, Where]]:
        """Supports of a body with their edge sets or points."""
        found: list[tuple[SupportTable, Where]] = []
        for number, table in enumerate(self.case.supports, 1):
            if table.body != name:
                continue
            key = f"supports[{number}]"
            for component, value in (("x", table.x_mm), ("y", table.y_mm)):
                if value and component not in table.hold:
                    raise InputError(
                        f"{key}.{component}_mm = {value:g} with hold = {table.hold!r}",
                        "displacements of held components",
                        f'set hold = "xy" or "{component}", or leave {component}_mm out',
                    )
            found.append((table, self._place(table, table.point_mm, key)))
        return found

    def _loads(self, name: str) -> list[Load]:
        found: list[Load] = []
        for number, table in enumerate(self.case.loads, 1):
            if table.body == name:
                found.append(self._load(table, f"loads[{number}]"))
        return found

    def _springs(self, name: str) -> list[Spring]:
        found: list[Spring] = []
        for number, table in enumerate(self.case.springs, 1):
            if table.body == name:
                found.append(self._spring(table, f"springs[{number}]"))
        return found

    def _spring(self, table: SpringTable, key: str) -> Spring:
        where = self._place(table, table.point_mm, key)
        units = ("MPa_mm", "N_mm") if isinstance(where, str) else ("N_mm", "MPa_mm")
        own, other = ([getattr(table, f"{axis}_{unit}") for axis in "xy"] for unit in units)
        if other != [None, None] or own == [None, None]:
            raise InputError(
                f"{key} with x = {table.x_MPa_mm or table.x_N_mm} and y = {table.y_MPa_mm or table.y_N_mm}",
                f"x_{units[0]}, y_{units[0]} or both for {'edges' if isinstance(where, str) else 'a point'}",
                "give a stiffness in this unit",
            )
        return Spring(where, own[0] or 0.0, own[1] or 0.0)

    def _load(self, table: LoadTable, key: str) -> Load:
        given = [name for name in LOAD_KEYS if getattr(table, name) is not None]
        if len(given) != 1:
            raise InputError(
                f"{key} with {' and '.join(given) or 'no load'}",
                f"one of {', '.join(LOAD_KEYS)}",
                "make each a [[loads]] of its own" if given else "add one of them",
            )
        kind = given[0]
        if table.cells is not None and kind not in ("body_force_N_mm3", "temperature_K"):
            raise InputError(
                f"{key}.cells with {kind}", "cells with body_force_N_mm3 or temperature_K", "leave cells out"
            )
        if kind in WHOLE_BODY:
            if keys_of_place(table) or table.point_mm is not None:
                raise InputError(f"{key}.{kind} with a position", "the whole body, or cells", "leave the position out")
            if table.cells is not None:
                self.meshes[table.body].cell_set(table.cells)
            return _whole(table)
        where = self._place(table, table.point_mm, key)
        if not isinstance(where, str):
            if table.force_N is None:
                raise InputError(f"{key}.{kind} at a point", "force_N at a point", "give edges for it")
            return PointForce(where, table.force_N)
        if table.pressure_MPa is not None:
            return Pressure(where, table.pressure_MPa)
        if table.traction_MPa is not None:
            return Traction(where, table.traction_MPa)
        mesh = self.meshes[table.body]
        pairs = mesh.edge_sets[where]
        lengths = np.linalg.norm(np.diff(mesh.points[pairs], axis=1), axis=-1)[:, 0]
        around = 2.0 * np.pi * mesh.points[pairs, 0].mean(axis=1) if self.case.hypothesis == "axisymmetric" else 1.0
        area = float((lengths * around).sum()) * self.case.thickness_mm
        x, y = table.force_N or (0.0, 0.0)
        return Traction(where, (x / area, y / area))

    def _place(self, table: PlaceTable, point: tuple[float, float] | None, key: str) -> Where:
        """Name of an edge set made for a position, or a point."""
        given = keys_of_place(table)
        if point is not None:
            if given:
                raise InputError(f"{key}.point_mm with {' and '.join(given)}", "a point, or edges", "keep one of them")
            return point_at(self.meshes[table.body], self.tables[table.body].order, table.body, point, key)
        if not given:
            raise InputError(
                f"{key} without a position", "edges, at_x_mm, at_y_mm, box_mm or point_mm", "give one of these"
            )
        lines = (table.at_x_mm, table.at_y_mm)
        mesh = self.meshes[table.body]
        pairs = edges_at(mesh, table.body, table.edges, table.box_mm, lines, key, "edges")
        self.meshes[table.body] = mesh.with_edge_set(key, pairs)
        return key

    def _body(
        self, name: str, held: list[tuple[SupportTable, Where]], loads: list[Load], springs: list[Spring]
    ) -> BodyModel:
        table, mesh = self.tables[name], self.meshes[name]
        material = self._material(table, mesh)
        supports = [
            PrescribedDisplacement(
                where, support.x_mm if "x" in support.hold else None, support.y_mm if "y" in support.hold else None
            )
            for support, where in held
        ]
        thickness = self.case.thickness_mm
        if name not in self.in_contact:
            space = Space(mesh, elements_of(table, mixed=name in self.mixed))
            problem = Elasticity(space, material, thickness, loads, [*supports, *springs], name)
            return BodyModel(name, problem, None, problem.load_vector().sum(axis=0))
        components: dict[Where, Components] = {}
        for support, where in held:
            components[where] = "xy" if where in components and components[where] != support.hold else support.hold
        element = elements_of(table, mixed=name in self.mixed)
        body = Body(name, mesh, element, material, components or None, thickness, springs)
        problem = Elasticity(body.space, material, thickness, loads, [*supports, *springs], name)
        return BodyModel(name, problem, Part(name, body), problem.load_vector().sum(axis=0))

    def _material(self, table: BodyTable, mesh: PolyMesh) -> Material | Mapping[str, Material]:
        if not table.materials:
            return elastic(table, self.case.hypothesis)
        for name in table.materials:
            if name not in mesh.cell_sets:
                known = sorted(mesh.cell_sets)
                number = self.case.bodies.index(table) + 1
                raise InputError(f"bodies[{number}].materials.{name}", ", ".join(known), closest(name, known))
        return {name: elastic(each, self.case.hypothesis) for name, each in table.materials.items()}

    def _contact(self, table: ContactTable, key: str, bodies: Mapping[str, BodyModel]) -> Contact:
        for name, used_by, inputs in USED_BY:
            if getattr(table, name) not in used_by:
                table.refuse_without_effect(inputs, name, " or ".join(used_by), f"{key}.")
        sides = [self._surface(table, role, key, bodies) for role in ("secondary", "primary")]
        pairing = {
            "segment-to-segment": SegmentToSegment(weighting=table.weighting),
            "node-to-segment": NodeToSegment(slack=table.slack),
            "node-to-node": NodeToNode(),
        }[table.pairing]
        try:
            found = Contact(sides[0], sides[1], pairing, Multiplier())
            return replace(found, enforcement=_enforcement(table, found), friction=table.friction)
        except InputError as reason:
            raise InputError(f"{key}: {reason.given}", reason.allowed, reason.advice) from reason

    def _surface(self, table: ContactTable, role: str, key: str, bodies: Mapping[str, BodyModel]) -> Surface:
        name = getattr(table, role)
        edges, box = getattr(table, f"{role}_edges"), getattr(table, f"{role}_box_mm")
        part = bodies[name].part
        assert part is not None
        pairs = edges_at(self.meshes[name], name, edges, box, (None, None), key, f"{role}_edges")
        free = free_edges(part.body, pairs)
        if len(free) == 0:
            raise InputError(
                f"{key}.{role} = {name!r}: its whole surface is fixed", "a surface that can move", "shorten the support"
            )
        if len(free) < len(pairs) and edges is not None:
            self.notices.append(
                f"{name}: {len(pairs) - len(free)} of the {len(pairs)} edges of its contact surface touch a support "
                "and are left out of the contact."
            )
        pairs = free
        points = self.meshes[name].points[np.unique(pairs)]
        curve = self._curve(name, edges, points, table.curved, f"{key}.curved")
        try:
            return Surface(part, pairs, curve)
        except InputError as reason:
            raise InputError(f"{key}.{role}: {reason.given}", reason.allowed, reason.advice) from reason

    def _curve(
        self, name: str, edges: str | list[str] | None, points: Floats, wanted: bool | None, key: str
    ) -> Contour | None:
        """Drawn curve of a surface through points (n, 2), unless it is not wanted, or is left out and has no arcs."""
        if wanted is False:
            return None
        curve = self.shapes[name].curve([edges] if isinstance(edges, str) else edges, points)
        if curve is None and wanted:
            raise InputError(
                f"{key} = true for {name!r}, whose mesh came without an outline",
                "bodies whose outlines are given",
                "give its shape as an outline, or leave curved out and take elements far smaller than its radii",
            )
        if curve is None or not (wanted or any(isinstance(segment, Arc) for segment in curve.segments)):
            return None
        return curve

    def _motions(self, bodies: Mapping[str, BodyModel]) -> tuple[tuple[dict[Part, Placement], ...], Handle | None]:
        n_legs = max((table.leg for table in self.case.motions), default=1)
        legs: tuple[dict[Part, Placement], ...] = tuple({} for _ in range(n_legs))
        push = None
        for number, table in enumerate(self.case.motions, 1):
            key = f"motions[{number}]"
            part = bodies[table.body].part
            if part is None:
                raise InputError(
                    f"{key}.body = {table.body!r}, which is in no contact",
                    "bodies in contact",
                    "move its supports by x_mm",
                )
            if part in legs[table.leg - 1] or (table.leg == 1 and push is not None and part in push.parts):
                raise InputError(f"{key}.body = {table.body!r} for the second time", "one motion each", "join them")
            if not part.body.supported.any():
                raise InputError(
                    f"{key}.body = {table.body!r}, which has no supports", "bodies with supports", "contact moves it"
                )
            if table.push_N is None:
                legs[table.leg - 1][part] = _placement(table)
                continue
            moves = table.rotation_deg or table.shift_mm != (0.0, 0.0)
            if push is not None or table.leg > 1 or moves or table.push_N == (0.0, 0.0):
                raise InputError(
                    f"{key}.push_N = {list(table.push_N)}",
                    "one push in a case, in leg 1, of a force that is not zero, without shift and rotation",
                    "press one body by a force and fix or shift the others",
                )
            if part.body.freedom.n_motions:
                raise InputError(
                    f"{key}.push_N on body {table.body!r}, whose supports leave it free to move",
                    "a body whose supports hold it: the force acts on them",
                    "make the force one of [[loads]]",
                )
            force = np.array(table.push_N)
            direction, load = force / np.linalg.norm(force), np.append(force, 0.0)
            push = Handle((part,), np.zeros(2), direction[None], turns=False, load=load, soft_motions="kept")
        return legs, push


def _whole(table: LoadTable) -> Load:
    """Load of a whole body, or of cells of it."""
    if table.gravity_m_s2 is not None:
        x, y = table.gravity_m_s2
        return Gravity((MM_PER_M * x, MM_PER_M * y))
    if table.temperature_K is not None:
        return TemperatureChange(table.temperature_K, table.cells)
    return BodyForce(table.body_force_N_mm3 or (0.0, 0.0), table.cells)


def _placement(table: MotionTable) -> Placement:
    shift = Placement(0.0, table.shift_mm)
    return shift.after(Placement.about([table.centre_mm], float(np.deg2rad(table.rotation_deg))))


def _enforcement(table: ContactTable, contact: Contact) -> Enforcement:
    if table.enforcement == "multiplier":
        return Multiplier()
    if table.enforcement == "barrier":
        if table.barrier_N_per_mm is None or table.barrier_reach_mm is None:
            raise InputError(
                "a barrier without barrier_N_per_mm or barrier_reach_mm",
                "both",
                "start with a thousandth of the expected pressure times the approach, and the approach",
            )
        return Barrier(table.barrier_N_per_mm, table.barrier_reach_mm)
    if table.nodal_penalty_N_per_mm is not None and table.penalty_MPa_mm is not None:
        raise InputError("penalty_MPa_mm and nodal_penalty_N_per_mm", "one of both", "leave one out")
    penalty = table.nodal_penalty_N_per_mm or table.penalty_MPa_mm or contact.suggested_penalty
    per: Literal["node", "length"] = "length" if table.nodal_penalty_N_per_mm is None else "node"
    if table.enforcement == "penalty":
        return Penalty(penalty, per)
    return AugmentedLagrange(penalty, per, table.penetration_mm)
