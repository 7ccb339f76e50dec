"""The published Hertz problem and flange root; the numbers are in `flangeway reproduce hertz`."""

import math

import numpy as np
import pytest

from flangeway.cases.bodies.presets import HertzCase
from flangeway.contact import Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.contact.bodies_model import build_bodies
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.geometry import Arc
from flangeway.post import stresses_along
from flangeway.railway.profiles.bundled import IDENTIFIED, IDENTIFIED_RADIUS_MM, wheel
from flangeway.railway.profiles.named import profile_of
from flangeway.railway.track.wheelset_problem import Plane
from flangeway_studies.discs import axis_stresses_in_disc
from flangeway_studies.flange_root import with_flange_root
from flangeway_studies.hertz import largest_patch, oscillation, published_case

P0 = 671.5


def model_of(code, level=1, variant="printed"):
    """Meshed discs and their contact."""
    return build_bodies(published_case(code, level, variant).general())


def test_edges_of_the_arc_are_halved_once():
    """A halved side makes each triangle with one edge on it a quadrilateral and leaves area and others alone."""
    mesh, fine = (model_of(code).bodies["lower"].problem.space.mesh for code in ("FDO2", "HEO2"))
    n_arc = len(mesh.edge_set("arc"))
    assert len(fine.edge_set("arc")) == 2 * n_arc
    assert fine.n_points == mesh.n_points + n_arc
    assert (fine.cell_sizes[fine.cell_set("polygons")] == 4).all()
    assert (fine.cell_sizes[fine.cell_set("triangles")] == 3).all()
    np.testing.assert_allclose(fine.cell_areas, mesh.cell_areas, rtol=1e-9)


def test_variants_name_contact():
    """Node-to-segment has the printed penalty at nodes; segment-to-segment multipliers, dual weights and circles."""
    contact = model_of("FDO1").contacts[0]
    assert contact.enforcement == Penalty(1e5, per="node")
    assert contact.pairing == NodeToSegment(slack=0.02)
    assert contact.secondary.curve is None
    smooth = model_of("VVO2", variant="segments").contacts[0]
    assert smooth.enforcement == Multiplier()
    assert smooth.pairing == SegmentToSegment(weighting="dual")
    assert smooth.secondary.curve is not None
    assert smooth.secondary.part.body.space.element == Virtual(2)


def test_wrong_input_is_refused():
    """An arc too narrow for the contact, or of a block, halved edges without it, and two penalties are refused."""
    values = published_case("FDO1", 1).model_dump(exclude_unset=True)
    for changed, named in (
        ({"fine_arc_deg": 6.0}, "fine_arc_deg"),
        ({"lower": "block"}, "block"),
        ({"fine_arc_deg": None, "halved_edges": True}, "halved_edges"),
    ):
        with pytest.raises(InputError, match=named):
            HertzCase.from_values({**values, **changed}).check()
    case = published_case("FDO1", 1).general()
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        case.contacts[0].replaced(enforcement={"penalty_MPa_mm": 1.0})
    body = case.bodies[0].model_copy(update={"halved_side": "side"})
    with pytest.raises(InputError, match="halved_side"):
        case.model_copy(update={"bodies": [body, case.bodies[1]]}).check()


def test_every_load_step_converges_and_stresses_on_the_axis_are_those_of_a_disc():
    """Ten steps of six iterations at most; from 0.1 to 1 cm down within 1 % of p0, a half plane's are 2 % off."""
    case = published_case("VVO2", 2, "segments")
    run = case.run()
    assert [step.state.status.iterations <= 6 for step in run.contact.steps] == [True] * 10
    line = stresses_along(run.bodies["lower"].field, (0.0, -0.1), (0.0, -1.0), 101)
    depth, computed = -line.points[:, 1], line.stresses.components[:, :3]
    theory = case.theory(float(run.contact.forces[0, 1]))
    assert np.abs(computed - axis_stresses_in_disc(theory, depth, 4.0)).max() < 0.01 * P0
    assert np.abs(computed - theory.stresses(0.0, depth)).max() > 0.02 * P0


@pytest.mark.parametrize(("code", "least", "most"), [("FDO2", 0.1, 1.0), ("VVO2", 0.0, 0.05)])
def test_oscillation_of_pressures_is_as_published(code, least, most):
    """Pressures on M2 oscillate by 10 % or more on triangles of order 2, by less than 5 % on polygons (Figure 76)."""
    x, patch = largest_patch(published_case(code, 2, "halved").run().contact)
    assert least < oscillation(patch.normal_forces / np.gradient(x)) < most


@pytest.mark.parametrize("radius", [30.0, 38.1, 49.2, 60.0])
def test_the_family_keeps_what_is_known_of_the_wheel(radius):
    """Taper, height, thickness and angle of the flange, narrow arc and slope between the arcs stay; no kink appears."""
    made = with_flange_root(wheel(), radius)
    parts = dict(zip(made.outline.names, made.outline.segments, strict=True))
    narrow, wide, tread, face = (
        parts[n] for n in ("flange_root_R1", "flange_root_R2", "tread_1:20", "flange_face_75deg")
    )
    assert isinstance(narrow, Arc)
    assert narrow.radius == pytest.approx(14.2875, abs=1e-4)
    assert 1.0 / abs(wide.curvature) == pytest.approx(radius, rel=1e-6)
    assert np.degrees(np.arctan(tread.tangent(0.0)[0] @ (0, 1))) == pytest.approx(
        math.degrees(math.atan(0.05)), abs=0.01
    )
    assert face.tangent(0.0)[0] == pytest.approx((math.cos(math.radians(75)), math.sin(math.radians(75))), abs=1e-5)
    for one, following in ((parts["flange_tip_front"], face), (face, narrow), (narrow, wide), (wide, tread)):
        assert one.tangent(1.0)[0] == pytest.approx(following.tangent(0.0)[0], abs=2e-5)
    assert wide.tangent(0.0)[0][1] == pytest.approx(math.sin(math.radians(30.0)), abs=1e-4)
    assert (made.flange_height_mm, made.outline.bounds()[0, 1]) == pytest.approx((25.4, -25.4))
    points = made.running_surface.sampled(max_deviation=1e-6)
    front = points[points[:, 0] > -60.0]
    thickness = np.interp(9.525, -front[::-1, 1], front[::-1, 0]) - made.outline.bounds(["back_face"])[0, 0]
    assert thickness == pytest.approx(34.925, abs=2e-3)


def test_roots_that_do_not_fit_are_refused():
    """A radius that leaves no room, and other wheels are refused."""
    for radius in (10.0, 90.0, float("nan")):
        with pytest.raises(InputError, match="flange root"):
            with_flange_root(wheel(), radius)
    with pytest.raises(InputError, match="flange root"):
        with_flange_root(wheel("S1002"), 40.0)


def test_the_identified_wheel_has_the_root_of_its_radius():
    """The bundled contour is that of the AAR-1B with the wide arc of the identified radius, to the last bit."""
    assert profile_of(IDENTIFIED, "wheel").outline == with_flange_root(wheel(), IDENTIFIED_RADIUS_MM).outline


def test_a_nodal_penalty_is_of_node_to_segment_alone():
    """A penalty per node with segment-to-segment or with multipliers is refused, since it would do nothing."""
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        Plane(nodal_penalty_N_per_mm=1e7)
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        Plane(pairing="node-to-segment", enforcement="multiplier", nodal_penalty_N_per_mm=1e7)
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        Plane(pairing="node-to-segment", nodal_penalty_N_per_mm=-1.0)
