"""Locks, workers and folders on each operating system; Windows is imitated by what it lacks and by its own module."""

import ast
import multiprocessing
import os
import signal
import subprocess
import sys
import types
from pathlib import Path

import pytest

import flangeway
from flangeway.campaign.database import CampaignDatabase
from flangeway.errors import InputError
from flangeway.system import operating_system as system

PACKAGE = Path(flangeway.__file__).parent
OF_SOME = {"fcntl", "grp", "msvcrt", "posix", "pwd", "resource", "termios", "winreg"}
ATTRIBUTES = {"sched_getaffinity", "fork", "killpg", "geteuid", "getuid", "pthread_sigmask", "pthread_kill", "mkfifo"}


class Windows(types.ModuleType):
    """What `msvcrt` does with locks: one byte at the position of the file, for one file at a time."""

    LK_NBLCK = 2

    def __init__(self):
        super().__init__("msvcrt")
        self.locked = set()

    def locking(self, number, mode, n_bytes):
        assert mode == self.LK_NBLCK
        status = os.fstat(number)
        place = (status.st_dev, status.st_ino, os.lseek(number, 0, os.SEEK_CUR), n_bytes)
        if place in self.locked:
            raise PermissionError(13, "Permission denied")
        self.locked.add(place)


@pytest.fixture
def windows(monkeypatch):
    """Take what Windows lacks away from this process, and give it `msvcrt`."""
    for name in ("fcntl", "resource"):
        monkeypatch.setitem(sys.modules, name, None)
    module = Windows()
    monkeypatch.setitem(sys.modules, "msvcrt", module)
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.delattr(signal, "pthread_sigmask", raising=False)
    monkeypatch.setattr(multiprocessing, "get_all_start_methods", lambda: ["spawn"])
    return module


def test_no_other_module_names_what_a_system_lacks():
    """Modules that only some systems have, and such functions, are named in one module of the package only."""
    for path in PACKAGE.rglob("*.py"):
        if path.stem == "operating_system":
            continue
        text = path.read_text(encoding="utf-8")
        if not any(word in text for word in OF_SOME | ATTRIBUTES):
            continue
        for node in ast.walk(ast.parse(text)):
            names = {alias.name for alias in node.names} if isinstance(node, ast.Import) else set()
            names |= {node.module} if isinstance(node, ast.ImportFrom) else set()
            assert not names & OF_SOME, path
            assert not (isinstance(node, ast.Attribute) and node.attr in ATTRIBUTES), f"{path}:{node.lineno}"


@pytest.mark.parametrize("imitated", [False, True])
def test_a_campaigns_file_has_one_writer(request, tmp_path, imitated):
    """A second coordinator is refused with what to do, with either kind of lock."""
    if imitated:
        request.getfixturevalue("windows")
    with CampaignDatabase(tmp_path / "c.sqlite"), pytest.raises(InputError, match="which another process writes"):
        CampaignDatabase(tmp_path / "c.sqlite")


def test_without_the_functions_of_unix_there_are_answers_all_the_same(windows, monkeypatch):
    """Cores, start of workers, and interrupts where nothing can be asked or blocked; missing modules are None."""
    assert system.number_of_cores() == os.cpu_count()
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert system.number_of_cores() == 1
    assert system.worker_start_method() == "spawn"
    assert system.system_module("resource") is None
    with system.interrupts_blocked():
        pass


@pytest.mark.parametrize(
    ("given", "parent"),
    [
        ({"XDG_CACHE_HOME": "a", "LOCALAPPDATA": "b"}, Path("a")),
        ({"XDG_CACHE_HOME": "", "LOCALAPPDATA": "b"}, Path("b")),
        ({"HOME": "/c", "USERPROFILE": "/c"}, Path("/c/.cache")),
    ],
)
def test_the_cache_is_where_the_system_keeps_such_files(monkeypatch, given, parent):
    """The variable of Linux comes first, then that of Windows, then the folder of the user."""
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    assert system.cache_parent() == parent


WITHOUT_UNIX = """
import multiprocessing, os, signal, subprocess, sys, types
import psutil  # it has parts of its own for each system, and this one's needs the modules of Unix
for name in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[name] = None
for module, name in ((os, "sched_getaffinity"), (os, "sysconf"), (signal, "pthread_sigmask")):
    vars(module).pop(name, None)
multiprocessing.get_all_start_methods = lambda: ["spawn"]
sys.modules["msvcrt"] = types.SimpleNamespace(LK_NBLCK=2, locking=lambda *_: None)
if __name__ == "__main__":
    sys.argv[0] = "flangeway"
    from flangeway.cli import main
    main()
"""

CAMPAIGN = """
case = "hertz"
[inputs]
size_mm = 1.0
[vary]
indentation_mm = [0.1, 0.2]
"""


@pytest.mark.ci
def test_commands_run_without_the_functions_of_unix(tmp_path):
    """A campaign with two workers, which begin as fresh processes, computes its rows where Unix's functions lack."""
    (tmp_path / "windows.py").write_text(WITHOUT_UNIX, encoding="utf-8")
    (tmp_path / "loads.toml").write_text(CAMPAIGN, encoding="utf-8")
    command = [sys.executable, "windows.py", "campaign", "loads.toml", "--workers", "2", "--out", "out"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    rows = (tmp_path / "out" / "results.csv").read_text(encoding="utf-8").splitlines()
    assert [row.split(",")[1] for row in rows[1:]] == ["converged", "converged"], rows
