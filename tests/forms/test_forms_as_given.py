"""What the third review found wrong with forms, refinement and polygons (rows H1, H2, H7, H10, H11)."""

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.forms import Factor, bilinear, load, mass, solve, stiffness
from flangeway.geometry import square
from flangeway.mesh import dual, triangulate
from flangeway.space import Space


def test_a_symmetric_positive_form_is_factorised_by_the_own_cholesky_method():
    """SuperLU with an unsuitable ordering took a minute."""
    space = Space(dual(triangulate(square(1.0), size=0.1)), Virtual(2))
    assert Factor(stiffness(space), space.boundary_dofs()).kind == "Cholesky"


def test_imaginary_parts_and_skew_parts_stay():
    """A complex form kept its real part only, and the assembly symmetrised what is not symmetric."""
    space = Space(dual(triangulate(square(1.0), size=0.3)), Virtual(2))
    skew = bilinear(space, lambda u, v, w: u.gradient[:, 0] * v.value - u.value * v.gradient[:, 0])
    assert abs(skew + skew.T).max() < 1e-13
    assert abs(skew).max() > 1e-2
    u = solve(stiffness(space) + 1j * mass(space), load(space, 1.0))
    np.testing.assert_allclose(u[: space.n_nodes], -1j, atol=1e-10)  # a constant: i u = 1


@pytest.mark.parametrize("form", [stiffness, mass, load])
def test_a_function_of_x_and_y_is_named(form):
    """H11: ``lambda x, y`` was a TypeError."""
    space = Space(dual(triangulate(square(1.0), size=0.3)), Virtual(1))
    with pytest.raises(InputError, match="points"):
        form(space, lambda x, y: x + y)
