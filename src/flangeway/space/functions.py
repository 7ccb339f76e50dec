"""Given functions on a space: interpolation and loads."""

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers, values_at
from flangeway.elements import Function, polygon_quadrature
from flangeway.errors import InputError
from flangeway.space.spaces import CellBatch, Space
from flangeway.types import Floats, floats


def quadrature_degree(space: Space) -> int:
    """Degree of quadrature of given smooth functions, so that its error is below that of the space."""
    return 2 * space.order + 2


def function_of(
    name: str, given: Function | ArrayLike, at: Floats | None = None, shape: tuple[int, ...] = ()
) -> Function:
    """A function of points (n, 2): the given one, or one that has the given numbers everywhere.

    With points (n, 2) in ``at``, an `InputError` unless it has values of a shape (n, *shape) there.
    """
    function = given
    if not callable(function):
        constant = as_numbers(name, given)
        function = lambda points: np.broadcast_to(constant, (len(points), *constant.shape))  # noqa: E731
    if at is not None and (found := values_at(function, at).shape) != (len(at), *shape):
        raise InputError(
            f"{name} with values of shape {found} at {len(at)} points", f"{(len(at), *shape)}", "correct it"
        )
    return function


def at_points(function: Function, points: Floats) -> Floats:
    """Values of a function at points (..., 2, n_cells).

    Returns
    -------
    Floats
        Shape (..., n_cells), or (m, ..., n_cells) for a function with m components, and so on for tensors.

    Raises
    ------
    InputError
        If the function is complex, gives another shape or a number that is not finite; the message names the place.

    """
    given = points.swapaxes(-1, -2)
    rows = given.reshape(-1, 2)
    values = values_at(function, rows)
    if np.iscomplexobj(values):
        raise InputError(
            "a complex function", "real values", "give its real and imaginary parts one by one, or a form to `linear`"
        )
    values = floats(values)
    if values.shape[:1] != (len(rows),):
        raise InputError(
            f"a function that gives shape {values.shape} for {len(rows)} points",
            f"({len(rows)},), or ({len(rows)}, m) for m components",
            "write it for points of shape (n, 2)",
        )
    if not np.isfinite(values).all():
        row = int(np.argmax(~np.isfinite(values).reshape(len(rows), -1).all(axis=1)))
        raise InputError(
            f"a function that is not finite at ({rows[row, 0]:g}, {rows[row, 1]:g})",
            "finite numbers everywhere inside the mesh",
            "check the function there",
        )
    shape = (*values.shape[1:], *given.shape[:-1])
    return np.ascontiguousarray(np.moveaxis(values, 0, -1)).reshape(shape)


def cell_quadrature(batch: CellBatch, degree: int) -> tuple[Floats, Floats]:
    """Points (n_points, 2, n_cells) inside cells and weights (n_points, n_cells)."""
    return polygon_quadrature(batch.outline, degree)


def interpolate(space: Space, function: Function, degree: int | None = None) -> Floats:
    """Degrees of freedom of a function: values at nodes, and its moments inside virtual cells.

    Parameters
    ----------
    space
        The space.
    function
        Takes points (n, 2), gives values (n,), or (n, m) for m components.
    degree
        Degree of the quadrature of moments, ``2 k + 2`` by default.

    Returns
    -------
    Floats
        Shape (n_dofs,) or (n_dofs, m).

    """
    degree = quadrature_degree(space) if degree is None else degree
    at_nodes = at_points(function, space.nodes.T)
    if at_nodes.ndim > 1:
        components = [lambda points, i=i: np.asarray(function(points))[:, i] for i in range(len(at_nodes))]
        return np.stack([interpolate(space, component, degree) for component in components], axis=1)
    dofs = np.empty(space.n_dofs)
    dofs[: space.n_nodes] = at_nodes
    for batch in space.batches():
        n_interior = batch.element.n_interior()
        if n_interior:
            inside = batch.element.interior_dofs(batch.outline, function, degree)
            dofs[batch.dofs[-n_interior:]] = inside
    return dofs


def load_vector(space: Space, function: Function, degree: int | None = None) -> Floats:
    """Integrals of a function times the projected basis functions (Moherdaui 2021, 3.81).

    Parameters
    ----------
    space
        The space.
    function
        Takes points (n, 2), gives values (n,), or (n, m) for m components.
    degree
        Degree of the quadrature of the function times a polynomial, ``2 k + 2`` by default.

    Returns
    -------
    Floats
        Shape (n_dofs,) or (n_dofs, m).

    """
    degree = quadrature_degree(space) if degree is None else degree
    load = None
    for batch in space.batches():
        reconstruction = batch.reconstruction
        points, weights = cell_quadrature(batch, degree)
        weighted = at_points(function, points) * weights
        products = np.einsum("aqe,...qe->...ae", reconstruction.at(points), weighted)
        local = np.einsum("...ae,ame->me...", products, reconstruction.projected_value)
        load = np.zeros((space.n_dofs, *local.shape[2:])) if load is None else load
        np.add.at(load, batch.dofs, local)
    assert load is not None  # a mesh has a cell
    return load
