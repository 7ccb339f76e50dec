"""A case on its mesh and on the mesh with half of its sizes: how much each number changes."""

from dataclasses import dataclass
from typing import Any

from flangeway.cases.case import Progress, Run, RunnableCase


@dataclass(frozen=True)
class Convergence:
    """Results with the sizes of a case and with half of them.

    - `case`: the case.
    - `sizes`: the inputs that were halved, or doubled if they are numbers of cells, with both values.
    - `runs`: both runs, that of the case first.
    """

    case: RunnableCase
    sizes: dict[str, tuple[float, float]]
    runs: tuple[Run, Run]

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
    halved = case.from_values({**case.model_dump(exclude_unset=True), **finer})
    halved.check()

    def run(of: RunnableCase, sizes: str) -> Run:
        return of.run(lambda sentence: progress(f"{sizes}: {sentence}"))

    runs = run(case, "given sizes"), run(halved, "half of the sizes")
    return Convergence(case, {key: (getattr(case, key), value) for key, value in finer.items()}, runs)
