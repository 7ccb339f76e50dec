"""What runs say: summaries for programs, comparison with half of the sizes, constants of drawn sections."""

import math

import numpy as np
import pytest

from flangeway.cases import Wheelset, load_case, run_halved
from flangeway.cases.section_run import TorsionCase, run_section, usual_size
from flangeway.errors import InputError
from flangeway.formats import DrawnSection, PartMaterial
from flangeway.geometry import Region, Section, circle, polygon, rectangle, square
from flangeway.records import flattened
from flangeway.report.wheelset.wheelset_page import plane_record

IN_SPACE = {"horizontal_in_space_mm", "vertical_in_space_mm"}
SHAPE = {
    "status": {"converged", "message"},
    "position": {"vertical_mm", "lateral_mm", "roll_mrad", "approach_mm", "stable", "reference"} | IN_SPACE,
    "load": {"vertical_kN", "lateral_kN", "tilt_rad", "lateral_in_track_kN", "onto_track_kN"},
    "residual": {"vertical", "lateral", "moment", "equilibrium"},
    "timings_s": {"meshing", "condensation", "contact", "post_processing", "total"},
    "versions": {"flangeway", "python", "numpy", "scipy", "gmsh"},
}
BELOW = {f"in_{role}_{name}" for role in ("rail", "wheel") for name in (
    "max_in_plane_shear_MPa", "max_in_plane_shear_depth_mm", "max_von_mises_MPa", "max_von_mises_depth_mm",
)}  # fmt: skip
PATCH = {
    "side", "region", "normal_force_kN", "lateral_force_kN", "vertical_force_kN", "rail_position_mm",
    "wheel_position_mm", "track_position_mm", "contact_angle_deg", "half_width_mm", "max_pressure_MPa",
    "max_pressure_remark", "pressure_oscillation", "hertz_half_width_mm", "hertz_pressure_MPa", "nodes", *BELOW,
}  # fmt: skip


@pytest.fixture(scope="module")
def run():
    """A wheelset on coarse meshes."""
    return load_case("wheelset-tangent", size_scale=4.0).run()


def leaves(value):
    if isinstance(value, dict | list):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from leaves(entry)
    else:
        yield value


def test_keys_are_those_that_programs_rely_on(run):
    """The summary has its keys, and its values are Python's own, so that any program can read them."""
    for key, names in SHAPE.items():
        assert set(run.summary[key]) == names
    assert all(set(patch) == PATCH for patch in run.summary["patches"])
    kinds = {str if isinstance(value, str) else type(value) for value in leaves({**run.summary, "case": {}})}
    assert kinds <= {str, bool, int, float, type(None)}  # no remark is null, and not an empty text
    assert "" not in leaves(run.summary)
    inputs = {type(value) for value in leaves(run.summary["case"])}
    assert inputs <= {str, bool, int, float, type(None)}  # an input that was left out is null


def test_inputs_and_assumptions_are_told(run):
    """All inputs are in the summary, and so are assumptions."""
    inputs = dict(run.summary["case"])
    assert inputs.pop("name") == "wheelset"
    assert Wheelset.from_values(inputs) == run.case
    assert len(run.summary["assumptions"]) > 3


def test_numbers_that_are_not_finite_become_null(run):
    """A number that is not finite is written as null, since JSON has no other word for it."""
    assert type(run)(run.case, run.result, float("inf")).summary["timings_s"]["total"] is None


def test_a_prescribed_motion_is_not_in_equilibrium():
    """With a prescribed component the residual is that of the free ones; the force that holds it is in `residual`."""
    run = load_case("wheelset-tangent", lateral_mm=2.0, size_scale=4.0).run()
    summary = run.summary
    assert summary["residual"]["equilibrium"] < 1e-9
    assert abs(summary["residual"]["lateral"]) * 28.4e3 == pytest.approx(  # Moherdaui (2021), 7.2.2
        1e3 * abs(sum(side["lateral_force_kN"] for side in summary["sides"])), rel=1e-9
    )
    assert abs(summary["residual"]["lateral"]) > 1e-3
    assert summary["position"]["stable"] is None
    assert plane_record(run).results.rows[0][1] == "2.000"


@pytest.mark.parametrize(
    ("name", "given", "halved", "key", "change"),
    [
        ("wheelset-tangent", {"mesh.size_scale": 4.0}, {"mesh.size_scale": 2.0}, "left_max_pressure_MPa", 0.02),
        pytest.param(
            "wheelset",
            {"mesh.size_scale": 6.0, "contact.patch_cells": 12, "mesh.order": 1, "track.support.kind": "fixed"},
            {"mesh.size_scale": 3.0, "contact.patch_cells": 24},
            "left_max_pressure_MPa",
            0.02,
            marks=pytest.mark.ci,
        ),
        (
            "rolling-patch",
            {"patch.cells_along": 10, "patch.cells_across": 10},
            {"patch.cells_along": 20, "patch.cells_across": 20},
            "longitudinal_force_kN",
            0.03,
        ),
    ],
)
def test_halving_the_sizes_changes_little(name, given, halved, key, change):
    """Forces, pressures and approaches change by some percent, and the sizes are half of the given ones."""
    convergence = run_halved(load_case(name, **given))
    assert convergence.converged
    assert {name: sizes[1] for name, sizes in convergence.sizes.items()} == halved
    assert {name: sizes[0] for name, sizes in convergence.sizes.items()}.items() <= given.items()
    one, other = (flattened(run.summary["case"]) for run in convergence.runs)
    assert one.items() >= given.items()
    assert other.items() >= halved.items()
    first, second = convergence.numbers[key]
    assert 0.0 < abs(second / first - 1.0) < change


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("wheelset-tangent", {"size_scale": 0.06}, r"size_scale = 0\.03"),
        ("wheelset", {"patch_cells": 40}, "patch_cells = 80"),
        ("torsion", {}, "torsion"),
    ],
)
def test_sizes_that_cannot_be_halved_are_refused(name, given, message):
    """A size whose half is out of range, or a case without a size, is refused before anything is computed."""
    with pytest.raises(InputError, match=message):
        run_halved(load_case(name, **given))


def drawn(region, **options):
    return DrawnSection("test", Section({"section": region}), "mm", **options)


def test_maximum_shear_stress_of_a_disc_and_none_at_a_notch():
    """A disc's maximum stress per torque is 2 / (pi R^3); a section with a reentrant corner has none, and says so."""
    found = run_section(drawn(Region(circle(10.0)))).summary
    assert found["max_shear_stress_per_torque_per_mm3"] == pytest.approx(2.0 / (math.pi * 1e3), rel=5e-3)
    ell = run_section(drawn(Region(polygon([(0, 0), (30, 0), (30, 5), (5, 5), (5, 30), (0, 30)])))).summary
    assert ell["max_shear_stress_per_torque_per_mm3"] is None
    assert "reentrant corner, the first at (5, 5)" in ell["notices"][0]


def test_composite_tube_adds_its_layers():
    """Two concentric tubes of different materials do not warp: G J is the sum of theirs; G and E weigh apart."""
    inner, outer = PartMaterial(young_MPa=70e3, poisson=0.3), PartMaterial(young_MPa=210e3, poisson=0.3)
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
    materials = {"a": PartMaterial(young_MPa=1.0, poisson=0.2), "b": PartMaterial(young_MPa=1.0, poisson=0.3)}
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
        run_section(
            drawn(Region(square(1.0)), materials={"section": PartMaterial(young_MPa=1.0, poisson=0.3)}),
            TorsionCase(poisson=0.2),
        )
