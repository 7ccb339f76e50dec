"""The FMU: creep forces of a wheelset from a table, in plain C, by FMI 2.0 and FMI 3.0, without Python at run time.

The source `creep_forces.c` is compiled by the C compiler of this machine for this machine; it is in the FMU as well,
so that other machines can compile it.
"""

import hashlib
import os
import platform
import subprocess
import sys
import tempfile
import uuid
import zipfile
from pathlib import Path
from typing import Literal

import numpy as np

from flangeway.errors import MissingLibraryError
from flangeway.system.templates import templates
from flangeway.tables.creep_table import CreepTable
from flangeway.types import Floats

Fmi = Literal["2.0", "3.0"]

NAME = "WheelsetCreepForces"
SOURCE = Path(__file__).with_name("creep_forces.c")
TABLE_FILE = "creep-table.bin"
_OF_PATCH = (
    *("normal_force_N", "contact_angle_rad", "wheel_roll_rad", "rolling_radius_mm", "position_mm", "free_creepage"),
    *("stiffness_N", "radius_mm"),
)
"""Numbers of a patch in the order of the C source."""


def start_values(table: CreepTable) -> dict[str, float]:
    """Return the values of the inputs at the start: the middle of the table, rolling freely."""
    lateral, yaw, load = table.axes
    at = float(np.clip(0.0, lateral[0], lateral[-1])), float(np.clip(0.0, yaw[0], yaw[-1])), float(load[len(load) // 2])
    contacts = table.contacts(*at)
    radius = float(np.average(contacts["rolling_radius_mm"], weights=contacts["normal_force_N"]))
    position = {"lateral": 1e-3 * at[0], "yaw": -1e-3 * at[1], "load": 1e3 * at[2]}
    motion = {"speed": 20.0, "rotation": 20.0 / (1e-3 * radius), "lateral_velocity": 0.0, "yaw_rate": 0.0}
    return position | motion | {"friction": 0.3}


def table_numbers(table: CreepTable) -> Floats:
    """Return the numbers of the table in the order in which the C source reads them."""
    normal = table.values["normal_force_N"]
    patches = [table.values[name].reshape(*normal.shape, -1) for name in _OF_PATCH]
    forces = table.force_axes
    head = [*(len(axis) for axis in table.axes), normal.shape[-1], *(len(axis) for axis in forces.axes)]
    axes = [*table.axes, *forces.axes, *table.smooth]
    arrays = [head, *axes, table.values["joined"], np.concatenate(patches, axis=-1), forces.linear, forces.rest]
    parts = [np.asarray(array, dtype=np.float64).ravel() for array in arrays]
    return np.concatenate(parts)


def model_description(table: CreepTable, fmi: Fmi, token: str) -> str:
    """Return ``modelDescription.xml`` of a version of FMI; the numbers of variables are those of the C source."""
    template = templates(__package__, markup=True).get_template("modelDescription.xml.jinja")
    return template.render(fmi=fmi, second=fmi == "2.0", name=NAME, token=token, start=start_values(table))


def refuse_without_compiler() -> str:
    """Return the C compiler, the one in the variable ``CC`` or ``cc``; a `MissingLibraryError` if there is none."""
    compiler = os.environ.get("CC", "cc")
    try:
        subprocess.run([compiler, "--version"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as reason:
        raise MissingLibraryError(
            f"an FMU needs a C compiler, and {compiler} does not run\n"
            "  what to do: install one (on Debian: apt-get install gcc), or name it in the variable CC"
        ) from reason
    return compiler


def write_fmu(table: CreepTable, fmi: Fmi, path: Path) -> None:
    """Write the FMU of a table for this machine; a `MissingLibraryError` if there is no C compiler."""
    compiler = refuse_without_compiler()
    system = {"linux": "linux", "darwin": "darwin", "win32": "windows"}.get(sys.platform, sys.platform)
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    old = {"linux": "linux", "darwin": "darwin", "windows": "win"}.get(system, system)
    folder = f"{old}64" if fmi == "2.0" else f"{machine}-{system}"
    ending = {"linux": "so", "darwin": "dylib", "windows": "dll"}.get(system, "so")
    with tempfile.TemporaryDirectory() as place:
        library = Path(place, f"{NAME}.{ending}")
        command = [compiler, "-std=c11", "-O2", "-shared", "-fPIC", "-fvisibility=hidden"]
        subprocess.run([*command, "-o", str(library), str(SOURCE), "-lm"], check=True, capture_output=True)
        numbers, source = table_numbers(table).tobytes(), SOURCE.read_text(encoding="utf-8")
        token = str(uuid.uuid5(uuid.NAMESPACE_OID, f"{hashlib.sha256(numbers).hexdigest()} {source}"))
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", model_description(table, fmi, token))
            archive.writestr(f"resources/{TABLE_FILE}", numbers)
            archive.writestr(f"sources/{SOURCE.name}", source)
            archive.write(library, f"binaries/{folder}/{library.name}")
