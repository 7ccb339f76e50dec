"""Checks of the numbers that a user gives: a number is a number, not a text, not a truth value."""

import math
from collections.abc import Callable, Sequence
from inspect import signature
from numbers import Integral, Real
from types import UnionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flangeway.errors import InputError, short
from flangeway.types import Floats

MIN_POSITIVE, MAX_POSITIVE = 1e-100, 1e100
"""Limits of positive numbers, beyond any unit's choice: products of a few of them neither vanish nor overflow."""

MAX_COUNT = 2**31 - 1
"""Largest count: what numbers of points and cells can hold."""


def is_number(value: object) -> bool:
    """Whether a value is one real number, of Python or of NumPy, an array without axes included."""
    if isinstance(value, np.ndarray):
        return value.shape == () and value.dtype.kind in "iuf"
    return isinstance(value, Real) and not isinstance(value, bool)


def is_finite(value: object) -> bool:
    """Whether a value is one finite number."""
    try:
        return is_number(value) and math.isfinite(float(value))  # type: ignore[arg-type]
    except OverflowError:  # an integer of hundreds of digits
        return False


def are_finite(values: object, n: int) -> bool:
    """Whether values are a sequence or an array of n finite numbers."""
    if isinstance(values, np.ndarray):
        return values.shape == (n,) and all(map(is_finite, values))
    return isinstance(values, Sequence) and len(values) == n and all(map(is_finite, values))


def parsed_number(text: str) -> float:
    """Return the number that a text in a file means; a `ValueError` for 6_0, which `float` reads as 60."""
    if "_" in text:
        raise ValueError(f"{short(text)} is no number")
    return float(text)


def as_numbers(what: str, values: object, allowed: str = "numbers", advice: str = "correct them") -> Floats:
    """Return numbers in an array; texts, truth values, objects and rows of different lengths are an `InputError`."""
    try:
        kinds = {np.asarray(values).dtype.kind}
        if not isinstance(values, np.ndarray):  # a list of numbers and truth values becomes numbers
            kinds |= {"b" for value in np.asarray(values, dtype=object).flat if isinstance(value, bool | np.bool_)}
        if not kinds <= set("iuf"):
            raise TypeError("complex numbers" if kinds == {"c"} else "texts, truth values or objects")
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as reason:
        raise InputError(f"{what} that are not numbers: {reason}", allowed, advice) from reason


def check_finite(
    owner: str, name: str, value: object, allowed: str = "a finite number", advice: str = "correct the value"
) -> float:
    """Return a finite number as a float.

    Parameters
    ----------
    owner, name
        The class or function and its argument, for the message.
    value
        What was given.
    allowed, advice
        What the message says is allowed, and what to do.

    Raises
    ------
    InputError
        If the value is a text, a truth value, anything else that is not one number, or not finite.

    """
    if not is_finite(value):
        raise refused(owner, name, value, allowed, advice)
    return float(value)  # type: ignore[arg-type]


def check_positive(
    owner: str, name: str, value: object, allowed: str = "a positive number", advice: str = "correct the value"
) -> float:
    """Return a number from `MIN_POSITIVE` to `MAX_POSITIVE`; see `check_finite`."""
    number = check_finite(owner, name, value, allowed, advice)
    if number > 0.0 and not MIN_POSITIVE <= number <= MAX_POSITIVE:
        raise refused(owner, name, value, f"{allowed} from {MIN_POSITIVE:g} to {MAX_POSITIVE:g}", "choose other units")
    if number <= 0.0:
        raise refused(owner, name, value, allowed, advice)
    return number


def check_between(
    owner: str,
    name: str,
    value: object,
    low: float,
    high: float = math.inf,
    allowed: str = "",
    advice: str = "correct the value",
) -> float:
    """Return a number from `low` to `high`, both allowed; see `check_finite`. Without `allowed` the message gives them.

    An `InputError` if it is none.
    """
    allowed = allowed or f"{low:g}{' or more' if high == math.inf else f' to {high:g}'}"
    number = check_finite(owner, name, value, allowed, advice)
    if not low <= number <= high:
        raise refused(owner, name, value, allowed, advice)
    return number


def check_angle(owner: str, name: str, value: object) -> float:
    """Return an angle in radians of up to one turn: larger ones are taken for degrees."""
    angle = check_finite(owner, name, value, "a finite angle in radians", "correct it")
    if abs(angle) > 2.0 * np.pi:
        raise InputError(
            f"{owner}: {name}={short(value)}",
            "radians, from -2 pi to 2 pi",
            f"of degrees take np.deg2rad({angle:g}); for more than one turn take a path of several motions",
        )
    return angle


def are_all(values: object, kind: type) -> bool:
    """Whether values are a sequence whose items are all of a type."""
    return isinstance(values, Sequence) and all(isinstance(value, kind) for value in values)


def check_kind(owner: str, name: str, value: object, kinds: type | UnionType, allowed: str, advice: str) -> None:
    """Raise an `InputError` if a value is of another type than those that a function takes."""
    if not isinstance(value, kinds):
        raise refused(owner, name, value, allowed, advice)


def check_tolerance(owner: str, value: object) -> float:
    """Return a number between 0 and 1, both excluded; see `check_finite`."""
    if not (is_finite(value) and 0.0 < value < 1.0):  # type: ignore[operator]
        raise refused(owner, "tolerance", value, "a number between 0 and 1", "leave it out")
    return float(value)  # type: ignore[arg-type]


def check_integer(
    owner: str,
    name: str,
    value: object,
    least: int,
    most: int = MAX_COUNT,
    allowed: str = "",
    advice: str = "correct the value",
) -> int:
    """Return a whole number from `least` to `most`; 2.0 and True are none, see `check_finite`.

    Parameters
    ----------
    owner, name, value, allowed, advice
        As for `check_finite`; without `allowed` the message gives the limits.
    least, most
        Limits.

    """
    number = int(value) if isinstance(value, Integral) and is_number(value) else None
    if number is None or not least <= number <= most:
        upto = " or more" if most == MAX_COUNT and (number is None or number < least) else f" to {most}"
        raise refused(owner, name, value, allowed or f"a whole number, {least}{upto}", advice)
    return number


def refused(owner: str, name: str, value: object, allowed: str, advice: str) -> InputError:
    """The error of a value that is not allowed."""
    return InputError(f"{owner}({name}={short(value)})", allowed, advice)


def values_at(function: Callable[[Floats], Any], points: Floats) -> NDArray[Any]:
    """Values of a user's function at points (n, 2); `InputError` if it takes others, such as ``lambda x, y: ...``."""
    try:
        signature(function).bind(points)
    except TypeError as error:
        raise InputError(
            f"a function of other arguments than points: {error}", "one argument: points (n, 2)", "write lambda p: ..."
        ) from error
    except ValueError:  # no signature, as of some compiled functions
        pass
    return np.asarray(function(points))
