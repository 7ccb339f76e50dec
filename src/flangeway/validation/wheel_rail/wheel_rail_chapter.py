"""Wheel and rail on the page of validation."""

from flangeway.railway.profiles.flange_root import IDENTIFIED, IDENTIFIED_RADIUS_MM
from flangeway.validation.validation_page import Chapter, PagePicture
from flangeway.validation.validation_tables import PageTable, digits, relative
from flangeway.validation.wheel_rail.wheel_rail_figures import (
    positions_figure,
    refined_pressures_figure,
    rigid_limit_figure,
    root_figure,
)
from flangeway.validation.wheel_rail.wheel_rail_reproduced import WheelRailReproduction, patch_rows
from flangeway.validation.wheel_rail.wheel_rail_tables import (
    BALANCED,
    BODY_MM,
    FAMILIES,
    FITTED_CODE,
    MEMBER_CODE,
    RAIL_MM,
    WHEEL_MM,
)


def _tables(found: WheelRailReproduction) -> list[PageTable]:
    """What is fitted and predicted, the members of the families, and the contacts of all rows."""
    rows = tuple(
        (
            f"{row.situation} {row.code}",
            row.contact,
            *(digits(v, 3) for v in (row.angle_deg, row.wheel_x_mm, row.rail_x_mm, row.force_kN)),
        )
        for row in patch_rows(found.rows)
    )
    head = ("row", "contact", "angle (degrees)", "x of the wheel (mm)", "x of the rail (mm)", "force (kN)")
    members = tuple(
        (
            each.family,
            digits(each.radius_mm, 3),
            digits(each.lateral_cm),
            digits(each.rotation_rad),
            digits(each.vertical_difference_cm),
        )
        for each in found.members
    )
    roots = ("family of flange roots", "wide arc (mm)", "lateral (cm)", "rotation (rad)", "curve less tangent (cm)")
    return [
        _kinds(found),
        PageTable(
            f"Curve {MEMBER_CODE} with other flange roots (published: 0.7025 cm, 3.273e-4, 0.0163 cm)", roots, members
        ),
        PageTable("Contacts, for which nothing is published", head, rows),
    ]


def _kinds(found: WheelRailReproduction) -> PageTable:
    """How many numbers of Tables 15 and 16 are fitted and how many predicted, and how far off they are."""
    rows = []
    for kind in ("fitted", "predicted"):
        mine = [number for number in found.numbers if number.note.startswith(kind)]
        for name in dict.fromkeys((number.table, number.quantity, number.limit) for number in mine):
            same = [number for number in mine if (number.table, number.quantity, number.limit) == name]
            apart = [number.relative_difference for number in same]
            off = " to ".join(dict.fromkeys(relative(value) for value in (min(apart), max(apart))))
            within = f"{sum(number.within for number in same)} of {len(same)}"
            rows.append(
                (
                    kind,
                    f"Table {name[0]}: {name[1]}, {same[0].unit}",
                    str(len(same)),
                    off if name[2].endswith("%") else "",
                    name[2],
                    within,
                )
            )
    head = ("kind", "quantity", "numbers", "difference", "limit", "within")
    return PageTable("What is fitted and what is predicted", head, tuple(rows))


CHAPTER = Chapter(
    "Wheel and rail",
    f"""A wheelset on two rails in tangent track and in a curve: Tables 15 and 16 of Moherdaui (2021), pages 197 and
    203. There the position was sought by hand until the balance was within about 1e-5 of the load; here it must be
    within {digits(BALANCED, 1)}. No source gives the flange root of the wheel. **One number is fitted**: the radius of
    the root's wide arc, {digits(IDENTIFIED_RADIUS_MM, 3)} mm in place of the assumed 38.1 mm, is chosen so that
    {FITTED_CODE} has its published lateral translation. Taper, height, thickness and angle of the flange stay, the
    narrow arc of the root (14.29 mm) and the slope at which it follows the wide one too: narrow arc and flange face
    move with the wide arc ("{next(iter(FAMILIES))}"). **The other positions are predicted**, but they also chose this
    family: with the narrow arc in its place ("{list(FAMILIES)[1]}") a wide arc of about 75 mm meets the lateral
    translation as well, but not rotation and vertical translation together (rows "flange root"). The wheel is
    `{IDENTIFIED}`; only this chapter uses it. The other readings: node-to-segment, 1e5 kN/cm (polygons 5e4) at each
    node, triangles of {RAIL_MM:g} mm in contact on the rail, {WHEEL_MM:g} mm on the wheel and {BODY_MM:g} mm elsewhere,
    as in section 6 of the source, since chapter 7 names none; the same mesh for both orders. Since the size elsewhere
    is not given, the differences between the rows must have the published sign only; with 10 mm elsewhere they come
    near the published size. The vertical translation depends on a reference position that is not given: it is compared
    as a difference. The outer wheel touches at two places, the tread almost level and the flange root at 15 degrees.
    Further: the kinds of elements agree; with a stiffer and stiffer material the position becomes that of rigid
    profiles, which another algorithm finds; a finer mesh changes little; and where wheel and rail are one arc each,
    Hertz's theory (1882) comes out. In the rows "agreement" and "refinement" the number compared with is one of
    flangeway's own. Codes: F or V, finite or virtual elements; the order.""",
    (
        PagePicture(
            "wheel-rail-positions",
            "Vertical and horizontal translation and rotation of all rows, published and computed",
            positions_figure,
        ),
        PagePicture(
            "wheel-rail-flange-root",
            "Assumed and identified flange root; rotation and vertical translation over the lateral translation for "
            "two families of roots, and for the published and the computed rows",
            root_figure,
        ),
        PagePicture(
            "wheel-rail-pressures",
            "Pressures of the three contacts in a curve, segment-to-segment, beside Hertz's curve of the same force "
            "and curvature",
            refined_pressures_figure,
        ),
        PagePicture(
            "wheel-rail-rigid-limit",
            "Distance of the elastic wheelset from the rigid one over the factor on Young's modulus: it falls with one "
            "over the factor",
            rigid_limit_figure,
        ),
    ),
    _tables,
)
