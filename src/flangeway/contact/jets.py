"""Numbers that carry their first and second derivatives, for gaps too long to differentiate by hand."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Jet:
    """Values with their derivatives by d variables (forward differentiation, Griewank and Walther, 2008).

    Parameters
    ----------
    value
        Any shape.
    gradient
        First derivatives, shape (*value.shape, d).
    hessian
        Second derivatives, shape (*value.shape, d, d); None where they are not wanted.

    """

    value: Floats
    gradient: Floats
    hessian: Floats | None

    # arrays on the left of an operator leave it to the jet
    __array_ufunc__ = None

    @classmethod
    def constant(cls, value: Floats, n_variables: int, *, second: bool) -> Self:
        """Values whose derivatives vanish, second ones only if wanted."""
        shape = (*value.shape, n_variables)
        return cls(value, np.zeros(shape), np.zeros((*shape, n_variables)) if second else None)

    def variable(self, value: Floats, number: int) -> "Jet":
        """Independent variable among those of this jet, whose shape ``value`` has."""
        gradient = np.zeros_like(self.gradient)
        gradient[..., number] = 1.0
        return Jet(value, gradient, None if self.hessian is None else np.zeros_like(self.hessian))

    def along_points(self) -> "Jet":
        """Jet of shape (n, 1), to be combined with jets and arrays of shape (n, q)."""
        hessian = None if self.hessian is None else self.hessian[:, None]
        return Jet(self.value[:, None], self.gradient[:, None], hessian)

    def masked(self, keep: NDArray[np.bool_]) -> "Jet":
        """Jet whose derivatives vanish where ``keep`` is false."""
        hessian = None if self.hessian is None else self.hessian * keep[..., None, None]
        return Jet(self.value, self.gradient * keep[..., None], hessian)

    def through(self, value: Floats, first: Floats, second: Floats) -> "Jet":
        """Chain rule: a function of this jet, given its value and derivatives there."""
        gradient = first[..., None] * self.gradient
        if self.hessian is None:
            return Jet(value, gradient, None)
        bend = second[..., None, None] * (self.gradient[..., :, None] * self.gradient[..., None, :])
        return Jet(value, gradient, bend + first[..., None, None] * self.hessian)

    def sqrt(self) -> "Jet":
        """Square root."""
        root = np.sqrt(self.value)
        return self.through(root, 0.5 / root, -0.25 / (root * self.value))

    def reciprocal(self) -> "Jet":
        """One over this."""
        inverse = 1.0 / self.value
        return self.through(inverse, -(inverse**2), 2.0 * inverse**3)

    def sum(self) -> "Jet":
        """Sum over the last axis of the values."""
        hessian = None if self.hessian is None else self.hessian.sum(axis=-3)
        return Jet(self.value.sum(axis=-1), self.gradient.sum(axis=-2), hessian)

    def __add__(self, other: "Jet | Floats | float") -> "Jet":
        """Sum."""
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.gradient, self.hessian)
        hessian = None
        if self.hessian is not None and other.hessian is not None:
            hessian = self.hessian + other.hessian
        return Jet(self.value + other.value, self.gradient + other.gradient, hessian)

    def __mul__(self, other: "Jet | Floats | float") -> "Jet":
        """Product; arrays have this jet's shape."""
        if not isinstance(other, Jet):
            factor = np.asarray(other)
            hessian = None if self.hessian is None else factor[..., None, None] * self.hessian
            return Jet(self.value * factor, self.gradient * factor[..., None], hessian)
        gradient = self.value[..., None] * other.gradient + other.value[..., None] * self.gradient
        if self.hessian is None or other.hessian is None:
            return Jet(self.value * other.value, gradient, None)
        mixed = self.gradient[..., :, None] * other.gradient[..., None, :]
        hessian = self.value[..., None, None] * other.hessian + other.value[..., None, None] * self.hessian
        return Jet(self.value * other.value, gradient, hessian + mixed + np.swapaxes(mixed, -1, -2))

    def __neg__(self) -> "Jet":
        """Opposite."""
        return self * -1.0

    def __sub__(self, other: "Jet | Floats | float") -> "Jet":
        """Difference."""
        return self + (-other)

    def __rsub__(self, other: Floats | float) -> "Jet":
        """Difference from a constant on the left."""
        return -self + other

    def __truediv__(self, other: "Jet") -> "Jet":
        """Quotient."""
        return self * other.reciprocal()
