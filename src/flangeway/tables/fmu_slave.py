"""The FMU: creep forces of a wheelset from a table, in axes x ahead, y to the right, z down, and SI units.

It is copied into the FMU beside `creep_table.py` and the table, and needs NumPy only.
"""

import atexit
import ctypes
import sys
from pathlib import Path
from typing import Any

import numpy as np
from pythonfmu3 import Boolean, Float64, Fmi3Causality, Fmi3Slave, Fmi3Variability
from pythonfmu3.unit import Unit

try:
    from creep_table import CreepTable  # type: ignore[import-not-found]
except ImportError:
    from flangeway.tables.creep_table import CreepTable

INPUTS = {
    "lateral": (0.0, "m", "lateral position of the axle in the track, to the right"),
    "yaw": (0.0, "rad", "yaw about z: positive where the left wheel is ahead"),
    "load": (np.nan, "N", "axle load; at the start the middle of the table"),
    "speed": (20.0, "m/s", "speed of the axle along the track, above 0"),
    "rotation": (np.nan, "rad/s", "rotation of the axle, positive where it rolls ahead; at the start free rolling"),
    "lateral_velocity": (0.0, "m/s", "velocity of the axle to the right, relative to the track"),
    "yaw_rate": (0.0, "rad/s", "rate of yaw about z, relative to the track"),
    "friction": (0.3, None, "coefficient of friction"),
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
SIDES = ("left", "right")


def _release_before_exit(fmu: Path) -> None:
    """Make the FMU's library release its state when Python ends, before the process does.

    The library of pythonfmu3 0.3.4 sets this state to null in a destructor that Linux runs after the state itself was
    destroyed. It then writes to freed memory, and a program may end with "corrupted double-linked list".
    """
    library = fmu / "binaries" / "x86_64-linux" / "WheelsetCreepForces.so"
    if sys.platform == "linux" and library.is_file():
        atexit.register(ctypes.CDLL(str(library)).finalizePythonInterpreter)


class WheelsetCreepForces(Fmi3Slave):  # type: ignore[misc]
    """Contact and creep forces of both wheels."""

    author = "flangeway"
    description = "Forces of the rails on the wheels of a wheelset, from a table; moments are about the axle's middle"

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = Path(str(kwargs.get("resources") or Path(__file__).parent).removeprefix("file://"))
        _release_before_exit(resources.parent)
        self.table = CreepTable.load(resources / "creep-table.npz")
        lateral, yaw, load = self.table.axes
        self.time = 0.0
        self.register_units([Unit(name, **powers) for name, powers in UNITS.items()])
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous, unit="s")
        )
        for name, (value, unit, description) in INPUTS.items():
            setattr(self, name, value)
            self.register_variable(Float64(name, causality=Fmi3Causality.input, unit=unit, description=description))
        self.lateral = 1e-3 * float(np.clip(0.0, lateral[0], lateral[-1]))
        self.yaw = -1e-3 * float(np.clip(0.0, yaw[0], yaw[-1]))
        self.load = 1e3 * float(load[len(load) // 2])
        self.rotation = self.speed / (1e-3 * self._radius())
        for side in SIDES:
            for name, (unit, description) in OUTPUTS.items():
                setattr(self, f"{side}_{name}", 0.0)
                self.register_variable(
                    Float64(
                        f"{side}_{name}", causality=Fmi3Causality.output, unit=unit,
                        description=f"{side} wheel: {description}",
                    )
                )  # fmt: skip
        self.outside = False
        self.register_variable(
            Boolean(
                "outside", causality=Fmi3Causality.output, variability=Fmi3Variability.discrete,
                description="whether an input is out of the table's range, where the nearest position counts",
            )
        )  # fmt: skip
        self.update()

    @property
    def _position(self) -> tuple[float, float, float]:
        return 1e3 * self.lateral, -1e3 * self.yaw, 1e-3 * self.load

    def _radius(self) -> float:
        """Mean rolling radius at the present position, mm."""
        found = self.table.contacts(*self._position, clamp=True)
        return float(np.average(found["rolling_radius_mm"], weights=found["normal_force_N"]))

    def update(self) -> None:
        """Compute the outputs."""
        position = self._position
        contacts = self.table.contacts(*position, clamp=True)
        creepages = self.table.creepages(
            contacts, position[1], speed=1e3 * self.speed, rotation=self.rotation,
            lateral_velocity=1e3 * self.lateral_velocity, yaw_rate=-self.yaw_rate,
        )  # fmt: skip
        forces = self.table.forces(*position, creepages, friction=self.friction, clamp=True)
        push, moment = self.table.wrench(contacts, forces)
        for number, side in enumerate(SIDES):
            right, up, ahead = push[0, number].tolist()
            turning, yawing, rolling = (1e-3 * moment[0, number]).tolist()
            across = forces[0, number, :, 1].sum() * (-1.0 if number else 1.0)
            values = (ahead, right, -up, -rolling, -turning, -yawing,
                      contacts["normal_force_N"][0, number].sum(), forces[0, number, :, 0].sum(), across)  # fmt: skip
            for name, value in zip(OUTPUTS, values, strict=True):
                setattr(self, f"{side}_{name}", float(value))
        self.outside = any(
            not axis[0] - 1e-6 <= value <= axis[-1] + 1e-6
            for axis, value in zip(self.table.axes, position, strict=True)
        )

    def exit_initialization_mode(self) -> None:
        """Compute the outputs at the start."""
        self.update()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Compute the outputs at the inputs of now: there is no state."""
        self.time = current_time + step_size
        self.update()
        return True
