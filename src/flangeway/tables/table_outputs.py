"""Files of a table of creep forces: arrays, CSV, README, and the FMU."""

import hashlib
import json
import os
import platform
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from flangeway.errors import MissingLibraryError
from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer, text_writer, write_together
from flangeway.system.templates import templates
from flangeway.tables import creep_table
from flangeway.tables.creep_table import OF_PATCH, SIDES, CreepTable
from flangeway.types import Floats

# --- The FMU: creep forces of a wheelset from a table, in plain C, by FMI 2.0 and FMI 3.0, without Python at run time.
#
# The source `creep_forces.c` is compiled by the C compiler of this machine for this machine; it is in the FMU as well,
# so that other machines can compile it.


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
    with tempfile.TemporaryDirectory() as folder_name:
        library, written = (Path(folder_name, name) for name in (f"{NAME}.{ending}", SOURCE.name))
        numbers, source = table_numbers(table).tobytes(), SOURCE.read_text(encoding="utf-8")
        token = str(uuid.uuid5(uuid.NAMESPACE_OID, f"{hashlib.sha256(numbers).hexdigest()} {source}"))
        source = f'#define TOKEN "{token}" /* of modelDescription.xml */\n{source}'
        written.write_text(source, encoding="utf-8")
        command = [compiler, "-std=c11", "-O2", "-shared", "-fPIC", "-fvisibility=hidden"]
        subprocess.run([*command, "-o", str(library), str(written), "-lm"], check=True, capture_output=True)
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", model_description(table, fmi, token))
            archive.writestr(f"resources/{TABLE_FILE}", numbers)
            archive.writestr(f"sources/{SOURCE.name}", source)
            archive.write(library, f"binaries/{folder}/{library.name}")


# --- Files of a table of creep forces: arrays, CSV, README, and the FMU.


TABLE, PATCHES, FORCES, README = "creep-table.npz", "patches.csv", "forces.csv", "README.md"
FMUS: dict[str, Fmi] = {f"{NAME}.fmu": "3.0", f"{NAME}-FMI2.fmu": "2.0"}
COLUMN = {"free_creepage": "free"}
ENDINGS: dict[str, Sequence[str]] = {
    "semi_axes_mm": "ab",
    "free": ("longitudinal_creepage", "lateral_creepage"),
    "stiffness_N": ("longitudinal", "lateral"),
}
"""COLUMN, ENDINGS: names of numbers in the table of patches that are others, and of the columns of two numbers."""


def write_table(table: CreepTable, folder: Path, *, fmu: bool = False) -> list[Path]:
    """Write all files of a table, or none of them; `fmu`: also as an FMU.

    Raises
    ------
    InputError
        If the folder cannot be written.
    MissingLibraryError
        If there is no C compiler, which an FMU needs.

    """
    return write_together(folder, table_writers(table, fmu=fmu))


def table_writers(table: CreepTable, *, fmu: bool = False) -> dict[str, Writer]:
    """Return functions that write the files of a table, by their names."""
    writers: dict[str, Writer] = {
        TABLE: lambda path: _write_arrays(table, path),
        PATCHES: text_writer(_patches_table(table).csv(9)),
        FORCES: lambda path: _write_forces(table, path),
        README: text_writer(_readme(table)),
    }
    return writers | ({name: partial(write_fmu, table, fmi) for name, fmi in FMUS.items()} if fmu else {})


def _write_arrays(table: CreepTable, path: Path) -> None:
    values: dict[str, Any] = {**table.values, "metadata": np.array(json.dumps(table.metadata))}
    with path.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **values)


def _patches(table: CreepTable) -> list[tuple[int, ...]]:
    """Places of the patches that there are: lateral, yaw, load, side, number."""
    return [tuple(row) for row in np.argwhere(table.values["normal_force_N"] > 0.0).tolist()]


def _patches_table(table: CreepTable) -> ResultTable:
    rows = []
    for number, patch in enumerate(_patches(table), 1):
        at = {name: axis[index] for name, axis, index in zip(creep_table.AXES, table.axes, patch, strict=False)}
        numbers = {COLUMN.get(name, name): table.values[name][patch].tolist() for name in OF_PATCH}
        rows.append({"patch": number, **at, "side": SIDES[patch[3]], **numbers})
    return ResultTable.of_rows(rows, ENDINGS)


def _write_forces(table: CreepTable, path: Path) -> None:
    slip, spin, creep = table.creep_axes
    points = [f"{a:g},{b:.6g},{c:.6g}" for a in slip for b in np.rad2deg(spin) for c in np.rad2deg(creep)]
    with path.open("w", encoding="utf-8") as file:
        file.write("patch,slip,spin_angle_deg,creep_angle_deg,longitudinal,lateral,moment\n")
        for number, patch in enumerate(_patches(table), 1):
            values = table.values["forces"][patch].reshape(-1, 3).tolist()
            file.writelines(
                f"{number},{point},{x:.5g},{y:.5g},{m:.5g}\n" for point, (x, y, m) in zip(points, values, strict=True)
            )


def _readme(table: CreepTable) -> str:
    template = templates(__package__, markup=False, percent="{:.2%}".format).get_template("README.md.jinja")
    return template.render(table=table, reader=creep_table)
