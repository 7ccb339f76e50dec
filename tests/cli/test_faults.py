"""What the machine does to a run: folders that cannot be written, full disks, no memory, interruption, kill."""

import errno
import os
import sys
from pathlib import Path

import pytest

from tests.processes import MAIN, started

RUN = ("run", "hertz", "--set", "size_mm=0.5", "--no-pictures")


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def full_disk(after):
    """Return a replacement of ``Path.write_text`` and others that has room for a number of files."""
    left = [after]

    def write(path, data, *_, **__):
        left[0] -= 1
        half = data[: len(data) // 2]
        with path.open("wb" if isinstance(data, bytes) else "w") as file:
            file.write(data if left[0] >= 0 else half)
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    return write


def test_a_full_disk_leaves_no_half_file(call, monkeypatch, tmp_path):
    """If the disk is full after a file, the status is 2, the system's reason is printed, and no file stays."""
    write = full_disk(1)
    monkeypatch.setattr(Path, "write_text", write)
    monkeypatch.setattr(Path, "write_bytes", write)
    status, out, err = call(*RUN, "--out", "results")
    assert status == 2
    assert "results, which cannot be written: No space left on device" in err
    assert "what to do: choose another folder with --out" in err
    assert "Traceback" not in err
    assert "Report:" not in out
    assert everything(tmp_path) == []


def test_no_memory_is_told(call, monkeypatch, tmp_path):
    """If memory ends in a run, status 1, a sentence with what to do, and nothing written."""
    text = "Unable to allocate 74.5 GiB for an array"

    def fail(*_, **__):
        raise MemoryError(text)

    monkeypatch.setattr("flangeway.cases.bodies.two_bodies.press", fail)
    status, out, err = call(*RUN)
    assert status == 1
    assert "flangeway: out of memory" in err
    assert text in err
    assert "nothing was written" in err
    assert "make the elements larger" in err
    assert "Traceback" not in err
    assert out == ""
    assert everything(tmp_path) == []


@pytest.mark.ci
def test_a_real_limit_of_memory_is_told(tmp_path):
    """Under a limit of the address space that the run needs more than, status 1 and no traceback."""
    if sys.platform != "linux":
        pytest.skip("limits of the address space are those of Linux")
    # what is loaded already, and little more
    code = (
        "import re, resource, flangeway.report.case_outputs, flangeway.cases, gmsh\n"
        "used = int(re.search(r'VmSize:\\s+(\\d+)', open('/proc/self/status').read())[1]) * 1024\n"
        "resource.setrlimit(resource.RLIMIT_AS, (used + 40 * 2**20,) * 2)\n" + MAIN
    )
    process = started(tmp_path, "run", "cook", "--order", "1", "--set", "level=6", code=code, FLANGEWAY_CACHE="off")
    out, err = process.communicate(timeout=300)
    assert process.returncode == 1, err
    assert "flangeway: out of memory" in err
    assert "Traceback" not in err
    assert "Report:" not in out
    assert everything(tmp_path) == []


@pytest.mark.parametrize("arguments", [RUN, ("init", "hertz")])
def test_interruption_while_files_are_moved(call, monkeypatch, tmp_path, arguments):
    """Ctrl-C before the first file is at its place: status 130, a sentence, no file and no temporary folder."""

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("flangeway.system.output_folder.os.replace", stop)
    status, out, err = call(*arguments)
    assert status == 130
    assert "interrupted; nothing was written" in err
    assert "Traceback" not in err
    assert "Report:" not in out
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    assert list(tmp_path.glob(".flangeway-*")) == []
