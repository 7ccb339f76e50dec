"""Every example runs, and its own checks hold."""

import importlib.util
import re
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


GALLERY = sorted(path for path in (EXAMPLES / "gallery").glob("*.py") if path.stem != "gallery_drawing")


@pytest.mark.ci
@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_an_example_of_the_gallery_holds_and_is_on_its_page(path, capsys, monkeypatch):
    """Its checks hold, it prints a number and returns a picture; the page shows it, in at most 25 kB."""
    monkeypatch.syspath_prepend(str(path.parent))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    figure = module.main()
    assert figure.axes
    assert re.search(r"\d", capsys.readouterr().out)
    assert 15 <= len(path.read_text().splitlines()) <= 50
    docs = EXAMPLES.parent / "docs"
    assert (docs / "images" / "examples" / f"{path.stem}.png").stat().st_size <= 25_000
    page = (docs / "gallery.md").read_text(encoding="utf-8")
    assert f"images/examples/{path.stem}.png" in page
    assert module.__doc__.splitlines()[0].rstrip(".") in page
