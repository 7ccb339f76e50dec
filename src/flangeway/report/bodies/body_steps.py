"""Load steps of a case of bodies as its page and its files show them: as many as a page has room for."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.contact import LoadStep
from flangeway.report.bodies.body_fields import BodyFields
from flangeway.report.figures.newton_history import load_steps

MOST_VALUES = 3_000_000
"""Numbers of all load steps above which page and files leave some of them out."""


@dataclass(frozen=True, eq=False)
class BodySteps:
    """Load steps with the fields of all bodies.

    Parameters
    ----------
    names
        Number, count and name of each step, the last one's last.
    numbers
        Number of each step, from 1.
    fields
        Fields of the bodies in their order, step by step, all at the same points.
    note
        Sentence on what is left out, empty if nothing is.

    """

    names: tuple[str, ...]
    numbers: tuple[int, ...]
    fields: tuple[Sequence[BodyFields], ...]
    note: str


def body_steps(run: BodiesRun, last: Sequence[BodyFields]) -> BodySteps:
    """Return the load steps of a run, evenly chosen where all have more than `MOST_VALUES` numbers.

    Parameters
    ----------
    run
        The run.
    last
        Fields of all bodies at its end, which is the last step.

    """
    if run.contact is None:
        return BodySteps(("",), (1,), (last,), "")
    names = [name for name, _ in load_steps(run.contact)]
    earlier, note = run.contact.steps[: len(names) - 1], ""
    if "sliding_body" in run.summary.results:
        if len(earlier) > 1:
            note = "Load steps before equilibrium are not shown: there a support carries loads of the contact."
        earlier = ()
    elif earlier and _at_rest(run, earlier[0]):
        earlier = ()  # and so are all the others before the push: loads and motions are proportional
    names = names[len(names) - 1 - len(earlier) :]
    chosen = evenly(len(names), MOST_VALUES // _n_values(run, last))
    if len(chosen) < len(names):
        kept = f"{len(chosen)} of the {len(names)} load steps are shown, evenly chosen, the last among them"
        if len(chosen) == 1:
            kept = f"Of the {len(names)} load steps only the last is shown"
        note = f"{kept}: a page has room for {MOST_VALUES:,} values."
    fields = [_fields_at(run, earlier[number], last) for number in chosen[:-1]]
    words, numbers = tuple(_words(names, number) for number in chosen), tuple(number + 1 for number in chosen)
    return BodySteps(words, numbers, (*fields, last), note)


def _words(names: Sequence[str], number: int) -> str:
    name = names[number]
    share = f"{name} of loads and motions" if name.endswith("%") else name
    return f"{number + 1} of {len(names)}: {share}"


def _at_rest(run: BodiesRun, step: LoadStep) -> bool:
    """Whether nothing has moved yet."""
    for body in run.at_step(step).values():
        space, values = body.field.problem.space, body.field.displacements
        if body.moved(space.nodes, values[: space.n_nodes]).any():
            return False
    return True


def _fields_at(run: BodiesRun, step: LoadStep, like: Sequence[BodyFields]) -> list[BodyFields]:
    bodies = run.at_step(step)
    return [each.of(bodies[each.name]) for each in like]


def _n_values(run: BodiesRun, fields: Sequence[BodyFields]) -> int:
    """Numbers of one step: displacements of the places and stresses, which elements of order 1 have one a cell."""
    total = 0
    for each in fields:
        constant = run.bodies[each.name].field.problem.space.order == 1
        total += 2 * int(each.places.max() + 1) + 4 * (each.mesh.n_cells if constant else each.mesh.n_points)
    return total


def evenly(n: int, most: int) -> list[int]:
    """Numbers of some of n steps, the last among them."""
    chosen: list[int] = np.rint(np.linspace(n - 1, 0, max(min(n, most), 1))).astype(int).tolist()
    return chosen[::-1]
