"""Arrays with their derivatives: truncated Taylor series, by which the gaps' formulas are written once.

Operations on values carry the first and second derivatives along by the rules of sums, products and chains (forward
automatic differentiation; A. Griewank and A. Walther, 2008, "Evaluating Derivatives"; for contact J. Korelc and P.
Wriggers, 2016, "Automation of Finite Element Methods"). Vectors of the plane are complex numbers x + i y: the real part
of ``conj(a) b`` is the dot product of two, the imaginary part a's cross b. Variables are always real.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from flangeway.types import Complex, Floats, Ints

Array = NDArray[Any]
Factor = Union["Taylor", Array, complex]


@dataclass(frozen=True, eq=False)
class Taylor:
    """Real or complex functions of d variables, about one point of these.

    Parameters
    ----------
    value
        Values, shape (...).
    first
        First derivatives, shape (d, ...), or one that is broadcast to it: NumPy's loops are then over many values.
    second
        Second derivatives, shape (d, d, ...), or one that is broadcast to it; None where they are not wanted.

    """

    value: Array
    first: Array
    second: Array | None = None

    __array_ufunc__ = None  # an array on the left leaves the operation to this class

    @classmethod
    def of_points(cls, points: Floats, *, second: bool, slots: Ints | None = None) -> "Taylor":
        """Complex positions of points (p, n, 2) whose d = 2 n components, point by point, are the variables: (p, n).

        With ``slots`` only those points, in each row others, shape (p, k).
        """
        n = points.shape[1]
        value, first = as_complex(points), np.kron(np.eye(n), [[1.0], [1.0j]])
        if slots is not None:
            value = np.take_along_axis(value, slots, axis=1)
        first = first[:, None] if slots is None else first[:, slots]
        return cls(value, first, np.zeros((1, 1, 1, 1)) if second else None)

    def constant(self, value: Array) -> "Taylor":
        """Constants as functions of the same variables, derivatives of the same order."""
        ones = (1,) * value.ndim
        return Taylor(value, np.zeros((1, *ones)), None if self.second is None else np.zeros((1, 1, *ones)))

    def weighted(self, weights: Floats) -> "Taylor":
        """Sums (p,) of points (p, n) times weights (n,)."""
        return (self * weights).sum()

    def _each(self, function: Callable[[Array], Array]) -> "Taylor":
        """A function that is linear over the reals, of values and derivatives."""
        return Taylor(
            function(self.value), function(self.first), None if self.second is None else function(self.second)
        )

    def __getitem__(self, place: Any) -> "Taylor":
        """Some of the functions, by all axes, along which derivatives are not broadcast."""
        return self._each(lambda array: np.asarray(array[..., *place]))

    @property
    def real(self) -> "Taylor":
        """Real parts."""
        return self._each(np.real)

    @property
    def conj(self) -> "Taylor":
        """Complex conjugates."""
        return self._each(np.conj)

    def __neg__(self) -> "Taylor":
        """Return the negative."""
        return self._each(np.negative)

    def __add__(self, other: Factor) -> "Taylor":
        """Return the sum with functions or with constants."""
        if not isinstance(other, Taylor):
            return Taylor(self.value + other, self.first, self.second)
        second = None if self.second is None or other.second is None else self.second + other.second
        return Taylor(self.value + other.value, self.first + other.first, second)

    def __rsub__(self, other: Factor) -> "Taylor":
        """Return the difference from constants."""
        return -self + other

    def __sub__(self, other: Factor) -> "Taylor":
        """Return the difference."""
        return self + (-other)

    def __mul__(self, other: Factor) -> "Taylor":
        """Return the product."""
        if not isinstance(other, Taylor):
            second = None if self.second is None else other * self.second
            return Taylor(other * self.value, other * self.first, second)
        one, two = self.value, other.value
        first, second = one * other.first + two * self.first, None
        if self.second is not None and other.second is not None:
            both = _outer(self.first, other.first)
            second = one * other.second + two * self.second + both + both.swapaxes(0, 1)
        return Taylor(one * two, first, second)

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: Factor) -> "Taylor":
        """Return the quotient."""
        if not isinstance(other, Taylor):
            return self * (1.0 / np.asarray(other))
        inverse = 1.0 / other.value
        return self * other.chained(inverse, -(inverse**2), 2.0 * inverse**3)

    @property
    def abs(self) -> "Taylor":
        """Lengths of vectors, none of which is zero."""
        length = np.abs(self.value)
        return dot(self, self).chained(length, 0.5 / length, -0.25 / length**3)

    def chained(self, value: Array, first: Array, second: Array | None = None) -> "Taylor":
        """A function of these, by its value and its derivatives by them; the second one where it is wanted."""
        seconds = None
        if self.second is not None and second is not None:
            seconds = first * self.second + second * _outer(self.first, self.first)
        return Taylor(value, first * self.first, seconds)

    def sum(self, axis: int = -1) -> "Taylor":
        """Sums along an axis of the values, counted from the last; it is not broadcast in the derivatives."""
        return self._each(lambda array: array.sum(axis=axis))


def dot(one: Taylor, other: Taylor) -> Taylor:
    """Dot products of vectors."""
    return (one.conj * other).real


def cross(one: Taylor, other: Taylor) -> Taylor:
    """Cross products of vectors: positive where the other one is to the left."""
    return (one.conj * other * -1.0j).real


def implicit(function: Callable[[Taylor], Taylor], root: Taylor, slope: Floats) -> Taylor:
    """Root of a function, with derivatives, from its value.

    Each step of Newton's method from the value makes the next derivatives right.

    Parameters
    ----------
    function
        The function of the unknown.
    root
        Its root, a constant.
    slope
        Derivative by the unknown there; infinite where the root is to stay a constant.

    """
    for _ in range(1 if root.second is None else 2):
        root = root - function(root) / slope
    return root


def _outer(one: Array, other: Array) -> Array:
    return one[:, None] * other


def as_complex(vectors: Floats) -> Complex:
    """Vectors (..., 2) as complex numbers, shape (...)."""
    return np.ascontiguousarray(vectors).view(np.complex128)[..., 0]


def as_vectors(numbers: Complex) -> Floats:
    """Complex numbers (...) as vectors (..., 2)."""
    return np.stack((numbers.real, numbers.imag), axis=-1)
