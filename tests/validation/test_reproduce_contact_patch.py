"""The contact patch test computed again, as `flangeway reproduce contact-patch` does."""

import numpy as np
import pytest

from studies.contact_patch import contact_patch_reproduced
from studies.contact_patch.contact_patch_reproduced import (
    PASSED,
    PUBLISHED,
    ContactPatchReproduction,
    PatchRun,
    reproduce_contact_patch,
)

pytestmark = pytest.mark.ci


@pytest.fixture(scope="module")
def found() -> ContactPatchReproduction:
    """All three refinements."""
    return reproduce_contact_patch()


def by_code(found: ContactPatchReproduction) -> dict[str, PatchRun]:
    """Published configurations."""
    return {run.code: run for run in found.published}


def test_segment_to_segment_passes_everywhere(found: ContactPatchReproduction) -> None:
    """Pressures and stresses are uniform to 1e-8 for all elements, mixed sides, meshes, rotations and enforcements."""
    assert PASSED == 1e-8
    assert len(found.proper) == 108
    for run in found.proper:
        assert run.converged, f"{run.code}: {run.solution.status.message}"
        assert run.pressure_error < 1e-8, run.code
        assert run.stress_error < 1e-8, run.code
    kinds = {(run.case.upper_method, run.case.upper_order) for run in found.proper}
    assert kinds == {("fem", 1), ("fem", 2), ("vem", 1), ("vem", 2)}
    assert any(run.case.upper_method != run.case.lower_method for run in found.proper)
    assert any(run.matching for run in found.proper)
    assert {run.case.rotation_deg for run in found.proper} == {0, 30}
    assert {run.law for run in found.proper} == {"penalty", "augmented", "multiplier"}
    assert {run.pairing for run in found.proper} == {"segment-to-segment, standard", "segment-to-segment, dual"}


def test_multipliers_meet_the_published_stress(found: ContactPatchReproduction) -> None:
    """With multipliers the uniform stress is that of equation 6.1, -1125 kN/cm2, and the penalty gives 1.1 % less."""
    for run in found.proper:
        expected = 1125.0 if run.law != "penalty" else 0.1 / (2.0 * (8.0 / 9.0) / 20e3 + 1e-6)
        assert -run.mean_stress == pytest.approx(expected, rel=1e-9)
    assert PUBLISHED == -1125.0


def test_node_to_segment_fails_as_published(found: ContactPatchReproduction) -> None:
    """No configuration is exact: stresses are 1 to 15 % off, while the force is within 1 %."""
    runs = by_code(found)
    assert len(runs) == 12
    for run in runs.values():
        assert run.converged
        assert 0.008 < run.stress_error < 0.15
        assert run.mean_stress == pytest.approx(PUBLISHED, rel=0.01)
    assert found.passed


def test_node_to_segment_has_the_published_trends(found: ContactPatchReproduction) -> None:
    """Oscillations shrink with refinement in the mean square, and polygons have less than triangles of their order."""
    runs = by_code(found)
    for order in (1, 2):
        for method in "FV":
            oscillations = [runs[f"{method}PTM{level}O{order}"].stress_oscillation for level in (1, 2, 3)]
            assert oscillations[0] > oscillations[1] > oscillations[2]
        for level in (1, 2, 3):
            names = [f"{method}PTM{level}O{order}" for method in "VF"]
            assert runs[names[0]].stress_error < runs[names[1]].stress_error
            assert runs[names[0]].stress_oscillation < runs[names[1]].stress_oscillation


def test_forces_of_both_sides_balance(found: ContactPatchReproduction) -> None:
    """Forces and moments on the two boxes cancel to 1e-10 in every computation."""
    for run in (*found.published, *found.proper):
        sides = run.solution.resultants[0]
        assert np.abs(sides.sum(axis=0)).max() < 1e-10 * np.abs(sides).max()


def test_quick_leaves_out_the_finest_meshes(found: ContactPatchReproduction, monkeypatch: pytest.MonkeyPatch) -> None:
    """Quick takes M1 and M2 alone, of all that is computed."""
    left = [*found.published, *found.proper]

    def again(code: str, *_: object, **__: object) -> PatchRun:
        return left.pop(next(i for i, run in enumerate(left) if run.code == code))

    monkeypatch.setattr(contact_patch_reproduced, "patch_run", again)
    quick = reproduce_contact_patch(quick=True)
    assert {run.level for run in left} == {3}
    assert {run.code[4] for run in quick.published} == {"1", "2"}
    assert quick.passed
    assert all("M3" not in run.code for run in quick.proper)
