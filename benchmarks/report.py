"""``docs/performance.md`` from recorded measurements: no number in it is typed by hand."""

import json
import os
import platform
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmarks.measurement import NO_PEER, Measurement
from benchmarks.samples import ROOT

RECORDS = ROOT / "out" / "benchmarks"
PAGE = ROOT / "docs" / "performance.md"

HEAD = """# Performance

*Written by `python -m benchmarks report`; every number is from a run. Peers are installed by
`sh benchmarks/peers/install.sh`, each outside of the repository.*

All programs take turns on one machine and the fastest run of each counts. A ratio is the peer's time over flangeway's:
above 1, flangeway is faster. What each time holds and what an accuracy is the error of stands in the first lines of
`benchmarks/NAME.py`; both are relative errors unless said otherwise.
"""


def record(name: str, measurements: Sequence[Measurement], folder: Path = RECORDS) -> None:
    """Keep a benchmark's measurements with the machine, the load and the day."""
    folder.mkdir(parents=True, exist_ok=True)
    kept = {"machine": _machine(), "measurements": [measurement.record() for measurement in measurements]}
    (folder / f"{name}.json").write_text(json.dumps(kept, indent=1), encoding="utf-8")


def write(names: Sequence[str], folder: Path = RECORDS, page: Path = PAGE) -> Path:
    """Write the page from what is recorded of benchmarks, in the order of their names; return its path."""
    parts = [HEAD]
    for name in names:
        path = folder / f"{name}.json"
        if path.exists():
            parts.append(_section(name, json.loads(path.read_text(encoding="utf-8"))))
    page.write_text("\n".join(parts), encoding="utf-8")
    return page


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
        f"{cpu}, {os.cpu_count()} processors{memory}, {platform.system()} {platform.release()}, Python "
        f"{platform.python_version()}, {datetime.now(UTC):%Y-%m-%d}; load at the end {load}"
    )


def _section(name: str, kept: Mapping[str, Any]) -> str:
    rows = [
        f"## {name}",
        "",
        kept["machine"],
        "",
        "| work | peer | ours, s | peer, s | ratio | asked | our accuracy | peer's accuracy |",
        "|---|---|---|---|---|---|---|---|",
    ]
    rows += [_row(found) for found in kept["measurements"]]
    notes = [_note(number, found) for number, found in enumerate(kept["measurements"], start=1)]
    return "\n".join([*rows, "", *[note for note in notes if note], ""])


def _row(found: Mapping[str, Any]) -> str:
    peer = found["peer"]
    version = found["versions"].get(peer, "")
    texts = [
        found["work"],
        "" if peer == NO_PEER else f"{peer} {version}".strip(),
        *(
            _number(found.get(name))
            for name in ("ours_s", "peer_s", "ratio", "asked", "ours_accuracy", "peer_accuracy")
        ),
    ]
    return "| " + " | ".join(texts) + " |"


def _note(number: int, found: Mapping[str, Any]) -> str:
    usual = set(Measurement("", NO_PEER, 1.0, None, None, None, asked=1.0).record())
    more = [f"{name} {_value(value)}" for name, value in found.items() if name not in usual]
    text = "; ".join(part for part in (found["note"], *more) if part)
    return f"{number}. {text}" if text else ""


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_value(each)}" for name, each in value.items())
    return _number(value) if isinstance(value, float) else str(value)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"
