"""A body that stands somewhere."""

from dataclasses import dataclass, field

from flangeway.geometry import Placement
from flangeway.problems.body import Body


@dataclass(frozen=True, eq=False)
class Part:
    """One instance of a body in space; a body may stand in several places, mirrored too.

    Parameters
    ----------
    name
        Name for messages and results.
    body
        The body.
    placement
        Where the body's frame stands.

    """

    name: str
    body: Body
    placement: Placement = field(default_factory=Placement)
