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


def sentences(package: str, name: str, **values: Any) -> list[str]:
    """Return the sentences of a template that is filled in, one from each of its lines that is not empty."""
    lines = templates(package, markup=False).get_template(name).render(**values).splitlines()
    return [line.strip() for line in lines if line.strip()]
