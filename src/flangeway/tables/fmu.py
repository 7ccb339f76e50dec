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
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from flangeway.errors import MissingLibraryError
from flangeway.tables.creep_table import SIDES, CreepTable
from flangeway.types import Floats

Fmi = Literal["2.0", "3.0"]

NAME = "WheelsetCreepForces"
SOURCE = Path(__file__).with_name("creep_forces.c")
TABLE_FILE = "creep-table.bin"
INPUTS = {
    "lateral": ("m", "lateral position of the axle in the track, to the right"),
    "yaw": ("rad", "yaw about z: positive where the left wheel is ahead"),
    "load": ("N", "axle load; at the start the middle of the table"),
    "speed": ("m/s", "speed of the axle along the track; backwards it is negative"),
    "rotation": ("rad/s", "rotation of the axle, positive where it rolls ahead; at the start free rolling"),
    "lateral_velocity": ("m/s", "velocity of the axle to the right, relative to the track"),
    "yaw_rate": ("rad/s", "rate of yaw about z, relative to the track"),
    "friction": ("", "coefficient of friction"),
}
OUTPUTS = {
    "fx": ("N", "force ahead"), "fy": ("N", "force to the right"), "fz": ("N", "force down"),
    "mx": ("N.m", "moment about x"), "my": ("N.m", "moment about y"), "mz": ("N.m", "moment about z"),
    "normal": ("N", "sum of the normal forces"), "longitudinal": ("N", "sum of the longitudinal creep forces"),
    "lateral": ("N", "sum of the lateral creep forces in the planes of contact, to the right"),
}  # fmt: skip
UNITS = {
    "m": {"m": 1}, "s": {"s": 1}, "rad": {"rad": 1}, "N": {"kg": 1, "m": 1, "s": -2}, "m/s": {"m": 1, "s": -1},
    "rad/s": {"rad": 1, "s": -1}, "N.m": {"kg": 1, "m": 2, "s": -2},
}  # fmt: skip
_OF_PATCH = (
    *("normal_force_N", "contact_angle_rad", "wheel_roll_rad", "rolling_radius_mm", "position_mm", "free_creepage"),
    *("stiffness_N", "radius_mm"),
)
"""Numbers of a patch in the order of the C source."""


@dataclass(frozen=True)
class Variable:
    """A variable of the model; its number is its reference in both versions of FMI."""

    name: str
    causality: str
    unit: str
    description: str
    boolean: bool = False


def variables() -> list[Variable]:
    """Return the variables in the order of their references, those of the C source."""
    found = [Variable("time", "independent", "s", "time")]
    found += [Variable(name, "input", unit, words) for name, (unit, words) in INPUTS.items()]
    found += [
        Variable(f"{side}_{name}", "output", unit, f"{side} wheel: {words}")
        for side in SIDES
        for name, (unit, words) in OUTPUTS.items()
    ]
    outside = "whether an input is out of the table's range, where the nearest position counts"
    clamp = "whether inputs out of the table's range are allowed; otherwise they are an error"
    return [*found, Variable("outside", "output", "", outside, True), Variable("clamp", "parameter", "", clamp, True)]


def start_values(table: CreepTable) -> dict[str, float]:
    """Return the values of the inputs at the start: the middle of the table, rolling freely."""
    lateral, yaw, load = table.axes
    at = float(np.clip(0.0, lateral[0], lateral[-1])), float(np.clip(0.0, yaw[0], yaw[-1])), float(load[len(load) // 2])
    contacts = table.contacts(*at)
    radius = float(np.average(contacts["rolling_radius_mm"], weights=contacts["normal_force_N"]))
    values = dict.fromkeys(INPUTS, 0.0)
    values |= {"lateral": 1e-3 * at[0], "yaw": -1e-3 * at[1], "load": 1e3 * at[2]}
    return values | {"speed": 20.0, "rotation": 20.0 / (1e-3 * radius), "friction": 0.3}


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
    """Return ``modelDescription.xml`` of a version of FMI."""
    second = fmi == "2.0"
    description = "Forces of the rails on the wheels of a wheelset, from a table; moments are about the axle's middle"
    root = Element(
        "fmiModelDescription",
        {"fmiVersion": fmi, "modelName": NAME, "guid" if second else "instantiationToken": token}
        | {"description": description, "author": "flangeway", "variableNamingConvention": "flat"},
    )
    SubElement(root, "CoSimulation", modelIdentifier=NAME, canHandleVariableCommunicationStepSize="true")
    units = SubElement(root, "UnitDefinitions")
    for name, powers in UNITS.items():
        SubElement(SubElement(units, "Unit", name=name), "BaseUnit", {key: str(each) for key, each in powers.items()})
    listed, start = SubElement(root, "ModelVariables"), start_values(table)
    for reference, variable in enumerate(variables()):
        common = {"name": variable.name, "valueReference": str(reference), "causality": variable.causality}
        common["description"] = variable.description
        kinds = {"parameter": "fixed"} if variable.boolean else {"independent": "continuous"}
        variability = kinds.get(variable.causality, "discrete" if variable.boolean else "continuous")
        own = {} if variable.boolean or not variable.unit else {"unit": variable.unit}
        if variable.name in start:
            own["start"] = repr(start[variable.name])
        elif variable.causality == "parameter":
            own["start"] = "false"
        if second:
            scalar = SubElement(listed, "ScalarVariable", common | {"variability": variability})
            SubElement(scalar, "Boolean" if variable.boolean else "Real", own)
        else:
            kind = "Boolean" if variable.boolean else "Float64"
            SubElement(listed, kind, common | {"variability": variability} | own)
    structure = SubElement(root, "ModelStructure")
    outputs = SubElement(structure, "Outputs") if second else structure
    unknowns = SubElement(structure, "InitialUnknowns") if second else structure
    for place, tag in (
        (outputs, "Unknown" if second else "Output"),
        (unknowns, "Unknown" if second else "InitialUnknown"),
    ):
        for reference, variable in enumerate(variables()):
            if variable.causality == "output":
                SubElement(place, tag, {"index": str(reference + 1)} if second else {"valueReference": str(reference)})
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


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
