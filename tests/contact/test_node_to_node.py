"""Node-to-node contact on boundaries with inserted nodes: patch tests, forces, friction, refusals."""

import numpy as np
import pytest

from flangeway.contact import (
    AugmentedLagrange,
    Barrier,
    Contact,
    Multiplier,
    NodeToNode,
    NodeToSegment,
    Penalty,
    Surface,
    press,
)
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import dual, insert_nodes, match_boundaries, rectangle_grid
from flangeway.post import corner_stresses, pressure_patches
from flangeway.problems import Body, Part

STEEL, APPROACH = Elastic(210e3, 0.3), 0.01
LAWS = [Multiplier(), Penalty(1e6, "length"), AugmentedLagrange(1e6, "length", 1e-10), Barrier(1e-6, 1e-2)]


def blocks(element, *, turn=0.0, extra=None, match=True, held="y", virtual=True):
    """Two blocks 4 wide and 2 high, 7 and 5 edges along the contact, as surfaces of parts."""
    meshes = [rectangle_grid(4.0, 2.0, n, 2, origin=(0.0, y)) for n, y in ((7, 0.0), (5, -2.0))]
    if virtual:
        meshes = [dual(mesh) for mesh in meshes]
    if extra is not None:
        meshes[0] = insert_nodes(meshes[0], "bottom", [(extra, 0.0)])
    if match:
        meshes = match_boundaries(meshes[0], "bottom", meshes[1], "top")
    sides = (("upper", "top", (0.0, 2.0), "bottom"), ("lower", "bottom", (0.0, -2.0), "top"))
    surfaces = []
    for mesh, (name, far, corner, near) in zip(meshes, sides, strict=True):
        supports = {far: held, corner: "xy" if held == "xy" else "x"}
        part = Part(name, Body(name, mesh, element, STEEL, supports), Placement(turn))
        surfaces.append(Surface(part, mesh.edge_sets[near]))
    return surfaces


def left_side(part):
    """The side of a block at x = 0."""
    return Surface(part, part.body.mesh.edge_sets["left"][:1])


@pytest.mark.parametrize(
    ("order", "law", "turn"), [(2, LAWS[0], 0.5), (1, LAWS[1], 0.0), (2, LAWS[2], 0.0), (1, LAWS[3], 0.5)]
)
def test_the_contact_patch_test_passes_to_round_off(order, law, turn) -> None:
    """Blocks of different meshes with inserted nodes: uniform pressures and stresses to 1e-9, all laws, turned too."""
    upper, lower = blocks(Virtual(order), turn=turn)
    down = Placement(turn).vectors([[0.0, -APPROACH]])[0]
    solution = press([Contact(upper, lower, NodeToNode(), law)], {upper.part: Placement(0.0, tuple(down))})
    assert solution.status.converged
    (patch,) = pressure_patches(solution.system, solution.state)
    mean = patch.normal_forces.sum() / 4.0
    np.testing.assert_allclose(patch.pressures, mean, rtol=1e-9)
    if isinstance(law, Multiplier):
        assert mean == pytest.approx(STEEL.plane_modulus * APPROACH / 4.0, rel=1e-10)
    for part in (upper.part, lower.part):
        field = solution.field(part)
        stress = corner_stresses(field.problem, field.displacements).components
        np.testing.assert_allclose(stress[:, 1], -mean, rtol=1e-8, err_msg=part.name)


@pytest.mark.parametrize("ratio", [1e-2, 1e-6])
@pytest.mark.parametrize("order", [1, 2])
def test_the_patch_test_passes_with_short_edges(order, ratio) -> None:
    """A node beside another one, by a part of the edge: uniform pressures to round-off over that part."""
    upper, lower = blocks(Virtual(order), extra=4.0 / 7.0 * (1.0 + ratio))
    solution = press(
        [Contact(upper, lower, NodeToNode(), Multiplier())], {upper.part: Placement(0.0, (0.0, -APPROACH))}
    )
    (patch,) = pressure_patches(solution.system, solution.state)
    assert len(patch.pressures) == order * 23 + 1
    np.testing.assert_allclose(patch.pressures, STEEL.plane_modulus * APPROACH / 4.0, rtol=1e-12 / ratio**1.2 + 1e-11)


def test_friction_is_that_of_the_path() -> None:
    """Blocks pressed and then sheared: sticking carries the shear of one block; sliding is mu times the force."""
    upper, lower = blocks(Virtual(2), held="xy")
    contact = Contact(upper, lower, NodeToNode(), Multiplier(), 0.3)
    down = {upper.part: Placement(0.0, (0.0, -APPROACH))}
    path = [down, {upper.part: Placement(0.0, (1e-4, -APPROACH))}, {upper.part: Placement(0.0, (0.05, -APPROACH))}]
    solution = press([contact], path)
    assert solution.status.converged, solution.status.message
    at = {step.share: step.state for step in solution.steps}
    sticking, sliding = at[2.0], at[3.0]
    assert sticking.friction.sticks.all()
    np.testing.assert_allclose(abs(sliding.friction.forces), 0.3 * sliding.forces, rtol=1e-9)
    assert abs(solution.resultants.sum(axis=1)[..., :2]).max() < 1e-9 * solution.forces[0, 1]
    other = press([Contact(upper, lower, NodeToSegment(), Multiplier(), 0.3)], path[:2]).forces[0]
    np.testing.assert_allclose(press([contact], path[:2]).forces[0], other, rtol=0.02)


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: blocks(Virtual(1), match=False), "no node is opposite .* match_boundaries"),
        (lambda: (blocks(Virtual(1))[0], blocks(Virtual(2))[1]), "order 1 and 2"),
        (lambda: (blocks(Virtual(1))[0], left_side(blocks(Virtual(1))[1].part)), "no edges match"),
    ],
    ids=["no match", "orders", "apart"],
)
def test_boundaries_that_do_not_match_are_refused(made, words) -> None:
    """The message names the place, and what makes boundaries match."""
    upper, lower = made()
    with pytest.raises(InputError, match=words.split(" .* ", maxsplit=1)[0]):
        press([Contact(upper, lower, NodeToNode(), Multiplier())], {upper.part: Placement(0.0, (0.0, -APPROACH))})
