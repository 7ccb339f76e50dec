"""What users get wrong, through the command line, in one table: ``bad_inputs.toml`` beside this file.

Each row is a claim: what is run, the files that it reads, and what the message names: the argument that was given, and
the action that it advises. The names, numbers and commands of a row are compared, not the wording. What
the machine does, such as full disks, lack of memory and interruption, is in ``test_faults.py``; what libraries refuse
is beside the tests of what they accept.
"""

import functools
import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest

from flangeway.railway.profiles.bundled import rail, wheel

TABLE = tomllib.loads((Path(__file__).parent / "bad_inputs.toml").read_text(encoding="utf-8"))
ROWS = [(f"{about}: {name}", about, row) for about, rows in TABLE.items() for name, row in rows.items()]


def names(text):
    """Words of a text that name things: with digits, quotes or signs, such as keys, files, values, options, lines."""
    words = [word.strip(",;:()") for word in text.split()]
    return [word for word in words if re.search(r"[\d_=`'\"/\[<>-]|\w\.\w", word)]


def is_said(text, part):
    """Whether a part of a message has all names of a text; of a text without names, one of its words."""
    wanted = names(text)
    return all(word in part for word in wanted) if wanted else any(word in part for word in re.findall(r"\w{2,}", text))


def head():
    """Points of a new 136RE's head from its top."""
    profile = rail()
    return profile.running_surface.sampled(spacing=0.3) - [0.0, profile.outline.bounds()[1, 1]]


@functools.cache
def tread():
    """Points of a new AAR-1B's running surface."""
    return wheel().running_surface.sampled(spacing=0.3)


def lines(points):
    return "".join(f"{x:.5f} {y:.5f}\n" for x, y in points)


def looped():
    """A tread with a loop of 12 mm drawn into it."""
    points = tread()
    middle = len(points) // 2
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    loop = points[middle] + 6.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    return np.vstack((points[:middle], loop, points[middle:]))


def without(first, last):
    """A tread without what is between two places."""
    points = tread()
    return lines(points[(points[:, 0] < first) | (points[:, 0] > last)])


# files that are too long for the table
MADE = {
    "head.txt": lambda: lines(head()),
    "inch-head.csv": lambda: "\n".join(f"{x:.7f},{y:.7f}" for x, y in head() / 25.4),
    "tread.txt": lambda: lines(tread()),
    "mirrored.txt": lambda: lines(tread() * [-1.0, 1.0]),
    "looped.txt": lambda: lines(looped()),
    "gap.txt": lambda: without(-45.0, -15.0),
    "flange.txt": lambda: "# kind: wheel\n# origin: tape\n" + lines(tread()[tread()[:, 0] < -41.0]),
    "one.txt": lambda: "".join(f"{x:.4f}\n" for x in tread()[:, 0]),
    "novel.csv": lambda: "name,type,x0_mm,y0_mm,x1_mm,y1_mm\n" + "a,line," + "9" * 150_001 + "\n",
    "latin.toml": lambda: 'case = "h\xe9rtz"'.encode("latin-1"),
    "large.toml": lambda: "# a comment\n" * 500_000,
}


@pytest.fixture
def with_files(call, tmp_path):
    """Run a command with the files that its row has, or that it names and `MADE` knows; return those as well."""

    def run(command, files):
        words = shlex.split(command)
        wanted = {word.partition("=")[2] or word for word in words} & set(MADE)
        for name, content in {**{name: MADE[name]() for name in wanted}, **files}.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        before = sorted(tmp_path.rglob("*"))
        return *call(*words), before

    return run


@pytest.mark.parametrize(("about", "row"), [row[1:] for row in ROWS], ids=[row[0] for row in ROWS])
def test_what_is_wrong_is_told(about, row, with_files, tmp_path):
    """Status 2; what was given, what is allowed and what to do on stderr; nothing on stdout, no file left behind.

    Places that cannot be written are told before any work.
    """
    status, out, err, before = with_files(row["command"], row.get("files", {}))
    assert status == 2, err
    assert "Traceback" not in err
    assert err.count("flangeway: ") == 1
    if about == "machine":
        assert err.startswith("flangeway: ")
    parts = err[err.index("flangeway: ") :].removeprefix("flangeway: ").rstrip("\n").split("\n  ")
    assert len(parts) == 3, err
    if len(parts[2]) > 200:  # a long list comes last
        parts[1:] = parts[:0:-1]
    assert parts[1].startswith("allowed: ")
    assert parts[2].startswith("what to do: ")
    for part, key in zip(parts, ("given", "allowed", "advice"), strict=True):
        for words in row.get(key, []):
            assert is_said(words, part), (words, part)
    assert len(err) < 4000
    assert out == ""
    assert sorted(tmp_path.rglob("*")) == before


def test_a_message_about_another_argument_or_action_is_seen():
    """The comparison fails for another key, value, line or command, and holds for another wording."""
    assert is_said("line 9: supports[1] without a place", "case.toml, line 9: supports[1] without a position")
    assert not is_said("line 9: supports[1] without a place", "case.toml, line 8: supports[1] without a position")
    assert not is_said("leave young_MPa out to take 210000", "leave young_MPa out for the default 200000")
    assert not is_said("`flangeway init NAME` writes a case file", "choose another file")
    assert not is_said("correct the place", "leave it out")
