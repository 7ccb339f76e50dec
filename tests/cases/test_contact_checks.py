"""Contacts of any bodies are checked as those of wheelsets are."""

import re
from dataclasses import replace

import numpy as np
import pytest

from flangeway.cases import CASES
from flangeway.post import check_contact, cut_zones

NAMES = ["the contact"]


def found(motions=None, **changes):
    """Run of the disc on the block with other inputs of its contact, and another motion."""
    case = CASES["two-bodies"]
    values = {**case.example, "contacts": [{**case.example["contacts"][0], **changes}]}
    values["motions"] = motions or values["motions"]
    return case.from_values(values).run()


@pytest.fixture(scope="module")
def good():
    return found()


def test_a_good_contact_has_no_doubts(good):
    """The disc on the block of the case's example is converged, without errors and cut zones."""
    contact = good.contact
    checks = check_contact(contact.system, contact.state, good.patches, NAMES)
    assert good.status.converged
    assert checks.errors == ()
    assert cut_zones(contact.system, contact.state) == ()


@pytest.mark.parametrize(("body", "box"), [("block", "primary_box_mm")])
def test_a_zone_that_cuts_the_contact_is_told(body, box):
    """If the edges that may touch end within the contact, the note says that contact beyond is missing."""
    down = [{"body": "cylinder", "shift_mm": [0.0, -0.02]}]
    run = found(down, **{box: [-8.0, -1.0, 0.2, 2.0]})
    assert not any("end of the edges" in note for note in found(down).summary["notices"])
    assert any(note.startswith(f"{body}: there is contact at the end") for note in run.summary["notices"])


def test_segments_are_counted_by_order(good):
    """A patch of 7 constraints is 7 segments, which is reported as too few; 8 on a smooth ellipse are enough."""
    patch = good.patches[0]
    short = replace(patch, pressures=patch.pressures[:7])
    checks = check_contact(good.contact.system, good.contact.state, [short], NAMES)
    assert any("only 7 segments wide, fewer than 8" in warning for warning in checks.warnings)
    places = np.linspace(-1.0, 1.0, 10)[1:-1]
    smooth = replace(patch, pressures=100.0 * np.sqrt(1.0 - places**2))
    assert check_contact(good.contact.system, good.contact.state, [smooth], NAMES).warnings == ()


@pytest.mark.parametrize("pairing", ["segment-to-segment", "node-to-segment"])
def test_segments_of_order_2_are_counted_whole(pairing):
    """A contact reported as n segments wide has that width, though its constraints are at ends or at all nodes."""
    case = CASES["hertz"].from_values({"order": 2, "size_mm": 0.5, "pairing": pairing, "enforcement": "multiplier"})
    run = case.run()
    (patch,) = run.patches
    (told,) = (note for note in run.summary["notices"] if "wide, fewer than 8" in note)
    n_segments = float(re.search(r"only ([\d.]+) segments? wide", told)[1])
    lengths = run.contact.system.contacts[0].secondary.edge_lengths
    assert n_segments == pytest.approx(patch.width / lengths.min(), abs=0.6)
