"""A sample of mutants, programs with one changed operator or number, and how many of them the tests refuse.

``python -m benchmarks.mutants [NUMBER] [SEED] [PACKAGE...]``: each mutant runs the tests of its sub-package, without
those that take long. One JSON line each; the exit status is 1 where fewer than `LIMIT` of them fail their tests.
What survives is a defect of the tests, or a place where the change has no effect: it is to be read.
"""

import ast
import json
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.samples import ROOT

LIMIT = 0.6
"""Least part of the mutants that fail: what the first samples reached, rounded down."""
TIMEOUT_S = 600
"""A mutant whose tests take longer does not end, and counts as failed."""
OTHERS = {
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
"""What each operator becomes."""
BESIDE = ("exact", "patch")
"""Folders of tests that run for every package as well."""


@dataclass(frozen=True)
class Mutant:
    """A file with one change."""

    file: Path
    line: int
    change: str
    text: str


def mutants(file: Path) -> Iterator[Mutant]:
    """Yield all mutants of a file, one at a time."""
    source = file.read_text(encoding="utf-8")
    for number, node in enumerate(ast.walk(ast.parse(source))):
        if _change(node) is None:
            continue
        tree = ast.parse(source)
        changed = next(other for at, other in enumerate(ast.walk(tree)) if at == number)
        before = ast.unparse(changed)
        _apply(changed)
        yield Mutant(file, node.lineno, f"{before} -> {ast.unparse(changed)}", ast.unparse(tree))  # type: ignore[attr-defined]


def _change(node: ast.AST) -> ast.AST | float | None:
    """What the operator or number of a node becomes; None of other nodes."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in OTHERS:
        return OTHERS[type(node.ops[0])]()
    if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in OTHERS:
        return OTHERS[type(node.op)]()
    if isinstance(node, ast.Constant) and type(node.value) is float and node.value:
        return 1.5 * node.value
    return None


def _apply(node: ast.AST) -> None:
    """Change a node in its tree."""
    change = _change(node)
    if isinstance(node, ast.Compare):
        node.ops = [change]  # type: ignore[list-item]
    elif isinstance(node, ast.BinOp | ast.BoolOp):
        node.op = change  # type: ignore[assignment]
    elif isinstance(node, ast.Constant):
        node.value = change  # type: ignore[assignment]


def sample(number: int, seed: int, packages: tuple[str, ...]) -> Iterator[Mutant]:
    """Yield random mutants: files by chance, each with one of its changes."""
    chance = random.Random(seed)
    source = ROOT / "src" / "flangeway"
    files = [file for name in packages or ("",) for file in sorted((source / name).rglob("*.py"))]
    for _ in range(number):
        while not (found := list(mutants(chance.choice(files)))):
            pass
        yield chance.choice(found)


def is_found(mutant: Mutant) -> bool:
    """Whether a test of the mutant's package fails, in a copy of the sources that has the change."""
    inside = mutant.file.relative_to(ROOT / "src" / "flangeway")
    with TemporaryDirectory() as folder:
        copy = Path(folder) / "src"
        shutil.copytree(ROOT / "src", copy, ignore=shutil.ignore_patterns("__pycache__"))
        (copy / "flangeway" / inside).write_text(mutant.text, encoding="utf-8")
        paths = os.pathsep.join(map(str, (copy, ROOT / "studies", ROOT)))
        folders = [ROOT / "tests" / name for name in dict.fromkeys((*inside.parts[:1], *BESIDE))]
        command = [sys.executable, "-m", "pytest", "-x", "-q", *(str(one) for one in folders if one.is_dir())]
        try:
            done = subprocess.run(
                command, cwd=ROOT, env=os.environ | {"PYTHONPATH": paths}, timeout=TIMEOUT_S, capture_output=True,
                check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return True
        return done.returncode != 0


def main(arguments: list[str]) -> int:
    """Print a line a mutant, and at the end what part of them fails."""
    number, seed = (int(word) for word in (*arguments[:2], *("20", "0")[len(arguments[:2]) :]))
    found = []
    for mutant in sample(number, seed, tuple(arguments[2:])):
        found.append(is_found(mutant))
        where = f"{mutant.file.relative_to(ROOT)}:{mutant.line}"
        print(json.dumps({"at": where, "change": mutant.change, "found": found[-1]}), flush=True)
    part = sum(found) / len(found)
    print(json.dumps({"mutants": len(found), "found": part, "limit": LIMIT}))
    return int(part < LIMIT)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
