"""Wear laws on Hertz's ellipse in full slip (more in `flangeway reproduce damage`), and profiles that wear."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.railway.damage.wear_laws import ArchardLaw, CellLoads, EnergyLaw, OwnLaw, PerPatch, UsfdLaw
from flangeway.railway.damage.worn_surface import WornSurface
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.track.placements import Track
from flangeway_studies.damage import A_MM, B_MM, FRICTION, WEAR_COEFFICIENT, HARDNESS_MPa, P0_MPa, SPEED_m_s, full_slip

Y = np.array([0.0, 2.0, 3.5])


def rows(creepage: float, n: int = 4000) -> tuple[CellLoads, np.ndarray]:
    """Cells of rows at Y in full slip, even in the angle of ``x = a cos t``, and their lengths."""
    half = A_MM * np.sqrt(1.0 - (Y / B_MM) ** 2)
    ends = np.cos(np.linspace(np.pi, 0.0, n + 1))
    x = half[:, None] * np.cos(np.pi - np.pi * (np.arange(n) + 0.5) / n)
    pressures = P0_MPa * np.sqrt(1.0 - (x / A_MM) ** 2 - (Y[:, None] / B_MM) ** 2)
    lengths = half[:, None] * np.diff(ends)
    along = np.zeros((*x.shape, 2))
    along[..., 1] = 1.0
    tractions = -FRICTION * pressures[..., None] * along
    return CellLoads(pressures, tractions, creepage * along, lengths, SPEED_m_s), lengths


@pytest.mark.parametrize("branch", ["continuous", "published"])
def test_usfd_branches_in_full_slip_are_those_of_quadrature(branch: str) -> None:
    """At creepage 0.2 a row has all three branches: its depth is that of pieces with closed forms to 1e-3."""
    creepage = 0.2
    cells, lengths = rows(creepage)
    depth = (UsfdLaw(branch=branch).rates(cells) * lengths).sum(axis=1)
    top, third = FRICTION * creepage * P0_MPa, 61.9
    offset = 55.0 - third * 77.2 if branch == "continuous" else 0.0
    exact = []
    for y in Y:
        share = np.sqrt(1.0 - (y / B_MM) ** 2)
        peak, half = top * share, A_MM * share
        # |x| at which T-gamma / A_MM falls below a limit, and the integral of sqrt(1 - (x/half)^2) up to there
        cut = [half * np.sqrt(max(1.0 - (limit / peak) ** 2, 0.0)) for limit in (77.2, 10.4)]
        area = [0.5 * half * (c / half * np.sqrt(1.0 - (c / half) ** 2) + np.arcsin(c / half)) for c in (*cut, half)]
        steep = third * peak * area[0] + offset * cut[0]
        exact.append(2.0 * (steep + 55.0 * (cut[1] - cut[0]) + 5.3 * peak * (area[2] - area[1])) * 1e-3 / 7800.0)
    assert depth == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize(
    ("velocity", "pressure", "k"),
    [(0.1, 0.5, 5.5e-4), (0.3, 0.5, 35e-4), (0.9, 0.5, 5.5e-4), (0.3, 0.9, 350e-4), (0.9, 0.81, 350e-4)],
)
def test_map_of_jendel(velocity: float, pressure: float, k: float) -> None:
    """The coefficient is the middle of the range of its region."""
    law = ArchardLaw(hardness_MPa=HARDNESS_MPa)
    found = law.coefficients(np.array([velocity]), np.array([pressure * HARDNESS_MPa]))
    assert found == pytest.approx([k])


def test_level_moves_through_the_ranges_of_the_map() -> None:
    """Levels 0 and 1 are the ends of the range."""
    ends = [
        ArchardLaw(hardness_MPa=HARDNESS_MPa, level=level).coefficients(np.array([0.3]), np.array([1.0]))[0]
        for level in (0.0, 1.0)
    ]
    assert ends == pytest.approx([30e-4, 40e-4])


def test_energy_law_takes_energy_times_its_constant() -> None:
    """0.02 mm3/kJ of 300 J/m are 0.006 mm3/m, and 156 ug/kJ = 0.156 mg/kJ the same."""
    cells = full_slip()[0]
    for law in (EnergyLaw(constant=0.02, unit="mm3/kJ"), EnergyLaw(constant=0.156, unit="mg/kJ")):
        assert 1e3 * float((law.rates(cells) * cells.areas).sum()) == pytest.approx(2e-5 * cells.t_gamma_N, rel=1e-12)


def test_own_law_is_that_of_its_function() -> None:
    """A_MM function that is Archard's law in um/m gives Archard's depths."""
    cells, _ = full_slip()

    def archard(pressures: np.ndarray, slips: np.ndarray, tractions: np.ndarray) -> np.ndarray:
        return 1e6 * WEAR_COEFFICIENT * pressures * np.hypot(*np.moveaxis(slips, -1, 0)) / HARDNESS_MPa

    assert OwnLaw(archard, "um/m").rates(cells) == pytest.approx(
        ArchardLaw(hardness_MPa=HARDNESS_MPa, k=WEAR_COEFFICIENT).rates(cells)
    )


def test_per_patch_differs_from_local_only_where_the_constant_varies() -> None:
    """Volumes per patch and local agree for a constant k in full slip, and differ by the map and by USFD's branches."""

    def volumes(law: ArchardLaw | UsfdLaw, cells: CellLoads) -> float:
        local, mean = (float((each.rates(cells) * cells.areas).sum()) for each in (law, PerPatch(law)))
        return mean / local

    assert volumes(ArchardLaw(hardness_MPa=HARDNESS_MPa, k=WEAR_COEFFICIENT), full_slip()[0]) == pytest.approx(1.0)
    assert volumes(UsfdLaw(), full_slip()[0]) == pytest.approx(1.0)
    assert abs(volumes(UsfdLaw(), full_slip(creepage=0.03)[0]) - 1.0) > 0.05
    high = full_slip()[0]
    assert (
        volumes(ArchardLaw(hardness_MPa=2000.0), high) < 0.5
    )  # only the middle of the patch has pressures above 0.8 of H


def test_a_patch_without_pressure_wears_nothing() -> None:
    """Per patch as well, whose means are over no area."""
    none = CellLoads(np.zeros((2, 3)), np.zeros((2, 3, 2)), np.zeros((2, 3, 2)), np.ones((2, 3)), 20.0)
    assert not PerPatch(ArchardLaw(hardness_MPa=HARDNESS_MPa)).rates(none).any()


PROFILES = {"S1002": wheel("S1002"), "60E1": rail("60E1")}


def hollow(name: str, most: float, width: float = 8.0) -> WornSurface:
    """A surface with a Gaussian hollow of a depth, in the middle of its arc length on rails, on the tread of wheels."""
    fresh = WornSurface(PROFILES[name])
    middle = fresh.surface.length * (0.5 if "E" in name else 0.62)
    return WornSurface(
        fresh.new, most * np.exp(-(((fresh.middles - middle) / width) ** 2)) * (np.abs(fresh.middles - middle) < 40.0)
    )


@pytest.mark.parametrize("name", PROFILES)
def test_depths_have_the_area_of_the_cells(name: str) -> None:
    """Areas between points of a worn surface are on its pieces without loss, to 1e-12, on a new and a worn surface."""
    for surface in (WornSurface(PROFILES[name]), hollow(name, 0.5)):
        points = surface.worn.running_surface.sampled(spacing=0.31)[100:300]
        ends = np.stack((points[:-1], points[1:]), axis=1)
        areas = np.sin(np.arange(len(ends))) ** 2
        depths = surface.deposited(ends, areas)
        assert (depths * surface.worn_lengths).sum() == pytest.approx(areas.sum(), rel=1e-12)
        kept = surface.filtered(depths)
        assert (kept * surface.worn_lengths).sum() == pytest.approx(areas.sum(), rel=1e-12)
        assert np.std(np.diff(kept, 2)) < 0.2 * np.std(np.diff(depths, 2))


@pytest.mark.parametrize("name", PROFILES)
def test_worn_profile_lies_by_the_depth_below_the_new_one(name: str) -> None:
    """Points of the worn surface are as far below the new one as the depth says, to 2e-5 mm, the rest is unmoved."""
    surface = hollow(name, 0.5)
    contour = surface.worn.running_surface
    points = contour.sampled(spacing=0.5)
    number, s, distance = surface.surface.closest(points)
    starts = np.append(0.0, np.cumsum([each.length for each in surface.surface.segments]))
    at = starts[number] + s * np.diff(starts)[number]
    assert distance == pytest.approx(np.interp(at, surface.middles, surface.depth), abs=2e-5 + 2e-3 * 0.5)
    assert contour.segments[0].start == surface.surface.segments[0].start
    assert contour.segments[-1].end == surface.surface.segments[-1].end


@pytest.mark.parametrize("name", PROFILES)
def test_files_hold_worn_profiles_without_loss(name: str, tmp_path) -> None:
    """A worn profile that is written and read again has the same lines and arcs, from the tread on to 1e-6 mm."""
    surface = hollow(name, 0.5)
    file = tmp_path / "worn.csv"
    file.write_text(surface.csv())
    read, written = read_profile(file).surface, surface.worn.running_surface
    assert len(read.segments) == len(written.segments)
    points = [np.array([each.point([0.0, 0.5, 1.0]) for each in contour.segments]) for contour in (read, written)]
    assert np.abs(points[0] + [0.0, surface.radius_loss_mm] - points[1]).max() < 1e-6
    assert np.abs(points[0] - points[1])[..., 0].max() < 1e-9


@pytest.mark.parametrize("name", PROFILES)
def test_body_made_anew_has_lost_the_worn_area(name: str) -> None:
    """The outline of the worn body is smaller by the worn area, to 1e-3 of it."""
    surface = hollow(name, 0.5)
    lost = surface.new.outline.area - surface.worn_body.outline.area
    assert lost == pytest.approx(surface.worn_area_mm2, rel=1e-3)
    assert set(surface.new.running_names) <= set(surface.worn_body.outline.names)


def test_worn_gauge_face_does_not_move_the_rail() -> None:
    """The rail keeps its position where its gauge face wears: the gauge is that of the new head."""
    fresh = WornSurface(PROFILES["60E1"])
    worn = WornSurface(
        fresh.new, np.exp(-(((fresh.middles - 105.0) / 5.0) ** 2)) * (np.abs(fresh.middles - 105.0) < 20.0)
    )
    assert isinstance(worn.new, type(PROFILES["60E1"]))
    places = [Track(rail=each, gauge_mm=1600.0).placement("right") for each in (fresh.worn, worn.worn)]
    assert places[0] == places[1]


@pytest.mark.parametrize(("most", "where"), [(60.0, 0.62), (0.5, 0.999), (11.0, 0.2)])
def test_wear_deeper_than_the_profile_is_refused(most: float, where: float) -> None:
    """Wear that reaches the end of the surface, folds it or leaves the body is refused, and the profile is named."""
    fresh = WornSurface(PROFILES["S1002"])
    depth = most * np.exp(-(((fresh.middles - where * fresh.surface.length) / 4.0) ** 2))
    with pytest.raises(InputError, match="S1002"):
        _ = WornSurface(fresh.new, np.where(depth > 1e-6, depth, 0.0)).worn
