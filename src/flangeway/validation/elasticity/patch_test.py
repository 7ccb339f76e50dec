"""A square under uniform tension (Moherdaui 2021, 5.2.1), which every method must reproduce."""

from dataclasses import dataclass

import numpy as np

from flangeway.cases.bodies.cook import method_space, published_virtual
from flangeway.elements import Element, Lagrange
from flangeway.errors import InputError
from flangeway.geometry import polygon
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.post import corner_stresses
from flangeway.problems import Elasticity, PrescribedDisplacement, Traction
from flangeway.solve import ElasticitySolution, solve_elasticity
from flangeway.space import Space

SIDE, SIZE, TENSION = 1.0, 0.22, 1.0
YOUNG, POISSON = 20e3, 1.0 / 3.0
"""Lengths in cm, stresses in kN/cm^2. The text does not tell the published side, mesh and tension: none matters."""

METHODS = ("FD", "VD", "VV", "HE")


@dataclass(frozen=True)
class PatchCode:
    """One configuration, such as ``VVPTO1`` (Moherdaui 2021, Figure 52).

    Parameters
    ----------
    method
        ``"FD"`` for Lagrange triangles, ``"VD"`` for virtual triangles, ``"VV"`` for virtual polygons, ``"HE"`` for
        Lagrange triangles inside and virtual quadrilaterals with two aligned edges at the boundary.
    order
        Order of the elements.

    """

    method: str
    order: int

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"PatchCode(method={self.method!r})", ", ".join(METHODS), "choose one of these")

    def __str__(self) -> str:
        return f"{self.method}PTO{self.order}"

    @property
    def published(self) -> bool:
        """Whether Moherdaui (2021) shows or names it."""
        return self.method in ("FD", "VV") and self.order <= 2


@dataclass(frozen=True, eq=False)
class PatchRow:
    """One solution.

    Parameters
    ----------
    code
        Its configuration.
    n_unknowns
        Components of displacement at nodes; those inside cells are condensed.
    stresses
        Value of a corner with the maximum difference from the exact one, over the tension: xx, xy, yy.
    displacement_error
        Maximum error of a node's displacement over the maximum displacement.
    solution
        The solution.

    """

    code: PatchCode
    n_unknowns: int
    stresses: tuple[float, float, float]
    displacement_error: float
    solution: ElasticitySolution

    @property
    def stress_error(self) -> float:
        """Maximum error of a stress over the tension."""
        xx, xy, yy = self.stresses
        return max(abs(xx - 1.0), abs(xy), abs(yy))


def patch_codes(orders: tuple[int, ...] = (1, 2, 3, 4)) -> tuple[PatchCode, ...]:
    """All configurations; there is no Lagrange triangle of order 4."""
    return tuple(
        PatchCode(method, order) for order in orders for method in METHODS if order < 4 or method in ("VD", "VV")
    )


def patch_row(code: PatchCode) -> PatchRow:
    """Pull the square to the right, held on the left along x and in one corner along y, in plane strain."""
    space = _space(code)
    material = Elastic(YOUNG, POISSON)
    supports = [PrescribedDisplacement("left", x=0.0), PrescribedDisplacement((0.0, 0.0), y=0.0)]
    solution = solve_elasticity(
        Elasticity(space, material, loads=[Traction("right", (TENSION, 0.0))], supports=supports)
    )
    stresses = corner_stresses(solution.problem, solution.displacements).components[:, [0, 2, 1]] / TENSION
    exact = np.array([1.0, 0.0, 0.0])
    worst = np.abs(stresses - exact).argmax(axis=0)
    xx, xy, yy = stresses[worst, [0, 1, 2]].tolist()
    stretch = np.array([1.0 - POISSON**2, -POISSON * (1.0 + POISSON)]) * TENSION / YOUNG
    wanted = space.nodes * stretch
    error = np.abs(solution.displacements[: space.n_nodes] - wanted).max() / np.abs(wanted).max()
    return PatchRow(code, 2 * space.n_nodes, (xx, xy, yy), float(error), solution)


def _space(code: PatchCode) -> Space:
    corners = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)]
    triangles = triangulate(polygon(corners, names=("bottom", "right", "top", "left")), size=SIZE)
    if code.method == "VD":
        element: Element = published_virtual(code.order)
        return Space(triangles, element)
    if code.method == "FD":
        return Space(triangles, Lagrange(code.order))
    return method_space(triangles, code.method[0], code.order)
