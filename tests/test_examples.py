"""Every example runs, and its own checks hold."""

import importlib.util
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
ARGUMENTS = {"wheelset_tangent": {"size_scale": 2.0}}


@pytest.mark.ci
@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_example_runs_and_its_checks_hold(path, capsys):
    """The script's `main` ends without an error on a coarse mesh and says what it found."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main(**ARGUMENTS.get(path.stem, {}))
    assert capsys.readouterr().out
