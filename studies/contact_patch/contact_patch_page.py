"""Figures and chapter of the contact patch test (Moherdaui 2021, Figures 70 to 75): forces, pressures, stresses."""

from collections.abc import Sequence
from functools import partial
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flangeway.report.figures.display import shaded
from flangeway.report.figures.drawing import INK, new_figure
from flangeway.report.figures.plots import COLOURS
from flangeway.report.page.tables import SummaryTable
from flangeway.types import Floats
from studies.contact_patch.contact_patch_reproduced import (
    LAWS,
    OFF,
    PASSED,
    PUBLISHED,
    SAME_STRESS,
    ContactPatchReproduction,
    PatchRun,
    pass_rows,
    reproduce_contact_patch,
)
from studies.published_numbers import digits, percent, share
from studies.reproduction import Chapter, PagePicture, Reproduction

KINDS = {
    "FO1": "linear triangles",
    "VO1": "polygons, order 1",
    "FO2": "quadratic triangles",
    "VO2": "polygons, order 2",
}
"""Names by the letter of the method and the order."""
STYLES = (("s", (0, (1, 1))), ("o", (0, (5, 1.5))), ("^", "solid"))  # marker and line by refinement
PIECES = 3  # subdivisions along each side of an element's triangles
EXACT = "#d55e00"


def pressures_figure(found: ContactPatchReproduction) -> Figure:
    """Draw the pressures by influence width over the interface, for all refinements (Figure 71)."""
    figure = new_figure(10.0, 6.8)
    rows = figure.subplots(2, 2, sharex=True, sharey="row")
    for axes, (kind, name) in zip(rows.flat, KINDS.items(), strict=True):
        for level, (marker, line) in zip(_levels(found), STYLES, strict=False):
            run = _level(found, level)[kind]
            x = _reference_x(run)
            axes.plot(x, run.patch.pressures, color=INK, marker=marker, ms=3, mfc="white", ls=line, lw=0.8)
        axes.axhline(-PUBLISHED, color=EXACT, linewidth=1.6, zorder=1)
        axes.set_title(name, fontsize=10)
        axes.set_xlabel("x in cm", fontsize=9)
        axes.set_ylabel("pressure in kN/cm²", fontsize=9)
        axes.label_outer()
    handles = [
        Line2D([], [], color=INK, marker=marker, ms=4, mfc="white", ls=line, lw=0.8, label=f"node-to-segment, M{level}")
        for level, (marker, line) in zip(_levels(found), STYLES, strict=False)
    ]
    handles.append(Line2D([], [], color=EXACT, lw=1.6, label="(6.1), and segment-to-segment with multipliers"))
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    return figure


def stresses_figure(found: ContactPatchReproduction, kind: str) -> Figure:
    """Draw the vertical stress of the node-to-segment results of one kind of elements (Figures 72 to 75)."""
    levels = _levels(found)
    runs = [_level(found, level)[kind] for level in levels]
    figure = new_figure(3.6 * len(runs) + 0.8, 4.2)
    _draw_stresses(figure, list(figure.subplots(1, len(runs), sharey=True)), runs, [run.code for run in runs])
    return figure


def comparison_figure(found: ContactPatchReproduction) -> Figure:
    """Draw the vertical stress with node-to-segment above and with segment-to-segment and multipliers below."""
    figure = new_figure(12.0, 8.2)
    rows = figure.subplots(2, 4, sharex=True, sharey=True)
    level = min(2, max(_levels(found)))
    for column, (kind, run) in zip(rows.T, _level(found, level).items(), strict=True):
        proper = _proper(found, run)
        titles = [f"{run.code}\nnode-to-segment", f"{KINDS[kind]}\nsegment-to-segment"]
        _draw_stresses(figure, list(column), [run, proper], titles, location="bottom")
    return figure


def _draw_stresses(
    figure: Figure,
    panels: Sequence[Axes],
    runs: Sequence[PatchRun],
    titles: Sequence[str],
    location: Literal["right", "bottom"] = "right",
) -> None:
    """Draw runs side by side in the same colours."""
    fields = [run.fields for run in runs]
    shown = [[shaded(field, PIECES) for field in pair] for pair in fields]
    values = np.concatenate([stresses.components[:, 1] for pair in shown for _, stresses in pair])
    norm = Normalize(float(values.min()), float(values.max()))
    for axes, pair, drawn, title in zip(panels, fields, shown, titles, strict=True):
        for field, (points, stresses) in zip(pair, drawn, strict=True):
            stress = stresses.components[:, 1]
            colours = axes.tripcolor(points, stress, shading="gouraud", cmap=COLOURS.reversed(), norm=norm)
            mesh = field.problem.space.mesh
            axes.add_collection(LineCollection(list(mesh.points[mesh.edges]), colors=INK, linewidths=0.2, alpha=0.6))
            axes.add_collection(LineCollection(list(mesh.points[mesh.boundary_edges]), colors=INK, linewidths=0.8))
        axes.set_aspect("equal")
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("x in cm", fontsize=9)
        axes.set_ylabel("y in cm", fontsize=9)
        axes.label_outer()
    bar = figure.colorbar(
        colours, ax=list(panels), location=location, shrink=0.85, aspect=25, label="vertical stress in kN/cm²"
    )
    mark = bar.ax.axhline if location == "right" else bar.ax.axvline
    mark(PUBLISHED, color="white", linewidth=1.5)
    bar.ax.tick_params(labelsize=7)


def _levels(found: ContactPatchReproduction) -> list[int]:
    return sorted({_parts(run)[1] for run in found.published})


def _level(found: ContactPatchReproduction, level: int) -> dict[str, PatchRun]:
    """Published configurations of one refinement by kind, in the order of `KINDS`."""
    runs = {_parts(run)[0]: run for run in found.published if _parts(run)[1] == level}
    return {kind: runs[kind] for kind in KINDS}


def _parts(run: PatchRun) -> tuple[str, int]:
    """Kind and refinement of a code such as ``FPTM3O2``."""
    return f"{run.code[0]}{run.code[5:]}", int(run.code[4])


def _proper(found: ContactPatchReproduction, like: PatchRun) -> PatchRun:
    """Segment-to-segment with multipliers on the same meshes."""
    return next(
        run
        for run in found.proper
        if (run.sides, run.level, run.law, run.matching) == (like.sides, like.level, "multiplier", False)
        and (run.case.rotation_deg, run.case.weighting) == (0.0, "standard")
    )


def _reference_x(run: PatchRun) -> Floats:
    """Undeformed positions x of the loaded nodes."""
    surface = run.solution.system.contacts[0].secondary
    nodes = surface.part.body.space.nodes[surface.nodes]
    moved = run.solution.state.positions[run.solution.system.nodes_of(surface)]
    order = np.argsort(moved[:, 0])
    loaded = order[np.searchsorted(moved[order, 0], run.patch.points[:, 0] - 1e-12)]
    return np.asarray(nodes[loaded, 0])


def _tables(found: ContactPatchReproduction) -> list[SummaryTable]:
    """Errors of node-to-segment, and in how many cases segment-to-segment passes, by elements."""
    errors = tuple((run.code, share(run.stress_error), share(run.stress_oscillation)) for run in found.published)
    kinds: dict[str, list[PatchRun]] = {}
    for run in found.proper:
        kinds.setdefault(run.code.partition(" M")[0], []).append(run)
    return [
        SummaryTable(
            "Node-to-segment: maximum difference of a stress from the uniform one, and root mean square over both "
            "boxes. Moherdaui (2021) states that oscillations are smaller on finer meshes and for polygons; the root "
            "mean square confirms it",
            ("code", "maximum", "root mean square"),
            errors,
        ),
        SummaryTable(
            f"Segment-to-segment: cases in which pressures and stresses are uniform to {digits(PASSED, 1)}. Cases are "
            "meshes, matching and not, rotated by 30 degrees or not, with standard and dual weights",
            ("elements above on below", *LAWS),
            tuple((kind, *(_passing(runs, law) for law in LAWS)) for kind, runs in kinds.items()),
        ),
    ]


def _passing(runs: list[PatchRun], law: str) -> str:
    mine = [run.passes for run in runs if run.law == law]
    counted = f"{sum(mine)} of {len(mine)}"
    return counted if all(mine) else f"**{counted}**"


CONTACT_PATCH = Reproduction(
    reproduce_contact_patch,
    Chapter(
        "Contact patch test",
        f"""Two boxes pressed together have one uniform stress: {PUBLISHED:g} kN/cm² by Moherdaui's equation (6.1),
        section 6.2.1. Its node-to-segment results fail the test, in pictures without numbers (Figures 70 to 75, pages
        165 to 170): no stress is exact. The computed results must fail in the same way: a mean stress within
        {percent(SAME_STRESS)}, and stress errors above {percent(OFF)}. Segment-to-segment contact must pass the test
        in every case. Codes such as VPTM3O2: F or V, finite or virtual elements; the mesh; the order.""",
        (
            PagePicture(
                "contact-patch-pressures",
                "Pressures over the interface by node-to-segment contact for four kinds of elements: they oscillate "
                "about the uniform pressure, which segment-to-segment contact meets",
                pressures_figure,
            ),
            PagePicture(
                "contact-patch-stresses",
                "Vertical stresses in both boxes for four kinds of elements: uneven above with node-to-segment "
                "contact, uniform below with segment-to-segment contact",
                comparison_figure,
            ),
        ),
        _tables,
    ),
    {
        "pressures.png": pressures_figure,
        "comparison.png": comparison_figure,
        **{f"stresses_{kind.lower()}.png": partial(stresses_figure, kind=kind) for kind in KINDS},
    },
    {"passes.csv": pass_rows},
    brief=True,
)
