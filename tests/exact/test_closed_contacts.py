"""Contact along whole circles, ovals and polygons, beside Lamé's rings and a contact that may lie across the seam."""

from typing import Any

import numpy as np
import pytest

from flangeway.cases.bodies.bodies_run import BodiesRun, TwoBodiesCase

YOUNG, POISSON, GAP, INNER, OUTER = 210e3, 0.3, 0.01, 20.0, 40.0


def circle(radius: float, name: str = "circle", at: float = 0.0, height: float = 0.0) -> dict[str, Any]:
    """A circle of two arcs about (0, height), whose seam is at an angle."""
    x, y = radius * np.cos(at), radius * np.sin(at)
    ends = [[sign * x, height + sign * y] for sign in (-1, 1)]
    arcs = [{"arc_to": end, "centre": [0.0, height], "turn": "left", "name": name} for end in ends]
    return {"path": [{"from": ends[1]}, *arcs]}


def fit(hub: dict[str, Any], held: str, primary: str = "shaft", **values: Any) -> BodiesRun:
    """A shaft that is too large by `GAP` in a hub, plane strain."""
    names = {"shaft": None, "hub": "bore"}
    secondary = "hub" if primary == "shaft" else "shaft"
    edges = {key: names[name] for key, name in (("secondary_edges", secondary), ("primary_edges", primary))}
    contact = {"secondary": secondary, "primary": primary, "interference": True}
    return TwoBodiesCase.from_values(
        {
            "bodies": [
                {"name": "shaft", "outline": circle(INNER + GAP), "size_mm": 2.5},
                {"name": "hub", "outline": hub, "size_mm": 2.5},
            ],
            "supports": [{"body": "hub", "edges": held}],
            "contacts": [contact | {key: name for key, name in edges.items() if name}],
        }
        | values
    ).run()


@pytest.mark.parametrize("primary", ["shaft", "hub"])
def test_a_fit_in_a_held_hub_has_the_pressure_of_lame(primary: str) -> None:
    """U = A (r - b^2 / r) in the hub, which is held at b, and a uniform pressure in the shaft: 93.75 MPa."""
    run = fit(circle(OUTER, "rim") | {"holes": [circle(INNER, "bore", 0.7)]}, "rim", primary)
    assert run.status.converged, run.status.message
    shear, strain = YOUNG / (1.0 + POISSON), 1.0 - 2.0 * POISSON
    ratio = (OUTER / INNER) ** 2
    hub = INNER * (ratio - 1.0) / (shear * (1.0 / strain + ratio))
    pressure = GAP / (hub + INNER * strain / shear)
    (patch,) = run.patches
    assert patch.pressures == pytest.approx(pressure, rel=0.03)
    assert patch.normal_forces.sum() == pytest.approx(2.0 * np.pi * INNER * pressure, rel=3e-3)
    assert patch.half_width == pytest.approx(np.pi * INNER, rel=2e-3)
    assert not patch.at_edge


@pytest.mark.parametrize("pairing", ["segment-to-segment", "node-to-segment"])
@pytest.mark.parametrize("method", ["fem", "vem"])
def test_a_heated_shaft_that_nothing_else_holds_has_the_pressure_of_lame(method: str, pairing: str) -> None:
    """Its free expansion (1 + nu) alpha T r is the interference; its forces turn with it, and hold no rotation."""
    elements = {"size_mm": 2.5, "method": method}
    rim = circle(OUTER, "rim") | {"holes": [circle(INNER, "bore", 0.7)]}
    run = TwoBodiesCase.from_values(
        {
            "bodies": [
                {"name": "shaft", "outline": circle(INNER), "expansion_per_K": 12e-6} | elements,
                {"name": "hub", "outline": rim} | elements,
            ],
            "loads": [{"body": "shaft", "temperature_K": 50.0}],
            "supports": [{"body": "hub", "edges": "rim"}],
            "contacts": [{"secondary": "hub", "secondary_edges": "bore", "primary": "shaft", "pairing": pairing}],
        }
    ).run()
    assert run.status.converged, run.status.message
    shear, ratio = YOUNG / (1.0 + POISSON), (OUTER / INNER) ** 2
    of_hub = (ratio - 1.0) / (shear * (1.0 / (1.0 - 2.0 * POISSON) + ratio))
    pressure = (1.0 + POISSON) * 12e-6 * 50.0 / (of_hub + (1.0 - 2.0 * POISSON) / shear)
    (patch,) = run.patches
    assert patch.normal_forces.sum() == pytest.approx(2.0 * np.pi * INNER * pressure, rel=5e-3)


@pytest.mark.parametrize("order", [1, 2])
def test_a_ring_between_a_shaft_and_a_hub_has_two_pressures_of_lame(order: int) -> None:
    """Interferences of 0.01 mm at radii 10 and 15 mm in a hub held at 25 mm: two closed contacts of one body."""
    radii, shear, strain = (10.0, 15.0, 25.0), YOUNG / (1.0 + POISSON), 1.0 - 2.0 * POISSON
    bodies = [
        {"name": "shaft", "outline": circle(10.0 + GAP)},
        {"name": "ring", "outline": circle(15.0, "out", 0.4) | {"holes": [circle(10.0, "in", 1.3)]}},
        {"name": "hub", "outline": circle(25.0, "rim") | {"holes": [circle(15.0 - GAP, "bore", 2.0)]}},
    ]
    sides = [{"secondary_edges": "in", "primary": "shaft"}, {"secondary_edges": "out", "primary": "hub"}]
    sides[1]["primary_edges"] = "bore"
    run = TwoBodiesCase.from_values(
        {
            "bodies": [body | {"size_mm": 2.0, "order": order} for body in bodies],
            "supports": [{"body": "hub", "edges": "rim"}],
            "contacts": [{"secondary": "ring", "interference": True} | side for side in sides],
        }
    ).run()
    assert run.status.converged, run.status.message
    a, b, c = np.square(radii)
    pressures = np.eye(2)  # inside and outside of the ring
    # u = ((1 - 2 nu) A r + B / r) / 2 G of a ring, with A = (p a - q b) / (b - a), B = (p - q) a b / (b - a)
    first, second = (pressures @ (a, -b)) / (b - a), (pressures @ (1.0, -1.0)) * a * b / (b - a)
    inner, outer = ((strain * first * r + second / r) / shear for r in radii[:2])
    hub = radii[1] * (c / b - 1.0) / (shear * (1.0 / strain + c / b))
    equations = np.stack((np.add(inner, (strain / shear * radii[0], 0.0)), np.subtract((0.0, hub), outer)))
    for patch, pressure, radius in zip(run.patches, np.linalg.solve(equations, [GAP, GAP]), radii, strict=False):
        assert patch.normal_forces.sum() == pytest.approx(2.0 * np.pi * radius * pressure, rel=5e-3)
        assert patch.half_width == pytest.approx(np.pi * radius, rel=5e-3)


@pytest.mark.parametrize("primary", ["shaft", "hub"])
def test_a_square_peg_in_a_square_hole_marks_its_corners(primary: str) -> None:
    """One region all round, and in equilibrium; its maximum is at a sharp corner, whichever side is the secondary."""
    corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
    hole = {"points": [[INNER * x, INNER * y] for x, y in corners]}
    sides = [{"line_to": [INNER * x / 2.0, INNER * y / 2.0], "name": "bore"} for x, y in corners]
    hub = hole | {"holes": [{"path": [{"from": sides[-1]["line_to"]}, *sides]}]}
    peg = {"points": [[(INNER / 2.0 + GAP) * x, (INNER / 2.0 + GAP) * y] for x, y in corners]}
    edges = {"secondary_edges": "bore"} if primary == "shaft" else {"primary_edges": "bore"}
    secondary = "hub" if primary == "shaft" else "shaft"
    run = TwoBodiesCase.from_values(
        {
            "bodies": [
                {"name": "shaft", "outline": peg, "size_mm": 2.0},
                {"name": "hub", "outline": hub, "size_mm": 2.0},
            ],
            "supports": [{"body": "hub", "edges": "side_1"}],
            "contacts": [{"secondary": secondary, "primary": primary, "interference": True} | edges],
        }
    ).run()
    assert run.status.converged, run.status.message
    (patch,) = run.patches
    assert patch.half_width == pytest.approx(2.0 * INNER, rel=2e-3)
    assert np.abs(patch.force).max() < 1e-6 * patch.normal_forces.sum()
    assert patch.corner is not None
    assert np.abs(patch.corner) == pytest.approx(INNER / 2.0, abs=0.1)


def test_a_fit_in_a_square_hub_carries_a_pressure_all_round() -> None:
    """A square outside of the ring of Lamé with a free rim, 43.27 MPa: a little stiffer, in one region."""
    points = [[-40.0, -40.0], [40.0, -40.0], [40.0, 40.0], [-40.0, 40.0]]
    run = fit({"points": points, "holes": [circle(INNER, "bore")]}, "side_1")
    assert run.status.converged, run.status.message
    (patch,) = run.patches
    mean = float(patch.normal_forces.sum()) / (2.0 * np.pi * INNER)
    assert 43.27 < mean < 1.15 * 43.27
    assert np.ptp(patch.along) == pytest.approx(2.0 * np.pi * INNER, rel=0.05)


@pytest.mark.parametrize("pairing", ["segment-to-segment", "node-to-segment"])
def test_a_contact_across_the_seam_is_one_region(pairing: str) -> None:
    """A whole disc on a block: wherever the seam of its circle is, one region has the same force, centre and width."""
    numbers = []
    for seam in (-np.pi / 2.0, 0.0):
        disc = circle(10.0, "rim", seam, 10.0) | {"holes": [circle(5.0, "hub", 0.0, 10.0)]}
        block = {"width_mm": 40.0, "height_mm": 20.0, "centre_mm": [0.0, -10.0]}
        fine = [{"at_mm": [[-1.0, 0.0], [1.0, 0.0]], "size_mm": 0.15}]
        run = TwoBodiesCase.from_values(
            {
                "bodies": [
                    {"name": "disc", "outline": disc, "size_mm": 2.0, "fine": fine},
                    {"name": "block", "rectangle": block, "size_mm": 4.0, "fine": fine},
                ],
                "supports": [{"body": "disc", "edges": "hub"}, {"body": "block", "edges": "bottom"}],
                "motions": [{"body": "disc", "shift_mm": [0.0, -0.05]}],
                "contacts": [
                    {
                        "secondary": "disc",
                        "secondary_edges": "rim",
                        "primary": "block",
                        "primary_edges": "top",
                        "pairing": pairing,
                    }
                ],
            }
        ).run()
        assert run.status.converged, run.status.message
        (patch,) = run.patches
        assert np.all(np.diff(patch.along) > 0.0)
        numbers.append([patch.force[1], patch.half_width, patch.pressures.max()])
        assert patch.centre[0] == pytest.approx(0.0, abs=0.02)
    assert numbers[0] == pytest.approx(numbers[1], rel=0.12)
    assert numbers[0][0] == pytest.approx(numbers[1][0], rel=0.02)


@pytest.mark.parametrize("order", [1, 2])
def test_a_pile_of_discs_has_the_forces_of_statics(order: int) -> None:
    """Two whole discs carry a third one: its weight W presses each with W / (2 cos 30), on a floor and on a wall."""
    walls = [[10.0, 20.0], [10.0, 0.0], [-10.0, 0.0], [-10.0, 20.0]]
    path: list[dict[str, Any]] = [{"from": [-10.0, 20.0]}, {"line_to": [-15.0, 20.0]}, {"line_to": [-15.0, -5.0]}]
    path += [{"line_to": [15.0, -5.0], "name": "bottom"}, {"line_to": [15.0, 20.0]}]
    path += [{"line_to": point, "name": "in"} for point in walls]
    centres = [(-5.0, 5.0), (5.0, 5.0), (0.0, 5.0 + 5.0 * np.sqrt(3.0))]
    discs = [
        {"name": f"{i}", "disc": {"radius_mm": 5.0, "centre_mm": at}, "size_mm": 1.0} for i, at in enumerate(centres)
    ]
    bodies = [*discs, {"name": "box", "outline": {"path": path}, "size_mm": 2.0}]
    on_box = [{"secondary": f"{i}", "primary": "box", "primary_edges": "in"} for i in (0, 1)]
    run = TwoBodiesCase.from_values(
        {
            "bodies": [body | {"order": order} for body in bodies],
            "supports": [{"body": "box", "edges": "bottom"}],
            "loads": [{"body": "2", "body_force_N_mm3": [0.0, -1.0]}],
            "contacts": [*on_box, *({"secondary": f"{i}", "primary": "2"} for i in (0, 1))],
        }
    ).run()
    assert run.status.converged, run.status.message
    half = np.pi * 5.0**2 / 2.0
    for patch in run.patches:
        assert patch.half_width > 0.0
    on_lower = np.abs([patch.force for patch in run.patches if patch.contact > 1])
    assert on_lower == pytest.approx(np.array([[np.tan(np.pi / 6.0), 1.0]] * 2) * half, rel=0.03)
