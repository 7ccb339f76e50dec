"""What all cases share: named inputs with ranges, checked before anything is computed; and a case on a finer mesh."""

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar, cast

import annotated_types as at

from flangeway.cases.summary import RunResult, summary_numbers
from flangeway.errors import InputError
from flangeway.records import Record, entries_of, with_settings
from flangeway.system.file_content import toml_data
from flangeway.types import Progress
from flangeway.units import Units

# --- What all cases share: named inputs with ranges, checked before anything is computed.


HALVING = {
    **dict.fromkeys(
        ("size_scale", "size", "size_mm", "body_size_mm", "upper_size_mm", "lower_size_mm", "cell_mm"), 0.5
    ),
    **dict.fromkeys(("patch_cells", "cells_along", "cells_across"), 2),
}
"""Inputs that say how fine a mesh or grid is, and the factors on them that halve its sizes."""
OF_REPORT = ("units", "report_title", "project", "author", "date")
"""Inputs that change nothing of what is computed."""


class Case(Record):
    """Inputs of a computation; units are in the names, and keys that are left out have defaults."""

    name: ClassVar[str]
    title: ClassVar[str]
    units: Units = "metric"
    """units of numbers in results; an input has the unit at the end of its key"""
    report_title: Annotated[str, at.MaxLen(200)] | None = None
    """title of the report (default: that of the case)"""
    project: Annotated[str, at.MaxLen(200)] | None = None
    """project, for the report"""
    author: Annotated[str, at.MaxLen(200)] | None = None
    """author, for the report"""
    date: Annotated[str, at.MaxLen(60)] | None = None
    """date, for the report (default: today)"""

    essential: ClassVar[tuple[str, ...]] = ()  # keys that are set in a new case file; the others are there as comments
    example: ClassVar[Mapping[str, Any]] = {}  # values of a new case file where they are not the defaults

    @classmethod
    def called(cls) -> str:
        """See `Record.called`."""
        return cls.name


def example_of(name: str) -> dict[str, Any]:
    """Return the `Case.example` of a case, from its file in the folder ``examples``."""
    return toml_data((Path(__file__).parent / "examples" / f"{name}.toml").read_text(encoding="utf-8"), "")


class RunnableCase(Case):
    """A case that `flangeway run` computes."""

    @abstractmethod
    def check(self) -> None:
        """Raise `InputError` for what is wrong beyond single values, without computing."""

    def check_sections(self) -> None:
        """Raise `InputError` where a run has no whole sections of rails and wheels."""
        raise InputError(
            f"whole sections of {self.name}",
            "those of rails and wheels of a wheelset in three dimensions",
            "leave --whole-sections out",
        )

    position_keys: ClassVar[tuple[str, ...]] = ()
    """Inputs that leave the bodies as they are: cases that differ in these only share their `prepared` bodies."""

    @property
    def min_together(self) -> int | None:
        """Minimum number of cases with the same bodies for which preparing these pays; None: it never does."""
        return None

    def check_position(self) -> None:
        """Raise `InputError` for what is wrong with the inputs `position_keys`, where the others are checked."""

    def prepared(self, progress: Progress = lambda _: None) -> Any:
        """Return the bodies with what all cases with the same bodies share."""
        raise NotImplementedError

    def run_on(self, bodies: Any, progress: Progress = lambda _: None) -> RunResult:
        """Compute the case on bodies that are `prepared` for one that differs in `position_keys` only."""
        raise NotImplementedError

    def halved_sizes(self) -> dict[str, float]:
        """Return the inputs `HALVING` with values for half of the sizes; an `InputError` if none has a value."""
        given = {entry.name: entry.value for entry in entries_of(self) if entry.path[-1] in HALVING}
        if any(name.endswith("size_scale") for name in given):  # the other sizes are multiplied by it
            given = {name: value for name, value in given.items() if not name.endswith("size_mm")}
        factors = {name: HALVING[name.rpartition(".")[2]] for name in given}
        finer = {name: type(value)(value * factors[name]) for name, value in given.items() if value is not None}
        if not finer:
            raise InputError(
                f"the case {self.name} without {' and '.join(given) or 'one size of all its elements'}",
                f"a case with a value of one of: {', '.join(HALVING)}",
                "give the size" if given else "run it twice, with its sizes and with smaller ones",
            )
        return finer

    def columns(self) -> tuple[str, ...]:
        """Return the columns of a row of a campaign if they are known before it is computed."""
        return ()

    def patch_columns(self) -> tuple[str, ...]:
        """Return the columns of the table of patches of a campaign."""
        return ()

    def row(self, run: Any) -> dict[str, Any]:
        """Return the numbers of a run by columns of a row of a campaign: all single numbers of its summary."""
        return summary_numbers(run.summary)

    def patch_rows(self, run: Any) -> list[dict[str, Any]]:  # noqa: ARG002 (cases without patches)
        """Return the rows of a run in the table of patches of a campaign."""
        return []

    def warnings_of(self, run: Any) -> Sequence[str]:
        """Return what limits the results of a run."""
        return run.summary.get("warnings") or run.summary.get("notices") or ()

    @abstractmethod
    def run(self, progress: Progress = lambda _: None) -> RunResult:
        """Compute the case.

        Raises
        ------
        InputError
            If the inputs make no problem that can be solved.
        MissingLibraryError
            If the mesh generator lacks a shared library of the system.

        """


General = TypeVar("General", bound=RunnableCase)


class PresetCase(RunnableCase):
    """A case with a few inputs that stands for a general case; a template in the folder ``presets`` is its file."""

    @abstractmethod
    def general(self) -> RunnableCase:
        """Return the same as a general case; an `InputError` if the inputs do not go together."""

    def filled_in(self, kind: type[General]) -> General:
        """Return the general case of a kind that the template says, filled in with the inputs."""
        from flangeway.system.templates import templates  # noqa: PLC0415 (Jinja, which few cases need)

        template = templates("flangeway.cases", markup=False).get_template(f"presets/{self.name}.toml")
        return kind.from_values(toml_data(template.render(case=self, math=math), ""))

    def check(self) -> None:
        """See `RunnableCase.check`."""
        self.general().check()

    def run(self, progress: Progress = lambda _: None) -> Any:
        """See `RunnableCase.run`."""
        return replace(cast("Any", self.general().run(progress)), case=self)


# --- A case on its mesh and on the mesh with half of its sizes: how much each number changes.


@dataclass(frozen=True)
class Convergence:
    """Results with the sizes of a case and with half of them.

    - `case`: the case.
    - `sizes`: the inputs that were halved, or doubled if they are numbers of cells, with both values.
    - `runs`: both runs, that of the case first.
    """

    case: RunnableCase
    sizes: dict[str, tuple[float, float]]
    runs: tuple[RunResult, RunResult]

    @property
    def converged(self) -> bool:
        """Whether both runs converged."""
        return all(run.status.converged for run in self.runs)

    @property
    def numbers(self) -> dict[str, tuple[float, float]]:
        """Numbers of a row of a campaign by their keys, of both runs; those that only one of them has are left out."""
        coarse, fine = (self.case.row(run) for run in self.runs)
        return {
            key: (value, fine[key])
            for key, value in coarse.items()
            if type(value) is float and type(fine.get(key)) is float
        }

    def to_json(self) -> dict[str, Any]:
        """Return what ``converge.json`` holds: of each number both values and the change, metric."""
        names = ("value", "with_half_the_sizes")
        return {
            "sizes": {key: dict(zip(names, both, strict=True)) for key, both in self.sizes.items()},
            "numbers": {
                key: {**dict(zip(names, (a, b), strict=True)), "change": b - a} for key, (a, b) in self.numbers.items()
            },
            "status": [{"converged": run.status.converged, "message": run.status.message} for run in self.runs],
            "case": self.runs[0].summary["case"],
            "versions": self.runs[0].summary["versions"],
        }


def run_halved(case: RunnableCase, progress: Progress = lambda _: None) -> Convergence:
    """Run a case with its own sizes and with half of them, of all inputs in `HALVING`.

    It is an `InputError` if the inputs make no problem that can be solved, or half of a size is not allowed.
    """
    finer = case.halved_sizes()
    halved = case.from_values(with_settings(type(case), case.written, finer))
    halved.check()

    def run(of: RunnableCase, sizes: str) -> RunResult:
        return of.run(lambda sentence: progress(f"{sizes}: {sentence}"))

    runs = run(case, "given sizes"), run(halved, "half of the sizes")
    sizes = {entry.name: entry.value for entry in entries_of(case)}
    return Convergence(case, {name: (sizes[name], value) for name, value in finer.items()}, runs)
