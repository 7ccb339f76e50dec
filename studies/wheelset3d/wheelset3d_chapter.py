"""Figures and chapter of the wheelset in three dimensions."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from flangeway.report.figures.drawing import GREY, INK, new_figure
from flangeway.report.page.tables import SummaryTable
from studies.published_numbers import digits, percent
from studies.reproduction import Chapter, PagePicture, Reproduction
from studies.spatial.profile_blocks import LIMIT
from studies.wheelset3d.element_methods import DIRECT_LIMIT, FORCE_LIMIT, METHODS
from studies.wheelset3d.element_methods import PRESSURE_LIMIT as METHODS_LIMIT
from studies.wheelset3d.manchester import FORCE_LIMIT as BENCHMARK_FORCE_LIMIT
from studies.wheelset3d.manchester import POSITION_LIMIT_MM, PRESSURE_LIMIT, STEEPEST_RAD
from studies.wheelset3d.wheelset3d_reproduced import (
    Wheelset3dReproduction,
    patches_table,
    positions_table,
    reproduce_wheelset3d,
)


def manchester_figure(found: Wheelset3dReproduction) -> Figure:
    """Draw maximum pressure and contact point over the lateral position, and the deviation of the pressure."""
    figure = new_figure(10.5, 3.8)
    pressure, deviation, place = figure.subplots(1, 3)
    rows = positions_table(found)
    y, known = (np.array([row[name] for row in rows], dtype=float) for name in ("y_published", "p0_published"))
    real, half = (np.array([row[name] for row in rows], dtype=float) for name in ("p0", "p0_half_spaces"))
    pressure.plot(y, known, "o", color=GREY, ms=5, label="CONTACT")
    pressure.plot(y, real, color=INK, lw=1.0, label="flangeway")
    pressure.set_ylabel("maximum pressure in MPa")
    for values, line, label in (
        (real, "solid", "flangeway, rail and wheel"),
        (half, "dashed", "flangeway, half-spaces"),
    ):
        deviation.plot(y, 100.0 * (values / known - 1.0), color=INK, ls=line, lw=1.0, marker=".", label=label)
    deviation.axhline(0.0, color=GREY, lw=0.8)
    deviation.set_ylim(-100.0 * PRESSURE_LIMIT, 100.0 * PRESSURE_LIMIT)
    deviation.set_ylabel("deviation of the maximum pressure in %")
    place.plot(y, [row["wheel_y_published"] for row in rows], "o", color=GREY, ms=5, label="CONTACT")
    place.plot(y, [row["wheel_y"] for row in rows], color=INK, lw=1.0, label="flangeway, as CONTACT")
    place.plot(y, [row["wheel_y_pressure"] for row in rows], color=INK, ls="dashed", lw=1.0, label="centre of pressure")
    place.set_ylabel("position on the wheel in mm")
    for axes in (pressure, deviation, place):
        axes.set_xlabel("lateral position in mm")
        axes.grid(which="major", color="#e4e4e4", linewidth=0.5)
        axes.legend(frameon=False, fontsize=8)
    return figure


def _tables(found: Wheelset3dReproduction) -> Sequence[SummaryTable]:
    """The patches of tangent and curve."""
    rows = tuple(
        (
            f"{row['situation']}, {row['method']} {row['order']}, {row['side']}",
            str(row["region"]),
            *(digits(float(str(row[name])), 5) for name in ("force", "p0", "longer_semi_axis", "shorter_semi_axis")),
        )
        for row in patches_table(found)
    )
    head = ("situation, elements, wheel", "region", "force, N", "p0, MPa", "semi-axes, mm", "")
    return [SummaryTable("Patches of S1002 on 60E1 at standard gauge", head, rows)]


WHEELSET3D = Reproduction(
    reproduce_wheelset3d,
    Chapter(
        "The wheelset in three dimensions",
        f"""Wheels on rails in three dimensions. The Manchester contact benchmark (Shackleton and Iwnicki 2008), case
        A-2.2, left wheel, S1002 on UIC60 under 10 kN with yaw and roll in 21 lateral positions, beside E. A. H.
        Vollebregt's CONTACT: maximum pressure to {percent(PRESSURE_LIMIT)}, normal force to
        {percent(BENCHMARK_FORCE_LIMIT)}, contact point on the wheel to {POSITION_LIMIT_MM:g} mm where the contact angle
        is below {STEEPEST_RAD:g} rad and the patch in one piece; with the elasticity of rail and wheel, and of
        half-spaces, which CONTACT's bodies are. Ours is without friction: CONTACT's creep forces of up to 3 kN change
        its normal force by up to 0.5 %. Its contact point is the centre of the squared overlap of the undeformed
        surfaces; ours is computed in the same way, and the centre of pressure is shown beside it. The rail is the
        bundled 60E1 (EN 13674-1): the arc of 300 mm on the head of the benchmark's rail is about 0.25 mm longer on
        each side. Tangent and curve (500 m, 80 km/h, 60 mm of superelevation) at standard gauge by finite and virtual
        elements of both orders: forces to {percent(FORCE_LIMIT)}, pressures to {percent(METHODS_LIMIT)} beside those of
        {METHODS[0][0]} {METHODS[0][1]}. Patches of a tabulated compliance beside those of a mesh that is fine in the
        patch, which is pressed directly: {percent(DIRECT_LIMIT)}. One position with true profiles, cut to blocks of
        60 mm, beside C3D20 of CalculiX: {percent(LIMIT)}.""",
        (
            PagePicture(
                "wheelset3d-manchester",
                "Maximum pressure, its deviation from CONTACT and the contact point on the wheel over the lateral "
                "position: all points of CONTACT lie on the curves of flangeway",
                manchester_figure,
            ),
        ),
        _tables,
    ),
    {"manchester.png": manchester_figure},
    {"manchester.csv": positions_table, "patches.csv": patches_table},
)
