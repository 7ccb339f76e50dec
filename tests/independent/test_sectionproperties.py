"""Constants of sections against the program sectionproperties (its own six-node triangles and mesher)."""

import numpy as np
import pytest

from flangeway.cases.section_run import TorsionCase, find_section, run_section
from flangeway.formats import DrawnSection
from flangeway.geometry import Region, Section, polygon, rectangle

pytestmark = pytest.mark.ci  # costs a minute or more

pytest.importorskip("sectionproperties", reason="the peer is installed with the extra 'dev'")

CHANNEL = Region(polygon([(0, 0), (60, 0), (60, 6), (6, 6), (6, 114), (60, 114), (60, 120), (0, 120)]))
BOX = Region(rectangle(80.0, 50.0), (rectangle(74.0, 44.0),))
ANGLE = Region(polygon([(0, 0), (90, 0), (90, 9), (10, 9), (10, 60), (0, 60)]))


def peer(region, max_area, poisson=0.0):
    """Solve with sectionproperties on the region's chords."""
    from sectionproperties.analysis import Section as PeerSection  # noqa: PLC0415
    from sectionproperties.pre import Geometry, Material  # noqa: PLC0415
    from shapely import Polygon  # noqa: PLC0415

    loops = [loop.sampled(max_deviation=2e-4 * region.size / 200.0) for loop in region.loops]
    material = Material("unit", 1.0, poisson, 1.0, 1.0, "grey")
    geometry = Geometry(Polygon(loops[0], loops[1:]), material)
    geometry.create_mesh([max_area])
    section = PeerSection(geometry)
    section.calculate_geometric_properties()
    section.calculate_warping_properties()
    return section


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("region", "max_area"),
    [(CHANNEL, 1.0), (BOX, 0.5), (ANGLE, 1.0)],
    ids=["thin-walled open channel", "thin-walled closed box", "angle"],
)
def test_walled_sections_agree_with_the_peer(region, max_area):
    """Torsion constant, shear centre and warping constant agree to 0.1 %, second moments to 1e-9."""
    theirs = peer(region, max_area)
    size = region.size
    for method in ("fem", "vem"):
        options = TorsionCase(method=method, size=0.6 * np.sqrt(max_area) * 1.5)
        ours = run_section(DrawnSection("", Section({"section": region}), "mm"), options).constants
        assert ours.torsion_constant == pytest.approx(theirs.get_ej(), rel=1e-3)
        np.testing.assert_allclose(ours.shear_centre, theirs.get_sc(), atol=1e-3 * size)
        np.testing.assert_allclose(ours.second_moments, theirs.get_eic(), rtol=1e-9, atol=1e-9 * ours.second_moments[0])
        # a section that hardly warps has only noise to compare
        assert ours.warping_constant == pytest.approx(theirs.get_egamma(), rel=1e-3, abs=1e-7 * size**6)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_rail_agrees_with_the_peer(poisson):
    """136RE: torsion and warping constants agree to 0.1 %, centroid and shear centre, also for nu = 0.3, to 0.01 mm."""
    rail = find_section("136RE")
    theirs = peer(rail.section.parts["section"], 16.0, poisson=poisson)
    ours = run_section(rail, TorsionCase(poisson=poisson)).constants
    assert ours.torsion_constant == pytest.approx(theirs.get_ej(), rel=1e-3)
    np.testing.assert_allclose(ours.shear_centre, theirs.get_sc(), atol=1e-2)
    np.testing.assert_allclose(ours.centroid, theirs.get_c(), atol=1e-2)
    # with nu the peer puts another shear centre into the formula that holds for Trefftz's: its constant then depends on
    # nu, which the least integral of the warping squared does not
    if poisson == 0.0:
        assert ours.warping_constant == pytest.approx(theirs.get_egamma(), rel=1e-3)
