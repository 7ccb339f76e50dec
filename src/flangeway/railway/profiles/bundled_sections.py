"""Sections that come with the package, by the names that ``flangeway section`` takes."""

import difflib

from flangeway.errors import InputError
from flangeway.formats import DrawnSection
from flangeway.geometry import Region, Section
from flangeway.railway.profiles.bundled import rail

BUNDLED = {
    "136RE": ("136RE", None),
    "136RE-8": ("136RE", 8.0),
    "136RE-10": ("136RE", 10.0),
    "136RE-14": ("136RE", 14.0),
    "60E1": ("60E1", None),
}
"""Rail and radius of its crown in inches by name; None for the usual one."""


def bundled_section(name: str) -> DrawnSection:
    """Return a bundled section; capital and small letters are the same.

    Raises
    ------
    InputError
        If there is none of that name; the message lists those there are.

    """
    found = {known.upper(): known for known in BUNDLED}.get(name.upper())
    if found is None:
        near = difflib.get_close_matches(name.upper(), BUNDLED, n=1, cutoff=0.5)
        raise InputError(
            f"a section called {name!r}",
            f"{', '.join(BUNDLED)}, or a file that ends with .toml, .csv or .dxf",
            f"did you mean {near[0]}?" if near else "give one of these names or a file",
        )
    rail_name, radius = BUNDLED[found]
    profile = rail(rail_name, crown_radius_in=radius)
    return DrawnSection(profile.title, Section({"section": Region(profile.outline)}), "mm", certainty=profile.certainty)
