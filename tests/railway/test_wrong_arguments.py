"""What classes and functions of the railway refuse: arguments without sense, by their names."""

import math
from dataclasses import replace

import numpy as np
import pytest

from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.errors import InputError
from flangeway.exact.shakedown import shakedown_limits
from flangeway.geometry import Contour, Line
from flangeway.materials import Elastic
from flangeway.railway.damage.evolution import EvolutionSettings
from flangeway.railway.damage.rolling_fatigue import DangVan, surface_fatigue_index, t_gamma_damage
from flangeway.railway.damage.rolling_plasticity import RollingLine, RollingSteel
from flangeway.railway.damage.wear_laws import ArchardLaw, CellLoads, EnergyLaw, OwnLaw, PerPatch, UsfdLaw
from flangeway.railway.damage.worn_surface import WornSurface
from flangeway.railway.profiles.bundled import bundled_section, rail, wheel
from flangeway.railway.profiles.joining import joined, on_plain_body
from flangeway.railway.profiles.orientation import ReadOptions
from flangeway.railway.profiles.profile_file import read_profile
from flangeway.railway.profiles.smoothing import smoothed
from flangeway.railway.rigid.conicity import (
    RollingRadiusDifference,
    conicity_by_regression,
    equivalent_conicity,
    read_rolling_radius_difference,
)
from flangeway.railway.rigid.rigid_side import RigidCurve
from flangeway.railway.track.placements import Track, WheelPair
from flangeway.railway.track.supports import ElasticAxle, Sleepers, WholeWheel
from flangeway.railway.track.wheelset_loads import Load, superelevation_angle
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.whole_wheel import whole_wheel

DIFFERENCE = RollingRadiusDifference([-8.0, 8.0], [-0.8, 0.8])
CIRCLE = 30.0 * np.column_stack((np.cos(np.linspace(0.2, 2.9, 100)), np.sin(np.linspace(0.2, 2.9, 100))))
ROLLED = RollingSteel(shear_yield_MPa=300.0)
CELL = CellLoads(np.ones((1, 1)), np.ones((1, 1, 2)), np.ones((1, 1, 2)), np.ones((1, 1)), 20.0)
STEEL = Elastic(210e3, 0.3)
WALL = Contour.from_segments([Line((0.0, 0.0), (0.0, 1.0))], ["wall"])
WORN = WornSurface(rail("60E1"))


def disc(**wrong):
    return whole_wheel(wheel("S1002"), 460.0, WholeWheel(**wrong))


WRONG = {
    "read_profile(path=None)": lambda: read_profile(None),
    "options='mm'": lambda: read_profile("wheel.whl", "mm"),
    "tape_mm='70'": lambda: ReadOptions(tape_mm="70"),
    "position='5'": lambda: ReadOptions(position="5"),
    "joined(measured=None)": lambda: joined(None, "60E1"),
    "on_plain_body(measured='S1002')": lambda: on_plain_body("S1002"),
    "section 'None'": lambda: bundled_section(None),
    "read_rolling_radius_difference(path=3)": lambda: read_rolling_radius_difference(3),
    "WornSurface(new='S1002')": lambda: WornSurface("S1002"),
    "WornSurface(spacing_mm=1e-06)": lambda: WornSurface(wheel("S1002"), spacing_mm=1e-6),
    "WornSurface(spacing_mm=500.0)": lambda: WornSurface(wheel("S1002"), spacing_mm=500.0),
    "end of the running surface of 60E1": lambda: WORN.deposited(WORN.worn_points[None, [0, 4]], np.ones(1)),
    "OwnLaw(function=None)": lambda: OwnLaw(None, "mm/mm"),
    "OwnLaw(unit=['mm/mm'])": lambda: OwnLaw(np.zeros_like, ["mm/mm"]),
    "PerPatch(law=None)": lambda: PerPatch(None),
    "RollingContact(friction=0.3)": lambda: RollingContact.under_hertz((6.0, 4.0), 1e5, (8, 8), 0.3, (STEEL, STEEL)),
    "gauge_mm": lambda: Track(gauge_mm=0.0),
    "below the head of the right rail": lambda: Track(gauge_depth_mm=90.0).placement("right"),
    "inclination": lambda: Track(inclination=40.0),
    "back_to_back_mm": lambda: WheelPair(back_to_back_mm=-1.0),
    "centre_of_gravity_height_mm": lambda: Load(centre_of_gravity_height_mm=math.nan),
    "axle_load_kN = -1": lambda: Load(axle_load_kN=-1.0),
    "lateral_force_kN = inf": lambda: Load(lateral_force_kN=math.inf),
    "track.left.friction with no table rolling": lambda: WheelsetProblem(track={"left": {"friction": 0.1}}),
    "track.right.support with contact.kind": lambda: WheelsetProblem(
        track={"right": {"support": "fixed"}}, contact="plane"
    ),
    "superelevation": lambda: superelevation_angle(2000.0, 1600.0),
    "young_MPa": lambda: ElasticAxle(young_MPa=-1.0),
    "a diameter above 0": lambda: ElasticAxle(diameters_mm=((0.0, 170.0), (900.0, 0.0))),
    "order them": lambda: ElasticAxle(diameters_mm=((0.0, 170.0), (900.0, 170.0), (800.0, 170.0))),
    "diameters_mm[1]": lambda: ElasticAxle(diameters_mm=(0.0, 170.0)),
    "both on the axle": lambda: ElasticAxle().compliance(np.array([750.0, -750.0])),
    "kind = 'ladder'": lambda: Sleepers(kind="ladder"),
    "spacing_mm": lambda: Sleepers(spacing_mm=0.0),
    "vertical_kN_per_mm": lambda: Sleepers(vertical_kN_per_mm=0.0),
    "longitudinal_kN_per_mm": lambda: Sleepers(longitudinal_kN_per_mm=math.nan),
    "pad_length_mm": lambda: Sleepers(pad_length_mm=601.0),
    "position = 1": lambda: Sleepers(position=1.0),
    "position = 'over'": lambda: Sleepers(position="over"),
    "rim_mm": lambda: disc(rim_mm=0.0),
    "web_middle_mm": lambda: disc(web_middle_mm=(0.0, math.inf)),
    "a hub from 10 to 10 mm": lambda: disc(hub_mm=(10.0, 10.0)),
    "a bore smaller than the hub": lambda: disc(bore_radius_mm=150.0),
    "parts that follow each other": lambda: disc(hub_radius_mm=430.0),
    "a smaller fillet_mm": lambda: disc(fillet_mm=200.0),
    "two arrays of the same length": lambda: RollingRadiusDifference([0.0, 1.0], [0.0]),
    "increas": lambda: RollingRadiusDifference([1.0, 0.0], [0.0, 1.0]),
    "finite": lambda: RollingRadiusDifference([0.0, 1.0], [0.0, math.inf]),
    "amplitude": lambda: equivalent_conicity(DIFFERENCE, [0.0]),
    "-8 to 8 mm": lambda: conicity_by_regression(DIFFERENCE, [9.0]),
    "without a running surface": lambda: RigidCurve.from_contour(WALL),
    "graph": lambda: RigidCurve.from_graph([1.0, 0.0], np.zeros(2), np.zeros(2)),
    "k_MPa": lambda: surface_fatigue_index(0.3, (6.0, 4.0), 1e5, 0.0),
    "limit_MPa": lambda: DangVan(limit_MPa=0.0, slope=0.3),
    "slope": lambda: DangVan(limit_MPa=200.0, slope=-0.3),
    "shear_yield_MPa": lambda: RollingSteel(shear_yield_MPa=0.0),
    "load_factor": lambda: RollingLine(load_factor=0.0, friction=0.1, steel=ROLLED),
    "cells": lambda: RollingLine(load_factor=4.0, friction=0.1, steel=ROLLED, cells=2),
    "depth = 50": lambda: RollingLine(load_factor=4.0, friction=0.1, steel=ROLLED, depth=50.0),
    "values from 0 to 1": lambda: shakedown_limits("line", 1.1),
    "traction coefficients -0.1": lambda: shakedown_limits("line", -0.1),
    "utilised_friction": lambda: surface_fatigue_index(math.nan, (6.0, 4.0), 1e5, 300.0),
    "semi_axes": lambda: surface_fatigue_index(0.3, (6.0,), 1e5, 300.0),
    "some T-gamma not finite": lambda: t_gamma_damage(np.array([10.0, math.nan])),
    "contact='area'": lambda: shakedown_limits("area", 0.3),
    "filter_mm": lambda: EvolutionSettings(end=1.0, filter_mm="2"),
    "max_hollow_mm": lambda: EvolutionSettings(end=1.0, limits={"max_hollow_mm": "two"}),
    "pressures (1, 2)": lambda: replace(CELL, pressures=np.ones((1, 2))),
    "finite numbers of shapes": lambda: replace(CELL, pressures=np.full((1, 1), math.nan)),
    "at -20 m/s": lambda: replace(CELL, speed_m_s=-20.0),
    "CellLoads(slips)": lambda: replace(CELL, slips="fast"),
    "wheel 'None'": lambda: wheel(None),
    "k = 0": lambda: ArchardLaw(hardness_MPa=2700.0, k=0.0),
    "k = 5.5": lambda: ArchardLaw(hardness_MPa=2700.0, k=5.5),
    "level": lambda: ArchardLaw(hardness_MPa=2700.0, level=2.0),
    "unit": lambda: EnergyLaw(constant=0.02, unit="mm3"),
    "branch": lambda: UsfdLaw(branch="smooth"),
    "own law": lambda: OwnLaw(lambda p, s, q: -p, "mm/m").rates(CELL),
    "--smooth nan": lambda: smoothed(CIRCLE, math.nan),
    "--smooth 1000": lambda: smoothed(CIRCLE, 1e3),
    "--limit": lambda: smoothed(CIRCLE, 5.0, 0.0),
}
"""Words of the message, and what is refused."""


@pytest.mark.parametrize("words", WRONG)
def test_wrong_arguments_are_refused_by_their_names(words) -> None:
    """The message has the name of the argument, or of what it has to fulfil, and an advice."""
    with pytest.raises(InputError) as caught:
        WRONG[words]()
    assert words in str(caught.value)
    assert caught.value.advice
