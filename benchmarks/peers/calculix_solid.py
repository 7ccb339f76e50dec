"""Quarters and halves of two pressed bodies of C3D20 as CalculiX reads them, and the pressures that it writes.

A body is a grid of cells whose nodes any function places: abscissae across, up from the held side to the surface, and
along. Both are cut at z = 0, and at x = 0 if they are symmetric about it, where they are held by symmetry.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CORNERS = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2))
MIDDLES = (
    (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
    (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1),
)  # fmt: skip
FACES = (3, 5)
"""Numbers of the faces of a C3D20 at the lower and the upper end of the second direction."""


@dataclass(frozen=True)
class Solid:
    """A quarter, or half, of a body.

    Parameters
    ----------
    nodes
        Places, shape (n, 3).
    elements
        C3D20, shape (m, 20).
    held, surface, at_x, at_z
        Nodes of the held side, of the contact surface, and of the planes of symmetry; none at x in a half.
    faces
        Elements at the contact surface.
    face
        The number of their face there.

    """

    nodes: Floats
    elements: Ints
    held: Ints
    surface: Ints
    at_x: Ints
    at_z: Ints
    faces: Ints
    face: int


def solid(
    across: Floats, up: Floats, along: Floats, place: Callable[[Floats, Floats, Floats], Floats], *, upper: bool
) -> Solid:
    """Return a grid of cells between rising abscissae, its nodes placed by a function of three abscissae (n,) each.

    The function must keep the orientation of (across, up, along). An upper body has its surface where ``up`` begins.
    Where ``across`` begins below 0 it is a half.
    """
    each: list[Floats] = [np.sort(np.concatenate((ends, (ends[1:] + ends[:-1]) / 2.0))) for ends in (across, up, along)]
    shape = tuple(len(values) for values in each)
    grid = np.moveaxis(np.indices(shape), 0, -1)
    # a node of C3D20 has at most one odd index: no middles of faces and cells
    used = (grid % 2).sum(axis=-1) <= 1
    numbers = np.where(used, np.cumsum(used.ravel()).reshape(shape) - 1, -1)
    i, j, k = grid[used].T
    starts = 2 * np.indices([n // 2 for n in shape]).reshape(3, -1).T
    places = starts[:, None] + np.array((*CORNERS, *MIDDLES))
    elements = numbers[places[..., 0], places[..., 1], places[..., 2]]
    last = shape[1] - 1
    held, surface, face = (last, 0, FACES[0]) if upper else (0, last, FACES[1])
    touching = np.flatnonzero(starts[:, 1] == (0 if upper else last - 2))
    return Solid(
        place(each[0][i], each[1][j], each[2][k]), elements,
        np.flatnonzero(j == held), np.flatnonzero(j == surface),
        np.flatnonzero((i == 0) & (across[0] >= 0.0)), np.flatnonzero(k == 0), touching, face,
    )  # fmt: skip


def deck(lower: Solid, upper: Solid, *, young: float, poisson: float, penalty: float, approach: float) -> str:
    """Input of the upper body's held side moved down by the approach, the lower one's held."""
    first, first_element = len(lower.nodes), len(lower.elements)
    lines = ["*NODE, NSET=ALL"]
    places = np.vstack((lower.nodes, upper.nodes)).tolist()
    lines += [f"{number},{x:.12g},{y:.12g},{z:.12g}" for number, (x, y, z) in enumerate(places, start=1)]
    lines.append("*ELEMENT, TYPE=C3D20, ELSET=EALL")
    for number, nodes in enumerate((np.vstack((lower.elements, upper.elements + first)) + 1).tolist(), start=1):
        lines += [f"{number}," + ",".join(map(str, nodes[:10])) + ",", ",".join(map(str, nodes[10:]))]
    sets = {
        "BASE": lower.held, "TOP": upper.held + first,
        "ATX": np.union1d(lower.at_x, upper.at_x + first), "ATZ": np.union1d(lower.at_z, upper.at_z + first),
        "TOUCHING": np.union1d(lower.surface, upper.surface + first),
    }  # fmt: skip
    sets = {name: nodes for name, nodes in sets.items() if len(nodes)}
    for name, nodes in sets.items():
        lines += [f"*NSET, NSET={name}", *(f"{node}," for node in (nodes + 1).tolist())]
    for name, body, before in (("LOWER", lower, 0), ("UPPER", upper, first_element)):
        faces = (body.faces + 1 + before).tolist()
        lines += [f"*SURFACE, NAME={name}, TYPE=ELEMENT", *(f"{element},S{body.face}" for element in faces)]
    lines += [
        "*MATERIAL, NAME=STEEL", "*ELASTIC", f"{young},{poisson}", "*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL",
        "*SURFACE INTERACTION, NAME=HARD", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{penalty:.6g}",
        "*CONTACT PAIR, INTERACTION=HARD, TYPE=SURFACE TO SURFACE", "UPPER,LOWER",
        "*BOUNDARY", "BASE,1,3", "TOP,1,1", "TOP,3,3", *(["ATX,1,1"] if "ATX" in sets else []), "ATZ,3,3",
        "*STEP, INC=1000", "*STATIC", "0.5,1.",
        "*BOUNDARY", f"TOP,2,2,{-approach:.14g}",
        "*NODE PRINT, NSET=BASE, TOTALS=ONLY, FREQUENCY=1000", "RF",
        "*NODE FILE, NSET=TOUCHING, FREQUENCY=1000", "U", "*EL FILE, NSET=TOUCHING, FREQUENCY=1000", "S",
        "*END STEP",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def read(path: Path) -> tuple[dict[int, list[float]], float]:
    """Stresses xx, yy, zz, xy, yz, zx of the surfaces' nodes, by number from 1, and the force on the base."""
    stresses: dict[int, list[float]] = {}
    block = ""
    for line in path.with_suffix(".frd").read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith(" -4"):
            block = line[5:13].strip()
        elif line.startswith(" -3"):
            block = ""
        elif line.startswith(" -1") and block == "STRESS":
            stresses[int(line[3:13])] = [float(line[13 + 12 * i : 25 + 12 * i]) for i in range(6)]
    forces = path.with_suffix(".dat").read_text(encoding="ascii").split()
    return stresses, float(forces[-2])


def middle_pressure(lower: Solid, upper: Solid, stresses: dict[int, list[float]]) -> float:
    """Mean of the pressures at the first touch of both surfaces."""
    found = []
    for body, before in ((lower, 0), (upper, len(lower.nodes))):
        node = int(body.surface[np.abs(body.nodes[body.surface]).sum(axis=1).argmin()])
        found.append(-stresses[node + 1 + before][1])
    return float(np.mean(found))
