"""Displacements and stresses of the bodies of a case, as their VTU files and the page show them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult
from flangeway.contact import LoadStep
from flangeway.formats import write_vtu
from flangeway.post import Stresses
from flangeway.report.figures.display import ShownCells, shown_cells
from flangeway.report.figures.newton_history import load_steps
from flangeway.report.figures.series import field_arrays, placed_stresses
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class BodyFields:
    """One body at its first place; each cell has points of its own, so that stresses jump between cells."""

    name: str  # name of the body
    shown: ShownCells  # the cells; of orders above 1 the triangles that they are cut into to be shown
    displacement: Floats  # whole motion of the points in space, mm, shape (n_points, 2)
    stresses: Stresses  # stresses at the points, axes of space, each from its own cell

    def write(self, path: Path, body_id: int = 0) -> None:
        """Write a VTU file; the arrays are those of `field_arrays`, the displacements are the whole motion."""
        arrays = field_arrays(self.displacement, self.stresses)
        write_vtu(path, self.shown.mesh, arrays, {"cell_number": self.shown.cells}, body_id=body_id)


def bodies_fields(run: BodiesRun) -> Iterator[BodyFields]:
    """Fields of all bodies in their order, with the elements' own fields shown for their order."""
    for name, body in run.bodies.items():
        yield body_fields(name, body, shown_cells(body.field.space, body.field.space.order))


def body_fields(name: str, body: BodyResult, shown: ShownCells) -> BodyFields:
    """Fields of a body at the points of its cells as they are shown."""
    elastic, stresses = shown.values(body.field)
    motion = body.moved(shown.mesh.points, elastic)
    return BodyFields(name, shown, motion, placed_stresses(stresses, body.placement))


MAX_VALUES = 3_000_000  # maximum number of values of all load steps on the page and in the files


@dataclass(frozen=True, eq=False)
class BodySteps:
    """Load steps with the fields of all bodies."""

    names: tuple[str, ...]  # number, count and name of each step, the last one's last
    numbers: tuple[int, ...]  # number of each step, from 1
    fields: tuple[Sequence[BodyFields], ...]
    """Fields of the bodies in their order, step by step, all at the same points."""
    note: str  # sentence on what is left out, empty if nothing is


def body_steps(run: BodiesRun, last: Sequence[BodyFields]) -> BodySteps:
    """Return the load steps of a run up to `last`, evenly chosen where all have more than `MAX_VALUES` numbers."""
    if run.contact is None:
        return BodySteps(("",), (1,), (last,), "")
    names = [name for name, _ in load_steps(run.contact)]
    earlier, note = run.contact.steps[: len(names) - 1], ""
    names = names[len(names) - 1 - len(earlier) :]
    chosen = evenly(len(names), MAX_VALUES // _n_values(run, last))
    if len(chosen) < len(names):
        kept = f"{len(chosen)} of the {len(names)} load steps are shown, evenly chosen, the last among them"
        if len(chosen) == 1:
            kept = f"Of the {len(names)} load steps only the last is shown"
        note = f"{kept}: a page has room for {MAX_VALUES:,} values."
    fields = [_fields_at(run, earlier[number], last) for number in chosen[:-1]]
    words, numbers = tuple(_words(names, number) for number in chosen), tuple(number + 1 for number in chosen)
    return BodySteps(words, numbers, (*fields, last), note)


def _words(names: Sequence[str], number: int) -> str:
    name = names[number]
    share = f"{name} of loads and displacements" if name.endswith("%") else name
    return f"{number + 1} of {len(names)}: {share}"


def _fields_at(run: BodiesRun, step: LoadStep, like: Sequence[BodyFields]) -> list[BodyFields]:
    bodies = run.at_step(step)
    return [body_fields(each.name, bodies[each.name], each.shown) for each in like]


def _n_values(run: BodiesRun, fields: Sequence[BodyFields]) -> int:
    """Numbers of one step: displacements of the places and stresses, which elements of order 1 have one a cell."""
    total = 0
    for each in fields:
        mesh, constant = each.shown.mesh, run.bodies[each.name].field.space.order == 1
        total += 2 * int(each.shown.places.max() + 1) + 4 * (mesh.n_cells if constant else mesh.n_points)
    return total


def evenly(n: int, most: int) -> list[int]:
    """Numbers of some of n steps, the last among them."""
    chosen: list[int] = np.rint(np.linspace(n - 1, 0, max(min(n, most), 1))).astype(int).tolist()
    return chosen[::-1]
