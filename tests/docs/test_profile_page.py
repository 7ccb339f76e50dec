"""The how-to on profiles, followed to the letter: its scripts and commands are run in order, its outputs compared."""

import re
from pathlib import Path

from flangeway.railway.profiles.profile_file import READABLE

TEXT = (Path(__file__).parents[2] / "docs" / "how-to" / "bring-your-profile.md").read_text(encoding="utf-8")


OF_ALL_COMMANDS = ("--quiet", "--json", "--no-pictures", "--units", "--xlsx")


def test_the_page_names_all_options_and_formats(call):
    """Each option of the command and each ending of a format is explained on the page."""
    _, shown, _ = call("profile", "--help")
    for option in set(re.findall(r"--[a-z-]+", shown)) - {"--help", "--out", *OF_ALL_COMMANDS}:
        assert f"`{option}" in TEXT or f" {option} " in TEXT, option
    for ending in READABLE:
        assert f"`{ending}`" in TEXT, ending
