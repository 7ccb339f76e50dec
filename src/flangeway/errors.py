"""Errors that a user of flangeway can meet.

Every message says three things: what was given, what is allowed, and what to do next.
"""

LONGEST_VALUE = 80


def short(value: object) -> str:
    """Write a value for a message, cut where it is longer than `LONGEST_VALUE` characters."""
    try:
        text = repr(value)
    except ValueError:  # Python writes no integer of more than some thousands of digits
        return "a number of thousands of digits"
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + "..."


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
        super().__init__(f"{given}\n  allowed: {allowed}\n  what to do: {advice}")
        self.given = given
        self.allowed = allowed
        self.advice = advice

    def __reduce__(self) -> tuple[type, tuple[str, ...]]:
        """Parts, not the message made of them, so that another process can raise it."""
        return type(self), (self.given, self.allowed, self.advice)


class MissingLibraryError(FlangewayError):
    """A shared library of the system is missing; the message names the packages that bring it."""


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
        super().__init__(f"{given}\n  allowed: {allowed}\n  what to do: {self.advice}")
        self.given = given
        self.allowed = allowed

    def __reduce__(self) -> tuple[type, tuple[str, ...]]:
        """See `InputError.__reduce__`."""
        return type(self), (self.given, self.allowed)
