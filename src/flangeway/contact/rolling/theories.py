"""The theories of rolling with friction by name: the exact one and the fast ones."""

from collections.abc import Callable
from typing import Literal

from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.fast_theories import linear_theory, polach
from flangeway.contact.rolling.fastsim import fastrip, fastsim
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.contact.rolling.rolling_result import CreepForces

Theory = Literal["exact", "fastsim", "fastrip", "polach", "linear"]

FAST: dict[Theory, Callable[[RollingContact, Creepages], CreepForces]] = {
    "fastsim": fastsim,
    "fastrip": fastrip,
    "polach": polach,
    "linear": linear_theory,
}
"""Theories on an ellipse; the exact one is `flangeway.contact.rolling.exact_rolling.roll`."""
TITLES: dict[Theory, str] = {
    "exact": "exact theory",
    "fastsim": "FASTSIM",
    "fastrip": "FaStrip",
    "polach": "Polach",
    "linear": "linear theory",
}
WITH_TRACTIONS: tuple[Theory, ...] = ("exact", "fastsim", "fastrip")
"""Theories that give tractions, slip and states of the cells."""
