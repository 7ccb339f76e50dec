"""Torsion constants of a square and a triangle of area one (Moherdaui 2021, Tables 4 to 7)."""

from collections import defaultdict
from collections.abc import Iterator
from functools import cache

import numpy as np

from flangeway.elements import Lagrange, Virtual
from flangeway.geometry import polygon, square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.problems import Torsion
from flangeway.problems.torsion_problem import Formulation, Load
from flangeway.solve import TorsionSolution, solve_torsion
from flangeway.space import Space
from flangeway_studies.study import Row, Run, published_rows
from flangeway_studies.torsion_bars import EquilateralTriangle, Rectangle

TRIANGLE = EquilateralTriangle(2.0 / 3.0**0.25)
SECTIONS = {
    "S": (square(1.0), Rectangle(1.0, 1.0), (10.0, 13.9, 20.0, 39.73)),
    "T": (polygon(TRIANGLE.corners), TRIANGLE, (16.0, 21.0, 31.0, 60.9)),
}
"""Outline, exact solution, and edges on a side for M1 to M4: Gmsh then makes the published numbers of points, or
nearly."""
LIMITS = {"h": 0.15, "n_dof": 0.05, "torsion_constant": 1e-3, "relative_error": 0.15}
UNITS = {"h": "side of area 1", "n_dof": "1", "torsion_constant": "area squared", "relative_error": "1"}
UNKNOWN_MESH = {("6", "VVSM3O2"), ("7", "VVTM3O2")}
UNKNOWN_MESH_LIMIT = 0.2
"""Of the errors near 1e-6 of these rows, which change by 60 % among meshes whose sizes differ by 4 %."""
UNKNOWN_MESH_NOTE = (
    "the published mesh is not known, and on meshes of sizes within 4 % the error is 0.8 to 1.8 times this"
)
AVERAGED = "load and constant by vertex averages, as in the published column"
PROJECTED = "load and constant by the projection (3.81), more accurate than the published vertex averages"
TITLES = {
    "4": "square, warping (Table 4)",
    "5": "triangle, warping (Table 5)",
    "6": "square, Prandtl (Table 6)",
    "7": "triangle, Prandtl (Table 7)",
}
METHODS = {"FD": "Lagrange triangles", "VD": "virtual triangles", "VV": "virtual polygons"}


@cache
def torsion_mesh(section: str, cells: str, level: int) -> PolyMesh:
    """Return a triangulation by Gmsh (Delaunay, ``"D"``), or its dual polygons (``"V"``), of refinement 1 to 4."""
    if cells == "V":
        return dual(torsion_mesh(section, "D", level))
    outline, _, n_edges = SECTIONS[section]
    return triangulate(outline, size=outline.segments[0].length / n_edges[level - 1])


def solve_code(code: str, formulation: Formulation, load: Load = "projected") -> TorsionSolution:
    """Solve a row such as ``VVSM3O2``; published VVO1 rows of Prandtl's function have the load ``"vertex_mean"``."""
    method, cells, section, level, order = code[0], code[1], code[2], int(code[4]), int(code[6])
    element = Virtual(order) if method == "V" else Lagrange(order)
    return solve_torsion(
        Torsion(Space(torsion_mesh(section, cells, level), element), formulation=formulation, load=load)
    )


def rows(run: Run) -> Iterator[Row]:
    """Rows of all tables, with the more accurate load beside the published one."""
    errors: dict[tuple[str, str], list[tuple[float, float]]] = defaultdict(list)
    for published in published_rows("torsion_tables_4_to_7.csv"):
        table, code, exact = published["table"], published["code"], SECTIONS[published["code"][2]][1]
        formulation: Formulation = "warping" if published["formulation"] == "warping" else "prandtl"
        averaged = formulation == "prandtl" and code[:2] == "VV" and code.endswith("1")
        loads: tuple[Load, ...] = ("vertex_mean", "projected") if averaged else ("projected",)
        for load in loads:
            solution = solve_code(code, formulation, load)
            space = solution.problem.space
            # Prandtl's unknowns are counted without those held on the boundary, as published
            held = np.unique(space.edge_nodes(solution.problem.boundary.outer)).size if formulation == "prandtl" else 0
            values = {
                "h": space.mesh.cell_diameters.max(),
                "n_dof": float(space.n_dofs - held),
                "torsion_constant": solution.torsion_constant,
                "relative_error": abs(solution.torsion_constant / exact.torsion_constant - 1.0),
            }
            if load == loads[0]:
                errors[table, f"{METHODS[code[:2]]}, order {code[-1]}"].append(
                    (values["n_dof"], values["relative_error"])
                )
            for name, value in values.items():
                wanted = float(published[name])
                if load == loads[0]:
                    unknown = name == "relative_error" and (table, code) in UNKNOWN_MESH
                    limit = UNKNOWN_MESH_LIMIT if unknown else LIMITS[name]
                    note = UNKNOWN_MESH_NOTE if unknown else AVERAGED if averaged else ""
                    yield Row(int(table), code, name, UNITS[name], value, wanted, limit, note)
                elif name in ("torsion_constant", "relative_error"):
                    yield Row(int(table), code, f"{name} (projected load)", UNITS[name], value, wanted, None, PROJECTED)
        point = float(published["n_dof"]), float(published["relative_error"])
        run.curve("torsion", TITLES[table], "published", point[:1], point[1:], "D")
    for (table, label), points in errors.items():
        x, y = zip(*points, strict=True)
        run.curve("torsion", TITLES[table], label, x, y, "o-")
