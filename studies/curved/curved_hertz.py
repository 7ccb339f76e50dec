"""A half disc of polygons on a block: pressures on curved edges and on chords, beside Hertz's."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flangeway.contact import Contact, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Virtual
from flangeway.exact import LineContact
from flangeway.geometry import Arc, Line, Outline, Placement, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.post import pressure_patches
from flangeway.problems import Body, Part
from studies.hertz.hertz_reproduced import rms_from_hertz
from studies.published_numbers import ReproducedNumber, compare

STEEL = Elastic(210e3, 0.3)
DISC = Outline.from_segments(
    [Arc((-1.0, 1.0), (1.0, 1.0), (0.0, 1.0), True), Line((1.0, 1.0), (-1.0, 1.0))], ["arc", "cut"]
)
BLOCK = rectangle(2.0, 1.0, (0.0, -0.5))
DEPTH, HALF_WIDTH = 3e-3, 0.04  # approach, and about half of the width of the contact, over the radius
CANDIDATES = 0.08  # distance from the middle up to which edges can touch
INSIDE = 0.9  # share of the half width inside which pressures are compared: Hertz's falls steeply at its ends
COARSER = 1.13  # edges of the block over those of the disc
ORDERS, LEVELS = (1, 2, 3), (4, 8, 16)  # triangles of the disc to the half width
PRESSURE_LIMITS = {1: 0.015, 2: 0.005, 3: 0.005}  # of the difference at the finest level; Hertz's own is 0.003


@dataclass(frozen=True)
class PressureRow:
    """One contact: a row of ``pressures.csv``."""

    order: int  # of the elements
    curved: bool  # whether edges are curved, or chords
    level: int  # triangles to the half width
    n_unknowns: int  # of both bodies
    difference: float  # root mean square difference of the pressure from Hertz's, over its maximum
    oscillation: float  # that of the nodes from the means of their neighbours, over the maximum


def pressures(order: int, level: int, *, on_curves: bool) -> PressureRow:
    """Press the disc onto the block, segment-to-segment with multipliers weighted by biorthogonal functions.

    On curved edges the gap is that from the circle; for order 1, whose edges are chords, by a point beside each.
    """
    size, parts, surfaces = HALF_WIDTH / level, [], []
    zone = np.array([[-1.5 * HALF_WIDTH, 0.0], [1.5 * HALF_WIDTH, 0.0]])
    for name, outline, held, side, factor in (
        ("disc", DISC, "cut", "arc", 1.0),
        ("block", BLOCK, "bottom", "top", COARSER),
    ):
        curve = outline if on_curves and name == "disc" else None
        mesh = dual(triangulate(outline, size=0.25, refinements=[Refinement(zone, size * factor, 0.3)], outline=curve))
        part = Part(name, Body(name, mesh, Virtual(order), STEEL, held))
        edges = mesh.edge_set(side)
        ends = mesh.points[edges]
        near = (np.abs(ends[..., 0]) < CANDIDATES).all(axis=1) & (ends[..., 1] < 0.5).all(axis=1)
        parts.append(part)
        surfaces.append(Surface(part, edges[near], curve))
    contact = Contact(surfaces[0], surfaces[1], SegmentToSegment(weighting="dual"), Multiplier())
    found = press([contact], motion={parts[0]: Placement(0.0, (0.0, -DEPTH))})
    theory = LineContact(float(found.forces[0, 1]), 1.0, STEEL.plane_modulus / 2.0)
    (patch,) = pressure_patches(found.system, found.state)
    x, values = patch.points[:, 0], patch.pressures
    within = INSIDE * theory.half_width
    apart = values - np.interp(x, (x[:-2] + x[2:]) / 2.0, (values[:-2] + values[2:]) / 2.0)
    difference = rms_from_hertz(x, values, theory, within)
    oscillation = float(np.sqrt(np.mean(apart[np.abs(x) < within] ** 2))) / theory.max_pressure
    n_unknowns = sum(2 * part.body.space.n_dofs for part in parts)
    return PressureRow(order, on_curves, level, n_unknowns, difference, oscillation)


def pressure_numbers(rows: tuple[PressureRow, ...]) -> Iterator[ReproducedNumber]:
    """Differences of the finest meshes from Hertz's pressure; those of chords are shown only."""
    for row in rows:
        if row.level == LEVELS[-1]:
            where = "curved edges" if row.curved else "chords"
            yield compare(
                "Hertz", f"V{row.order}", f"difference of the pressure on {where}", "1", (0.0, row.difference),
                PRESSURE_LIMITS[row.order], "Hertz's theory", words=None if row.curved else "",
            )  # fmt: skip


def pressure_failures(rows: tuple[PressureRow, ...]) -> Iterator[str]:
    """Orders with which curved edges do not halve the oscillation of chords."""
    chords = {(row.order, row.level): row.oscillation for row in rows if not row.curved}
    for row in rows:
        if row.curved and not row.oscillation < 0.5 * chords[row.order, row.level]:
            before = chords[row.order, row.level]
            yield f"order {row.order}: pressures oscillate by {row.oscillation:.2g}, on chords by {before:.2g}"
