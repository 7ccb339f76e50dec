"""Shared by the tests of this folder: a reproduction beside its section of the page of validation."""

import re
from pathlib import Path

import pytest

from studies.reproduction import section_text


@pytest.fixture(scope="session")
def same_as_page():
    """Compare a reproduction with its section of the page of validation; texts alike, numbers to their last digit.

    Where less was computed than the page shows, only the rows of all numbers are compared.
    """

    def compare(chapter, found, *, whole, page=None):
        page = page or (Path(__file__).parents[2] / "docs" / "validation.md").read_text(encoding="utf-8")
        section = page.partition(f"## {chapter.title}\n")[2].partition("\n## ")[0].strip()
        shown = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", section)
        fresh = section_text(chapter, found, shown).partition("\n")[2].strip()
        if whole:
            assert len(fresh.splitlines()) == len(section.splitlines())
            pairs = list(zip(section.splitlines(), fresh.splitlines(), strict=True))
        else:
            known, computed = (folded_rows(text) for text in (section, fresh))
            assert computed.keys() <= known.keys()
            pairs = [(known[key], line) for key, line in computed.items()]
        for line, again in pairs:
            assert NUMBER.split(line) == NUMBER.split(again)
            for number, value in zip(NUMBER.findall(line), NUMBER.findall(again), strict=True):
                assert abs(float(value) - float(number)) <= last_digit(number), f"{line}\n{again}"

    return compare


NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def last_digit(number):
    """What a change of the last digit makes; nothing for counts, and one for numbers of four digits."""
    mantissa, _, power = number.lstrip("+-").partition("e")
    whole, _, fraction = mantissa.partition(".")
    if not fraction and not power and len(whole) < 4:
        return 0.0
    return 1.01 * 10.0 ** (int(power or 0) - len(fraction))


def folded_rows(section):
    """Rows of the table of all numbers, by their quantity and code."""
    table = section.partition("<details")[2].partition("</details>")[0]
    rows = [line for line in table.splitlines() if line.startswith("| ")][2:]
    return {tuple(line.split(" | ")[:2]): line for line in rows}
