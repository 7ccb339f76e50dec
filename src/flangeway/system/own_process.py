"""Work in another process, which Ctrl-C ends at once.

Compiled code does not let Python see a signal before it returns. A process that computes for a long time is ended
instead, with all that it holds, while this one goes on.
"""

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.spawn import get_executable
from typing import Any, NoReturn, TypeVar

from flangeway.errors import FlangewayError, InputError, OutOfMemoryError, UnforeseenError, unforeseen
from flangeway.system.operating_system import INPUT_CAN_BE_WATCHED

Result = TypeVar("Result")

BYTES = 120_000_000  # memory of a process that has loaded NumPy, SciPy and Gmsh; measured 104 to 115 MB

_PROGRAM = """
import pickle, signal, sys
if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:  # as in a job that runs in the background
    signal.signal(signal.SIGINT, signal.SIG_DFL)
sys.path[:] = pickle.load(sys.stdin.buffer)
from flangeway.system.own_process import serve
serve()
"""


def in_own_process(work: Callable[..., Result], *arguments: Any) -> Result:
    """Return the result of a function of a module, called by a new process of the same Python that ends with this one.

    The arguments are all that `pickle` takes. Raises what the function raises; `UnforeseenError` for an error of
    another kind, `OutOfMemoryError` if the system kills the process, and `KeyboardInterrupt` on Ctrl-C, at once.
    """
    command = [get_executable(), "-c", _PROGRAM]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            with suppress(BrokenPipeError):  # reported by the missing answer
                process.stdin.write(pickle.dumps(sys.path) + pickle.dumps((work, arguments)))
                process.stdin.flush()  # and stays open: its end shows the process that this one has ended
            answer = process.stdout.read()
            status = process.wait()
        except BaseException:
            process.kill()
            raise
    if not answer:
        _raise_lost(status)
    kind, content = pickle.loads(answer)
    if kind == "error":
        raise content
    if kind == "defect":
        raise UnforeseenError(content)
    result: Result = content
    return result


def serve() -> NoReturn:
    """Do the work that the standard input describes, write the result, and end."""
    # what Gmsh may print goes with the errors
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    work, arguments = pickle.load(sys.stdin.buffer)
    if INPUT_CAN_BE_WATCHED:
        threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        answer: tuple[str, Any] = ("result", work(*arguments))
    except (FlangewayError, MemoryError) as error:
        answer = ("error", error)
    except Exception as error:  # a defect, reported in the other process
        answer = ("defect", unforeseen(error))
    answers.write(pickle.dumps(answer))
    answers.flush()
    os._exit(0)


def _end_with_parent() -> None:
    sys.stdin.buffer.read(1)
    os._exit(1)


def _raise_lost(status: int) -> NoReturn:
    """Raise what the status of a process says that gave no answer."""
    if status == -signal.SIGINT:  # of the terminal, which reaches both processes
        raise KeyboardInterrupt
    if status == -getattr(signal, "SIGKILL", 9):
        raise OutOfMemoryError("triangulation by Gmsh, whose process the system has killed")
    raise InputError(
        f"a region at which Gmsh failed: its process ended with status {status}",
        "outlines without slivers much smaller than the size",
        "look at the outline, or enlarge the size",
    )
