"""St. Venant's torsion in closed form.

All sections give, for a rate of twist of one and a shear modulus of one: the torsion constant, the warping function
psi (mean zero, about the origin named), Prandtl's function phi (zero on the outer boundary), and their gradients.
Shear stresses are ``(psi,x - y, psi,y + x) = (phi,y, -phi,x)``.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers, check_finite, check_integer, check_positive, is_finite, refused
from flangeway.errors import InputError
from flangeway.types import Complex, Floats, floats


def _refuse_not_positive(owner: object, **values: float) -> None:
    for name, value in values.items():
        check_positive(type(owner).__name__, name, value)


def _xy(points: ArrayLike) -> tuple[Floats, Floats]:
    given = as_numbers("points", points)
    if given.ndim != 2 or given.shape[1] != 2:
        raise InputError(f"points of shape {given.shape}", "(n, 2)", "give one row of x and y for each point")
    return given[:, 0], given[:, 1]


class TorsionSection(ABC):
    """A cross-section with a torsion solution in closed form; subclasses are final."""

    @property
    @abstractmethod
    def area(self) -> float:
        """Area."""

    @property
    @abstractmethod
    def torsion_constant(self) -> float:
        """Torsion constant J."""

    @abstractmethod
    def stress_function(self, points: ArrayLike) -> Floats:
        """Prandtl's function at points (n, 2), shape (n,)."""

    @abstractmethod
    def stress_function_gradient(self, points: ArrayLike) -> Floats:
        """Gradient of Prandtl's function at points (n, 2), shape (n, 2)."""

    @abstractmethod
    def warping(self, points: ArrayLike) -> Floats:
        """Warping function at points (n, 2), shape (n,)."""

    def warping_gradient(self, points: ArrayLike) -> Floats:
        """Gradient of the warping function at points (n, 2), shape (n, 2)."""
        x, y = _xy(points)
        return self.shear_stress(points) + np.column_stack((y, -x))

    def shear_stress(self, points: ArrayLike) -> Floats:
        """Shear stresses zx and zy at points (n, 2), shape (n, 2)."""
        gradient = self.stress_function_gradient(points)
        return np.column_stack((gradient[:, 1], -gradient[:, 0]))


@dataclass(frozen=True)
class Ellipse(TorsionSection):
    """Ellipse about the origin, with a similar hole if asked (Timoshenko and Goodier, 1970, articles 107 and 115).

    Parameters
    ----------
    half_width, half_height
        Semi-axes along x and y.
    hole_ratio
        Semi-axes of the hole over those of the outline, in [0, 1).

    """

    half_width: float
    half_height: float
    hole_ratio: float = 0.0

    def __post_init__(self) -> None:
        _refuse_not_positive(self, half_width=self.half_width, half_height=self.half_height)
        if not (is_finite(self.hole_ratio) and 0.0 <= self.hole_ratio < 1.0):
            raise refused("Ellipse", "hole_ratio", self.hole_ratio, "0 <= ratio < 1", "correct the value")

    @classmethod
    def circle(cls, radius: float, hole_radius: float = 0.0) -> "Ellipse":
        """Circle, hollow if asked: no warping."""
        check_positive("Ellipse.circle", "radius", radius)
        return cls(radius, radius, check_finite("Ellipse.circle", "hole_radius", hole_radius) / radius)

    @property
    def area(self) -> float:
        """Area."""
        return np.pi * self.half_width * self.half_height * (1.0 - self.hole_ratio**2)

    @property
    def torsion_constant(self) -> float:
        """``pi a^3 b^3 (1 - q^4) / (a^2 + b^2)``."""
        a, b = self.half_width, self.half_height
        return np.pi * (a * b) ** 3 / (a**2 + b**2) * (1.0 - self.hole_ratio**4)

    def _terms(self, points: ArrayLike) -> tuple[Floats, Floats, float, float]:
        """Coordinates of points, and squares of both semi-axes."""
        return *_xy(points), self.half_width**2, self.half_height**2

    def stress_function(self, points: ArrayLike) -> Floats:
        """Prandtl's function; see `TorsionSection`."""
        x, y, a2, b2 = self._terms(points)
        return a2 * b2 / (a2 + b2) * (1.0 - x**2 / a2 - y**2 / b2)

    def stress_function_gradient(self, points: ArrayLike) -> Floats:
        """Gradient of Prandtl's function; see `TorsionSection`."""
        x, y, a2, b2 = self._terms(points)
        return np.column_stack((-2.0 * b2 * x, -2.0 * a2 * y)) / (a2 + b2)

    def warping(self, points: ArrayLike) -> Floats:
        """Warping function about the centre; see `TorsionSection`."""
        x, y, a2, b2 = self._terms(points)
        return -(a2 - b2) / (a2 + b2) * x * y


@dataclass(frozen=True)
class EquilateralTriangle(TorsionSection):
    """Equilateral triangle with its centroid at the origin, base below (Timoshenko and Goodier, article 107).

    Parameters
    ----------
    side
        Length of a side.

    """

    side: float

    def __post_init__(self) -> None:
        _refuse_not_positive(self, side=self.side)

    @property
    def _inradius(self) -> float:
        return self.side / (2.0 * np.sqrt(3.0))

    @property
    def corners(self) -> Floats:
        """Corners, counter-clockwise, shape (3, 2)."""
        r, half = self._inradius, self.side / 2.0
        return np.array([[-half, -r], [half, -r], [0.0, 2.0 * r]])

    @property
    def area(self) -> float:
        """Area."""
        return np.sqrt(3.0) / 4.0 * self.side**2

    @property
    def torsion_constant(self) -> float:
        """``sqrt(3) s^4 / 80``."""
        return np.sqrt(3.0) / 80.0 * self.side**4

    def stress_function(self, points: ArrayLike) -> Floats:
        """Prandtl's function, a multiple of the product of the distances to the sides; see `TorsionSection`."""
        x, y = _xy(points)
        r = self._inradius
        return 2.0 / 3.0 * r**2 - (x**2 + y**2) / 2.0 + (y**3 - 3.0 * x**2 * y) / (6.0 * r)

    def stress_function_gradient(self, points: ArrayLike) -> Floats:
        """Gradient of Prandtl's function; see `TorsionSection`."""
        x, y = _xy(points)
        r = self._inradius
        return np.column_stack((-x - x * y / r, -y + (y**2 - x**2) / (2.0 * r)))

    def warping(self, points: ArrayLike) -> Floats:
        """Warping function about the centroid; see `TorsionSection`."""
        x, y = _xy(points)
        return (3.0 * x * y**2 - x**3) / (6.0 * self._inradius)


@dataclass(frozen=True)
class Rectangle(TorsionSection):
    """Rectangle about the origin, by a series in sines (Timoshenko and Goodier, article 109).

    Off the sides x = const the series converges geometrically; on them, gradients are off by
    about ``0.4 height / n_terms`` at worst, in the corners.

    Parameters
    ----------
    width, height
        Sides along x and y.
    n_terms
        Terms of the series of the functions; the torsion constant is exact to rounding whatever their number.

    """

    width: float
    height: float
    n_terms: int = 200

    def __post_init__(self) -> None:
        _refuse_not_positive(self, width=self.width, height=self.height)
        check_integer("Rectangle", "n_terms", self.n_terms, 1)

    @property
    def area(self) -> float:
        """Area."""
        return self.width * self.height

    @property
    def torsion_constant(self) -> float:
        """``w h^3 (1/3 - 64 h / (pi^5 w) sum tanh(n pi w / (2 h)) / n^5)`` over odd n, h the shorter side."""
        h, w = sorted((self.width, self.height))
        n = np.arange(1, 2001, 2)
        terms = np.tanh(n * np.pi * w / (2.0 * h)) / n**5.0
        return float(w * h**3 * (1.0 / 3.0 - 64.0 * h / (np.pi**5 * w) * terms[::-1].sum()))

    def _series(self, points: ArrayLike, power: int, odd_in_x: bool, sine: bool) -> Floats:
        """Sum over odd n of ``(-1)^((n-1)/2) / n^power f(n pi x / h) / cosh(n pi w / 2h) g(n pi y / h)``.

        f is sinh or cosh, g is sin or cos.
        """
        x, y = _xy(points)
        total = np.zeros(len(x))
        for i in range(self.n_terms):
            n = 2 * i + 1
            rate = n * np.pi / self.height
            edge = np.exp(rate * (np.abs(x) - self.width / 2.0))
            mirrored = np.exp(-2.0 * rate * np.abs(x))
            along = edge * (np.sign(x) * (1.0 - mirrored) if odd_in_x else 1.0 + mirrored)
            along /= 1.0 + np.exp(-rate * self.width)
            total += (-1.0) ** i / float(n) ** power * along * (np.sin if sine else np.cos)(rate * y)
        return total

    def stress_function(self, points: ArrayLike) -> Floats:
        """Prandtl's function; see `TorsionSection`."""
        _, y = _xy(points)
        h = self.height
        return h**2 / 4.0 - y**2 - 8.0 * h**2 / np.pi**3 * self._series(points, 3, odd_in_x=False, sine=False)

    def stress_function_gradient(self, points: ArrayLike) -> Floats:
        """Gradient of Prandtl's function; see `TorsionSection`."""
        _, y = _xy(points)
        factor = 8.0 * self.height / np.pi**2
        return np.column_stack(
            (
                -factor * self._series(points, 2, odd_in_x=True, sine=False),
                -2.0 * y + factor * self._series(points, 2, odd_in_x=False, sine=True),
            )
        )

    def warping(self, points: ArrayLike) -> Floats:
        """Warping function about the centre; see `TorsionSection`."""
        x, y = _xy(points)
        return -x * y + 8.0 * self.height**2 / np.pi**3 * self._series(points, 3, odd_in_x=True, sine=True)


@dataclass(frozen=True)
class CircularSector(TorsionSection):
    """Sector of a circle with its apex at the origin, symmetric about the positive x axis.

    The series of Timoshenko and Goodier (article 111) written so that no angle is singular:
    ``J = 8 R^4 angle / pi^2 sum 1 / (n^2 (n pi / angle + 2)^2)`` over odd n.

    Parameters
    ----------
    radius
        Radius.
    angle
        Opening, in radians, in (0, 2 pi); pi is the half circle.
    n_terms
        Terms of the series of the functions.

    """

    radius: float
    angle: float
    n_terms: int = 200

    def __post_init__(self) -> None:
        _refuse_not_positive(self, radius=self.radius, angle=self.angle)
        check_integer("CircularSector", "n_terms", self.n_terms, 1)
        if self.angle >= 2.0 * np.pi:
            raise InputError(f"CircularSector(angle={self.angle})", "below 2 pi", "give the opening in radians")

    @property
    def area(self) -> float:
        """Area."""
        return self.radius**2 * self.angle / 2.0

    @property
    def torsion_constant(self) -> float:
        """Torsion constant, see the class."""
        n = np.arange(1, 40001, 2)[::-1]
        return float(
            8.0 * self.radius**4 * self.angle / np.pi**2 * np.sum(1.0 / (n * (n * np.pi / self.angle + 2.0)) ** 2)
        )

    def _harmonic(self, points: ArrayLike) -> tuple[Complex, Complex]:
        """Analytic function whose real part is ``phi + r^2 / 2``, and its derivative."""
        x, y = _xy(points)
        z = (x + 1j * y) / self.radius
        safe = np.where(z == 0.0, 1e-300, z)
        turn, alpha = np.cos(self.angle), self.angle
        resonant = abs(turn) < 1e-9
        value = np.zeros(len(z), dtype=np.complex128)
        slope = np.zeros(len(z), dtype=np.complex128)
        if resonant:
            # cos(angle) = 0: z^2 ln z takes the place of z^2 / cos(angle)
            factor = -1.0 / (alpha * np.sin(alpha))
            value += factor * safe**2 * np.log(safe)
            slope += factor * (2.0 * safe * np.log(safe) + safe)
            shift = 2.0 / alpha * (-0.5 * np.sin(alpha) - factor * alpha / 8.0)
            value -= shift * safe**2
            slope -= 2.0 * shift * safe
        else:
            value += 0.5 * safe**2 / turn
            slope += safe / turn
        for i in range(self.n_terms):
            n = 2 * i + 1
            rate = n * np.pi / alpha
            if resonant and abs(rate - 2.0) < 1e-6:
                continue
            coefficient = -8.0 * (-1.0) ** i / (n * np.pi * (rate - 2.0) * (rate + 2.0))
            power = safe ** (rate - 1.0)
            value += coefficient * power * safe
            slope += coefficient * rate * power
        return value * self.radius**2, slope * self.radius

    def stress_function(self, points: ArrayLike) -> Floats:
        """Prandtl's function; see `TorsionSection`."""
        x, y = _xy(points)
        return self._harmonic(points)[0].real - (x**2 + y**2) / 2.0

    def stress_function_gradient(self, points: ArrayLike) -> Floats:
        """Gradient of Prandtl's function; see `TorsionSection`."""
        x, y = _xy(points)
        slope = self._harmonic(points)[1]
        return np.column_stack((slope.real - x, -slope.imag - y))

    def warping(self, points: ArrayLike) -> Floats:
        """Warping function about the apex; see `TorsionSection`."""
        return -self._harmonic(points)[0].imag


def thin_open_torsion_constant(lengths: ArrayLike, thicknesses: ArrayLike) -> float:
    """Approximate torsion constant ``sum l t^3 / 3`` of a thin-walled open section (Roark, table 10.7).

    Parameters
    ----------
    lengths, thicknesses
        Lengths along the middle lines and thicknesses of the straight or curved parts, shape (n,).

    """
    lengths, thicknesses = floats(lengths), floats(thicknesses)
    return float(np.sum(lengths * thicknesses**3) / 3.0)


def thin_closed_torsion_constant(enclosed_area: float, lengths: ArrayLike, thicknesses: ArrayLike) -> float:
    """Approximate torsion constant ``4 A^2 / sum (l / t)`` of a thin-walled closed section (Bredt, 1896).

    Parameters
    ----------
    enclosed_area
        Area inside the middle line.
    lengths, thicknesses
        Lengths along the middle line and thicknesses of the walls, shape (n,).

    """
    lengths, thicknesses = floats(lengths), floats(thicknesses)
    return float(4.0 * enclosed_area**2 / np.sum(lengths / thicknesses))
