"""Equations in time, step by step with one kept factorisation: first order by theta, second by generalised alpha."""

from collections.abc import Callable, Iterator

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from flangeway.checks import check_between, check_integer, check_positive
from flangeway.errors import InputError
from flangeway.forms.weak import Values
from flangeway.solve.factor import Factor
from flangeway.types import Bools, Indices

InTime = ArrayLike | Callable[[float], ArrayLike]
"""An array, or a function of the time that gives one."""


def theta_steps(
    mass: sp.sparray,
    stiffness: sp.sparray,
    start: ArrayLike,
    step: float,
    number: int,
    *,
    theta: float = 0.5,
    load: InTime = 0.0,
    fixed: Indices | Bools | None = None,
    values: InTime | None = None,
) -> Iterator[tuple[float, Values]]:
    """Integrate ``M u' + K u = f(t)``: yields the time and the unknowns after every step.

    ``(M + theta dt K) u1 = (M - (1 - theta) dt K) u0 + dt (theta f1 + (1 - theta) f0)``; 1/2 is Crank and Nicolson's
    method of second order, 1 the implicit Euler method.

    Parameters
    ----------
    mass, stiffness
        Matrices (m n_dofs, m n_dofs), symmetric or not, real or complex.
    start
        Unknowns at time zero, (n_dofs,) or (n_dofs, m), real or complex.
    step, number
        Length and number of the steps.
    theta
        From 1/2, without a limit of the step for stability, to 1.
    load
        Right-hand side, of the shape of ``start``, or a function of the time.
    fixed, values
        Prescribed unknowns and their values, which may be a function of the time; None keeps those of ``start``.

    Raises
    ------
    InputError
        If the step is not positive, theta out of its range, the start of another size, or the matrix singular.

    """
    (u,), m = _checked(step, number, mass, start)
    check_between("theta_steps", "theta", theta, 0.5, 1.0, advice="take 0.5 for second order")
    factor = Factor(mass + theta * step * stiffness, fixed, m)
    explicit = sp.csr_array(mass - (1.0 - theta) * step * stiffness)
    before = _at(load, 0.0, u)
    for i in range(number):
        time = (i + 1) * step
        after = _at(load, time, u)
        rhs = (explicit @ u.ravel()).reshape(u.shape) + step * (theta * after + (1.0 - theta) * before)
        u = factor.solve(rhs, u if values is None else _at(values, time, u))
        before = after
        yield time, u


def newmark_steps(
    mass: sp.sparray,
    stiffness: sp.sparray,
    start: ArrayLike,
    velocity: ArrayLike,
    step: float,
    number: int,
    *,
    damping: sp.sparray | None = None,
    radius: float | None = None,
    load: InTime = 0.0,
    fixed: Indices | Bools | None = None,
) -> Iterator[tuple[float, Values, Values]]:
    """Integrate ``M u'' + C u' + K u = f(t)``: yields time, unknowns and their velocities after every step.

    Newmark's method (1959) of average acceleration keeps the energy of a free vibration; the generalised alpha method
    (Chung and Hulbert, 1993, J. Appl. Mech. 60, eqs. 17, 18, 25) damps waves that the step does not resolve. Both are
    of second order and stable for any step.

    Parameters
    ----------
    mass, stiffness, damping
        Matrices (m n_dofs, m n_dofs), real or complex.
    start, velocity
        Unknowns and velocities at time zero, (n_dofs,) or (n_dofs, m), real or complex.
    step, number
        Length and number of the steps.
    radius
        Factor of the amplitude per step at infinite frequency, 0 to 1, of the generalised alpha method; None is
        Newmark's method.
    load
        Right-hand side, or a function of the time.
    fixed
        Unknowns that keep their values of ``start``.

    Raises
    ------
    InputError
        If the step is not positive, the radius out of its range, the start of another size, or a matrix singular.

    """
    (u, v), m = _checked(step, number, mass, start, velocity)
    if radius is not None:
        check_between("newmark_steps", "radius", radius, 0.0, 1.0, advice="leave it out for Newmark's method")
    of_mass, of_rest = (0.0, 0.0) if radius is None else ((2 * radius - 1) / (radius + 1), radius / (radius + 1))
    gamma, beta = 0.5 - of_mass + of_rest, 0.25 * (1.0 - of_mass + of_rest) ** 2
    shape = u.shape
    damping = sp.csr_array(mass.shape) if damping is None else damping
    implicit = (1.0 - of_mass) * mass + (1.0 - of_rest) * (gamma * step * damping + beta * step**2 * stiffness)
    factor = Factor(implicit, fixed, m)
    v = np.where(factor.free.reshape(shape), v, 0.0)

    def forces(displacements: Values, velocities: Values) -> Values:
        return np.asarray(stiffness @ displacements.ravel() + damping @ velocities.ravel()).reshape(shape)

    a = Factor(mass, fixed, m).solve(_at(load, 0.0, u) - forces(u, v))
    for i in range(number):
        time = (i + 1) * step
        at_load = _at(load, time - of_rest * step, u)
        predicted, rate = u + step * v + step**2 * (0.5 - beta) * a, v + step * (1.0 - gamma) * a
        inside = forces((1 - of_rest) * predicted + of_rest * u, (1 - of_rest) * rate + of_rest * v)
        a = factor.solve(at_load - inside - of_mass * (mass @ a.ravel()).reshape(shape))
        u, v = predicted + beta * step**2 * a, rate + gamma * step * a
        yield time, u, v


def _checked(step: float, number: int, mass: sp.sparray, *start: ArrayLike) -> tuple[list[Values], int]:
    """Arrays at time zero, real or complex, and their number of components."""
    check_positive("time steps", "step", step)
    check_integer("time steps", "number", number, 1)
    arrays: list[Values] = [np.asarray(given) for given in start]
    shapes = {array.shape for array in arrays}
    if len(shapes) > 1 or arrays[0].dtype.kind not in "iufc" or arrays[0].size != mass.shape[0] or arrays[0].ndim > 2:
        raise InputError(
            f"a mass of shape {mass.shape}, and a start of shape {' and '.join(map(str, shapes))}",
            "as many rows as the start has numbers: (n_dofs,) or (n_dofs, m)",
            "use the same space and the same number of components for all",
        )
    return arrays, 1 if arrays[0].ndim == 1 else arrays[0].shape[1]


def _at(given: InTime, time: float, like: Values) -> Values:
    return np.broadcast_to(np.asarray(given(time) if callable(given) else given), like.shape)
