"""A figure in US units: ticks at round numbers of the unit that an axis names there, and texts with new numbers."""

import re
from collections.abc import Sequence

import numpy as np
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import AutoLocator, Formatter, ScalarFormatter

from flangeway.units import NUMBER, TEXT_UNIT, UsUnit, in_us_units, number_of, us_unit

COLOUR_BAR = "<colorbar>"  # what matplotlib labels the axes of one with
OF_LABEL = re.compile(rf"(?:^|(?<= in )|(?<=, ))(?:in )?({TEXT_UNIT})(?=$|[\n,;:)])")
"""The unit in a text such as "x in mm", "depth, mm" or "MPa"."""


class UsLocator(AutoLocator):
    """Ticks at round numbers of a unit, on an axis in the metric one."""

    def __init__(self, unit: UsUnit) -> None:
        super().__init__()
        self.metric = float(unit.metric)

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Return places on the axis."""
        values = np.asarray(super().tick_values(vmin / self.metric, vmax / self.metric)) * self.metric
        return [float(each) for each in values]


class UsFormatter(Formatter):
    """Numbers of a unit beside ticks in the metric one, all with as many decimals as the finest needs."""

    def __init__(self, unit: UsUnit) -> None:
        self.metric = float(unit.metric)

    def __call__(self, x: float, pos: int | None = None) -> str:  # noqa: ARG002 (matplotlib's)
        """Return the number of one place, for the cursor of windows."""
        return f"{x / self.metric:.6g}"

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        """Return the numbers at the ticks."""
        numbers = np.asarray(values) / self.metric
        if not len(numbers) or not 1e-4 <= abs(numbers).max() < 1e6:
            return [f"{each:.4g}" for each in numbers]
        off = 1e-9 * float(abs(numbers).max())
        decimals = next((n for n in range(8) if np.allclose(numbers, numbers.round(n), rtol=0.0, atol=off)), 8)
        return [f"{each:z.{decimals}f}" for each in numbers]


def figure_in_us_units(figure: Figure) -> Figure:
    """Return a figure with its axes, and the texts with numbers and units, in US units.

    An axis without a label has the unit of those in its direction that have one, if they have the same. Bare numbers
    are converted in texts whose `gid` is a unit; then texts that name this unit are, too, as are titles of colour bars.
    """
    texts: list[Text] = figure.findobj(Text)
    given = {gid for text in texts if (gid := text.get_gid()) and us_unit(gid)}
    for direction, common in (("xaxis", figure.get_supxlabel()), ("yaxis", figure.get_supylabel())):
        every: list[tuple[Axis, bool]] = [(getattr(a, direction), a.get_label() == COLOUR_BAR) for a in figure.axes]
        names = {_unit(label) for label in (common, *(a.get_label_text() for a, bar in every if not bar)) if label}
        shared = min(names) if len(names) == 1 else ""
        given |= {shared} if common else {_unit(a.get_label_text()) for a, bar in every if bar}
        for axis, bar in every:
            _convert(axis, _unit(label) if (label := axis.get_label_text()) or bar else shared)
    for text in texts:
        words, unit = text.get_text(), us_unit(text.get_gid() or "")
        words = _numbers(words, unit) if unit else _renamed(in_us_units(words), given)
        if words != text.get_text():
            text.set_text(words)
    return figure


def _numbers(words: str, unit: UsUnit) -> str:
    values = [unit.of(number_of(each)) for each in re.findall(NUMBER, words)]
    shown = iter(f"{value:z.{int(abs(value) < 100.0)}f}" for value in values)
    return re.sub(NUMBER, lambda _: next(shown), words)


def _unit(label: str) -> str:
    """Unit that a text names, empty without one."""
    found = OF_LABEL.search(label)
    return found[1] if found else ""


def _renamed(words: str, units: set[str]) -> str:
    """Words with the unit that they name, if it is one of these, in US units."""
    found = OF_LABEL.search(words)
    unit = us_unit(found[1]) if found and found[1] in units else None
    if found is None or unit is None:
        return words
    return f"{words[: found.start(1)]}{unit.name}{words[found.end(1) :]}".replace(" in in", ", in").replace(",,", ",")


def _convert(axis: Axis, name: str) -> None:
    """Set ticks and label of an axis whose values have a metric unit; one with ticks of its own stays."""
    unit = us_unit(name)
    if unit is None or not isinstance(axis.get_major_formatter(), ScalarFormatter | UsFormatter):
        return
    # a colour bar of steps has a scale of its own, and no ticks across
    if axis.get_scale() not in ("linear", "function") or not len(axis.get_majorticklocs()):
        return
    axis.set_major_locator(UsLocator(unit))
    axis.set_major_formatter(UsFormatter(unit))
    axis.set_label_text(_renamed(axis.get_label_text(), {name}))
