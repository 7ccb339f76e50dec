"""Closed-form solutions of elasticity satisfy their equations; limits of plastic cylinders and repeated rolling."""

from functools import cache

import numpy as np
import pytest

from flangeway.elements import Lagrange, StabilisationFree
from flangeway.errors import InputError
from flangeway.exact import LineContact
from flangeway.exact.half_space import half_space_stresses
from flangeway.exact.shakedown import shakedown_limits
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate, voronoi
from flangeway.problems import Elasticity, Harmonic, PrescribedDisplacement, Pressure, Traction
from flangeway.solve import solve_elasticity, solve_harmonic
from flangeway.space import Space
from flangeway_studies.forms import half_plastic, mapped, rim_displacement, ring
from flangeway_studies.hole import PlateWithHole
from flangeway_studies.thick_cylinder import ThickCylinder


def test_thick_cylinder_is_in_balance_and_meets_the_pressures() -> None:
    """Radial stresses are minus the pressures at both walls and ``d(r sigma_r)/dr`` is the hoop stress."""
    cylinder = ThickCylinder(1.0, 3.0, 7.0, 2.0)
    assert cylinder.radial_stress(np.array([1.0, 3.0])) == pytest.approx([-7.0, -2.0])
    r, step = np.linspace(1.1, 2.9, 7), 1e-6
    slope = ((r + step) * cylinder.radial_stress(r + step) - (r - step) * cylinder.radial_stress(r - step)) / (2 * step)
    assert slope == pytest.approx(cylinder.hoop_stress(r), rel=1e-6)


@pytest.mark.parametrize("plane_strain", [True, False])
def test_thick_cylinder_obeys_hooke(plane_strain: bool) -> None:
    """The hoop strain u / r is Hooke's for the stresses."""
    cylinder, young, poisson = ThickCylinder(1.0, 3.0, 7.0, 2.0), 100.0, 0.3
    r = np.linspace(1.0, 3.0, 5)
    radial, hoop = cylinder.radial_stress(r), cylinder.hoop_stress(r)
    axial = poisson * (radial + hoop) if plane_strain else 0.0
    strain = cylinder.radial_displacement(r, young, poisson, plane_strain=plane_strain) / r
    assert strain == pytest.approx((hoop - poisson * (radial + axial)) / young)


@pytest.mark.parametrize("hypothesis", ["plane_strain", "plane_stress"])
def test_kirsch_displacements_have_kirsch_stresses(hypothesis: str) -> None:
    """Hooke's law on the displacements' differences gives the stresses, which vanish on the hole along its normal."""
    plate, material, step = PlateWithHole(2.0, 5.0), Elastic(100.0, 0.3, hypothesis), 1e-6
    kolosov = 3.0 - 1.2 if hypothesis == "plane_strain" else 2.7 / 1.3
    points = np.array([[2.5, 0.4], [-1.0, 3.0], [0.1, -2.2]])
    slopes = [
        plate.displacements(points + move, material.shear_modulus, kolosov)
        - plate.displacements(points - move, material.shear_modulus, kolosov)
        for move in step * np.eye(2)
    ]
    gradient = np.stack(slopes, axis=2) / (2.0 * step)
    stress = np.einsum("ijkl,nkl->nij", material.stiffness, gradient)
    expected = plate.stresses(points)
    assert stress[:, [0, 1, 0], [0, 1, 1]] == pytest.approx(expected, abs=1e-6)
    angle = np.linspace(0.0, np.pi, 5)
    normal = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    xx, yy, xy = plate.stresses(2.0 * normal).T
    assert xx * normal[:, 0] + xy * normal[:, 1] == pytest.approx(0.0, abs=1e-12)
    assert xy * normal[:, 0] + yy * normal[:, 1] == pytest.approx(0.0, abs=1e-12)


def test_impossible_radii_are_refused() -> None:
    """A wall without thickness and a hole without radius are input errors."""
    with pytest.raises(InputError, match="inner_radius"):
        ThickCylinder(2.0, 2.0, 1.0)
    with pytest.raises(InputError, match="radius"):
        PlateWithHole(0.0, 1.0)


def test_elements_without_stabilisation_move_the_rim_as_the_closed_form_says():
    """On duals within 0.5 % of Hill's radial displacement; the inner part has flowed."""
    solution, moved = half_plastic(Space(mapped("duals", 8, 16, ring), StabilisationFree(1)))
    assert solution.status.converged
    assert moved == pytest.approx(rim_displacement(), rel=5e-3)
    assert solution.history[np.linalg.norm(solution.points, axis=1) < 1.3, 4].min() > 0.0


POISSON = 0.3
Fields = tuple[np.ndarray, np.ndarray]


@pytest.mark.parametrize(("contact", "first_yield", "rolling"), [("line", 3.11, 4.0), ("point", 2.80, 4.68)])
def test_limits_without_traction_are_the_published_ones(contact, first_yield, rolling):
    """Johnson (1985, 4.2, 9.2): 3.1 and 4.0 for a line; Ponter, Hearle and Johnson (1985): 2.8 and 4.7 for a circle."""
    found = shakedown_limits(contact, 0.0)
    assert float(found.first_yield) == pytest.approx(first_yield, rel=3e-3)
    assert float(found.shakedown) == pytest.approx(rolling, rel=3e-3)
    assert float(found.hardening) == pytest.approx(rolling, rel=3e-3)


@pytest.mark.parametrize(("contact", "least"), [("line", 0.367), ("point", 0.30)])
def test_beyond_a_traction_the_surface_flows(contact, least):
    """There, and not before, shakedown ends at p0 = k / mu; for a line that is mu = 0.367 (Johnson, 1985)."""
    traction = np.linspace(0.0, 1.0, 401)
    found = shakedown_limits(contact, traction)
    at_surface = np.abs(found.shakedown * traction - 1.0) < 5e-3
    assert at_surface[traction > least + 0.01].all()
    assert not at_surface[traction < least - 0.03].any()
    for values in (found.first_yield, found.shakedown, found.hardening):
        assert (np.diff(values) < 0.0).all()
    assert (found.first_yield < found.shakedown).all()


@pytest.mark.parametrize("traction", [0.0, 0.2, 0.4, 0.7])
@pytest.mark.parametrize("contact", ["line", "point"])
def test_limits_follow_from_the_stresses(contact, traction):
    """First yield, the maximum shear stress parallel to the surface, and the smallest sphere about each path: 1 %."""
    pressure, shear = {"line": _of_line, "point": _of_point}[contact]()
    stresses = pressure + traction * shear
    xx, dd, zz, xd, dz, xz = np.moveaxis(stresses, -1, 0)
    # sqrt(J2) is the length of these
    paths = np.stack(((xx - dd) / 2.0, (2.0 * zz - xx - dd) / np.sqrt(12.0), xd, dz, xz), axis=-1)
    found = shakedown_limits(contact, traction)
    assert float(found.first_yield) == pytest.approx(1.0 / np.linalg.norm(paths, axis=-1).max(), rel=0.01)
    assert float(found.shakedown) == pytest.approx(1.0 / np.abs(dz).max(), rel=0.01)
    assert float(found.hardening) == pytest.approx(1.0 / smallest_spheres(paths).max(), rel=0.01)


def smallest_spheres(paths: np.ndarray) -> np.ndarray:
    """Radii of the smallest spheres about points (..., n, 5) (Badoiu and Clarkson, 2003)."""
    centres = paths.mean(axis=-2)
    for step in range(1, 400):
        lengths = np.linalg.norm(paths - centres[..., None, :], axis=-1)
        farthest = np.take_along_axis(paths, lengths.argmax(axis=-1)[..., None, None], axis=-2)[..., 0, :]
        centres = centres + (farthest - centres) / (step + 1)
    return np.linalg.norm(paths - centres[..., None, :], axis=-1).max(axis=-1)


@cache
def _of_line() -> Fields:
    depth, z = np.meshgrid(np.linspace(0.0, 0.9, 46), np.linspace(-1.6, 1.6, 161), indexing="ij")
    contact = LineContact.of_max_pressure(1.0, 1.0, 1.0)
    plane = contact.stresses(contact.half_width * z, contact.half_width * depth)
    root = np.sqrt(1.0 - (z + 1j * np.maximum(depth, 1e-12)) ** 2)
    m, n = np.abs(root.real), np.sign(z) * np.abs(root.imag)
    along = n * (2.0 - (depth**2 - m**2) / (m**2 + n**2)) - 2.0 * z
    sheared = np.stack((along, plane[..., 2], plane[..., 0]), axis=-1)
    return _in_space(plane), _in_space(sheared)


def _in_space(plane: np.ndarray) -> np.ndarray:
    """Components xx, dd, zz, xd, dz, xz of plane strain across x, with a point before the passage."""
    along, across, shear = np.moveaxis(plane, -1, 0)
    zero = np.zeros_like(along)
    found = np.stack((POISSON * (along + across), across, along, zero, shear, zero), axis=-1)
    return np.concatenate((found, np.zeros_like(found[:, :1])), axis=1)


@cache
def _of_point() -> Fields:
    ends = np.linspace(-1.0, 1.0, 33)
    cells = np.stack((ends[:-1], ends[1:]), axis=1)
    fine = (ends[:-1, None] + np.diff(ends)[0] * (np.arange(8) + 0.5) / 8.0).ravel()
    pressures = np.sqrt(np.maximum(1.0 - fine[:, None] ** 2 - fine**2, 0.0)).reshape(32, 8, 32, 8).mean(axis=(1, 3))
    depth, z = np.meshgrid([0.27, 0.33, 0.4, 0.47], np.append(np.linspace(-1.4, 1.4, 57), 1e3), indexing="ij")
    places = np.stack((np.zeros(z.size), depth.ravel(), z.ravel()), axis=1)
    shears = np.stack((np.zeros_like(pressures), pressures), axis=2)
    inside = [
        half_space_stresses(cells, cells, loads, places, POISSON, drawn).reshape(*z.shape, 6)
        for loads, drawn in ((pressures, None), (np.zeros_like(pressures), shears))
    ]
    return tuple(
        np.concatenate((values, surface), axis=0) for values, surface in zip(inside, _of_surface(), strict=True)
    )


def _of_surface() -> Fields:
    """Stresses along the middle of a circle at the surface (Johnson, 1985, eqs 3.42 and 7.20), and none before it."""
    z = np.append(np.linspace(-1.0, 1.0, 57), 0.0)[None]
    root = np.sqrt(1.0 - z**2)
    ring = (1.0 - 2.0 * POISSON) / 3.0 * np.where(z**2 > 1e-8, (1.0 - root**3) / np.maximum(z**2, 1e-8), 1.5)
    zero = np.zeros_like(z)
    pressed = np.stack((-ring - 2.0 * POISSON * root, -root, ring - root, zero, zero, zero), axis=-1)
    across, along = -3.0 * np.pi * POISSON * z / 8.0, -np.pi * (4.0 + POISSON) * z / 8.0
    sheared = np.stack((across, zero, along, zero, -root, zero), axis=-1)
    for each in (pressed, sheared):
        each[:, -1] = 0.0
    return pressed, sheared


RING = square(1.0, (1.5, 0.5))
POLYGONS = {"voronoi": lambda: voronoi(RING, 100), "duals": lambda: dual(triangulate(RING, size=0.15))}


@pytest.mark.parametrize("name", POLYGONS)
@pytest.mark.parametrize(("order", "tolerance"), [(1, 8e-3), (2, 5e-4), (3, 2e-5)])
def test_rings_without_stabilisation_have_the_energy_of_the_thick_cylinder(name, order, tolerance):
    """Half of the pressure times the displaced bore, Lame in plane strain."""
    supports = [PrescribedDisplacement(edges, y=0.0) for edges in ("bottom", "top")]
    space, material = Space(POLYGONS[name](), StabilisationFree(order)), Elastic(200.0, 0.3, "axisymmetric")
    problem = Elasticity(space, material, loads=[Pressure("left", 1.0)], supports=supports)
    energy = 0.5 * np.sum(problem.load_vector() * solve_elasticity(problem).displacements)
    displaced = ThickCylinder(1.0, 2.0, 1.0).radial_displacement(1.0, 200.0, 0.3, plane_strain=True)
    assert energy == pytest.approx(np.pi * displaced, rel=tolerance)


@pytest.mark.parametrize("hypothesis", ["plane_strain", "axisymmetric"])
@pytest.mark.parametrize(("order", "tolerance"), [(1, 8e-3), (2, 8e-4), (3, 3e-4)])
def test_waves_without_stabilisation_have_the_energy_of_finite_elements(hypothesis, order, tolerance):
    """Two waves around a ring, and a wave along a prism, beside triangles of order 3."""

    def energy(mesh, element):
        body = Elasticity(Space(mesh, element), Elastic(200.0, 0.3, hypothesis), loads=[Traction("top", (0.0, 1.0))])
        return solve_harmonic(Harmonic(body, held={"bottom": "xyz"}), 2.0).energy

    expected = energy(triangulate(RING, size=0.08), Lagrange(3))
    assert energy(POLYGONS["voronoi"](), StabilisationFree(order)) == pytest.approx(expected, rel=tolerance)
