"""Sections by their dimensions: areas and second moments of handbooks, and of sectionproperties' own library."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.geometry import (
    angle_section,
    box_section,
    channel_section,
    i_section,
    pipe_section,
    rounded_polygon,
    tee_section,
)

PEERS = {
    "i_section": (i_section(200, 100, 8.5, 5.6, 12), {"d": 200, "b": 100, "t_f": 8.5, "t_w": 5.6, "r": 12, "n_r": 256}),
    "channel_section": (
        channel_section(120, 60, 8, 6, 10), {"d": 120, "b": 60, "t_f": 8, "t_w": 6, "r": 10, "n_r": 256},
    ),
    "tee_section": (tee_section(200, 100, 12, 6, 8), {"d": 200, "b": 100, "t_f": 12, "t_w": 6, "r": 8, "n_r": 256}),
    "angle_section": (
        angle_section(150, 100, 12, 10, 5), {"d": 150, "b": 100, "t": 12, "r_r": 10, "r_t": 5, "n_r": 256},
    ),
    "rectangular_hollow_section": (
        box_section(120, 80, 6), {"d": 120, "b": 80, "t": 6, "r_out": 0, "n_r": 1},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PEERS)
def test_areas_and_second_moments_are_those_of_the_peers_library(name):
    """The area and the second moments about the centroid agree to 1e-5, which the peer's chords leave."""
    library = pytest.importorskip("sectionproperties.pre.library")
    ours, arguments = PEERS[name]
    theirs = getattr(library, name)(**arguments).geom
    assert ours.area == pytest.approx(theirs.area, rel=1e-5)
    # second moments of a polygon of chords, by Green's formula
    ixx = 0.0
    for ring, sign in [(theirs.exterior, 1.0), *[(each, -1.0) for each in theirs.interiors]]:
        p = np.array(ring.coords) - [theirs.centroid.x, theirs.centroid.y]
        (x0, y0), (x1, y1) = p[:-1].T, p[1:].T
        cross = x0 * y1 - x1 * y0
        ixx += sign * abs((cross * (y0**2 + y0 * y1 + y1**2)).sum() / 12.0)
    assert ours.second_moments[0] == pytest.approx(ixx, rel=2e-5)


def test_ipe_200_is_the_one_of_the_tables():
    """IPE 200 (EN 10365): 28.5 cm2, 1943 cm4, 142 cm4."""
    beam = i_section(200.0, 100.0, 8.5, 5.6, 12.0)
    assert beam.area == pytest.approx(2850.0, rel=1e-3)
    np.testing.assert_allclose(sorted(beam.second_moments[:2]), [142.4e4, 1943e4], rtol=2e-3)


def test_a_pipe_and_a_rounded_square_have_the_known_areas():
    """The pipe has pi (R^2 - r^2), the square its own less (4 - pi) r^2."""
    assert pipe_section(50.0, 5.0).area == pytest.approx(np.pi * (25.0**2 - 20.0**2), rel=1e-12)
    rounded = rounded_polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [1, 1, 1, 1])
    assert rounded.area == pytest.approx(16.0 - 4.0 + np.pi, rel=1e-12)


@pytest.mark.parametrize("make", [
    lambda: i_section(10, 10, 6, 1),
    lambda: pipe_section(10, 5),
    lambda: box_section(10, 10, -1),
    lambda: i_section(100, 50, 5, 5, 60),
    lambda: rounded_polygon([(0, 0), (1, 0), (0, 1)], [0, -1, 0]),
])  # fmt: skip
def test_dimensions_that_do_not_fit_are_refused(make):
    """Walls thicker than the section, radii longer than sides, negative numbers."""
    with pytest.raises(InputError):
        make()
