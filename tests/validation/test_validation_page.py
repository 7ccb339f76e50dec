"""Rows, verdicts and pages of studies: what is on the page agrees with itself, and the command writes it."""

import csv
import re
from pathlib import Path

import pytest

from flangeway_studies import registry
from flangeway_studies.registry import STUDIES
from flangeway_studies.study import Limit, Row, Study

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "validation.md").read_text(encoding="utf-8")
SECTIONS = {title: text for title, _, text in (part.partition("\n") for part in PAGE.split("\n## ")[1:])}


def rows_of(title):
    """Rows of all numbers of a part, as lists of their cells."""
    with (DOCS / "validation.csv").open(encoding="utf-8", newline="") as stream:
        return [row[1:] for row in csv.reader(stream) if row[0] == title]


def test_the_page_has_a_section_for_each_study_in_order():
    """The page is short, and its first table counts the rows of each section."""
    assert list(SECTIONS) == [study.template[0] for study in STUDIES.values()]
    assert len(PAGE.split()) <= 10_000
    table = re.findall(r"^\| (.+?) \| (\d+) \| (\d+) \| (\d+) \| (.+?) \|$", PAGE.partition("## ")[0], re.MULTILINE)
    assert [title for title, *_ in table] == list(SECTIONS)
    for title, *counts, verdict in table:
        rows = rows_of(title)
        shown = sum("shown only" in row for row in rows)
        assert list(map(int, counts)) == [len(rows) - shown, sum(row[-1] == "yes" for row in rows), shown]
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
        digits_lost = 1.1e-3 if difference.endswith(" %") else max(1.1e-3, 6e-4 * abs(float(published)))
        assert apart == pytest.approx(shown, abs=digits_lost, rel=0.06), row
        checked += 1
    assert checked > 10


@pytest.mark.parametrize(
    ("published", "computed", "limit", "difference", "words", "within"),
    [
        (2.0, 2.02, 0.05, 0.01, "5 %", True),
        (2.0, 2.5, 0.05, 0.25, "5 %", False),
        (0.0, 0.04, 0.05, 0.04, "0.05", True),
        (2.0, 2.4, "0.5 mm", 0.2, "0.5 mm", True),
        (2.0, 1.4, "0.5 mm", -0.3, "0.5 mm", False),
        (2.0, 9.0, Limit("same sign", True), 3.5, "same sign", True),
        (2.0, 9.0, None, 3.5, "", None),
        (2.0, float("nan"), 0.05, None, "5 %", False),
    ],
)
def test_a_limit_is_relative_absolute_or_a_word(published, computed, limit, difference, words, within):
    """A number is of the relative difference, in words with a unit of the difference; None is no limit."""
    row = Row(7, "A", "depth", "mm", computed, published, limit)
    assert row.within is within
    assert (row.limit_words, row.cells["limit"]) == (words, words)
    if difference is not None:
        assert row.difference == pytest.approx(difference)


ROWS = (
    Row(7, "A", "depth, left", "mm", 2.02, 2.0, 0.05, "a | reason"),
    Row(7, "B", "depth, left", "mm", 2.5, 2.0, 0.05, "a | reason"),
    Row(7, "C", "depth, left", "mm", 4.0, 2.0),
)


@pytest.fixture
def made_up(monkeypatch, tmp_path):
    """Two studies in the place of the others: one that passes and one that does not; and what they were asked."""
    asked = []
    (tmp_path / "text").mkdir()
    monkeypatch.setattr("flangeway_studies.study.files", lambda _: tmp_path)

    def study(name, rows):
        (tmp_path / "text" / f"{name}.md").write_text(
            f"# {name.title()}\n\nSome\ntext to {{{{limit Table 7: depth}}}}.\n\n{{{{table}}}}\n"
            '\n![A line](line.png "x | y")\n'
        )

        def compute(run):
            asked.append((name, run.quick))
            run.curve("line", "panel", "computed", [0, 1], [1, 0])
            return rows

        return Study(name, compute)

    studies = {name: study(name, rows) for name, rows in (("one", ROWS[::2]), ("two", ROWS[:2]))}
    monkeypatch.setattr(registry, "STUDIES", studies)
    return asked


def test_the_command_writes_page_pictures_and_a_summary(call, made_up, tmp_path):
    """`all --page` writes the page, prints a line for each study, and ends with their verdict."""
    status, out, err = call("reproduce", "all", "--quick", "--page", "pages/mine.md")
    assert status == 1, err
    assert made_up == [("one", True), ("two", True)]
    text = (tmp_path / "pages" / "mine.md").read_text(encoding="utf-8")
    assert "flangeway reproduce all --quick --page pages/mine.md" in text
    assert "| One | 1 | 1 | 1 | passed |\n| Two | 2 | 1 | 0 | **not passed** |" in text
    assert "1 of 2 numbers with a limit are within. **Not passed.**" in text
    assert "| Table 7: depth, mm | +25 % | 5 % | **1 of 2** |" in text
    assert "- **Not within:** Table 7: depth, left, mm, B, 2.500 for 2; a | reason" in text
    assert "\nSome text to 5 %.\n" in text
    assert re.search(r"one +1 +1 +1 +passed", out)
    assert re.search(r"two +2 +1 +0 +not passed", out)
    folder = tmp_path / "out" / "reproduce" / "one"
    assert {path.name for path in folder.iterdir()} == {"line.png", "table.csv", "report.html", "summary.json"}
    rows = list(csv.DictReader((folder / "table.csv").read_text(encoding="utf-8").splitlines()))
    assert list(rows[0]) == [
        *("table", "code", "quantity", "unit", "published", "computed", "relative_difference", "limit", "within"),
        "note",
    ]
    assert [(row["computed"], row["limit"], row["within"]) for row in rows] == [("2.02", "5 %", "True"), ("4", "", "")]


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("three", ()),
        ("all", ("--page", "folder")),
        ("all", ("--page", "file/mine.md")),
        ("all", ("--out", "blocked")),
    ],
)
def test_what_cannot_be_written_is_refused_first(call, made_up, tmp_path, name, options):
    """A study that there is not, and a page or a folder in the way of something are status 2 before any computing."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    (tmp_path / "blocked").mkdir()
    (tmp_path / "blocked" / "two").write_text("")
    assert call("reproduce", name, *options)[0] == 2
    assert made_up == []
