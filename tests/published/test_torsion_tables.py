"""Torsion constants of Moherdaui (2021) chapter 4 against its Tables 4 to 7 (relative errors for M1 to M4)."""

from functools import cache

import numpy as np
import pytest

from studies.torsion.torsion_reproduced import (
    TorsionCode,
    convergence_rate,
    published_reading,
    torsion_codes,
    torsion_mesh,
    torsion_row,
    torsion_rows,
)

PUBLISHED_ERRORS = {
    ("warping", "FDSO1"): (0.0113, 0.00582, 0.00315, 0.000697),
    ("warping", "FDSO2"): (9.75e-05, 2.3e-05, 5.97e-06, 4.2e-07),
    ("warping", "VDSO1"): (0.0113, 0.00582, 0.00315, 0.000697),
    ("warping", "VDSO2"): (3.22e-05, 1.07e-05, 2.96e-06, 1.85e-07),
    ("warping", "VVSO1"): (0.00168, 0.000644, 0.000318, 6.17e-05),
    ("warping", "VVSO2"): (2.92e-05, 6.26e-06, 1.59e-06, 1.37e-07),
    ("warping", "FDTO1"): (0.0126, 0.00741, 0.00353, 0.000901),
    ("warping", "FDTO2"): (1.23e-05, 3.93e-06, 9.22e-07, 6.01e-08),
    ("warping", "VDTO1"): (0.0126, 0.00741, 0.00353, 0.000901),
    ("warping", "VDTO2"): (6.16e-06, 2.04e-06, 4.24e-07, 2.75e-08),
    ("warping", "VVTO1"): (0.0016, 0.000752, 0.000304, 7.02e-05),
    ("warping", "VVTO2"): (8.73e-06, 3.59e-06, 6.49e-07, 5.02e-08),
    ("prandtl", "FDSO1"): (0.0176, 0.009, 0.00424, 0.00107),
    ("prandtl", "FDSO2"): (0.000119, 2.57e-05, 5.82e-06, 4.79e-07),
    ("prandtl", "VDSO1"): (0.0176, 0.009, 0.00424, 0.00107),
    ("prandtl", "VDSO2"): (8.06e-05, 1.31e-05, 2.49e-06, 2.48e-07),
    ("prandtl", "VVSO1"): (0.0152, 0.00767, 0.00374, 0.00102),
    ("prandtl", "VVSO2"): (1.92e-05, 3.08e-06, 1.06e-06, 7.01e-08),
    ("prandtl", "FDTO1"): (0.0188, 0.0112, 0.0053, 0.00136),
    ("prandtl", "FDTO2"): (1.3e-05, 4.19e-06, 9.4e-07, 6.09e-08),
    ("prandtl", "VDTO1"): (0.0188, 0.0112, 0.0053, 0.00136),
    ("prandtl", "VDTO2"): (5.07e-06, 1.57e-06, 3.99e-07, 2.58e-08),
    ("prandtl", "VVTO1"): (0.0156, 0.00937, 0.00458, 0.00115),
    ("prandtl", "VVTO2"): (2.87e-06, 8.17e-07, 2.64e-07, 1.68e-08),
}
PUBLISHED_SIZES = {
    "DS": (0.137, 0.0967, 0.0662, 0.0343),
    "VS": (0.144, 0.109, 0.0741, 0.0389),
    "DT": (0.128, 0.0976, 0.0726, 0.0358),
    "VT": (0.146, 0.106, 0.0763, 0.0413),
}
OUTSIDE = {
    # errors near 1e-6 of dual polygons change by 20 % with the mesh, which is not the published one
    ("prandtl", "VVSM3O2"),
    ("prandtl", "VVTM3O2"),
}


@cache
def computed():
    """All rows in the published reading, by formulation and code."""
    return {(row.formulation, str(row.code)): row for row in torsion_rows() if published_reading(row)}


def published_error(formulation, code):
    return PUBLISHED_ERRORS[formulation, f"{code.method}{code.cells}{code.section}O{code.order}"][code.level - 1]


def test_there_are_96_rows():
    """48 codes, each for the warping and for Prandtl's function."""
    assert len(torsion_codes()) == 48
    assert len(computed()) == 96


@pytest.mark.parametrize("formulation", ["warping", "prandtl"])
@pytest.mark.parametrize("code", torsion_codes(), ids=str)
def test_error_is_the_published_one(formulation, code):
    """The error is within 15 % of the published one, and of the rows named outside within 20 %."""
    row = computed()[formulation, str(code)]
    allowed = 0.20 if (formulation, str(code)) in OUTSIDE else 0.15
    assert abs(row.relative_error) == pytest.approx(published_error(formulation, code), rel=allowed)


@pytest.mark.parametrize(("formulation", "group"), sorted(PUBLISHED_ERRORS))
def test_rate_is_the_published_one(formulation, group):
    """The exponent fitted over h is within 0.4 of the published points' (about 2 and 4)."""
    rows = [computed()[formulation, f"{group[:3]}M{level}O{group[-1]}"] for level in (1, 2, 3, 4)]
    ours = convergence_rate(np.array([r.size for r in rows]), np.array([r.relative_error for r in rows]))
    sizes, errors = PUBLISHED_SIZES[group[1:3]], PUBLISHED_ERRORS[formulation, group]
    assert ours == pytest.approx(convergence_rate(np.array(sizes), np.array(errors)), abs=0.4)


def test_linear_virtual_triangles_are_linear_triangles():
    """The rows VD and FD of order 1 coincide, as published."""
    for formulation in ("warping", "prandtl"):
        for section in ("S", "T"):
            pair = [computed()[formulation, f"{m}D{section}M2O1"].torsion_constant for m in "FV"]
            assert pair[0] == pytest.approx(pair[1], rel=1e-12)


@pytest.mark.parametrize(("level", "error"), [(1, 9.35e-3), (4, 6.29e-4)])
def test_projected_load_is_more_accurate_than_the_published_reading(level, error):
    """With the load as written in (3.81), VVSO1 of Prandtl's function has 0.6 times the published error."""
    row = torsion_row(TorsionCode.parse(f"VVSM{level}O1"), "prandtl")
    assert abs(row.relative_error) == pytest.approx(error, rel=0.05)
    assert abs(row.relative_error) < 0.7 * published_error("prandtl", row.code)


@pytest.mark.parametrize(("section", "points"), [("S", (145, 286, 573, 2217)), ("T", (172, 288, 589, 2197))])
def test_triangulations_have_nearly_the_published_points(section, points):
    """Each triangulation has within 3 % of the published number of points, and the published number on its sides."""
    for level, n_points in enumerate(points, start=1):
        assert torsion_mesh(section, "D", level).n_points == pytest.approx(n_points, rel=0.03)
    edges = [len(torsion_mesh(section, "D", level).boundary_edges) for level in (1, 2, 3, 4)]
    assert edges == ([40, 56, 80, 160] if section == "S" else [48, 63, 93, 183])
