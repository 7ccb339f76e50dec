"""Errors that a user of flangeway can meet.

Every message says three things: what was given, what is allowed, and what to do next.
"""


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


class MissingLibraryError(FlangewayError):
    """A shared library of the system is missing; the message names the packages that bring it."""
