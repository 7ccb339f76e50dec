"""What several folders of tests share: the command line in this process, and small contact problems."""

import atexit
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass

# before NumPy is imported: on a busy machine, threads that wait for each other take minutes for small matrices
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# otherwise each process, of pytest-xdist and of a test, would compile everything again
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# nothing of another run may make a test pass: the cache is new, and all processes of this run share it
if "PYTEST_XDIST_WORKER" not in os.environ:
    os.environ["FLANGEWAY_CACHE"] = tempfile.mkdtemp(prefix="flangeway-cache-")
    atexit.register(shutil.rmtree, os.environ["FLANGEWAY_CACHE"], ignore_errors=True)

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from flangeway import cli
from flangeway.contact import Contact, ContactSystem, NodeToSegment, Penalty, Surface
from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import Arc, Line, Outline, Placement, rectangle
from flangeway.materials import Elastic
from flangeway.mesh import Refinement, dual, triangulate
from flangeway.problems import Body, Part

# A commit is judged by the same examples everywhere: 50 of each test, or 1,000 with HYPOTHESIS_PROFILE=ci.
# HYPOTHESIS_PROFILE=search draws 1,000 new ones at every run.
# Tests with @settings.get_profile("costly"), whose examples take 0.03 s or more, have a fifth of these numbers.
# No clock decides: a busy machine may take any time for an example and for making it.
checked = settings(
    settings.get_profile("default"), deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("default", checked, max_examples=50)
settings.register_profile("ci", checked, max_examples=1000)
settings.register_profile("search", checked, max_examples=1000, derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))
settings.register_profile("costly", max_examples=settings.default.max_examples // 5)

RADIUS = 50.0
STEEL = Elastic(210e3, 0.3)


LONG = {"follow", "followed", "background", "browser"}
"""Fixtures that run a page of the documentation from top to bottom or start a browser, which takes long."""


LONGEST = (
    "test_studies.py", "test_tutorials.py", "test_sectionproperties.py", "test_notebooks.py",
    "test_rolling_wheelset.py", "test_examples.py", "test_live_page.py", "test_cli.py",
    "test_spatial_wheelset_report.py", "test_virtual_variants.py", "test_campaign_resume.py",
)  # fmt: skip
"""Files of more than 10 s. They begin first, so that no worker has one of them alone at the end."""


def pytest_configure(config):
    """Keep the order of files, where pytest-xdist would begin with those of most tests."""
    config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Leave tests with such a fixture to CI, and begin with the longest files."""
    for item in items:
        if LONG.intersection(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.ci)
    items.sort(key=lambda item: LONGEST.index(item.path.name) if item.path.name in LONGEST else len(LONGEST))


BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER_REQUIRED = "FLANGEWAY_NEEDS_BROWSER"
BROWSER_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--enable-unsafe-swiftshader",
)  # fmt: skip


@pytest.fixture(scope="session")
def browser():
    """Chromium; its driver gives each start a new folder for its own files.

    One for all folders of tests: a second driver in the same process is refused.
    """
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 (most tests need no browser)

    path = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if path is None:
        missing = f"none of {', '.join(BROWSERS)} is installed"
        assert not os.environ.get(BROWSER_REQUIRED), f"{BROWSER_REQUIRED} is set, but {missing}"
        pytest.skip(f"no Chromium, and {BROWSER_REQUIRED} does not demand one")
    with sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=path, args=BROWSER_FLAGS)
        yield opened
        opened.close()


@pytest.fixture
def interruptible():
    """Give processes that a test starts the usual end by Ctrl-C, also where the tests themselves ignore it.

    A shell makes what it runs in the background ignore it, and children inherit that.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def call(monkeypatch, tmp_path, capsys):
    """Run the command line in this process, in a folder of its own; return status, stdout and stderr."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "140")
    monkeypatch.setenv("NO_COLOR", "1")

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["flangeway", *map(str, arguments)])
        with pytest.raises(SystemExit) as caught:
            cli.main()
        return caught.value.code, *capsys.readouterr()

    return run


@dataclass(frozen=True)
class Press:
    """A half disc over a block; the disc's cut and the block's bottom are held.

    Parameters
    ----------
    system
        The contact.
    disc, block
        The two parts; the disc touches the block at the origin.

    """

    system: ContactSystem
    disc: Part
    block: Part

    def placements(self, depth: float, turn: float = 0.0, shift: float = 0.0) -> tuple[Placement, ...]:
        """Parts with the disc pressed down, turned about its centre and moved sideways; the whole turned first."""
        own = Placement.about((0.0, RADIUS), turn)
        moved = Placement(0.0, (shift, -depth)).after(own)
        whole = self.block.placement
        of = {self.disc: whole.after(moved), self.block: whole}
        return tuple(of[part] for part in self.system.parts)


@pytest.fixture(scope="session")
def press() -> Callable[..., Press]:
    """Maker of small problems of a half disc on a block."""

    def make(
        method: str = "fem",
        size: float = 0.3,
        primary: str = "block",
        penalty: float = 1e6,
        whole: Placement | None = None,
    ) -> Press:
        arc = Arc((-RADIUS, RADIUS), (RADIUS, RADIUS), (0.0, RADIUS), counter_clockwise=True)
        disc = Outline.from_segments([arc, Line((RADIUS, RADIUS), (-RADIUS, RADIUS))], ["arc", "cut"])
        block = rectangle(60.0, 40.0, centre=(0.0, -20.0))
        bodies, zones = [], []
        for name, outline, held, surface in (("disc", disc, "cut", "arc"), ("block", block, "bottom", "top")):
            finer = 1.0 if name == "disc" else 1.13
            zone = np.array([[-6.0, 0.0], [6.0, 0.0]])
            mesh = triangulate(outline, size=8.0, refinements=(Refinement(zone, size * finer, 0.25),))
            element = Lagrange(1)
            if method == "vem":
                mesh, element = dual(mesh), Virtual(1)
            body = Body(name, mesh, element, STEEL, held, thickness=10.0)
            edges = mesh.edge_set(surface)
            near = (np.abs(mesh.points[edges][..., 0]) < 7.0).all(axis=1) & (mesh.points[edges][..., 1] < 5.0).all(
                axis=1
            )
            bodies.append(body)
            zones.append(edges[near])
        where = whole or Placement()
        parts = [Part(body.name, body, where) for body in bodies]
        secondary, primary_side = (Surface(part, zone) for part, zone in zip(parts, zones, strict=True))
        if primary == "disc":
            secondary, primary_side = primary_side, secondary
        contact = Contact(secondary, primary_side, NodeToSegment(), Penalty(penalty, per="length"))
        return Press(ContactSystem([contact]), parts[0], parts[1])

    return make
