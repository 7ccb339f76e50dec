"""The factorisation behind forms: its choice, prescribed values, complex numbers, conditions and singular matrices."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import LinAlgWarning
from scipy.sparse.linalg import spsolve

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.forms import Factor, load, mass, solve, stiffness
from flangeway.geometry import square
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate
from flangeway.space import Space

SPACE = Space(dual(triangulate(square(1.0), size=0.1)), Virtual(2))
K, M = stiffness(SPACE), mass(SPACE)
SKEW = sp.csr_array(sp.triu(M, 1) - sp.tril(M, -1))
ELASTIC = Elastic(1.0, 0.3).stiffness
MATRICES = {
    "Cholesky": K + M,
    "LDLT": K - 50.0 * M,
    "LU": K + M + 20.0 * SKEW,
    "complex symmetric": K - (50.0 + 2.0j) * M,
    "complex": K + M + 20.0j * SKEW,
}


@pytest.mark.parametrize("kind", MATRICES)
def test_every_kind_of_matrix_is_solved_as_by_scipy(kind):
    """Real and complex, symmetric or not, with prescribed values: SciPy's solution to 1e-11, by the method named."""
    matrix, random = MATRICES[kind], np.random.default_rng(0)
    rhs, values = random.standard_normal((2, SPACE.n_dofs))
    if "complex" in kind:
        values = values + 1j * rhs
    fixed = SPACE.boundary_dofs("left")
    factor = Factor(matrix, fixed)
    assert factor.kind == ("LU" if "complex" in kind else kind)
    free = factor.free
    known = np.where(free, 0.0, values)
    wanted = known.astype(matrix.dtype) + 0.0
    wanted[free] = spsolve(sp.csc_array(matrix)[free][:, free], (rhs - matrix @ known)[free])
    np.testing.assert_allclose(factor.solve(rhs, values), wanted, atol=1e-11 * np.abs(wanted).max())
    np.testing.assert_allclose(factor.solve(2.0 * rhs, 2.0 * values), 2.0 * wanted, atol=1e-10 * np.abs(wanted).max())


def test_a_complex_load_of_a_real_matrix_keeps_its_imaginary_part():
    """The solution of ``b + i c`` is that of b plus i times that of c."""
    b, c = np.random.default_rng(1).standard_normal((2, SPACE.n_dofs))
    both = solve(K + M, b + 1j * c)
    np.testing.assert_allclose(both, solve(K + M, b) + 1j * solve(K + M, c), rtol=1e-12)


def test_the_condition_is_that_of_the_scaled_matrix():
    """Within a factor of three of NumPy's norms of the matrix of unit diagonal and its inverse, in any units."""
    dense = (K + M).toarray()
    scale = 1.0 / np.sqrt(np.diag(dense))
    unit = scale[:, None] * dense * scale
    wanted = np.linalg.norm(unit, np.inf) * np.linalg.norm(np.linalg.inv(unit), "fro")
    assert wanted / 3.0 < Factor(K + M).condition < 3.0 * wanted
    units = sp.diags_array(10.0 ** np.random.default_rng(2).integers(-6, 6, SPACE.n_dofs))
    assert Factor(sp.csr_array(units @ (K + M) @ units)).condition == pytest.approx(Factor(K + M).condition, rel=1.0)


SINGULAR = {
    "constant can be added": lambda s: (stiffness(s), load(s, 1.0), None),
    "slide in x and y and turn": lambda s: (stiffness(s, ELASTIC), load(s, (1.0, 0.0)), None),
    "rotation": lambda s: (stiffness(s, ELASTIC), load(s, (1.0, 0.0)), [0]),
    r"along \[1.0, 0.0\]": lambda s: (stiffness(s, ELASTIC), load(s, (1.0, 0.0)), _held_in_y(s)),
}


def _held_in_y(space):
    fixed = np.zeros((space.n_dofs, 2), dtype=bool)
    fixed[space.boundary_dofs("bottom"), 1] = True
    return fixed


@pytest.mark.parametrize(("order", "size"), [(1, 0.2), (2, 0.1), (1, 0.04)])
@pytest.mark.parametrize("words", SINGULAR)
def test_a_singular_matrix_names_the_motion_without_energy(words, order, size):
    """Neumann problems and bodies that can move, on coarse and fine meshes of three orders: the motion is named."""
    space = Space(dual(triangulate(square(1.0), size=size)), Virtual(order))
    matrix, rhs, fixed = SINGULAR[words](space)
    with pytest.raises(InputError, match=words):
        solve(matrix, rhs, fixed)


def test_a_nearly_singular_matrix_is_solved_with_a_warning():
    """A reaction of 2e-9 beside the Laplacian: a warning with the digits left, and as many are right."""
    matrix = K + 2e-9 * M
    with pytest.warns(LinAlgWarning, match="digits"):
        u = solve(matrix, load(SPACE, 2e-9))
    digits = Factor(matrix).digits
    assert 2.0 < digits < 4.0
    assert np.abs(u[: SPACE.n_nodes] - 1.0).max() < 10.0 ** (1.0 - digits)


def test_wrong_matrices_and_loads_are_refused():
    """A load that is not finite, a matrix of another shape and one with a NaN."""
    with pytest.raises(InputError, match="finite"):
        solve(K + M, np.full(SPACE.n_dofs, np.nan))
    with pytest.raises(InputError, match="finite"):
        Factor(K * np.nan)
    with pytest.raises(InputError, match="shape"):
        Factor(K[:5])


@pytest.mark.parametrize("shape", [(), (2,)])
def test_unknowns_that_are_all_prescribed_are_returned(shape):
    """No unknown is left: the prescribed values, for one component and for two."""
    matrix = stiffness(SPACE) if shape == () else stiffness(SPACE, ELASTIC)
    values = np.random.default_rng(3).standard_normal((SPACE.n_dofs, *shape))
    factor = Factor(matrix, np.arange(SPACE.n_dofs), 1 if shape == () else 2)
    np.testing.assert_array_equal(factor.solve(np.ones_like(values), values), values)
    assert factor.condition == 1.0


TWO = sp.csr_array(np.array([[2.0, 1.0], [1.0, 2.0]]))


@pytest.mark.parametrize("kind", [int, np.float32, np.complex64, np.float64])
def test_matrices_of_any_numbers_are_solved_in_double_precision(kind):
    """Whole numbers, single precision and complex numbers, dense or sparse: a third each."""
    for matrix in (TWO.astype(kind), TWO.astype(kind).tocoo(), TWO.toarray().astype(kind).tolist()):
        np.testing.assert_allclose(solve(matrix, [1, 1]), [1.0 / 3.0, 1.0 / 3.0], rtol=1e-15)


WRONG = {
    "no matrix": (None, [1.0, 1.0]),
    "no unknowns": (sp.csr_array((0, 0)), []),
    "a number for a load": (TWO, 5.0),
    "a text for a load": (TWO, "up"),
    "no load": (TWO, None),
    "a sparse load": (TWO, sp.csr_array([[1.0, 1.0]])),
    "values of another shape": (TWO, [1.0, 1.0], [0], [1.0, 2.0, 3.0]),
    "a text for values": (TWO, [1.0, 1.0], [0], "up"),
}


@pytest.mark.parametrize("name", WRONG)
def test_natural_mistakes_are_named(name):
    """What is no matrix, load or value is an `InputError`."""
    with pytest.raises(InputError):
        solve(*WRONG[name])
