"""What Linux, macOS and Windows do differently; no other module names a function that one of them lacks."""

import importlib
import os
import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from flangeway.errors import MissingLibraryError

INPUT_CAN_BE_WATCHED = sys.platform != "win32"
"""Whether a thread may wait for the standard input; on Windows a library that is loaded would wait for that thread."""


def system_module(name: str) -> Any:
    """Return a module of Python that only some systems have, such as ``resource``; None where it is missing."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def optional_module(name: str, need: str, remedy: str) -> Any:
    """Return a module that is installed with the option ``campaign``, or raise a `MissingLibraryError`.

    - `need`: what needs which library.
    - `remedy`: what else the user can do.
    """
    try:
        return importlib.import_module(name)
    except ImportError as reason:
        raise MissingLibraryError(
            f"{need}, which is not installed\n  what to do: pip install 'flangeway[campaign]'{remedy}"
        ) from reason


def lock_file(file: IO[bytes]) -> None:
    """Lock an open file for this process until it is closed or the process ends, however it ends.

    An `OSError` if another process has locked it.
    """
    posix = system_module("fcntl")
    if posix is not None:
        posix.flock(file, posix.LOCK_EX | posix.LOCK_NB)
    else:
        windows = importlib.import_module("msvcrt")
        file.seek(0)  # what is locked begins here: one byte, which need not exist
        windows.locking(file.fileno(), windows.LK_NBLCK, 1)


def number_of_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cache_parent() -> Path:
    """Folder of what programs can make anew: ``$XDG_CACHE_HOME``, ``%LOCALAPPDATA%`` of Windows, or ``~/.cache``."""
    named = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    return Path(named) if named else Path("~/.cache").expanduser()


@contextmanager
def environment(variables: Mapping[str, str]) -> Iterator[None]:
    """Set variables of the environment, which other processes inherit, for some time."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


def worker_start_method() -> str:
    """Return how `multiprocessing` starts workers: forks of a fresh process, or fresh processes where none can fork."""
    import multiprocessing  # noqa: PLC0415 (commands without workers do without it)

    return "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C in processes that begin meanwhile; where the system cannot, they must ignore it themselves."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
