"""Texts from templates of Jinja that lie beside the modules that fill them."""

from collections.abc import Callable
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


def templates(package: str, *, markup: bool, **filters: Callable[..., Any]) -> Environment:
    """Return the templates in the folder of a package; in markup what is filled in is escaped."""
    environment = Environment(
        loader=PackageLoader(package, "."),
        autoescape=markup,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= filters
    return environment
