"""Rails and wheels of cases by the names that users give: bundled ones, or files of running surfaces."""

from pathlib import Path

from flangeway.errors import InputError
from flangeway.railway.joining import joined
from flangeway.railway.profile_file import FORMATS, read_profile
from flangeway.railway.profiles import RailProfile, WheelProfile, rail, wheel


def rail_named(name: str, crown_radius_in: float | None, body: str) -> RailProfile:
    """Return a bundled rail, or a file's running surface on the body of a bundled one.

    Raises
    ------
    InputError
        If there is none of that name, or the file holds a wheel or cannot be read.

    """
    if not _is_file(name):
        return rail(name, crown_radius_in=crown_radius_in)
    found = joined(read_profile(name), body).profile
    if not isinstance(found, RailProfile):
        raise InputError(f"rail = {name}, which holds a wheel", "a rail", "exchange the keys rail and wheel")
    return found


def wheel_named(name: str, throat_radius_mm: float | None, body: str) -> WheelProfile:
    """Return a bundled wheel, or a file's running surface on the body of a bundled one; errors as `rail_named`."""
    if not _is_file(name):
        return wheel(name, throat_radius_mm=throat_radius_mm)
    found = joined(read_profile(name), body).profile
    if not isinstance(found, WheelProfile):
        raise InputError(f"wheel = {name}, which holds a rail", "a wheel", "exchange the keys rail and wheel")
    return found


def _is_file(name: str) -> bool:
    path = Path(name)
    return path.suffix.lower() in FORMATS or path.is_file()
