"""Shared by the tests of this folder: a reproduction beside its section of the page of validation."""

import csv
import re
from pathlib import Path

import pytest

from studies.published_numbers import numbers_table
from studies.reproduction import section_text


@pytest.fixture(scope="session")
def same_as_page():
    """Compare a reproduction with its section of the page of validation; texts alike, numbers to their last digit.

    Where less was computed than the page shows, only the rows of all numbers are compared.
    """

    def compare(chapter, found, *, whole, page=None):
        page = page or (Path(__file__).parents[2] / "docs" / "validation.md").read_text(encoding="utf-8")
        section = page.partition(f"## {chapter.title}\n")[2].partition("\n## ")[0].strip()
        fresh = section_text(chapter, found).partition("\n")[2].strip()
        known, computed = rows_of(chapter.title), {row[:2]: row for row in numbers_table(found.numbers).rows}
        assert computed.keys() <= known.keys()
        pairs = [(" | ".join(known[key]), " | ".join(row)) for key, row in computed.items()]
        if whole:
            assert computed.keys() == known.keys()
            pairs += zip(section.splitlines(), fresh.splitlines(), strict=True)
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


def rows_of(title):
    """All numbers of a part of the page, as rows of cells by their quantity and code."""
    with (Path(__file__).parents[2] / "docs" / "validation.csv").open(encoding="utf-8", newline="") as stream:
        rows = [tuple(row[1:]) for row in csv.reader(stream) if row[0] == title]
    return {row[:2]: row for row in rows}
