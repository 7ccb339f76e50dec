"""Blocks of rectangular cells, fine where they touch, for the contact problems of friction."""

from collections import Counter
from dataclasses import replace

import numpy as np

from flangeway.contact import Contact, ContactSolution, Multiplier, SegmentToSegment, Surface
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Body, Part
from flangeway.types import Floats
from flangeway_studies.study import Run


def growing(start: float, size: float, end: float, factor: float = 1.3) -> Floats:
    """Coordinates from a start to an end, at first a size apart, then growing by a factor."""
    steps = start + size * np.cumsum(factor ** np.arange(1, 100))
    return np.concatenate(([start], steps[steps < start + 0.8 * (end - start)], [end]))


def block(
    name: str, x: Floats, depth: Floats, material: Elastic, *, near: float, radius: float = np.inf, order: int = 1
) -> Part:
    """The part ``upper`` above y = 0, or another one below, of columns at x and rows at depths, held far from the face.

    The face is bulged by a radius up to x = ``near``, and straight beyond.
    """
    above = name == "upper"
    grid = rectangle_grid(1.0, 1.0, len(x) - 1, len(depth) - 1)
    across, up = (coordinates.ravel() for coordinates in np.meshgrid(x, depth if above else -depth[::-1]))
    far, close = np.maximum(np.abs(across) - near, 0.0), np.minimum(np.abs(across), near)
    bulge = (close**2 / 2.0 + far * close) / radius * (1.0 - np.abs(up) / depth[-1])
    mesh = replace(grid, points=np.column_stack((across, up + bulge)))
    return Part(name, Body(name, mesh, Lagrange(order), material, "top" if above else "bottom"))


def face(part: Part, reach: float) -> Surface:
    """The face of a block up to a distance from x = 0."""
    mesh = part.body.elasticity.space.mesh
    edges = mesh.edge_sets["bottom" if part.name == "upper" else "top"]
    middle = mesh.points[edges][:, :, 0].mean(axis=1)
    return Surface(part, edges[np.abs(middle) < reach])


def touching(secondary: Surface, primary: Surface, friction: float = 0.0) -> Contact:
    """Contact averaged over segments, with multipliers."""
    return Contact(secondary, primary, SegmentToSegment(), Multiplier(), friction)


def shift(part: Part, x: float, y: float) -> dict[Part, Placement]:
    """A motion of a part."""
    return {part: Placement(0.0, (x, y))}


def columns(solution: ContactSolution) -> dict[str, Floats]:
    """Columns of the table of a solution's nodes in contact, see `ContactSolution.friction_table`."""
    return {name: np.asarray(values) for name, values in solution.friction_table.columns.items()}


class Solved:
    """What all solutions of the study must be: converged, and how many iterations their slowest load step takes."""

    def __init__(self, run: Run) -> None:
        self.run, self.slowest = run, 0

    def __call__(self, solution: ContactSolution) -> ContactSolution:
        """Return a solution after a look at it."""
        self.run.check(" on ".join(part.name for part in solution.system.parts), solution.status)
        for step in solution.steps:
            # without augmented Lagrange all iterations of a step are of one correction of the forces
            counts = Counter(iteration.correction for iteration in step.state.history)
            self.slowest = max(self.slowest, *counts.values())
        return solution
