"""What was computed before is taken from the cache, checked, and never trusted blindly."""

from pathlib import Path

import numpy as np
import pytest

from flangeway.materials import Elastic
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.track.discretisation import Discretisation
from flangeway.railway.track.placements import Track, Wheelset
from flangeway.railway.track.wheelset_load import WheelsetLoad
from flangeway.railway.track.wheelset_problem import WheelsetProblem
from flangeway.railway.wheelset.wheelset_result import WheelsetResult, solve_wheelset


def problem() -> WheelsetProblem:
    settings = Discretisation(size_scale=6.0)
    return WheelsetProblem(
        Track(rail()), Wheelset(wheel()), WheelsetLoad(200e3), Elastic(210e3, 0.3), discretisation=settings
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FLANGEWAY_CACHE", str(tmp_path))
    return tmp_path


def forces(result: WheelsetResult) -> np.ndarray:
    return np.array([patch.force_on_wheel_N for patch in result.patches])


def test_a_second_run_meshes_and_condenses_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It meshes and condenses nothing, and agrees to 1e-9 in forces and fields."""
    first = solve_wheelset(problem())

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("computed again")

    for name in (
        "flangeway.railway.wheelset.wheelset_mesh.triangulate",
        "flangeway.solve.condensed.CondensedBody._computed",
    ):
        monkeypatch.setattr(name, refuse)
    second = solve_wheelset(problem())
    assert second.status == first.status
    np.testing.assert_allclose(forces(second), forces(first), rtol=1e-9)
    for name, field in first.displacements.items():
        np.testing.assert_allclose(second.displacements[name], field, rtol=0.0, atol=1e-9 * np.abs(field).max())
    assert second.equilibrium.stable == first.equilibrium.stable
