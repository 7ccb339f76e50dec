"""Coulomb's friction, constant or falling with the slip velocity or the flash temperature."""

# ruff: noqa: N815 (units in names)
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

import annotated_types as at
import numpy as np
from pydantic import model_validator
from scipy.special import lambertw

from flangeway.checks import are_finite, as_numbers, check_finite
from flangeway.errors import InputError
from flangeway.records import Fraction, NotNegative, Pair, Positive, Record, refused_by_check
from flangeway.space.symmetric import EPS
from flangeway.types import Bools, Floats

# --- Flash temperature: how friction warms the surfaces of a contact that rolls.
#
# Heat flows into both bodies along their normals only, since it spreads slowly beside the speed of rolling: a point on
# the surface of a half-space that passes a source of the power q over area has the temperature
#
#     T(x) = T_0 + 1 / (b sqrt(pi V)) integral of q(xi) / sqrt(xi - x) d xi over what lies ahead of x,
#
# with the effusivity ``b = sqrt(conductivity density capacity)`` and the speed V (Carslaw and Jaeger, 1959, "Conduction
# of heat in solids", 10.7; Ertz and Knothe, 2002, Wear 253). Both bodies have the same temperature in contact, so that
# heat is divided as their effusivities are. The error falls with the Peclet number ``V a / (2 kappa)``: for steel, half
# a length a of 6 mm, and 1 m/s it is 210.


UNITS = 1e6 * np.sqrt(1e-3)
"""W/m² over N/mm² m/s, and the root of m over mm."""


class Heat(Record):
    """Thermal properties of a body; by default those of rail steel (Ertz and Knothe, 2002, at 20 degrees)."""

    temperature_C: float = 20.0
    """temperature of the body away from the contact, degrees Celsius"""
    conductivity_W_per_m_K: Positive = 50.0
    """thermal conductivity"""
    density_kg_m3: Positive = 7850.0
    """density"""
    capacity_J_per_kg_K: Positive = 450.0
    """specific heat capacity"""

    @property
    def effusivity(self) -> float:
        """Root of conductivity, density and capacity, W s^(1/2) / (m² K)."""
        return float(np.sqrt(self.conductivity_W_per_m_K * self.density_kg_m3 * self.capacity_J_per_kg_K))


@dataclass(frozen=True)
class Heating:
    """Two bodies that friction warms.

    Parameters
    ----------
    first, second
        Thermal properties; lengths of the contact are then in mm, pressures in MPa, and the speed in m/s.
    falls
        Temperatures from which friction falls, linearly, and at which it has its kinetic coefficient (as in CONTACT's
        law for friction that depends on temperature); None: it does not depend on temperature.

    Raises
    ------
    InputError
        If the second temperature is not above the first one.

    """

    first: Heat = field(default_factory=Heat)
    second: Heat = field(default_factory=Heat)
    falls: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.falls is not None and not (are_finite(self.falls, 2) and self.falls[0] < self.falls[1]):
            raise InputError(
                f"friction that falls between {self.falls} degrees",
                "two temperatures, a second temperature above the first one",
                "correct or exchange them",
            )

    @property
    def temperature(self) -> float:
        """Temperature of the contact without friction: that at which two bodies meet."""
        parts = self.first.effusivity, self.second.effusivity
        return (parts[0] * self.first.temperature_C + parts[1] * self.second.temperature_C) / sum(parts)

    def warming(self, ahead: Floats, speed: float) -> Floats:
        """Temperature rise over power density, K over N/mm² m/s, of sources that begin and end ahead.

        - `ahead`: distances to the end and to the beginning of the sources, mm, (2, ...); below 0 is behind.
        - `speed`: m/s, not 0.
        """
        begin, end = np.sqrt(np.maximum(ahead, 0.0))
        both = self.first.effusivity + self.second.effusivity
        return np.asarray(UNITS * 2.0 / (both * np.sqrt(np.pi * abs(speed))) * (end - begin))

    def on_strips(self, n_strips: int, strip: float, speed: float) -> Floats:
        """`warming` of the middles of strips by strips, which roll to +z: row i by column j, (n_strips, n_strips)."""
        distance = strip * (np.arange(n_strips) - np.arange(n_strips)[:, None])
        return self.warming(np.array([distance - strip / 2.0, distance + strip / 2.0]), speed)

    def rises(self, heat: Floats, strip: float, speed: float) -> Floats:
        """Temperature rise of cells by the frictional power over area, (n_cells, n_strips) each, K and W/mm².

        - `strip`: length of a cell along the track, mm; `speed`: m/s, negative: the patch rolls to -z.
        """
        ahead = heat if speed > 0.0 else heat[:, ::-1]
        rises = ahead @ self.on_strips(heat.shape[1], strip, speed).T
        return np.asarray(rises if speed > 0.0 else rises[:, ::-1])


# --- Coulomb's friction, constant or falling with the slip velocity or the temperature.


NOTICE_ABOVE = 1.0
"""Coefficient above which a notice is given."""


class SlopeReduction(Record):
    """Factor k by which layers on the surfaces lower the initial slope of creep forces: compliance in shear is 1/k.

    ``k = initial (remaining + (1 - remaining) / (1 + rate epsilon))`` with the gradient epsilon of the tractions where
    surfaces stick, ``initial pi G a b c s / (4 mu N)`` for the creepage s (Spiryagin, Polach and Cole, 2013, Vehicle
    System Dynamics 51; CONTACT's K0_MF, ALFAMF and BETAMF). At creepages s forces are those of k s, slip is that of k s
    over k.
    """

    initial: Fraction = 1.0
    """factor at small creepages (Spiryagin's k0)"""
    remaining: Annotated[float, at.Ge(0.0), at.Le(1.0)] = 1.0
    """part of it at large creepages (Spiryagin's alpha)"""
    rate: NotNegative = 0.0
    """how fast it falls with creepage (Spiryagin's beta)"""

    def factor(self, gradient: float) -> float:
        """The factor at a gradient epsilon."""
        return self.initial * (self.remaining + (1.0 - self.remaining) / (1.0 + self.rate * gradient))


MAX_FRICTION = 1.0
"""Upper bound of coefficients of friction: the driest steel on steel has 0.8, and shakedown limits end at 1."""
FrictionCoefficient = Annotated[float, at.Ge(0.0), at.Le(MAX_FRICTION)]


class FallingFriction(Record):
    """Friction that falls with the slip velocity or the temperature of the contact."""

    kinetic: FrictionCoefficient
    """coefficient at high slip velocity or temperature"""
    decay_m_per_s: NotNegative = 0.0
    """slip velocity in which the difference of both coefficients falls to 1/e"""
    between_C: Pair | None = None
    """temperatures of the contact in degrees Celsius from which friction falls to the kinetic one, linearly, and at
    which it has fallen"""

    @model_validator(mode="after")
    def _rises(self) -> "FallingFriction":
        if self.between_C is not None and not self.between_C[0] < self.between_C[1]:
            given = f"between_C = {list(self.between_C)}"
            raise refused_by_check(given, "a second temperature above the first one", "exchange them")
        return self


class FrictionInputs(Record):
    """How friction depends on slip velocity and temperature, thermal properties, and the slope of creep forces."""

    falling: FallingFriction | None = None
    """how friction falls with slip velocity and temperature (default: it is constant)"""
    heat: Heat = Heat()
    """thermal properties of both bodies"""
    slope: SlopeReduction = SlopeReduction()
    """reduction of the initial slope of creep forces by layers on the surfaces"""

    def law(self, static: float, by_row: Floats | None = None) -> "Friction":
        """Return the law of friction of a static coefficient.

        - `by_row`: static coefficients of rows of cells across, (n,); the kinetic ones are less by the same factor.
        """
        falling = self.falling
        heating = Heating(self.heat, self.heat, None if falling is None else falling.between_C)
        kinetic = static if falling is None else falling.kinetic
        decay = 0.0 if falling is None else falling.decay_m_per_s
        if by_row is None:
            return Friction(static, kinetic, decay, heating, self.slope)
        # rows with the static coefficient have the kinetic one to the last digit
        fallen = np.where(by_row == static, kinetic, (kinetic / static if static > 0.0 else 1.0) * by_row)
        return Friction(by_row, fallen, decay, heating, self.slope)


@dataclass(frozen=True, eq=False)
class Friction:
    """Coefficient of friction ``mu(w) = kinetic + (static - kinetic) exp(-w / decay)`` at the slip velocity w.

    The exponential is Polach's (2005, Wear 258, "Creep forces in simulations of traction vehicles running on adhesion
    limit"): his A is kinetic / static, his B is 1 / decay. With ``decay=0`` it is kinetic as soon as surfaces slip.

    Parameters
    ----------
    static
        Coefficient of surfaces that stick, >= 0; a number, or one for each row of cells across. 0 is without friction.
    kinetic
        Coefficient of surfaces that slip fast, from 0 to static; left out: static.
    decay
        Slip velocity in which the difference falls to 1/e, >= 0, in the unit of the speed of rolling.
    heating
        Thermal properties of the bodies, for temperatures; `Heating.falls` multiplies the difference of both
        coefficients by a factor from 1 to 0. Such friction does not depend on the slip velocity where decay is 0.
    slope
        Reduction of the initial slope of creep forces.

    Raises
    ------
    InputError
        If a coefficient is negative or no number, or the kinetic one exceeds the static one.

    """

    static: float | Floats
    kinetic: float | Floats | None = None
    decay: float = 0.0
    heating: Heating | None = None
    slope: SlopeReduction = field(default_factory=SlopeReduction)

    def __post_init__(self) -> None:
        static, kinetic = self.limits
        sizes = {static.size, kinetic.size} - {1}
        if max(static.ndim, kinetic.ndim) > 1 or 0 in sizes or len(sizes) > 1:
            raise InputError(
                f"coefficients of friction of shapes {static.shape} and {kinetic.shape}",
                "a number, or one for each row of cells across, as many static as kinetic ones",
                "give one for each row; along the patch they do not vary",
            )
        if not (np.isfinite(static).all() and (static >= 0.0).all() and (kinetic >= 0.0).all()):
            raise InputError(
                f"Friction(static={self.static}, kinetic={self.kinetic})",
                "finite coefficients >= 0",
                "give 0 for contact without friction",
            )
        if not (kinetic <= static).all():
            raise InputError(
                f"Friction(static={self.static}, kinetic={self.kinetic})",
                "a kinetic coefficient that is not above the static one",
                "exchange them, or leave the kinetic one out",
            )
        check_finite("Friction", "decay", self.decay)
        if self.decay < 0.0:
            raise InputError(f"Friction(decay={self.decay})", "a slip velocity >= 0", "correct the sign")

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Static and kinetic coefficients, each one number or one for each row."""
        given = self.static, self.static if self.kinetic is None else self.kinetic
        static, kinetic = (np.atleast_1d(as_numbers("coefficients of friction", limit)) for limit in given)
        return static, kinetic

    def of_rows(self, rows: slice | Bools) -> "Friction":
        """The same on some of the rows of cells."""
        static, kinetic = self.limits
        if max(len(static), len(kinetic)) == 1:
            return self
        static, kinetic = (limit if len(limit) == 1 else limit[rows] for limit in (static, kinetic))
        return replace(self, static=static, kinetic=kinetic)

    @property
    def constant(self) -> bool:
        """Whether the coefficient depends on nothing."""
        static, kinetic = self.limits
        return bool((static == kinetic).all())

    @property
    def by_temperature(self) -> bool:
        """Whether it falls with temperature."""
        return not self.constant and self.heating is not None and self.heating.falls is not None

    @property
    def jumps(self) -> bool:
        """Whether it is kinetic as soon as surfaces slip."""
        return not self.constant and self.decay == 0.0 and not self.by_temperature

    @property
    def notices(self) -> tuple[str, ...]:
        """What is unusual about the numbers."""
        most = float(self.limits[0].max())
        return (f"a coefficient of friction of {most:g} is above {NOTICE_ABOVE:g}",) if most > NOTICE_ABOVE else ()

    def share(self, velocities: Floats | float, rise: Floats | float = 0.0) -> Floats:
        """Share of ``static - kinetic`` that is left at slip velocities >= 0 and temperatures above `Heating`'s."""
        share: Floats = self._warm(rise)[0]
        if self.decay > 0.0:
            return np.asarray(share * np.exp(-np.asarray(velocities) / self.decay))
        return np.asarray(share * (np.asarray(velocities) <= 0.0)) if self.jumps else share

    def _warm(self, rise: Floats | float) -> tuple[Floats, Floats]:
        """The same by temperature alone, and its derivative."""
        if self.heating is None or self.heating.falls is None:
            return np.ones(()), np.zeros(())
        start, end = self.heating.falls
        left = np.asarray((end - self.heating.temperature - rise) / (end - start))
        return left.clip(0.0, 1.0), np.where((left > 0.0) & (left < 1.0), -1.0 / (end - start), 0.0)

    def fallen(
        self,
        rest: Floats,
        kinetic: Floats,
        trial: Floats,
        softness: Floats,
        rise: Floats | float = 0.0,
    ) -> "FallenLimits":
        """Limits of forces where surfaces slip because sticking would need more.

        With the limit m the slip velocity is ``w = softness (trial - m)``, and m is ``kinetic + (rest - kinetic) r(T)
        exp(-w / decay)``. With A for the second part at w = 0, ``B = trial - kinetic`` and ``a = softness / decay``,
        ``y = trial - m`` has ``y + A exp(-a y) = B``, by Lambert's function W: ``a y = a B + W(-a A exp(-a B))``. Where
        B is above A there is one such y.

        Parameters
        ----------
        rest, kinetic
            Limits at rest and at high slip velocities: normal forces times coefficients.
        trial
            Sizes of the forces without slip, of the same shape.
        softness
            Slip velocity over force.
        rise
            Temperature above that without friction.

        """
        share, by_rise = self._warm(rise)
        span, beyond = share * (rest - kinetic), trial - kinetic
        slips = beyond > span
        part: Floats = np.where(slips & self.jumps, 0.0, 1.0)
        rate: Floats = np.zeros(trial.shape)
        if self.decay > 0.0:
            rate = np.asarray(slips * softness / self.decay)
            # the argument is not below -1/e, but for round-off
            argument = np.minimum(rate * span * np.exp(-rate * np.maximum(beyond, 0.0)), np.exp(-1.0))
            part = np.exp(-rate * beyond - lambertw(-argument).real)
        steepness = 1.0 - rate * span * part
        steepness = np.where(np.abs(steepness) > EPS, steepness, 1.0)
        by_trial, by_warmth = -rate * span * part / steepness, part * (rest - kinetic) * by_rise / steepness
        return FallenLimits(kinetic + span * part, by_trial, by_warmth)


class FallenLimits(NamedTuple):
    """Limits, and their derivatives by the trial force and by the temperature, each of the shape of the forces."""

    limits: Floats
    by_trial: Floats
    by_rise: Floats
