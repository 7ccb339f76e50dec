"""A live page on a free port of this machine, with coarse bodies, and profiles that a user could drop."""

import threading
import time
from pathlib import Path

import pytest

from flangeway.cases.profile_run import run_profile
from flangeway.live import LiveServer
from flangeway.railway.profiles.profile_file import profile_text


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
