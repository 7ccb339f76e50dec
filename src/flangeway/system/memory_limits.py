"""How much memory may be used; work that needs more is refused before it begins.

``FLANGEWAY_MEMORY_GB`` limits what a process holds, in units of 1e9 bytes; left out it is what the machine, or the
control group of the process, has left. A limit of the address space counts in any case.
"""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import psutil

from flangeway.errors import InputError, OutOfMemoryError
from flangeway.system.operating_system import system_module

LIMIT = "FLANGEWAY_MEMORY_GB"
GB = 1e9
SMALL = 10_000_000  # bytes that every machine has: to ask the system takes longer than small work


def memory_left() -> int:
    """Bytes that this process may still take. An `InputError` if ``FLANGEWAY_MEMORY_GB`` is not a positive number."""
    return max(0, min(bytes_left for bytes_left, _ in _bounds()))


def refuse_beyond_memory(work: str, needed: int) -> None:
    """Raise an `OutOfMemoryError` where some work needs more bytes than may be taken."""
    if needed < SMALL and LIMIT not in os.environ:
        return
    if needed > memory_left():
        raise out_of_memory(work, needed)


@contextmanager
def memory_limited(n_bytes: int) -> Iterator[None]:
    """Let this process take up to so many bytes more, where the system can say so; a `MemoryError` beyond."""
    resource = system_module("resource")
    if resource is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = psutil.Process().memory_info().vms + n_bytes
    resource.setrlimit(resource.RLIMIT_AS, (limit if soft == resource.RLIM_INFINITY else min(limit, soft), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def refuse_large_mesh(work: str, needed: int) -> None:
    """Do the same for work on meshes, of which what needs less than `SMALL` is let through under any limit.

    Where a limit leaves no room for that, later work is refused, with a better message.
    """
    if needed >= SMALL:
        refuse_beyond_memory(work, needed)


def out_of_memory(work: str, needed: int | None) -> OutOfMemoryError:
    """Error of work that needs so many bytes, or more entries than can be counted (None)."""
    if needed is None:
        return OutOfMemoryError(f"{work}, which needs more than 2^31 - 1 entries", "a problem with fewer")
    left, why = min(_bounds())
    return OutOfMemoryError(f"{work}, which needs about {_size(needed)} of memory", f"{_size(max(0, left))}, {why}")


def peak_memory_bytes() -> int:
    """Most memory that this process has held at a time, in bytes; 0 where the system does not report it."""
    # the process's own: what `resource` reports begins with that of the process that started it
    peak = re.search(r"^VmHWM:\s+(\d+) kB", _text(Path("/proc/self/status")), re.MULTILINE)
    if peak:
        return 1024 * int(peak[1])
    resource = system_module("resource")
    if resource is None:
        return int(getattr(psutil.Process().memory_info(), "peak_wset", 0))  # Windows
    return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * (1 if sys.platform == "darwin" else 1024)


def _bounds() -> Iterator[tuple[int, str]]:
    """Bytes left by each limit, and in words what limits."""
    memory = psutil.Process().memory_info()
    held = memory.rss
    given = os.environ.get(LIMIT, "")
    if given:
        limit = int(GB * size_of_variable(LIMIT, given, "gigabytes", "leave it out"))
        yield limit - held, f"what {LIMIT} or --memory ({limit / GB:g} GB) leaves beside {_size(held)} in use"
    else:
        yield psutil.virtual_memory().available, "what this machine has left"
        yield from ((left, "what the control group of this process has left") for left in _control_groups(Path("/")))
    resource = system_module("resource")
    if resource is not None and (most := resource.getrlimit(resource.RLIMIT_AS)[0]) != resource.RLIM_INFINITY:
        yield int(most) - memory.vms, "what the limit of the address space (ulimit -v) leaves"


def size_of_variable(name: str, given: str, unit: str, otherwise: str) -> float:
    """Number of a variable of the environment; an `InputError` if it is not positive.

    - `given`: its text.
    - `otherwise`: what to do instead of correcting it.
    """
    try:
        size = float(given)
    except ValueError:
        size = -1.0
    if not (np.isfinite(size) and size > 0.0):
        raise InputError(f"{name}={given}", f"a positive number of {unit}", f"correct it, or {otherwise}")
    return size


def _control_groups(root: Path) -> Iterator[int]:
    """Bytes left in each control group (of either version) that this process is in."""
    for line in _text(root / "proc/self/cgroup").splitlines():
        _, controllers, path = line.split(":", 2)
        if controllers and "memory" not in controllers.split(","):
            continue
        top = root / "sys/fs/cgroup" / ("memory" if controllers else "")
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes") if controllers else ("memory.max", "memory.current")
        folder = top / path.lstrip("/")
        for group in (folder, *(parent for parent in folder.parents if parent.is_relative_to(top))):
            limit, used = (_text(group / name).strip() for name in names)
            if limit.isdigit() and used.isdigit():
                cached = re.search(r"^(?:total_)?inactive_file (\d+)", _text(group / "memory.stat"), re.MULTILINE)
                yield int(limit) - int(used) + (int(cached[1]) if cached else 0)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError:
        return ""


def _size(n_bytes: int) -> str:
    return f"{n_bytes / GB:.3g} GB" if n_bytes >= GB else f"{n_bytes / 1e6:.3g} MB"
