"""Bending, shear, plastic moments and stresses beside sectionproperties on its own mesh, to six digits."""

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.forms import BeamSection
from flangeway.mesh import PolyMesh, dual, rectangle_grid
from flangeway.space import Space

pytest.importorskip("sectionproperties", reason="the peer is installed with the extra 'dev'")

POISSON = 0.3
RESULTANTS = {"n": 1e3, "mxx": 1e5, "myy": 2e5, "mzz": 3e4, "vx": 500.0, "vy": 700.0}


def angle_section(materials):
    from sectionproperties.pre.library import angle_section as make  # noqa: PLC0415

    return make(d=150, b=100, t=12, r_r=0, r_t=0, n_r=1, material=materials[0])


def composite(materials):
    """A rectangle of one material on a wider one, off its middle."""
    from sectionproperties.pre.library import rectangular_section  # noqa: PLC0415

    low = rectangular_section(d=20, b=100, material=materials[0])
    return low + rectangular_section(d=60, b=30, material=materials[1]).shift_section(10, 20)


def peer(make):
    """Their section, and ours on their triangles of order 2."""
    from sectionproperties.analysis import Section  # noqa: PLC0415
    from sectionproperties.pre import Material  # noqa: PLC0415

    materials = [Material(n, e, POISSON, y, 1.0, "grey") for n, e, y in (("soft", 1.0, 2.0), ("hard", 3.0, 1.0))]
    geometry = make(materials)
    geometry.create_mesh([20.0])
    theirs = Section(geometry)
    theirs.calculate_geometric_properties()
    theirs.calculate_warping_properties()
    theirs.calculate_plastic_properties()
    triangles = theirs.mesh["triangles"][:, :3]
    used, corners = np.unique(triangles, return_inverse=True)
    mesh = PolyMesh(theirs.mesh["vertices"][used], np.arange(len(triangles) + 1) * 3, corners.ravel())
    hard = np.array([element.material.name == "hard" for element in theirs.elements])
    mesh = (
        mesh.with_cell_set("soft", ~hard).with_cell_set("hard", hard)
        if hard.any()
        else mesh.with_cell_set("soft", ~hard)
    )
    values = {"soft": (1.0, 2.0), "hard": (3.0, 1.0)}
    young, strength = ({name: values[name][i] for name in mesh.cell_sets} for i in range(2))
    return theirs, BeamSection(Space(mesh, Lagrange(2)), young, POISSON), strength


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("make", [angle_section, composite])
def test_constants_and_stresses_are_those_of_the_peer(make):
    """One material and two: all constants and the stresses under N, V, M and T at once, to 1e-6."""
    theirs, ours, strength = peer(make)
    p = theirs.section_props
    np.testing.assert_allclose(ours.axial, theirs.section_props.ea, rtol=1e-9)
    np.testing.assert_allclose(ours.centroid, theirs.get_c(), rtol=1e-9)
    np.testing.assert_allclose(ours.bending, theirs.get_eic(), rtol=1e-9)
    np.testing.assert_allclose(np.cos(2.0 * ours.angle), np.cos(np.radians(2.0 * p.phi)), atol=1e-9)
    np.testing.assert_allclose(ours.torsion, theirs.get_ej(), rtol=1e-6)
    np.testing.assert_allclose(ours.shear_centre + ours.centroid, theirs.get_sc(), atol=1e-5)
    np.testing.assert_allclose(ours.shear_areas, [p.a_sx, p.a_sy, p.a_sxy], rtol=2e-6)
    np.testing.assert_allclose(ours.monosymmetry(), [p.beta_x_minus, p.beta_y_minus], rtol=1e-6, atol=1e-5)
    turned = np.abs(ours.monosymmetry(np.radians(p.phi)))
    np.testing.assert_allclose(turned, np.abs([p.beta_11_minus, p.beta_22_minus]), rtol=1e-6)
    # the peer finds plastic axes to a tolerance of its own, and moments by yield stress
    level, moment = ours.plastic(strength)
    across, other = ours.plastic(strength, np.pi / 2.0)
    np.testing.assert_allclose([level, -across], [p.y_pc, p.x_pc], atol=1e-5)
    np.testing.assert_allclose([moment, other], [p.sxx, p.syy], rtol=1e-6)
    turned = [ours.plastic(strength, np.radians(p.phi) + more)[1] for more in (0.0, np.pi / 2.0)]
    np.testing.assert_allclose(turned, [p.s11, p.s22], rtol=1e-6)
    points = ours.space.mesh.cell_centroids[::7]
    wanted = theirs.get_stress_at_points([tuple(each) for each in points], **RESULTANTS)
    found = ours.stresses(points, force=1e3, shear=(500.0, 700.0), moments=(1e5, 2e5), torque=3e4)
    np.testing.assert_allclose(found, np.array(wanted), rtol=1e-6, atol=1e-6 * np.abs(found).max())


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(2), Virtual(3)])
def test_a_rectangle_has_the_known_constants(element):
    """Shear area 5 A / 6 with nu = 0, plastic modulus b h^2 / 4, shear stress 3 V / 2 A in the middle."""
    mesh = rectangle_grid(2.0, 3.0, 8, 12, origin=(4.0, 5.0))
    section = BeamSection(Space(mesh if isinstance(element, Lagrange) else dual(mesh), element), 7.0)
    np.testing.assert_allclose(section.centroid, [5.0, 6.5], rtol=1e-10)
    np.testing.assert_allclose(section.shear_areas[:2], 7.0 * 5.0 * np.ones(2), rtol=5e-4)
    np.testing.assert_allclose(section.shear_centre, 0.0, atol=1e-8)
    np.testing.assert_allclose(section.plastic(), (0.0, 4.5), atol=1e-9)
    np.testing.assert_allclose(section.plastic(angle=np.pi / 2.0), (0.0, 3.0), atol=1e-9)
    np.testing.assert_allclose(section.monosymmetry(0.3), 0.0, atol=1e-6)
    stress = section.stresses([(5.01, 6.51)], shear=(0.0, 10.0))[0]
    np.testing.assert_allclose(stress, [0.0, 0.0, 1.5 * 10.0 / 6.0], atol=0.02)


WRONG = {
    "poisson": lambda s: BeamSection(s, 1.0, 0.6),
    "young": lambda s: BeamSection(s, -1.0),
    "yield_stress": lambda s: BeamSection(s).plastic(0.0),
    "outside of the mesh": lambda s: BeamSection(s).stresses([(9.0, 9.0)], force=1.0),
}


@pytest.mark.parametrize("words", WRONG)
def test_wrong_input_is_named(words):
    """Each error says what was wrong."""
    with pytest.raises(InputError, match=words):
        WRONG[words](Space(rectangle_grid(1.0, 1.0, 2, 2), Lagrange(2)))
