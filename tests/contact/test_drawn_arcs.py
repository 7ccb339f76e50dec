"""Contact of curved bodies is measured between the drawn arcs, at every order, and says where it is not."""

from typing import Any

import numpy as np
import pytest

from flangeway.cases.bodies.bodies_run import TwoBodiesCase
from flangeway.contact import Contact, ContactSystem, Multiplier, NodeToSegment, SegmentToSegment, Surface
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc, Contour, Line, Outline, Placement, circle, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import curved, dual, triangulate
from flangeway.problems import Body, Part

STEEL = Elastic(210e3, 0.3)
INTERFERENCE, LAME_MPA = 0.02, 54.087
"""Rings of radii 10, 20 and 30 mm in plane strain: p = E' delta / (r ((b^2 + r^2) / (b^2 - r^2) + ...))."""


def ring(name: str, inner: float, outer: float, **keys: Any) -> dict[str, Any]:
    """A quarter of a ring."""
    path = [
        {"from": [inner, 0.0]},
        {"line_to": [outer, 0.0], "name": "bottom"},
        {"arc_to": [0.0, outer], "centre": [0.0, 0.0], "turn": "left", "name": "outer"},
        {"line_to": [0.0, inner], "name": "left"},
        {"arc_to": [inner, 0.0], "centre": [0.0, 0.0], "turn": "right", "name": "inner"},
    ]
    return {"name": name, "outline": {"path": path}, **keys}


def shrink_fit(size_mm: float = 1.5, named: bool = True, **contact: Any) -> TwoBodiesCase:
    """A shaft in a hub, too large by the interference."""
    keys = {key: contact.pop(key) for key in ("order", "method") if key in contact}
    hub = ring("hub", 20.0, 30.0, size_mm=size_mm, **keys)
    shaft = ring("shaft", 10.0, 20.0 + INTERFERENCE, size_mm=0.83 * size_mm, **keys)
    edges = {"secondary_edges": "outer", "primary_edges": "inner"}
    if not named:
        edges = {"secondary_box_mm": [0.0, 0.0, 21.0, 21.0], "primary_box_mm": [0.0, 0.0, 20.5, 20.5]}
        edges["secondary_edges"] = "outer"
    return TwoBodiesCase.from_values(
        {
            "bodies": [hub, shaft],
            "supports": [
                {"body": body, "edges": edge, "hold": axis}
                for body in ("hub", "shaft")
                for edge, axis in (("bottom", "y"), ("left", "x"))
            ],
            "contacts": [{"secondary": "shaft", "primary": "hub", **edges, **contact}],
        }
    )


def mean_error(case: TwoBodiesCase) -> tuple[float, float]:
    """Errors of the mean pressure and of the worst node over Lame's pressure."""
    run = case.run()
    assert run.status.converged, run.status.message
    force = sum(patch.normal_forces.sum() for patch in run.patches)
    mean = force / sum(patch.width for patch in run.patches)
    worst = max(abs(patch.pressures / LAME_MPA - 1.0).max() for patch in run.patches)
    return mean / LAME_MPA - 1.0, worst


@pytest.mark.parametrize(
    ("order", "method", "pairing", "enforcement"),
    [
        (1, "fem", "node-to-segment", "multiplier"),
        (2, "fem", "segment-to-segment", "augmented-lagrange"),
        (2, "vem", "node-to-segment", "penalty"),
        (1, "fem", "segment-to-segment", "multiplier"),
    ],
)
def test_shrink_fit_has_the_pressure_of_lame(order: int, method: str, pairing: str, enforcement: str) -> None:
    """The mean pressure of a shrink fit is that of Lame within 0.5 %, at no node of order 1 it is farther than 13 %."""
    mean, worst = mean_error(shrink_fit(order=order, method=method, pairing=pairing, enforcement=enforcement))
    assert abs(mean) < 0.005
    assert worst < 0.13 or order == 2


def test_curves_are_used_where_edges_are_found_by_a_box() -> None:
    """A surface that no names but a box choose is curved as well."""
    assert abs(mean_error(shrink_fit(named=False))[0]) < 0.005


def test_straight_edges_that_matter_are_named() -> None:
    """Straight edges in a shrink fit are warned about with their distance h^2 / 8 R from the arcs; curved ones not."""
    straight = shrink_fit(curved=False).run().summary["notices"]
    assert any("straight edges in the contact of shaft on hub are up to" in notice for notice in straight)
    assert not any("straight edges" in notice for notice in shrink_fit().run().summary["notices"])


def test_edges_know_their_distance_from_the_curve_they_stand_for() -> None:
    """Edges of a circle without its curve are R (1 - cos(t / 2)) off it; long straight sides are no curve."""
    sides = Line((-10.0, -2.0), (10.0, -2.0)), Line((10.0, 2.0), (-10.0, 2.0))
    ends = [Arc(a.end, b.start, (a.end[0], 0.0), counter_clockwise=True) for a, b in (sides, sides[::-1])]
    slot = Outline.from_segments([sides[0], ends[0], sides[1], ends[1]], ["slot"] * 4)
    for outline in (circle(5.0), slot):
        mesh = triangulate(outline, size=0.6)
        name = outline.names[0]
        body = Body("pin", mesh.with_edge_set("held", mesh.edge_set(name)[:1]), Lagrange(1), STEEL, "held")
        surface = Surface(Part("pin", body), mesh.edge_set(name))
        depth, radius = surface.facet_depth, 5.0 if name == "circle" else 2.0
        on_arc = (np.abs(mesh.points[surface.edges][..., 0]) > 10.0 + 1e-9).any(axis=1) | (name == "circle")
        assert depth.max() == pytest.approx(surface.edge_lengths[on_arc].max() ** 2 / 8.0 / radius, rel=0.05)
        if name == "circle":
            assert Surface(Part("pin", body), mesh.edge_set(name), outline).facet_depth.max() == 0.0
            assert depth.min() > 0.8 * depth.max()


def element(method: str, order: int) -> Element:
    return Lagrange(order) if method == "fem" else Virtual(order)


@pytest.mark.parametrize(
    ("method", "order", "pairing", "mirrored"),
    [
        ("fem", 1, NodeToSegment(), True),
        ("fem", 2, SegmentToSegment(weighting="dual"), False),
        ("vem", 1, SegmentToSegment(), True),
        ("vem", 2, NodeToSegment(), False),
    ],
)
def test_the_clearance_of_a_pin_is_the_same_all_around(method: str, order: int, pairing: Any, mirrored: bool) -> None:
    """A pin in a hole with 0.01 mm clearance has gaps of 0.01 mm within 3 % on edges whose chords take 0.06 mm."""
    clearance, radius = 0.01, 5.0
    place = Placement(0.3, (1.0, 2.0), mirrored)
    meshes = (
        triangulate(circle(radius), size=1.5),
        triangulate(rectangle(24.0, 24.0), size=2.0, holes=(circle(radius + clearance),)),
    )
    surfaces = []
    for name, mesh, curve in zip(("pin", "plate"), meshes, (circle(radius), circle(radius + clearance)), strict=True):
        cells = mesh if method == "fem" else dual(mesh)
        held = cells.edge_set("circle")[:1] if name == "pin" else cells.edge_set("bottom")
        body = Body(name, cells.with_edge_set("held", held), element(method, order), STEEL, "held")
        edges = cells.edge_set("circle")
        lower = edges[(cells.points[edges][..., 1] < 1e-9).all(axis=1)]
        surfaces.append(Surface(Part(name, body, place), lower, curve))
    system = ContactSystem([Contact(*surfaces, pairing, Multiplier())])
    reference = [
        part.placement.points(nodes.points) for part, nodes in zip(system.parts, system.surface_nodes, strict=True)
    ]
    lin = system.linearise(np.concatenate(reference), None)
    assert len(lin.gaps) > 5
    np.testing.assert_allclose(lin.gaps, clearance, rtol=0.03)

    moved = np.concatenate(reference) + 1e-4 * np.random.default_rng(1).normal(
        size=(system.nodes_of(surfaces[0]).size + len(surfaces[1].nodes), 2)
    )
    lin = system.linearise(moved, None)
    assert lin.jacobian.shape[1] == 2 * len(lin.nodes)
    # rigid motions of all change no gap: forces and moments of both sides are in equilibrium
    points = moved[lin.nodes]
    turn = np.stack((-points[:, 1], points[:, 0]), axis=1)
    for motion in (np.ones_like(points) * (1.0, 0.0), np.ones_like(points) * (0.0, 1.0), turn):
        assert abs(lin.jacobian @ motion.ravel()).max() < 1e-12 * abs(points).max()


@pytest.mark.parametrize("element", [Virtual(2), Virtual(3), Lagrange(2)], ids=repr)
def test_a_surface_of_curved_edges_is_on_its_curve_already(element) -> None:
    """Nodes of contact need no shift onto the drawn circle, and no edge counts as a facet; with chords both are so."""
    disc = circle(1.0)
    straight = triangulate(disc, size=0.4)
    (shifts, depths), (chord_shifts, chord_depths) = (
        (np.abs(Surface(part, edges, curve=disc).shifts).max(), Surface(part, edges).facet_depth.max())
        for mesh in (curved(straight, disc), straight)
        for edges in [mesh.boundary_edges]
        for part in [Part("disc", Body("disc", mesh, element, Elastic(1.0, 0.3), {(1.0, 0.0): "xy", (-1.0, 0.0): "y"}))]
    )
    assert shifts < 1e-12
    assert depths == 0.0
    assert chord_shifts > 5e-3
    assert chord_depths > 5e-3


def test_a_curve_elsewhere_is_refused() -> None:
    """A curve that is not the meshed outline is refused with the node that is far from it."""
    mesh = triangulate(circle(1.0), size=0.4)
    part = Part("disc", Body("disc", mesh, Lagrange(1), Elastic(1.0, 0.3), {(1.0, 0.0): "xy", (-1.0, 0.0): "y"}))
    line = Contour((Line((-3.0, -3.0), (3.0, -3.0)),), ("line",))
    with pytest.raises(InputError, match=r"is [2-4]\S* from its curve"):
        Surface(part, mesh.boundary_edges, curve=line)
