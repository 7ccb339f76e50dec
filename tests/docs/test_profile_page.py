"""The how-to on profiles, followed to the letter: its scripts and commands are run in order, its outputs compared."""

import re
from pathlib import Path

from flangeway.railway.profiles import joining, profile_checks, smoothing
from flangeway.railway.profiles.profile_file import READABLE

TEXT = (Path(__file__).parents[2] / "docs" / "how-to" / "bring-your-profile.md").read_text(encoding="utf-8")


OF_ALL_COMMANDS = ("--quiet", "--json", "--no-pictures", "--units", "--xlsx")


def test_the_page_runs_from_top_to_bottom(follow, tmp_path):
    """Every script and command of the page ends well, in its order, and prints the lines that the page shows."""
    assert follow("how-to/bring-your-profile.md") == {"python": 2, "sh": 7, "text": 2}
    assert {"worn_rail.csv", "S1002.prw", "S1002.whl"} <= {path.name for path in tmp_path.iterdir()}


def test_the_page_names_all_options_and_formats(call):
    """Each option of the command and each ending of a format is explained on the page."""
    _, shown, _ = call("profile", "--help")
    for option in set(re.findall(r"--[a-z-]+", shown)) - {"--help", "--out", *OF_ALL_COMMANDS}:
        assert f"`{option}" in TEXT or f" {option} " in TEXT, option
    for ending in READABLE:
        assert f"`{ending}`" in TEXT, ending


def test_the_numbers_of_the_page_are_the_programs():
    """Limits that the page tells are those of the program."""
    assert (joining.MIN_BLEND_MM, joining.MAX_BLEND_MM, joining.BLEND_FACTOR) == (1.0, 12.0, 4.0)
    assert (joining.MAX_GAP_MM, joining.MAX_RIM_GAP_MM) == (4.0, 15.0)
    assert (smoothing.USUAL_WAVELENGTH_MM, smoothing.NOISE_UM, smoothing.USUAL_LIMIT_UM) == (5.0, 0.02, 20.0)
    assert smoothing.ARC_TOLERANCE_MM == 2e-4
    assert profile_checks.SAME_MM == 0.01
    for words in (
        "4 mm",
        "at least 1 and at most 12 mm",
        "15 mm",
        "0.02 micrometres",
        "20 micrometres",
        "0.2 micrometres",
        "0.01 mm",
    ):
        assert words in " ".join(TEXT.split()), words
