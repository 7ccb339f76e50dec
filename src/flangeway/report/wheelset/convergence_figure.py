"""Picture of how the search for the balance converged."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flangeway.cases import CaseRun
from flangeway.railway.wheelset.residual import TOLERANCE
from flangeway.report.figures.drawing import GREY, INK, Room, figure_with_room, power_of_ten

SMALLEST = 1e-16
"""Errors of exactly zero are drawn here: the axis is logarithmic."""


def convergence_figure(run: CaseRun) -> Figure:
    """Draw the residuals (Moherdaui 2021, 7.2.2) at each position that was tried, and the accepted one."""
    history = run.result.equilibrium.history
    figure, ((axes,),) = figure_with_room(13.0, 4.0, Room(top=0.15))
    steps = np.arange(len(history))
    resulting = np.maximum([balance.equilibrium_residual for balance in history], SMALLEST)
    axes.semilogy(steps, resulting, color=INK, lw=1.6, marker="o", ms=4.5, mfc="white", label="resulting error")
    free = history[-1].free if history else ()
    if not any(free):
        axes.text(0.5, 0.5, "the position is prescribed: nothing was searched", ha="center", transform=axes.transAxes)
    for name, line, is_free in zip(("lateral", "vertical", "moment"), ("-.", "--", ":"), free, strict=False):
        if not is_free:
            continue
        errors = np.maximum([abs(getattr(balance, f"{name}_residual")) for balance in history], SMALLEST)
        axes.semilogy(steps, errors, color=GREY, lw=1.1, ls=line, label=name)
    axes.axhline(TOLERANCE, color=GREY, lw=0.8)
    axes.annotate("accepted below", (0.0, TOLERANCE), (3.0, 2.0), textcoords="offset points", fontsize=8, color=GREY)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    axes.set_xlabel("outer iteration: positions of the wheelset tried, each with its contact solved")
    axes.set_ylabel("relative error of the balance")
    axes.yaxis.set_major_formatter(power_of_ten)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend(loc="upper right", fontsize=8, framealpha=1.0)
    return figure
