"""Bodies pressed against each other, whatever the pairing, the enforcement and the polygons."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.polygons import Case, faults, outcome
from flangeway.contact import (
    AugmentedLagrange,
    Contact,
    Multiplier,
    NodeToSegment,
    Penalty,
    SegmentToSegment,
    Surface,
)
from flangeway.contact import (
    press as press_parts,
)
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.post import pressure_patches
from flangeway.problems import Part
from flangeway.solve import StepSettings

PAIRINGS = [NodeToSegment(), SegmentToSegment(), SegmentToSegment(weighting="dual")]
LAWS = [Penalty(1e7, per="length"), AugmentedLagrange(1e6, per="length", penetration=1e-7), Multiplier()]
DOWN = Placement(0.0, (0.0, -0.05))


def contact_of(press, pairing, law, method: str = "fem") -> Contact:
    """The half disc of the shared fixture on its block, size 0.6 mm."""
    given = press(method, size=0.6).system.contacts[0]
    return Contact(given.secondary, given.primary, pairing, law)


@pytest.mark.parametrize(
    ("pairing", "law"),
    list(zip(PAIRINGS, LAWS, strict=True)),
    ids=["nodes-penalty", "segments-augmented", "dual-multiplier"],
)
def test_all_pairings_and_laws_agree_on_the_force(press, pairing, law) -> None:
    """A half disc on a block: every pairing and law gives the multipliers' force within 2 %, balanced to 1e-12."""
    contact = contact_of(press, pairing, law)
    motion = {contact.secondary.part: DOWN}
    solution = press_contacts(contact, motion)
    reference = press_contacts(contact_of(press, SegmentToSegment(), Multiplier()), None)
    assert solution.status.converged, solution.status.message
    assert solution.forces[0, 1] == pytest.approx(reference.forces[0, 1], rel=0.02)
    assert abs(solution.resultants.sum(axis=1)).max() < 1e-12 * abs(solution.resultants[..., :2]).max() * 60.0


def press_contacts(contact: Contact, motion, **settings):
    """Press the secondary part of one contact down."""
    return press_parts([contact], motion or {contact.secondary.part: DOWN}, **settings)


def test_a_softer_penalty_penetrates_in_proportion(press) -> None:
    """With segments the penetration times the penalty is the pressure at every node."""
    contact = contact_of(press, SegmentToSegment(), Penalty(1e5, per="length"), "vem")
    solution = press_contacts(contact, None)
    (patch,) = pressure_patches(solution.system, solution.state)
    gaps = solution.state.linearisation.gaps[solution.state.forces > 0.0]
    np.testing.assert_allclose(patch.pressures, -1e5 * gaps, rtol=1e-8)
    assert patch.normal_forces.sum() == pytest.approx(solution.state.forces.sum(), rel=1e-12)


def test_the_answer_does_not_depend_on_the_load_steps(press) -> None:
    """Ten equal steps and one step end at the same displacements to 1e-9; all ten are kept, with rising force."""
    contact = contact_of(press, SegmentToSegment(), Multiplier())
    at_once = press_contacts(contact, None)
    stepped = press_contacts(contact, None, steps=StepSettings(first=0.1, maximum=0.1), response=at_once.response)
    assert [step.share for step in stepped.steps] == pytest.approx(np.linspace(0.1, 1.0, 10))
    force = [step.state.forces.sum() for step in stepped.steps]
    assert (np.diff(force) > 0.0).all()
    np.testing.assert_allclose(stepped.state.displacements, at_once.state.displacements, atol=1e-10)


def test_initial_penetration_is_reported(press) -> None:
    """A block that stands 0.02 mm into the other before any motion is reported with that depth."""
    given = press("fem", size=0.6)
    contact = given.system.contacts[0]
    solution = press_contacts(contact, {contact.secondary.part: Placement(0.0, (0.0, 0.0))})
    assert solution.initial_penetration[0] == pytest.approx(0.0, abs=1e-9)
    lower = press("fem", size=0.6, whole=Placement(0.0, (0.0, 0.0)))
    shifted = lower.system.contacts[0]
    moved = type(shifted.secondary.part)("disc", shifted.secondary.part.body, Placement(0.0, (0.0, -0.02)))
    surface = type(shifted.secondary)(moved, shifted.secondary.edges)
    deep = press_contacts(Contact(surface, shifted.primary, NodeToSegment(), Multiplier()), {moved: Placement()})
    assert deep.initial_penetration[0] == pytest.approx(0.02, rel=1e-6)


@pytest.mark.parametrize(("penetration", "converges"), [(1e-9, True), (1e-90, False)])
def test_an_augmented_lagrangian_reaches_what_round_off_lets_it(press, penetration: float, converges: bool) -> None:
    """A penalty of a hundredth of the bodies' stiffness reaches 1e-9 mm; a tolerance below round-off is said to be."""
    law = AugmentedLagrange(1e3, per="length", penetration=penetration)
    steps = StepSettings(smallest=1.0)
    solution = press_contacts(contact_of(press, SegmentToSegment(), law), None, steps=steps)
    assert solution.status.converged is converges
    assert ("a larger tolerance" in solution.status.message) is not converges
    gaps = solution.state.linearisation.gaps[solution.state.forces > 0.0]
    assert np.abs(gaps).max() < 1e-9


def in_plane_stress(surface: Surface) -> Surface:
    """The surface of a body of the same mesh in plane stress."""
    body = replace(surface.part.body, material=Elastic(210e3, 0.3, "plane_stress"))
    return Surface(replace(surface.part, body=body), surface.edges)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda s, p: Contact(s, p, SegmentToSegment(), Penalty(1e5, per="node")), "per='length'"),
        (lambda s, p: Contact(s, p, NodeToSegment(), Penalty(None, per="node")), "start with Penalty\\(.*, per='node'"),
        (
            lambda s, p: Contact(s, p, SegmentToSegment(), AugmentedLagrange(None, "length", 1e-6)),
            "start with AugmentedLagrange\\(",
        ),
        (lambda _s, _p: SegmentToSegment(weighting="lumped"), "'standard' or 'dual'"),
        (lambda _s, _p: AugmentedLagrange(1e5, "length", 0.0), "positive length"),
        (lambda _s, _p: Penalty(-1.0, per="length"), "positive number"),
        (lambda _s, _p: Penalty(1.0, per="area"), "'node' or 'length'"),
        (lambda _s, _p: StepSettings(first=0.5, maximum=0.1), "first <= maximum"),
        (lambda s, p: press_parts([Contact(s, p, NodeToSegment(), Multiplier())], {}, path="dense"), "'condensed' or"),
        (
            lambda s, p: press_parts(
                [Contact(s, p, NodeToSegment(), Multiplier())], {s.part: Placement(mirrored=True)}
            ),
            "mirror the part itself",
        ),
        (
            lambda s, p: press_parts([Contact(s, p, NodeToSegment(), Multiplier())], {s.part.name: DOWN}),
            "a Placement by its Part",
        ),
        (lambda s, p: Contact(s, in_plane_stress(p), NodeToSegment(), Multiplier()), "both in plane strain"),
        (lambda s, p: press_parts(Contact(s, p, NodeToSegment(), Multiplier()), {}), "a list of at least one Contact"),
        (lambda s, p: press_parts([Contact(s, p, NodeToSegment(), Multiplier())], []), "a path of at least one"),
        (
            lambda s, p: press_parts([Contact(s, p, NodeToSegment(), Multiplier())], {}, loads=[(0.0, 1.0, 0.0)]),
            "a dictionary by part",
        ),
        (
            lambda s, p: press_parts([Contact(s, p, NodeToSegment(), Multiplier())], {}, response=SegmentToSegment()),
            "an earlier press",
        ),
        (lambda s, _p: Surface(s.part.body, s.edges), "a Part"),
        (lambda s, _p: Surface(s.part, s.edges, curve="rim"), "an Outline"),
        (lambda s, _p: Part("block", s.part.body, 3.0), r"Placement\(...\)"),
        (lambda _s, _p: Part("block", None), "Body"),
        (lambda s, _p: replace(s.part.body, held=["top"]), "the name of an edge set"),
        (lambda s, _p: replace(s.part.body, material="steel"), "a material"),
        (lambda s, _p: replace(s.part.body, springs=None), "a list of Spring"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(press, make, message: str) -> None:
    """Each combination that makes no sense raises an error that names it and what to do."""
    contact = press("fem", size=0.6).system.contacts[0]
    with pytest.raises(InputError, match=message):
        make(contact.secondary, contact.primary)


def test_the_suggested_penalty_works(press) -> None:
    """The penalty that the message suggests penetrates less than 5 % of the approach and gives the force within 3 %."""
    given = contact_of(press, SegmentToSegment(), Multiplier())
    law = Penalty(given.suggested_penalty, per="length")
    solution = press_contacts(Contact(given.secondary, given.primary, SegmentToSegment(), law), None)
    exact = press_contacts(given, None)
    assert -solution.state.linearisation.gaps.min() < 0.05 * 0.05
    assert solution.forces[0, 1] == pytest.approx(exact.forces[0, 1], rel=0.03)


@pytest.mark.parametrize("pairing", PAIRINGS[::2], ids=["nodes", "dual"])
def test_a_step_deeper_than_the_elements_keeps_the_contact(press, pairing) -> None:
    """Pressed 1.5 mm at once, five times the elements, the disc ends with force and without penetration."""
    contact = contact_of(press, pairing, Multiplier())
    solution = press_contacts(contact, {contact.secondary.part: Placement(0.0, (0.0, -1.5))})
    assert solution.status.converged
    assert solution.state.forces.sum() > 0.0
    assert solution.state.linearisation.gaps.min() > -1e-9


def in_ci(*numbers: int) -> list:
    """Cases that take a second or more each."""
    return [pytest.param(number, marks=pytest.mark.ci) for number in numbers]


@pytest.mark.parametrize("number", [3, 5, *in_ci(1, 6, 9, 10)])
def test_what_converged_is_right(number: int) -> None:
    """Bodies do not overlap, forces balance and carry the load, nothing pulls, friction dissipates."""
    assert not outcome(number).wrong


@pytest.mark.ci
def test_contact_that_comes_and_goes_under_all_of_a_load_holds_it_after_shorter_steps() -> None:
    """A corner with friction and a barrier is reached in steps, although one step ends where nothing touches."""
    found = outcome(22)
    assert found.converged, found.message
    assert found.touches
    assert not found.wrong


def test_the_judge_sees_a_wrong_solution() -> None:
    """To a solution without fault a load that is one per cent larger is a fault."""
    number = next(n for n in range(100) if Case.of(n).drive == "slide")
    case = Case.of(number)
    solution = case.solve()
    assert solution.status.converged
    assert list(faults(solution, case)) == []
    assert any("load" in each for each in faults(solution, replace(case, depth=1.01 * case.depth)))


@pytest.mark.parametrize("number", [69, *in_ci(40, 105, 200, 212, 332)])
def test_a_corner_that_is_pressed_by_a_load_on_a_handle_stays_outside(number: int) -> None:
    """Sharp corners under loads on handles: from step to step they stay on the face that they press on."""
    found = outcome(number)
    assert found.converged, found.message
    assert found.touches
    assert not found.wrong
