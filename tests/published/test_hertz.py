"""The published Hertz problem: its meshes, contacts, oscillations; its numbers are in `flangeway reproduce hertz`."""

import numpy as np
import pytest

from flangeway.cases.bodies.bodies_model import build_bodies
from flangeway.cases.bodies.presets import HertzCase
from flangeway.contact import Multiplier, NodeToSegment, Penalty, SegmentToSegment
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.post import stresses_along
from studies.hertz import largest_patch, oscillation, published_case

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
    contact = case.contacts[0].model_copy(update={"penalty_MPa_mm": 1.0})
    with pytest.raises(InputError, match="nodal_penalty_N_per_mm"):
        case.model_copy(update={"contacts": [contact]}).check()
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
    assert np.abs(computed - theory.axis_stresses_in_disc(depth, 4.0)).max() < 0.01 * P0
    assert np.abs(computed - theory.stresses(0.0, depth)).max() > 0.02 * P0


@pytest.mark.parametrize(("code", "least", "most"), [("FDO2", 0.1, 1.0), ("VVO2", 0.0, 0.05)])
def test_oscillation_of_pressures_is_as_published(code, least, most):
    """Pressures on M2 oscillate by 10 % or more on triangles of order 2, by less than 5 % on polygons (Figure 76)."""
    x, patch = largest_patch(published_case(code, 2, "halved").run().contact)
    assert least < oscillation(patch.normal_forces / np.gradient(x)) < most
