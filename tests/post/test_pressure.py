"""Contact pressure from nodal forces, pressures that oscillate, and overlaps of undeformed boundaries."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flangeway.cases.bodies.bodies_run import TwoBodiesCase
from flangeway.cases.bodies.presets import HertzCase
from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, solve_contact
from flangeway.contact import press as press_parts
from flangeway.contact.solution_checks import Boundary, passes_through
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, circle
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid, triangulate
from flangeway.post import pressure_patches
from flangeway.post.pressure import oscillation_of
from flangeway.problems import Body, Part
from flangeway.report.bodies_page import results_table
from flangeway.report.case_outputs import write_case
from flangeway.solve import CondensedBodies


@pytest.mark.parametrize("primary", ["block", "disc"])
def test_a_patch_carries_the_whole_force(press, primary: str) -> None:
    """One patch: its pressures times areas are the contact force, centred where the disc points."""
    problem = press("vem", primary=primary)
    response = CondensedBodies(problem.system.surface_nodes)
    state = solve_contact(response, problem.system, problem.placements(0.05, shift=0.4))
    (patch,) = pressure_patches(problem.system, state)
    assert patch.normal_forces.sum() == pytest.approx(state.forces.sum(), rel=1e-12)
    areas = problem.system.contacts[0].node_areas
    assert patch.normal_forces / patch.pressures == pytest.approx(
        areas[state.linearisation.pairs[0].nodes][state.forces > 0]
    )
    assert patch.centre[0] == pytest.approx(0.4, abs=0.05)
    sign = -1.0 if primary == "disc" else 1.0
    assert sign * patch.force[1] > 0.0
    on_block = patch.secondary_point if primary == "disc" else patch.primary_point
    on_disc = patch.primary_point if primary == "disc" else patch.secondary_point
    assert on_block[1] == pytest.approx(0.0, abs=1e-9)
    assert np.hypot(on_disc[0], on_disc[1] - 50.0) == pytest.approx(50.0, abs=0.02)
    assert not patch.at_edge


def test_a_patch_at_the_end_of_its_surface_says_so(press) -> None:
    """A disc shifted to the end of the candidate zone makes a patch that reaches the edge."""
    problem = press("fem")
    response = CondensedBodies(problem.system.surface_nodes)
    state = solve_contact(response, problem.system, problem.placements(0.05, shift=-6.6))
    assert any(patch.at_edge for patch in pressure_patches(problem.system, state))


def test_a_corner_just_beyond_a_node_has_no_pressure_without_limit() -> None:
    """A block whose corner stands a little beyond a node of the wider secondary one: how little does not matter."""
    steel = Elastic(210e3, 0.3)
    upper, lower = (
        Body(name, rectangle_grid(width, 2.0, n, 4), Lagrange(1), steel, held=held)
        for name, width, n, held in (("upper", 4.0, 8, "top"), ("lower", 8.0, 16, "bottom"))
    )
    ground = Part("lower", lower)
    maximum = []
    for beyond in (1e-5, 1e-3, 0.05, 0.2):
        block = Part("upper", upper, Placement(0.0, (2.0 + beyond, 2.0)))
        above, below = Surface(block, upper.mesh.edge_set("bottom")), Surface(ground, lower.mesh.edge_set("top"))
        contact = Contact(below, above, SegmentToSegment(), Multiplier())
        solution = press_parts([contact], motion={block: Placement(0.0, (0.0, -0.01))})
        assert solution.status.converged
        patches = pressure_patches(solution.system, solution.state)
        assert sum(patch.force for patch in patches) == pytest.approx(solution.forces[0])
        maximum.append(max(patch.pressures.max() for patch in patches))
    assert max(maximum) < 1.5 * min(maximum)


def punch(**changes: Any) -> TwoBodiesCase:
    """A flat punch of quadratic elements pushed on a block."""
    contact = {"secondary": "punch", "secondary_edges": "bottom", "primary": "block", "primary_edges": "top", **changes}
    near = {"at_mm": [[-6.0, 0.0], [6.0, 0.0]], "size_mm": 0.42}
    return TwoBodiesCase.from_values(
        {
            "bodies": [
                {
                    "name": "punch",
                    "rectangle": {"width_mm": 10.0, "height_mm": 10.0, "centre_mm": [0.0, 5.0]},
                    "size_mm": 0.5,
                    "order": 2,
                },
                {
                    "name": "block",
                    "rectangle": {"width_mm": 60.0, "height_mm": 30.0, "centre_mm": [0.0, -15.0]},
                    "size_mm": 3.0,
                    "order": 2,
                    "fine": [near],
                },
            ],
            "supports": [{"body": "punch", "edges": "top"}, {"body": "block", "edges": "bottom"}],
            "motions": [{"body": "punch", "push_N": [0.0, -1000.0]}],
            "contacts": [contact],
        }
    )


@pytest.mark.parametrize("peak", [1.0, 5.0, 20.0, 100.0])
def test_a_peak_does_not_hide_an_alternating_pressure(peak: float) -> None:
    """Nodes of 0.77 and 1.23 in turn oscillate by 46 % whatever peaks are at the ends; smooth ones by less than 2 %."""
    for n in (8, 15, 40):
        pressures = 1.0 + 0.23 * (-1.0) ** np.arange(n)
        pressures[[0, -1]] = peak
        assert oscillation_of(pressures) == pytest.approx(0.46)
        for shift in np.linspace(0.05, 0.95, 10):
            places = 2.0 * (np.arange(n) + shift) / n - 1.0
            assert oscillation_of(np.sqrt(1.0 - places**2)) < 0.02
            assert oscillation_of(1.0 / np.sqrt(1.0 - places**2)) < 0.02


def test_an_oscillating_pressure_is_printed_with_its_mark(tmp_path: Path) -> None:
    """Pressures of nodes and multipliers under a flat punch are warned about, and marked wherever they are printed."""
    run = punch(pairing="node-to-segment", enforcement="multiplier").run()
    assert run.status.converged
    assert any("oscillates by" in notice for notice in run.summary["notices"])
    (contact,) = run.summary["contacts"]
    remark = contact["max_pressure_remark"]
    assert remark.startswith("oscillates by ")
    assert contact["patches"][0]["max_pressure_remark"] == remark
    (shown,) = (text for name, text in results_table(run).rows if "maximum pressure" in name)
    assert (shown, shown.remark) == (f"{contact['max_pressure_MPa']:.6g}", remark)
    write_case(run, tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["contacts"][0]["max_pressure_remark"] == remark
    page = (tmp_path / "report.html").read_text()
    # in the tile and in the table
    assert page.count(f'title="{remark}"') >= 2
    assert f"≈ {remark}" in page


def test_too_few_segments_are_a_mark() -> None:
    """A contact of a few segments has its number beside the pressure, in the results of the Hertz case too."""
    run = HertzCase.from_values({"size_mm": 1.0}).run()
    (contact,) = run.summary["contacts"]
    assert "wide" in contact["max_pressure_remark"]
    assert run.summary["results"]["max_pressure_remark"] == contact["max_pressure_remark"]
    rows = dict(results_table(run).rows)
    assert not any("remark" in name for name in rows)
    assert ["wide" in text.remark for name, text in rows.items() if name.startswith("maximum pressure, MPa")] == [True]


def part_of(mesh):
    """A steel part of a mesh."""
    return Part("box", Body("box", mesh, Lagrange(1), Elastic(210e3, 0.3)))


def boundary(mesh, placement):
    """Boundary of a placed mesh."""
    return Boundary.of_part(part_of(mesh), placement.points(mesh.points))


def box(x, y):
    """Boundary of a square of side 1 in 4 x 4 cells, its lower left corner at x, y."""
    return boundary(rectangle_grid(1.0, 1.0, 4, 4), Placement(0.0, (x, y)))


def test_boxes_overlap_by_the_depth_of_the_deepest_corner():
    """A corner that lies 0.2 and 0.3 inside another box is 0.2 deep, seen from either box."""
    for one, other in ((box(0.0, 0.0), box(0.8, 0.7)), (box(0.8, 0.7), box(0.0, 0.0))):
        assert one.overlap(other).depth == pytest.approx(0.2)


def test_boxes_apart_do_not_overlap_and_straight_sides_allow_nothing():
    """Boxes apart have no overlap; a millionth of a side is one, and no chord of a curve explains it."""
    assert box(0.0, 0.0).overlap(box(1.5, 0.0)) is None
    found = box(0.0, 0.0).overlap(box(1.0 - 1e-6, 0.37))
    assert found.depth == pytest.approx(1e-6, rel=1e-6)
    assert found.allowed == 0.0


def test_edges_that_cross_without_a_node_inside_are_an_overlap():
    """A bar that goes through a box overlaps it by half of its width, although no node is in the other body."""
    bar = boundary(rectangle_grid(10.0, 0.1, 1, 1), Placement(0.0, (-4.5, 0.3)))
    assert box(0.0, 0.0).overlap(bar).depth == pytest.approx(0.4, rel=0.1)


def test_chords_of_two_arcs_explain_their_sagittas_alone():
    """Meshed discs that roll on each other overlap by their sagittas at most; pressed by an edge they overlap more."""
    mesh = triangulate(circle(1.0), size=0.2)
    disc = boundary(mesh, Placement())
    for angle in np.linspace(0.0, 0.6, 7):
        rolled = disc.overlap(boundary(mesh, Placement(angle, (2.0, 0.0))))
        assert rolled is None or rolled.depth <= rolled.allowed + 1e-9
        assert disc.overlap(boundary(mesh, Placement(angle, (1.8, 0.0)))).depth > 0.1


@pytest.mark.parametrize(("y", "passes"), [(0.0, True), (0.99, True), (1.01, False), (-1.01, False)])
def test_a_path_through_a_body_is_seen_however_thin_it_is(y, passes):
    """A box that moves far past a thin plate goes through it where their heights overlap."""
    moved, plate = part_of(rectangle_grid(1.0, 1.0, 1, 1)), part_of(rectangle_grid(1e-3, 1.0, 1, 1))
    before, after = (
        [
            (placement, Boundary.of_part(part, placement.points(part.body.nodes)))
            for part, placement in ((moved, Placement(0.0, (x, y))), (plate, Placement()))
        ]
        for x in (-100.0, 100.0)
    )
    assert passes_through(moved, plate, before, after) == passes
