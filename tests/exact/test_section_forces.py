"""Sections under forces beside closed forms: plastic moduli, shear areas, and stresses of beams."""

import math

import pytest

from flangeway.cases.section_run import TorsionCase, run_section
from flangeway.errors import InputError
from flangeway.formats import DrawnSection
from flangeway.geometry import Region, Section, circle, rectangle
from flangeway.report.section_page import section_quantities

WIDTH, HEIGHT = 40.0, 60.0


def section(outline, **inputs):
    """A run of a section of one material."""
    drawn = DrawnSection("", Section({"section": Region(outline)}), "mm")
    return run_section(drawn, TorsionCase(**inputs))


def test_a_rectangle_has_the_textbooks_moduli_and_shear_areas():
    """Plastic moduli b h^2 / 4, shape factors 3/2, and shear areas 5/6 of the area at a Poisson's ratio of zero."""
    numbers = section(rectangle(WIDTH, HEIGHT)).summary
    assert numbers["plastic_moduli_mm3"]["xx"] == pytest.approx(WIDTH * HEIGHT**2 / 4.0, rel=1e-9)
    assert numbers["plastic_moduli_mm3"]["yy"] == pytest.approx(HEIGHT * WIDTH**2 / 4.0, rel=1e-9)
    assert numbers["shape_factors"] == pytest.approx({"xx": 1.5, "yy": 1.5}, rel=1e-9)
    area = 5.0 / 6.0 * WIDTH * HEIGHT
    assert numbers["shear_areas_mm2"] == pytest.approx({"x": area, "y": area}, rel=1e-5)


def test_a_circle_has_the_textbooks_plastic_modulus():
    """4 r^3 / 3 about each axis, to the chords of the mesh; the shape factor is 16 / (3 pi)."""
    numbers = section(circle(20.0)).summary
    assert numbers["plastic_moduli_mm3"] == pytest.approx(dict.fromkeys(("xx", "yy"), 4.0 / 3.0 * 20.0**3), rel=5e-4)
    assert numbers["shape_factors"] == pytest.approx(dict.fromkeys(("xx", "yy"), 16.0 / (3.0 * math.pi)), rel=5e-4)


def test_stresses_of_a_rectangle_under_each_force():
    """N / A, 6 M / (b h^2), 3 V / (2 A) in the middle: normal stresses to 1e-6, the shear stress to 1e-3."""
    area = WIDTH * HEIGHT
    pulled = section(rectangle(WIDTH, HEIGHT), axial_N=1e4).summary
    assert pulled["normal_stress_MPa"] == pytest.approx([1e4 / area, 1e4 / area])
    assert pulled["max_von_mises_MPa"] == pytest.approx(1e4 / area)
    bent = section(rectangle(WIDTH, HEIGHT), moments=[1e6, 0.0]).summary
    largest = 6e6 / (WIDTH * HEIGHT**2)
    assert bent["normal_stress_MPa"] == pytest.approx([-largest, largest], rel=1e-6)
    assert abs(bent["max_von_mises_position_mm"][1]) == pytest.approx(HEIGHT / 2.0)
    sheared = section(rectangle(WIDTH, HEIGHT), shear_N=[0.0, 1e4], size=2.0).summary
    assert sheared["max_shear_stress_MPa"] == pytest.approx(1.5 * 1e4 / area, rel=1e-3)
    assert sheared["max_von_mises_MPa"] == pytest.approx(math.sqrt(3.0) * 1.5 * 1e4 / area, rel=1e-3)


def test_the_stress_of_a_torque_is_that_of_the_table():
    """The maximum of a circle under a torque is 2 T / (pi r^3), to 1 % of the mesh, and the table has it."""
    run = section(circle(20.0), torque=1e5)
    assert run.summary["max_shear_stress_MPa"] == pytest.approx(2e5 / (math.pi * 20.0**3), rel=1e-2)
    shown = {quantity.key: quantity.value(run) for quantity in section_quantities(run, "metric")}
    assert shown["max_shear_stress_MPa"] == run.summary["max_shear_stress_MPa"]


TWO_MATERIALS = """unit = "mm"
[parts.low]
young_MPa = 30e3
poisson = 0.2
outer.points = [[0, 0], [40, 0], [40, 20], [0, 20]]
[parts.high]
young_MPa = 210e3
poisson = 0.2
outer.points = [[0, 20], [40, 20], [40, 40], [0, 40]]
"""


def test_without_forces_there_are_no_stresses_and_materials_are_refused(tmp_path):
    """A section alone has no stresses; forces on a section of two materials are an error with what to take."""
    assert section(rectangle(WIDTH, HEIGHT)).stresses is None
    (tmp_path / "two.toml").write_text(TWO_MATERIALS)
    TorsionCase(section=str(tmp_path / "two.toml")).check()
    with pytest.raises(InputError, match="forces on a section of several materials"):
        TorsionCase(section=str(tmp_path / "two.toml"), torque=1.0).check()
