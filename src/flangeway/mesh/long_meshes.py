"""Triangulations that take long: what is told of them, and where they run."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from flangeway.mesh.expected_size import ExpectedMesh
from flangeway.mesh.polymesh import PolyMesh
from flangeway.system.memory_limits import refuse_large_mesh
from flangeway.system.own_process import BYTES, in_own_process

LONG = 3.0
"""Seconds for which one waits without a word, and after Ctrl-C."""

_TOLD: ContextVar[Callable[[str], None]] = ContextVar("_TOLD", default=lambda _: None)


@contextmanager
def long_meshes_reported(progress: Callable[[str], None]) -> Iterator[None]:
    """Tell of triangulations that take long, wherever they are begun inside this context.

    Most are begun deep inside of other work, which does not know of sizes.

    Parameters
    ----------
    progress
        Called with a sentence before each triangulation that is expected to take more than `LONG` seconds.

    """
    token = _TOLD.set(progress)
    try:
        yield
    finally:
        _TOLD.reset(token)


def made(expected: ExpectedMesh, work: Callable[..., PolyMesh], *arguments: Any) -> PolyMesh:
    """Return the mesh that some work makes: here if it is soon done, else in a process of its own.

    Parameters
    ----------
    expected
        How large it will be.
    work
        A function of a module.
    arguments
        What it is given.

    Raises
    ------
    OutOfMemoryError
        If there is no memory for it.

    """
    long = expected.seconds > LONG
    counted = f"about {float(f'{expected.n_triangles:.2g}'):,.0f} triangles"
    refuse_large_mesh(f"the triangulation into {counted}", expected.n_bytes + long * BYTES)
    if not long:
        return work(*arguments)
    _TOLD.get()(f"triangulating: {counted}, which take {_time(expected.seconds)}")
    return in_own_process(work, *arguments)


def _time(seconds: float) -> str:
    """Write a time as roughly as it is known."""
    if seconds < 90.0:
        return f"about {round(seconds, -1 if seconds > 10.0 else 0):.0f} seconds"
    return f"about {seconds / 60.0:.0f} minutes"
