"""Cross-sections of beams: bending, shear, monosymmetry, plastic moments and all stresses, of one or more materials.

W. D. Pilkey (2002, "Analysis and Design of Elastic Beams", chapters 2, 5, 6). Constants are weighted by Young's
modulus: with ``young=1`` they are those of the shape alone.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.optimize
import shapely
from numpy.typing import ArrayLike

from flangeway.checks import check_between
from flangeway.errors import InputError
from flangeway.forms.weak import Field, integrals, local_functions, stiffness
from flangeway.mesh.mesh_checks import positive_by_cells
from flangeway.post.section_constants import SectionConstants, section_constants
from flangeway.post.stress import locate
from flangeway.solve.linear import Factor
from flangeway.space import CellBatch, Space
from flangeway.types import Floats

ByCells = float | Mapping[str, float]
"""A positive number for all cells, or for each named cell set."""


@dataclass(frozen=True, eq=False)
class BeamSection:
    """A cross-section; positions are about the weighted centroid but for `centroid` itself.

    Parameters
    ----------
    space
        Space on a mesh of the section, which hangs together.
    young
        Young's modulus E of all cells, or of each named cell set.
    poisson
        Poisson's ratio of all materials, 0 to 1/2.
    known
        Constants of this space, modulus and ratio, if they were computed before.

    Raises
    ------
    InputError
        If a modulus is not positive, Poisson's ratio is out of its range, or the sets do not cover the mesh once.

    """

    space: Space
    young: ByCells = 1.0
    poisson: float = 0.0
    known: SectionConstants | None = None

    def __post_init__(self) -> None:
        check_between("BeamSection", "poisson", self.poisson, 0.0, 0.5, advice="give Poisson's ratio")
        _ = self._moduli

    @cached_property
    def _constants(self) -> SectionConstants:
        return self.known or section_constants(self.space, shear_modulus=self.young, poisson=self.poisson)

    @property
    def _mean(self) -> float:
        """Mean Young's modulus over the area, which the constants are over."""
        return self._constants.warping.problem.mean_modulus

    def _by_cells(self, name: str, given: ByCells) -> Floats:
        """Number of each cell, (n_cells,)."""
        return positive_by_cells(self.space.mesh, "BeamSection", name, given)

    @cached_property
    def _moduli(self) -> Floats:
        return self._by_cells("young", self.young)

    @property
    def axial(self) -> float:
        """Axial stiffness EA."""
        return self._mean * self._constants.area

    @property
    def centroid(self) -> Floats:
        """Weighted centroid, (2,)."""
        return np.array(self._constants.centroid)

    @property
    def bending(self) -> Floats:
        """``int E y^2, int E x^2, int E x y``, (3,)."""
        return self._mean * np.array(self._constants.second_moments)

    @property
    def angle(self) -> float:
        """Angle in radians from the x axis to the axis of the maximum bending stiffness."""
        return self._constants.principal_angle

    @property
    def torsion(self) -> float:
        """Torsion constant weighted by E, from the warping function; over ``2 (1 + nu)`` the torsional rigidity."""
        return self._mean * self._constants.torsion_bounds[1]

    @property
    def shear_centre(self) -> Floats:
        """Shear centre with Poisson's ratio, about the centroid, (2,)."""
        return np.array(self._constants.shear_centre) - self.centroid

    def _parameters(self, x: Floats, y: Floats) -> Floats:
        """Pilkey's d and h, over nu / 2, (2, 2, ...): rows for shear along x and y."""
        xx, yy, xy = self.bending
        r, q = x * x - y * y, 2.0 * x * y
        return np.array([[xx * r - xy * q, xy * r + xx * q], [-xy * r + yy * q, -yy * r - xy * q]])

    @property
    def _delta(self) -> float:
        xx, yy, xy = self.bending
        return float(2.0 * (1.0 + self.poisson) * (xx * yy - xy**2))

    def _quadrature(self) -> Iterator[tuple[CellBatch, Floats, Floats]]:
        """Batches with points, and with x, y about the centroid and the weights times E, (3, n_points, n_cells)."""
        for batch in self.space.batches():
            points, weights = batch.quadrature(2 * self.space.order + 2)
            about = points.swapaxes(0, 1) - self.centroid[:, None, None]
            yield batch, points, np.stack((*about, weights * self._moduli[batch.cells]))

    @cached_property
    def _functions(self) -> tuple[Field, Floats, Floats]:
        """Warping and both shear functions (n_dofs, 3); the shear areas' products (2, 2) and ``int E x r^2`` (2,)."""
        space, (xx, yy, xy) = self.space, self.bending
        rhs, nu = np.zeros((space.n_dofs, 2)), self.poisson
        for batch, points, (x, y, weights) in self._quadrature():
            local = local_functions(batch, points)
            sources = 2 * (1 + nu) * (xx * x - xy * y), 2 * (1 + nu) * (yy * y - xy * x)
            for i, (source, flux) in enumerate(zip(sources, nu / 2.0 * self._parameters(x, y), strict=True)):
                np.add.at(rhs[:, i], batch.dofs, integrals(local, weights * np.array([source, *flux])))
        by_cells = self._moduli if isinstance(self.young, Mapping) else float(self._moduli[0])
        factor = Factor(stiffness(space, by_cells), np.array([0]))
        shear = [factor.solve(column) for column in rhs.T]
        functions = Field(space, np.stack([self._constants.warping.function, *shear], axis=1))
        products, cubic = np.zeros((2, 2)), np.zeros(2)
        for batch, points, (x, y, weights) in self._quadrature():
            gradient = functions.on(batch, points).gradient.reshape(*weights.shape, 3, 2)[..., 1:, :]
            flow = np.moveaxis(gradient, (2, 3), (0, 1)) - nu / 2.0 * self._parameters(x, y)
            products += np.einsum("ijqe,kjqe,qe->ik", flow, flow, weights)
            cubic += [(weights * f * (x * x + y * y)).sum() for f in (x, y)]
        return functions, products, cubic

    @property
    def shear_areas(self) -> Floats:
        """Shear areas along x and y and of both together, weighted by E, (3,); an infinite one where none couples."""
        kappa = self._functions[1]
        with np.errstate(divide="ignore"):
            return self._delta**2 / np.array([kappa[0, 0], kappa[1, 1], kappa[0, 1]])

    def monosymmetry(self, angle: float = 0.0) -> tuple[float, float]:
        """``int E v (u^2 + v^2) / EI_uu - 2 v_s`` and the same with u and v exchanged, axes u, v turned by an angle."""
        (xx, yy, xy), (c, s) = self.bending, (np.cos(angle), np.sin(angle))
        turn = np.array([[c, s], [-s, c]])
        cubic, centre = turn @ self._functions[2], turn @ self.shear_centre
        about = turn @ np.array([[yy, xy], [xy, xx]]) @ turn.T
        return float(cubic[1] / about[1, 1] - 2.0 * centre[1]), float(cubic[0] / about[0, 0] - 2.0 * centre[0])

    def plastic(self, yield_stress: ByCells = 1.0, angle: float = 0.0) -> tuple[float, float]:
        """Position of the plastic axis and plastic moment, bending about an axis turned by an angle from x.

        The position is along the normal of the axis, from the centroid; with a yield stress of one the moment is the
        plastic modulus. Exact for cells with straight edges, which are cut at the axis.
        """
        mesh = self.space.element_mesh
        stress, (c, s) = self._by_cells("yield_stress", yield_stress), (np.cos(angle), np.sin(angle))
        if mesh.curves is not None:
            raise InputError("plastic moments of curved edges", "straight edges", "take mesh.straight()")
        turned = replace(mesh, points=(mesh.points - self.centroid) @ np.array([[c, -s], [s, c]]))
        polygons = turned.polygons(np.arange(mesh.n_cells))
        left, low, right, high = shapely.bounds(polygons).T
        bottom, top = float(low.min()), float(high.max())

        def below(level: float) -> tuple[float, float]:
            """Weighted area and first moment below a level."""
            parts, cut = polygons.copy(), (low < level) & (level < high)
            room = shapely.box(left.min() - 1.0, bottom - 1.0, right.max() + 1.0, level)
            parts[cut] = shapely.intersection(polygons[cut], room)
            there = (low < level) & ~shapely.is_empty(parts)
            areas = stress[there] * shapely.area(parts[there])
            return float(areas.sum()), float(areas @ shapely.get_y(shapely.centroid(parts[there])))

        area, first_moment = below(top)
        level = scipy.optimize.brentq(lambda v: below(v)[0] - area / 2.0, bottom, top, xtol=1e-14 * (top - bottom))
        return float(level), first_moment - 2.0 * below(level)[1]

    def stresses(
        self,
        points: ArrayLike,
        *,
        force: float = 0.0,
        shear: tuple[float, float] = (0.0, 0.0),
        moments: tuple[float, float] = (0.0, 0.0),
        torque: float = 0.0,
    ) -> Floats:
        """Stresses zz, zx, zy at points (n, 2) of the section under all resultants at once, shape (n, 3).

        Parameters
        ----------
        points
            Points of the section; between materials either side may answer.
        force
            Axial force at the centroid, tension positive.
        shear
            Shear forces along x and y, through the shear centre.
        moments
            Bending moments about x and y by the right-hand rule with z out of the plane: a positive one about x pulls
            at positive y, one about y at negative x.
        torque
            Torque about the shear centre, counter-clockwise.

        """
        given, (xx, yy, xy) = np.asarray(points, dtype=np.float64), self.bending
        gradient = self._functions[0].gradient_at(given)
        x, y = (given - self.centroid).T
        determinant = xx * yy - xy**2
        about_x, about_y = moments
        axial = force / self.axial + (yy * about_x + xy * about_y) / determinant * y
        axial = axial - (xy * about_x + xx * about_y) / determinant * x
        d = self._parameters(x, y)
        tangential = torque / self.torsion * (gradient[:, 0] - np.stack((y, -x), axis=1))
        for i in range(2):
            tangential += shear[i] / self._delta * (gradient[:, 1 + i] - self.poisson / 2.0 * d[i].T)
        return self._moduli[locate(self.space.mesh, given), None] * np.column_stack((axial, tangential))
