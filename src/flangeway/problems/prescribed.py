"""Numbers and functions of the points that a user gives: loads, displacements, temperatures."""

from collections.abc import Callable, Sequence

import numpy as np

from flangeway.checks import are_finite, is_finite
from flangeway.errors import InputError, located, short
from flangeway.space.functions import at_points
from flangeway.types import Floats, floats

Scalar = float | Callable[[Floats], Floats]
"""A number, or a function of points (n, 2) with values (n,)."""
Vector = Sequence[float] | Floats | Callable[[Floats], Floats]
"""Two numbers, or a function of points (n, 2) with values (n, 2)."""


def check_scalar(owner: str, value: Scalar) -> None:
    """Refuse what is neither a finite number nor a function."""
    if callable(value):
        return
    if not is_finite(value):
        allowed = "a finite number, or a function of points (n, 2)"
        raise InputError(f"{owner} = {short(value)}", allowed, "correct the value")


def check_vector(owner: str, value: Vector) -> None:
    """Refuse what is neither two finite numbers nor a function."""
    if callable(value):
        return
    if not are_finite(value, 2):
        raise InputError(
            f"{owner} = {short(value)}",
            "two finite numbers, for x and y, or a function of points (n, 2)",
            "give both components, 0 for none",
        )


def scalar_at(owner: str, value: Scalar, points: Floats) -> Floats:
    """Values (n,) at points (n, 2); an InputError if a function fails to give finite numbers."""
    return _at(owner, value, points, (len(points),))


def vector_at(owner: str, value: Vector, points: Floats) -> Floats:
    """Values (n, 2) at points (n, 2); an InputError if a function fails to give finite numbers."""
    return _at(owner, value, points, (len(points), 2))


def _at(owner: str, value: Scalar | Vector, points: Floats, shape: tuple[int, ...]) -> Floats:
    if not callable(value):
        return np.broadcast_to(floats(value), shape)
    with located(f"{owner}: "):
        values = at_points(value, points.T).T
        if values.shape != shape:
            raise InputError(
                f"a function that gives shape {values.shape} for {len(points)} points",
                f"shape {shape}",
                "write it for points of shape (n, 2)",
            )
    return values
