"""Files of a table of creep forces: arrays, CSV, README, and the FMU."""

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.results import ResultTable
from flangeway.system.output_folder import Writer, text_writer, write_together
from flangeway.system.templates import templates
from flangeway.tables import creep_table
from flangeway.tables.creep_table import OF_PATCH, SIDES, CreepTable
from flangeway.tables.fmu import NAME, Fmi, write_fmu

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
    return [tuple(each) for each in np.argwhere(table.values["normal_force_N"] > 0.0).tolist()]


def _patches_table(table: CreepTable) -> ResultTable:
    rows = []
    for number, place in enumerate(_patches(table), 1):
        at = {name: axis[index] for name, axis, index in zip(creep_table.AXES, table.axes, place, strict=False)}
        numbers = {COLUMN.get(name, name): table.values[name][place].tolist() for name in OF_PATCH}
        rows.append({"patch": number, **at, "side": SIDES[place[3]], **numbers})
    return ResultTable.of_rows(rows, ENDINGS)


def _write_forces(table: CreepTable, path: Path) -> None:
    slip, spin, creep = table.creep_axes
    points = [f"{a:g},{b:.6g},{c:.6g}" for a in slip for b in np.rad2deg(spin) for c in np.rad2deg(creep)]
    with path.open("w", encoding="utf-8") as file:
        file.write("patch,slip,spin_angle_deg,creep_angle_deg,longitudinal,lateral,moment\n")
        for number, place in enumerate(_patches(table), 1):
            values = table.values["forces"][place].reshape(-1, 3).tolist()
            file.writelines(
                f"{number},{point},{x:.5g},{y:.5g},{m:.5g}\n" for point, (x, y, m) in zip(points, values, strict=True)
            )


def _readme(table: CreepTable) -> str:
    template = templates(__package__, markup=False, percent="{:.2%}".format).get_template("README.md.jinja")
    return template.render(table=table, reader=creep_table)
