"""Tables of a case of bodies, for the terminal and for the page."""

from collections.abc import Callable, Mapping
from typing import Any

from flangeway.cases.bodies.bodies_run import BodiesSummary, PairSummary
from flangeway.report.page.page_tables import Table, marked

UNITS = {"_N_mm_per_mm": "N mm per mm", "_MPa": "MPa", "_mm": "mm", "_N": "N", "_rad": "rad", "_deg": "degrees"}

REMARK = "_remark"


def case_rows(summary: BodiesSummary) -> list[tuple[str, str]]:
    """Names with units and values of what a case of bodies found, as shown."""
    rows = result_rows(summary)
    for each in summary.contacts:
        name = f"{each.secondary} on {each.primary}"
        rows.append((f"{name}: force on {each.secondary} (x, y), N", value_text(each.force_on_secondary_N)))
        rows.append((f"{name}: maximum pressure, MPa", _pressure(each)))
        rows.append((f"{name}: half width of contact, mm", _half_widths(each)))
    for body in summary.bodies:
        rows.append((f"{body.name}: maximum displacement, mm", value_text(body.max_displacement_mm)))
        rows.append((f"{body.name}: maximum von Mises stress, MPa", value_text(body.max_von_mises_MPa)))
        rows.append((f"{body.name}: elements, unknowns", f"{body.elements}, {body.unknowns}"))
    return rows


def result_rows(summary: BodiesSummary) -> list[tuple[str, str]]:
    """Names with units and values of what a case is about."""
    results = summary.results
    return [
        (", ".join(words_of(key)), marked(value_text(value), remark_of(results, key)))
        for key, value in results.items()
        if not key.endswith(REMARK)
    ]


def remark_of(results: Mapping[str, Any], key: str) -> str | None:
    """Why the value of a key is not to be relied on; None if it is, or nothing is said."""
    remark = results.get(key.removesuffix("_MPa") + REMARK)
    return None if remark is None else str(remark)


def contacts_of_bodies(summary: BodiesSummary) -> Table:
    """Forces, pressures and regions of the contacts, one column a contact."""
    contacts = summary.contacts
    quantities: list[tuple[str, Callable[[PairSummary], str]]] = [
        ("force on the first (x, y), N", lambda c: value_text(c.force_on_secondary_N)),
        ("maximum pressure, MPa", _pressure),
        ("half width of contact, mm", _half_widths),
        ("centre of pressure (x, y), mm", lambda c: _of_patches(c, "centre_mm")),
        ("reaches an end of the surface", lambda c: _of_patches(c, "reaches_an_end")),
        ("overlap before any motion, mm", lambda c: value_text(c.initial_penetration_mm)),
    ]
    header = ("", *(f"{each.secondary} on {each.primary}" for each in contacts))
    rows = tuple((name, *(text(each) for each in contacts)) for name, text in quantities)
    return Table("Contacts", header, rows)


def forces_table(summary: BodiesSummary) -> Table:
    """Forces on the bodies in contact."""
    rows = [
        (row.body, value_text(row.contact_N), value_text(row.loads_N), value_text(row.supports_N))
        for row in summary.forces
    ]
    return Table("Forces on the bodies (x, y)", ("", "contact, N", "loads, N", "supports, N"), tuple(rows))


def supports_table(summary: BodiesSummary) -> Table:
    """Force of each support on its body."""
    rows = [(f"{row.number}", row.body, value_text(row.force_N)) for row in summary.supports]
    return Table("Supports", ("", "body", "force on it (x, y), N"), tuple(rows))


def sizes_table(summary: BodiesSummary) -> Table:
    """Sizes of the bodies' meshes, and their extreme values."""
    header = (
        "",
        "elements",
        "unknowns",
        "maximum displacement, mm",
        "maximum von Mises, MPa",
        "minimum principal, MPa",
    )
    rows = [
        (
            *(body.name, f"{body.elements:,}", f"{body.unknowns:,}"),
            *(value_text(body.max_displacement_mm), value_text(body.max_von_mises_MPa)),
            *(value_text(body.min_principal_MPa), value_text(body.max_in_plane_shear_MPa)),
        )
        for body in summary.bodies
    ]
    return Table("Bodies", (*header, "maximum in-plane shear, MPa"), tuple(rows))


def words_of(key: str) -> tuple[str, ...]:
    """A key as words, and its unit if it has one."""
    for ending, unit in UNITS.items():
        if key.endswith(ending):
            return key[: -len(ending)].replace("_", " "), unit
    return (key.replace("_", " "),)


def value_text(value: Any) -> str:
    """Write a value for people: six digits, lists in brackets."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return f"({', '.join(value_text(each) for each in value)})"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pressure(contact: PairSummary) -> str:
    return marked(value_text(contact.max_pressure_MPa), contact.max_pressure_remark)


def _half_widths(contact: PairSummary) -> str:
    return _of_patches(contact, "half_width_mm") if contact.patches else "no contact"


def _of_patches(contact: PairSummary, key: str) -> str:
    return ", ".join(value_text(getattr(patch, key)) for patch in contact.patches) or "–"
