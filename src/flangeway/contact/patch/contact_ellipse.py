"""Separate patches of a contact: resultants, equivalent ellipses, and Hertz's contact beside them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flangeway.contact.patch.patch_grid import PatchGrid, separate_patches
from flangeway.exact import PointContact
from flangeway.types import Bools, Floats

ROUND_OFF = 1e-6
"""Cosine of an axis that is zero but for round-off."""
PARABOLIC = 0.05
"""Distance of gaps from a paraboloid over the approach, above which Hertz's contact has no meaning."""


@dataclass(frozen=True, eq=False)
class ContactEllipse:
    """One patch: its resultant, and the ellipse with the same second moments of pressure as Hertz's.

    Parameters
    ----------
    force
        Resultant on the second body, shape (2,).
    centre
        Centre of pressure (x, y, z), shape (3,).
    semi_axes
        Longer and shorter semi-axis of the ellipse under a Hertzian pressure with the patch's second moments.
    angle_rad
        From z to the longer semi-axis, towards the first body's tangent (counter-clockwise seen from above for a flat
        body: z up, x to the left), within pi / 2.
    max_pressure
        Maximum mean pressure of a cell.
    area
        Inside of the edge that pressures and gaps give, see `covered`.
    cells
        Maximum numbers of them across and along z.
    inside
        Which cells they are, shape (n_cells, n_strips).

    """

    force: Floats
    centre: Floats
    semi_axes: tuple[float, float]
    angle_rad: float
    max_pressure: float
    area: float
    cells: tuple[int, int]
    inside: Bools

    @property
    def widths(self) -> tuple[float, float]:
        """Widths of the ellipse across and along z."""
        long, short = self.semi_axes
        cos, sin = np.cos(self.angle_rad), np.sin(self.angle_rad)
        return 2.0 * float(np.hypot(long * sin, short * cos)), 2.0 * float(np.hypot(long * cos, short * sin))


@dataclass(frozen=True, eq=False)
class CellForces:
    """Normal forces on cells of a surface.

    Parameters
    ----------
    forces
        Shape (n_cells, n_strips).
    grid
        The cells.
    points, normals
        Middles of the cells and outward normals, each (n_cells, 2).
    gaps
        Of the deformed surfaces, shape as the forces.
    modulus
        Contact modulus.

    """

    forces: Floats
    grid: PatchGrid
    points: Floats
    normals: Floats
    gaps: Floats
    modulus: float

    @property
    def pressures(self) -> Floats:
        """Mean pressures of the cells, shape (n_cells, n_strips)."""
        return self.forces / self.grid.areas

    def patches(self, insides: Sequence[Bools] | None = None) -> list[ContactEllipse]:
        """Separate patches, or those of given cells, by falling force."""
        insides = separate_patches(self.forces > 0.0) if insides is None else insides
        found = [self._ellipse(inside) for inside in insides]
        return sorted(found, key=lambda each: -float(np.linalg.norm(each.force)))

    def _ellipse(self, inside: Bools) -> ContactEllipse:
        forces, grid = np.where(inside, self.forces, 0.0), self.grid
        total = float(forces.sum())
        by_cell, by_strip = forces.sum(axis=1) / total, forces.sum(axis=0) / total
        s, z = grid.stations - by_cell @ grid.stations, grid.along - by_strip @ grid.along
        # a cell's own second moments are those of its area
        mixed = float(s @ forces @ z) / total
        moments = np.array(
            [[by_strip @ z**2 + grid.strip**2 / 12.0, mixed], [mixed, by_cell @ (s**2 + grid.widths**2 / 12.0)]]
        )
        values, vectors = np.linalg.eigh(moments)
        # the cosine is not negative; where it is round-off, the sine is positive
        direction = vectors[:, 1]
        across = abs(direction[0]) < ROUND_OFF
        direction = direction * (1.0 if direction[int(across)] >= 0.0 else -1.0)
        return ContactEllipse(
            forces.sum(axis=1) @ self.normals,
            np.append(by_cell @ self.points, by_strip @ grid.along),
            (float(np.sqrt(5.0 * values[1])), float(np.sqrt(5.0 * values[0]))),
            float(np.arctan2(direction[1], direction[0])),
            float(self.pressures[inside].max()),
            self._area(inside),
            (int(inside.sum(axis=0).max()), int(inside.sum(axis=1).max())),
            inside,
        )

    def _area(self, inside: Bools) -> float:
        """Area of the polygon through the points at which the edge of a patch crosses the lines between middles."""
        steps, pressures = np.diff(self.grid.stations)[:, None], self.pressures
        across = covered(inside, pressures, self.gaps, self.modulus / steps)
        along = covered(inside.T, pressures.T, self.gaps.T, self.modulus / self.grid.strip).T
        # rectangles between four middles: corners inside, and the covered parts a and b of the sides that meet there
        low, high = slice(None, -1), slice(1, None)
        corners = [(inside[i, j], across[:, j], along[i]) for i in (low, high) for j in (low, high)]
        number = sum(corner.astype(int) for corner, _, _ in corners)
        triangle = sum(corner * a * b for corner, a, b in corners) / 2.0
        cut = sum(~corner * (1.0 - a) * (1.0 - b) for corner, a, b in corners) / 2.0
        return float((np.where(number > 1, 1.0 - cut, triangle) * steps).sum() * self.grid.strip)

    def hertz(self, patch: ContactEllipse, gaps: Floats, approach: float) -> PointContact | None:
        """Hertz's contact for the force of a patch and the curvatures of its gap; None where these vary too much.

        The curvatures are those of the paraboloid that fits the gaps of the cells under pressure best.

        Parameters
        ----------
        patch
            The patch.
        gaps
            Of the undeformed surfaces, shape as the forces.
        approach
            The gaps may be a share of it, `PARABOLIC`, off the paraboloid.

        """
        across, along = self.grid.middles
        z, s = (each[patch.inside] for each in np.meshgrid(along - patch.centre[2], across - across.mean()))
        values = gaps[patch.inside]
        terms = np.stack((np.ones(len(s)), s, z, s**2, s * z, z**2), axis=1)
        fit, *_ = np.linalg.lstsq(terms, values)
        least, most = np.linalg.eigvalsh([[2.0 * fit[3], fit[4]], [fit[4], 2.0 * fit[5]]])
        if not least > 0.0 or np.abs(terms @ fit - values).max() > PARABOLIC * approach:
            return None
        return PointContact(float(np.linalg.norm(patch.force)), 1.0 / least, 1.0 / most, self.modulus)


def covered(inside: Bools, pressures: Floats, gaps: Floats, stiffness: Floats | float) -> Floats:
    """Parts of the lines between middles of neighbours along the first axis that lie in a patch, shape (n - 1, m).

    At the distance d from the edge the pressure inside is ``p = K sqrt(d)``, and the gap outside is
    ``g = 4 K d^(3/2) / (3 E*)`` (Johnson, 1985, "Contact Mechanics", 5.1). Between middles at the distance h, of which
    one is under pressure and the other one open, the edge is at the part t with ``t^(1/2) / (1 - t)^(3/2) =
    4 h p / (3 E* g)``. It reaches a middle as that cell opens or closes: the edge moves on without a jump.

    - `inside`: cells of the patch, shape (n, m).
    - `pressures`, `gaps`: of all cells, shape (n, m).
    - `stiffness`: contact modulus over the distance, E* / h.
    """
    low, high = inside[:-1], inside[1:]
    pressure, gap = np.where(low, pressures[:-1], pressures[1:]), np.where(low, gaps[1:], gaps[:-1])
    ratio = 4.0 / 3.0 * pressure / (stiffness * np.maximum(gap, np.finfo(float).tiny))
    beyond = np.where(low, pressures[1:], pressures[:-1])
    ratio = np.where(beyond > 0.0, 2.0, ratio)  # the middle between it and another patch
    # u + u^3 = ratio with u^2 = t / (1 - t)
    u = np.sqrt(4.0 / 3.0) * np.sinh(np.arcsinh(np.sqrt(6.75) * ratio) / 3.0)
    return np.where(low & high, 1.0, np.where(low | high, u**2 / (1.0 + u**2), 0.0))
