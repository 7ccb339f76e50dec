"""Values inside tables and lists."""

from collections.abc import Callable, Mapping
from typing import Any

from flangeway.types import Key


def mapped(value: Any, function: Callable[[Key, Any], Any], key: Key = ()) -> Any:
    """Return tables and lists with a function of path and value in the place of each value in them."""
    if isinstance(value, Mapping):
        return {name: mapped(inner, function, (*key, name)) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [mapped(inner, function, (*key, number)) for number, inner in enumerate(value)]
    return function(key, value)
