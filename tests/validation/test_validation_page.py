"""The page of validation: what is on it agrees with itself, and the command writes it."""

import csv
import re
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from flangeway.report.page.tables import SummaryTable
from studies import registry as reproductions
from studies.published_numbers import Reproduced, compare, digits, relative
from studies.registry import REPRODUCTIONS
from studies.reproduction import Chapter, PagePicture, Reproduction, section_text

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "validation.md").read_text(encoding="utf-8")
SECTIONS = {title: text for title, _, text in (part.partition("\n") for part in PAGE.split("\n## ")[1:])}


def rows_of(title):
    """Rows of all numbers of a part, as lists of their cells."""
    with (DOCS / "validation.csv").open(encoding="utf-8", newline="") as stream:
        return [row[1:] for row in csv.reader(stream) if row[0] == title]


def test_the_page_has_a_section_for_each_reproduction_in_order():
    """Sections are those of the reproductions, and the page names the command that writes it."""
    assert list(SECTIONS) == [each.chapter.title for each in REPRODUCTIONS.values()]
    assert "`flangeway reproduce all --quick --page docs/validation.md`" in PAGE.partition("## ")[0]


def test_counts_of_the_first_table_are_those_of_the_sections():
    """Numbers with a limit, those within and those shown only are as many as stand in each table of all numbers."""
    table = re.findall(r"^\| (.+?) \| (\d+) \| (\d+) \| (\d+) \| (.+?) \|$", PAGE.partition("## ")[0], re.MULTILINE)
    assert [title for title, *_ in table] == list(SECTIONS)
    for title, *counts, verdict in table:
        rows = rows_of(title)
        shown = sum("shown only" in row for row in rows)
        within = sum(row[-1] == "yes" for row in rows)
        assert list(map(int, counts)) == [len(rows) - shown, within, shown]
        assert f"{counts[1]} of {counts[0]} numbers with a limit are within" in SECTIONS[title]
        assert verdict == "passed"


@pytest.mark.parametrize("title", SECTIONS)
def test_each_difference_is_that_of_its_row(title):
    """Every difference is that of the computed and the published number beside it, in per cent or not as its limit."""
    checked = 0
    for row in rows_of(title):
        published, computed, difference, limit = row[2:6]
        if "<" in "".join(row[2:5]) or "e" in difference:
            continue
        assert not (difference.endswith(" %") and re.fullmatch(r"[\d.]+(e-\d+)?", limit))
        shown, apart = float(difference.removesuffix(" %")), float(computed) - float(published)
        if difference.endswith(" %"):
            shown, apart = shown / 100.0, apart / float(published)
        assert apart == pytest.approx(shown, abs=1.1e-3 * max(1.0, 1e-2 * abs(float(published))), rel=0.06), row
        checked += 1
    assert checked > 10


def test_what_is_not_within_has_its_reason():
    """Each number outside of its limit stands below its section's table once more, with a reason."""
    for title, text in SECTIONS.items():
        outside = [row for row in rows_of(title) if row[-1] == "**no**"]
        lines = re.findall(r"^- \*\*Not within:\*\* .+; (.+)$", text, flags=re.MULTILINE)
        assert len(lines) == len(outside)
        assert all(len(reason) > 20 for reason in lines)


def test_the_page_is_short():
    """The page has at most 10,000 words; what is longer is in the reports and in the CSV file."""
    assert len(PAGE.split()) <= 10_000


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (3e-15, "< 1e-10"), (252.0, "252"), (251.96, "252.0"), (1271.4, "1271"), (-4.5e-8, "-4.500e-8")],
)
def test_numbers_have_four_digits(value, text):
    """Whole numbers are shown in full, others with four digits, round-off as such."""
    assert digits(value) == text


@pytest.mark.parametrize(
    ("difference", "text"), [(1e-7, "< 0.001 %"), (0.113, "+11 %"), (-0.99999, "-100 %"), (3e-4, "+0.030 %")]
)
def test_differences_have_two_digits(difference, text):
    """Relative differences are per cents with their sign and two digits."""
    assert relative(difference) == text


@dataclass(frozen=True, eq=False, kw_only=True)
class Found(Reproduced):
    """What a made-up reproduction leaves."""

    seconds: float = 0.0


def number(code, published, computed, note="a | reason", words=None):
    """One number of Table 7 with a limit of 5 %."""
    return compare(7, code, "depth, left", "mm", (published, computed), 0.05, note, words=words)


NUMBERS = (number("A", 2.0, 2.02), number("B", 2.0, 2.5), number("C", 2.0, 4.0, "not comparable", ""))


def made_up(found, asked, *, brief=False):
    """A reproduction that computes nothing."""

    def compute(*, quick, progress):
        asked.append(quick)
        return found

    def draw(_):
        figure = Figure()
        figure.subplots().plot([0, 1], [1, 0])
        return figure

    table = SummaryTable("More", ("a",), (("b",),))
    chapter = Chapter("Title", "Some\ntext.", (PagePicture("drawn", "A line", draw),), lambda _: [table])
    return Reproduction(compute, chapter, {"line.png": draw}, {"more.csv": lambda _: [{"a": 0.1, "b": 2}]}, brief)


def test_a_section_shows_what_fails():
    """A number that is not within stands in bold with its reason; one without a limit has no verdict."""
    found = Found(numbers=NUMBERS)
    assert not found.passed
    text = section_text(made_up(found, []).chapter, found)
    assert "1 of 2 numbers with a limit are within; 1 more are shown only. **Not passed.**" in text
    assert "| Table 7: depth, mm | +25 % | 5 % | **1 of 2** |" in text
    assert "- **Not within:** Table 7: depth, left, mm, B, 2.500 for 2; a | reason" in text
    assert "- Shown only: Table 7: depth, left, mm, C, 4 for 2; not comparable" in text
    assert "\nSome text.\n" in text


def test_the_command_writes_page_pictures_and_a_summary(call, monkeypatch, tmp_path):
    """`all --page` writes the page with its pictures beside it, prints a line for each, and ends with their verdict."""
    asked = []
    one = made_up(Found(numbers=NUMBERS[::2]), asked)
    two = made_up(Found(numbers=NUMBERS[:2]), asked, brief=True)
    two = replace(two, chapter=replace(two.chapter, title="Second", pictures=()))
    monkeypatch.setattr(reproductions, "REPRODUCTIONS", {"one": one, "two": two})
    status, out, _ = call("reproduce", "all", "--quick", "--page", "pages/mine.md")
    assert status == 1
    assert asked == [True, False], "what takes seconds is whole"
    text = (tmp_path / "pages" / "mine.md").read_text(encoding="utf-8")
    assert "flangeway reproduce all --quick --page pages/mine.md" in text
    assert "| Title | 1 | 1 | 1 | passed |\n| Second | 2 | 1 | 0 | **not passed** |" in text
    assert re.search(r"one +1 +1 +1 +passed", out)
    assert re.search(r"two +2 +1 +0 +not passed", out)
    assert "two: NOT passed with 1 warning, 1 of 2 numbers with a limit are within" in out
    assert "Table 7: depth, left, mm, B, 2.500 for 2; a | reason" in out
    folder = tmp_path / "out" / "reproduce" / "one"
    assert (folder / "line.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "more.csv").read_text(encoding="utf-8") == "a,b\n0.1,2\n"
    assert len((folder / "table.csv").read_text(encoding="utf-8").splitlines()) == 3


def test_one_chapter_is_made_again(call, monkeypatch, tmp_path):
    """A page with one NAME has the chapter's new numbers, and its other chapters as they were; others are refused."""
    one, two = (made_up(Found(numbers=NUMBERS[::2]), []) for _ in range(2))
    two = replace(two, chapter=replace(two.chapter, title="Second", pictures=()))
    monkeypatch.setattr(reproductions, "REPRODUCTIONS", {"one": one, "two": two})
    assert call("reproduce", "all", "--page", "mine.md")[0] == 0
    before = (tmp_path / "mine.md").read_text(encoding="utf-8")
    assert call("reproduce", "two", "--page", "mine.md")[0] == 0
    assert (tmp_path / "mine.md").read_text(encoding="utf-8") == before
    new = replace(made_up(Found(numbers=NUMBERS[:2]), []), chapter=one.chapter)
    monkeypatch.setattr(reproductions, "REPRODUCTIONS", {"one": new, "two": two})
    assert call("reproduce", "one", "--page", "mine.md")[0] == 1
    after = (tmp_path / "mine.md").read_text(encoding="utf-8")
    assert "| Title | 2 | 1 | 0 | **not passed** |\n| Second | 1 | 1 | 1 | passed |" in after
    assert after.partition("## Second")[2] == before.partition("## Second")[2]
    assert after.partition("## Title")[0].splitlines()[:3] == before.splitlines()[:3]
    third = replace(one, chapter=replace(one.chapter, title="Third"))
    monkeypatch.setattr(reproductions, "REPRODUCTIONS", {"one": third, "two": two})
    assert call("reproduce", "one", "--page", "mine.md")[0] == 2


@pytest.mark.parametrize(("name", "page"), [("one", "mine.md"), ("all", "folder"), ("all", "file/mine.md")])
def test_a_page_that_cannot_be_is_refused_first(call, monkeypatch, tmp_path, name, page):
    """A page of one that does not exist, in the place of a folder or below a file is status 2 before any computing."""
    asked = []
    made = {key: made_up(Found(numbers=NUMBERS), asked) for key in ("one", "two")}
    monkeypatch.setattr(reproductions, "REPRODUCTIONS", made)
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    assert call("reproduce", name, "--page", page)[0] == 2
    assert asked == []
