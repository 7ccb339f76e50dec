"""The size of load steps with friction is an error, which is controlled where no steps are given."""

import numpy as np
import pytest

from flangeway.contact import Contact, ContactSolution, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement, polygon
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.mesh.sizing import Refinement
from flangeway.problems import Body, Part
from flangeway.solve import StepSettings

FINE_MM, RADIUS_MM, APPROACH_MM, ZONE_MM = 0.5, 50.0, 1.45, 12.0


def surface_of(part: Part, name: str) -> Surface:
    """Edges of a set of the part within the zone of contact."""
    edges = part.body.mesh.edge_sets[name]
    return Surface(part, edges[part.body.mesh.points[edges][:, :, 0].max(axis=1) < ZONE_MM + 0.1])


def rolled(steps: StepSettings | None) -> ContactSolution:
    """Half of a steel roller that is pressed on half of an aluminium block with friction (NAFEMS R0094)."""
    angles = np.append(np.arange(0.0, 0.24, FINE_MM / RADIUS_MM), np.linspace(0.24, np.pi / 2.0, 25))
    arc = [(RADIUS_MM * np.sin(angle), RADIUS_MM * (1.0 - np.cos(angle))) for angle in angles]
    top = [(x, 0.0) for x in np.append(np.arange(0.0, ZONE_MM + 0.01, FINE_MM), (20.0, 40.0, 100.0))][::-1]
    outlines = {
        "roller": polygon([*arc, (0.0, RADIUS_MM)], ["arc"] * (len(arc) - 1) + ["top", "axis"]),
        "block": polygon([(0.0, -200.0), (100.0, -200.0), *top], ["bottom", "side", *["top"] * (len(top) - 1), "axis"]),
    }
    held = {"roller": {"top": "y", "axis": "x"}, "block": {"bottom": "xy", "axis": "x"}}
    fine = [Refinement(np.zeros((1, 2)), FINE_MM)]
    roller, block = (
        Part(
            name,
            Body(
                name,
                triangulate(outlines[name], size=size, refinements=fine),
                Lagrange(1),
                Elastic(young, 0.3),
                held[name],
            ),
        )
        for name, size, young in (("roller", 6.0, 210e3), ("block", 15.0, 70e3))
    )
    contact = Contact(surface_of(roller, "arc"), surface_of(block, "top"), SegmentToSegment(), Multiplier(), 0.1)
    solution = press([contact], {roller: Placement(0.0, (0.0, -APPROACH_MM))}, steps=steps)
    assert solution.status.converged, solution.status.message
    return solution


@pytest.mark.ci
def test_dissipated_work_does_not_depend_on_steps_that_nobody_gave() -> None:
    """The work by default is that of 60 steps within 5 %, in fewer of them; one step is wrong by a factor of 2."""
    fine = rolled(StepSettings(1.0 / 60.0, 1.0 / 60.0)).dissipated_work.sum()
    default = rolled(None)
    assert default.dissipated_work.sum() == pytest.approx(fine, rel=0.05)
    assert 5 < len(default.steps) < 60
    assert rolled(StepSettings()).dissipated_work.sum() > 2.0 * fine
