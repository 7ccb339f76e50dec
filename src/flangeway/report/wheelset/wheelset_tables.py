"""Tables of a wheelset's summary: one list of columns for the terminal and for the page."""

from collections.abc import Sequence

from flangeway.cases.wheelset.wheelset_summary import (
    ContactSummary,
    RigidContactSummary,
    WheelsetSummary,
)
from flangeway.railway.track.placements import SIDES
from flangeway.railway.wheelset.wheelset_checks import STEEL_MPa, YIELD_MPa
from flangeway.report.page.tables import Column, SummaryTable, marked, number, table_across, table_of, with_whole

Contacts = Sequence[ContactSummary] | Sequence[RigidContactSummary]


CONTACT: tuple[Column, ...] = (
    ("force on the wheel, kN", "force_kN", ".3f"),
    ("contact angle, degrees", "contact_angle_deg", ".2f"),
    ("x on the rail, mm", lambda c: c.rail_position_mm[0], "z.3f"),
    ("x on the wheel, mm", lambda c: c.wheel_position_mm[0], "z.3f"),
    ("maximum pressure, MPa", lambda c: marked(number(c.max_pressure_MPa, 1), c.max_pressure_remark), ""),
    ("  Hertz, MPa", lambda c: _hertz(c.hertz_pressure_MPa, 1), ""),
    ("half width, mm", "half_width_mm", ".3f"),
    ("  Hertz, mm", lambda c: _hertz(c.hertz_half_width_mm, 3), ""),
)
BELOW: tuple[Column, ...] = (
    ("y on the rail, mm", lambda c: c.rail_position_mm[1], "z.3f"),
    ("y on the wheel, mm", lambda c: c.wheel_position_mm[1], "z.3f"),
    ("pressure oscillation, %", lambda c: number(100.0 * c.pressure_oscillation, 2), ""),
    ("lateral force (to the right), kN", "lateral_force_kN", ".3f"),
    ("vertical force (up), kN", "vertical_force_kN", ".3f"),
    ("shear in the rail{, MPa|: depth, mm}", lambda c: _at_depth(c.in_rail, "max_in_plane_shear"), ".0f|.2f"),
    ("  in the wheel{, MPa|: depth, mm}", lambda c: _at_depth(c.in_wheel, "max_in_plane_shear"), ".0f|.2f"),
    ("  Hertz{, MPa|: depth, mm}", lambda c: _at_depth(c, "hertz_in_plane_shear"), ".0f|.2f"),
    ("von Mises in the rail{, MPa|: depth, mm}", lambda c: _at_depth(c.in_rail, "max_von_mises"), ".0f|.2f"),
    ("  in the wheel{, MPa|: depth, mm}", lambda c: _at_depth(c.in_wheel, "max_von_mises"), ".0f|.2f"),
    ("nodes in contact", "n_nodes", "d"),
)
"""CONTACT, BELOW: the numbers of a contact, those of the table of results and further ones."""
ROUND_OFF = 1e-9
"""Coordinates below it, in mm or rad, are zero."""
SLICE = "Of the slice alone, which carries the whole load: compare runs with each other, not with a rail in track."


def contacts_table(summary: WheelsetSummary) -> SummaryTable:
    """Forces below the surface and further numbers of the contacts, one column a contact."""
    contacts = summary.contacts
    return table_across("Contacts", (contact_name(c, contacts) for c in contacts), contacts, BELOW)


def results_table(summary: WheelsetSummary) -> SummaryTable:
    """Position, L/V of the wheels and contacts, one column a contact; what is of a side is in its first column."""
    contacts, position = summary.contacts, summary.position
    ratios = {each.side: number(each.lateral_over_vertical, 4) for each in summary.sides}
    whole = {
        "lateral position of the axle, mm": _coordinate(position.lateral_mm),
        "approach after first touch, mm": number(position.approach_mm, 4),
    }
    table = table_across("Results", (contact_name(c, contacts) for c in contacts), contacts, CONTACT)
    return with_whole(table, whole, [c.side for c in contacts], {"L/V": ratios})


def contact_name(contact: ContactSummary, contacts: Sequence[ContactSummary]) -> str:
    """Side of a contact, with its region where the side has several."""
    alone = sum(other.side == contact.side for other in contacts) == 1
    return contact.side if alone else f"{contact.side}, {contact.region}"


def position_table(summary: WheelsetSummary) -> SummaryTable:
    """Position of the wheelset and residuals of its equilibrium."""
    position, residual, published = summary.position, summary.residual, summary.published
    rows = [
        ("approach after first touch, mm", number(position.approach_mm, 4)),
        ("vertical position, mm", number(position.vertical_mm, 4)),
        ("lateral position, mm", _coordinate(position.lateral_mm)),
        ("roll, rad", _coordinate(position.roll_rad)),
    ]
    if published is not None:
        rows += [
            ("  vertical in space, mm", number(position.vertical_in_space_mm, 4)),
            ("  horizontal in space, mm", number(position.horizontal_in_space_mm, 4)),
            ("  published vertical, mm", number(published.vertical_mm, 3)),
            ("  published horizontal, mm", number(published.horizontal_mm, 3)),
            ("  published roll, rad", _small(published.roll_rad)),
        ]
    rows.append(("equilibrium residual", _small(residual.equilibrium)))
    parts = (
        ("  vertical", residual.vertical, "vertical_mm"),
        ("  lateral", residual.lateral, "lateral_mm"),
        ("  moment", residual.moment, "roll_rad"),
    )
    rows += [(name, _small(value)) for name, value, key in parts if summary.case[key] is None]
    return SummaryTable("Position and equilibrium", ("", "value"), tuple(rows))


def rigid_table(summary: WheelsetSummary) -> SummaryTable:
    """The elastic wheelset beside the rigid one: position, points of contact, forces, Hertz's estimates."""
    elastic, rigid = summary.position, summary.rigid
    rows: list[tuple[str, ...]] = [
        ("lateral position, mm", _coordinate(elastic.lateral_mm), _coordinate(rigid.lateral_mm)),
        ("vertical position, mm", _coordinate(elastic.vertical_mm), _coordinate(rigid.vertical_mm)),
        ("roll, rad", _coordinate(elastic.roll_rad), _coordinate(rigid.roll_rad)),
    ]
    quantities = (
        ("force, kN", "force_kN", 2),
        ("contact angle, degrees", "contact_angle_deg", 2),
        ("x on the rail, mm", "rail_position_mm", 2),
        ("x on the wheel, mm", "wheel_position_mm", 2),
        ("Hertz: half width, mm", "hertz_half_width_mm", 3),
        ("Hertz: pressure, MPa", "hertz_pressure_MPa", 0),
    )
    both: tuple[Contacts, Contacts] = (summary.contacts, rigid.contacts)
    for side in SIDES:
        mine = [sorted((c for c in each if c.side == side), key=lambda c: c.space_position_mm[0]) for each in both]
        for place in range(max(map(len, mine))):
            pair = [each[place] if place < len(each) else None for each in mine]
            several = f", {place + 1}" if max(map(len, mine)) > 1 else ""
            rows += [
                (f"{side}{several}: {name}", *(_value(contact, key, digits) for contact in pair))
                for name, key, digits in quantities
            ]
    note = "Several contacts of a side are numbered from left to right." if len(summary.contacts) > len(SIDES) else ""
    return SummaryTable("Elastic and rigid, in the track's axes", ("", "elastic", "rigid"), tuple(rows), note=note)


def _value(contact: ContactSummary | RigidContactSummary | None, key: str, digits: int) -> str:
    """Number of a contact, the x of a position; a dash without contact."""
    value = None if contact is None else getattr(contact, key)
    return number(value[0] if isinstance(value, list | tuple) else value, digits)


def stresses_table(summary: WheelsetSummary) -> SummaryTable:
    """Extreme stresses of the parts beside the yield strength."""
    columns: tuple[Column, ...] = (
        ("", "part", ""),
        ("von Mises below contacts, MPa", "max_von_mises_below_contacts_MPa", ".1f"),
        ("  yield strength, MPa", lambda part: _yield_strength(summary, part.part), "g"),
        ("von Mises anywhere, MPa", "max_von_mises_MPa", ".1f"),
        ("minimum principal, MPa", "min_principal_MPa", ".1f"),
        ("maximum in-plane shear, MPa", "max_in_plane_shear_MPa", ".1f"),
    )
    note = f"Elastic stresses; steel yields above its yield strength. Anywhere: also in web and foot. {SLICE}"
    return table_of("Extreme stresses, element averages", summary.stresses, columns, note)


def _yield_strength(summary: WheelsetSummary, part: str) -> float | None:
    """Yield strength that a part is compared with; None where none is given for what is not steel."""
    case, role = summary.case, part.partition("-")[0]
    if case["yield_MPa"] is not None:
        return float(case["yield_MPa"])
    young = case[f"{role}_young_MPa"] or case["young_MPa"]
    return YIELD_MPa if STEEL_MPa[0] <= young <= STEEL_MPa[1] else None


def bodies_table(summary: WheelsetSummary) -> SummaryTable:
    """Sizes of the meshes."""
    sizes: tuple[Column, ...] = (("unknowns", "unknowns", ","), ("elements", "elements", ","), ("nodes", "nodes", ","))
    columns: tuple[Column, ...] = (("", "name", ""), *sizes, ("used for", lambda b: ", ".join(b.parts), ""))
    return table_of("Bodies", summary.bodies, columns)


def _hertz(value: float | None, digits: int) -> str:
    return "conforming" if value is None else number(value, digits)


def _small(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}"


def _coordinate(value: float | None) -> str:
    """Return a coordinate with four decimals, or its size where these are all zero; 0 for round-off."""
    if value is not None and abs(value) < ROUND_OFF:
        return "0"
    return _small(value) if value is None or abs(value) < 5e-4 else f"{value:.4f}"


def _at_depth(row: object, name: str) -> tuple[float, float] | None:
    """A stress and its depth."""
    value, depth = getattr(row, f"{name}_MPa"), getattr(row, f"{name}_depth_mm")
    return None if value is None else (value, depth)
