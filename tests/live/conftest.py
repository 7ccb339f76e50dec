"""A live page on a free port of this machine, with coarse bodies, and profiles that a user could drop."""

import threading
import time
from pathlib import Path

import pytest

from flangeway.cases.profile_run import run_profile
from flangeway.live import LiveServer
from flangeway.railway.profiles.profile_file import profile_text

STANDS = "document.querySelector('#state').className.match(/good|warned/) && !document.querySelector('#tables.stale')"
"""Condition of the page: the last position is computed and shown."""


@pytest.fixture(scope="session")
def profiles(tmp_path_factory):
    """MiniProf files of an S1002 and a 60E1, as an instrument writes them."""
    folder = tmp_path_factory.mktemp("profiles")
    for name, file in (("S1002", "my-wheel.whl"), ("60E1", "my-rail.ban")):
        (folder / file).write_text(profile_text(run_profile(name).profile, Path(file).suffix), encoding="utf-8")
    return folder


@pytest.fixture(scope="session", params=["metric"])
def served(request):
    """A server without files of its own, in a thread of this process."""
    server = LiveServer([], units=request.param)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    while not server.server.started:
        time.sleep(0.02)
    yield server
    server.close()
    thread.join(timeout=20)
    assert not thread.is_alive()
    assert not server.engine.folder.exists()


@pytest.fixture
def page(browser, served):
    """The page with bundled profiles and coarse bodies, and the requests and errors of the browser."""
    served.engine.files.clear()  # the page begins with the files that it is served with
    # the tests look into the page by texts of code, which its own policy forbids
    context = browser.new_context(viewport={"width": 1400, "height": 900}, bypass_csp=True)
    page = context.new_page()
    page.requested, page.wrong = [], []
    page.on("request", lambda request: page.requested.append(request.url))
    page.on("pageerror", lambda error: page.wrong.append(str(error)))
    page.goto(served.address)
    page.evaluate("started")
    page.evaluate("state.inputs['mesh.size_scale'] = '3'; loadGeometry()")
    yield page
    assert page.wrong == []
    context.close()
