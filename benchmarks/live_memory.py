"""Resident memory of the live page's server over many positions, asked for as the page does.

``python -m benchmarks.live_memory [POSITIONS] [INPUT=VALUE...]`` starts ``flangeway live`` and asks for so many lateral
positions (1,000 if left out), each with the rigid contact of a yaw angle of its own. It prints the megabytes of the
server after 1, 2, 5, 10, 20, 50, 100, 200, ... positions, and ends with status 1 if they grow by more than a tenth
after the first tenth.
"""

import contextlib
import json
import random
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

from benchmarks.samples import ROOT

SEED = 49
LATERAL_MM, YAW_MRAD = 6.0, 3.0
MAX_GROWTH = 0.1


def main(count: int, settings: dict[str, str]) -> int:
    """Ask for positions, print the memory, and return the exit status."""
    command = [sys.executable, "-m", "flangeway", "live", "--no-browser"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT)
    try:
        assert server.stdout is not None
        address = next(word for line in server.stdout for word in line.split() if word.startswith("http://"))
        _wait_for(address)
        draw, memory, failed = random.Random(SEED), {}, 0
        for number in range(1, count + 1):
            lateral, yaw = draw.uniform(-LATERAL_MM, LATERAL_MM), draw.uniform(-YAW_MRAD, YAW_MRAD)
            inputs = settings | {"position.lateral_mm": f"{lateral:.3f}"}
            _ask(f"{address}geometry", inputs | {"position.yaw_mrad": f"{yaw:.3f}"})
            failed += not _ask(f"{address}position", inputs)["converged"]
            memory[number] = _resident_mb(server.pid)
            if number in {1, 2, 5, 10, 20, 50, count} or number % 100 == 0:
                print(f"{number} positions: {memory[number]:.0f} MB, {failed} not converged", flush=True)
    finally:
        server.terminate()
        server.communicate()
    early = max(megabytes for number, megabytes in memory.items() if number <= max(count // 10, 1))
    growth = max(memory.values()) / early - 1.0
    print(f"growth after the first tenth: {growth:.1%}, at most {MAX_GROWTH:.0%} allowed")
    return int(growth > MAX_GROWTH)


def _wait_for(address: str) -> None:
    """Wait until the server answers: its address is printed before."""
    for _ in range(600):
        with contextlib.suppress(urllib.error.URLError), urllib.request.urlopen(address, timeout=60):
            return
        time.sleep(0.1)


def _ask(address: str, inputs: dict[str, str]) -> dict[str, bool]:
    """Answer to inputs."""
    with urllib.request.urlopen(address, json.dumps(inputs).encode(), timeout=600) as response:
        answer: dict[str, bool] = json.load(response)
    return answer


def _resident_mb(process: int) -> float:
    status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    return int(status.split("VmRSS:")[1].split()[0]) / 1024.0


if __name__ == "__main__":
    numbers = [word for word in sys.argv[1:] if "=" not in word]
    pairs = dict(word.split("=", 1) for word in sys.argv[1:] if "=" in word)
    sys.exit(main(int(numbers[0]) if numbers else 1000, pairs))
