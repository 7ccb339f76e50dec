"""Files of a table of creep forces: arrays, CSV, README, and the FMU."""

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.system.output_folder import Writer, text_writer, write_together
from flangeway.tables import creep_table
from flangeway.tables.creep_table import OF_PATCH, SIDES, CreepTable
from flangeway.tables.fmu import NAME, Fmi, write_fmu

TABLE, PATCHES, FORCES, README = "creep-table.npz", "patches.csv", "forces.csv", "README.md"
FMUS: dict[str, Fmi] = {f"{NAME}.fmu": "3.0", f"{NAME}-FMI2.fmu": "2.0"}
PLANE = ("longitudinal", "lateral")
COMPONENTS: dict[str, Sequence[str]] = {
    "position_mm": "xyz",
    "rail_point_mm": "xy",
    "wheel_point_mm": "xy",
    "semi_axes_mm": "ab",
    "free_creepage": PLANE,
    "stiffness_N": PLANE,
}


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
        PATCHES: lambda path: _write_patches(table, path),
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


def _write_patches(table: CreepTable, path: Path) -> None:
    names = []
    for name in OF_PATCH:
        base, _, unit = name.rpartition("_")
        names += [f"{base}_{part}_{unit}" for part in COMPONENTS.get(name, "")] or [name]
    lines = [",".join(("patch", *creep_table.AXES, "side", *names))]
    for number, place in enumerate(_patches(table), 1):
        at = [axis[index] for axis, index in zip(table.axes, place, strict=False)]
        numbers = np.concatenate([np.ravel(table.values[name][place]) for name in OF_PATCH])
        cells = (f"{each:.9g}" for each in (*at, *numbers.tolist()))
        first = [next(cells) for _ in at]
        lines.append(",".join((str(number), *first, SIDES[place[3]], *cells)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


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


def _error(found: dict[str, Any]) -> str:
    if not found["n"]:
        return "no points"
    return f"at most {found['max']:.2%}, root mean square {found['rms']:.2%} at {found['n']} points"


def _readme(table: CreepTable) -> str:
    checks, shape = table.metadata["checks"], table.values["forces"].shape
    ranges = "\n".join(
        f"| `{name}` | {len(axis)} | {axis[0]:g} to {axis[-1]:g} |"
        for name, axis in zip(creep_table.AXES, table.axes, strict=True)
    )
    jumps = "\n".join(
        f"- {each['side']}: at {each['lateral_mm']:.3f} mm, within {each['width_mm']:.3f} mm"
        for each in checks["jumps"]
    )
    return f"""# Creep forces of a wheelset

Made by flangeway {table.metadata["versions"]["flangeway"]}. `{TABLE}` has all arrays and, as the JSON text `metadata`,
the inputs of the case and the checks. `{PATCHES}` and `{FORCES}` have the same numbers; the column `patch` joins both.

| axis | points | range |
|---|---|---|
{ranges}

## Errors

**The claimed error is {checks["claimed_error"]:.2%} of the limit of friction**: of the creep force of a wheel, beside
exact solutions at independent random positions and creepages, the same for all patches of the wheel. Of 500 further
random points 0.05 are expected above it, by an exponential law of the largest tenth of the errors found:

- at random points: {_error(checks["between_positions"])};
- where the table has other patches than the wheel: {_error(checks["where_patches_jump"])}; the claim leaves them out;
- at random creepages of each patch of the table: {_error(checks["between_creepages"])}.

The tolerance was {checks["tolerance"]:.2%}. Of {checks["exact_solutions"]} exact solutions {checks["not_converged"]}
did not converge. Between patches that jump, or where one becomes two (`joined` is false), the patches of all positions
around are there, each with a part of its load and its forces: the product of 1 - w or w for the position before or
after, with w = 3 t^2 - 2 t^3 over the lateral interval, t over those of yaw and load. Such lateral
intervals:

{jumps or "- none"}

## Layout

Arrays have the dimensions (lateral, yaw, load, side, patch, ...); side 0 is left, 1 right; patches go from the field
side to the gauge side, absent ones are 0 (`normal_force_N` = 0). Here there are {shape[:5]}.

| array | meaning |
|---|---|
| `normal_force_N` | N |
| `contact_angle_rad` | of the patch, positive towards the flange |
| `wheel_roll_rad` | of the wheel on the bent axle, positive where its field side is higher |
| `rolling_radius_mm` | distance from the axle |
| `position_mm` | centre of pressure from the axle's middle: right, up, ahead |
| `rail_point_mm`, `wheel_point_mm` | the same in the frames of the right rail's and wheel's profiles |
| `semi_axes_mm`, `max_pressure_MPa` | longer and shorter semi-axis, maximum pressure |
| `free_creepage` | xi0, eta0: longitudinal and lateral creepage of the free patch, see below |
| `stiffness_N` | k1, k2: loss of longitudinal and lateral force by longitudinal and lateral creepage, from 0 |
| `radius_mm` | r: radius of gyration of the normal forces |
| `forces` | (..., slip, spin angle, creep angle, 3): see below |
| `axle_vertical_mm_roll_rad` | (lateral, yaw, load, 2): position of the axle |
| `joined` | (intervals of lateral, yaw and load, side): whether to interpolate in it |

## Forces

With friction mu, normal force N, longitudinal and lateral creepage xi, eta and spin phi (1/mm):

    u1 = k1 (xi - xi0),  u2 = k2 (eta - eta0),  u3 = k2 r phi
    R = sqrt(u1^2 + u2^2 + u3^2),  slip V = R / (R + {creep_table.SATURATED:g} mu N)
    spin angle = atan2(u3, sqrt(u1^2 + u2^2)),  creep angle = atan2(u2, u1)
    longitudinal force = mu N V forces[0],  lateral force = mu N V forces[1],  spin moment = mu N r V forces[2]

Between its points `forces` is M(V) d + R(V, spin angle, creep angle), with the direction d = (u1, u2, u3) / R. M has
the force of pure spin (spin angle 90 degrees) in its third column; the first two are its changes by the other
creepages, from the first and second Fourier coefficient around the nearest ring: sum over the creep angles a of
forces cos a and of forces sin a, times 2 / (n cos(spin angle)). M(V), and what is left to the points as R (mirrored
at the spin angles of +-90 degrees), are cubics with the slopes of parabolas through three points (Catmull and Rom),
along each of the three axes; so are all arrays along lateral position, yaw and load where `joined`. Forces are
continuous, and so are their derivatives, at creepages of 0 and in pure spin too, but at the ends of intervals in
which patches jump. Near the limit of friction the size s of both forces over it is rounded: s - (s - 1 + w)^2 / (4 w)
within w = {creep_table.ROUNDED:g} of 1, and 1 beyond. Linear interpolation is less exact, and its derivative jumps.
The creep angle goes from 0 to 180 degrees: for a negative one, take minus spin angle, creep angle plus 180 degrees,
and the opposite forces. V = 0 is linear theory, V = 1 sliding everywhere; so there is no largest creepage. mu is
free, since forces over mu N depend on creepages over mu.

Without spin a patch has no creep force at xi0, eta0: the top of a rail that bends under a wheel is shorter, surfaces
of both bodies are stretched by the pressures. xi0 = 0.0004 is as if the wheel's radius were smaller by that share.

## Axes

Creepages are slip of the wheel on the rail over the speed, forces act on the wheel, both at the centre of pressure. n
is the normal out of the rail, t the tangent across the rail towards the gauge side, z ahead. Longitudinal is along z,
lateral along t; spin and moment about n turn t towards z: at the distance s along t spin adds phi s to the longitudinal
creepage, at the distance z ahead it takes phi z from the lateral one. CONTACT, with x ahead, y to the right and z down:
xi = longitudinal on both sides; on the right eta = -lateral, phi = spin, Fy = -lateral, Mz = moment; on the left
eta = lateral, phi = -spin, Fy = lateral, Mz = -moment.
"""
