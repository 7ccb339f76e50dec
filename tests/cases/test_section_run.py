"""Constants of drawn sections against closed forms, and what is refused."""

import math

import numpy as np
import pytest

from flangeway.cases.section.section_run import TorsionCase, run_section, usual_size
from flangeway.errors import InputError
from flangeway.formats import DrawnSection, PartMaterial
from flangeway.geometry import Region, Section, circle, polygon, rectangle, square


def drawn(region, **options):
    return DrawnSection("test", Section({"section": region}), "mm", **options)


def test_both_formulations_bracket_a_hollow_square():
    """Bounds of coarse triangles hold the constant of a hollow square that finer ones narrow."""
    tube = drawn(Region(square(10.0), (square(6.0),)))
    coarse, fine = (run_section(tube, TorsionCase(size=size)).constants.torsion_bounds for size in (1.0, 0.15))
    assert coarse[0] < fine[0] < fine[1] < coarse[1]
    assert fine[1] / fine[0] < 1.001


def test_maximum_shear_stress_of_a_disc_and_none_at_a_notch():
    """A disc's maximum stress per torque is 2 / (pi R^3); a section with a reentrant corner has none, and says so."""
    found = run_section(drawn(Region(circle(10.0)))).summary
    assert found["max_shear_stress_per_torque_per_mm3"] == pytest.approx(2.0 / (math.pi * 1e3), rel=5e-3)
    ell = run_section(drawn(Region(polygon([(0, 0), (30, 0), (30, 5), (5, 5), (5, 30), (0, 30)])))).summary
    assert ell["max_shear_stress_per_torque_per_mm3"] is None
    assert "reentrant corner, the first at (5, 5)" in ell["notices"][0]


def test_composite_tube_adds_its_layers():
    """Two concentric tubes of different materials do not warp: G J is the sum of theirs; G and E weigh apart."""
    inner, outer = PartMaterial(70e3, 0.3), PartMaterial(210e3, 0.3)
    parts = Section({"inner": Region(circle(45.0), (circle(40.0),)), "outer": Region(circle(50.0), (circle(45.0),))})
    found = run_section(DrawnSection("layers", parts, "mm", {"inner": inner, "outer": outer}), TorsionCase(size=3.0))
    polar = [math.pi / 2.0 * (a**4 - b**4) for a, b in ((45.0, 40.0), (50.0, 45.0))]
    stiffness = inner.shear_modulus_MPa * polar[0] + outer.shear_modulus_MPa * polar[1]
    weights = found.summary["weights"]
    computed = found.constants.torsion_constant * weights["reference_shear_modulus_MPa"]
    assert computed == pytest.approx(stiffness, rel=1e-3)
    bending = found.constants.second_moments[0] * weights["reference_young_MPa"]
    assert bending == pytest.approx((70e3 * polar[0] + 210e3 * polar[1]) / 2.0, rel=1e-9)


def test_different_poissons_ratios_are_told():
    """Materials with different Poisson's ratios give Trefftz's shear centre and a notice."""
    parts = Section({"a": Region(square(2.0)), "b": Region(square(2.0, (2.0, 0.0)))})
    materials = {"a": PartMaterial(1.0, 0.2), "b": PartMaterial(1.0, 0.3)}
    found = run_section(DrawnSection("two", parts, "mm", materials), TorsionCase(size=0.5))
    assert found.summary["poisson"] == 0.0
    assert "several Poisson's ratios" in found.summary["notices"][0]


def test_keys_bear_the_unit_and_sizes_are_usual():
    """A section in inches has inches in its keys; usual sizes follow wall, area, or limits of cells and edges."""
    found = run_section(DrawnSection("in", Section({"section": Region(square(1.0))}), "in"), TorsionCase(size=0.2))
    assert {"area_in2", "torsion_constant_in4", "warping_constant_in6", "shear_centre_in"} <= set(found.summary)
    assert not any("mm" in key for key in found.summary)
    assert usual_size(Section({"tube": Region(circle(50.0), (circle(49.0),))})) == pytest.approx(0.25)
    disc = Section({"disc": Region(circle(1.0))})
    assert 0.03 < usual_size(disc) < 0.08
    assert usual_size(Section({"foil": Region(rectangle(1e5, 1.0))})) == pytest.approx(20.0, rel=1e-2)


def test_bending_has_radii_and_section_moduli():
    """A right triangle has i = h / sqrt 18, W = b h^2 / 24 at the apex, b h^2 / 12 at the base; two parts have no W."""
    found = run_section(drawn(Region(polygon([(0.0, 0.0), (12.0, 0.0), (0.0, 30.0)])))).summary
    assert found["radii_of_gyration_mm"] == pytest.approx({"xx": 30.0 / np.sqrt(18.0), "yy": 12.0 / np.sqrt(18.0)})
    wanted = {"top": 12.0 * 900.0 / 24.0, "bottom": 12.0 * 900.0 / 12.0, "right": 30.0 * 6.0, "left": 30.0 * 12.0}
    assert found["section_moduli_mm3"] == pytest.approx(wanted)
    halves = {name: Region(rectangle(4.0, 2.0, centre=(0.0, y))) for name, y in (("a", -1.0), ("b", 1.0))}
    assert "section_moduli_mm3" not in run_section(DrawnSection("two", Section(halves), "mm")).summary


def test_sections_that_cannot_be_computed_are_refused():
    """Pieces apart, and a ratio beside materials are refused."""
    apart = Section({"a": Region(square(1.0)), "b": Region(square(1.0, (5.0, 0.0)))})
    with pytest.raises(InputError, match="2 pieces that do not touch"):
        run_section(DrawnSection("apart", apart, "mm"))
    with pytest.raises(InputError, match="leave it out"):
        run_section(drawn(Region(square(1.0)), materials={"section": PartMaterial(1.0, 0.3)}), TorsionCase(poisson=0.2))
