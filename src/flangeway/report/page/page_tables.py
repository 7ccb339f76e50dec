"""Tables of a wheelset's summary: one list of columns for the terminal and for the page."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from flangeway.cases.wheelset.wheelset_summary import (
    BendingSummary,
    ContactSummary,
    RigidContactSummary,
    WheelsetSummary,
)

Contacts = Sequence[ContactSummary] | Sequence[RigidContactSummary]


@dataclass(frozen=True)
class SummaryTable:
    """A table of text."""

    caption: str  # what it shows
    header: tuple[str, ...]  # names of the columns with their units
    rows: tuple[tuple[str, ...], ...]  # cells as text; the first of each row names it
    of_words: bool = False  # whether the cells are words rather than numbers, and are aligned on the left


def contacts_table(summary: WheelsetSummary) -> SummaryTable:
    """Forces, positions and pressures of the contacts, one row a quantity and one column a contact."""
    contacts = summary.contacts
    quantities: list[tuple[str, Callable[[ContactSummary], str]]] = [
        ("force on the wheel, kN", lambda c: number(c.force_kN, 3)),
        ("  lateral (to the right), kN", lambda c: number(c.lateral_force_kN, 3)),
        ("  vertical (up), kN", lambda c: number(c.vertical_force_kN, 3)),
        ("contact angle, degrees", lambda c: number(c.contact_angle_deg, 2)),
        ("position on the rail (x, y), mm", lambda c: _point(c.rail_position_mm)),
        ("position on the wheel (x, y), mm", lambda c: _point(c.wheel_position_mm)),
        ("maximum pressure, MPa", lambda c: marked(number(c.max_pressure_MPa, 1), c.max_pressure_remark)),
        ("  Hertz, MPa", lambda c: _hertz(c.hertz_pressure_MPa, 1)),
        ("  pressure oscillation, %", lambda c: number(100.0 * c.pressure_oscillation, 2)),
        ("half width, mm", lambda c: number(c.half_width_mm, 3)),
        ("  Hertz, mm", lambda c: _hertz(c.hertz_half_width_mm, 3)),
        ("in-plane shear in the rail, MPa (at mm)", lambda c: _at_depth(c.in_rail, "max_in_plane_shear")),
        ("  in the wheel", lambda c: _at_depth(c.in_wheel, "max_in_plane_shear")),
        ("  Hertz", lambda c: _at_depth(c, "hertz_in_plane_shear")),
        ("von Mises in the rail, MPa (at mm)", lambda c: _at_depth(c.in_rail, "max_von_mises")),
        ("  in the wheel", lambda c: _at_depth(c.in_wheel, "max_von_mises")),
        ("nodes in contact", lambda c: f"{c.n_nodes}"),
    ]
    rows = [(name, *(text(contact) for contact in contacts)) for name, text in quantities]
    return SummaryTable("Contacts", ("", *(contact_name(c, contacts) for c in contacts)), tuple(rows))


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
        ("roll, rad", _small(position.roll_rad)),
    ]
    if published is not None:
        rows += [
            ("  vertical in space, mm", number(position.vertical_in_space_mm, 4)),
            ("  horizontal in space, mm", number(position.horizontal_in_space_mm, 4)),
            ("  published vertical, mm", number(published.vertical_mm, 3)),
            ("  published horizontal, mm", number(published.horizontal_mm, 3)),
            ("  published roll, rad", _small(published.roll_rad)),
        ]
    if any(side.lateral_over_vertical is not None for side in summary.sides):
        rows += [(f"L/V of the {each.side} wheel", number(each.lateral_over_vertical, 4)) for each in summary.sides]
    rows.append(("equilibrium residual", _small(residual.equilibrium)))
    parts = (
        ("  vertical", residual.vertical, "vertical_mm"),
        ("  lateral", residual.lateral, "lateral_mm"),
        ("  moment", residual.moment, "roll_rad"),
    )
    rows += [(name, _small(value)) for name, value, key in parts if summary.case[key] is None]
    holding = summary.support.holding
    if holding is not None:
        forces = (
            ("reaction at the axle: lateral force, N", holding.lateral_N, "lateral_mm"),
            ("reaction at the axle: vertical force, N", holding.vertical_N, "vertical_mm"),
            ("reaction at the axle: moment, N mm", holding.moment_N_mm, "roll_rad"),
        )
        rows += [(name, number(value, 1)) for name, value, key in forces if summary.case[key] is not None]
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
    for side in ("left", "right"):
        rows += [
            (f"{side}: {name}", *(_of_side(contacts, side, key, digits) for contacts in both))
            for name, key, digits in quantities
        ]
    return SummaryTable("Elastic and rigid, in the track's axes", ("", "elastic", "rigid"), tuple(rows))


def _of_side(contacts: Contacts, side: str, key: str, digits: int) -> str:
    """Values of a side's contacts from left to right; the x of a position."""
    mine = sorted((c for c in contacts if c.side == side), key=lambda c: c.space_position_mm[0])
    values = [getattr(c, key)[0] if key.endswith("position_mm") else getattr(c, key) for c in mine]
    return " / ".join(number(value, digits) for value in values) or "–"


def bending_table(summary: WheelsetSummary, *, short: bool = False) -> SummaryTable:
    """Displacement of the rails' heads and stresses in web and fillets, one column a rail; `short`: no fillets."""
    rails = summary.bending
    quantities: list[tuple[str, Callable[[BendingSummary], str]]] = [
        ("top of the head to the right, mm", lambda r: number(r.head_lateral_mm, 3)),
        ("  up, mm", lambda r: number(r.head_vertical_mm, 3)),
        ("  roll outwards, mrad", lambda r: number(1e3 * r.head_roll_outward_rad, 2)),
        ("gauge face outwards, mm", lambda r: number(r.gauge_outward_mm, 3)),
        ("web, gauge face, MPa", lambda r: number(r.web_gauge_face_MPa, 0)),
        ("  field face, MPa", lambda r: number(r.web_field_face_MPa, 0)),
    ]
    if not short:
        quantities += [
            ("web: normal force, kN", lambda r: number(r.web_normal_force_kN, 2)),
            ("  shear force, kN", lambda r: number(r.web_shear_force_kN, 2)),
            ("  moment, kN mm", lambda r: number(r.web_moment_kN_mm, 1)),
        ]
    for towards in ("head", "foot"):
        for word, sign in (("tension", 1.0), ("compression", -1.0)):
            quantities.append((f"maximum {word} towards the {towards}, MPa", _extreme(towards, word, sign, short)))
    rows = [(name, *(text(rail) for rail in rails)) for name, text in quantities]
    caption = "Bending of the rails, stresses along the surface of web and fillets (of the slice alone: see limits)"
    return SummaryTable(caption, ("", *(rail.side for rail in rails)), tuple(rows))


def _extreme(towards: str, word: str, sign: float, short: bool) -> Callable[[BendingSummary], str]:
    def text(rail: BendingSummary) -> str:
        found = [(getattr(f, f"max_{word}_MPa"), f) for f in rail.fillets if f.towards == towards]
        known = [(value, fillet) for value, fillet in found if value is not None]
        if not known:
            return "–"
        value, worst = max(known, key=lambda each: sign * each[0])
        where = _point(getattr(worst, f"{word}_position_mm"), 1)
        return number(value, 0) if short else f"{number(value, 0)} ({worst.face}, {where})"

    return text


def support_table(summary: WheelsetSummary) -> SummaryTable:
    """Reactions of bases and axle, and the residuals with the contact forces."""
    rows = [
        (
            row.part,
            number(row.lateral_force_kN, 3),
            number(row.vertical_force_kN, 3),
            number(row.moment_kN_mm, 1),
            number(row.eccentricity_mm, 2),
            _small(row.force_residual),
            _small(row.moment_residual),
        )
        for row in summary.support.reactions
    ]
    header = ("", "lateral, kN", "vertical, kN", "moment, kN mm", "eccentricity, mm")
    return SummaryTable(
        "Reactions of bases and axle on the parts", (*header, "force residual", "moment residual"), tuple(rows)
    )


def stresses_table(summary: WheelsetSummary) -> SummaryTable:
    """Extreme stresses of the parts."""
    header = (
        *("", "von Mises below contacts, MPa", "anywhere in the slice, MPa"),
        *("minimum principal, MPa", "maximum in-plane shear, MPa"),
    )
    rows = [
        (
            each.part,
            *(number(each.max_von_mises_below_contacts_MPa, 1), number(each.max_von_mises_MPa, 1)),
            *(number(each.min_principal_MPa, 1), number(each.max_in_plane_shear_MPa, 1)),
        )
        for each in summary.stresses
    ]
    caption = "Extreme stresses, element averages (anywhere: also in web, fillets and foot of the slice, see limits)"
    return SummaryTable(caption, header, tuple(rows))


def bodies_table(summary: WheelsetSummary) -> SummaryTable:
    """Sizes of the meshes."""
    rows = [(b.name, f"{b.unknowns:,}", f"{b.elements:,}", f"{b.nodes:,}", ", ".join(b.parts)) for b in summary.bodies]
    return SummaryTable("Bodies", ("", "unknowns", "elements", "nodes", "used for"), tuple(rows))


def timings_table(timings_s: Mapping[str, float]) -> SummaryTable:
    """Seconds of each stage."""
    rows = [(name.replace("_", "-"), number(t, 2)) for name, t in timings_s.items()]
    return SummaryTable("Time", ("", "s"), tuple(rows))


def marked(text: str, remark: str | None) -> str:
    """Return the text of a value, with the reason why it is approximate, if there is one."""
    return text if remark is None else f"about {text} ({remark})"


def number(value: float | None, digits: int) -> str:
    """Return a number with some decimals, or a dash for None."""
    return "–" if value is None else f"{value:.{digits}f}"


def _hertz(value: float | None, digits: int) -> str:
    return "conforming" if value is None else number(value, digits)


def _small(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}"


def _coordinate(value: float | None) -> str:
    """Return a coordinate with four decimals, or its size where these are all zero."""
    return _small(value) if value is None or abs(value) < 5e-4 else f"{value:.4f}"


def _point(point: Sequence[float], digits: int = 3) -> str:
    return f"({point[0]:.{digits}f}, {point[1]:.{digits}f})"


def _at_depth(row: object, name: str) -> str:
    """A stress with its depth."""
    value, depth = getattr(row, f"{name}_MPa"), getattr(row, f"{name}_depth_mm")
    return "–" if value is None else f"{value:.0f} ({depth:.2f})"
