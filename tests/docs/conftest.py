"""Pages of the documentation, followed to the letter: files saved, commands and code run, outputs compared."""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

DOCS = Path(__file__).parents[2] / "docs"
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:e[+-]?\d+)?(?![\w.⁻])")
ROUND_OFF = 1e-8
"""Residual up to which a search goes on, below which it depends on the processor."""
FILE_BEFORE = re.compile(r"`([\w-]+\.\w+)`[^`]*\Z")
SHOWN = ("sh", "text", "python")
"""Kinds of blocks that are not saved as files."""


@dataclass(frozen=True)
class Block:
    """A block of code on a page.

    Parameters
    ----------
    kind
        Its language: ``"sh"``, ``"python"``, ``"text"`` and so on.
    text
        What it holds.
    file
        Name of the file that it is to be saved as, from the words before it.

    """

    kind: str
    text: str
    file: str | None


def blocks_of(page):
    """All blocks of a page of the documentation, in their order."""
    text = (DOCS / page).read_text(encoding="utf-8")
    found = []
    for block in re.finditer(r"^```(\w+)\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE):
        name = FILE_BEFORE.search(text[: block.start()])
        found.append(Block(block[1], block[2], name[1] if name and block[1] not in SHOWN else None))
    return found


def words_of(line):
    """What a line says without its numbers and without rules and signs."""
    return re.findall(r"[^\W\d_]+", NUMBER.sub(" ", line))


def agree(shown, printed, tolerance):
    """Whether the numbers of two lines agree to a part of each, to its last digit, or are both round-off."""
    pairs = list(zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=False))
    if len(NUMBER.findall(printed)) != len(NUMBER.findall(shown)):
        return False
    for given, found in pairs:
        digits, _, exponent = given.partition("e")
        last_digit = 10.0 ** (int(exponent or 0) - len(digits.partition(".")[2]))
        allowed = max(tolerance * abs(float(given)), 1.01 * last_digit, ROUND_OFF)
        if not abs(float(found) - float(given)) <= allowed:
            return False
    return True


def refuse_other_lines(shown, printed, tolerance):
    """Fail unless each line that is shown is printed: the same words, and numbers that agree."""
    for line in shown.splitlines():
        same = [other for other in printed.splitlines() if words_of(other) == words_of(line)]
        assert same, f"not printed: {line}"
        assert any(agree(line, other, tolerance) for other in same), f"shown: {line}\nprinted: {same}"


@pytest.fixture
def follow(call, tmp_path, capsys):
    """Follow a page from top to bottom in a folder of its own; return how many blocks of each kind were followed.

    Files are saved under the names that stand before them. Lines of the shell, and other blocks, with words to skip are
    left out. Every command ends with status 0, and what is shown after
    it is part of what it prints. Python blocks are one script, and what is shown after one is all that it prints.
    """

    def run(page, tolerance=0.02, skip=()):
        printed, of_python, done, names = "", False, {}, {}
        for block in blocks_of(page):
            lines = [line for line in block.text.splitlines() if not any(words in line for words in skip)]
            if not lines or (block.kind != "sh" and any(words in block.text for words in skip)):
                continue
            done[block.kind] = done.get(block.kind, 0) + 1
            if block.file is not None:
                (tmp_path / block.file).write_text(block.text, encoding="utf-8")
            elif block.kind == "sh":
                printed, of_python = "", False
                for line in lines:
                    program, *arguments = shlex.split(line, comments=True)
                    assert program.removeprefix(".venv/bin/") == "flangeway", line
                    status, out, err = call(*arguments)
                    assert status == 0, err
                    printed += out
            elif block.kind == "python":
                exec(compile(block.text, page, "exec"), names)
                plt.close("all")
                printed, of_python = capsys.readouterr().out, True
            elif block.kind == "text":
                refuse_other_lines(block.text, printed, tolerance)
                if of_python:
                    assert len(block.text.splitlines()) == len(printed.splitlines()), printed
        return done

    return run
