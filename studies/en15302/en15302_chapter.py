"""Figures and chapter of the benchmark of EN 15302."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flangeway.railway.profiles.bundled import REFERENCE_RAIL, REFERENCE_WHEELS, rail, wheel
from flangeway.report.figures.drawing import INK, SERIES, new_figure
from studies.en15302.en15302_reproduced import (
    DIFFERENCE_LIMIT_MM,
    Combination,
    ConicityReproduction,
    conicity_table,
    difference_table,
    reproduce_conicity,
)
from studies.reproduction import Chapter, PagePicture, Reproduction

COMPUTED, BAND = SERIES[0], "#cfe2f3"


def _panels(found: ConicityReproduction, across: str, up: str) -> tuple[Figure, list[tuple[Axes, Combination]]]:
    figure = new_figure(11.0, 5.0)
    panels = figure.subplots(2, 5, sharex=True, sharey=True)
    for axes, each in zip(panels.flat, found.combinations, strict=True):
        axes.set_title(each.title, fontsize=9)
        axes.grid(color="#e4e4e4", linewidth=0.5)
    figure.supylabel(up, fontsize=10)
    for axes in panels[-1]:
        axes.set_xlabel(across, fontsize=9)
    return figure, list(zip(panels.flat, found.combinations, strict=True))


def _legend(figure: Figure) -> Figure:
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return figure


def conicity_figure(found: ConicityReproduction) -> Figure:
    """Draw the conicity of every combination over the amplitude, with the standard's and what it allows."""
    figure, panels = _panels(found, "amplitude in mm", "equivalent conicity")
    for axes, each in panels:
        low, high = each.reference - each.tolerances, each.reference + each.tolerances
        axes.fill_between(each.amplitudes_mm, low, high, color=BAND, lw=0.0, label="tolerance of EN 15302")
        axes.plot(each.amplitudes_mm, each.conicity, color=COMPUTED, lw=1.4, label="computed")
        axes.plot(each.amplitudes_mm, each.reference, ".", color=INK, ms=2.5, label="EN 15302")
    figure.axes[0].set_ylim(0.0, 0.85)
    return _legend(figure)


def difference_figure(found: ConicityReproduction) -> Figure:
    """Draw the rolling radius difference of every combination over the lateral displacement, with the standard's."""
    figure, panels = _panels(found, "lateral displacement in mm", "rolling radius difference in mm")
    for axes, each in panels:
        curve = each.difference
        axes.plot(curve.lateral_mm, curve.difference_mm, color=COMPUTED, lw=1.2, label="computed")
        axes.plot(each.lateral_mm[::4], each.reference_mm[::4], ".", color=INK, ms=2.5, label="EN 15302")
    figure.axes[0].set(xlim=(-7.2, 7.2), ylim=(-6.5, 6.5))
    return _legend(figure)


def profiles_figure(_: ConicityReproduction) -> Figure:
    """Draw the running surfaces of the wheels, heights exaggerated, and the rail's head."""
    figure = new_figure(10.0, 4.2)
    whole, treads = figure.subplots(1, 2)
    for name, colour in zip(REFERENCE_WHEELS, SERIES, strict=False):
        x, y = wheel(name).running_surface.sampled(max_deviation=1e-3).T
        for axes in (whole, treads):
            axes.plot(x, y, color=colour, lw=1.2, label=name)
    x, y = rail(REFERENCE_RAIL).running_surface.sampled(max_deviation=1e-3).T
    whole.plot(x, y - y.max() - 30.0, color=INK, lw=1.2, ls="dashed", label=f"{REFERENCE_RAIL}, upright, lowered")
    whole.set_aspect("equal")
    treads.set(xlim=(-32.0, 40.0), ylim=(-5.0, 2.0), title="running surfaces, heights exaggerated")
    whole.set_title("profiles", fontsize=10)
    treads.title.set_fontsize(10)
    for axes in (whole, treads):
        axes.set(xlabel="from the tape line, or the rail's middle, in mm", ylabel="height in mm")
        axes.grid(color="#e4e4e4", linewidth=0.5)
    figure.legend(*whole.get_legend_handles_labels(), loc="outside lower center", ncols=6, frameon=False)
    return figure


CONICITY = Reproduction(
    reproduce_conicity,
    Chapter(
        "Equivalent conicity: the benchmark of EN 15302",
        f"""Reference wheels R-519-A, -B, -C, -H and -I on the reference rail S-519-A, built from the formulas of the
        standard, without roll: all combinations E1 to E9 of the edition of 2010, and wheel C, which that of 2021 adds.
        Each conicity, at 33 amplitudes from 1 to 7.4 mm, must be within the standard's tolerance, the lesser of 0.05
        and half of it, and 5e-4 where it is zero; each rolling radius difference, 0.1 mm apart, within
        {DIFFERENCE_LIMIT_MM:g} mm, our own limit. The reference results are those of annexes J and K of EN 15302:2021
        as transcribed in the public package EN15302 of A. Rohrbeck; four of its 1438 differences and one of its 330
        conicities, which contradict their neighbours, are left out. The table has the conicities at whole millimetres;
        `conicity.csv` and `rolling_radius_difference.csv` have all.""",
        (
            PagePicture(
                "conicity-tolerances",
                "Equivalent conicity over the amplitude for ten combinations of reference profiles: the computed "
                "curves go through the standard's points, inside the band of its tolerance",
                conicity_figure,
            ),
            PagePicture(
                "conicity-profiles",
                "Reference wheels A, B, C, H and I and the reference rail: flanges are the same but for C, the "
                "treads differ between flange root and tape line",
                profiles_figure,
            ),
        ),
        lambda _: [],
    ),
    {
        "conicity.png": conicity_figure,
        "rolling_radius_difference.png": difference_figure,
        "profiles.png": profiles_figure,
    },
    {"conicity.csv": conicity_table, "rolling_radius_difference.csv": difference_table},
    brief=True,
)
