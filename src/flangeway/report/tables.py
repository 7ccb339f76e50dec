"""Tables of a summary: one list of columns for the terminal and for the page."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Row = dict[str, Any]


@dataclass(frozen=True)
class Table:
    """A table of text.

    Parameters
    ----------
    caption
        What it shows.
    header
        Names of the columns with their units.
    rows
        Cells as text; the first of each row names it.

    """

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def contacts_table(summary: Row) -> Table:
    """Forces, places and pressures of the contacts, one row a quantity and one column a contact."""
    contacts = summary["contacts"]
    quantities: list[tuple[str, Callable[[Row], str]]] = [
        ("force on the wheel, kN", lambda c: number(c["force_kN"], 3)),
        ("  lateral (to the right), kN", lambda c: number(c["lateral_force_kN"], 3)),
        ("  vertical (up), kN", lambda c: number(c["vertical_force_kN"], 3)),
        ("place on the rail (x, y), mm", lambda c: _place(c["rail_position_mm"])),
        ("place on the wheel (x, y), mm", lambda c: _place(c["wheel_position_mm"])),
        ("largest pressure, MPa", lambda c: number(c["max_pressure_MPa"], 1)),
        ("  Hertz, MPa", lambda c: number(c["hertz_pressure_MPa"], 1)),
        ("  scatter of the nodes, %", lambda c: number(100.0 * c["pressure_scatter"], 2)),
        ("half width, mm", lambda c: number(c["half_width_mm"], 3)),
        ("  Hertz, mm", lambda c: number(c["hertz_half_width_mm"], 3)),
        ("nodes in contact", lambda c: f"{c['n_nodes']}"),
    ]
    rows = [(name, *(text(contact) for contact in contacts)) for name, text in quantities]
    return Table("Contacts", ("", *(contact_name(c, contacts) for c in contacts)), tuple(rows))


def contact_name(contact: Row, contacts: list[Row]) -> str:
    """Side of a contact, with its region where the side has several."""
    alone = sum(other["side"] == contact["side"] for other in contacts) == 1
    return str(contact["side"]) if alone else f"{contact['side']}, {contact['region']}"


def motion_table(summary: Row) -> Table:
    """Motion of the wheelset and errors of the balance."""
    motion, balance = summary["motion"], summary["balance"]
    rows = [
        ("approach after first touch, mm", number(motion["approach_mm"], 4)),
        ("vertical motion, mm", number(motion["vertical_mm"], 4)),
        ("lateral motion, mm", _motion(motion["lateral_mm"])),
        ("roll, rad", _small(motion["roll_rad"])),
    ]
    published = summary["published"]
    if published:
        rows += [
            ("  vertical in space, mm", number(motion["vertical_in_space_mm"], 4)),
            ("  horizontal in space, mm", number(motion["horizontal_in_space_mm"], 4)),
            ("  published vertical, mm", number(published["vertical_mm"], 3)),
            ("  published horizontal, mm", number(published["horizontal_mm"], 3)),
            ("  published roll, rad", _small(published["roll_rad"])),
        ]
    if any(side["lateral_over_vertical"] is not None for side in summary["sides"]):
        rows += [(f"L/V of the {s['side']} wheel", number(s["lateral_over_vertical"], 4)) for s in summary["sides"]]
    rows += [
        ("resulting error of the balance", _small(balance["resulting_error"])),
        ("  vertical", _small(balance["vertical_error"])),
        ("  lateral", _small(balance["lateral_error"])),
        ("  moment", _small(balance["moment_error"])),
    ]
    return Table("Position and balance", ("", "value"), tuple(rows))


def stresses_table(summary: Row) -> Table:
    """Extreme stresses of the parts."""
    keys = ("max_von_mises_MPa", "min_principal_MPa", "max_in_plane_shear_MPa")
    header = ("", "largest von Mises, MPa", "least principal, MPa", "largest in-plane shear, MPa")
    rows = [(r["part"], *(number(r[key], 1) for key in keys)) for r in summary["stresses"]]
    return Table("Extreme stresses, means of cells", header, tuple(rows))


def bodies_table(summary: Row) -> Table:
    """Sizes of the meshes."""
    rows = [
        (b["name"], f"{b['unknowns']:,}", f"{b['cells']:,}", f"{b['points']:,}", ", ".join(b["parts"]))
        for b in summary["bodies"]
    ]
    header = ("", "unknowns", "cells", "points", "stands as")
    return Table("Bodies", header, tuple(rows))


def timings_table(summary: Row) -> Table:
    """Seconds of each stage."""
    rows = [(name.replace("_", "-"), number(t, 2)) for name, t in summary["timings_s"].items()]
    return Table("Time", ("", "s"), tuple(rows))


def number(value: float | None, digits: int) -> str:
    """Return a number with some decimals, or a dash for one that there is not."""
    return "–" if value is None else f"{value:.{digits}f}"


def _small(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}"


def _motion(value: float | None) -> str:
    """Return a motion with four decimals, or its size where these are all zero."""
    return _small(value) if value is None or abs(value) < 5e-4 else f"{value:.4f}"


def _place(point: list[float]) -> str:
    return f"({point[0]:.3f}, {point[1]:.3f})"
