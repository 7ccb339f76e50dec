"""Pictures of a case of bodies: stresses on the deformed bodies, contact pressures and tractions, convergence."""

from functools import partial
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult
from flangeway.geometry.arrays import box, extent, framed
from flangeway.report.figures.drawing import GREY, INK, NODES, PAGE_IN, name_axes, newton_figure, panels
from flangeway.report.figures.plots import DrawnBody, pressure_curves, stress_panels
from flangeway.report.page.record import Picture
from flangeway.report.scenes import load_steps
from flangeway.types import Floats

LETTERS_PER_IN = 13  # of the title
MARGIN = 0.04
MIN_DRAWN_ITERATIONS = 3  # of fewer the table says all


def stress_figure(run: BodiesRun) -> Figure:
    """Draw von Mises stress on the deformed bodies; where they touch, once more near the contact."""
    bodies = [DrawnBody(body.field, partial(_moved, body)) for body in run.bodies.values()]
    points = np.vstack([body.points for body in bodies])
    size = extent(points)
    windows = [framed(points, MARGIN)]
    if run.patches:
        touched = np.vstack([patch.points for patch in run.patches])
        width = 3.0 * max(extent(touched), 1e-3 * size)
        if width < 0.7 * size:
            windows.append(box([touched.mean(axis=0, keepdims=True)], width / 2.0))
    figure, _ = stress_panels(bodies, windows, run.case.units)
    word = "" if run.status.converged else ", not converged"
    figure.suptitle(
        fill(f"{run.case.title}: as deformed{word}", int(LETTERS_PER_IN * figure.get_figwidth())), fontsize=9
    )
    return figure


def _moved(body: BodyResult, points: Floats, displacements: Floats) -> Floats:
    return points + body.moved(points, displacements)


def pressure_figure(run: BodiesRun) -> Figure:
    """Draw the pressures along each region of contact, with Hertz's where the case has it."""
    patches = [(run.pairs[patch.contact].name, patch, run.theory) for patch in run.patches]
    return pressure_curves(patches, run.case.units)


def traction_figure(run: BodiesRun) -> Figure:
    """Draw the tangential tractions of the contacts with friction between their limits, one contact below another."""
    figure, rows = panels(PAGE_IN, 1.8 * len(run.rubbing) + 0.5, len(run.rubbing), 1, run.case.units)
    for axes, pair in zip(rows[:, 0], run.rubbing, strict=True):
        nodes = pair.nodes
        steps = [np.diff(nodes[axis], prepend=nodes[axis][:1]) for axis in "xy"]
        way = np.cumsum(np.hypot(*steps))
        for sign in (1.0, -1.0):
            axes.plot(way, sign * pair.contact.friction_coefficient * nodes["pressure"], color=GREY, lw=1.2, ls="--")
        axes.plot(way, nodes["traction"], color=INK, **NODES)
        axes.set_title(pair.name, fontsize=9)
        name_axes(axes, ("length along the surface", "mm"), ("traction", "MPa"))
    return figure


def bodies_pictures(run: BodiesRun) -> list[Picture]:
    """Pictures, the most important first."""
    near, contact = ", and near the contact" if run.patches else "", run.contact
    theory = ", beside Hertz's theory for the same force" if run.theory is not None else ""
    steps = load_steps(contact) if contact is not None else []
    described = [
        ("stresses.png", True, partial(stress_figure, run), f"Von Mises stress on the deformed bodies{near}."),
        ("pressure.png", run.patches, partial(pressure_figure, run), f"Contact pressure along the surface{theory}."),
        (
            "traction.png",
            run.patches and run.rubbing,
            partial(traction_figure, run),
            "Tangential traction along the surface (solid) between the limits of friction (dashed).",
        ),
        (
            "convergence.png",
            sum(len(state.history) for _, state in steps) >= MIN_DRAWN_ITERATIONS,
            partial(newton_figure, steps),
            "Convergence: residual of the forces and change of the displacements in each iteration.",
        ),
    ]
    return [Picture(name, draw, caption) for name, wanted, draw, caption in described if wanted]
