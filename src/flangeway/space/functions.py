"""Given functions on a space: interpolation, loads, and coefficients of forms."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flangeway.checks import as_numbers, values_at
from flangeway.elements import Function
from flangeway.errors import InputError
from flangeway.geometry.arrays import point_text
from flangeway.mesh.mesh_checks import set_numbers
from flangeway.space.spaces import CellBatch, Space
from flangeway.types import Bools, Floats, floats

# --- Given functions on a space: interpolation and loads.


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
    if at is not None and (returned := values_at(function, at).shape) != (len(at), *shape):
        raise InputError(
            f"{name} with values of shape {returned} at {len(at)} points", f"{(len(at), *shape)}", "correct it"
        )
    return function


def at_points(function: Function, points: Floats) -> Floats:
    """Values of a function at points (..., d, n_cells).

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
    rows = given.reshape(-1, given.shape[-1])
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
            f"write it for points of shape {rows.shape}",
        )
    if not np.isfinite(values).all():
        row = int(np.argmax(~np.isfinite(values).reshape(len(rows), -1).all(axis=1)))
        raise InputError(
            f"a function that is not finite at {point_text(rows[row])}",
            "finite numbers everywhere inside the mesh",
            "check the function there",
        )
    shape = (*values.shape[1:], *given.shape[:-1])
    return np.ascontiguousarray(np.moveaxis(values, 0, -1)).reshape(shape)


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
        points, weights = batch.quadrature(degree)
        weighted = at_points(function, points) * weights
        products = np.einsum("aqe,...qe->...ae", reconstruction.at(points), weighted)
        local = np.einsum("...ae,ame->me...", products, reconstruction.projected_value)
        load = np.zeros((space.n_dofs, *local.shape[2:])) if load is None else load
        np.add.at(load, batch.dofs, local)
    assert load is not None  # a mesh has a cell
    return load


# --- Coefficients of forms: numbers, matrices and tensors, the same everywhere, of cells, or functions of the place.


Coefficient = ArrayLike | Mapping[str, ArrayLike] | Function
"""A constant, one for each cell (first axis), one for each named cell set, or a function of points (n, 2)."""

PLANE_STRAINS = np.array([[0, 2], [2, 1]])
"""Place among xx, yy, 2 xy of the strain that a component's (row) derivative by x or y adds to."""
ROUND_OFF = 1e-10
GRADIENTS, VALUES = "gradients", "values"
_ALLOWED = {
    GRADIENTS: "a number or a matrix (2, 2) for one field, (3, 3) for strains xx, yy, 2 xy, or (m, 2, m, 2) "
    "such as Elastic(...).stiffness",
    VALUES: "a number for one field, or a matrix (m, m) for m components",
}


@dataclass(frozen=True, eq=False)
class CellCoefficient:
    """A coefficient on the cells of a space, symmetric, as a tensor that multiplies gradients or values.

    Parameters
    ----------
    space
        The space.
    of
        What it multiplies: ``"gradients"``, shape (m, 2, m, 2), or ``"values"``, shape (m, m), of m components.
    n_components
        Number m of components of the field.
    values
        Tensors of all cells, or of each cell, shape (1 or n_cells, ...); None for a function.
    function
        Function of points (n, 2).

    """

    space: Space
    of: str
    n_components: int
    values: Floats | None
    function: Function | None = None

    @classmethod
    def on(cls, space: Space, given: Coefficient, of: str) -> "CellCoefficient":
        """Read what a user gives; anything else is an `InputError`."""
        if callable(given):
            there = _of_function(given, space.mesh.cell_centroids[:1].T, of)
            return cls(space, of, there.shape[1], None, given)
        if isinstance(given, Mapping):
            values = _of_sets(space, given)
        else:
            values = as_numbers("a coefficient", given, _ALLOWED[of])
            values = values[None] if values.ndim % 2 == 0 else values
            if len(values) not in (1, space.mesh.n_cells):
                raise InputError(
                    f"a coefficient of shape {np.shape(given)} for {space.mesh.n_cells} cells",
                    f"{_ALLOWED[of]}; one more axis in front holds those of the cells",
                    "give one for each cell",
                )
        if not np.isfinite(values).all():
            raise InputError("a coefficient that is not finite", "finite numbers", "correct it")
        tensors = _tensor(values, of)
        return cls(space, of, tensors.shape[1], tensors)

    def at(self, batch: CellBatch, points: Floats) -> Floats:
        """Tensors at points (n_points, 2, n_cells) of cells, shape (..., n_points or 1, n_cells or 1)."""
        if self.function is not None:
            tensors = _of_function(self.function, points, self.of)
            return np.moveaxis(tensors, 0, -1).reshape(*tensors.shape[1:], len(points), -1)
        assert self.values is not None
        chosen = self.values if len(self.values) == 1 else self.values[batch.cells]
        return np.moveaxis(chosen, 0, -1)[..., None, :]

    def along(self, points: Floats) -> Floats:
        """Tensors at points (n, 2), shape (..., n or 1); none of single cells."""
        tensors = self.values if self.function is None else _of_function(self.function, points.T, self.of)
        assert tensors is not None
        return np.moveaxis(tensors, 0, -1)


def _of_function(function: Function, points: Floats, of: str) -> Floats:
    """Tensors at points (..., 2, n_cells), shape (n, ...)."""
    values = at_points(function, points)
    n = points.size // 2
    return _tensor(
        np.moveaxis(values.reshape(-1, n), -1, 0).reshape(n, *values.shape[: values.ndim + 1 - points.ndim]), of
    )


def _of_sets(space: Space, given: Mapping[str, ArrayLike]) -> Floats:
    """Tensors of all cells from those of named sets, which must cover the mesh once."""
    parts = {name: as_numbers(f"the coefficient of cell set `{name}`", value) for name, value in given.items()}
    shapes = {value.shape for value in parts.values()}
    if len(shapes) != 1:
        raise InputError(f"coefficients of shapes {sorted(shapes)}", "one shape", "give matrices to all cell sets")
    return np.array(list(parts.values()))[set_numbers(space.mesh, parts, "coefficient")]


def _tensor(values: Floats, of: str) -> Floats:
    """Tensors (n, m, 2, m, 2) or (n, m, m) from what the user gives for each of n places."""
    shape = values.shape[1:]
    if of == VALUES and (not shape or (len(shape) == 2 and shape[0] == shape[1])):
        tensor = values.reshape(len(values), *(shape or (1, 1)))
        matrices = tensor
    elif of == GRADIENTS and shape in ((), (2, 2), (3, 3), (*shape[:1], 2, *shape[:1], 2)):
        if not shape:
            tensor = values[:, None, None, None, None] * np.eye(2)[:, None]
        elif shape == (2, 2):
            tensor = values[:, None, :, None, :]
        elif shape == (3, 3):
            tensor = values[:, PLANE_STRAINS[:, :, None, None], PLANE_STRAINS]
        else:
            tensor = values
        n = 2 * tensor.shape[1]
        matrices = tensor.reshape(len(values), n, n)
    else:
        raise InputError(f"a coefficient of shape {shape}", _ALLOWED[of], "give one of these")
    size = np.abs(matrices).max(axis=(1, 2))
    if (np.abs(matrices - matrices.swapaxes(1, 2)).max(axis=(1, 2)) > ROUND_OFF * size).any():
        raise InputError("a coefficient that is not symmetric", "symmetric matrices", "take its symmetric part")
    if of == GRADIENTS and not _positive(matrices, size).all():
        raise InputError(
            "a coefficient of gradients that is not positive", "positive numbers or matrices", "subtract a form"
        )
    return tensor


def _positive(matrices: Floats, size: Floats) -> Bools:
    """Which matrices are positive semidefinite and not zero."""
    values = np.linalg.eigvalsh(matrices)
    return (values[:, 0] >= -ROUND_OFF * size) & (values[:, -1] > 0.0)
