"""The published torsion constants on the meshes of Table 3, computed again (Moherdaui 2021, Tables 3 to 7)."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from flangeway.elements import Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.exact import EquilateralTriangle, Rectangle, TorsionSection
from flangeway.geometry import Outline, polygon, square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.problems import Torsion
from flangeway.problems.torsion_problem import Formulation, Load
from flangeway.solve import TorsionSolution, solve_torsion
from flangeway.space import Space

Method = Literal["F", "V"]
Cells = Literal["D", "V"]
Section = Literal["S", "T"]

SQUARE_EDGES = (10.0, 13.9, 20.0, 39.73)
TRIANGLE_EDGES = (16.0, 21.0, 31.0, 60.9)
"""Edges on a side for M1 to M4: Gmsh then makes the published numbers of points, or nearly."""


@dataclass(frozen=True)
class TorsionCode:
    """One code of Table 3, such as ``VVSM3O2``.

    Parameters
    ----------
    method
        ``"F"`` for Lagrange, ``"V"`` for virtual elements.
    cells
        ``"D"`` for triangles, ``"V"`` for their dual polygons.
    section
        ``"S"`` for the square, ``"T"`` for the equilateral triangle, of area one.
    level
        Refinement, 1 to 4.
    order
        Order of the elements, 1 or 2.

    """

    method: Method
    cells: Cells
    section: Section
    level: int
    order: int

    def __str__(self) -> str:
        return f"{self.method}{self.cells}{self.section}M{self.level}O{self.order}"

    @classmethod
    def parse(cls, code: str) -> "TorsionCode":
        """Read a code of Table 3."""
        for known in torsion_codes():
            if str(known) == code:
                return known
        raise InputError(f"torsion code {code!r}", "a code of Table 3 such as FDSM1O1 or VVTM4O2", "correct it")


@dataclass(frozen=True, eq=False)
class TorsionRow:
    """One computed row of Tables 4 to 7.

    Parameters
    ----------
    table
        Number of the published table, 4 to 7.
    formulation
        ``"warping"`` or ``"prandtl"``.
    load
        Reading of Prandtl's load, see `Torsion`.
    code
        Mesh and element.
    size
        Maximum diameter of the cells.
    n_dofs
        Unknowns of the space, all counted.
    n_free
        Unknowns that are solved for.
    exact
        Torsion constant in closed form.
    solution
        The solution.

    """

    table: int
    formulation: Formulation
    load: Load
    code: TorsionCode
    size: float
    n_dofs: int
    n_free: int
    exact: float
    solution: TorsionSolution

    @property
    def torsion_constant(self) -> float:
        """Computed torsion constant."""
        return self.solution.torsion_constant

    @property
    def relative_error(self) -> float:
        """Relative error with its sign: positive if the computed constant is too large."""
        return self.torsion_constant / self.exact - 1.0


def torsion_codes() -> tuple[TorsionCode, ...]:
    """The 48 codes of Table 3, in its order."""
    pairs: tuple[tuple[Method, Cells], ...] = (("F", "D"), ("V", "D"), ("V", "V"))
    sections: tuple[Section, ...] = ("S", "T")
    return tuple(
        TorsionCode(method, cells, section, level, order)
        for section in sections
        for method, cells in pairs
        for order in (1, 2)
        for level in (1, 2, 3, 4)
    )


def torsion_section(section: Section) -> tuple[Outline, TorsionSection]:
    """Outline of a section of area one, and its exact solution in the same coordinates."""
    if section == "S":
        return square(1.0), Rectangle(1.0, 1.0)
    exact = EquilateralTriangle(2.0 / 3.0**0.25)
    return polygon(exact.corners), exact


@cache
def torsion_mesh(section: Section, cells: Cells, level: int) -> PolyMesh:
    """Mesh of Table 3: a triangulation by Gmsh (Delaunay), or its dual polygons."""
    if cells == "V":
        return dual(torsion_mesh(section, "D", level))
    outline, _ = torsion_section(section)
    side = outline.segments[0].length
    n_edges = (SQUARE_EDGES if section == "S" else TRIANGLE_EDGES)[level - 1]
    return triangulate(outline, size=side / n_edges)


def torsion_row(
    code: TorsionCode,
    formulation: Formulation,
    load: Load = "projected",
) -> TorsionRow:
    """Compute one row; the published VVO1 rows of Tables 6 and 7 come out with the load ``"vertex_mean"``."""
    mesh = torsion_mesh(code.section, code.cells, code.level)
    space = Space(mesh, Virtual(code.order) if code.method == "V" else Lagrange(code.order))
    problem = Torsion(space, formulation=formulation, load=load)
    held = np.unique(space.edge_nodes(problem.boundary.outer)).size if formulation == "prandtl" else 1
    return TorsionRow(
        table=4 + (code.section == "T") + 2 * (formulation == "prandtl"),
        formulation=formulation,
        load=load,
        code=code,
        size=float(mesh.cell_diameters.max()),
        n_dofs=space.n_dofs,
        n_free=space.n_dofs - held,
        exact=torsion_section(code.section)[1].torsion_constant,
        solution=solve_torsion(problem),
    )


def torsion_rows(*, levels: tuple[int, ...] = (1, 2, 3, 4)) -> Iterator[TorsionRow]:
    """Rows of Tables 4 to 7 in their order: 96 in the published reading, and 8 more in the other one.

    The other reading, the projected load of Prandtl's function on dual polygons of order 1, follows its row.
    """
    formulations: tuple[Formulation, ...] = ("warping", "prandtl")
    for formulation in formulations:
        for code in torsion_codes():
            if code.level not in levels:
                continue
            both = formulation == "prandtl" and code.cells == "V" and code.order == 1
            if both:
                yield torsion_row(code, formulation, "vertex_mean")
            yield torsion_row(code, formulation, "projected")


def published_reading(row: TorsionRow) -> bool:
    """Whether a row is in the reading that the published tables need."""
    both = row.formulation == "prandtl" and row.code.cells == "V" and row.code.order == 1
    return (row.load == "vertex_mean") == both


def convergence_rate(sizes: np.ndarray, errors: np.ndarray) -> float:
    """Exponent p of the least-squares fit ``error = c size^p`` in logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0])
