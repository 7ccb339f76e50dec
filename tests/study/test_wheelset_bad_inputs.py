"""What users get wrong, through the command line: each ends with a clear message, or with a notice of what was assumed.

Each row of the tables is a claim: what is given, and the words by which the message says what was given, what is
allowed, and what to do.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flangeway.cli.app import app
from flangeway.railway.profiles import rail, wheel


def head():
    """Points of a new 136RE's head from its top."""
    profile = rail()
    return profile.running_surface.sampled(spacing=0.3) - [0.0, profile.outline.bounds()[1, 1]]


def tread():
    """Points of a new AAR-1B's running surface."""
    return wheel().running_surface.sampled(spacing=0.3)


def lines(points):
    return "".join(f"{x:.5f} {y:.5f}\n" for x, y in points)


def looped():
    """A tread with a loop of 12 mm drawn into it."""
    points = tread()
    middle = len(points) // 2
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    loop = points[middle] + 6.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    return np.vstack((points[:middle], loop, points[middle:]))


def with_nan():
    rows = lines(tread()).splitlines()
    rows[50] = "-40.0 nan"
    return "\n".join(rows)


def with_text():
    rows = lines(tread()).splitlines()
    rows[60] = "-20.5 abc"
    return "\n".join(rows)


def without(first, last):
    points = tread()
    return lines(points[(points[:, 0] < first) | (points[:, 0] > last)])


FILES = {
    "head.txt": lambda: lines(head()),
    "tread.txt": lambda: lines(tread()),
    "mirrored.txt": lambda: lines(tread() * [-1.0, 1.0]),
    "inches.txt": lambda: lines(tread() / 25.4),
    "looped.txt": lambda: lines(looped()),
    "gap.txt": lambda: without(-45.0, -15.0),
    "flange.txt": lambda: "# kind: wheel\n# origin: tape\n" + lines(tread()[tread()[:, 0] < -41.0]),
    "doubled.txt": lambda: lines(np.repeat(tread(), 2, axis=0)),
    "nan.txt": with_nan,
    "text.txt": with_text,
    "empty.txt": lambda: "",
    "binary.txt": lambda: bytes(range(256)) * 20,
    "one.txt": lambda: "".join(f"{x:.4f}\n" for x in tread()[:, 0]),
    "few.txt": lambda: lines(tread()[::120]),
    "occupied": lambda: "a file where a folder is wanted",
}


@dataclass(frozen=True)
class Wrong:
    """A command that is refused.

    Parameters
    ----------
    claim
        What is wrong with it.
    arguments
        The command line, words apart by blanks; what follows ``run`` is the case.
    given, allowed, advice
        Words of the message.

    """

    claim: str
    arguments: str
    given: str
    allowed: str
    advice: str


WRONG = [
    Wrong("a rail's file as the wheel", "wheelset-tangent --set wheel=head.txt",
          "wheel = head.txt, which holds a rail", "a wheel", "exchange the keys"),
    Wrong("a wheel's file as the rail", "wheelset-tangent --set rail=tread.txt",
          "rail = tread.txt, which holds a wheel", "a rail", "exchange the keys"),
    Wrong("bundled profiles exchanged", "wheelset-curve --set rail=S1002 --set wheel=60E1",
          "which is a", "136RE, 60E1", "exchange the keys"),
    Wrong("an unknown wheel", "wheelset-tangent --set wheel=S1003", "wheel 'S1003'", "'S1002'", "choose a wheel"),
    Wrong("a file that is not there", "wheelset-tangent --set wheel=gone.prw",
          "gone.prw: No such file", "can be read", "check the name"),
    Wrong("the body of a rail for a wheel", "wheelset-tangent --set wheel=tread.txt --set wheel_body=136RE",
          "wheel_body = 136RE", "AAR-1B, S1002", "needs the body of a wheel"),
    Wrong("an unknown body", "wheelset-tangent --set rail=head.txt --set rail_body=60E2",
          "rail_body = 60E2", "136RE, 60E1", "most like"),
    Wrong("a file in inches that does not say so", "wheelset-tangent --set wheel=inches.txt",
          "a profile of 6.9", "40 to 500 mm", "give --unit in"),
    Wrong("a curve that crosses itself when smoothed", "wheelset-tangent --set wheel=looped.txt",
          "meet at (", "does not meet itself", "clean the points there"),
    Wrong("a throat that was not measured", "wheelset-tangent --set wheel=gap.txt",
          "a gap of 32.8 mm from (-45.1", "only where the profile is straight", "measure it again"),
    Wrong("a flange alone, too short for the contact", "wheelset-tangent --set wheel=flange.txt",
          "too short for the contact", "at least from -40 to 20 mm", "flangeway profile flange.txt --join AAR-1B"),
    Wrong("too few points", "wheelset-tangent --set wheel=few.txt", "5 points", "10 or more", "hundreds of points"),
    Wrong("not a number in a file", "wheelset-tangent --set wheel=nan.txt", "line 51", "finite", "repair or remove"),
    Wrong("text where numbers should be", "wheelset-tangent --set wheel=text.txt",
          "line 61: '-20.5 abc'", "two numbers", "correct this line"),
    Wrong("an empty file", "wheelset-tangent --set wheel=empty.txt", "an empty file", "a profile", "was saved"),
    Wrong("a binary file", "wheelset-tangent --set wheel=binary.txt",
          "bytes that are no text", "a text file", "check the ending"),
    Wrong("one column only", "wheelset-tangent --set wheel=one.txt", "without points", "two numbers", "is whole"),
    Wrong("a gauge too small for the wheelset", "wheelset-tangent --set gauge_mm=1300",
          "do not touch the rails", "stand on the heads", "gauge_mm and back_to_back_mm"),
    Wrong("a gauge too large for the wheelset", "wheelset-tangent --set gauge_mm=1800",
          "do not touch the rails", "stand on the heads", "gauge_mm and back_to_back_mm"),
    Wrong("a negative gauge", "wheelset-tangent --set gauge_mm=-1435", "gauge_mm = '-1435'", "above 0", "1600"),
    Wrong("no load", "wheelset-tangent --set axle_load_kN=0", "axle_load_kN = '0'", "above 0", "presses on the rails"),
    Wrong("a load upwards", "wheelset-tangent --set axle_load_kN=-300",
          "axle_load_kN = '-300'", "above 0", "presses on the rails"),
    Wrong("a load that is no number", "wheelset-tangent --set axle_load_kN=nan",
          "axle_load_kN = 'nan'", "a number", "300"),
    Wrong("an infinite load", "wheelset-tangent --set axle_load_kN=inf", "axle_load_kN = 'inf'", "a number", "300"),
    Wrong("a load in newtons", "wheelset-tangent --set axle_load_kN=300000",
          "axle_load_kN = '300000'", "up to 100000", "300"),
    Wrong("a force that overturns", "wheelset-curve --set lateral_force_kN=200",
          "overturning", "L/V up to 0.4", "lower the lateral force"),
    Wrong("a force that no flange holds",
          "wheelset-curve --set lateral_force_kN=900 --set barycentre_height_mm=-400", "L/V", "", "lower"),
    Wrong("a speed without a radius", "wheelset-curve --set speed_km_h=70",
          "one of speed_km_h and curve_radius_m", "both or neither", "give the other"),
    Wrong("a force besides speed and radius",
          "wheelset-curve --set speed_km_h=70 --set curve_radius_m=400 --set lateral_force_kN=20",
          "lateral_force_kN with speed_km_h", "the force or both", "leave it out"),
    Wrong("two statements of the load", "wheelset-tangent --set car_mass_t=100 --set axle_load_kN=300",
          "axle_load_kN and car_mass_t", "one of both", "leave one out"),
    Wrong("a negative radius", "wheelset-curve --set speed_km_h=70 --set curve_radius_m=-400",
          "curve_radius_m = '-400'", "above 0", "leave curve_radius_m out"),
    Wrong("a superelevation to balance nothing", "wheelset-tangent --set superelevation_mm=from-speed",
          "from-speed without speed_km_h", "both", "or a height"),
    Wrong("a superelevation in another unit", "wheelset-curve --set superelevation_mm=900",
          "superelevation_mm = 900", "a fifth of the base", "3 cm is 30"),
    Wrong("a key that does not exist", "wheelset-tangent --set axel_load_kN=300",
          "an input called 'axel_load_kN'", "axle_load_kN", "did you mean axle_load_kN?"),
    Wrong("an incompressible steel", "wheelset-tangent --set poisson=0.5", "poisson = '0.5'", "below 0.5", "0.3"),
    Wrong("elements of order 3", "wheelset-tangent --order 3", "order = '3'", "up to 2", "leave order out"),
    Wrong("a crown that is not drawn", "wheelset-tangent --crown-radius 9", "9", "8, 10", "choose a radius"),
    Wrong("a folder below a file", "wheelset-tangent --out occupied/results", "occupied", "folder", "another folder"),
]  # fmt: skip


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Run the command line in a folder with the files of the table."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "110")
    monkeypatch.setenv("NO_COLOR", "1")

    def run(*arguments):
        for name in {word.partition("=")[2] or word.partition("/")[0] for word in arguments} & set(FILES):
            content = FILES[name]()
            Path(name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return CliRunner().invoke(app, list(arguments))

    return run


@pytest.mark.parametrize("wrong", WRONG, ids=[wrong.claim for wrong in WRONG])
def test_wrong_input_is_explained(wrong, invoke, tmp_path):
    """What was given, what is allowed and what to do are said on stderr, the exit status is 2, nothing is written."""
    result = invoke("run", *wrong.arguments.split())
    assert isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == 2, result.stderr
    message = result.stderr[result.stderr.index("flangeway: ") :]
    parts = message.removeprefix("flangeway: ").split("\n  ")
    assert len(parts) == 3, message
    assert wrong.given in parts[0]
    assert parts[1].startswith("allowed: ")
    assert wrong.allowed in parts[1]
    assert parts[2].startswith("what to do: ")
    assert wrong.advice in parts[2]
    assert "Traceback" not in message
    assert result.stdout == ""
    assert not (tmp_path / "out").exists()


NOTICES = [
    ("a mirrored wheel is turned round", "mirrored.txt", "left-hand wheel; it is mirrored"),
    ("a unit is assumed", "tread.txt", "The unit mm is assumed; --unit says another one."),
    ("doubled points are left out", "doubled.txt", "points nearer than 0.01 mm to the one before are left out"),
]


@pytest.mark.parametrize(("file", "notice"), [row[1:] for row in NOTICES], ids=[row[0] for row in NOTICES])
def test_what_was_assumed_is_said(file, notice, invoke):
    """A file that can be read with an assumption is read, and the assumption is printed as a note."""
    result = invoke("profile", file)
    assert result.exit_code == 0, result.stderr
    notes = " ".join(line for line in result.stdout.splitlines() if line.startswith("Note: "))
    assert notice in notes
    right = wheel().outline.bounds()[:, 0]
    assert f"{file.partition('.')[0]}" in result.stdout
    assert right[0] < 0.0 < right[1]


def test_there_are_more_than_twenty_cases():
    """At least twenty different mistakes are told apart, no two messages of the table alike."""
    assert len({(wrong.given, wrong.arguments) for wrong in WRONG}) == len(WRONG)
    assert len(WRONG) + len(NOTICES) >= 20
