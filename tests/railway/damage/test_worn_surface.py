"""Profiles that wear: area, shape, files, and what is refused."""

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.railway.damage.worn_surface import WornSurface
from flangeway.railway.profiles.bundled import WheelProfile, rail, wheel
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.track.placements import Track

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
    names = surface.new.running_names if isinstance(surface.new, WheelProfile) else surface.new.head_names
    assert set(names) <= set(surface.worn_body.outline.names)


def test_worn_gauge_face_does_not_move_the_rail() -> None:
    """The rail keeps its position where its gauge face wears: the gauge is that of the new head."""
    fresh = WornSurface(PROFILES["60E1"])
    worn = WornSurface(
        fresh.new, np.exp(-(((fresh.middles - 105.0) / 5.0) ** 2)) * (np.abs(fresh.middles - 105.0) < 20.0)
    )
    assert isinstance(worn.new, type(PROFILES["60E1"]))
    places = [Track(each).placement("right") for each in (fresh.worn, worn.worn)]
    assert places[0] == places[1]


@pytest.mark.parametrize(("most", "where"), [(60.0, 0.62), (0.5, 0.999), (11.0, 0.2)])
def test_wear_deeper_than_the_profile_is_refused(most: float, where: float) -> None:
    """Wear that reaches the end of the surface, folds it or leaves the body is refused, and the profile is named."""
    fresh = WornSurface(PROFILES["S1002"])
    depth = most * np.exp(-(((fresh.middles - where * fresh.surface.length) / 4.0) ** 2))
    with pytest.raises(InputError, match="S1002"):
        _ = WornSurface(fresh.new, np.where(depth > 1e-6, depth, 0.0)).worn


def test_contact_at_the_end_of_the_surface_is_refused() -> None:
    """Cells at the end of the running surface would wear what is not there."""
    fresh = WornSurface(PROFILES["60E1"])
    with pytest.raises(InputError, match="end of the running surface"):
        fresh.deposited(fresh.worn_points[None, [0, 4]], np.ones(1))
