"""Contact surfaces on edges that are curved in the mesh."""

import numpy as np
import pytest

from flangeway.contact import Surface
from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Contour, Line, circle
from flangeway.materials import Elastic
from flangeway.mesh import curved, triangulate
from flangeway.problems import Body, Part


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
