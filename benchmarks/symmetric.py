"""Random sparse symmetric systems: definite, indefinite, saddle points, integers, badly scaled, and singular ones.

`solve` must give the solution of matrices of a condition up to 1e8 to 1e-8 of its maximum value and refuse singular
ones; it may refuse others of a condition above 1e12. The reference is NumPy's dense solution, refined with residuals in
extended precision. Each matrix has a number: ``python -m benchmarks.symmetric FIRST COUNT`` prints those that fail.
"""

import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.linalg import LinAlgWarning

from benchmarks.measurement import NO_PEER, Measurement
from flangeway.errors import InputError
from flangeway.forms import solve
from flangeway.types import Floats

MAX_ERROR, MAX_CONDITION, SINGULAR_CONDITION = 1e-8, 1e8, 1e12
MAX_UNKNOWNS = 150
COUNT, QUICK_COUNT = 500, 60
N_REFINEMENTS = 4


def _symmetric(rng: np.random.Generator, n: int, *, integer: bool = False) -> Floats:
    density = min(1.0, rng.uniform(2.0, 9.0) / n)
    entries = rng.integers(-3, 4, (n, n)).astype(np.float64) if integer else rng.standard_normal((n, n))
    lower = np.tril(np.where(rng.random((n, n)) < density, entries, 0.0))
    return np.asarray(lower + np.tril(lower, -1).T)


def _definite(rng: np.random.Generator, n: int) -> Floats:
    root = _symmetric(rng, n)
    return np.asarray(root @ root + 10.0 ** rng.uniform(-6.0, 0.0) * np.eye(n))


def _shifted(rng: np.random.Generator, n: int) -> Floats:
    """A matrix with an eigenvalue close to zero: a condition of up to 1e8."""
    matrix = _symmetric(rng, n)
    values = np.linalg.eigvalsh(matrix)
    return np.asarray(matrix - (rng.choice(values) + 10.0 ** rng.uniform(-7.0, 0.0)) * np.eye(n))


def _saddle(rng: np.random.Generator, n: int, *, redundant: bool = False) -> Floats:
    """Constraints of a definite matrix, all unknowns in a random order."""
    stiffness, m = _definite(rng, n), int(rng.integers(2, n // 2 + 3))
    rows = np.where(rng.random((m, n)) < 3.0 / n, rng.standard_normal((m, n)), 0.0)
    rows[np.arange(m), rng.permutation(n)[:m] if m <= n else np.arange(m) % n] += 2.0
    if redundant:
        rows[0] = rows[1:].sum(axis=0)
    order = rng.permutation(n + m)
    return np.asarray(np.block([[stiffness, rows.T], [rows, np.zeros((m, m))]])[np.ix_(order, order)])


def _path(rng: np.random.Generator, n: int) -> Floats:
    """A chain with ones beside the diagonal, and a few on it."""
    matrix = np.diag(np.ones(n - 1), 1) + np.diag(np.ones(n - 1), -1)
    some = rng.integers(0, n, 2)
    matrix[some, some] = 1.0
    return matrix


def _scaled(rng: np.random.Generator, matrix: Floats, decades: float) -> Floats:
    scale = 10.0 ** rng.uniform(-decades, decades, len(matrix))
    return np.asarray(scale[:, None] * matrix * scale)


def _low_rank(rng: np.random.Generator, n: int) -> Floats:
    m = max(1, n - int(rng.integers(1, 4)))
    spread = np.where(rng.random((n, m)) < min(1.0, 4.0 / n), rng.standard_normal((n, m)), 0.0)
    return np.asarray(spread @ _symmetric(rng, m) @ spread.T)


def _laplacian(rng: np.random.Generator, n: int) -> Floats:
    weights = np.abs(_symmetric(rng, n))
    np.fill_diagonal(weights, 0.0)
    return np.asarray(np.diag(weights.sum(axis=1)) - weights)


def _repeated(rng: np.random.Generator, n: int) -> Floats:
    """An integer matrix whose last row is a sum of other ones, and so the last column."""
    matrix = _symmetric(rng, n, integer=True)
    combine = np.eye(n)
    combine[-1] = 0.0
    combine[-1, rng.integers(0, n - 1, 2)] = 1.0
    return np.asarray(combine @ matrix @ combine.T)


Generator = Callable[[np.random.Generator, int], Floats]

REGULAR: dict[str, Generator] = {
    "definite": _definite,
    "indefinite": _symmetric,
    "integer": lambda rng, n: _symmetric(rng, n, integer=True),
    "eigenvalue close to zero": _shifted,
    "saddle point": _saddle,
    "zero diagonal": lambda rng, n: (matrix := _symmetric(rng, n)) - np.diag(np.diag(matrix)),
    "badly scaled": lambda rng, n: _scaled(rng, _symmetric(rng, n), 3.0),
    "units": lambda rng, n: _symmetric(rng, n) * 10.0 ** rng.uniform(-12.0, 12.0),
    "path": _path,
}
SINGULAR: dict[str, Generator] = {
    "low rank": _low_rank,
    "repeated rows": _repeated,
    "Laplacian": _laplacian,
    "scaled Laplacian": lambda rng, n: _scaled(rng, _laplacian(rng, n), 3.0),
    "redundant constraints": lambda rng, n: _saddle(rng, n, redundant=True),
}


@dataclass(frozen=True)
class System:
    """A random matrix, shape (n, n), and a right-hand side, of a kind of `REGULAR` or `SINGULAR`."""

    kind: str
    matrix: Floats
    rhs: Floats

    @classmethod
    def of(cls, number: int) -> "System":
        """Return the system of a number; of each three two are of a regular kind."""
        rng = np.random.default_rng([49, number])
        kinds = SINGULAR if number % 3 == 2 else REGULAR
        kind = str(rng.choice(list(kinds)))
        matrix = kinds[kind](rng, int(rng.integers(3, MAX_UNKNOWNS)))
        return cls(kind, matrix, rng.standard_normal(len(matrix)))

    @property
    def condition(self) -> float:
        """Condition number in the 2-norm; infinite where the kind is a singular one."""
        return np.inf if self.kind in SINGULAR else float(np.linalg.cond(self.matrix))

    def reference(self) -> Floats:
        """Dense solution, refined in extended precision."""
        solution, matrix = (
            np.linalg.solve(self.matrix, self.rhs).astype(np.longdouble),
            self.matrix.astype(np.longdouble),
        )
        for _ in range(N_REFINEMENTS):
            solution += np.linalg.solve(self.matrix, np.asarray(self.rhs - matrix @ solution, dtype=np.float64))
        return np.asarray(solution, dtype=np.float64)

    def outcome(self) -> str:
        """``solved`` or ``refused`` where it is right, or what is wrong."""
        condition = self.condition
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", LinAlgWarning)
                solution = solve(sp.csr_array(self.matrix), self.rhs)
        except InputError:
            return "refused" if condition > SINGULAR_CONDITION else f"wrong: refused at a condition of {condition:.1e}"
        if np.isinf(condition):
            return "wrong: a singular matrix was solved"
        if condition <= MAX_CONDITION:
            reference = self.reference()
            error = float(np.abs(solution - reference).max() / np.abs(reference).max())
            return (
                "solved" if error <= MAX_ERROR else f"wrong: an error of {error:.1e} at a condition of {condition:.1e}"
            )
        return "solved"


def measurements() -> Iterator[Measurement]:
    """Outcomes of 500 systems."""
    yield _campaign(COUNT)


def quick() -> Iterator[Measurement]:
    """Outcomes of a few systems."""
    yield _campaign(QUICK_COUNT)


def _campaign(count: int) -> Measurement:
    start = time.perf_counter()
    outcomes = [System.of(number).outcome() for number in range(count)]
    wrong = {number: outcome for number, outcome in enumerate(outcomes) if outcome.startswith("wrong")}
    counts = Counter(outcome.split(":")[0] for outcome in outcomes)
    seconds = time.perf_counter() - start
    return Measurement(
        f"{count} random symmetric systems", NO_PEER, seconds, None, None, None, "with their dense solutions",
        more={"outcomes": dict(counts), "wrong": wrong},
    )  # fmt: skip


if __name__ == "__main__":
    first, number = int(sys.argv[1]), int(sys.argv[2])
    for case in range(first, first + number):
        result = System.of(case).outcome()
        if result.startswith("wrong"):
            print(case, System.of(case).kind, result, flush=True)
