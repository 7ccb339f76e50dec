"""A section as a file or a catalogue gives it: parts, unit of length, materials, and what was repaired."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from flangeway.checks import is_finite
from flangeway.errors import InputError, short
from flangeway.geometry.region import Section

UNITS = ("mm", "cm", "m", "in", "ft")  # units of length that a section can be given in; nothing is converted


@dataclass(frozen=True)
class PartMaterial:
    """Elastic material of a part.

    An `InputError` if a number is out of range.

    - `young_MPa`: Young's modulus, positive.
    - `poisson`: Poisson's ratio, above -1 and below 0.5.
    """

    young_MPa: float  # noqa: N815 (the unit megapascal)
    poisson: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not (is_finite(self.young_MPa) and self.young_MPa > 0.0):
            raise InputError(f"young_MPa = {short(self.young_MPa)}", "a positive number", "correct it")
        if not (is_finite(self.poisson) and -1.0 < self.poisson < 0.5):
            raise InputError(f"poisson = {short(self.poisson)}", "a number above -1 and below 0.5", "correct it")

    @property
    def shear_modulus_MPa(self) -> float:  # noqa: N802 (the unit megapascal)
        """``G = E / (2 (1 + nu))``."""
        return self.young_MPa / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True)
class DrawnSection:
    """What was read.

    An `InputError` if the unit is unknown, or some parts have a material and others none.

    - `title`: name to show.
    - `unit`: unit of length of all coordinates, one of `UNITS`.
    - `materials`: material of each part; empty for a section of one material.
    - `notices`: what was repaired or left out, in sentences.
    - `certainty`: how accurate the outline is, if its source says so.
    """

    title: str
    section: Section
    unit: str
    materials: Mapping[str, PartMaterial] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    certainty: str = ""

    def __post_init__(self) -> None:
        """Check unit and materials; keep a copy that cannot be changed."""
        refuse_unit(self.unit)
        missing = sorted(set(self.section.parts) - set(self.materials))
        if self.materials and missing:
            raise InputError(
                f"no material for {', '.join(missing)}",
                "young_MPa and poisson for every part, or for none",
                "add both for each part",
            )
        object.__setattr__(self, "materials", MappingProxyType(dict(self.materials)))


def refuse_unit(unit: str) -> None:
    """Raise `InputError` for an unknown unit of length."""
    if unit not in UNITS:
        raise InputError(f"unit of length {unit!r}", f"one of {', '.join(UNITS)}", "name the unit of the coordinates")


def agreed_unit(in_file: str | None, given: str | None, how: str) -> str:
    """Return the unit of a file, or the one given for a file that names none, which it can do as `how` says.

    An `InputError` if both differ, or there is neither.
    """
    if given is not None:
        refuse_unit(given)
    if in_file is not None and given is not None and in_file != given:
        raise InputError(
            f"unit {given} for a file in {in_file}",
            "the file's own unit",
            "leave the unit out; coordinates are never converted",
        )
    unit = in_file or given
    if unit is None:
        raise InputError(
            "coordinates without a unit of length",
            how,
            'add the unit to the file; or give unit = "mm" in the case, --unit mm to `flangeway section`',
        )
    refuse_unit(unit)
    return unit
