"""A die that is pressed into a slab and slides along it ("shallow ironing"), beside five published curves.

The die, 1.2 mm wide with an arc of radius 0.75 mm below, ten times as stiff as the slab of 12 by 4 mm, is lowered by 1
mm from 0.2 mm above the slab (times 0 to 1) and then moved by 10 mm (1 to 2), friction 0.3 (K. A. Fischer and P.
Wriggers, 2006, Comput. Methods Appl. Mech. Eng. 195). The curves are those of Fischer and Wriggers, of S. Hartmann, J.
Oliver, R. Weyler, J. Cante and J. Hernandez (2009, ibid. 198), V. Yastrebov (2011, thesis, Mines ParisTech), K. Poulios
and Y. Renard (2015, Comput. Struct. 153) and Code_Aster's test SSNP153, as collected in numbers by I. Batistic, P.
Cardiff and Z. Tukovic (2022, Appl. Math. Model. 101; solids4foam, "solid-benchmarks"), interpolated at `TIMES`.
Yastrebov's are his own numbers, the others were read off the printed figures.

The published bodies are neo-Hookean in large deformation; ours are linear in small strains, with large sliding, though
the slab below the die is strained by about a third. So a number is asked to be between the least and the largest of the
published ones, which differ among themselves by up to a quarter in the normal and by a factor of 1.9 in the tangential
force. Only while the die is lowered do they agree on the ratio of both, from time 0.6 on within 9 %: there it is shown
only. Cells are as large as Batistic's. In steady sliding the work of the tangential force must be what friction
dissipates, whatever the strains.
"""

from dataclasses import dataclass, replace

import numpy as np

from flangeway.contact import Contact, ContactSolution, Multiplier, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, rectangle_grid
from flangeway.problems import Body, Part
from flangeway.solve import StepSettings
from flangeway.types import Bools, Floats
from studies.friction.blocks import shift
from studies.published_numbers import ReproducedNumber, compare

SLAB_MPA, POISSON, MU = 689.6, 0.32, 0.3
SLAB_MM, DIE_MM, ARC_MM, DIE_HEIGHT_MM, ARC_HEIGHT_MM = (12.0, 4.0), 1.2, 0.75, 1.2, 0.3
LEFT_MM, ABOVE_MM = 0.2, 0.2  # of the die's side from the slab's, and of its lowest point from the slab, at first
DOWN_MM, ALONG_MM, COMPUTED_MM = 1.0, 10.0, 6.0  # motions that time counts; we stop half-way, in steady sliding
CELLS, DIE_CELLS = (120, 30), (12, 6)
STEPS = (20, 300)  # those of sliding are as long as published: 500 of them in 10 mm
STEADY = (1.3, 1.5)  # times between which oscillation and work are measured
STEADY_WORK_LIMIT = 0.01
TIMES = (0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.02, 1.04, 1.1, 1.25, 1.5)
COMPARED = (0.6, 0.8, 1.0, 1.25, 1.5)
NORMAL_N_MM = {
    "Fischer, Wriggers 2006": (19.1, 52.0, 86.1, 122.2, 204.7, 297.9, 316.8, 334.9, 363.2, 368.1, 365.1),
    "Hartmann et al. 2009": (25.7, 58.4, 95.1, 133.9, 221.3, 319.5, 341.5, 364.3, 395.5, 408.4, 408.4),
    "Yastrebov 2011": (25.4, 56.8, 92.3, 127.8, 206.3, 289.7, 303.4, 319.1, 352.1, 366.1, 359.5),
    "Poulios, Renard 2015": (22.4, 50.8, 81.5, 114.1, 187.0, 267.9, 286.1, 303.1, 324.3, 334.9, 337.4),
    "Code_Aster SSNP153": (27.1, 59.4, 96.2, 135.3, 225.8, 332.0, 356.4, 377.5, 405.0, 419.7, 421.0),
}
"""Normal force per thickness at `TIMES`."""
TANGENTIAL_N_MM = {
    "Fischer, Wriggers 2006": (2.8, 8.8, 15.9, 22.0, 39.9, 62.1, 96.5, 129.5, 172.6, 190.4, 188.8),
    "Hartmann et al. 2009": (2.5, 9.3, 17.6, 25.6, 44.0, 67.2, 97.0, 131.2, 149.6, 158.8, 160.2),
    "Yastrebov 2011": (4.6, 10.6, 17.2, 24.9, 41.0, 58.5, 91.5, 126.5, 167.4, 171.8, 170.8),
    "Poulios, Renard 2015": (4.0, 9.3, 15.5, 22.1, 37.4, 55.3, 84.8, 103.3, 99.4, 100.2, 102.1),
    "Code_Aster SSNP153": (4.8, 11.3, 18.7, 26.7, 46.5, 71.0, 107.8, 137.7, 138.8, 141.3, 143.3),
}
"""Tangential force per thickness at `TIMES`."""
TITLE = "Ironing"


@dataclass(frozen=True, eq=False)
class Ironing:
    """Forces per thickness in each step, and what friction dissipated in it, shape (n_steps,)."""

    times: Floats
    normal: Floats
    tangential: Floats
    work: Floats

    def at(self, time: float) -> tuple[float, float]:
        """Normal and tangential force at a time."""
        return float(np.interp(time, self.times, self.normal)), float(np.interp(time, self.times, self.tangential))

    @property
    def steady(self) -> Bools:
        """Which steps are of steady sliding."""
        return (self.times > STEADY[0] + 1e-9) & (self.times < STEADY[1] + 1e-9)

    @property
    def oscillation(self) -> float:
        """Largest less least tangential force of steady sliding over its mean."""
        force = self.tangential[self.steady]
        return float(np.ptp(force) / force.mean())

    @property
    def works(self) -> tuple[float, float]:
        """What friction dissipates in steady sliding, and the work of the tangential force, in N mm per mm."""
        along = np.diff(self.times, prepend=0.0)[self.steady] * ALONG_MM
        means = (self.tangential + np.roll(self.tangential, 1))[self.steady] / 2.0
        return float(self.work[self.steady].sum()), float(along @ means)


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
    die_mesh = PolyMesh(points, grid.cell_offsets, grid.cell_points, {}, grid.edge_sets)
    die = Part("die", Body("die", die_mesh, Lagrange(1), Elastic(10.0 * SLAB_MPA, POISSON), "top"))
    slab = Part("slab", Body("slab", slab_mesh, Lagrange(1), Elastic(SLAB_MPA, POISSON), "bottom"))
    surfaces = Surface(die, die_mesh.edge_sets["bottom"]), Surface(slab, slab_mesh.edge_sets["top"])
    contact = Contact(*surfaces, SegmentToSegment(), Multiplier(), MU)
    path = [shift(die, 0.0, -DOWN_MM), shift(die, COMPUTED_MM, 0.0)]
    return press([contact], path, steps=[StepSettings(1.0 / n, 1.0 / n) for n in steps])


def ironing_of(solution: ContactSolution) -> Ironing:
    """Forces and dissipated work in each step of `ironed_slab`."""
    shares = np.array([step.share for step in solution.steps])
    times = np.where(shares < 1.0, shares, 1.0 + (shares - 1.0) * COMPUTED_MM / ALONG_MM)
    forces = np.array([replace(solution, state=step.state).forces[0] for step in solution.steps])
    return Ironing(times, forces[:, 1], -forces[:, 0], solution.dissipated_work)


def ironing_numbers(found: Ironing) -> list[ReproducedNumber]:
    """Forces and their ratio between the published ones; work and oscillation of steady sliding."""
    published = np.array([[*table.values()] for table in (NORMAL_N_MM, TANGENTIAL_N_MM)])
    numbers = []
    for time in COMPARED:
        normal, tangential = published[:, :, TIMES.index(time)]
        mine = found.at(time)
        for quantity, unit, values, value in (
            ("normal force", "N/mm", normal, mine[0]),
            ("tangential force", "N/mm", tangential, mine[1]),
            ("tangential over normal force", "1", tangential / normal, mine[1] / mine[0]),
        ):
            least, most = float(values.min()), float(values.max())
            shown_only = unit == "1" and time < 1.0
            code = f"time {time:g}, mean of {least:.3g} to {most:.3g}"
            given = TITLE, code, quantity, unit, (float(values.mean()), value), most / least - 1.0
            words = "" if shown_only else "among the five"
            numbers.append(compare(*given, words=words, within=least <= value <= most))
    dissipated = "work of the tangential force beside what friction dissipates"
    numbers.append(compare(TITLE, "steady sliding", dissipated, "N mm/mm", found.works, STEADY_WORK_LIMIT))
    oscillation = "oscillation of the tangential force over its mean"
    numbers.append(compare(TITLE, "steady sliding", oscillation, "1", (0.0, found.oscillation), 0.05, words=""))
    return numbers
