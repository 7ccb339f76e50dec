"""From records to bodies, loads, supports and contacts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from flangeway.contact.contact_records import ROLES, BodiesProblem, ContactTable, MatchedPairing, Role, Shift
from flangeway.contact.surface import Surface
from flangeway.contact.system import Contact, ContactSystem
from flangeway.errors import InputError, located
from flangeway.geometry import Arc, Placement
from flangeway.geometry.arrays import chords_of, norms
from flangeway.mesh import PolyMesh
from flangeway.mesh.insertion import match_all
from flangeway.problems import Body, Elasticity, Part
from flangeway.problems.body import Components
from flangeway.problems.body_records import BodyShape, BodyTable, EdgesTable, PointTable, Where, body_shape
from flangeway.records import require_known
from flangeway.solve import Handle
from flangeway.solve.body_response import BodyLoad
from flangeway.solve.constraints import refuse_floating
from flangeway.space import Space
from flangeway.types import Floats

_Table = TypeVar("_Table")


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


def build_bodies(case: BodiesProblem) -> BodiesModel:
    """Mesh the bodies and find supports, loads and contact surfaces on them.

    It is an `InputError` if a name is unknown, a position has no edges, or keys contradict each other; the message
    names the table.
    """
    _refuse_names(case)
    shapes: dict[str, BodyShape] = {}
    notices: list[str] = []
    for key, table in numbered("bodies", case.bodies):
        with located(f"{key} {table.name!r}: ", unless="bodies["):
            shapes[table.name] = body_shape(table, key, notices)
    meshes = _matched(case, {name: shape.mesh for name, shape in shapes.items()})
    return _Builder(case, shapes, meshes).model(notices)


def _refuse_names(case: BodiesProblem) -> None:
    """Refuse two bodies of one name, and tables for bodies that are not there."""
    names = [body.name for body in case.bodies]
    for number, (key, body) in enumerate(numbered("bodies", case.bodies)):
        if body.name in names[:number]:
            raise InputError(f"{key}.name = {body.name!r} for the second time", "a name for each", "rename one")
    for group in ("supports", "springs", "loads", "motions", "contacts"):
        for key, table in numbered(group, getattr(case, group)):
            for role in ROLES if group == "contacts" else ("body",):
                require_known(f"{key}.{role}", getattr(table, role), names, "the bodies")


def _matched(case: BodiesProblem, meshes: dict[str, PolyMesh]) -> dict[str, PolyMesh]:
    """Meshes of bodies that have each other's nodes where their contact is node-to-node.

    Triangles with more nodes become virtual elements.
    """
    pairs, tables = [], {body.name: body for body in case.bodies}
    for key, table in numbered("contacts", case.contacts):
        if isinstance(table.pairing, MatchedPairing):
            for role in ROLES:
                name, edges, box, what = table.side(role)
                with located(f"{key}.{what}: "):
                    touching = meshes[name].edge_set(edges, within=box)
                meshes[name] = meshes[name].with_edge_set(f"{key}.{role}", touching)
            orders = [tables[name].order for name in (table.secondary, table.primary)]
            if orders[0] != orders[1]:
                raise InputError(
                    f"{key}.pairing = 'node-to-node' of bodies with order = {orders[0]} and order = {orders[1]}",
                    "one order for both bodies",
                    "change one of them, or take segment-to-segment",
                )
            pairs.append((table.secondary, f"{key}.secondary", table.primary, f"{key}.primary"))
    with located("contacts: "):
        meshes = match_all(meshes, pairs)
    for name, mesh in meshes.items():
        polygons = mesh.cell_sizes > 3
        if tables[name].method == "fem" and polygons.any():
            meshes[name] = mesh.with_cell_set("triangles", ~polygons).with_cell_set("polygons", polygons)
    return meshes


@dataclass(frozen=True)
class _Builder:
    """A case with its bodies, meshed."""

    case: BodiesProblem
    shapes: Mapping[str, BodyShape]
    meshes: Mapping[str, PolyMesh]

    def model(self, notices: list[str]) -> BodiesModel:
        bodies = {table.name: self._body(key, table) for key, table in numbered("bodies", self.case.bodies)}
        contacts = tuple(
            self._contact(table, key, bodies, notices) for key, table in numbered("contacts", self.case.contacts)
        )
        if contacts:
            ContactSystem(contacts)  # refuses contacts that do not go together, before anything is solved
        supported = tuple(table.body for table in self.case.supports)
        model = BodiesModel(bodies, contacts, *self._motions(bodies), supported, tuple(notices))
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

    def _body(self, key: str, table: BodyTable) -> BodyModel:
        case, name, mesh = self.case, table.name, self.meshes[table.name]
        groups = [numbered(group, getattr(case, group), name) for group in ("supports", "loads", "springs")]
        rows: list[tuple[str, Any]] = [row for group in groups for row in group]
        named = {at: row.edges_on(mesh, at) for at, row in rows if isinstance(row, EdgesTable)}
        mesh = replace(mesh, edge_sets={**mesh.edge_sets, **named})
        supports, springs = ([row.support(row.where(at)) for at, row in groups[number]] for number in (0, 2))
        loads = [
            row.load(row.where(at), self._area(mesh.points[named.get(at, mesh.boundary_edges[:0])]))
            for at, row in groups[1]
        ]
        element, material = table.element(mesh), table.material(case.hypothesis)
        for cells in table.materials:
            require_known(f"{key}.materials", cells, sorted(mesh.cell_sets), "cell sets")
        part = None
        if any(name in (contact.secondary, contact.primary) for contact in case.contacts):
            held: dict[Where, Components] = {}
            for support in supports:
                fixed = {axis for axis in "xy" if getattr(support, axis) is not None}
                held[support.where] = "".join(sorted(fixed.union(held.get(support.where, ""))))  # type: ignore[assignment]
            part = Part(name, Body(name, mesh, element, material, held or None, case.thickness_mm, springs))
        problem = Elasticity(
            Space(mesh, element) if part is None else part.body.space, material, case.thickness_mm, name=name
        )
        for at, row in rows:
            if isinstance(row, PointTable):
                with located(f"{at}.point_mm: "):
                    problem.node_at(row.point_mm)
        problem = replace(problem, loads=loads, supports=[*supports, *springs])
        return BodyModel(problem, part, problem.load_vector().sum(axis=0))

    def _area(self, ends: Floats) -> float:
        """Area of edges by their ends (n, 2 ends, 2), in a body of revolution all around the axis."""
        widths = 2.0 * np.pi * ends[:, :, 0].mean(axis=1) if self.case.hypothesis == "axisymmetric" else 1.0
        lengths = norms(chords_of(ends))
        return float((lengths * widths).sum()) * self.case.thickness_mm

    def _contact(self, table: ContactTable, key: str, bodies: Mapping[str, BodyModel], notices: list[str]) -> Contact:
        secondary, primary = (self._surface(table, role, key, bodies, notices) for role in ROLES)
        with located(f"{key}: "):
            contact = Contact(secondary, primary, table.pairing.pairing)
            law = table.enforcement.law(contact.suggested_penalty)
            return replace(contact, enforcement=law, friction=table.friction)

    def _surface(
        self, table: ContactTable, role: Role, key: str, bodies: Mapping[str, BodyModel], notices: list[str]
    ) -> Surface:
        name, edges, box, what = table.side(role)
        part = bodies[name].part
        assert part is not None
        with located(f"{key}.{what}: "):
            free, n_held = part.body.surface_edges(edges, box)
        if n_held and edges is not None:
            notices.append(
                f"{name}: {n_held} of the {n_held + len(free)} edges of its contact surface touch a support "
                "and are left out of the contact."
            )
        # left out, curved is true where the outline has arcs
        points = self.meshes[name].points[np.unique(free)]
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
        motions = self.case.motions
        n_legs = max((table.leg for table in motions), default=1)
        missing = set(range(2 if self.case.loads else 1, n_legs)) - {table.leg for table in motions}
        if missing:
            raise InputError(
                f"motions of leg {n_legs}, and none of leg {min(missing)}",
                "legs that follow each other; forces alone may be in leg 1",
                "number the legs without a gap",
            )
        legs: tuple[dict[Part, Placement], ...] = tuple({} for _ in range(n_legs))
        push = None
        for number, (key, table) in enumerate(numbered("motions", motions)):
            part = bodies[table.body].part
            of_body = f"{key}.body = {table.body!r}"
            if part is None:
                raise InputError(f"{of_body}, which is in no contact", "bodies in contact", "move its supports by x_mm")
            if any((table.body, table.leg) == (other.body, other.leg) for other in motions[:number]):
                raise InputError(f"{of_body} for the second time", "one motion each", "join them")
            if not part.body.supported.any():
                raise InputError(f"{of_body}, which has no supports", "bodies with supports", "contact moves it")
            if isinstance(table, Shift):
                legs[table.leg - 1][part] = table.placement
                continue
            if push is not None or not any(table.push_N):
                raise InputError(
                    f"{key}.push_N = {list(table.push_N)}",
                    "one push in a case, of a force that is not zero",
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


def numbered(group: str, tables: Sequence[_Table], body: str | None = None) -> list[tuple[str, _Table]]:
    """Tables behind how messages call them; those of one body alone."""
    keys = [(f"{group}[{number}]", table) for number, table in enumerate(tables, 1)]
    return [(key, table) for key, table in keys if body in (None, getattr(table, "body", None))]
