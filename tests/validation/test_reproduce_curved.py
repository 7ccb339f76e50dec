"""Curved edges beside chords: `flangeway reproduce curved`."""

import pytest

from studies.curved.curved_chapter import CURVED
from studies.curved.curved_reproduced import BODIES, ELEMENTS, error_rows, levels, reproduce_curved


@pytest.mark.ci
def test_errors_have_the_order_of_the_element_on_curved_edges(same_as_page) -> None:
    """All orders of convergence and stresses are as on the page, and within; every solution is a row of the file."""
    found = reproduce_curved()
    assert found.passed
    same_as_page(CURVED.chapter, found, whole=True)
    assert len(error_rows(found)) == sum(2 * len(levels(b, e)) for b in BODIES for e in ELEMENTS.values())
