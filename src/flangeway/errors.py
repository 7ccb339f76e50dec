"""Errors that a user of flangeway can meet.

Every message says three things: what was given, what is allowed, and what to do next.
"""

import os
import re
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import date, time
from numbers import Number
from pathlib import Path, PurePath

MAX_LETTERS_OF_VALUE = 80
MAX_LETTERS_OF_LIST = 200
MAX_LETTERS_OF_WORD = 300
MAX_LETTERS_OF_PART = 3000  # of a message: as much as the longest list of keys
DEBUG_VARIABLE = "FLANGEWAY_DEBUG"
"""Environment variable that ``--debug`` sets for this process and its workers."""

_PLAIN = str.maketrans("", "", "<>")
_LONG = re.compile(
    rf"""\S{{{MAX_LETTERS_OF_WORD},}}|'[^'\n]{{{MAX_LETTERS_OF_WORD},}}'|"[^"\n]{{{MAX_LETTERS_OF_WORD},}}\""""
)


def short(value: object) -> str:
    """Write a value for a message as a user would, cut where it is longer than `MAX_LETTERS_OF_VALUE` characters."""
    try:
        text = _written(value)
    except ValueError:  # Python writes no integer of more than some thousands of digits
        return "a number of thousands of digits"
    return text if len(text) <= MAX_LETTERS_OF_VALUE else text[: MAX_LETTERS_OF_VALUE - 3] + "..."


def _cut(part: str) -> str:
    """A part of a message, cut where what a user wrote is longer than one reads: words, quoted texts, and the whole."""
    part = _LONG.sub(lambda long: f"{long[0][: MAX_LETTERS_OF_WORD - 3]}...", part)
    return part if len(part) <= MAX_LETTERS_OF_PART else f"{part[: MAX_LETTERS_OF_PART - 3]}..."


def _written(value: object) -> str:
    """Numbers, texts and what holds them; of other objects the class."""
    if hasattr(value, "tolist") and not isinstance(value, type):  # of NumPy
        value = value.tolist()
    if isinstance(value, list | tuple):
        inside = ", ".join(map(_written, value[:MAX_LETTERS_OF_VALUE]))
        return f"[{inside}]" if isinstance(value, list) else f"({inside}{',' * (len(value) == 1)})"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_written(key)}: {_written(item)}" for key, item in value.items()) + "}"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, date | time):
        return value.isoformat()
    if isinstance(value, str | bytes | Number | PurePath) or value is None:
        return repr(str(value) if isinstance(value, PurePath) else value)
    name = getattr(value, "__name__", None)
    return f"{type(value).__name__}(...)" if name is None else f"the {type(value).__name__} {name}".translate(_PLAIN)


class FlangewayError(Exception):
    """Base of all errors that flangeway raises on purpose."""


class InputError(FlangewayError):
    """The input is wrong: the command line ends with exit status 2.

    Parameters
    ----------
    given
        What was found, with the name of the argument and its value.
    allowed
        What would have been accepted.
    advice
        What to do next.

    """

    def __init__(self, given: str, allowed: str, advice: str) -> None:
        given, allowed, advice = map(_cut, (given, allowed, advice))
        parts = ["allowed: " + allowed, "what to do: " + advice]
        if len(allowed) > MAX_LETTERS_OF_LIST:  # nobody reads a page of keys before "did you mean"
            parts.reverse()
        self.lines = [given, *parts]
        super().__init__("\n  ".join(self.lines))
        self.given = given
        self.allowed = allowed
        self.advice = advice

    def __reduce__(self) -> tuple[type, tuple[str, ...]]:
        """Parts, not the message made of them, so that another process can raise it."""
        return type(self), (self.given, self.allowed, self.advice)


@contextmanager
def located(location: str, *, unless: str | None = None) -> Iterator[None]:
    """Put a place, such as ``contacts[1]: ``, before the message of an `InputError` of what is inside.

    - `unless`: a text that a message has which names its location already.
    """
    try:
        yield
    except InputError as reason:
        if unless is not None and unless in reason.given:
            raise
        raise InputError(location + reason.given, reason.allowed, reason.advice) from reason


class UnforeseenError(RuntimeError):
    """A defect of flangeway in another process; the message is the sentence of `unforeseen`."""


def unforeseen(error: BaseException) -> str:
    """Return one sentence on an internal error: what and where it is, and where to report it.

    With `DEBUG_VARIABLE` the traceback follows.
    """
    if isinstance(error, UnforeseenError):
        return str(error)
    package = Path(__file__).parent
    frames = [
        f"{Path(frame.f_code.co_filename).relative_to(package)}, line {line}"
        for frame, line in traceback.walk_tb(error.__traceback__)
        if Path(frame.f_code.co_filename).is_relative_to(package)
    ]
    why = " ".join(str(error).split())
    why = why if len(why) <= 2 * MAX_LETTERS_OF_VALUE else f"{why[: 2 * MAX_LETTERS_OF_VALUE]}..."
    sentence = (
        f"internal error, {type(error).__name__}{f' ({why})' if why else ''} in "
        f"{frames[-1] if frames else 'flangeway'}: please report it as an issue of the project flangeway, with the "
        "command, its files and what `flangeway --version` prints; --debug shows more"
    )
    if os.environ.get(DEBUG_VARIABLE):
        sentence += "\n" + "".join(traceback.format_exception(error)).rstrip()
    return sentence


class MissingLibraryError(FlangewayError):
    """A package or a shared library of the system is missing; the message says how to install it."""


class OutOfMemoryError(FlangewayError, MemoryError):
    """Work needs more memory than may be used: the command line ends with exit status 1.

    Parameters
    ----------
    given
        The work, and how much it needs.
    allowed
        How much may be used, and why not more.

    """

    advice = (
        "make the elements larger (size_scale, size_mm) or take order 1; close other programs, or allow more with "
        "--memory or FLANGEWAY_MEMORY_GB"
    )

    def __init__(self, given: str, allowed: str = "a computation for which this machine has memory") -> None:
        given = _cut(given)
        super().__init__(f"{given}\n  allowed: {allowed}\n  what to do: {self.advice}")
        self.given = given
        self.allowed = allowed

    def __reduce__(self) -> tuple[type, tuple[str, ...]]:
        """See `InputError.__reduce__`."""
        return type(self), (self.given, self.allowed)
