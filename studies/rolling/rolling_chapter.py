"""Figures and chapter of rolling with friction."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.page.tables import SummaryTable
from flangeway.report.rolling.rolling_maps import ShownRolling, rolling_figure
from studies.published_numbers import digits, percent
from studies.reproduction import Chapter, PagePicture, Reproduction
from studies.rolling.manchester_rolling import CREEP_LIMIT
from studies.rolling.rolling_bodies import BODY_LIMIT
from studies.rolling.rolling_cases import (
    COARSE_LIMIT,
    COEFFICIENT_LIMITS,
    FASTSIM_LIMIT,
    LINE_LIMIT,
    POINT_LIMIT,
)
from studies.rolling.rolling_reproduced import (
    SPIN,
    THEORIES,
    RollingReproduction,
    curve_of,
    curve_table,
    refinement_table,
    reproduce_rolling,
)
from studies.rolling.rolling_rollers import FREE_LIMIT

LINES = {"exact": ("solid", INK), "linear theory": ("dotted", GREY), "Polach": ("dashdot", "#b35806"),
         "FASTSIM": ("dashed", "#2166ac"), "FaStrip": ("dashed", "#1b7837")}  # fmt: skip


def curves_figure(found: RollingReproduction) -> Figure:
    """Draw forces over the longitudinal creepage, without and with spin."""
    figure = new_figure(10.5, 4.0)
    for axes, (spin, column, title) in zip(
        figure.subplots(1, 3),
        (
            (0.0, 1, "along, without spin"),
            (SPIN, 1, f"along, spin {1e3 * SPIN:g} per m"),
            (SPIN, 2, f"across, spin {1e3 * SPIN:g} per m"),
        ),
        strict=True,
    ):
        for name in ("exact", *THEORIES):
            curve = curve_of(found, name, spin)
            style, colour = LINES[name]
            axes.plot(1e3 * curve[:, 0], curve[:, column], ls=style, color=colour, lw=1.2, label=name)
        axes.set_ylim(*((-1.1, 0.05) if column == 1 else (-0.05, 0.6)))
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("longitudinal creepage, 1/1000")
        axes.grid(color="#e4e4e4", linewidth=0.5)
    figure.axes[0].set_ylabel("force over the limit of friction")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, frameon=False)
    return figure


def tractions_figure(found: RollingReproduction) -> Figure:
    """Draw stick, slip and tractions, slip velocity and frictional power under lateral creepage and spin."""
    return rolling_figure([ShownRolling("CONTACT's ellipse", found.shown, found.shown.contact, 1.0, 0.0)])


def _tables(found: RollingReproduction) -> Sequence[SummaryTable]:
    """Coefficients on all grids."""
    chosen = [row for row in found.rows if row.case == "coefficients"]
    cells = list(dict.fromkeys(row.cells for row in chosen))
    kinds = dict.fromkeys((row.code, row.quantity) for row in chosen)
    rows = tuple(
        (code, name.upper(), *(digits(row.value) for row in chosen if (row.code, row.quantity) == (code, name)))
        for code, name in kinds
    )
    return [SummaryTable("Creep coefficients on grids with 24 to 48 cells across", ("a/b", "", *map(str, cells)), rows)]


ROLLING = Reproduction(
    reproduce_rolling,
    Chapter(
        "Rolling with friction",
        f"""Kalker's exact theory and fast theories on half-spaces. Cylinders beside Carter (1926,
        {percent(LINE_LIMIT)}) and, when shifted, beside Cattaneo and Mindlin; shifted spheres
        ({percent(POINT_LIMIT)}); Kalker's creep coefficients for five ellipses at nu = 1/4, extrapolated from five
        grids ({percent(COEFFICIENT_LIMITS["c11"])}, C33 {percent(COEFFICIENT_LIMITS["c33"])}, published with three
        digits); free rolling of different materials, all slipping (Bentall and Johnson, 1967) and none (Bufler,
        1959), beside the closed forms, and beside CONTACT on its cells with its differences of first order, which
        make its creepage without slip 2.2 % smaller than the closed form, 0.0003673 ({percent(FREE_LIMIT)});
        saturation under large creepage and pure spin; examples of CONTACT, with friction that falls and the onset of
        rolling ({percent(COARSE_LIMIT)}, the error of its grids), and of FASTSIM, extrapolated
        ({percent(FASTSIM_LIMIT)}). Creep forces and spin moments of the Manchester contact benchmark, case A-2.2,
        left wheel, at CONTACT's creepages and about its contact point, the centre of the overlap of undeformed
        surfaces ({percent(CREEP_LIMIT)}): on the real bodies, on half-spaces, and on half-spaces with CONTACT's cells
        and differences of first order, which give its spin moments too. Meshed bodies of 400 x 300 mm beside
        half-spaces under the same pressures, beside Cattaneo and Mindlin, and, on the middle strip of a wide patch,
        beside Carter ({percent(BODY_LIMIT)}: the bodies bend, their surfaces are curved, and a patch that is 3.2
        times as wide as long is not quite plane). In every state of steady rolling the power of friction is that of
        forces and creepages.""",
        (
            PagePicture(
                "rolling-curves",
                "Creep curves of an ellipse by five theories: the fast ones follow the exact one, linear theory its "
                "tangent; with spin there is a lateral force, which falls as the longitudinal creepage grows",
                curves_figure,
            ),
            PagePicture(
                "rolling-tractions",
                "Areas of stick and slip with arrows of the tractions, slip velocity at 1 m/s, and frictional power of "
                "an ellipse under lateral creepage and spin, seen from the second body; the leading edge (top) sticks",
                tractions_figure,
            ),
        ),
        _tables,
    ),
    {"creep_curves.png": curves_figure, "tractions.png": tractions_figure},
    {"refinement.csv": refinement_table, "creep_curves.csv": curve_table},
    brief=True,
)
