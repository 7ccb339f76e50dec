"""A die that is pressed into a slab and slides along it ("shallow ironing"), beside five published curves.

The die, 1.2 mm wide with an arc of radius 0.75 mm below, ten times as stiff as the slab of 12 by 4 mm, is lowered by 1
mm from 0.2 mm above the slab (times 0 to 1) and then moved by 10 mm (1 to 2), friction 0.3 (K. A. Fischer and P.
Wriggers, 2006, Comput. Methods Appl. Mech. Eng. 195). The curves are those of Fischer and Wriggers, of S. Hartmann, J.
Oliver, R. Weyler, J. Cante and J. Hernandez (2009, ibid. 198), V. Yastrebov (2011, thesis, Mines ParisTech), K. Poulios
and Y. Renard (2015, Comput. Struct. 153) and Code_Aster's test SSNP153, as collected in numbers by I. Batistic, P.
Cardiff and Z. Tukovic (2022, Appl. Math. Model. 101; solids4foam, "solid-benchmarks"), see
``flangeway_studies/data/friction.csv``.

The published bodies are neo-Hookean in large deformation; ours are linear in small strains, with large sliding, though
the slab below the die is strained by about a third. So a number is asked to be between the least and the largest of the
published ones, which differ among themselves by up to a quarter in the normal and by a factor of 1.9 in the tangential
force. Only while the die is lowered do they agree on the ratio of both, from time 0.6 on within 9 %: there it is shown
only. Cells are as large as Batistic's. In steady sliding the work of the tangential force must be what friction
dissipates, whatever the strains.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flangeway.contact import ContactSolution, Surface, press
from flangeway.elements import Lagrange
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Body, Part
from flangeway.solve import StepSettings
from flangeway_studies.friction.blocks import Solved, shift, touching
from flangeway_studies.study import Limit, Row, published_values

SLAB_MPA, POISSON, MU = 689.6, 0.32, 0.3
SLAB_MM, DIE_MM, ARC_MM, DIE_HEIGHT_MM, ARC_HEIGHT_MM = (12.0, 4.0), 1.2, 0.75, 1.2, 0.3
LEFT_MM, ABOVE_MM = 0.2, 0.2  # of the die's side from the slab's, and of its lowest point from the slab, at first
DOWN_MM, ALONG_MM, COMPUTED_MM = 1.0, 10.0, 6.0  # motions that time counts; we stop half-way, in steady sliding
CELLS, DIE_CELLS = (120, 30), (12, 6)
STEPS = (20, 300)  # those of sliding are as long as published: 500 of them in 10 mm
STEADY = (1.3, 1.5)  # times between which oscillation and work are measured
STEADY_WORK_LIMIT = 0.01
COMPARED = (0.6, 0.8, 1.0, 1.25, 1.5)


def ironed_slab(*, cells: tuple[int, int] = CELLS, steps: tuple[int, int] = STEPS) -> ContactSolution:
    """The die pressed into the slab and moved along it, with a die whose cells are as wide as the slab's."""
    slab_mesh = rectangle_grid(*SLAB_MM, *cells)
    across = round(DIE_CELLS[0] * cells[0] / CELLS[0])
    grid = rectangle_grid(1.0, 1.0, across, max(across // 2, 1))
    s, up = grid.points.T
    angle = (2.0 * s - 1.0) * np.arcsin(DIE_MM / 2.0 / ARC_MM)
    lowest = np.array([LEFT_MM + DIE_MM / 2.0, SLAB_MM[1] + ABOVE_MM])
    below = lowest + ARC_MM * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    above = np.column_stack((LEFT_MM + DIE_MM * s, np.full(len(s), lowest[1] + DIE_HEIGHT_MM)))
    points = (1.0 - up)[:, None] * below + up[:, None] * above
    die_mesh = replace(grid, points=points)
    die = Part("die", Body("die", die_mesh, Lagrange(1), Elastic(10.0 * SLAB_MPA, POISSON), "top"))
    slab = Part("slab", Body("slab", slab_mesh, Lagrange(1), Elastic(SLAB_MPA, POISSON), "bottom"))
    surfaces = Surface(die, die_mesh.edge_sets["bottom"]), Surface(slab, slab_mesh.edge_sets["top"])
    contact = touching(*surfaces, MU)
    path = [shift(die, 0.0, -DOWN_MM), shift(die, COMPUTED_MM, 0.0)]
    return press([contact], path, steps=[StepSettings(1.0 / n, 1.0 / n) for n in steps])


def ironing_rows(solved: Solved) -> Iterator[Row]:
    """Forces and their ratio between the published ones; work and oscillation of steady sliding."""
    solution = solved(ironed_slab())
    shares = np.array([step.share for step in solution.steps])
    times = np.where(shares < 1.0, shares, 1.0 + (shares - 1.0) * COMPUTED_MM / ALONG_MM)
    forces = np.array([replace(solution, state=step.state).forces[0] for step in solution.steps])
    computed = {"normal": forces[:, 1], "tangential": -forces[:, 0]}
    published = {case: published_values("friction.csv", case) for case in computed}
    for case, values in published.items():
        for name in dict.fromkeys(name for _, name in values):
            points = [(float(time), value) for (time, other), value in values.items() if other == name]
            solved.run.curve("ironing", f"{case} force", name, *np.transpose(points), "o-")  # type: ignore[call-arg]
        solved.run.curve("ironing", f"{case} force", "flangeway, small strains", times, computed[case], "-")
    for time in COMPARED:
        normal, tangential = (
            np.array([value for (code, _), value in published[case].items() if float(code) == time])
            for case in computed
        )
        computed_forces = [float(np.interp(time, times, force)) for force in computed.values()]
        for quantity, unit, reference, value in (
            ("normal force", "N/mm", normal, computed_forces[0]),
            ("tangential force", "N/mm", tangential, computed_forces[1]),
            ("tangential over normal force", "1", tangential / normal, computed_forces[1] / computed_forces[0]),
        ):
            least, most = reference.min(), reference.max()
            limit = None if unit == "1" and time < 1.0 else Limit("among the five", least <= value <= most)
            code = f"time {time:g}, mean of {least:.3g} to {most:.3g}"
            yield Row("Ironing", code, quantity, unit, value, reference.mean(), limit)
    steady = (times > STEADY[0] + 1e-9) & (times < STEADY[1] + 1e-9)
    force = computed["tangential"]
    along, means = np.diff(times, prepend=0.0) * ALONG_MM, (force + np.roll(force, 1)) / 2.0
    work, dissipated = (along[steady] @ means[steady]), solution.dissipated_work[steady].sum()
    quantity = "work of the tangential force beside what friction dissipates"
    yield Row("Ironing", "steady sliding", quantity, "N mm/mm", work, dissipated, STEADY_WORK_LIMIT)
    oscillation = np.ptp(force[steady]) / force[steady].mean()
    yield Row("Ironing", "steady sliding", "oscillation of the tangential force over its mean", "1", oscillation)
