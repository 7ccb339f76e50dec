"""Inputs of friction that a rolling patch and a wheelset share: how it falls, what it warms, and surface layers."""

from typing import Annotated

import annotated_types as at
from pydantic import Field

from flangeway.cases.case import Case, Fraction, NotNegative, Positive
from flangeway.contact.rolling.flash_temperature import Heat, Heating
from flangeway.contact.rolling.friction import Friction, SlopeReduction
from flangeway.contact.rolling.theories import WITH_TRACTIONS, Theory
from flangeway.errors import InputError

# ruff: noqa: N815 (units in names)

MAX_FRICTION = 1.0
"""Upper bound of coefficients of friction: the driest steel on steel has 0.8, and shakedown limits end at 1."""
FrictionCoefficient = Annotated[float, at.Ge(0.0), at.Le(MAX_FRICTION)]
WARM_KEYS = ("friction_falls_from_C", "friction_falls_to_C")
THERMAL_KEYS = ("temperature_C", "conductivity_W_per_m_K", "density_kg_m3", "heat_capacity_J_per_kg_K")


FRICTION_KEYS = (
    *("kinetic_friction", "friction_decay_m_per_s", *WARM_KEYS, *THERMAL_KEYS),
    *("slope_factor", "slope_remaining", "slope_rate"),
)


class FrictionInputs(Case):
    """How friction depends on slip velocity and temperature, thermal properties, and the slope of creep forces."""

    kinetic_friction: FrictionCoefficient | None = None
    """coefficient at high slip velocity or temperature (default: friction)"""
    friction_decay_m_per_s: NotNegative = 0.0
    """slip velocity in which the difference of both falls to 1/e"""
    friction_falls_from_C: float | None = None
    """temperature of the contact in degrees Celsius from which friction falls to kinetic_friction, linearly"""
    friction_falls_to_C: float | None = None
    """temperature in degrees Celsius at which it has fallen"""
    temperature_C: float = 20.0
    """temperature of both bodies away from the contact, degrees Celsius"""
    conductivity_W_per_m_K: Positive = 50.0
    """thermal conductivity of both bodies"""
    density_kg_m3: Positive = 7850.0
    """their density"""
    heat_capacity_J_per_kg_K: Positive = 450.0
    """their specific heat capacity"""
    slope_factor: Fraction = 1.0
    """factor of the initial slope of creep forces, below 1 by layers on the surfaces (Spiryagin's k0)"""
    slope_remaining: float = Field(1.0, ge=0.0, le=1.0)
    """part of slope_factor that remains at large creepages (Spiryagin's alpha)"""
    slope_rate: NotNegative = 0.0
    """how fast it falls with creepage (Spiryagin's beta)"""

    def friction_law(self, static: float, theory: Theory) -> Friction:
        """Return the law of friction; an `InputError` names inputs without effect."""
        starts, ends = self.friction_falls_from_C, self.friction_falls_to_C
        if self.kinetic_friction is None:
            keys = ["friction_decay_m_per_s", *WARM_KEYS]
            self.refuse_without_effect(keys, "kinetic_friction", "a coefficient below friction")
        if (starts is None) != (ends is None):
            raise InputError("one of friction_falls_from_C and friction_falls_to_C", "both or none", "give both")
        if theory not in WITH_TRACTIONS:
            self.refuse_without_effect(WARM_KEYS, "rolling_theory", "exact, fastsim or fastrip")
        if self.slope_remaining == 1.0:
            self.refuse_without_effect(["slope_rate"], "slope_remaining", "a part below 1")
        body = Heat(self.temperature_C, self.conductivity_W_per_m_K, self.density_kg_m3, self.heat_capacity_J_per_kg_K)
        falls = None if starts is None or ends is None else (starts, ends)
        slope = SlopeReduction(self.slope_factor, self.slope_remaining, self.slope_rate)
        heating = Heating(body, body, falls)
        return Friction(static, self.kinetic_friction, self.friction_decay_m_per_s, heating, slope)
