"""Installs a wheel as a user does who has no compiler, runs the main job and a study, and tests what was installed.

``python .ci/wheel.py dist/flangeway-*.whl [TESTS...]``, on any operating system, from the sources of the same version.
The tests, `TESTS` if left out, import the package from the wheel: no folder of sources is searched.
"""

import os
import subprocess
import sys
import tempfile
import time
import venv
import zipfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
MAIN_JOB_S = 60.0
TESTS = (
    "tests/test_names_at_the_top.py",
    "tests/test_packaging.py",
    "tests/system",
    "tests/patch/test_elasticity_patch.py",
    "tests/formats",
    "tests/solve/test_cache.py",
    "tests/railway/wheelset/test_wheelset_tangent.py",
    "tests/cases/test_case_files.py",
)
GMSH_OF_SYSTEM = sys.platform == "linux" and os.uname().machine == "aarch64"


def main(wheel: Path, tests: Sequence[str] = TESTS) -> None:
    """Make an environment with the wheel, and run the main job, a study and the tests in it."""
    packages = {name.partition("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    if {name for name in packages if not name.endswith((".dist-info", ".libs"))} != {"flangeway"}:
        sys.exit(f"the wheel has other packages than flangeway: {', '.join(sorted(packages))}")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        venv.create(folder / "venv", with_pip=True, system_site_packages=GMSH_OF_SYSTEM)
        programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        # only wheels: nothing is compiled; and nothing of this process's packages or cache is found
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | {
            "PIP_ONLY_BINARY": ":all:",
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
            "FLANGEWAY_CACHE": str(folder / "cache"),
        }

        def run(program: str, *arguments: str, where: Path, status: int = 0) -> None:
            command = [str(programs / program), *arguments]
            ended = subprocess.run(command, cwd=where, env=environment, check=False).returncode
            if ended != status:
                sys.exit(f"{' '.join(command)} ended with status {ended}, not {status}")

        run("python", "-m", "pip", "install", "-q", str(wheel.resolve()), where=folder)
        start, before = time.monotonic(), os.times()
        run("flangeway", "run", "wheelset", where=folder)
        seconds, after = time.monotonic() - start, os.times()
        busy = sum(after[2:4]) - sum(before[2:4])  # processor time, which no other load changes much; 0 on Windows
        print(f"flangeway run wheelset, installed from {wheel.name}: {seconds:.1f} s, {busy:.1f} s of a processor")
        if busy > MAIN_JOB_S:
            sys.exit(f"the main job took more than {MAIN_JOB_S:.0f} s of a processor")
        (folder / "studies").mkdir()
        (folder / "studies" / "__init__.py").write_text("raise SystemExit('a folder of the user was imported')\n")
        study = ("-m", "flangeway", "reproduce", "conicity", "-q")
        run("python", *study, where=folder, status=1)  # the message names the package of studies
        run("python", "-m", "pip", "install", "-q", str(ROOT / "studies"), where=folder)
        run("python", *study, where=folder)
        run("python", "-m", "pip", "install", "-q", "pytest>=8", "hypothesis>=6.100", where=folder)
        run("python", "-m", "pytest", "-q", *tests, where=ROOT)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:] or TESTS)
