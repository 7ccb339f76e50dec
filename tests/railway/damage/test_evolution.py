"""Collectives and the evolution of profiles on coarse meshes: resuming, symmetry, energy, limits, wrong inputs."""

import sqlite3
from contextlib import closing
from dataclasses import asdict, replace

import numpy as np
import pytest

from benchmarks.damage import collective
from flangeway.cases import Wheelset
from flangeway.cases.case_file import load_case
from flangeway.errors import InputError
from flangeway.railway.damage.collective import COLLECTIVES, Collective, RunningState, parts_of
from flangeway.railway.damage.evolution import Evolution, EvolutionSettings, EvolutionStep, limit_positions
from flangeway.railway.damage.wear_laws import (
    ArchardLaw,
    EnergyLaw,
    OwnLaw,
    PerPatch,
    UsfdLaw,
    WearLaw,
    patch_damage,
    patch_loads,
    row_wear,
)
from flangeway.railway.damage.worn_surface import WornSurface, reached, worn_measures
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.wheelset.spatial_result import solve_spatial
from flangeway.railway.wheelset.wheelset_newton import RollingPlace

COARSE = {
    "size_scale": 6.0,
    "order": 1,
    "support": "continuous",
    "axle": "rigid",
    "patch_cells": 10,
    "rolling": {"friction": 0.3, "yaw_stiffness_kNm_per_mrad": 10.0, "theory": "fastsim"},
}
ENERGY = EnergyLaw(constant=0.02, unit="mm3/kJ")


def state(share: float = 1.0, **inputs: object) -> RunningState:
    """A state on coarse meshes at 80 km/h, on straight track or in a curve."""
    speed = {} if "curve" in inputs else {"rolling.speed_km_h": 80.0}
    return RunningState(f"state {inputs}", share, load_case("wheelset", **COARSE, **speed, **inputs))


def in_curve(radius_m: float, **more: float) -> dict[str, object]:
    """Inputs of a curve."""
    return {"curve": {"radius_m": radius_m, "speed_km_h": 80.0} | more}


@pytest.fixture(scope="module")
def curve():
    """A wheelset in a curve, solved."""
    return solve_spatial(state(**in_curve(600.0)).problem)


def test_energy_law_wears_the_constant_times_t_gamma(curve) -> None:
    """The area of a passage is the law's constant times T-gamma on wheel and rail, and T-gamma power over speed."""
    rows = row_wear(curve, {"wheel": ENERGY, "rail": ENERGY})
    total = sum(creep.t_gamma_N for _, creep in curve.rolling)
    for role in ("wheel", "rail"):
        area = sum(each.areas.sum() for each in rows if each.role == role)
        assert area == pytest.approx(2e-5 * 1e-3 * total * 1.0, rel=1e-10)
    for _, creep in curve.rolling:
        assert patch_loads(creep).t_gamma_N == pytest.approx(creep.power_W / creep.speed, rel=1e-6)
    assert [each.t_gamma_N for each in patch_damage(curve)] == [creep.t_gamma_N for _, creep in curve.rolling]


def test_worn_areas_of_both_profiles_are_those_of_the_cells(curve) -> None:
    """Cells are carried to the profiles where their patches are, without loss, to 1e-10."""
    problem = curve.problem
    profiles = {"wheel": problem.wheels.wheel_of("right"), "rail": problem.track.rail_of("right")}
    for row in row_wear(curve, {"wheel": ENERGY, "rail": ENERGY}):
        surface = WornSurface(profiles[row.role])
        depth = surface.deposited(row.ends, row.areas)
        assert (depth * surface.worn_lengths).sum() == pytest.approx(row.areas.sum(), rel=1e-10)
        patch = next(each for each in curve.patches if each.side == row.side)
        centre = patch.wheel_point_mm if row.role == "wheel" else patch.rail_point_mm
        x = np.average(surface.worn_points[:-1, 0], weights=np.maximum(depth, 0.0))
        if sum(each.side == row.side for each in curve.patches) == 1:
            assert x == pytest.approx(centre[0], abs=2.0)


def settings(end: float = 3000.0, depth: float = 0.05, **more: object) -> EvolutionSettings:
    """Steps of 0.05 mm."""
    return EvolutionSettings(end=end, max_depth_mm=depth, **more)


class Fading(Evolution):
    """Wear without contact, whose rate falls with the depth: ``c exp(-depth / d)``; depth ``d ln(1 + c s / d)``."""

    def _evaluated(self, position, surfaces, damage, progress, near=()):  # noqa: ARG002
        progress(f"at {position}")
        rates = {key: 2e-5 * np.exp(-surface.depth / 0.1) * (surface.middles > 60.0) * (surface.middles < 110.0)
                 for key, surface in surfaces.items()}  # fmt: skip
        return EvolutionStep(position, surfaces, rates, damage, damage, (), 0.0)


def test_an_interrupted_run_ends_with_the_same_numbers(tmp_path) -> None:
    """A run that goes on from its file gives the same depths as one without interruption, to the last digit."""
    collective = Collective([state()])
    evolution = Fading(collective, {"wheel": ENERGY}, settings(1.1e4, 0.1, max_error_mm=4e-3))
    whole = evolution.run(tmp_path / "whole.sqlite")
    assert len(whole) > 2

    class StoppedError(Exception):
        """What a user does."""

    def stop(sentence: str) -> None:
        if sentence == f"at {whole[-1].position}":
            raise StoppedError

    with pytest.raises(StoppedError):
        evolution.run(tmp_path / "parts.sqlite", stop)
    parts = evolution.run(tmp_path / "parts.sqlite")
    key = ("wheel", "right")
    for one, other in zip(parts, whole, strict=True):
        assert one.position == other.position
        assert (one.surfaces[key].depth == other.surfaces[key].depth).all()
    np.testing.assert_equal(parts[-1].row, whole[-1].row)  # numbers that are none too
    assert (parts[-1].surfaces[key].depth > 0.0).any()
    again = Fading(collective, {"wheel": ENERGY}, settings(1.1e4, 0.1, max_error_mm=4e-3, filter_mm=1.0))
    with pytest.raises(InputError, match=r"parts\.sqlite"):
        again.run(tmp_path / "parts.sqlite")


def test_stored_steps_end_where_a_new_end_or_limit_is_reached(tmp_path) -> None:
    """Later steps do not count, so that a limit is reached in its step; steps that cannot be read are an error."""
    collective, file = Collective([state()]), tmp_path / "steps.sqlite"
    whole = Fading(collective, {"wheel": ENERGY}, settings(1.1e4, 0.1, max_error_mm=4e-3)).run(file)
    shorter = settings(whole[1].position, 0.1, max_error_mm=4e-3)
    assert len(Fading(collective, {"wheel": ENERGY}, shorter).run(file)) == 2
    limits = {"max_tread_wear_mm": 0.5 * whole[1].surfaces["wheel", "right"].radius_loss_mm}
    steps = Fading(collective, {"wheel": ENERGY}, settings(1.1e4, 0.1, max_error_mm=4e-3, limits=limits)).run(file)
    assert [step.position for step in steps] == [step.position for step in whole[:2]]
    assert limit_positions(steps, limits) == {steps[1].reached[0]: pytest.approx(0.5 * whole[1].position)}
    with closing(sqlite3.connect(file)) as database, database:
        database.execute("UPDATE steps SET content = '{' WHERE number = 2")
    with pytest.raises(InputError, match=r"steps\.sqlite: steps that cannot be read"):
        Fading(collective, {"wheel": ENERGY}, settings(1.1e4, 0.1, max_error_mm=4e-3)).run(file)


def test_other_constants_of_a_law_are_other_inputs() -> None:
    """A file of steps does not go on with another hardness, place in Jendel's ranges, or unit; the end may differ."""
    states = Collective([state()])

    def identity(law: WearLaw, end: float = 10.0) -> str:
        return Evolution(states, {"wheel": law}, EvolutionSettings(end=end)).identity

    first = ArchardLaw(hardness_MPa=2700.0)
    assert identity(first) == identity(ArchardLaw(hardness_MPa=2700.0), 20.0)
    others = (
        ArchardLaw(hardness_MPa=2400.0),
        ArchardLaw(hardness_MPa=2700.0, level=0.1),
        PerPatch(first),
        ENERGY,
        EnergyLaw(constant=0.02, unit="mg/kJ"),
    )
    assert len({identity(law) for law in (first, *others)}) == 6
    assert identity(OwnLaw(lambda p, s, t: p, "mm/m")) == identity(OwnLaw(lambda p, s, t: p, "mm/m"))


def test_error_of_the_steps_is_controlled_and_of_second_order() -> None:
    """A quarter of the error that is allowed halves the steps and divides that of the depth by four."""
    exact, errors, counts = 0.1 * np.log(1.0 + 2e-5 * 2e4 / 0.1), [], []
    for allowed in (4e-3, 1e-3):
        collective = Collective([state()])
        steps = Fading(collective, {"wheel": ENERGY}, settings(2e4, 0.1, max_error_mm=allowed)).run()
        errors.append(abs(steps[-1].surfaces["wheel", "right"].depth[300] - exact))  # at 75 mm
        counts.append(len(steps))
        assert all(step.error_mm <= allowed for step in steps)
    assert errors[0] < 4e-3
    assert 3.0 < errors[0] / errors[1] < 6.0
    assert 1.6 < counts[1] / counts[0] < 2.4


def test_a_symmetric_case_stays_symmetric_up_to_its_limit() -> None:
    """On straight track separate sides wear alike to the last bit, and the area is that of the energy.

    The evolution ends at the first step in which a limit is reached, and names it and where, linear in the step.
    """
    limits = {"max_tread_wear_mm": 1e-3, "min_flange_thickness_mm": 20.0}
    collective = Collective([state()], separate=True)
    steps = Evolution(collective, {"wheel": ENERGY}, settings(1e6, limits=limits)).run()
    first, last = steps[0], steps[-1]
    left, right = (last.surfaces["wheel", side] for side in ("left", "right"))
    assert (left.depth == right.depth).all()
    assert right.depth.max() > 0.01
    rate = float((first.rates["wheel", "right"] * first.surfaces["wheel", "right"].worn_lengths).sum())
    energy = 0.5 * first.t_gamma_N * 2e-8 * 1e6  # mm3 of one wheel in a km
    assert rate == pytest.approx(energy / (2.0 * np.pi * 460.0), rel=2e-3)
    assert last.reached == ("wheel: max_tread_wear_mm",)
    assert not any(step.reached for step in steps[:-1])
    losses = [step.surfaces["wheel", "right"].radius_loss_mm for step in steps[-2:]]
    position = np.interp(1e-3, losses, [step.position for step in steps[-2:]])
    assert limit_positions(steps, limits) == {last.reached[0]: pytest.approx(position, rel=1e-9)}


def test_a_mirrored_state_is_the_mirror_image(curve) -> None:
    """The left wheel in a curve to the left wears as the right one in the mirrored curve; twice mirrored is itself."""
    canted = state(**in_curve(600.0, superelevation_mm=60.0), yaw_mrad=0.4)
    other = canted.mirrored
    assert (other.problem.load.curve.radius_m, other.problem.position.yaw_mrad) == (-600.0, -0.4)
    assert other.mirrored.problem == canted.problem
    mirrored, areas = state(**in_curve(600.0)).mirrored, []
    for found in (curve, solve_spatial(mirrored.problem)):
        rows = row_wear(found, {"wheel": ENERGY})
        areas.append({side: sum(row.areas.sum() for row in rows if row.side == side) for side in ("left", "right")})
    assert areas[0]["left"] > 2.0 * areas[0]["right"] or areas[0]["right"] > 2.0 * areas[0]["left"]
    assert areas[1]["right"] == pytest.approx(areas[0]["left"], rel=1e-5)
    assert areas[1]["left"] == pytest.approx(areas[0]["right"], rel=1e-5)


def test_a_search_that_begins_near_an_equilibrium_finds_it(curve) -> None:
    """From a place beside it, without the search on the whole running surfaces."""
    place, cold = RollingPlace.of(curve.equilibrium), curve.equilibrium
    beside = place._replace(lateral_mm=place.lateral_mm + 0.1, yaw_rad=place.yaw_rad + 2e-4)
    texts: list[str] = []
    found = curve.wheelset.solve(texts.append, beside)
    assert found.status.converged
    assert found.position.components == pytest.approx(cold.position.components, abs=2e-3)
    assert RollingPlace.of(found).yaw_rad == pytest.approx(place.yaw_rad, abs=2e-5)
    assert sum("after 0 steps" in text for text in texts) == 1  # one search, not two
    for side, state in found.state.sides.items():
        assert state.forces.sum() == pytest.approx(cold.state.sides[side].forces.sum(), rel=1e-3)


def test_curves_of_both_hands_wear_both_sides_alike(tmp_path) -> None:
    """Curves to the left and to the right wear both wheels to the same bits, and as the mean of the sides of one."""
    one = state(0.5, **in_curve(600.0))
    both = Collective([one, state(0.5, **in_curve(-600.0))], separate=True)
    assert both.is_symmetric
    assert not Collective([one, state(0.5, **in_curve(-500.0))], separate=True).is_symmetric
    at_once = settings(1.0, limits={"min_flange_thickness_mm": 50.0})  # reached before the first step
    (both_sides,) = Evolution(both, {"wheel": ENERGY}, at_once).run()
    alone = Evolution(Collective([replace(one, share=1.0)]), {"wheel": ENERGY}, at_once)
    (mean,), (stored,) = alone.run(tmp_path / "one.sqlite"), alone.run(tmp_path / "one.sqlite")
    assert [*map(asdict, stored.states)] == [*map(asdict, mean.states)]  # from which the next step begins
    assert stored.states[0].place is not None
    left, right = (both_sides.rates["wheel", side] for side in ("left", "right"))
    assert (left == right).all()
    assert right.max() > 1e-6
    assert right == pytest.approx(mean.rates["wheel", "right"], abs=1e-4 * right.max())


@pytest.mark.ci
def test_all_states_of_the_mixed_line_have_an_equilibrium() -> None:
    """Eleven free states by the exact theory converge on new profiles."""
    at_once = settings(1.0, limits={"min_flange_thickness_mm": 50.0})
    (step,) = Evolution(collective(), {"wheel": UsfdLaw()}, at_once).run()
    assert len(step.states) == 11
    assert step.unconverged == ()


@pytest.mark.ci
def test_compliance_of_new_bodies_serves_up_to_a_millimetre() -> None:
    """Hollows of 1 mm: forces, and pressures of large patches, agree on the compliance of new and of worn bodies.

    To 2 %; a small patch has 3 % of the load on a few cells, by whose place its pressure differs by 10 %.
    """
    problem, found, surfaces = Wheelset(), [], []
    for new, share in ((problem.wheels.wheel_of("right"), 0.47), (problem.track.rail_of("right"), 0.5)):
        fresh = WornSurface(new)
        away = fresh.middles - share * fresh.surface.length
        surfaces.append(WornSurface(new, np.exp(-((away / 14.0) ** 2)) * (np.abs(away) < 40.0)))
    for which in ("worn", "worn_body"):
        on_wheel, on_rail = (getattr(each, which) for each in surfaces)
        result = solve_spatial(problem.replaced(wheelset={"wheel": on_wheel}, track={"rail": on_rail}))
        found.append([(patch.normal_force_N, patch.max_pressure) for patch in result.patches])
    (new_forces, new_pressures), (worn_forces, worn_pressures) = np.transpose(found, (0, 2, 1))
    assert new_forces == pytest.approx(worn_forces, rel=0.02)
    large = worn_forces > 0.1 * worn_forces.max()
    assert new_pressures[large] == pytest.approx(worn_pressures[large], rel=0.02)
    assert new_pressures[large].min() > 500.0


def test_measures_of_worn_profiles_have_closed_forms() -> None:
    """A hollow of 1 mm in the tread and wear of a head are what the measures say."""
    fresh = WornSurface(wheel("S1002"))
    x = fresh.worn_points[:-1, 0]
    worn = WornSurface(fresh.new, np.where(x > -20.0, np.exp(-((x / 12.0) ** 2)) * (np.abs(x) < 40.0), 0.0))
    found, new = worn_measures(worn), worn_measures(fresh)
    assert found["tread_wear_mm"] == pytest.approx(1.0, abs=0.01)
    assert found["flange_height_mm"] - new["flange_height_mm"] == pytest.approx(1.0, abs=0.01)
    assert 0.3 < found["hollow_mm"] < 1.0
    assert found["restoring_cut_mm"] == pytest.approx(1.0, abs=0.01)
    assert new["hollow_mm"] == pytest.approx(0.0, abs=1e-6)
    assert reached(worn, {"max_hollow_mm": 0.2, "max_side_wear_mm": 0.1}) == ("max_hollow_mm",)
    flange = (x > -44.0) & (x < -36.0)  # of 70 degrees
    cut = worn_measures(WornSurface(fresh.new, np.where(flange, 0.1, 0.0)))["restoring_cut_mm"]
    assert cut == pytest.approx(0.1 / np.cos(np.radians(70.0)), rel=1e-3)
    head = WornSurface(rail("60E1"))
    middle = head.surface.length / 2.0
    worn = WornSurface(
        head.new, 0.5 * np.exp(-(((head.middles - middle) / 8.0) ** 2)) * (np.abs(head.middles - middle) < 30.0)
    )
    assert worn_measures(worn)["top_wear_mm"] == pytest.approx(0.5, abs=0.01)
    assert worn_measures(worn)["side_wear_mm"] == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("name", COLLECTIVES)
def test_bundled_collectives_add_up(name: str) -> None:
    """The shares of each bundled collective sum to 1, and its inputs are those of the case wheelset."""
    parts = [part for state in COLLECTIVES[name] for part in parts_of(state)]
    assert sum(part["share"] for part in parts) == pytest.approx(1.0, abs=1e-12)
    for part in parts:
        load_case("wheelset", **{key: part[key] for key in part.keys() - {"name", "share"}}).check()


def test_parts_of_a_state_are_a_rule_of_quadrature() -> None:
    """Means of linear inputs are exact, those of a cubic curvature converge with the square of the parts."""
    curves = {
        "name": "curves",
        "share": 0.3,
        "load.curve.radius_m": (2000.0, 400.0),
        "load.curve.speed_km_h": [140.0, 70.0],
        "wheel": "S1002",
    }
    low, high = 1.0 / 2000.0, 1.0 / 400.0
    exact, errors = (high**4 - low**4) / (4.0 * (high - low)), []
    for number in (1, 2, 4):
        parts = parts_of(curves | {"parts": number})
        assert [part["share"] for part in parts] == pytest.approx([0.3 / number] * number)
        assert {part["wheel"] for part in parts} == {"S1002"}
        curvatures = np.array([1.0 / part["load.curve.radius_m"] for part in parts])
        speeds = np.array([part["load.curve.speed_km_h"] for part in parts])
        # all ranges run together
        assert speeds == pytest.approx(140.0 - 70.0 * (curvatures - low) / (high - low), rel=1e-12)
        assert speeds.mean() == pytest.approx(105.0, rel=1e-12)
        errors.append((curvatures**3).mean() / exact - 1.0)
    assert np.divide(errors[1:], errors[:-1]) == pytest.approx(0.25, abs=1e-12)


@pytest.mark.parametrize(
    ("inputs", "word"),
    [
        ({"gauge_mm": (1432.0, 1435.0, 1438.0)}, "gauge_mm"),
        ({"gauge_mm": (1432.0, "wide")}, "wide"),
        ({"load.curve.radius_m": (-500.0, 500.0)}, "load.curve.radius_m"),
        ({"parts": 2}, "ranges"),
    ],
)
def test_wrong_ranges_are_refused(inputs, word: str) -> None:
    """A range has two numbers, radii of one hand, and parts have a range."""
    with pytest.raises(InputError, match=word):
        parts_of({"name": "line", "share": 1.0} | inputs)


@pytest.mark.ci
def test_partners_of_what_wears_may_differ_between_states() -> None:
    """A wheel wears on two rails, each with its share, as on each of them alone; two rails do not wear as one."""
    rates, states = {}, [state(0.5, rail=name, gauge_mm=1435.0) for name in ("60E1", "49E1")]
    for name in ("both", "60E1", "49E1"):
        some = [each for each in states if name in ("both", each.problem.track.rail)]
        one = Collective([replace(each, share=1.0 / len(some)) for each in some])
        (step,) = Evolution(one, {"wheel": ENERGY}, settings(limits={"min_flange_thickness_mm": 50.0})).run()
        rates[name] = step.rates["wheel", "right"]
    assert rates["both"] == pytest.approx(0.5 * (rates["60E1"] + rates["49E1"]), abs=1e-12 * rates["both"].max())
    assert np.abs(rates["60E1"] - rates["49E1"]).max() > 0.1 * rates["both"].max()
    with pytest.raises(InputError, match="49E1"):
        Evolution(Collective(states), {"rail": ENERGY}, settings())


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Collective([]), "without states"),
        (lambda: Collective([state(0.5), state(0.4)]), "0.9"),
        (lambda: Collective([replace(state(), problem=state().problem.replaced(rolling=None))]), "friction"),
        (lambda: Evolution(Collective([state()]), {}, settings()), "law"),
        (lambda: Evolution(Collective([state()]), {"wheel": ENERGY, "rail": ENERGY}, settings()), "axles_per_km"),
        (lambda: settings(limits={"max_holow_mm": 2.0}), "max_holow_mm"),
    ],
)
def test_wrong_collectives_are_refused(make, word: str) -> None:
    """Shares that do not add up and the like are refused, and the message names them."""
    with pytest.raises(InputError, match=word):
        make()


def test_theories_without_slip_in_cells_are_refused() -> None:
    """Polach's formula has no slip in cells: wear by it is refused, and the input to change is named."""
    problem = state(**in_curve(600.0)).problem.replaced(rolling={"theory": "polach"})
    with pytest.raises(InputError, match=r"rolling\.theory"):
        row_wear(solve_spatial(problem), {"wheel": ENERGY})
