"""Bodies in three dimensions by plane problems: what ``flangeway reproduce spatial`` computes."""

from collections.abc import Iterator

from studies.spatial.cosine_loads import ELEMENTS, bar_rows, plane_strain_row, revolution_numbers
from studies.spatial.patches import conforming_rows, hertz_rows
from studies.spatial.point_loads import rail_rows, square_numbers
from studies.study import Row, Run


def rows(run: Run) -> Iterator[Row]:
    """Rows of all parts; if quick, the finest mesh of short waves is left out but for the element of order 3."""
    for element in sorted(ELEMENTS):
        yield from bar_rows(run, element)
    yield plane_strain_row()
    yield from revolution_numbers()
    yield from square_numbers()
    yield from rail_rows()
    yield from hertz_rows(run)
    yield from conforming_rows(run)
