"""From the tables of a case file to bodies, loads, supports and contacts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from flangeway.cases.bodies.bodies_shape import (
    BodiesInputs,
    BodyShape,
    BodyTable,
    ContactTable,
    LoadTable,
    PlaceTable,
    SpringTable,
    SupportTable,
    Where,
    body_shape,
    edges_at,
    elastic,
    keys_of_place,
    point_at,
)
from flangeway.contact import (
    Contact,
    ContactSystem,
    Surface,
)
from flangeway.elements import Element, Lagrange, TraceStabilisation, Virtual
from flangeway.errors import InputError, located
from flangeway.geometry import Arc, Placement
from flangeway.geometry.arrays import IntArray
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
from flangeway.problems.loads import AppliedLoad
from flangeway.records import require_known
from flangeway.solve import Handle
from flangeway.solve.body_response import BodyLoad
from flangeway.solve.constraints import refuse_floating
from flangeway.space import Space
from flangeway.types import Floats

_Row = TypeVar("_Row", SupportTable, LoadTable, SpringTable)

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

    problem: Elasticity  # elastic problem with supports and loads, without contact, named after the body
    part: Part | None  # the body in contact; None without contact
    load: Floats  # resultant of the loads, N, shape (2,)

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.problem.name

    @property
    def loads(self) -> list[BodyLoad]:
        """Loads and displacements of supports that are not zero."""
        return [*self.problem.loads, *(support for support in self.problem.prescribed if support.x or support.y)]


@dataclass(frozen=True, eq=False)
class BodiesModel:
    """All bodies, their contacts and their motions."""

    bodies: Mapping[str, BodyModel]  # bodies by name
    contacts: tuple[Contact, ...]  # contacts
    legs: tuple[Mapping[Part, Placement], ...]  # rigid motions of the supports of parts, one leg of the path each
    push: Handle | None  # force on the supports of one part, which slide along it
    supported: tuple[str, ...]  # name of the body of each table of supports
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
        self.shapes: dict[str, BodyShape] = {}
        self.meshes: dict[str, PolyMesh] = {}
        self.named: dict[str, dict[str, IntArray]] = {name: {} for name in self.tables}  # edges of supports and loads
        self.mixed: set[str] = set()
        self.in_contact = {name for table in case.contacts for name in (table.secondary, table.primary)}

    def model(self) -> BodiesModel:
        self._refuse_names()
        for number, table in enumerate(self.case.bodies, 1):
            key = f"bodies[{number}]"
            with located(f"{key} {table.name!r}: ", unless="bodies["):
                self.shapes[table.name] = body_shape(table, key, self.notices)
                self.meshes[table.name] = self.shapes[table.name].mesh
        self._match_boundaries()
        bodies = {name: self._body(name) for name in self.tables}
        contacts = tuple(
            self._contact(table, f"contacts[{n}]", bodies) for n, table in enumerate(self.case.contacts, 1)
        )
        if contacts:
            ContactSystem(contacts)  # refuses contacts that do not go together, before anything is solved
        supported = tuple(table.body for table in self.case.supports)
        model = BodiesModel(bodies, contacts, *self._motions(bodies), supported, tuple(self.notices))
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

    def _refuse_names(self) -> None:
        """Refuse a case without bodies, two bodies of one name, and tables for bodies that are not there."""
        if not self.case.bodies:
            raise InputError("bodies = []", "one body or more", "add [[bodies]] with a name and a shape")
        names = [body.name for body in self.case.bodies]
        for number, name in enumerate(names):
            if name in names[:number]:
                raise InputError(
                    f"bodies[{number + 1}].name = {name!r} for the second time", "a name for each", "rename one"
                )
        for group in ("supports", "springs", "loads", "motions", "contacts"):
            for number, table in enumerate(getattr(self.case, group), 1):
                for key in ("secondary", "primary") if group == "contacts" else ("body",):
                    require_known(f"{group}[{number}].{key}", getattr(table, key), names, "the bodies")

    def _match_boundaries(self) -> None:
        """Give bodies in node-to-node contact each other's nodes; triangles with more nodes become virtual elements."""
        pairs = []
        for number, table in enumerate(self.case.contacts, 1):
            if table.pairing.kind != "node-to-node":
                continue
            key = f"contacts[{number}]"
            for role, name in (("secondary", table.secondary), ("primary", table.primary)):
                mesh, edges = self.meshes[name], getattr(table, f"{role}_edges")
                with located(f"{key}.{role}{'' if edges is None else '_edges'}: "):
                    touching = mesh.edge_set(edges, within=getattr(table, f"{role}_box_mm"))
                self.meshes[name] = mesh.with_edge_set(f"{key}.{role}", touching)
            orders = [self.tables[name].order for name in (table.secondary, table.primary)]
            if orders[0] != orders[1]:
                raise InputError(
                    f"{key}.pairing = 'node-to-node' of bodies with order = {orders[0]} and order = {orders[1]}",
                    "one order for both bodies",
                    "change one of them, or take segment-to-segment",
                )
            pairs.append((table.secondary, f"{key}.secondary", table.primary, f"{key}.primary"))
        with located("contacts: "):
            self.meshes = match_all(self.meshes, pairs)
        for name in {name for pair in pairs for name in pair[::2]}:
            polygons = self.meshes[name].cell_sizes > 3
            if self.tables[name].method == "fem" and polygons.any():
                self.mixed.add(name)
                mesh = self.meshes[name].with_cell_set("triangles", ~polygons)
                self.meshes[name] = mesh.with_cell_set("polygons", polygons)

    def _rows(self, tables: Sequence[_Row], group: str, body: str) -> list[tuple[str, _Row]]:
        """Tables of a body, behind how messages call them."""
        return [(f"{group}[{number}]", table) for number, table in enumerate(tables, 1) if table.body == body]

    def _support(self, table: SupportTable, key: str) -> PrescribedDisplacement:
        given = {"x": table.x_mm, "y": table.y_mm}
        for component, value in given.items():
            if value and component not in table.hold:
                raise InputError(
                    f"{key}.{component}_mm = {value:g} with hold = {table.hold!r}",
                    "displacements of held components",
                    f'set hold = "xy" or "{component}", or leave {component}_mm out',
                )
        x, y = (given[axis] if axis in table.hold else None for axis in "xy")
        return PrescribedDisplacement(self._position(table, key), x, y)

    def _spring(self, table: SpringTable, key: str) -> Spring:
        where = self._position(table, key)
        units = ("MPa_mm", "N_mm") if isinstance(where, str) else ("N_mm", "MPa_mm")
        stiffness, other = ([getattr(table, f"{axis}_{unit}") for axis in "xy"] for unit in units)
        if other != [None, None] or stiffness == [None, None]:
            raise InputError(
                f"{key} with x = {table.x_MPa_mm or table.x_N_mm} and y = {table.y_MPa_mm or table.y_N_mm}",
                f"x_{units[0]}, y_{units[0]} or both for {'edges' if isinstance(where, str) else 'a point'}",
                "give a stiffness in this unit",
            )
        return Spring(where, stiffness[0] or 0.0, stiffness[1] or 0.0)

    def _load(self, table: LoadTable, key: str) -> AppliedLoad:
        given = [name for name in LOAD_KEYS if getattr(table, name) is not None]
        if len(given) != 1:
            raise InputError(
                f"{key} with {' and '.join(given) or 'no load'}",
                f"one of {', '.join(LOAD_KEYS)}",
                "make each a [[loads]] of its own" if given else "add one of them",
            )
        kind, mesh = given[0], self.meshes[table.body]
        if table.cells is not None and kind not in ("body_force_N_mm3", "temperature_K"):
            raise InputError(
                f"{key}.cells with {kind}", "cells with body_force_N_mm3 or temperature_K", "leave cells out"
            )
        if kind in WHOLE_BODY:
            if keys_of_place(table) or table.point_mm is not None:
                raise InputError(f"{key}.{kind} with a position", "the whole body, or cells", "leave the position out")
            if table.cells is not None:
                mesh.cell_set(table.cells)
            return _whole(table)
        where = self._position(table, key)
        if not isinstance(where, str):
            if table.force_N is None:
                raise InputError(f"{key}.{kind} at a point", "force_N at a point", "give edges for it")
            return PointForce(where, table.force_N)
        if table.pressure_MPa is not None:
            return Pressure(where, table.pressure_MPa)
        if table.traction_MPa is not None:
            return Traction(where, table.traction_MPa)
        ends = mesh.points[self.named[table.body][where]]  # (n, 2 ends, 2)
        widths = 2.0 * np.pi * ends[:, :, 0].mean(axis=1) if self.case.hypothesis == "axisymmetric" else 1.0
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        area = float((lengths * widths).sum()) * self.case.thickness_mm
        x, y = table.force_N or (0.0, 0.0)
        return Traction(where, (x / area, y / area))

    def _position(self, table: PlaceTable, key: str) -> Where:
        """Name of an edge set made for a position, or a point."""
        given, mesh = keys_of_place(table), self.meshes[table.body]
        if table.point_mm is not None:
            if given:
                raise InputError(f"{key}.point_mm with {' and '.join(given)}", "a point, or edges", "keep one of them")
            return point_at(mesh, self.tables[table.body].order, table.body, table.point_mm, key)
        if not given:
            raise InputError(
                f"{key} without a position", "edges, at_x_mm, at_y_mm, box_mm or point_mm", "give one of these"
            )
        self.named[table.body][key] = edges_at(mesh, table, key)
        return key

    def _body(self, name: str) -> BodyModel:
        case, table, thickness = self.case, self.tables[name], self.case.thickness_mm
        supports = [self._support(row, key) for key, row in self._rows(case.supports, "supports", name)]
        loads = [self._load(row, key) for key, row in self._rows(case.loads, "loads", name)]
        springs = [self._spring(row, key) for key, row in self._rows(case.springs, "springs", name)]
        mesh, element = self.meshes[name], elements_of(table, mixed=name in self.mixed)
        mesh = replace(mesh, edge_sets={**mesh.edge_sets, **self.named[name]})
        material: Material | Mapping[str, Material] = elastic(table, case.hypothesis)
        if table.materials:
            number = case.bodies.index(table) + 1
            for cells in table.materials:
                require_known(f"bodies[{number}].materials", cells, sorted(mesh.cell_sets), "cell sets")
            material = {cells: elastic(inner, case.hypothesis) for cells, inner in table.materials.items()}
        part = None
        if name in self.in_contact:
            components: dict[Where, Components] = {}
            for support, row in zip(supports, self._rows(case.supports, "supports", name), strict=True):
                hold = row[1].hold
                components[support.where] = "xy" if components.get(support.where, hold) != hold else hold
            part = Part(name, Body(name, mesh, element, material, components or None, thickness, springs))
        space = Space(mesh, element) if part is None else part.body.space
        problem = Elasticity(space, material, thickness, loads, [*supports, *springs], name)
        return BodyModel(problem, part, problem.load_vector().sum(axis=0))

    def _contact(self, table: ContactTable, key: str, bodies: Mapping[str, BodyModel]) -> Contact:
        secondary, primary = (self._surface(table, role, key, bodies) for role in ("secondary", "primary"))
        with located(f"{key}: "):
            contact = Contact(secondary, primary, table.pairing.pairing)
            law = table.enforcement.law(contact.suggested_penalty)
            return replace(contact, enforcement=law, friction=table.friction)

    def _surface(self, table: ContactTable, role: str, key: str, bodies: Mapping[str, BodyModel]) -> Surface:
        name, edges, part = getattr(table, role), getattr(table, f"{role}_edges"), bodies[getattr(table, role)].part
        assert part is not None
        with located(f"{key}.{role}{'' if edges is None else '_edges'}: "):
            free, n_held = part.body.surface_edges(edges, getattr(table, f"{role}_box_mm"))
        if n_held and edges is not None:
            self.notices.append(
                f"{name}: {n_held} of the {n_held + len(free)} edges of its contact surface touch a support "
                "and are left out of the contact."
            )
        points = self.meshes[name].points[np.unique(free)]
        # left out, curved is true where the outline has arcs
        curve = None if table.curved is False else self.shapes[name].curve(edges, points)
        if curve is None and table.curved and self.meshes[name].curves is None:
            raise InputError(
                f"{key}.curved = true for {name!r}, whose mesh came without curves",
                "bodies with an outline, or with curved sides of second order in the mesh file",
                "give its shape as an outline, or export cells of second order",
            )
        if curve is not None and not table.curved and not any(isinstance(side, Arc) for side in curve.segments):
            curve = None
        with located(f"{key}.{role}: "):
            return Surface(part, free, curve)

    def _motions(self, bodies: Mapping[str, BodyModel]) -> tuple[tuple[dict[Part, Placement], ...], Handle | None]:
        n_legs = max((table.leg for table in self.case.motions), default=1)
        missing = set(range(2 if self.case.loads else 1, n_legs)) - {table.leg for table in self.case.motions}
        if missing:
            raise InputError(
                f"motions of leg {n_legs}, and none of leg {min(missing)}",
                "legs that follow each other; forces alone may be in leg 1",
                "number the legs without a gap",
            )
        legs: tuple[dict[Part, Placement], ...] = tuple({} for _ in range(n_legs))
        push = None
        for number, table in enumerate(self.case.motions, 1):
            key, part = f"motions[{number}]", bodies[table.body].part
            of_body = f"{key}.body = {table.body!r}"
            if part is None:
                raise InputError(f"{of_body}, which is in no contact", "bodies in contact", "move its supports by x_mm")
            if part in legs[table.leg - 1] or (table.leg == 1 and push is not None and part in push.parts):
                raise InputError(f"{of_body} for the second time", "one motion each", "join them")
            if not part.body.supported.any():
                raise InputError(f"{of_body}, which has no supports", "bodies with supports", "contact moves it")
            if table.push_N is None:
                turn = Placement.about([table.centre_mm], float(np.deg2rad(table.rotation_deg)))
                legs[table.leg - 1][part] = Placement(0.0, table.shift_mm).after(turn)
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


def _whole(table: LoadTable) -> AppliedLoad:
    """AppliedLoad of a whole body, or of cells of it."""
    if table.gravity_m_s2 is not None:
        x, y = table.gravity_m_s2
        return Gravity((MM_PER_M * x, MM_PER_M * y))
    if table.temperature_K is not None:
        return TemperatureChange(table.temperature_K, table.cells)
    return BodyForce(table.body_force_N_mm3 or (0.0, 0.0), table.cells)
