"""Files of a wheelset in three dimensions: surfaces for ParaView, patches and stresses below them as tables."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.cases.wheelset.spatial_wheelset_case import SpatialWheelsetRun
from flangeway.cases.wheelset.spatial_wheelset_summary import WheelPatchSummary
from flangeway.formats import write_vtu
from flangeway.mesh import PolyMesh
from flangeway.railway.spatial.side_contact import SideState
from flangeway.railway.spatial.spatial_result import SpatialResult
from flangeway.railway.spatial.wheel_gap import FAR_MM, wheel_gap
from flangeway.railway.track.discretisation import ROLES, Role
from flangeway.railway.track.placements import SIDE_SIGN, Side
from flangeway.report.spatial.patch_map import surface_mesh
from flangeway.report.spatial_wheelset.wheelset_patches import lines_below
from flangeway.types import Bools, Floats

PARTS: tuple[tuple[Side, Role], ...] = tuple((side, role) for role in ROLES for side in ("left", "right"))
WORDS = {
    "rail_position_mm": "xy", "wheel_position_mm": "xy", "track_position_mm": "xyz", "cells": ("across", "along"),
    "semi_axes_mm": ("longer", "shorter"), "hertz_semi_axes_mm": ("longer", "shorter"),
}  # fmt: skip
"""Endings of the columns of a list."""


def write_surface(result: SpatialResult, side: Side, role: Role, path: Path) -> None:
    """Write pressure and gap on the running surface of a rail, or where the wheel is opposite to it.

    The points are in the track's axes, z ahead of the axle: the rail's as it is bent, the wheel's in its place, both
    without the indentation at the contact. The gap is nan where no wheel is opposite.
    """
    state = result.equilibrium.state.sides[side]
    nodes, z, mesh = surface_mesh(state.cells)
    on_rail, on_wheel, met = _corners(state, nodes, z)
    places = on_wheel if role == "wheel" else on_rail
    places[..., 0] *= SIDE_SIGN[side]
    corners = mesh.cell_points.reshape(-1, 4)
    opposite = met.ravel()[corners].all(axis=1)
    chosen = opposite if role == "wheel" else np.ones_like(opposite)
    used, numbers = np.unique(corners[chosen], return_inverse=True)
    offsets = 4 * np.arange(chosen.sum() + 1, dtype=np.int32)
    mesh = PolyMesh(mesh.points[used], offsets, numbers.ravel().astype(np.int32))
    gaps = np.where(opposite, state.gaps.ravel(), np.nan)
    values = {"pressure_MPa": state.cells.pressures.ravel()[chosen], "gap_mm": gaps[chosen]}
    write_vtu(path, mesh, cell_data=values, positions=places.reshape(-1, 3)[used])


def _corners(state: SideState, nodes: Floats, z: Floats) -> tuple[Floats, Floats, Bools]:
    """Points of rail and wheel at the corners of cells, each (k, m, 3), and where the wheel is opposite, (k, m)."""
    surfaces, stations = state.grid.surfaces, state.grid.grid.stations
    points, normals = surfaces.rail_points(nodes)
    moved = state.points - surfaces.rail_points(stations)[0]
    points = points + np.stack([np.interp(nodes, stations, moved[:, axis]) for axis in (0, 1)], axis=1)
    gap = wheel_gap(surfaces.wheel, state.pose.middle, state.pose.axis, points, normals, z)
    rail = np.concatenate(
        (np.repeat(points[:, None], len(z), axis=1), np.tile(z[:, None], (len(nodes), 1, 1))), axis=-1
    )
    wheel = gap.arms + np.append(state.pose.middle, 0.0)
    return rail, wheel, gap.gaps < FAR_MM


def patches_table(patches: Sequence[WheelPatchSummary]) -> str:
    """Return the numbers of all patches as CSV, a row each; empty where there is no number."""
    rows = [dict(_columns(asdict(patch))) for patch in patches]
    return _csv(rows[0] if rows else (), ([row.values() for row in rows]))


def _columns(values: Mapping[str, Any], before: str = "") -> Iterable[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _columns(value, f"{key}_")
        elif key in WORDS:
            stem = key.removesuffix("_mm")
            for number, word in enumerate(WORDS[key]):
                yield f"{stem}_{word}{key[len(stem) :]}", None if value is None else value[number]
        else:
            yield before + key, value


def below_table(run: SpatialWheelsetRun) -> str:
    """Return the stresses on the normals below the centres of pressure as CSV, a row for each depth."""
    rows: list[list[object]] = []
    header: list[str] = []
    for patch, role in lines_below(run.result):
        line = patch.below(role)
        by_name = line.stresses.by_name
        header = ["side", "region", "body", "depth_mm", *by_name]
        table = np.column_stack((line.depths, *by_name.values())).tolist()
        rows += [[patch.side, patch.region, role, *numbers] for numbers in table]
    return _csv(header, rows)


def _csv(header: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([f"{value:.6g}" if isinstance(value, float) else value for value in row] for row in rows)
    return text.getvalue()
