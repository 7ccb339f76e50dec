"""Maximum shear stresses of many positions, beside those of one field after the other."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from flangeway.materials import Elastic
from flangeway.post import stresses_along
from flangeway.problems import ElasticField
from flangeway.railway.positions import many_positions as positions
from flangeway.railway.positions.many_positions import Positions, solve_positions
from flangeway.railway.positions.positions_patches import LoadedPatch, maximum_shears
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset, prepare
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.track.discretisation import ROLES, Discretisation, Role
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.subsurface import SubsurfaceExtreme, closest_on_boundary
from flangeway.solve import CondensedBodies

Floats = NDArray[np.float64]

KINDS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "S1002 on 60E1": ("60E1", "S1002", {}),
    "order 2": ("136RE", "AAR-1B", {"order": 2}),
    "polygons": ("136RE", "AAR-1B", {"method": "vem"}),
}


@dataclass(frozen=True)
class Asked:
    """A wheelset, and what `solve_positions` asked for."""

    prepared: PreparedWheelset
    loaded: tuple[LoadedPatch, ...]


@pytest.fixture(scope="module", params=KINDS)
def asked(request: pytest.FixtureRequest) -> Asked:
    """Regions of contact from the middle to the flange."""
    rail_name, wheel_name, settings = KINDS[request.param]
    prepared = prepare(problem(rail_name, wheel_name, size_scale=4.0, **settings))
    loaded: list[LoadedPatch] = []

    def kept(_: PreparedWheelset, given: list[LoadedPatch], *, superposed: bool) -> list[dict[Role, SubsurfaceExtreme]]:
        assert not superposed  # so few positions do not pay for it
        loaded.extend(given)
        return [{} for _ in given]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(positions, "maximum_shears", kept)
        table = solve_positions(prepared, Positions.grid([-9.0, 0.0, 1.5, 8.8], [90e3, 250e3]), shear=True)
    assert table.converged.all(), table.messages
    return Asked(prepared, tuple(loaded))


def problem(rail_name: str, wheel_name: str, **settings: Any) -> WheelsetProblem:
    """A wheelset of two steel wheels."""
    return WheelsetProblem(
        Track(rail(rail_name)),
        Wheelset(wheel(wheel_name)),
        WheelsetLoad(200e3),
        Elastic(210e3, 0.3),
        discretisation=Discretisation(**settings),
    )


def alone(prepared: PreparedWheelset, each: LoadedPatch, role: Role) -> SubsurfaceExtreme:
    """The same by the field of the whole body, its stresses along the line, and NumPy's own polynomials."""
    patch, model = each.patch, prepared.model
    place = [part.name for part in model.system.parts].index(f"{role}-{patch.side}")
    body = model.system.parts[place].body
    field = prepared.response.body_fields(place, (each.wheel if role == "wheel" else each.rail)[None])[0]
    profile = (
        model.problem.wheelset.wheel_of(patch.side) if role == "wheel" else model.problem.track.rail_of(patch.side)
    )
    point = np.array(patch.wheel_point_mm if role == "wheel" else patch.rail_point_mm)
    numbers, parameters, _ = profile.running_surface.closest(point)
    inward = -profile.running_surface.segments[int(numbers[0])].normal(parameters)[0]
    start = closest_on_boundary(body.mesh, point[None])[0]
    depths = np.linspace(0.0, 4.0 * patch.half_width_mm, 201)
    line = stresses_along(ElasticField(body.elasticity, field), start, start + depths[-1] * inward, 201)
    searched = depths <= 2.0 * patch.half_width_mm * (1.0 + 1e-12)  # a wide contact's line ends in the web
    return top_of(depths[searched], line.stresses.in_plane_shear[searched])


def top_of(depths: Floats, values: Floats) -> SubsurfaceExtreme:
    """Top of the cubic closest to the values within half of the depth of the maximum."""
    place = int(np.nanargmax(values))
    depth, value = float(depths[place]), float(values[place])
    near = np.isfinite(values) & (np.abs(depths - depth) <= 0.5 * depth * (1.0 + 1e-9))
    if near.sum() < 8:
        return SubsurfaceExtreme(value, depth)
    cubic = Polynomial.fit(depths[near], values[near], 3)
    roots = cubic.deriv().roots()
    for top in roots[np.isreal(roots)].real.tolist():
        if abs(top - depth) <= 0.5 * depth and cubic.deriv(2)(top) < 0.0:
            return SubsurfaceExtreme(float(cubic(top)), top)
    return SubsurfaceExtreme(value, depth)


def test_all_at_once_agree_with_one_alone(asked: Asked, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stresses agree to 1e-9 with those of each whole field alone, by solving for it and by superposing others."""
    prepared, loaded = asked.prepared, asked.loaded
    assert {each.patch.side for each in loaded} == {"left", "right"}
    assert len(loaded) >= 16
    expected = [{role: alone(prepared, each, role) for role in ROLES} for each in loaded]
    solved: list[int] = []
    body_fields = CondensedBodies.body_fields

    def counted(self: CondensedBodies, number: int, forces: Floats) -> Floats:
        solved.append(len(forces))
        return body_fields(self, number, forces)

    monkeypatch.setattr(CondensedBodies, "body_fields", counted)
    first = maximum_shears(prepared, loaded, superposed=False)
    assert sum(solved) == 2 * len(loaded)
    last = maximum_shears(prepared, loaded, superposed=True)
    solved.clear()
    again = maximum_shears(prepared, loaded, superposed=True)
    assert not solved  # the unit forces are kept
    assert again == last
    for wanted, by_solving, superposed in zip(expected, first, last, strict=True):
        for role in ROLES:
            for found in (by_solving[role], superposed[role]):
                assert found.value_MPa == pytest.approx(wanted[role].value_MPa, rel=1e-9)
                assert found.depth_mm == pytest.approx(wanted[role].depth_mm, rel=1e-8, abs=1e-12)
