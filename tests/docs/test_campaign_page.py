"""The how-to on campaigns, followed to the letter, with a scheduler and workers that are processes of their own."""

import re
import runpy
import shlex
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flangeway import cli
from flangeway.campaign import results
from tests.processes import environment

TEXT = (Path(__file__).parents[2] / "docs" / "how-to" / "run-a-campaign.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(python|sh|text|toml|csv)\n(.*?)```", TEXT, flags=re.DOTALL)
FILES = iter(("shift.toml", "positions.csv", "measured.toml"))


@pytest.fixture
def background(tmp_path):
    """Start commands that the page starts in the background; they are ended at the end, workers of workers too."""
    started = []

    def run(line):
        program = shlex.split(line.rstrip("& \n").removeprefix(".venv/bin/"))
        assert program[0] == "dask"
        log = (tmp_path / f"{len(started)}.log").open("w")
        with log:
            started.append(
                subprocess.Popen(
                    [sys.executable, "-m", *program], stdout=log, stderr=log, cwd=tmp_path,
                    env=environment(),
                )
            )  # fmt: skip

    yield run
    for process in reversed(started):
        process.terminate()
    for process in started:
        process.wait(timeout=300)


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@pytest.mark.filterwarnings("ignore")  # of the cluster's libraries
def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch, capsys, background):
    """Every file, command and script of the page works, in its order; what it shows is printed."""
    pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("NO_COLOR", "1")
    port, printed, n_done = str(free_port()), "", 0
    for kind, block in BLOCKS:
        text = block.replace("8786", port)
        n_done += 1
        if kind in ("toml", "csv"):
            Path(next(FILES)).write_text(text, encoding="utf-8")
        elif kind == "python":
            Path("script.py").write_text(text, encoding="utf-8")
            runpy.run_path("script.py", run_name="__main__")
            printed = capsys.readouterr().out
        elif kind == "text":
            assert text in printed
        elif text.rstrip().endswith("&"):
            background(text)
            time.sleep(0.5)
        else:
            monkeypatch.setattr(sys, "argv", shlex.split(text))
            with pytest.raises(SystemExit) as caught:
                cli.main()
            printed, err = capsys.readouterr()
            assert caught.value.code == 0, err
    assert n_done == 11
    names = {path.name for path in (tmp_path / "out" / "shift").iterdir()}
    for name in re.findall(r"`((?:results|patches|campaign|contact|max|lateral|forces)[\w-]*\.\w+)`", TEXT):
        assert name in names, name
    table = results(tmp_path / "out" / "measured" / "campaign.sqlite")
    assert table.rows["rail"] == ["60E1", "60E1", "136RE"]
    assert min(table.numbers("right_max_pressure_MPa")) > 100.0
