"""Convergence: the Newton iterations of load steps as a figure and a table."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flangeway.contact import ContactSolution, ContactState
from flangeway.report.figures.drawing import GREY, INK, NODES, legend_below, name_axes, panels, power_of_ten
from flangeway.report.page.tables import SummaryTable

MIN_ERROR = 1e-17  # value for errors of exactly zero on the logarithmic axis
ERRORS = {"residual": "residual over the total force", "change": "change over the maximum displacement"}


def load_steps(contact: ContactSolution) -> list[tuple[str, ContactState]]:
    """Name and state of each load step, and where it ended without success."""
    found: list[tuple[str, ContactState]] = []
    legs = any(step.share > 1.0 for step in contact.steps)
    for step in contact.steps:
        leg = max(math.ceil(step.share), 1)
        name = f"leg {leg}: " * legs + f"{100.0 * (step.share - leg + 1):.4g} %"
        found.append((name, step.state))
    if not contact.status.converged:
        found.append(("not converged", contact.state))
    return found


def newton_figure(steps: Sequence[tuple[str, ContactState]]) -> Figure:
    """Draw residual and change of all iterations, load step by load step."""
    figure, ((axes,),) = panels(13.0, 4.0)
    start = 1
    for history in (state.history for _, state in steps):
        at = np.arange(start, start + len(history))
        for key, colour, line, marker in (("residual", INK, "-", "o"), ("change", GREY, "--", "s")):
            errors = np.maximum([getattr(iteration, key) for iteration in history], MIN_ERROR)
            axes.plot(at, errors, **NODES | {"color": colour, "ls": line, "marker": marker}, label=ERRORS[key])
        start += len(history)
        axes.axvline(start - 0.5, color=GREY, lw=0.6)
    axes.set(yscale="log", xlim=(0.5, start - 0.5))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    name_axes(axes, "Newton iterations" + (", load step by load step" if len(steps) > 1 else ""), "relative error")
    axes.yaxis.set_major_formatter(power_of_ten)
    legend_below(figure, 2)
    return figure


def steps_table(contact: ContactSolution) -> SummaryTable:
    """Iterations, last errors and constraints under force of each load step."""
    rows = []
    for name, state in load_steps(contact):
        last = state.history[-1] if state.history else None
        errors = ("–", "–", "–") if last is None else (
            f"{last.residual:.1e}", f"{last.change:.1e}", f"{last.n_active}"
        )  # fmt: skip
        rows.append((name, f"{len(state.history)}", *errors))
    header = ("fraction of loads and displacements", "iterations", "residual", "change", "active constraints")
    return SummaryTable("Load steps", header, tuple(rows))
