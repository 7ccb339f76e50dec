"""Rails on sleepers along the track, beside beams, equilibrium, and what regulations call typical of good track."""

from functools import cache

import numpy as np
import pytest

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement, circle
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate
from flangeway.post.section_constants import section_constants
from flangeway.problems import Elasticity, Harmonic
from flangeway.railway.profiles.bundled import rail
from flangeway.railway.track.supports import Continuous, Seats, Sleepers
from flangeway.railway.wheelset.supported_rail import (
    LoadedRail,
    RailAlongTrack,
    SupportedRail,
    narrowest_web,
    rail_problem,
    rails_along_track,
    sleeper_compliance,
    supported_rail,
)
from flangeway.space import Space

YOUNG, POISSON, SIZE = 210e3, 0.3, 11.0
LOAD, LATERAL = 150e3, 50e3  # N
SHEAR_FACTOR = 0.4
"""Of rails in vertical shear: 0.34 to 0.53 in the literature; 0.1 changes the deflection by 0.7 %."""
BETWEEN = (0.0, 0.5)
"""Positions of the wheel over a sleeper and in the middle between two."""


USUAL = Sleepers()
PLACES = np.arange(-2100.0, 2101.0, 75.0)


@cache
def rail_on(name: str = "60E1", support: Seats = USUAL) -> SupportedRail:
    return supported_rail(rail(name), Elastic(YOUNG, POISSON), support, SIZE)


def on_head(name: str, depth: float = 0.0) -> np.ndarray:
    """Top of the head, or the point of its gauge side at a depth."""
    points = rail(name).running_surface.sampled(spacing=0.5)
    top = points[:, 1].max()
    side = points[points[:, 0] <= 0.0]
    return side[np.argmin(np.abs(side[:, 1] - top + depth))]


@cache
def loaded(
    forces: tuple[tuple[float, float, float, float], ...],
    name: str = "60E1",
    support: Seats = USUAL,
    position: float = 0.0,
) -> RailAlongTrack:
    """Rail under forces, each with the depth of its point on the gauge side of the head."""
    points = np.array([on_head(name, depth) for depth, *_ in forces])
    on_head_of = np.array([each for _, *each in forces])
    own = rail_on(name, support.replaced(position=position) if position else support)
    return rails_along_track(own, rail(name), [LoadedRail(points, on_head_of)], z_mm=PLACES)[0]


class Beam:
    """Timoshenko's beam of 18 m under a load in its middle, by elements that are exact for loads at nodes."""

    def __init__(self, bending: float, shear: float, *, step: float = 25.0, half: float = 9000.0) -> None:
        self.step, self.z = step, np.arange(-half, half + step / 2.0, step)
        n = len(self.z)
        ratio = 12.0 * bending / (shear * step**2)
        a, b = (4.0 + ratio) * step**2, (2.0 - ratio) * step**2
        element = np.array(
            [
                [12.0, 6.0 * step, -12.0, 6.0 * step],
                [6.0 * step, a, -6.0 * step, b],
                [-12.0, -6.0 * step, 12.0, -6.0 * step],
                [6.0 * step, b, -6.0 * step, a],
            ]
        )
        self.bending, self.stiffness = bending, np.zeros((2 * n, 2 * n))
        for i in range(n - 1):
            self.stiffness[2 * i : 2 * i + 4, 2 * i : 2 * i + 4] += element * bending / (step**3 * (1.0 + ratio))

    def on_seats(self, places: np.ndarray, stiffness: float, length: float) -> "Beam":
        """Seats that act evenly on their length against their mean displacement."""
        for place in places:
            mean = np.zeros((len(self.z), 2))
            for part in place + length * (np.arange(6) - 2.5) / 6.0:
                mean[:, 0] += np.maximum(1.0 - np.abs(self.z - part) / self.step, 0.0) / 6.0
            self.stiffness += stiffness * np.outer(mean, mean)
        return self

    def continuous(self, modulus: float) -> "Beam":
        """Winkler's foundation."""
        self.stiffness[::2, ::2] += modulus * self.step * np.eye(len(self.z))
        return self

    def held_against_turning(self, stiffness: float) -> "Beam":
        """Moment per angle and length."""
        self.stiffness[1::2, 1::2] += stiffness * self.step * np.eye(len(self.z))
        return self

    def under(self, load: float) -> tuple[np.ndarray, np.ndarray]:
        """Deflections, and bending moments between the nodes."""
        forces = np.zeros(2 * len(self.z))
        forces[len(self.z) // 2 * 2] = load
        moved = np.linalg.solve(self.stiffness, forces)
        return moved[::2], self.bending * np.diff(moved[1::2]) / self.step


@cache
def constants(name: str):
    return section_constants(rail_on(name).problem.elasticity.space, poisson=POISSON)


def beam_of(name: str, support: Seats) -> Beam:
    """The rail as a beam; its base, along z, turns with the section."""
    section = constants(name)
    beam = Beam(YOUNG * section.second_moments[0], SHEAR_FACTOR * YOUNG / (2.0 + 2.0 * POISSON) * section.area)
    along = 1e3 * support.longitudinal_kN_per_mm / support.spacing_mm
    return beam.held_against_turning(along * section.centroid[1] ** 2)


@pytest.mark.parametrize(
    ("position", "seat_kN_per_mm", "n_sleepers"), [(0.0, 30.0, 21), (0.5, 30.0, 21), (0.0, 2.0, 41)]
)
def test_deflection_and_reactions_are_those_of_a_beam_on_sleepers(position, seat_kN_per_mm, n_sleepers) -> None:
    """Base, head and reactions along 3 m are Timoshenko's to 1.5, 3 and 1.5 % of the maxima; soft seats are more."""
    name = "60E1"
    support = Sleepers(vertical_kN_per_mm=seat_kN_per_mm, position=position)
    found = loaded(((0.0, 0.0, -LOAD, 0.0),), name, support, position)
    assert len(found.sleepers_mm) == n_sleepers
    beam = beam_of(name, support).on_seats(found.sleepers_mm, 1e3 * seat_kN_per_mm, support.pad_length_mm)
    deflection, _ = beam.under(-LOAD)
    expected = np.interp(found.z_mm, beam.z, deflection)
    scale = np.abs(expected).max()
    assert np.abs(found.base[:, 1] - expected).max() < 0.015 * scale
    assert np.abs(found.head[:, 1] - expected).max() < 0.03 * scale
    reactions = [
        -1e3 * seat_kN_per_mm * np.interp(place + np.linspace(-60.0, 60.0, 9), beam.z, deflection).mean()
        for place in found.sleepers_mm
    ]
    assert np.abs(found.reactions[:, 1] - reactions).max() < 0.015 * max(reactions)


def test_deflection_and_bending_stress_on_a_continuous_support_are_those_of_a_beam() -> None:
    """Base and stress under the foot are Timoshenko's beam's on Winkler's foundation to 1.5 and 3 % of the maxima."""
    support = Continuous()
    found = loaded(((0.0, 0.0, -LOAD, 0.0),), support=support)
    beam = beam_of("60E1", support).continuous(30e3 / 600.0)
    deflection, moments = beam.under(-LOAD)
    expected = np.interp(found.z_mm, beam.z, deflection)
    assert np.abs(found.base[:, 1] - expected).max() < 0.015 * np.abs(expected).max()
    section, stresses = constants("60E1"), found.stresses
    middle = np.flatnonzero(stresses.regions == "foot")
    middle = middle[np.lexsort((np.abs(stresses.points_mm[middle, 0]), stresses.points_mm[middle, 1]))[:1]]
    away = np.abs(found.z_mm) > 150.0
    moment = np.interp(found.z_mm[away], (beam.z[1:] + beam.z[:-1]) / 2.0, moments)
    bent = moment * section.centroid[1] / section.second_moments[0]
    along = stresses.along_MPa[away][:, middle].mean(axis=1)
    assert np.abs(along - bent).max() < 0.03 * 90.0  # MPa, below the load
    assert along.max() > 40.0
    assert len(found.reactions) == 0


@pytest.mark.parametrize("position", [0.3])
def test_reactions_are_in_equilibrium_with_the_load(position) -> None:
    """Forces sum to 3e-4 of the load, moments to 0.3 %: a share of 0.003 is spread along the rail."""
    found = loaded(((14.0, LATERAL, -LOAD, 0.0),), position=position)
    x, y = on_head("60E1", 14.0)
    forces, moments = found.reactions[:, :2], found.reactions[:, 2]
    np.testing.assert_allclose(forces.sum(axis=0), [-LATERAL, LOAD], atol=3e-4 * LOAD)
    height = y - rail("60E1").outline.bounds()[0, 1]
    assert moments.sum() == pytest.approx(height * LATERAL + x * LOAD, abs=3e-3 * height * LATERAL)


def test_a_force_along_the_track_is_in_equilibrium_with_the_sleepers_before_and_behind() -> None:
    """Its moments about x and y, with its reaction at the base, are those of the sleepers to 2 %."""
    along = 20e3
    held_along = USUAL.replaced(longitudinal_kN_per_mm=1000.0)  # within 1 m
    found = loaded(((14.0, 0.0, 0.0, along),), support=held_along)
    x, y = on_head("60E1", 14.0)
    height = y - rail("60E1").outline.bounds()[0, 1]
    moments = found.sleepers_mm @ found.reactions
    assert moments[1] == pytest.approx(height * along, rel=0.02)
    assert moments[0] == pytest.approx(x * along, rel=0.02)
    assert np.abs(found.reactions[:, :2].sum(axis=0)).max() < 1e-3 * along


def test_what_sleepers_change_is_the_difference_of_both_rails() -> None:
    """The change of the compliance is symmetric, and that of the head's displacements to 1.5 % of the rail's own."""
    name = "60E1"
    points = np.array([on_head(name), on_head(name, 14.0)])
    turned = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    continuous = Continuous()
    assert not sleeper_compliance(rail_on(name, continuous), points, np.stack((np.eye(3),) * 2)).any()
    for position in BETWEEN:
        on_sleepers = rail_on(name, USUAL.replaced(position=position))
        change = sleeper_compliance(on_sleepers, points, np.stack((np.eye(3),) * 2))
        np.testing.assert_allclose(change, change.transpose(2, 3, 0, 1), rtol=0.0, atol=1e-9 * np.abs(change).max())
        frames = np.stack((turned, np.eye(3)))
        in_frames = sleeper_compliance(on_sleepers, points, frames)
        np.testing.assert_allclose(in_frames, np.einsum("nai,nimj,mbj->namb", frames, change, frames), atol=1e-15)
        for axis, load in ((0, (0.0, LATERAL, 0.0, 0.0)), (1, (0.0, 0.0, -LOAD, 0.0))):
            rails = [loaded((load,), name, position=position), loaded((load,), name, continuous)]
            middle = len(rails[0].z_mm) // 2
            discrete, spread = (each.head[middle, axis] for each in rails)
            total = load[axis + 1]
            assert change[0, axis, 0, axis] * total == pytest.approx(discrete - spread, abs=0.015 * abs(spread))
    assert change[0, 0, 0, 0] * LATERAL > 0.02 * abs(spread)  # between the sleepers it matters


def test_gauge_widens_as_in_good_track_under_the_loads_of_the_measuring_car() -> None:
    """89 kN down and 62.3 kN outwards on each rail widen the gauge of 136RE by 1/4 in, to 10 %.

    "Typical good track will increase in total gage by as much as 1/4 inch due to outward rail rotation under GRMS
    loading conditions" (49 CFR 213.110, note 2 of the table; nominal loads of 20 and 14 kip of the Federal Railroad
    Administration's car DOTX 218).
    """
    for position in BETWEEN:
        found = loaded(((0.0, 0.0, -89e3, 0.0), (14.0, 62.3e3, 0.0, 0.0)), "136RE", position=position)
        middle = len(found.z_mm) // 2
        assert 2.0 * found.gauge_outward_mm[middle] == pytest.approx(25.4 / 4.0, rel=0.1)
        assert found.gauge_outward_mm.argmax() == middle


def test_stresses_lie_where_beams_have_them() -> None:
    """A vertical load bends the foot in tension below it, one towards the field side the gauge edge in tension."""
    down = loaded(((0.0, 0.0, -LOAD, 0.0),)).stresses
    value, place = down.peak("foot", down.along_MPa)
    assert 60.0 < value < 120.0
    assert place[1:].tolist() == [0.0, 0.0]
    aside = loaded(((14.0, LATERAL, 0.0, 0.0),)).stresses
    row = len(aside.z_mm) // 2
    edges = [np.argmax(sign * aside.points_mm[:, 0]) for sign in (1.0, -1.0)]
    assert aside.along_MPa[row, edges[0]] > 20.0
    assert aside.along_MPa[row, edges[1]] < -20.0
    with pytest.raises(InputError, match="web"):
        down.peak("head", down.along_MPa)


def test_the_other_side_of_the_track_is_its_mirror_image() -> None:
    """A mirrored rail moves away from the middle of the track by as much."""
    name = "60E1"
    place = on_head(name, 14.0)[None]
    force = np.array([[LATERAL, 0.0, 0.0]])
    placements = Placement(-0.025, (750.0, -172.0)), Placement(0.025, (-750.0, -172.0), True)
    both = [LoadedRail(place, force, each) for each in placements]
    right, left = rails_along_track(rail_on(name), rail(name), both, z_mm=np.array([0.0, 300.0]))
    np.testing.assert_allclose(left.gauge_outward_mm, right.gauge_outward_mm, rtol=1e-9)
    assert right.gauge_outward_mm[0] > right.gauge_outward_mm[1] > 0.5


def test_points_off_the_rail_and_forces_that_do_not_fit_are_refused() -> None:
    """Both errors say what is needed."""
    with pytest.raises(InputError, match="surface"):
        rails_along_track(rail_on(), rail("60E1"), [LoadedRail(np.array([[0.0, 100.0]]), np.zeros((1, 3)))])
    for points, forces in ((np.zeros((1, 3)), np.zeros((1, 3))), (np.zeros((1, 2)), np.full((1, 3), np.nan))):
        with pytest.raises(InputError, match="along x, y and z"):
            rails_along_track(rail_on(), rail("60E1"), [LoadedRail(points, forces)])


def test_loads_that_reach_beyond_all_sleepers_are_refused() -> None:
    """On supports so soft that a rail spreads its load over more than 101 of them, the error says what to change."""
    support = USUAL.replaced(vertical_kN_per_mm=1e-4)
    coarse = supported_rail(rail("60E1"), Elastic(YOUNG, POISSON), support, 3.0 * SIZE)
    with pytest.raises(InputError, match="101 sleepers"):
        sleeper_compliance(coarse, on_head("60E1")[None], np.eye(3)[None])


@pytest.mark.parametrize(("name", "thickness", "height"), [("136RE", 17.46, 90.2), ("60E1", 16.5, None)])
def test_the_web_of_bundled_rails_has_its_nominal_thickness(name, thickness, height):
    """The narrowest place is 11/16 in thick in the 136RE and 16.5 mm in the 60E1."""
    found, left, right = narrowest_web(rail(name).outline)
    assert right - left == pytest.approx(thickness, abs=0.02)
    assert left == pytest.approx(-right, abs=1e-6)
    if height is not None:
        assert found == pytest.approx(height, abs=0.5)


STEEL = Elastic(210e3, 0.3)
SUPPORT = Sleepers(spacing_mm=500.0, vertical_kN_per_mm=30.0, lateral_kN_per_mm=20.0, roll_kNm_per_rad=90.0)


@pytest.mark.parametrize("element", [Lagrange(2), Virtual(1)])
def test_a_rigid_motion_meets_the_stiffness_of_the_seats_over_their_spacing(element) -> None:
    """Translations and the rotation about the middle of the base have the given energies to 1e-9."""
    mesh = triangulate(rail("60E1").outline, size=15.0)
    space = Space(dual(mesh) if isinstance(element, Virtual) else mesh, element)
    problem = rail_problem(space, STEEL, "base", SUPPORT)
    dofs = np.zeros((4, space.n_dofs, 3))
    free = Harmonic(Elasticity(space, STEEL))
    nodes = space.nodes
    dofs[0, :, 0] = dofs[1, :, 1] = dofs[2, :, 2] = 1.0
    dofs[3, :, 0], dofs[3, :, 1] = -nodes[:, 1], nodes[:, 0]
    for motion, expected in zip(dofs, (20e3 / 500.0, 30e3 / 500.0, 10e3 / 500.0, 90e6 / 500.0), strict=True):
        energies = [motion.ravel() @ each.stiffness(0.0).times(motion.ravel()) for each in (problem, free)]
        assert energies[0] == pytest.approx(expected, rel=1e-9)
        assert abs(energies[1]) < 1e-6 * expected


def test_the_support_covers_the_whole_base() -> None:
    """A base of some of its edges, or of others too, and a round body without one are refused."""
    mesh = triangulate(rail("136RE").outline, size=15.0)
    base = mesh.edge_set("base")
    for edges in (base[1:], np.unique(np.vstack((base, mesh.boundary_edges[:40])), axis=0)):
        with pytest.raises(InputError, match="as the base of"):
            rail_problem(Space(mesh.with_edge_set("some", edges), Lagrange(1)), STEEL, "some", SUPPORT)
    bar = triangulate(circle(10.0), size=3.0)
    bar = bar.with_edge_set("low", bar.boundary_edges[:2])
    with pytest.raises(InputError, match="flat base"):
        rail_problem(Space(bar, Lagrange(1)), STEEL, "low", SUPPORT)


def test_sleepers_lie_about_the_wheel() -> None:
    """The last sleeper is behind the wheel by its position, as many are before as behind, none if continuous."""
    places = Sleepers(position=0.25).sleepers_mm(5)
    np.testing.assert_allclose(places, [-1350.0, -750.0, -150.0, 450.0, 1050.0])
    np.testing.assert_allclose(Sleepers(position=0.75).sleepers_mm(5), -places[::-1])
    assert len(rail_on(support=Continuous()).sleepers_mm) == 0
