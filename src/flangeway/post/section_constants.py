"""Constants of a cross-section: area, second moments, torsion, shear centre, warping constant."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flangeway.checks import check_between
from flangeway.elements import Lagrange
from flangeway.geometry.arrays import as_point
from flangeway.problems import Torsion
from flangeway.solve import TorsionSolution, solve_torsion
from flangeway.space import Space
from flangeway.types import Floats

Pair = tuple[float, float]


EQUAL_MOMENTS = 1e-6
"""Relative difference of the principal moments that may come from coordinates of six digits, as files have them."""


@dataclass(frozen=True, eq=False)
class SectionConstants:
    """Constants of a cross-section, for several materials weighted by shear modulus over its mean.

    The weights are those of the Young's moduli too if all materials have one Poisson's ratio.

    Parameters
    ----------
    area
        Area.
    centroid
        Centroid.
    second_moments
        ``Ixx = int y^2``, ``Iyy = int x^2``, ``Ixy = int x y`` about the centroid.
    torsion_bounds
        Torsion constant from Prandtl's and from the warping function.
    bounds_certain
        Whether these enclose the exact constant of the meshed polygon: with Lagrange elements, or triangles of order 1.
    shear_centre_trefftz
        Shear centre by Trefftz (1935): about it the warping function is orthogonal to 1, x and y.
    shear_centre
        Shear centre with Poisson's ratio: no mean twist under a shear force (Pilkey, 2002, "Analysis and design of
        elastic beams", section 6.2; "elastic" elsewhere). For a Poisson's ratio of zero it is Trefftz's.
    warping_constant
        Integral of the warping function about Trefftz's shear centre squared, the least over all centres.
    warping
        Solution for the warping function, about the centroid.
    prandtl
        Solution for Prandtl's function.
    """

    area: float
    centroid: Pair
    second_moments: tuple[float, float, float]
    torsion_bounds: Pair
    bounds_certain: bool
    shear_centre_trefftz: Pair
    shear_centre: Pair
    warping_constant: float
    warping: TorsionSolution
    prandtl: TorsionSolution

    @property
    def torsion_constant(self) -> float:
        """Mean of `torsion_bounds`; half of their gap bounds or estimates its error."""
        return sum(self.torsion_bounds) / 2.0

    @property
    def principal_moments(self) -> Pair:
        """Largest and smallest second moment about axes through the centroid."""
        ixx, iyy, ixy = self.second_moments
        middle, radius = (ixx + iyy) / 2.0, float(np.hypot((ixx - iyy) / 2.0, ixy))
        return middle + radius, middle - radius

    @property
    def all_axes_principal(self) -> bool:
        """Whether both principal moments are equal, as of circles, squares, and all regular polygons."""
        maximum, smallest = self.principal_moments
        return maximum - smallest <= EQUAL_MOMENTS * maximum

    @property
    def principal_angle(self) -> float:
        """Angle in radians from the x axis to the axis of the maximum second moment, in (-pi/2, pi/2].

        Zero where both principal moments are equal, to `EQUAL_MOMENTS`: all axes through the centroid are principal.
        """
        ixx, iyy, ixy = self.second_moments
        if self.all_axes_principal:
            return 0.0
        return float(np.arctan2(-2.0 * ixy, ixx - iyy)) / 2.0


def section_constants(
    space: Space, *, shear_modulus: float | Mapping[str, float] = 1.0, poisson: float = 0.0
) -> SectionConstants:
    """Compute the constants of a cross-section from both formulations of torsion.

    Parameters
    ----------
    space
        Space on a mesh of the section.
    shear_modulus
        As in `Torsion`; only ratios matter here.
    poisson
        Poisson's ratio in [0, 0.5] of all materials, for `SectionConstants.shear_centre`.

    Raises
    ------
    InputError
        If the input of `Torsion` is wrong or Poisson's ratio out of range.
    """
    check_between("section_constants", "poisson", poisson, 0.0, 0.5, advice="leave 0 for Trefftz's shear centre")
    warping = solve_torsion(Torsion(space, shear_modulus, "warping"))
    prandtl = solve_torsion(Torsion(space, shear_modulus, "prandtl"))
    problem = warping.problem
    sums = _integrals(warping)
    ixx, iyy, ixy = sums.second
    determinant = ixx * iyy - ixy**2
    trefftz = np.array([ixy * sums.x_warping - iyy * sums.y_warping, ixx * sums.x_warping - ixy * sums.y_warping])
    trefftz /= determinant
    constant = sums.warping_square - trefftz[1] * sums.x_warping + trefftz[0] * sums.y_warping
    offset = poisson * sums.poisson_terms / (2.0 * (1.0 + poisson) * determinant)
    return SectionConstants(
        area=float(space.mesh.cell_areas.sum()),
        centroid=as_point(problem.centre),
        second_moments=(ixx, iyy, ixy),
        torsion_bounds=(prandtl.torsion_constant, warping.torsion_constant),
        bounds_certain=all(
            isinstance(batch.element, Lagrange) or (space.order == 1 and len(batch.vertices) == 3)
            for batch in space.batches()
        ),
        shear_centre_trefftz=as_point(problem.centre + trefftz),
        shear_centre=as_point(problem.centre + trefftz + offset),
        warping_constant=float(constant),
        warping=warping,
        prandtl=prandtl,
    )


@dataclass(frozen=True, eq=False)
class _Integrals:
    """Integrals over the section about its centroid, weighted by shear modulus over its mean.

    ``poisson_terms`` are the parts of the shear centre that come with Poisson's ratio nu, over nu and times
    ``2 (1 + nu) (Ixx Iyy - Ixy^2)``. Pilkey's shear functions are not needed: their products with the warping
    function follow from its own weak form.
    """

    second: tuple[float, float, float]
    x_warping: float
    y_warping: float
    warping_square: float
    poisson_terms: Floats


def _integrals(warping: TorsionSolution) -> _Integrals:
    problem = warping.problem
    space = problem.space
    moments, cubic, products = np.zeros(6), np.zeros(2), np.zeros(4)
    for batch in space.batches():
        reconstruction = batch.reconstruct()
        points, weights = batch.quadrature(2 * space.order + 1)
        weights = weights * (problem.cell_moduli[batch.cells] / problem.mean_modulus)
        monomials, local = reconstruction.at(points), warping.function[batch.dofs]
        value = np.einsum("aqe,ame,me->qe", monomials, reconstruction.projected_value, local, optimize=True)
        coefficients = np.einsum("aime,me->iae", reconstruction.value_gradient, local)
        slope = np.einsum("iae,aqe->iqe", coefficients, monomials[: coefficients.shape[1]])
        x, y = (points - problem.centre[:, None]).swapaxes(0, 1)
        moments += [float(np.sum(weights * f)) for f in (y * y, x * x, x * y, x * value, y * value, value**2)]
        square, half = x**2 + y**2, (x**2 - y**2) / 2.0
        cubic += [float(np.sum(weights * f * square)) / 2.0 for f in (x, y)]
        products += [
            float(np.sum(weights * f)) for f in (slope[0] * x * y, slope[0] * half, slope[1] * x * y, slope[1] * half)
        ]
    ixx, iyy, ixy = moments[:3]
    x_xy, x_half, y_xy, y_half = products
    terms = np.array(
        [
            iyy * cubic[0] + ixy * cubic[1] - (iyy * x_xy - ixy * x_half) + (ixy * y_xy + iyy * y_half),
            ixx * cubic[1] + ixy * cubic[0] + (ixx * x_half - ixy * x_xy) + (ixx * y_xy + ixy * y_half),
        ]
    )
    return _Integrals(
        (float(ixx), float(iyy), float(ixy)), float(moments[3]), float(moments[4]), float(moments[5]), terms
    )
