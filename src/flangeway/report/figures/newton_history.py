"""How Newton's iterations of the load steps of a case of bodies went: a picture and a table."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flangeway.contact import ContactSolution
from flangeway.report.figures.drawing import GREY, INK, Room, figure_with_room, power_of_ten
from flangeway.report.page.page_tables import Table
from flangeway.solve import ContactState

SMALLEST = 1e-17
"""Errors of exactly zero are drawn here: the axis is logarithmic."""
ERRORS = {"residual": "imbalance over the total force", "change": "change over the maximum displacement"}
MOST_NAMED = 12
"""Number of steps up to which each has its name in the picture."""


def load_steps(contact: ContactSolution) -> list[tuple[str, ContactState]]:
    """Name and state of each load step, a force that was sought after them, and where it ended without success."""
    found: list[tuple[str, ContactState]] = []
    last = 0.0
    for step in contact.steps:
        found.append(("pushed" if step.share == last == 1.0 else f"{100.0 * step.share:.4g} %", step.state))
        last = step.share
    if not contact.status.converged:
        found.append(("not converged", contact.state))
    return found


def newton_figure(contact: ContactSolution) -> Figure:
    """Draw residual and change of all iterations, load step by load step."""
    figure, ((axes,),) = figure_with_room(13.0, 4.0, Room(bottom=0.8, top=0.15))
    steps = [(name, state.history) for name, state in load_steps(contact) if state.history]
    start, corrected = 0, False
    for number, (name, history) in enumerate(steps):
        at = np.arange(start + 1, start + 1 + len(history))
        for key, colour, line, marker in (("residual", INK, "-", "o"), ("change", GREY, "--", "s")):
            errors = np.maximum([getattr(iteration, key) for iteration in history], SMALLEST)
            axes.semilogy(
                at, errors, color=colour, lw=1.4, ls=line, marker=marker, ms=4.0, mfc="white",
                label=None if number else ERRORS[key],
            )  # fmt: skip
        if number:
            axes.axvline(start + 0.5, color=GREY, lw=0.6)
        corrections = np.array([iteration.correction for iteration in history])
        for place in np.flatnonzero(np.diff(corrections)):
            label = "correction of the forces" if not corrected else None
            axes.axvline(at[place] + 0.5, color=GREY, lw=0.8, ls=":", label=label)
            corrected = True
        if 1 < len(steps) <= MOST_NAMED:
            axes.text(
                start + 0.6, 0.98, name, fontsize=8, color=GREY, va="top", transform=axes.get_xaxis_transform()
            )  # fmt: skip
        start += len(history)
    axes.set_xlim(0.5, max(start, 1) + 0.5)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    axes.set_xlabel("Newton's iterations" + (", load step by load step" if len(steps) > 1 else ""))
    axes.set_ylabel("relative error")
    axes.yaxis.set_major_formatter(power_of_ten)
    axes.grid(color="#dddddd", linewidth=0.6)
    figure.legend(loc="lower center", ncols=3, fontsize=8, frameon=False)
    return figure


def steps_table(contact: ContactSolution) -> Table:
    """Iterations, last errors and constraints under force of each load step."""
    rows = []
    for name, state in load_steps(contact):
        last = state.history[-1] if state.history else None
        errors = ("–", "–", "–") if last is None else (
            f"{last.residual:.1e}", f"{last.change:.1e}", f"{last.n_active}"
        )  # fmt: skip
        rows.append((name, f"{len(state.history)}", *errors))
    header = ("share of loads and motions", "iterations", "imbalance", "change", "constraints under force")
    return Table("Load steps", header, tuple(rows))
