"""Tables of a summary: one list of columns for the terminal and for the page."""

from collections.abc import Callable, Sequence
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
    of_words
        Whether the cells are words more than numbers, which are then not put below each other by their last digits.

    """

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    of_words: bool = False


def contacts_table(summary: Row) -> Table:
    """Forces, places and pressures of the contacts, one row a quantity and one column a contact."""
    contacts = summary["contacts"]
    quantities: list[tuple[str, Callable[[Row], str]]] = [
        ("force on the wheel, kN", lambda c: number(c["force_kN"], 3)),
        ("  lateral (to the right), kN", lambda c: number(c["lateral_force_kN"], 3)),
        ("  vertical (up), kN", lambda c: number(c["vertical_force_kN"], 3)),
        ("contact angle, degrees", lambda c: number(c["contact_angle_deg"], 2)),
        ("place on the rail (x, y), mm", lambda c: _place(c["rail_position_mm"])),
        ("place on the wheel (x, y), mm", lambda c: _place(c["wheel_position_mm"])),
        ("maximum pressure, MPa", lambda c: marked(number(c["max_pressure_MPa"], 1), c["max_pressure_remark"])),
        ("  Hertz, MPa", lambda c: _hertz(c["hertz_pressure_MPa"], 1)),
        ("  scatter of the nodes, %", lambda c: number(100.0 * c["pressure_oscillation"], 2)),
        ("half width, mm", lambda c: number(c["half_width_mm"], 3)),
        ("  Hertz, mm", lambda c: _hertz(c["hertz_half_width_mm"], 3)),
        ("in-plane shear in the rail, MPa (at mm)", lambda c: _at_depth(c["in_rail"], "max_in_plane_shear")),
        ("  in the wheel", lambda c: _at_depth(c["in_wheel"], "max_in_plane_shear")),
        ("  Hertz", lambda c: _at_depth(c, "hertz_in_plane_shear")),
        ("von Mises in the rail, MPa (at mm)", lambda c: _at_depth(c["in_rail"], "max_von_mises")),
        ("  in the wheel", lambda c: _at_depth(c["in_wheel"], "max_von_mises")),
        ("nodes in contact", lambda c: f"{c['n_nodes']}"),
    ]
    rows = [(name, *(text(contact) for contact in contacts)) for name, text in quantities]
    return Table("Contacts", ("", *(contact_name(c, contacts) for c in contacts)), tuple(rows))


def contact_name(contact: Row, contacts: Sequence[Row]) -> str:
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
    rows.append(("resulting error of the balance", _small(balance["equilibrium_residual"])))
    free = {"vertical": "vertical_mm", "lateral": "lateral_mm", "moment": "roll_rad"}
    rows += [
        (f"  {name}", _small(balance[f"{name}_residual"]))
        for name, motion_key in free.items()
        if summary["case"][motion_key] is None
    ]
    rows += _holding(summary)
    return Table("Position and balance", ("", "value"), tuple(rows))


def _holding(summary: Row) -> list[tuple[str, str]]:
    """What holds the wheelset where its motion is prescribed."""
    holding = summary["support"]["holding"]
    rows = (
        ("lateral_mm", "held at the axle: lateral force, N", "lateral_N"),
        ("vertical_mm", "held at the axle: vertical force, N", "vertical_N"),
        ("roll_rad", "held at the axle: moment, N mm", "moment_N_mm"),
    )
    return [(name, number(holding[key], 1)) for motion, name, key in rows if summary["case"][motion] is not None]


def rigid_table(summary: Row) -> Table:
    """The elastic wheelset beside the rigid one: position, points of contact, forces, Hertz's estimates."""
    columns = [(summary["motion"], summary["contacts"]), (summary["rigid"], summary["rigid"]["contacts"])]
    rows = [
        (name, *(_motion(motion[key]) for motion, _ in columns))
        for name, key in (
            ("lateral motion, mm", "lateral_mm"),
            ("vertical motion, mm", "vertical_mm"),
            ("roll, rad", "roll_rad"),
        )
    ]
    quantities = (
        ("force, kN", "force_kN", 2),
        ("contact angle, degrees", "contact_angle_deg", 2),
        ("x on the rail, mm", "rail_position_mm", 2),
        ("x on the wheel, mm", "wheel_position_mm", 2),
        ("Hertz: half width, mm", "hertz_half_width_mm", 3),
        ("Hertz: pressure, MPa", "hertz_pressure_MPa", 0),
    )
    for side in ("left", "right"):
        rows += [
            (f"{side}: {name}", *(_of_side(contacts, side, key, digits) for _, contacts in columns))
            for name, key, digits in quantities
        ]
    return Table("Elastic beside rigid, in the track's axes", ("", "elastic", "rigid"), tuple(rows))


def _of_side(contacts: list[Row], side: str, key: str, digits: int) -> str:
    """Values of a side's contacts from left to right; of a place its x."""
    mine = sorted((c for c in contacts if c["side"] == side), key=lambda c: float(c["space_position_mm"][0]))
    values = [c[key][0] if key.endswith("position_mm") else c[key] for c in mine]
    return " / ".join(number(value, digits) for value in values) or "–"


def bending_table(summary: Row, *, short: bool = False) -> Table:
    """Motion of the rails' heads and stresses in web and fillets, one column a rail; the fillets not if `short`."""
    rails = summary["bending"]
    quantities: list[tuple[str, Callable[[Row], str]]] = [
        ("top of the head to the right, mm", lambda r: number(r["head_lateral_mm"], 3)),
        ("  up, mm", lambda r: number(r["head_vertical_mm"], 3)),
        ("  roll outwards, mrad", lambda r: number(1e3 * r["head_roll_outward_rad"], 2)),
        ("gauge face outwards, mm", lambda r: number(r["gauge_outward_mm"], 3)),
        ("web, gauge face, MPa", lambda r: number(r["web_gauge_face_MPa"], 0)),
        ("  field face, MPa", lambda r: number(r["web_field_face_MPa"], 0)),
    ]
    if not short:
        quantities += [
            ("web: force along it, kN", lambda r: number(r["web_normal_force_kN"], 2)),
            ("  across it, kN", lambda r: number(r["web_shear_force_kN"], 2)),
            ("  moment, kN mm", lambda r: number(r["web_moment_kN_mm"], 1)),
        ]
    for towards in ("head", "foot"):
        for word, sign in (("tension", 1.0), ("compression", -1.0)):
            quantities.append((f"largest {word} towards the {towards}, MPa", _extreme(towards, word, sign, short)))
    rows = [(name, *(text(rail) for rail in rails)) for name, text in quantities]
    caption = "Bending of the rails, stresses along the surface of web and fillets (of the slice alone: see limits)"
    return Table(caption, ("", *(rail["side"] for rail in rails)), tuple(rows))


def _extreme(towards: str, word: str, sign: float, short: bool) -> Callable[[Row], str]:
    def text(rail: Row) -> str:
        mine = [f for f in rail["fillets"] if f["towards"] == towards and f[f"max_{word}_MPa"] is not None]
        if not mine:
            return "–"
        worst = max(mine, key=lambda f: sign * float(f[f"max_{word}_MPa"]))
        value = number(worst[f"max_{word}_MPa"], 0)
        return value if short else f"{value} ({worst['face']}, {_place(worst[f'{word}_position_mm'], 1)})"

    return text


def support_table(summary: Row) -> Table:
    """Reactions of bases and axle, and their balance with the contact forces."""
    rows = [
        (
            row["part"],
            number(row["lateral_force_kN"], 3),
            number(row["vertical_force_kN"], 3),
            number(row["moment_kN_mm"], 1),
            number(row.get("eccentricity_mm"), 2),
            _small(row["force_error"]),
            _small(row["moment_residual"]),
        )
        for row in summary["support"]["reactions"]
    ]
    header = ("", "lateral, kN", "vertical, kN", "moment, kN mm", "eccentricity, mm", "force error", "moment error")
    return Table("Reactions of bases and axle on the parts", header, tuple(rows))


def stresses_table(summary: Row) -> Table:
    """Extreme stresses of the parts."""
    keys = ("max_von_mises_below_contacts_MPa", "max_von_mises_MPa", "min_principal_MPa", "max_in_plane_shear_MPa")
    header = (
        *("", "von Mises below contacts, MPa", "anywhere in the slice, MPa"),
        *("least principal, MPa", "maximum in-plane shear, MPa"),
    )
    rows = [(r["part"], *(number(r[key], 1) for key in keys)) for r in summary["stresses"]]
    caption = "Extreme stresses, means of cells (anywhere: also in web, fillets and foot of the slice, see limits)"
    return Table(caption, header, tuple(rows))


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


def marked(text: str, remark: str | None) -> str:
    """Return the text of a value, with why it is not to be relied on, if there is a reason."""
    return text if remark is None else f"about {text} ({remark})"


def number(value: float | None, digits: int) -> str:
    """Return a number with some decimals, or a dash for one that there is not."""
    return "–" if value is None else f"{value:.{digits}f}"


def _hertz(value: float | None, digits: int) -> str:
    return "conforming" if value is None else number(value, digits)


def _small(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}"


def _motion(value: float | None) -> str:
    """Return a motion with four decimals, or its size where these are all zero."""
    return _small(value) if value is None or abs(value) < 5e-4 else f"{value:.4f}"


def _place(point: list[float], digits: int = 3) -> str:
    return f"({point[0]:.{digits}f}, {point[1]:.{digits}f})"


def _at_depth(row: Row, name: str) -> str:
    """A stress with the depth at which it is."""
    value, depth = row[f"{name}_MPa"], row[f"{name}_depth_mm"]
    return "–" if value is None else f"{value:.0f} ({depth:.2f})"
