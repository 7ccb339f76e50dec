"""Wheel and rail on the page of validation."""

from flangeway.report.validation_page import Chapter, PagePicture
from flangeway.report.validation_tables import PageTable, digits
from flangeway.report.wheel_rail_figures import pressures_figure, rigid_limit_figure
from flangeway.study.reproductions.wheel_rail import BALANCED, WheelRailReproduction, patch_rows


def _tables(found: WheelRailReproduction) -> list[PageTable]:
    """The contacts of all rows."""
    rows = tuple(
        (
            f"{row.situation} {row.code}",
            f"{row.side} {row.region}",
            *(digits(v, 3) for v in (row.force_kN, row.max_pressure_MPa, row.half_width_mm, row.max_shear_rail_MPa)),
        )
        for row in patch_rows(found.rows)
    )
    head = ("row", "contact", "force (kN)", "pressure (MPa)", "half width (mm)", "shear in the rail (MPa)")
    return [PageTable("Contacts, for which nothing is published", head, rows)]


CHAPTER = Chapter(
    "Wheel and rail",
    f"""A wheelset on two rails in tangent track and in a curve: the seed's Tables 15 and 16 (pages 197 and 203). There
    the position was sought by hand until the balance was within about 1e-5 of the load; here it must be within
    {digits(BALANCED, 1)}. The published positions **are not met**, and cannot be: their reference position and
    the throat of the wheel are not given. So what decides is what must hold whatever the profile: the kinds of
    elements agree; the outer wheel of the curve touches on crown and gauge corner; with a stiffer and stiffer
    material the position becomes that of rigid profiles, which another algorithm finds; a finer mesh changes
    little; and where wheel and rail are one arc each, Hertz's theory (1882) comes out. In the rows "agreement"
    and "refinement" the number compared with is one of flangeway's own. Codes: F or V, finite or virtual
    elements; the order.""",
    (
        PagePicture(
            "wheel-rail-pressures",
            "Pressures of the three contacts in a curve, beside Hertz's curve of the same force and curvature",
            lambda found: pressures_figure(found, "curve"),
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
