"""Small gaps between arcs are closed, comments are read or said not to be, the frame is true."""

import math

import pytest

from flangeway.errors import InputError
from flangeway.railway.profiles.bundled import rail, wheel
from flangeway.railway.profiles.profile_file import read_profile


def rounded_csv(digits, unit="mm", gap=0.0):
    """An S1002's lines and arcs, as a table would print them, the tread shifted up by a gap."""
    surface, scale = wheel("S1002").running_surface, {"mm": 1.0, "in": 25.4}[unit]
    rows = [f"# unit: {unit}", "# kind: wheel", "# origin: tape", "# up: yes", "name,type,x0,y0,x1,y1,xc,yc,turn"]
    for name, s in zip(surface.names, surface.segments, strict=True):
        ends = [(x / scale, (y + (gap if name == "tread_1:15" else 0.0)) / scale) for x, y in (s.start, s.end)]
        cells = [f"{c:.{digits}f}" for end in ends for c in end]
        if hasattr(s, "centre"):
            cells += [*(f"{c / scale:.{digits}f}" for c in s.centre), "left" if s.counter_clockwise else "right"]
        rows.append(",".join([name, "arc" if hasattr(s, "centre") else "line", *cells, *[""] * (7 - len(cells))]))
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize(("unit", "gap"), [("mm", 5e-4), ("mm", 9e-3), ("in", 5e-4)])
def test_small_gaps_are_closed_with_a_notice(unit, gap, tmp_path):
    """A gap of 0.0005 mm in a table of arcs is closed, which moves the surface by less than that, and is said."""
    path = tmp_path / "wheel.csv"
    path.write_text(rounded_csv(9, unit, gap), encoding="utf-8")
    found = read_profile(path)
    assert any("gaps between lines and arcs are closed" in each for each in found.notices)
    points = wheel("S1002").running_surface.sampled(spacing=1.0)
    assert found.surface.closest(points)[2].max() < 1.05 * gap
    for segment in found.surface.segments:
        if hasattr(segment, "centre"):
            radii = [math.dist(segment.centre, end) for end in (segment.start, segment.end)]
            assert radii[0] == pytest.approx(radii[1], rel=1e-12)


def test_wide_gaps_are_refused_with_their_limit(tmp_path):
    """A gap above the tolerance is no rounding and is refused."""
    path = tmp_path / "wheel.csv"
    path.write_text(rounded_csv(9, gap=0.05), encoding="utf-8")
    with pytest.raises(InputError, match=r"0\.05 from the end") as reason:
        read_profile(path)
    assert "0.01" in reason.value.allowed


def test_comments_are_read_without_a_colon_and_in_capitals(tmp_path):
    """``# unit in``, ``# Kind: Rail``, ``# MIRROR yes`` mean what they say; a wrong value is refused with its line."""
    points = rail("60E1").running_surface.sampled(spacing=0.5) - [0.0, 172.0]
    rows = "\n".join(f"{-x / 25.4:.6f} {y / 25.4:.6f}" for x, y in points)
    path = tmp_path / "rail.txt"
    path.write_text(f"# unit in\n# Kind: Rail\n# ORIGIN top\n# up yes\n# mirror: yes\n{rows}\n", encoding="utf-8")
    found = read_profile(path)
    assert (found.orientation.unit, found.kind, found.orientation.mirrored) == ("in", "rail", True)
    assert {found.orientation.how[key] for key in ("unit", "kind", "side", "origin")} == {"from the file"}
    path.write_text(f"# unit furlong\n{rows}\n", encoding="utf-8")
    with pytest.raises(InputError, match="furlong"):
        read_profile(path)
    path.write_text(f"# unit of length is inch\n# unit: in\n# the unit of this file\n{rows}\n", encoding="utf-8")
    unread = [each for each in read_profile(path).notices if "is not read" in each]
    assert len(unread) == 1
    assert "line 1" in unread[0]
