"""Flash temperature: how friction warms the surfaces of a contact that rolls.

Heat flows into both bodies along their normals only, since it spreads slowly beside the speed of rolling: a point on
the surface of a half-space that passes a source of the power q over area has the temperature

    T(x) = T_0 + 1 / (b sqrt(pi V)) integral of q(xi) / sqrt(xi - x) d xi over what lies ahead of x,

with the effusivity ``b = sqrt(conductivity density capacity)`` and the speed V (Carslaw and Jaeger, 1959, "Conduction
of heat in solids", 10.7; Ertz and Knothe, 2002, Wear 253). Both bodies have the same temperature in contact, so that
heat is divided as their effusivities are. The error falls with the Peclet number ``V a / (2 kappa)``: for steel, half a
length a of 6 mm, and 1 m/s it is 210.
"""

from dataclasses import dataclass, fields

import numpy as np

from flangeway.checks import are_finite, check_finite, check_positive
from flangeway.errors import InputError
from flangeway.types import Floats

UNITS = 1e6 * np.sqrt(1e-3)
"""W/m² over N/mm² m/s, and the root of m over mm."""


@dataclass(frozen=True)
class Heat:
    """Thermal properties of a body; without numbers those of rail steel (Ertz and Knothe, 2002, at 20 degrees).

    Parameters
    ----------
    temperature
        Of the body away from the contact, degrees Celsius.
    conductivity
        W/(m K), > 0.
    density
        kg/m³, > 0.
    capacity
        Specific heat capacity, J/(kg K), > 0.

    """

    temperature: float = 20.0
    conductivity: float = 50.0
    density: float = 7850.0
    capacity: float = 450.0

    def __post_init__(self) -> None:
        check_finite("Heat", "temperature", self.temperature)
        for one in fields(self)[1:]:
            check_positive("Heat", one.name, getattr(self, one.name))

    @property
    def effusivity(self) -> float:
        """Root of conductivity, density and capacity, W s^(1/2) / (m² K)."""
        return float(np.sqrt(self.conductivity * self.density * self.capacity))


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

    first: Heat = Heat()
    second: Heat = Heat()
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
        return (parts[0] * self.first.temperature + parts[1] * self.second.temperature) / sum(parts)

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
