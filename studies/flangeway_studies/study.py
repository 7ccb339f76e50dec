"""What a study of ``flangeway reproduce`` is, and what becomes of it: ``table.csv``, report, chapter of a page.

A study is a function that yields rows, a text in ``text/NAME.md``, and a line of `registry.STUDIES`::

    def rows(run: Run) -> Iterator[Row]:
        found = solve(...)
        run.check("disc of 16 cells", found.status)              # a state that did not converge fails the study
        run.curve("pressure", "16 cells", "computed", x, found.pressures, "o")
        yield Row("Hertz", "16 cells", "force", "N", found.force, exact_force, 0.01)        # within 1 %

The text is Markdown: the title in its first line after ``# ``, what is compared with which source, and ``{{table}}``
where the verdict and the largest deviations go. ``{{limit TABLE: QUANTITY}}`` is replaced by the limits of the rows of
that table whose quantity begins so. Pictures are its last lines, with the labels of both axes, ``| logarithmic`` if
these are::

    ![Pressures on Hertz's curve](pressure.png "x in mm | pressure in MPa")

Published numbers are in ``data``; see `published_rows`.
"""

import re
import textwrap
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from importlib.resources import files
from itertools import cycle
from typing import TypeAlias

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from flangeway.cases.summary import plain_numbers
from flangeway.report.figures.drawing import SERIES, legend_below, panels
from flangeway.report.page.record import Again, Picture, Report, SummaryTable
from flangeway.results import ResultTable
from flangeway.solve import Status
from flangeway.system.file_content import packaged_rows
from flangeway.system.output_folder import text_writer, versions
from flangeway.types import Floats, Progress

ROUND_OFF = 1e-10  # numbers below it are shown as such, not with digits that change with the machine
MIN_CHANGE = 1e-5  # relative differences below it are shown as such
SHOWN_ONLY = "shown only"
Published: TypeAlias = dict[tuple[str, str], float]
"""Published values by code and quantity."""
TABLE = "table.csv"
COMPARED = ("published or exact", "computed", "difference", "limit", "within")
PICTURE = re.compile(r'^!\[(.+)\]\((\w+)\.png "(.+?) \| (.+?)( \| logarithmic)?"\)$', re.MULTILINE)
"""What it shows for those who do not see it, name, and labels of both axes of a picture of curves."""
PLAIN = r"\d[\d.]*(?:e-?\d+)?"  # a number of a limit without its unit


@dataclass(frozen=True)
class Limit:
    """A limit that is not the size of a difference."""

    words: str  # such as ``"same sign"``
    within: bool  # whether the number obeys it


@dataclass(frozen=True)
class Row:
    """A computed number beside the published one: a row of ``table.csv``."""

    table: int | str  # number of the published table, or a name such as ``"Figure 57"``
    code: str  # row of that table
    quantity: str  # what it is; what follows a comma tells several numbers of a code apart
    unit: str
    computed: float
    published: float = 0.0  # published or exact value
    limit: float | str | Limit | None = None
    """Limit of the relative difference, or of the computed number where zero is published; in words such as ``"0.5
    mm"``, of the difference; without one the number is shown only."""
    note: str = ""  # reading, or the reason for a difference

    def __post_init__(self) -> None:
        """Take NumPy's numbers as Python's."""
        for name in ("computed", "published"):
            object.__setattr__(self, name, float(getattr(self, name)))

    @property
    def difference(self) -> float:
        """``computed / published - 1``, or the computed number where zero is published."""
        return self.computed / self.published - 1.0 if self.published else self.computed

    @property
    def limit_words(self) -> str:
        """The limit in words; empty for a number that is shown only."""
        if isinstance(self.limit, float | int):
            return percent(self.limit) if self.published else f"{self.limit:g}"
        return self.limit.words if isinstance(self.limit, Limit) else self.limit or ""

    @property
    def within(self) -> bool | None:
        """Whether it is within its limit; None for a number that is shown only."""
        if isinstance(self.limit, Limit):
            return bool(self.limit.within)
        if isinstance(self.limit, str):
            return abs(self.computed - self.published) <= float(self.limit.split()[0])
        return None if self.limit is None else abs(self.difference) <= self.limit

    @property
    def cells(self) -> dict[str, object]:
        """What ``table.csv`` has of it, by column."""
        return {
            "table": self.table,
            "code": self.code,
            "quantity": self.quantity,
            "unit": self.unit,
            "published": self.published,
            "computed": self.computed,
            "relative_difference": self.difference,
            "limit": self.limit_words,
            "within": self.within,
            "note": self.note,
        }

    def named(self, *, kind: bool = False) -> str:
        """Return table, quantity and unit; of the kind, without what tells numbers of the same code apart."""
        numbered = isinstance(self.table, int)
        table = f"Table {self.table}" if numbered else f"{'Section ' * str(self.table)[0].isdigit()}{self.table}"
        quantity = (self.quantity.partition(", ")[0] if kind else self.quantity).replace("_", " ")
        unit = re.sub(r"\^([2-6])", lambda power: "²³⁴⁵⁶"[int(power[1]) - 2], self.unit)
        return f"{table}: {quantity}{'' if unit in ('', '1') else f', {unit}'}"

    def compared(self) -> tuple[str, str, str, str, str]:
        """Return the texts of `COMPARED`."""
        apart = self.computed - self.published
        if self.published == 0.0 or abs(apart) < ROUND_OFF:
            difference = digits(self.difference, 2)
        elif self.within is not None and re.fullmatch(PLAIN, self.limit_words):
            difference = f"{'+' * (apart > 0.0)}{digits(apart, 2)}"
        else:
            difference = relative(self.difference)
        within = "" if self.within is None else "yes" if self.within else "**no**"
        limit = _short(self.limit_words) or SHOWN_ONLY
        return _short(f"{self.published:.6g}"), digits(self.computed), difference, limit, within


@dataclass(frozen=True)
class Curve:
    """A line or points of a picture."""

    picture: str
    panel: str  # title of its panel
    label: str
    x: Floats
    y: Floats
    style: str  # line and marker as matplotlib has them


@dataclass
class Run:
    """What the rows of a study are computed with."""

    quick: bool = False  # whether to leave out what takes minutes
    progress: Progress = lambda _: None  # shows a sentence on long computations between two rows
    failures: list[str] = field(default_factory=list)  # sentences on what failed besides the numbers
    curves: list[Curve] = field(default_factory=list)

    def require(self, holds: bool, sentence: str) -> None:
        """Fail the study with a sentence if something does not hold that is no number of a row."""
        if not holds:
            self.failures.append(sentence)

    def check(self, name: str, status: Status) -> None:
        """Fail the study if a solution did not converge."""
        self.require(status.converged, f"{name}: {status.message}")

    def curve(self, picture: str, panel: str, label: str, x: ArrayLike, y: ArrayLike, style: str = "-") -> None:
        """Add a line, or points, to a panel of a picture; the same labels have the same colour in all panels."""
        self.curves.append(Curve(picture, panel, label, np.asarray(x, float), np.asarray(y, float), style))


@dataclass(frozen=True)
class Curves:
    """A picture of curves, a panel beside the other."""

    name: str  # its name in `Run.curve` and of its file
    alternative: str  # what it shows, for those who do not see it
    x: str  # label of the axis across
    y: str  # label of the axis up
    logarithmic: bool = False  # whether both axes are

    def draw(self, curves: Iterable[Curve]) -> Figure:
        """Draw those of the curves that are of this picture."""
        shown = [curve for curve in curves if curve.picture == self.name]
        titles = [*dict.fromkeys(curve.panel for curve in shown)]
        colours = dict(zip(dict.fromkeys(curve.label for curve in shown), cycle(SERIES), strict=False))
        columns = 2 if len(titles) == 4 else min(len(titles), 3)
        lines = -(-len(titles) // columns)
        figure, grid = panels(1.0 + 3.8 * columns, 0.9 + 3.2 * lines, lines, columns, sharex=True, sharey=True)
        for axes, title in zip(grid.flat, titles, strict=False):
            for curve in (curve for curve in shown if curve.panel == title):
                style = {"color": colours[curve.label], "ms": 3.5, "mfc": "white", "lw": 1.2}
                axes.plot(curve.x, curve.y, curve.style, label=curve.label, **style)
            if self.logarithmic:
                axes.set(xscale="log", yscale="log")
            axes.set_title(title, fontsize=10)
            axes.label_outer()
        figure.supxlabel(self.x, fontsize=9)
        figure.supylabel(self.y, fontsize=9)
        for axes in grid.flat[len(titles) :]:
            axes.set_axis_off()
        # a label has about 0.075 in for a letter, and 0.6 in for its line
        n_columns = max(1, int(figure.get_figwidth() / (0.6 + 0.075 * max(map(len, colours)))))
        legend_below(figure, n_columns, fontsize=9)
        return figure


@dataclass(frozen=True)
class Study:
    """A published problem computed again; see the head of this file."""

    name: str  # name for the command and of its text
    rows: Callable[[Run], Iterable[Row]]

    @property
    def template(self) -> tuple[str, str]:
        """Title, and text with its placeholders, without the pictures."""
        title, _, body = PICTURE.sub("", self._file).partition("\n")
        return title.removeprefix("# "), body.strip()

    @property
    def pictures(self) -> list[Curves]:
        """Pictures."""
        named = PICTURE.findall(self._file)
        return [Curves(name, words, x, y, bool(logarithmic)) for words, name, x, y, logarithmic in named]

    @property
    def _file(self) -> str:
        return (files("flangeway_studies") / "text" / f"{self.name}.md").read_text(encoding="utf-8")

    def compute(self, *, quick: bool = False, progress: Progress = lambda _: None) -> "Computed":
        """Compute its rows."""
        start, run = time.perf_counter(), Run(quick, progress)
        rows: list[Row] = []
        for row in self.rows(run):
            rows.append(row)
            progress(f"{len(rows)} numbers, the last: {row.named()}; {row.code}")
        return Computed(self, tuple(rows), tuple(run.failures), tuple(run.curves), time.perf_counter() - start)


@dataclass(frozen=True, eq=False)
class Computed:
    """A study that was computed."""

    study: Study
    rows: tuple[Row, ...]
    failures: tuple[str, ...]
    curves: tuple[Curve, ...] = field(repr=False)
    seconds: float  # wall-clock time

    @property
    def required(self) -> list[Row]:
        """Rows with a limit."""
        return [row for row in self.rows if row.within is not None]

    @property
    def passed(self) -> bool:
        """Whether nothing failed and all numbers with a limit are within."""
        return not self.failures and all(row.within for row in self.required)

    @property
    def counts(self) -> tuple[int, int, int]:
        """Numbers with a limit, those of them that are within, and numbers that are shown only."""
        required = self.required
        return len(required), sum(row.within is True for row in required), len(self.rows) - len(required)

    @property
    def verdict(self) -> str:
        """How many numbers are within their limits."""
        n_required, n_within, n_shown = self.counts
        shown = f"; {n_shown} more are shown only" if n_shown else ""
        return f"{n_within} of {n_required} numbers with a limit are within{shown}."

    @property
    def outside(self) -> list[str]:
        """A sentence on each number that is not within its limit."""
        return [
            _short(f"{row.named()}, {row.code}, {digits(row.computed)} for {row.published:.6g}; {row.note}")
            for row in self.required
            if not row.within
        ]

    @property
    def text(self) -> str:
        """The study's text with its limits, ``{{table}}`` in place."""

        def limits(name: re.Match[str]) -> str:
            words = [row.compared()[3] for row in self.required if row.named().startswith(name[1])]
            if not words:
                raise KeyError(f"{name[0]}, which is no row of {self.study.name}")
            return _range(words)

        return re.sub(r"\{\{limit (.+?)\}\}", limits, " ".join(self.study.template[1].split()))

    @property
    def chapter(self) -> str:
        """Its chapter of the page in Markdown: text, verdict, largest deviations, and what is not within."""
        words = f"{self.verdict} {'Passed.' if self.passed else '**Not passed.**'}"
        outside = "\n".join(f"- **Not within:** {line}" for line in (*self.outside, *self.failures))
        table = "\n\n".join(part for part in (words, self.deviations().markdown(), outside) if part)
        paragraphs = [textwrap.fill(part, 120) for part in self.text.split("{{table}}") if part]
        paragraphs.insert(1, table)
        return f"## {self.study.template[0]}\n\n" + "\n\n".join(paragraphs) + "\n"

    def deviations(self) -> SummaryTable:
        """Return the largest deviation of each quantity with a limit."""
        groups: dict[str, list[Row]] = {}
        for row in self.required:
            groups.setdefault(row.named(kind=True), []).append(row)
        lines = []
        for name, members in groups.items():
            # rounded, so that the choice among equals is the same on all machines
            worst = min(members, key=lambda row: (row.within, -round(abs(row.difference), 6)))
            within = f"{sum(row.within is True for row in members)} of {len(members)}"
            limit = _range([row.compared()[3] for row in members])
            lines.append((name, worst.compared()[2], limit, within if worst.within else f"**{within}**"))
        header = ("", "difference", "limit", "within")
        return SummaryTable("Largest deviation of each quantity", header, tuple(lines))

    def numbers(self) -> SummaryTable:
        """Return all numbers, one a row."""
        rows = tuple((row.named(), row.code, *row.compared()) for row in self.rows)
        return SummaryTable(f"All {len(rows)} numbers", ("quantity", "code", *COMPARED), rows)

    def record(self, command: str) -> Report:
        """Return what terminal and report show; `command` computes it again."""
        title, name = self.study.template[0], self.study.name
        n_required, n_within, n_shown = self.counts
        facts = [(f"{n_within} of {n_required}", "numbers with a limit within it")]
        return Report(
            name=name,
            title=title,
            subtitle="Computed numbers beside published or exact ones",
            converged=self.passed,
            success="passed",
            message=self.verdict,
            facts=facts + [(f"{n_shown}", "numbers shown only")] * bool(n_shown),
            results=self.deviations(),
            summary={
                "name": name,
                "title": title,
                "passed": self.passed,
                "failures": list(self.failures),
                "numbers": [plain_numbers(row.cells) for row in self.rows],
                "seconds": self.seconds,
                "versions": versions(),
            },
            again=Again(command, files=f"All numbers, for spreadsheets, are in `{TABLE}`."),
            assumptions=[self.text.replace(" {{table}}", "")],
            warnings=[*self.failures, *self.outside],
            pictures=lambda: [
                Picture(f"{picture.name}.png", partial(picture.draw, self.curves), f"{picture.alternative}.")
                for picture in self.study.pictures
                if any(curve.picture == picture.name for curve in self.curves)
            ],
            tables=[self.numbers()],
            timings_s={"total": self.seconds},
            files=lambda: {TABLE: text_writer(ResultTable.of_rows(row.cells for row in self.rows).csv(8))},
        )


def published_rows(name: str) -> list[dict[str, str]]:
    """Rows of a published table in ``data`` by column; lines that begin with ``#`` state the source."""
    return packaged_rows("flangeway_studies", name)


def published_values(name: str, case: str) -> Published:
    """Values of one case of a published table with the columns case, code, quantity and value, by code and quantity."""
    rows = published_rows(name)
    return {(row["code"], row["quantity"]): float(row["value"]) for row in rows if row["case"] == case}


def percent(limit: float) -> str:
    """Return a relative limit in words."""
    return f"{100.0 * limit:g} %"


def digits(value: float, n: int = 4) -> str:
    """Return a number with n significant digits, whole numbers with all of theirs; or that it is round-off."""
    if 0.0 < abs(value) < ROUND_OFF:
        return f"< {ROUND_OFF:g}"
    if abs(value) < 1e7 and (float(value).is_integer() or abs(value) >= 10.0 ** (n - 1)):
        return f"{value:.0f}"
    return _short(re.sub(r"\.(?=e|$)", "", f"{value:#.{n}g}"))


def relative(difference: float) -> str:
    """Return a relative difference in per cent with its sign and two digits, or that it is small."""
    if abs(difference) < MIN_CHANGE:
        return f"< {100.0 * MIN_CHANGE:g} %"
    return f"{'+' * (difference > 0.0)}{digits(100.0 * difference, 2)} %"


def _range(limits: Iterable[str]) -> str:
    """Different limits in words: from the least to the largest one, if all are numbers, or all in per cent."""
    words = [*dict.fromkeys(limits)]
    for kind in (PLAIN, f"{PLAIN} %"):
        if len(words) > 1 and all(re.fullmatch(kind, word) for word in words):
            words = sorted(words, key=lambda word: float(word.removesuffix(" %")))
            return f"{words[0]} to {words[-1]}"
    return " or ".join(words)


def _short(text: str) -> str:
    """Write 1e-09 as 1e-9."""
    return text.replace("e-0", "e-")
