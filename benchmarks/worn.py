"""A worn, conforming pair of profiles beside the bundled one: an equilibrium, and the rigid geometry.

The rail is worn at its gauge corner and crown, and its shape is worn into the wheel's tread at several lateral motions.
Both are noisy as measured profiles are, and read from the instrument's files. Accuracy is the residual of the
equilibrium over the load. The peer is the same program on the bundled pair, in the same run: the ratio of the two times
is at most 3 for the equilibrium.
"""

import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.measurement import ITSELF, Measurement, timed
from flangeway.cases import load_case
from flangeway.cases.rigid_run import GeometryRun, find_geometry_case, run_geometry
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.formats.instrument_files import write_miniprof
from flangeway.railway.track.placements import Track, WheelPair, WheelsetPosition

Floats = NDArray[np.float64]

LATERALS_MM = (-4.0, -2.0, 0.0, 2.0, 4.0, 6.0, 8.0)
WEAR_MM = 2.0
NOISE_MM = 0.03
SPACING_MM = 0.25


def worn_pair(folder: Path) -> dict[str, str]:
    """Write MiniProf files of a worn wheel and a worn rail; return the inputs that name them."""
    profile, tread = rail(), wheel()
    # where they were placed when the files were first made
    wheels = WheelPair(wheel=tread, back_to_back_mm=1515.0, radius_mm=500.0, radius_at="flange-tip")
    top = np.array([0.0, profile.outline.bounds()[1, 1]])
    head = profile.running_surface.sampled(spacing=SPACING_MM) - top
    depth = 0.8 * np.exp(-(((head[:, 0] + 30.0) / 6.0) ** 2)) + 0.2 * np.exp(-((head[:, 0] / 20.0) ** 2))
    head = head + _across(head) * (depth * (head[:, 1] > -20.0))[:, None]
    hollow = _hollow(
        tread.running_surface.sampled(spacing=SPACING_MM),
        head + top,
        wheels,
        Track(rail=profile, gauge_mm=1600.0, gauge_at="narrowest"),
    )
    texts = {
        "rail": write_miniprof(_noisy(head, 12), "rail", "worn"),
        "wheel": write_miniprof(_noisy(hollow, 22), "wheel", "worn", tread.flange_back_mm),
    }
    files = {"rail": folder / "worn.ban", "wheel": folder / "worn.whl"}
    for kind, text in texts.items():
        files[kind].write_text(text, encoding="utf-8")
    return {kind: str(file) for kind, file in files.items()}


def _hollow(points: Floats, head: Floats, wheels: WheelPair, track: Track) -> Floats:
    """A running surface into which the rail has worn its shape."""
    on_track = track.placement("right").points(head)
    height = points[:, 1].copy()
    reached = (points[:, 0] > -40.0) & (points[:, 0] < 55.0)
    for lateral in LATERALS_MM:
        at = WheelsetPosition(lateral, 0.0, 0.0).placement(wheels, "right").inverse().points(on_track)
        at = at[np.argsort(at[:, 0])]
        below = np.interp(points[:, 0], at[:, 0], at[:, 1])
        height = np.where(reached, np.maximum(height, below + (points[:, 1] - below)[reached].min() + WEAR_MM), height)
    window = np.hanning(23) / np.hanning(23).sum()
    depth = np.convolve(np.pad(height - points[:, 1], 11, mode="edge"), window, "valid")
    return points + np.column_stack((np.zeros(len(points)), depth))


def _across(points: Floats) -> Floats:
    """Unit normals to the left of a row of points."""
    along = np.gradient(points, axis=0)
    return np.column_stack((-along[:, 1], along[:, 0])) / np.hypot(*along.T)[:, None]


def _noisy(points: Floats, seed: int) -> Floats:
    return points + _across(points) * NOISE_MM * np.random.default_rng(seed).normal(size=(len(points), 1))


def measurements() -> Iterator[Measurement]:
    """Equilibrium, and rigid geometry with its conicity, jumps and equilibrium."""
    yield from _measured(1.0)


def quick() -> Iterator[Measurement]:
    """As `measurements`, with a coarse mesh."""
    yield from _measured(4.0)


def _equilibrium(values: dict[str, Any]) -> Any:
    return load_case("wheelset-tangent", **values).run()


def _geometry(values: dict[str, Any]) -> GeometryRun:
    return run_geometry("worn", find_geometry_case("wheelset-tangent", values))


def _measured(size_scale: float) -> Iterator[Measurement]:
    with tempfile.TemporaryDirectory() as folder:
        pair = worn_pair(Path(folder))
        seconds, errors = [], []
        for values in ({}, pair):
            time, run = timed(partial(_equilibrium, {**values, "size_scale": size_scale}))
            seconds.append(time)
            errors.append(run.result.equilibrium.residuals.equilibrium_residual)
        yield Measurement(
            f"equilibrium of a worn pair, size_scale {size_scale:g}; peer: the bundled pair",
            ITSELF, seconds[1], seconds[0], errors[1], errors[0], asked=1.0 / 3.0,
        )  # fmt: skip
        seconds = []
        for values in ({}, pair):
            time, geometry = timed(partial(_geometry, values))
            seconds.append(time)
        position = geometry.equilibrium.position
        yield Measurement(
            "rigid geometry of a worn pair; peer: the bundled pair",
            ITSELF, seconds[1], seconds[0], 1.0 if position is None else position.residual, None,
        )  # fmt: skip
