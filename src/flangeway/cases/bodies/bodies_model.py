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
    fixed_point,
    free_axis,
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
    SupportTable,
    elastic,
)
from flangeway.cases.bodies.pressing import Push
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
from flangeway.problems import Body, BodyForce, Elasticity, Part, PointForce, PrescribedDisplacement, Pressure, Traction
from flangeway.problems.body import Components
from flangeway.problems.loads import Load
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

LOAD_KEYS = ("pressure_MPa", "traction_MPa", "force_N", "body_force_N_mm3")


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
    slides: Literal["x", "y"] | None = None  # axis along which its supports let it slide

    @property
    def moved_before_contact(self) -> bool:
        """Whether loads or prescribed displacements move it without contact."""
        given = any(s.x or s.y for s in self.problem.prescribed)
        return bool(self.problem.loads) or given


@dataclass(frozen=True, eq=False)
class BodiesModel:
    """All bodies, their contacts and their motions."""

    bodies: Mapping[str, BodyModel]  # bodies by name
    contacts: tuple[Contact, ...]  # contacts
    legs: tuple[Mapping[Part, Placement], ...]  # rigid motions of the supports of parts, one leg of the path each
    push: Push | None  # force on the supports of one part
    notices: tuple[str, ...]  # what was repaired or assumed

    @property
    def motion(self) -> Mapping[Part, Placement]:
        """Motions of the first leg."""
        return self.legs[0]

    @property
    def follows_path(self) -> bool:
        """Whether bodies are held by contact alone, friction acts, or there are several legs: `press` solves these."""
        floats = any(body.part is not None and not body.part.body.supported.any() for body in self.bodies.values())
        return floats or any(each.friction_coefficient for each in self.contacts) or len(self.legs) > 1


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
        bodies = {name: self._body(name, held[name], loads[name]) for name in self.tables}
        contacts = tuple(
            self._contact(table, f"contacts[{n}]", bodies) for n, table in enumerate(self.case.contacts, 1)
        )
        if contacts:
            ContactSystem(contacts)  # refuses contacts that do not go together, before anything is solved
        model = BodiesModel(bodies, contacts, *self._motions(bodies), tuple(self.notices))
        parts = [body.part for body in bodies.values() if body.part is not None]
        if parts and not any(part.body.supported.any() for part in parts):
            raise InputError(
                "bodies in contact of which none has supports",
                "supports of one of them at least",
                "add [[supports]]; to press a body by a force, fix it and add [[motions]] with push_N",
            )
        moved = [body for body in bodies.values() if body.part is not None and body.moved_before_contact]
        push = model.push
        if model.follows_path and (moved or (push is not None and (push.force == 0.0 or 0.0 not in push.direction))):
            raise InputError(
                f"loads or displacements of supports of body {moved[0].name!r}" if moved else "a push that is oblique",
                "with friction, bodies without supports, or several legs: motions of bodies, and push_N along x or y",
                "move or push the supports of a body instead",
            )
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

    def _load(self, table: LoadTable, key: str) -> Load:
        given = [name for name in LOAD_KEYS if getattr(table, name) is not None]
        if len(given) != 1:
            raise InputError(
                f"{key} with {' and '.join(given) or 'no load'}",
                f"one of {', '.join(LOAD_KEYS)}",
                "make each a [[loads]] of its own" if given else "add one of them",
            )
        kind = given[0]
        if table.cells is not None and kind != "body_force_N_mm3":
            raise InputError(f"{key}.cells with {kind}", "cells with body_force_N_mm3", "leave cells out")
        if kind == "body_force_N_mm3":
            if keys_of_place(table) or table.point_mm is not None:
                raise InputError(f"{key}.{kind} with a position", "the whole body, or cells", "leave the position out")
            if table.cells is not None:
                self.meshes[table.body].cell_set(table.cells)
            return BodyForce(table.body_force_N_mm3 or (0.0, 0.0), table.cells)
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
        area = float(np.linalg.norm(np.diff(mesh.points[pairs], axis=1), axis=-1).sum()) * self.case.thickness_mm
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

    def _body(self, name: str, held: list[tuple[SupportTable, Where]], loads: list[Load]) -> BodyModel:
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
            problem = Elasticity(space, material, thickness, loads, supports, name)
            return BodyModel(name, problem, None, problem.load_vector().sum(axis=0))
        components: dict[Where, Components] = {}
        for support, where in held:
            components[where] = "xy" if where in components and components[where] != support.hold else support.hold
        slides = free_axis(name, mesh, components) if held else None  # without any, contact alone holds it
        if slides is not None:
            hold = fixed_point(name, mesh, self._touching(name))
            components[hold] = slides
            supports.append(PrescribedDisplacement(hold, **{slides: 0.0}))
        body = Body(name, mesh, elements_of(table, mixed=name in self.mixed), material, components or None, thickness)
        problem = Elasticity(body.space, material, thickness, loads, supports, name)
        return BodyModel(name, problem, Part(name, body), problem.load_vector().sum(axis=0), slides)

    def _touching(self, name: str) -> Ints:
        """Points of a body that are on contact surfaces."""
        found = []
        for number, table in enumerate(self.case.contacts, 1):
            for role in ("secondary", "primary"):
                if getattr(table, role) == name:
                    edges, box = getattr(table, f"{role}_edges"), getattr(table, f"{role}_box_mm")
                    key = f"contacts[{number}]"
                    found.append(edges_at(self.meshes[name], name, edges, box, (None, None), key, f"{role}_edges"))
        return np.unique(np.vstack(found))

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

    def _motions(self, bodies: Mapping[str, BodyModel]) -> tuple[tuple[dict[Part, Placement], ...], Push | None]:
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
            motion = legs[table.leg - 1]
            if part in motion or (table.leg == 1 and push is not None and push.part is part):
                raise InputError(f"{key}.body = {table.body!r} for the second time", "one motion each", "join them")
            if not part.body.supported.any():
                raise InputError(
                    f"{key}.body = {table.body!r}, which has no supports", "bodies with supports", "contact moves it"
                )
            if table.push_N is None:
                motion[part] = _placement(table)
                continue
            moves = table.rotation_deg or table.shift_mm != (0.0, 0.0)
            if push is not None or table.leg > 1 or moves or table.push_N == (0.0, 0.0):
                raise InputError(
                    f"{key}.push_N = {list(table.push_N)}",
                    "one push in a case, in leg 1, of a force that is not zero, without shift and rotation",
                    "press one body by a force and fix or shift the others",
                )
            size = float(np.hypot(*table.push_N))
            push = Push(part, (table.push_N[0] / size, table.push_N[1] / size), size)
        return legs, self._sliding(bodies, push)

    def _sliding(self, bodies: Mapping[str, BodyModel], push: Push | None) -> Push | None:
        """Push of the one body that its supports let slide: none but its loads."""
        for body in bodies.values():
            if body.slides is None or body.part is None:
                continue
            load = float(body.load_N["xy".index(body.slides)])
            if push is not None or load == 0.0:
                raise InputError(
                    f"body {body.name!r}, whose supports let it slide in {body.slides}, "
                    + ("beside another one that is pushed" if push is not None else "without a load along it"),
                    "one sliding body, whose load is carried by contact",
                    f"fix it in {body.slides} as well, or give it a load along {body.slides}",
                )
            sign = float(np.sign(load))
            push = Push(body.part, (sign, 0.0) if body.slides == "x" else (0.0, sign), 0.0)
        return push


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
