"""Chapter 5 computed again, as `flangeway reproduce elasticity` does, and `flangeway reproduce all`."""

from dataclasses import dataclass

import numpy as np
import pytest

from flangeway.cases.bodies.cook import ENERGY, CookCode, cook_row
from flangeway.errors import InputError
from studies.elasticity import elasticity_reproduced as elasticity
from studies.elasticity.closed_form import PatchCode, closed_form_numbers, cook_reference, patch_row
from studies.elasticity.elasticity_reproduced import COOK, reproduce_elasticity
from studies.published_numbers import Reproduced

PUBLISHED = {
    "strain energy": 1542.159,
    "vertical displacement at (48; 52)": 30.7494,
    "vertical displacement at (48; 60)": 32.3007,
}


@pytest.fixture(scope="module")
def found():
    """The quick reproduction."""
    return reproduce_elasticity(quick=True)


def test_every_configuration_passes_the_patch_test(found):
    """Finite, virtual and mixed elements of order 1 and 2 give the uniform stress to 1e-9, displacements to 1e-10."""
    codes = {str(row.code) for row in found.patch}
    assert codes == {f"{method}PTO{order}" for method in ("FD", "VD", "VV", "HE") for order in (1, 2)}
    for row in found.patch:
        assert row.stress_error < 1e-9
        assert row.displacement_error < 1e-10


def test_the_patch_test_sees_a_wrong_stress():
    """The error of a row is the distance of the stress that differs most from tension, zero and zero."""
    row = patch_row(PatchCode("VV", 1))
    spoiled = type(row)(row.code, row.n_unknowns, (1.0, -0.25, 0.1), 0.0, row.solution)
    assert spoiled.stress_error == 0.25


def test_mixed_configurations_have_both_methods():
    """Codes with H and HE use virtual elements for all cells at the boundary and Lagrange triangles inside."""
    for space in (CookCode("H", 1, 2).space(), patch_row(PatchCode("HE", 2)).solution.problem.space):
        mesh = space.mesh
        outer = np.zeros(mesh.n_edges, dtype=bool)
        outer[mesh.edge_numbers(mesh.boundary_edges)] = True
        at_rim = np.add.reduceat(outer[mesh.cell_edges], mesh.cell_offsets[:-1]) > 0
        assert np.array_equal(np.flatnonzero(at_rim), np.sort(mesh.cell_sets["rim"]))
        assert np.array_equal(np.flatnonzero(~at_rim), np.sort(mesh.cell_sets["triangles"]))
        assert {type(batch.element).__name__ for batch in space.batches()} == {"Lagrange", "Virtual"}


def test_each_refinement_of_the_membrane_is_nearer_to_the_published_numbers(found):
    """Energy and both displacements are nearer on M2 than on M1 for every method and order, and within 10 % there."""
    rows = {(n.code, n.quantity): n for n in found.numbers if n.table == COOK}
    assert len(rows) == 30
    for (code, quantity), number in rows.items():
        assert number.published == PUBLISHED[quantity]
        assert number.relative_difference == pytest.approx(number.computed / PUBLISHED[quantity] - 1.0, abs=1e-12)
        if "M2" in code:
            before = rows[code.replace("M2", "M1"), quantity]
            assert abs(number.relative_difference) < abs(before.relative_difference) < 0.1


@pytest.mark.parametrize("method", ["F", "V", "H"])
def test_order_2_on_the_finest_mesh_is_within_a_thousandth(method):
    """On M4 triangles, polygons and both in one mesh give energy and displacements within 0.1 % of those published."""
    row = cook_row(CookCode(method, 4, 2))
    assert (row.energy, row.middle, row.corner) == pytest.approx(tuple(PUBLISHED.values()), rel=1e-3)


def test_a_row_farther_from_the_published_number_than_the_mesh_before_fails(found):
    """A number that moves away from the published one under refinement is not within."""
    coarse, fine = (next(row for row in found.cook if str(row.code) == code) for code in ("VCM1O1", "VCM2O1"))
    worse = type(fine)(fine.code, fine.poisson, fine.n_unknowns, *[0.8 * v for v in PUBLISHED.values()], fine.solution)
    numbers = list(elasticity._cook_numbers([coarse, worse]))
    assert [number.within for number in numbers] == [True] * 3 + [False] * 3


def test_the_reference_energy_rounds_to_the_published_one():
    """Order 3 on an adaptive mesh has the energy that errors are measured with to 1e-6, as published to all digits."""
    energy = cook_reference(1e-3).energy
    assert energy == pytest.approx(ENERGY, rel=2e-6)
    assert pytest.approx(PUBLISHED["strain energy"], abs=1e-3) == ENERGY


def test_nearly_incompressible_order_1_locks_on_triangles_only(found):
    """With nu = 0.4999 order 2 is within 1 %, polygons of order 1 within 2 % on M2, where triangles lack a fifth."""
    rows = {row.code: row for row in found.incompressible}
    assert found.failures == ()
    for code, row in rows.items():
        assert row.relative_difference == pytest.approx(row.load_work / 2652.4 - 1.0, abs=1e-12)
        if code.endswith("O2"):
            assert abs(row.relative_difference) < 0.01
    assert abs(rows["VCM2O1"].relative_difference) < 0.02
    assert rows["FCM2O1"].relative_difference < -0.2


def test_kirsch_and_lame_are_met():
    """Kirsch's plate is met to 0.5 %, Lame's cylinder to 0.1 %, its soft hoop stress (nu = 0.4999) to 2 %."""
    numbers = list(closed_form_numbers())
    assert len(numbers) == 2 * 3 + 8 * 3
    for number in numbers:
        soft = "0.4999" in number.code and number.quantity.startswith("hoop stress")
        limit = 0.02 if soft else {"Kirsch": 5e-3, "Lamé": 1e-3}[number.table]
        assert number.within
        assert number.computed == pytest.approx(number.published, rel=limit)


def test_refinement_where_the_error_is_saves_unknowns(found):
    """For uniform's least error the L-shaped body needs a tenth of its unknowns, Cook's membrane of order 2 a third."""
    savings = {(case.body, case.order): case.saving for case in found.refinements}
    assert min(savings["L-shape", 1], savings["L-shape", 2]) >= 10.0
    assert savings["Cook", 2] >= 3.0
    for case in found.refinements:
        reached = next(row for row in case.adaptive if row.error <= case.uniform[-1].error)
        assert case.saving == case.uniform[-1].n_unknowns / reached.n_unknowns


def test_the_membranes_estimate_is_near_its_true_error(found):
    """On the finest adaptive meshes of Cook's membrane the estimate is 0.75 to 1.25 times the true error."""
    for case in found.refinements:
        if case.body == "Cook":
            last = case.adaptive[-1]
            assert 0.75 < last.estimated_error / last.error < 1.25


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: CookCode("X", 1, 1), "'F', 'V' or 'H'"),
        (lambda: CookCode("F", 0, 1), "1 to 6"),
        (lambda: PatchCode("VX", 1), "FD, VD, VV, HE"),
    ],
)
def test_wrong_codes_are_refused(make, message):
    """A method or a refinement that there is not is refused, with those that there are."""
    with pytest.raises(InputError, match=message):
        make()


@dataclass(frozen=True, eq=False, kw_only=True)
class Found(Reproduced):
    """What a made-up reproduction leaves."""

    failures: tuple = ()
