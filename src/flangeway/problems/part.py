"""A placed body."""

from dataclasses import dataclass, field

from flangeway.geometry import Placement
from flangeway.problems.body import Body


@dataclass(frozen=True, eq=False)
class Part:
    """One instance of a body in space; a body may have several instances, mirrored too.

    Parameters
    ----------
    name
        Name for messages and results.
    body
        The body.
    placement
        Position of the body's frame.

    """

    name: str
    body: Body
    placement: Placement = field(default_factory=Placement)
