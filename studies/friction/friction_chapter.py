"""Figures and chapter of Coulomb friction of plane bodies."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from flangeway.report.figures.drawing import INK, new_figure
from studies.friction.friction_reproduced import (
    MOST_ITERATIONS,
    MU,
    PUNCH_LIMIT,
    STICK_LIMIT,
    WORK_LIMIT,
    FrictionReproduction,
    reproduce_friction,
    stick_rows,
)
from studies.friction.ironing import NORMAL_N_MM, STEADY_WORK_LIMIT, TANGENTIAL_N_MM, TIMES
from studies.friction.loaded_bodies import CHOICES_LIMIT, PLATE_LIMIT, WALL_LIMIT
from studies.friction.punch_with_friction import PULL_LIMIT, PUNCH_STICK_LIMIT
from studies.friction.revolved_contact import REVOLVED_LIMIT
from studies.friction.sliding_bodies import BELT_LIMIT, LEGS, STRIP_LIMIT, strip_force
from studies.published_numbers import percent
from studies.reproduction import Chapter, PagePicture, Reproduction


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


def loop_figure(found: FrictionReproduction) -> Figure:
    """Draw the force of the strip by the displacement of its end, with the closed form."""
    figure = new_figure(7.0, 4.2)
    axes = figure.subplots()
    legs, at, forces = found.strip
    for leg, name in enumerate(LEGS):
        ends = at[legs == leg]
        start = 0.0 if leg == 0 else at[legs == leg - 1][-1]
        places = np.linspace(start, ends[-1], 200)
        exact = [strip_force(leg, each) for each in places.tolist()]
        axes.plot(1e3 * places, exact, color=INK, lw=1.0, label="" if leg else "closed form")
        axes.plot(1e3 * ends, forces[legs == leg], "o", ms=4.0, label=name)
    axes.set(xlabel="displacement in micrometres", ylabel="force per thickness in N/mm")
    axes.legend(frameon=False, fontsize=8)
    return figure


def punch_figure(found: FrictionReproduction) -> Figure:
    """Draw tractions on one half of the flat punch below the limit by the pressure, with the integral equations'."""
    figure = new_figure(10.0, 4.2)
    for axes, each in zip(figure.subplots(1, 2, sharey=True), found.punches, strict=True):
        x, pressures, tractions = each.found
        exact, inside = each.exact, x < 0.99
        # the smallest intervals beside the end of the stick zone carry what is left of a singular traction
        shown = (exact.x < 0.99) & (np.abs(exact.x - exact.stick) > 1e-3)
        axes.axvspan(0.0, exact.stick, color="0.88", lw=0.0, label="stick zone")
        axes.plot(exact.x[shown], each.friction * exact.pressures[shown], color=INK, lw=1.0, ls="dashed",
                  label="limit by the pressure")  # fmt: skip
        axes.plot(exact.x[shown], exact.tractions[shown], color=INK, lw=1.0, label="integral equations")
        axes.plot(x[inside][::3], tractions[inside][::3], "o", ms=4.0, label="traction, finite elements")
        axes.plot(x[inside][::3], each.friction * pressures[inside][::3], "x", ms=4.0, label="limit, finite elements")
        axes.set(
            xlabel="x over the half-width", ylabel="traction over force per half-width",
            title=f"coefficient of friction {each.friction:g}", xlim=(0.0, 1.0), ylim=(0.0, 0.4),
        )  # fmt: skip
        axes.label_outer()
        axes.legend(frameon=False, fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.15))
    return figure


def ironing_figure(found: FrictionReproduction) -> Figure:
    """Draw normal and tangential force of the ironing die over time, with the published ones."""
    figure = new_figure(10.0, 4.4)
    mine = found.ironing
    for axes, title, published, force in zip(
        figure.subplots(1, 2),
        ("normal force", "tangential force"),
        (NORMAL_N_MM, TANGENTIAL_N_MM),
        (mine.normal, mine.tangential),
        strict=True,
    ):
        for (name, values), mark in zip(published.items(), "osv^D", strict=True):
            axes.plot(TIMES, values, marker=mark, ms=4.0, lw=0.8, label=name)
        axes.plot(mine.times, force, color=INK, lw=1.8, label="flangeway, small strains")
        axes.set(
            xlabel="time: lowered from 0 to 1, then moved along", ylabel="force per thickness in N/mm", title=title
        )
        axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.15))
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
        {percent(REVOLVED_LIMIT)} on the finest of three meshes, and the same with so much friction that the flat punch
        sticks (Mossakovskii, Spence). A strip pressed upon a base, pulled, pushed back and pulled until all slides: its
        hysteresis loop and the work within {percent(STRIP_LIMIT)} of the closed form of a bar with distributed friction
        (Masing, 1926); the shear of the part that sticks is left out of it. A belt on half of a drum that turns until
        all slips (Euler, Eytelwein): the ratio of the tensions is within {percent(BELT_LIMIT)} of exp(mu pi) for the
        thinnest belt, and of the ratio that its thickness changes for all. What limits the first is the thickness,
        0.5 % of the radius: friction acts at the drum's radius, the tension in the middle of the belt. Without friction
        a taut belt has the same tension on both sides, and the drum turns below it without a change. A flat punch and a
        cylinder, both rigid, pressed on a half-plane with friction: the middle sticks, and the stick zone is the same
        part of both contacts (Spence, 1968). No equation of it that can be cited for pressure and traction coupled was
        found; the integral equations of the half-plane (Johnson, 1985, 2.25) are solved by themselves on intervals that
        shrink to 1e-9, an independent route: the stick zone is within {percent(PUNCH_STICK_LIMIT)}, half a finite
        element; the part of the force with which friction pulls the halves apart, within {percent(PULL_LIMIT)}, and of
        the punch that sticks, where it is known (Muskhelishvili, 1953). A die that is lowered into a slab and slides
        along it ("shallow ironing", Fischer and Wriggers, 2006) has forces between those of five publications,
        collected in numbers by Batistic, Cardiff and Tukovic (2022; solids4foam, solid-benchmarks): Fischer and
        Wriggers, Hartmann et al. (2009), Yastrebov (2011), Poulios and Renard (2015), and Code_Aster. Theirs are
        neo-Hookean bodies in large deformation, ours linear ones in small strains with large sliding, and theirs differ
        among themselves, so the limits are the least and the largest of the five. Their mean is in the column of what
        is published. While the die is lowered they agree better on the ratio of the forces, which is up to 6 % larger
        here than their mean: it is shown only. In steady sliding the force's work is within
        {percent(STEADY_WORK_LIMIT)} of what friction dissipates. Bodies under loads of their own: a plate that is
        pressed and pushed along a rigid plane (Code_Aster's test SSNV128) has its published displacements within
        {percent(PLATE_LIMIT)}, and within {percent(CHOICES_LIMIT)} of each other with any element, pairing and
        enforcement. The last of the five, 1.50e-5 m, is rounded or of a coarse mesh: orders and meshes converge to
        1.541e-5 m. A block on an incline holds and slides
        at the tangent of its slope; a ring that cools on a shaft has Lame's pressure; a wall on soil, pushed by water,
        is in equilibrium as displaced to {WALL_LIMIT:g}; a bolt that is pulled by a given displacement clamps a flange
        with the force of one piece, as head and flange stick. No load step, nor any of its
        corrections of the forces by augmented Lagrange, may take more than {MOST_ITERATIONS} iterations.""",
        (
            PagePicture(
                "friction-tractions",
                "Tangential tractions of two cylinders in five steps of a push and of its reversal: they reach the "
                "limit by the pressure at the ends of the contact first, and stay below it in the middle",
                tractions_figure,
            ),
            PagePicture(
                "friction-loop",
                "Force of a strip with distributed friction by the displacement of its end: a push, a reversal and a "
                "return close a loop of parabolas, until all slides under a constant force",
                loop_figure,
            ),
            PagePicture(
                "friction-punch",
                "Tangential tractions below one half of a flat punch that is pressed on a half-plane, friction 0.2 and "
                "0.3: they grow from the middle, reach the limit by the pressure at the end of the stick zone, and "
                "follow it to the edge of the punch; finite elements lie on the solution of the integral equations",
                punch_figure,
            ),
            PagePicture(
                "friction-ironing",
                "Normal and tangential force of a die that is lowered into a slab and then moved along it, beside five "
                "published curves: both grow with the depth, jump as the die starts to slide and then stay constant; "
                "the published curves are up to a quarter apart in the normal force and twice in the tangential one",
                ironing_figure,
            ),
        ),
        lambda _: [],
    ),
    {
        "tractions.png": tractions_figure,
        "loop.png": loop_figure,
        "punch.png": punch_figure,
        "ironing.png": ironing_figure,
    },
    {"tractions.csv": stick_rows},
    brief=True,
)
