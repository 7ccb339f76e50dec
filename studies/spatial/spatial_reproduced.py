"""Bodies in three dimensions by plane problems: what ``flangeway reproduce spatial`` computes."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

from flangeway.contact.patch.patch_contact import PatchContact
from studies.published_numbers import Reproduced, Row
from studies.spatial.cosine_loads import ELEMENTS, BarRow, bar_numbers, bar_rows, revolution_numbers
from studies.spatial.patches import (
    HertzPatch,
    conforming_numbers,
    conforming_patches,
    hertz_numbers,
    hertz_patches,
)
from studies.spatial.point_loads import RailRow, meshed_rail, rail_numbers, rail_rows, square_numbers


@dataclass(frozen=True, eq=False, kw_only=True)
class SpatialReproduction(Reproduced):
    """Closed forms and published contacts in three dimensions computed again.

    Parameters
    ----------
    bars
        Bars under a cosine pressure.
    rails
        The rail on foundations.
    hertz
        Hertz's contacts.
    block
        The conforming blocks.

    """

    bars: tuple[BarRow, ...]
    rails: tuple[RailRow, ...]
    hertz: tuple[HertzPatch, ...]
    block: PatchContact

    @property
    def failures(self) -> tuple[str, ...]:
        """Contacts that did not converge."""
        contacts = {each.code: each.found for each in self.hertz} | {"block": self.block}
        return tuple(
            f"{code}: {found.status.message}" for code, found in contacts.items() if not found.status.converged
        )


def reproduce_spatial(*, quick: bool = False, progress: Callable[[str], None] = lambda _: None) -> SpatialReproduction:
    """Compute all parts; if `quick`, the finest mesh of short waves with the element of order 3 only."""
    start = time.perf_counter()
    bars: list[BarRow] = []
    for element in ELEMENTS:
        progress(f"bar under a cosine pressure, {element}")
        bars += bar_rows(element, quick=quick)
    progress("body of revolution")
    numbers = [*bar_numbers(bars), *revolution_numbers()]
    progress("square on a half-space")
    numbers += square_numbers()
    progress("rail on a foundation")
    rail = meshed_rail()
    rails = list(rail_rows(rail))
    numbers += rail_numbers(rail, rails)
    hertz = []
    for each in hertz_patches():
        progress(each.code)
        hertz.append(each)
        numbers += hertz_numbers(each)
    progress("conforming bodies")
    bodies, block = conforming_patches()
    numbers += conforming_numbers(bodies, block)
    return SpatialReproduction(
        bars=tuple(bars),
        rails=tuple(rails),
        hertz=tuple(hertz),
        block=block,
        numbers=tuple(numbers),
        seconds=time.perf_counter() - start,
    )


def bar_table(found: SpatialReproduction) -> list[Row]:
    """Rows of ``bar.csv``."""
    return [asdict(row) for row in found.bars]


def rail_table(found: SpatialReproduction) -> list[Row]:
    """Rows of ``rail.csv``."""
    return [asdict(row) for row in found.rails]
