"""``docs/performance.md`` from recorded measurements: no number in it is typed by hand."""

import inspect
import json
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmarks.measurement import NO_PEER, OWN, Measurement
from benchmarks.samples import ROOT

RECORDS = ROOT / "benchmarks" / "records"
PAGE = ROOT / "docs" / "performance.md"

HEAD = """# Performance

*Written by `python -m benchmarks report`; every number is from a run on the machine that its part names. Peers are
installed by `sh benchmarks/peers/install.sh`, each outside of the repository.*

All programs take turns on one machine, and the fastest run of each counts. Times are wall-clock seconds; what they hold
stands above each table. A *ratio* is the peer's time over flangeway's: above 1, flangeway is faster. A *goal* is the
least ratio that flangeway sets itself; where it is missed, the ratio is in bold. Accuracies are relative errors, ours
and the peer's for the same work. `python -m benchmarks report NAME` measures one part again and keeps the others.
"""

MISSING = "not measured"


def record(name: str, measurements: Sequence[Measurement], folder: Path = RECORDS) -> None:
    """Keep a benchmark's measurements with the machine, the load and the day."""
    folder.mkdir(parents=True, exist_ok=True)
    kept = {"machine": _machine(), "measurements": [measurement.record() for measurement in measurements]}
    (folder / f"{name}.json").write_text(json.dumps(kept, indent=1), encoding="utf-8")


def write(abouts: Mapping[str, str], folder: Path = RECORDS, page: Path = PAGE) -> Path:
    """Write the page from what is recorded.

    Parameters
    ----------
    abouts
        What each benchmark measures, by name, in the order of the page.
    folder, page
        Where the records are, and the page.

    Returns
    -------
    Path
        The page.

    """
    kept = {}
    for name in abouts:
        path = folder / f"{name}.json"
        if path.exists():
            kept[name] = json.loads(path.read_text(encoding="utf-8"))
    parts = [HEAD, _goals(kept), *(_section(name, abouts[name], found) for name, found in kept.items())]
    page.write_text("\n".join(parts), encoding="utf-8")
    return page


def _goals(kept: Mapping[str, Mapping[str, Any]]) -> str:
    """Table of all measurements with a goal."""
    rows = [
        (f"[{_title(name)}](#{name})", found["work"], _peer(found), _ratio(found), _number(found["asked"]))
        for name, benchmark in kept.items()
        for found in benchmark["measurements"]
        if found.get("asked") is not None
    ]
    return _table(("part", "work", "peer", "ratio", "goal"), rows) + "\n" if rows else ""


def _machine() -> str:
    cpu, memory = platform.machine(), ""
    information, sizes = Path("/proc/cpuinfo"), Path("/proc/meminfo")
    if information.exists():
        lines = information.read_text(encoding="utf-8").splitlines()
        cpu = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), cpu)
    if sizes.exists():
        memory = f", {int(sizes.read_text(encoding='utf-8').split()[1]) / 1024**2:.0f} GiB"
    load = ", ".join(f"{value:.1f}" for value in os.getloadavg())
    return (
        f"{cpu}, {os.cpu_count()} processors{memory}, {platform.system()}, Python "
        f"{platform.python_version()}, {datetime.now(UTC):%Y-%m-%d}; load at the end {load}"
    )


def _title(name: str) -> str:
    return name.replace("-", " ").capitalize()


def _section(name: str, about: str, kept: Mapping[str, Any]) -> str:
    measurements = kept["measurements"]
    own = measurements[0]["versions"] if measurements else {}
    versions = ", ".join(f"{program} {own[program]}" for program in OWN if program in own)
    head = ("work", "peer", "ours, s", "peer, s", "ratio", "goal", "our accuracy", "peer's accuracy")
    notes = [f"- {number}: {found['note']}" for number, found in enumerate(measurements, start=1) if found["note"]]
    parts = [
        f"## {_title(name)}",
        inspect.cleandoc(about).replace("``", "`"),
        f"{kept['machine']}; {versions}.",
        _table(("", *head), [(f"{number}", *_row(found)) for number, found in enumerate(measurements, start=1)]),
        "\n".join(notes),
        *_more(measurements),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, ["---"] * len(head), *rows))


def _row(found: Mapping[str, Any]) -> tuple[str, ...]:
    ours, asked, accuracies = found["ours_s"], found.get("asked"), (found["ours_accuracy"], found["peer_accuracy"])
    peer_s = "" if found["peer"] == NO_PEER else MISSING if found["peer_s"] is None else _number(found["peer_s"])
    return (
        found["work"], _peer(found), _number(ours), peer_s, _ratio(found), _number(asked), *map(_number, accuracies),
    )  # fmt: skip


def _peer(found: Mapping[str, Any]) -> str:
    """Return the peer with its version, if it was measured."""
    peer, measured = found["peer"], found["peer_s"] is not None
    return "" if peer == NO_PEER else f"{peer} {found['versions'].get(peer, '') * measured}".strip()


def _ratio(found: Mapping[str, Any]) -> str:
    """Return the ratio, in bold below its goal."""
    ratio, asked = found["ratio"], found.get("asked")
    missed = ratio is not None and asked is not None and ratio < asked
    return f"**{_number(ratio)}**" if missed else _number(ratio)


def _more(measurements: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Tables of what else was measured: one for all measurements with the same names, one for each that has parts."""
    usual = set(Measurement("", NO_PEER, 1.0, None, None, None, asked=1.0).record())
    groups: dict[tuple[str, ...], list[tuple[str, ...]]] = {}
    parts: dict[tuple[str, ...], list[tuple[str, ...]]] = {}
    for number, found in enumerate(measurements, start=1):
        more = {
            name.replace("asked", "goal").replace("_", " "): value for name, value in found.items() if name not in usual
        }
        for name, value in more.items():
            if isinstance(value, Mapping):
                keys = tuple(str(key).replace("_", " ") for key in value)
                parts.setdefault(keys, []).append((f"{number}", name, *map(_value, value.values())))
        plain = {name: _value(value) for name, value in more.items() if not isinstance(value, Mapping)}
        if plain:
            groups.setdefault(tuple(plain), []).append((f"{number}", *plain.values()))
    yield from (_table(("", *names), rows) for names, rows in groups.items())
    yield from (_table(("", "measured", *keys), rows) for keys, rows in parts.items())


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(map(_value, value))
    return _number(value) if value is None or isinstance(value, float) else str(value)


def _number(value: float | None) -> str:
    """Return a number with three digits."""
    if value is None:
        return ""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"
