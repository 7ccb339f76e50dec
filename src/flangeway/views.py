"""Registry of what shows results: `flangeway.report` makes pictures and HTML of results, and so imports them."""

from collections.abc import Callable
from typing import Any, Protocol


class Views(Protocol):
    """Functions that show results, such as those of `flangeway.report`."""

    def plot_result(self, result: Any, /, **options: Any) -> Any:
        """Draw a result, and return the figure."""

    def run_html(self, run: Any, /) -> str | None:
        """Return a run of a case as HTML for a notebook; None if its case has no report."""


_loaders: list[Callable[[], Views]] = []


def register_views(load: Callable[[], Views]) -> Callable[[], Views]:
    """Make a function that loads views the one that `views` calls."""
    _loaders[:] = [load]
    return load


def views() -> Views:
    """Return the registered views, loaded when they are first used."""
    return _loaders[0]()
