"""Many positions of a wheelset at once: the same answers as the full search."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.post import stresses_along
from flangeway.problems import ElasticField
from flangeway.railway.positions.many_positions import Positions, PositionTable, solve_positions
from flangeway.railway.positions.positions_patches import lines_below, patches_of
from flangeway.railway.positions.prepared_wheelset import PreparedWheelset, prepare
from flangeway.railway.positions.running_pair import Candidates, RunningPair
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.track.discretisation import ROLES, Discretisation
from flangeway.railway.track.placements import Track, Wheelset, WheelsetPosition
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import Prescribed, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import FIRST_PENETRATION_MM
from flangeway.railway.wheelset.subsurface import SEARCHED, maximum_on
from flangeway.railway.wheelset.wheelset_model import build_model
from flangeway.solve import CondensedBodies

STEEL = Elastic(210e3, 0.3)
PAIRS = {"S1002 on 60E1": ("60E1", "S1002"), "AAR-1B on 136RE": ("136RE", "AAR-1B")}


def problem(names: tuple[str, str], **settings: Any) -> WheelsetProblem:
    settings.setdefault("size_scale", 4.0)
    return WheelsetProblem(
        Track(rail(names[0])),
        Wheelset(wheel(names[1])),
        WheelsetLoad(200e3),
        STEEL,
        discretisation=Discretisation(**settings),
    )


@cache
def standard(name: str) -> PreparedWheelset:
    return prepare(problem(PAIRS[name]))


@pytest.fixture(scope="module", params=PAIRS)
def prepared(request: pytest.FixtureRequest) -> PreparedWheelset:
    return standard(request.param)


@pytest.fixture(scope="module")
def north_american() -> PreparedWheelset:
    return standard("AAR-1B on 136RE")


@pytest.fixture(scope="module")
def table(prepared: PreparedWheelset) -> PositionTable:
    last = 11.9 if prepared.model.problem.wheelset.wheel.title.startswith("S1002") else 9.8
    lateral = np.concatenate((np.linspace(-6.0, 6.0, 7), last - np.array([2.0, 0.8, 0.3, 0.0])))
    return solve_positions(prepared, Positions.grid(lateral, [100e3, 200e3, 210e3]))


def agree(prepared: PreparedWheelset, table: PositionTable, number: int) -> None:
    """Compare a position with the full search, which starts without contact forces from where it was found."""
    positions = table.positions
    lateral = float(positions.lateral_mm[number])
    where = WheelsetPosition(*table.position[number]).moved(WheelsetPosition(vertical_mm=FIRST_PENETRATION_MM))
    load = WheelsetLoad(float(positions.vertical_N[number]), float(positions.lateral_N[number]))
    found = prepared.solve(load, Prescribed(lateral_mm=None if np.isnan(lateral) else lateral), where)
    assert found.status.converged, found.status.message
    expected = patches_of(prepared, found)
    got = table.patches[number]
    assert [(patch.side, patch.region) for patch in got] == [(patch.side, patch.region) for patch in expected]
    np.testing.assert_allclose(table.position[number], found.position.components, rtol=0.0, atol=1e-7)
    weight = load.vertical_N
    for mine, theirs in zip(got, expected, strict=True):
        np.testing.assert_allclose(mine.force_on_wheel_N, theirs.force_on_wheel_N, rtol=0.0, atol=1e-6 * weight)
        assert mine.max_pressure_MPa == pytest.approx(theirs.max_pressure_MPa, rel=1e-6)
        assert mine.half_width_mm == pytest.approx(theirs.half_width_mm, rel=1e-9)
        np.testing.assert_allclose(mine.wheel_point_mm, theirs.wheel_point_mm, atol=1e-4)
        np.testing.assert_allclose(mine.rail_point_mm, theirs.rail_point_mm, atol=1e-4)
        assert mine.at_edge == theirs.at_edge


@pytest.mark.ci
def test_positions_agree_with_the_full_search(prepared: PreparedWheelset, table: PositionTable) -> None:
    """Five positions drawn at random from centre to flange agree to 1e-6 of the weight in the forces of all patches."""
    assert table.converged.all(), table.messages
    for number in np.random.default_rng(1).choice(len(table.positions), 5, replace=False):
        agree(prepared, table, int(number))


def test_the_full_search_is_seldom_needed(table: PositionTable) -> None:
    """At most one position in twenty does not converge on the fast path."""
    assert table.by_full_search.mean() <= 0.05


def test_none_is_lost_where_the_flange_begins_to_bear() -> None:
    """Between tread and flange all positions converge on the fast path with elements of standard size."""
    made = prepare(problem(PAIRS["AAR-1B on 136RE"], size_scale=1.0))
    table = solve_positions(made, Positions.grid([8.44, 8.63, 8.83], [160e3, 165e3, 170e3]))
    assert table.converged.all(), table.messages
    assert not table.by_full_search.any()


def test_the_weight_is_borne(table: PositionTable) -> None:
    """Vertical forces of both wheels sum to the weight to 1e-8 in every position."""
    total = table.forces_on_wheels_N[:, :, 1].sum(axis=1)
    np.testing.assert_allclose(total, table.positions.vertical_N, rtol=1e-8)


def test_the_flange_is_reached(table: PositionTable) -> None:
    """Far from the middle one wheel touches the gauge corner, and pushes its rail outwards more the farther it is."""
    heavy = table.positions.vertical_N == 200e3
    ratio = table.lateral_over_vertical[heavy, 1]
    assert ratio[-1] > 2.0 * ratio[3]
    regions = {patch.region for patch in table.patches[-1] if patch.side == "right"}
    assert "gauge corner" in regions


def test_left_mirrors_right(prepared: PreparedWheelset, table: PositionTable) -> None:
    """A position to the left gives the mirror image of one to the right: forces to 1e-6."""
    lateral, vertical = table.positions.lateral_mm, table.positions.vertical_N
    forces = table.forces_on_wheels_N
    for number in range(9):
        (mirror,) = np.flatnonzero((lateral == -lateral[number]) & (vertical == vertical[number]))
        flipped = forces[mirror, ::-1] * [-1.0, 1.0]
        np.testing.assert_allclose(forces[number], flipped, rtol=0.0, atol=1e-6 * vertical[number])
        np.testing.assert_allclose(table.position[number] * [-1.0, 1.0, -1.0], table.position[mirror], atol=1e-7)


@pytest.mark.parametrize(
    "settings",
    [{"order": 2}, {"method": "vem"}, {"enforcement": "multiplier"}, {"primary": "wheel"}],
    ids=lambda settings: "-".join(str(value) for pair in settings.items() for value in pair),
)
def test_other_discretisations_agree(settings: dict[str, Any]) -> None:
    """Elements of order 2, polygons, multipliers and wheels that give the segments agree with the full search."""
    made = prepare(problem(PAIRS["AAR-1B on 136RE"], **settings))
    table = solve_positions(made, Positions.grid([1.5], [100e3, 120e3]))
    assert table.converged.all(), table.messages
    assert not table.by_full_search.any()
    agree(made, table, 1)


def test_a_lateral_motion_is_found(north_american: PreparedWheelset) -> None:
    """With a lateral force the wheelset finds its lateral position, as in the full search."""
    forces = np.array([4e3, 8e3])
    table = solve_positions(north_american, Positions(np.full(2, np.nan), np.full(2, 200e3), forces))
    assert table.converged.all(), table.messages
    np.testing.assert_allclose(table.forces_on_wheels_N[:, :, 0].sum(axis=1), -forces, rtol=1e-6)
    agree(north_american, table, 1)


def test_the_maximum_shear_is_that_of_the_fields(north_american: PreparedWheelset) -> None:
    """The maximum shear stress below each contact is that on the same line of the field of the full search: 1e-6."""
    table = solve_positions(north_american, Positions.grid([1.0], [150e3, 200e3]), shear=True)
    found = north_american.solve(WheelsetLoad(200e3), Prescribed(lateral_mm=1.0))
    fields = north_american.response.fields(
        north_american.response.rotations(found.state.placements), found.state.nodal_forces
    )
    parts = {
        part.name: (part.body, field) for part, field in zip(north_american.model.system.parts, fields, strict=True)
    }
    assert len(table.patches[1]) >= 2
    for patch in table.patches[1]:
        assert patch.shear is not None
        for role in ROLES:
            body, field = parts[f"{role}-{patch.side}"]
            lines = lines_below(north_american, role, patch.side, [patch])
            points = lines.points[0]
            line = stresses_along(ElasticField(body.elasticity, field), points[0], points[-1], len(points))
            expected = maximum_on(lines.depths[0], line.stresses.in_plane_shear, SEARCHED)
            assert patch.shear[role].value_MPa == pytest.approx(expected.value_MPa, rel=1e-6)
            assert 0.2 < patch.shear[role].value_MPa / patch.max_pressure_MPa < 0.5
            assert 0.3 < patch.shear[role].depth_mm / patch.half_width_mm < 1.5


def test_positions_out_of_reach_are_reported(north_american: PreparedWheelset) -> None:
    """A lateral position that rigid wheels do not reach is not found, and the message says so; others are found."""
    table = solve_positions(north_american, Positions.grid([0.0, 400.0], 100e3))
    assert table.converged.tolist() == [True, False]
    assert "400" in table.messages[1]
    assert np.isnan(table.position[1]).all()
    assert table.patches[1] == ()


def test_nonsense_is_refused() -> None:
    """No weight, or node-to-segment contact, is refused with what is allowed."""
    with pytest.raises(InputError, match="positive weight"):
        Positions.grid([0.0], [0.0])
    made = prepare(problem(PAIRS["AAR-1B on 136RE"], pairing="node-to-segment"))
    with pytest.raises(InputError, match="segment-to-segment"):
        solve_positions(made, Positions.grid([0.0], [1e5]))


def test_overlap_off_the_contact_zone_is_not_converged() -> None:
    """A flange that presses into the rail outside of the candidate zone makes the row not converged, with the place."""
    model = build_model(problem(PAIRS["AAR-1B on 136RE"]))  # zones about the middle of the tread only
    narrow = PreparedWheelset(model, CondensedBodies(model.system.surface_nodes))
    table = solve_positions(narrow, Positions.grid([0.0, 9.5], [200e3]))
    assert table.converged.tolist() == [True, False]
    assert table.by_full_search.tolist() == [False, True]
    assert "wheel-right and rail-right overlap by" in table.messages[1]


def test_an_uncertain_position_is_solved_by_the_full_search(
    north_american: PreparedWheelset, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the fast path did not look at the flange, its overlap is seen, and the full search finds the position."""
    search = RunningPair.search

    def blind(pair: RunningPair, *arguments: Any) -> Candidates:
        found = search(pair, *arguments)
        near_flange = pair.secondary.points[pair.hats.nodes, 0] < np.median(pair.secondary.points[:, 0])
        return replace(found, window=found.window & ~near_flange)

    expected = solve_positions(north_american, Positions.grid([9.5], [200e3]))
    monkeypatch.setattr(RunningPair, "search", blind)
    table = solve_positions(north_american, Positions.grid([9.5], [200e3]))
    assert not expected.by_full_search[0]
    assert (table.by_full_search[0], table.converged[0]) == (True, True)
    np.testing.assert_allclose(table.forces_on_wheels_N, expected.forces_on_wheels_N, atol=0.2)
