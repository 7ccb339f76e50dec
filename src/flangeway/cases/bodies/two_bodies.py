"""The general case: bodies of any shape with supports, loads, motions and contacts."""

import time
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from pydantic import Field

from flangeway.cases.bodies.bodies_checks import checked_bodies
from flangeway.cases.bodies.bodies_model import BodiesModel, BodyModel, build_bodies
from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult, summarise_bodies
from flangeway.cases.bodies.bodies_supports import support_rows
from flangeway.cases.bodies.bodies_tables import (
    BodyTable,
    ContactTable,
    HypothesisName,
    LoadTable,
    MotionTable,
    StepsTable,
    SupportTable,
)
from flangeway.cases.bodies.pressing import Pressed, press_loaded
from flangeway.cases.case import Progress, RunnableCase
from flangeway.contact import ContactSolution
from flangeway.errors import InputError
from flangeway.problems import Part
from flangeway.solve import ElasticitySolution, Status, solve_elasticity
from flangeway.types import Floats


class TwoBodiesCase(RunnableCase):
    """Bodies, one, two or more, in the plane; all places are in common axes, x to the right and y up."""

    name: ClassVar[str] = "two-bodies"
    title: ClassVar[str] = "Bodies of any shape with supports, loads, motions and contacts"
    essential: ClassVar[tuple[str, ...]] = ("thickness_mm", "hypothesis")
    example: ClassVar[Mapping[str, Any]] = {
        "bodies": [
            {
                "name": "cylinder",
                "young_MPa": 210e3,
                "poisson": 0.3,
                "disc": {"radius_mm": 40.0, "centre_mm": [0.0, 40.0], "half": "lower"},
                "method": "fem",
                "order": 1,
                "size_mm": 5.0,
                "fine": [{"at_mm": [[-1.5, 0.0], [1.5, 0.0]], "size_mm": 0.08, "growth": 0.15}],
            },
            {
                "name": "block",
                "rectangle": {"width_mm": 160.0, "height_mm": 80.0, "centre_mm": [0.0, -40.0]},
                "method": "vem",
                "order": 1,
                "size_mm": 8.0,
                "fine": [{"at_mm": [[-1.5, 0.0], [1.5, 0.0]], "size_mm": 0.1, "growth": 0.15}],
            },
        ],
        "supports": [{"body": "cylinder", "edges": "cut"}, {"body": "block", "edges": "bottom"}],
        "motions": [{"body": "cylinder", "push_N": [0.0, -2000.0]}],
        "contacts": [
            {
                "secondary": "cylinder",
                "secondary_edges": "rim",
                "secondary_box_mm": [-8.0, -1.0, 8.0, 2.0],
                "primary": "block",
                "primary_edges": "top",
                "primary_box_mm": [-10.0, -1.0, 10.0, 1.0],
            }
        ],
    }

    thickness_mm: float = Field(1.0, gt=0.0, description="length of all bodies out of the plane")
    hypothesis: HypothesisName = Field("plane-strain", description="no strain, or no stress, out of the plane")
    bodies: list[BodyTable] = Field(description="the bodies: shape, mesh, elements and material of each")
    supports: list[SupportTable] = Field([], description="what is held, or moved by a given displacement")
    loads: list[LoadTable] = Field([], description="pressures, tractions, point forces and forces per volume")
    motions: list[MotionTable] = Field([], description="rigid motions of bodies in contact, or forces behind them")
    contacts: list[ContactTable] = Field([], description="pairs of surfaces that may touch, without friction")
    steps: StepsTable = Field(
        default_factory=lambda: StepsTable(number=1), description="how loads and motions are applied"
    )

    def check(self) -> None:
        """See `RunnableCase.check`; the bodies are meshed."""
        build_bodies(self)

    def run(self, progress: Progress = lambda _: None) -> BodiesRun:
        """See `RunnableCase.run`."""
        start = time.perf_counter()
        progress("meshing the bodies")
        model = build_bodies(self)
        meshed = time.perf_counter()
        alone = {name: _alone(body, progress) for name, body in model.bodies.items() if body.part is None}
        results = {name: BodyResult(solution) for name, solution in alone.items()}
        status = _worst([solution.status for solution in alone.values()])
        pressed: Pressed | None = None
        checks: tuple[str, ...] = ()
        if model.contacts:
            pressed = self._pressed(model, progress)
            in_contact, checks = checked_bodies(pressed, model)
            status = _worst([in_contact, status])
            for name, body in model.bodies.items():
                if body.part is not None:
                    results[name] = BodyResult(pressed.contact.field(body.part), pressed.placement(body.part))
        in_order = {name: results[name] for name in model.bodies}
        contact = None if pressed is None else pressed.contact
        timings = {"meshing": meshed - start, "total": time.perf_counter() - start}
        notices = [*model.notices, *_notices(contact), *checks]
        found = {} if pressed is None else _found(pressed, model)
        summary = summarise_bodies(self, status, in_order, contact, found, timings, notices)
        summary["supports"] = support_rows(self, model, in_order, contact) if status.converged else []
        return BodiesRun(self, status, summary, in_order, contact)

    def _pressed(self, model: BodiesModel, progress: Progress) -> Pressed:
        fields: dict[Part, Floats] = {}
        loads: dict[Part, Floats] = {}
        for body in model.bodies.values():
            if body.part is not None and body.moved_before_contact:
                progress(f"solving for {body.name} under its loads")
                # how well it balances is judged on the way out, together with the contact forces
                fields[body.part] = solve_elasticity(body.problem).displacements
                loads[body.part] = body.load_N
        progress("condensing the bodies to their surfaces")
        return press_loaded(
            model.contacts,
            motion=model.motion,
            fields=fields,
            push=model.push,
            loads=loads,
            n_steps=self.steps.number,
            progress=progress,
        )


def _worst(statuses: Sequence[Status]) -> Status:
    """The first that is of a failure; otherwise the first."""
    failed = [status for status in statuses if not status.converged]
    return [*failed, *statuses, Status(True, "the forces balance", 0)][0]


def _alone(body: BodyModel, progress: Progress) -> ElasticitySolution:
    """A body without contact."""
    if not body.problem.loads and not any(support.x or support.y for support in body.problem.prescribed):
        raise InputError(
            f"body {body.name!r}, which bears no load, no given displacement and no contact",
            "something that acts on each body",
            "add [[loads]], a displacement in [[supports]], or a contact",
        )
    progress(f"solving for {body.name}")
    return solve_elasticity(body.problem)


def _notices(contact: ContactSolution | None) -> list[str]:
    if contact is None:
        return []
    return [
        f"{each.secondary.part.name} on {each.primary.part.name}: the surfaces overlapped by {depth:.3g} mm before any "
        "motion; this is pressed out as if they had been brought there."
        for each, depth in zip(contact.system.contacts, contact.initial_penetration, strict=True)
        if depth > 1e-9 * contact.system.parts[0].body.elasticity.size
    ]


def _found(pressed: Pressed, model: BodiesModel) -> dict[str, Any]:
    rows: dict[str, Any] = {}
    if model.push is not None and model.push.force == 0.0:
        rows["sliding_body"] = model.push.part.name
        rows["slid_mm"] = [pressed.pushed * component for component in model.push.direction]
    elif model.push is not None:
        rows["pushed_body"] = model.push.part.name
        rows["push_N"] = [model.push.force * component for component in model.push.direction]
        rows["pushed_mm"] = pressed.pushed
    rows["forces"] = [
        {
            "body": body.name,
            "contact_N": pressed.force_on(body.part),
            "loads_N": body.load_N,
            "supports_N": -pressed.force_on(body.part) - body.load_N,
        }
        for body in model.bodies.values()
        if body.part is not None
    ]
    return rows
