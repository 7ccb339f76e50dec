"""Figure and chapter of Coulomb friction of plane bodies."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from flangeway.report.figures.drawing import INK, new_figure
from flangeway.validation.friction.friction_reproduced import (
    MOST_ITERATIONS,
    MU,
    PUNCH_LIMIT,
    STICK_LIMIT,
    WORK_LIMIT,
    FrictionReproduction,
    reproduce_friction,
    stick_rows,
)
from flangeway.validation.friction.revolved_contact import REVOLVED_LIMIT
from flangeway.validation.published_numbers import percent
from flangeway.validation.reproduction import Chapter, PagePicture, Reproduction


def tractions_figure(found: FrictionReproduction) -> Figure:
    """Draw the tangential tractions of the cylinders in each step below the limit by the pressure."""
    figure = new_figure(10.0, 4.2)
    for axes, leg in zip(figure.subplots(1, 2, sharey=True), ("push", "reversal"), strict=True):
        steps = [each for each in found.slips if each.leg == leg]
        limit = MU * steps[-1].pressures
        axes.plot(steps[-1].x_mm, limit, color=INK, lw=1.0, ls="dashed", label="limit by the pressure")
        axes.plot(steps[-1].x_mm, -limit, color=INK, lw=1.0, ls="dashed")
        shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(steps)))
        for each, shade in zip(steps, shades, strict=True):
            axes.plot(each.x_mm, each.tractions, color=shade, lw=1.2, label=f"{each.load:.2f} of sliding")
        axes.set(xlabel="x in mm", ylabel="traction in MPa", title=leg)
        axes.label_outer()
        axes.legend(frameon=False, fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.15))
    return figure


FRICTION = Reproduction(
    reproduce_friction,
    Chapter(
        "Coulomb friction of plane bodies",
        f"""Cylinders pressed together, pushed and pulled back, beside the partial slip of Cattaneo and Mindlin: the
        zone that sticks within {percent(STICK_LIMIT)} of the contact, the dissipated work within
        {percent(WORK_LIMIT)}. A load of 1 makes all slip; that of the reversal is counted from its start, and
        twice as large. A rigid flat punch that slides: the centre of its pressure (Johnson, 1985, "Contact
        Mechanics", 2.8) within {percent(PUNCH_LIMIT)}; the pressure has no limit at the punch's ends. Pressures
        and tractions are those of segment-to-segment contact with multipliers. A rigid flat punch and a rigid sphere on
        a half-space, bodies of revolution, with the forces of the whole circumference (Boussinesq, Hertz): within
        {percent(REVOLVED_LIMIT)} on the finest of three meshes. No load step may take more than
        {MOST_ITERATIONS} iterations.""",
        (
            PagePicture(
                "friction-tractions",
                "Tangential tractions of two cylinders in five steps of a push and of its reversal: they reach the "
                "limit by the pressure at the ends of the contact first, and stay below it in the middle",
                tractions_figure,
            ),
        ),
        lambda _: [],
    ),
    {"tractions.png": tractions_figure},
    {"tractions.csv": stick_rows},
    brief=True,
)
