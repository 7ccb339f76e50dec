"""The block's problem as CalculiX reads it, and the contact pressures that it writes."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def deck(
    points: Floats,
    triangles: tuple[Ints, Ints],
    edges: tuple[Ints, Ints],
    held: tuple[Ints, Ints],
    *,
    young: float,
    poisson: float,
    penalty: float,
    approach: float,
    n_steps: int,
    friction: float = 0.0,
    shift: float = 0.0,
) -> str:
    """Input of a cylinder moved down onto a block.

    Parameters
    ----------
    points
        Nodes of both bodies, shape (n, 2).
    triangles
        CPE6 of the cylinder and of the block, each (m, 6).
    edges
        Contact edges' ends of the cylinder (the dependent surface) and of the block, each (k, 2).
    held
        Nodes of the cut and of the base.
    young, poisson
        Of both bodies.
    penalty
        Contact pressure per penetration.
    approach
        Motion of the cut, in equal increments.
    n_steps
        Their number.
    friction, shift
        Coefficient of friction, and motion of the cut to the right in a further step where there is one.

    """
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{number},{x:.14g},{y:.14g},0." for number, (x, y) in enumerate(points.tolist(), start=1)]
    lines.append("*ELEMENT, TYPE=CPE6, ELSET=EALL")
    both = np.vstack(triangles)
    lines += [f"{number}," + ",".join(map(str, nodes)) for number, nodes in enumerate((both + 1).tolist(), start=1)]
    for name, nodes in zip(("CUT", "BASE"), held, strict=True):
        lines += [f"*NSET, NSET={name}", *(f"{node}," for node in (nodes + 1).tolist())]
    for name, pairs in zip(("CYLINDER", "BLOCK"), edges, strict=True):
        lines += [f"*SURFACE, NAME={name}, TYPE=ELEMENT", *_faces(both, pairs)]
    lines += [
        "*MATERIAL, NAME=STEEL", "*ELASTIC", f"{young},{poisson}",
        "*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL", "1.",
        "*SURFACE INTERACTION, NAME=HARD", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{penalty:.6g}",
        *(["*FRICTION", f"{friction},{penalty:.6g}"] if friction else []),
        "*CONTACT PAIR, INTERACTION=HARD, TYPE=SURFACE TO SURFACE", "CYLINDER,BLOCK",
        "*BOUNDARY", "BASE,1,2", "CUT,1,1",
        "*STEP, INC=1000", "*STATIC, DIRECT", f"{1.0 / n_steps},1.",
        "*BOUNDARY", f"CUT,2,2,{-approach:.14g}",
        "*NODE PRINT, NSET=BASE, TOTALS=ONLY, FREQUENCY=1000", "RF",
        "*CONTACT FILE, FREQUENCY=1000", "CSTR",
        "*END STEP",
    ]  # fmt: skip
    if friction:
        lines += [
            "*STEP, INC=1000", "*STATIC, DIRECT", f"{1.0 / n_steps},1.",
            "*BOUNDARY", f"CUT,2,2,{-approach:.14g}", f"CUT,1,1,{shift:.14g}", "*END STEP",
        ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _faces(triangles: Ints, pairs: Ints) -> Iterator[str]:
    """Element and number of the face of each pair of ends."""
    wanted = {frozenset(pair) for pair in pairs.tolist()}
    for number, corners in enumerate(triangles[:, :3].tolist(), start=1):
        for face in range(3):
            if frozenset((corners[face], corners[(face + 1) % 3])) in wanted:
                yield f"{number},S{face + 1}"


def read(path: Path) -> tuple[Floats, Floats, float]:
    """Places and pressures of the nodes in contact, and the force on the base, from ``path.frd`` and ``path.dat``."""
    x, values, forces = read_tractions(path)
    return x, values[:, 0], float(forces[1])


def read_tractions(path: Path) -> tuple[Floats, Floats, Floats]:
    """Places of nodes in contact (n,), pressures and tangential tractions (n, 2), and the force on the base x and y.

    A plane element is written with the thickness that it is computed with: nodes are found again by their place.
    """
    places: dict[int, tuple[float, float]] = {}
    pressures: dict[int, tuple[float, float]] = {}
    block = ""
    for line in path.with_suffix(".frd").read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith("    2C"):
            block = "nodes"
        elif line.startswith(" -4"):
            block = line[5:13].strip()
        elif line.startswith(" -3"):
            block = ""
        elif line.startswith(" -1") and block in ("nodes", "CONTACT"):
            number = int(line[3:13])
            values = [float(line[13 + 12 * i : 25 + 12 * i]) for i in range(min(6, (len(line) - 13) // 12))]
            if block == "nodes":
                places[number] = (values[0], values[1])
            else:
                pressures[number] = values[3], values[4]
    forces = path.with_suffix(".dat").read_text(encoding="ascii").split()
    found: dict[float, tuple[float, float]] = {}
    for number, each in pressures.items():
        if each[0] > 0.0:
            found[places[number][0]] = max(each, found.get(places[number][0], (0.0, 0.0)))
    x = np.array(sorted(found))
    return x, np.array([found[place] for place in x]), np.array(forces[-3:-1], dtype=np.float64)
