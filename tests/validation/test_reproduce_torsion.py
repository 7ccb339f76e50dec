"""The published torsion tables computed again, as `flangeway reproduce torsion` does."""

import csv

import pytest

from flangeway.errors import InputError
from studies.published_numbers import write_numbers
from studies.registry import REPRODUCTIONS
from studies.reproduction import find_reproductions
from studies.torsion.torsion_reproduced import LIMITS, reproduce_torsion


@pytest.fixture(scope="module")
def found():
    """All four refinements."""
    return reproduce_torsion()


def test_at_least_90_of_the_96_errors_are_within_15_percent(found):
    """Of the 96 published errors of the torsion constant, 90 or more are met within 15 %."""
    assert len(found.errors) == 96
    assert LIMITS["relative_error"] == 0.15
    assert sum(abs(n.computed / n.published - 1.0) <= 0.15 for n in found.errors) == found.n_within >= 90
    assert found.passed


def test_each_error_outside_has_a_reason_that_covers_it(found):
    """An error outside 15 % is explained by meshes of nearly the same size, whose errors enclose the published one."""
    outside = [number for number in found.errors if not number.within]
    assert outside, "the claim would be empty"
    for number in outside:
        assert "lies between them" in number.note
        assert "not between" not in number.note


def test_both_readings_of_prandtls_load_are_shown(found):
    """Polygons of order 1 have the published reading within 15 %, and the more accurate one beside it with a note."""
    other = [n for n in found.numbers if n.quantity == "relative_error (projected load)"]
    assert len(other) == 8
    for number in other:
        main = next(n for n in found.errors if (n.table, n.code) == (number.table, number.code))
        assert main.within
        assert number.computed < main.computed
        assert "(3.81)" in number.note


def test_rates_are_as_published(found):
    """All 24 rates over unknowns are those of the published errors to 0.15, and those of theory to 0.6."""
    assert len(found.rates) == 24
    for rate in found.rates:
        assert rate.within
        assert rate.computed == pytest.approx(rate.published, abs=0.15)
        assert rate.computed == pytest.approx(rate.expected, abs=0.6)


def test_sizes_of_the_problems_are_the_published_ones(found):
    """Unknowns are within 5 %, h within 15 %, and constants within 0.1 % of those published."""
    for quantity, limit in (("n_dof", 0.05), ("h", 0.15), ("torsion_constant", 1e-3)):
        rows = [number for number in found.numbers if number.quantity == quantity]
        assert len(rows) == 96
        assert max(abs(number.relative_difference) for number in rows) <= limit


def test_quick_computes_the_coarser_half(tmp_path):
    """Quick has 48 of the 96 rows and no rates; the table is written with its columns and reads back."""
    found = reproduce_torsion(quick=True)
    assert len(found.errors) == 48
    assert found.rates == ()
    assert found.passed
    file = tmp_path / "table.csv"
    write_numbers(file, found.numbers)
    header, *lines = file.read_text(encoding="utf-8").splitlines()
    assert header == "table,code,quantity,unit,published,computed,relative_difference,limit,within,note"
    rows = list(csv.DictReader([header, *lines]))
    assert len(rows) == len(found.numbers)
    assert float(rows[3]["computed"]) == pytest.approx(found.numbers[3].computed, rel=1e-7)


def test_unknown_names_are_refused():
    """A name that cannot be reproduced is refused, with those that can, and `all` is every one of these."""
    with pytest.raises(InputError, match="one of: torsion"):
        find_reproductions("torsions", REPRODUCTIONS)
    assert find_reproductions("torsion", REPRODUCTIONS) == {"torsion": REPRODUCTIONS["torsion"]}
    assert find_reproductions("all", REPRODUCTIONS) == REPRODUCTIONS


def test_the_page_of_validation_is_this(found, same_as_page):
    """The section of torsion on the page of validation is written from these numbers."""
    same_as_page(REPRODUCTIONS["torsion"].chapter, found, whole=True)
