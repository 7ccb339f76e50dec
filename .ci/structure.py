"""Counts how the code repeats itself and how its parts hang together: ``python .ci/structure.py``.

- repeated passages: runs of six lines of code that stand at several places of `src` and `studies`; blank lines,
  comments, docstrings, imports and lines of brackets do not count.
- imports between packages: pairs of packages of which one imports from the other, and the imports themselves.
- the way of `problem`: functions that hold the problem of a wheelset during its run, and those that return it.
"""

import ast
import sys
from collections import defaultdict
from pathlib import Path
from types import FrameType

ROOT = Path(__file__).parents[1]
LENGTH = 6


def sources(*folders: str) -> list[Path]:
    """Python files of some folders."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def code_lines(path: Path) -> list[str]:
    """Lines of code that count, without their indentation."""
    text = path.read_text(encoding="utf-8")
    skipped: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom) or (
            isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        ):
            skipped |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    lines = (line.partition("  # ")[0].strip() for n, line in enumerate(text.splitlines(), 1) if n not in skipped)
    return [line for line in lines if line.strip("()[]{},") and not line.startswith("#")]


def repeated(paths: list[Path]) -> list[tuple[str, list[str]]]:
    """First line of each passage that stands at several places, and the files; overlapping ones count once."""
    places: dict[tuple[str, ...], list[tuple[str, int]]] = defaultdict(list)
    for path in paths:
        lines = code_lines(path)
        for start in range(len(lines) - LENGTH + 1):
            places[tuple(lines[start : start + LENGTH])].append((path.relative_to(ROOT).as_posix(), start))
    found: list[tuple[str, list[str]]] = []
    seen: set[tuple[str, int]] = set()
    for passage, where in places.items():
        if len(where) > 1 and not all((file, start - 1) in seen for file, start in where):
            found.append((passage[0], [file for file, _ in where]))
        if len(where) > 1:
            seen |= set(where)
    return found


def package_of(module: str) -> str:
    """Package below `flangeway` of a module, or the module itself."""
    words = module.split(".")
    return ".".join(words[1:3]) if words[1:2] == ["railway"] else ".".join(words[1:2])


def imports(paths: list[Path]) -> dict[tuple[str, str], int]:
    """Number of imports of each pair of packages, from one to another."""
    counts: dict[tuple[str, str], int] = defaultdict(int)
    for path in paths:
        module = ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("flangeway."):
                pair = package_of(module), package_of(node.module or "")
                counts[pair] += pair[0] != pair[1]
    return {pair: number for pair, number in counts.items() if number}


def way_of_problem() -> tuple[set[tuple[str, str]], set[tuple[str, str]]]:
    """Functions, by file and name, that hold the problem of a plane wheelset in its run, and those that return it."""
    from flangeway.cases import load_case  # noqa: PLC0415 (all is loaded before the run is followed)
    from flangeway.railway.track.wheelset_problem import WheelsetProblem  # noqa: PLC0415

    case = load_case("wheelset-tangent", size_scale=8.0)
    held: set[tuple[str, str]] = set()
    returned: set[tuple[str, str]] = set()

    def follow(frame: FrameType, event: str, value: object) -> None:
        place = frame.f_code.co_filename, frame.f_code.co_qualname
        if event in ("call", "return") and "flangeway" in place[0]:
            if any(isinstance(local, WheelsetProblem) for local in frame.f_locals.values()):
                held.add(place)
            if event == "return" and isinstance(value, WheelsetProblem):
                returned.add(place)

    sys.setprofile(follow)
    try:
        case.run()
    finally:
        sys.setprofile(None)
    return held, returned


if __name__ == "__main__":
    passages = repeated(sources("src/flangeway", "studies"))
    pairs = imports(sources("src/flangeway"))
    held, returned = way_of_problem()
    for first, where in passages:
        print(f"  {first[:70]}: {', '.join(sorted(set(where)))}")
    print(f"repeated passages of {LENGTH} lines: {len(passages)}")
    print(f"imports between packages: {sum(pairs.values())} of {len(pairs)} pairs")
    files = {file for file, _ in held}
    print(
        f"`problem` of a wheelset in its run: {len(held)} functions in {len(files)} files, returned by {len(returned)}"
    )
