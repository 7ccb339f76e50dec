"""Processes that tests start: Python with all that this one finds, from whatever folder."""

import os
import subprocess
import sys
from pathlib import Path

MAIN = "from flangeway.cli import main; main()"


def environment(*folders: Path, **others: str) -> dict[str, str]:
    """Variables with the paths of this process after some folders, plain lines of 100 columns, and others."""
    paths = [*map(str, folders), *(str(Path(path).resolve()) for path in sys.path if path)]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths), "COLUMNS": "100", "NO_COLOR": "1", **others}


def started(folder: Path, *arguments: object, code: str = MAIN, **others: str) -> subprocess.Popen[str]:
    """Start code, the command line if none is given, with arguments in a folder; its output goes to pipes."""
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment(folder, **others),
    )  # fmt: skip
