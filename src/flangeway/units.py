"""US customary units beside the metric ones: of keys such as ``axle_load_kN``, and of numbers with a unit.

Numbers of tables, files, axes and inputs are converted; sentences have metric numbers in both systems.
Factors are exact: 1 in = 25.4 mm, 1 lb = 0.45359237 kg, standard gravity 9.80665 m/s² (NIST SP 811).
"""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any, Literal

from flangeway.checks import is_number

Units = Literal["metric", "us"]

_FOOT, _POUND = Fraction("0.3048"), Fraction("0.45359237")
_FORCE = _POUND * Fraction("9.80665")  # N in 1 lbf, and kN in 1 kip
_PRESSURE = _FORCE / Fraction("0.64516")  # MPa in 1 ksi, and GPa in 1 Msi

_BASE = {
    "km": ("mi", Fraction("1.609344")),
    "mm": ("in", Fraction("25.4")),
    "cm": ("in", Fraction("2.54")),
    "µm": ("mil", Fraction("25.4")),
    "m": ("ft", _FOOT),
    "kNm": ("kip_ft", _FORCE * _FOOT),
    "Nm": ("lbf_ft", _FORCE * _FOOT),
    "kN": ("kip", _FORCE),
    "N": ("lbf", _FORCE),
    "MPa": ("ksi", _PRESSURE),
    "GPa": ("Msi", _PRESSURE),
    "kg": ("lb", _POUND),
    "t": ("lb", _POUND / 1000),
}
"""Unit in the US, and how many metric ones it is."""
_WHOLE = {"km/h": ("mph", Fraction("1.609344")), "kg/m": ("lb/yd", _POUND / (3 * _FOOT))}
_ALIKE = ("mrad", "rad", "deg", "s", "h", "W", "J")  # in both systems
_POWERS = str.maketrans("⁰¹²³⁴⁵⁶⁻", "0123456-")

_NAME = "|".join(sorted((*_BASE, *_ALIKE), key=len, reverse=True))
_PART = rf"(?:{_NAME})(?:⁻?[²³⁴⁵⁶]|[2-6])?"
_TEXT_UNIT = rf"(?:1/)?{_PART}(?:[ /]{_PART})*"
_KEY_UNIT = re.compile(rf"_((?:per_)?{_PART}(?:_(?:per_)?{_PART})*)$")
_SPLIT = re.compile(rf"(^1/|^per_|^|/|_per_|_| )({_NAME})(⁻?[²³⁴⁵⁶]|[2-6])?")


@dataclass(frozen=True)
class UsUnit:
    """A key or unit in the US, and how many metric units it is."""

    name: str
    metric: Fraction

    def of(self, value: Any) -> Any:
        """Return a metric number, or each one in a list, in this unit; what is no number as it is."""
        return _each(value, 1 / self.metric)

    def to_metric(self, value: Any) -> Any:
        """Return a number of this unit, or each one in a list, in the metric one; what is no number as it is."""
        return _each(value, self.metric)


def _each(value: Any, factor: Fraction) -> Any:
    if isinstance(value, list | tuple):
        return type(value)(_each(part, factor) for part in value)
    # a float times a fraction is the nearest float of the exact product of both
    return float(Fraction(float(value)) * factor) if is_number(value) and math.isfinite(value) else value


@cache
def us_unit(unit: str) -> UsUnit | None:
    """Return the unit of a text such as "kN/mm" or "mm⁴" in the US; None if it is the same there, or no unit."""
    if not re.fullmatch(_TEXT_UNIT, unit):
        return None
    converted = _converted(unit)
    return None if converted is None else UsUnit(converted[0].replace("_", " "), converted[1])


@cache
def us_key(key: str) -> UsUnit | None:
    """Return what a key such as ``axle_load_kN`` is called in the US; None if it has no unit, or the same there."""
    unit = _KEY_UNIT.search(key)
    converted = _converted(unit[1]) if unit else None
    return None if unit is None or converted is None else UsUnit(f"{key[: unit.start(1)]}{converted[0]}", converted[1])


def unit_in(key: str) -> str:
    """Return the metric unit at the end of a key of an input as texts have it, ``N/mm`` of ``stiffness_N_mm``."""
    match = _KEY_UNIT.search(key)
    return match[1].replace("per_", "").replace("_", "/") if match else ""


def _converted(unit: str) -> tuple[str, Fraction] | None:
    slash = unit.replace("_", "/")
    if slash in _WHOLE:
        name, factor = _WHOLE[slash]
        return (name if unit == slash else name.replace("/", "_")), factor
    text, factor = "", Fraction(1)
    for separator, base, power in _SPLIT.findall(unit):
        name, metric = _BASE.get(base, (base, Fraction(1)))
        exponent = int(power.translate(_POWERS)) if power else 1
        factor *= metric ** (-exponent if separator not in ("", " ") else exponent)
        text += f"{separator}{name}{power}"
    return None if factor == 1 else (text, factor)


def metric_key(key: str, known: Iterable[str]) -> tuple[str, UsUnit | None]:
    """Return the metric one of the known keys that a key means, and the US unit that it has; else the key itself."""
    in_us = {unit.name: (name, unit) for name in known if (unit := us_key(name))}
    return in_us.get(key, (key, None))


def same_quantity(key: str, other: str) -> bool:
    """Whether two different keys are one quantity in both systems."""
    return any(unit is not None and unit.name == name for unit, name in ((us_key(key), other), (us_key(other), key)))
