"""The block's problem given to Kratos and CalculiX: the same nodes, the approach that flangeway found.

CalculiX takes the triangles of order 2. Kratos' contact is of order 1, so each of them is four triangles there. Middle
nodes of the fine arc are moved onto the circle for both.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.hertz_block import BASE, RADIUS, STEEL, TOP, Block, Floats, Pressed
from benchmarks.peers import run_calculix, run_python
from benchmarks.peers.calculix_deck import deck, read_tractions
from flangeway.mesh import PolyMesh

Ints = NDArray[np.int64]

PENALTY_FACTOR = 50.0
"""CalculiX's pressure per penetration over E and per mm."""


@dataclass(frozen=True)
class Quadratic:
    """Nodes and triangles of order 2 of one body, and chains of nodes by name.

    Parameters
    ----------
    points
        Corners, then middles of edges, shape (n, 2).
    triangles
        Corners counter-clockwise, then the middles of the edges between them, shape (m, 6).
    contact
        Edges that can touch: two ends and the middle, shape (k, 3).
    held
        Nodes of the cut or of the base.

    """

    points: Floats
    triangles: Ints
    contact: Ints
    held: Ints

    @property
    def quarters(self) -> Ints:
        """The same nodes in four times as many triangles of order 1, shape (4 m, 3)."""
        parts = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
        return np.concatenate([self.triangles[:, part] for part in parts])


def quadratic(block: Block, mesh: PolyMesh, contact: str, held: str) -> Quadratic:
    """Nodes of order 2; middles of edges that can touch lie on the drawn surface."""
    middles = mesh.points[mesh.edges].mean(axis=1)
    zone = block.zone(mesh, contact)
    numbers = {name: mesh.edge_numbers(edges) for name, edges in (("zone", zone), ("held", mesh.edge_sets[held]))}
    if contact == "arc":
        centre = np.array([0.0, RADIUS])
        rays = middles[mesh.edge_numbers(mesh.edge_sets["arc"])] - centre
        onto = centre + RADIUS * rays / np.linalg.norm(rays, axis=1)[:, None]
        middles[mesh.edge_numbers(mesh.edge_sets["arc"])] = onto
    corners, edges = (numbers_of.reshape(-1, 3).astype(np.int64) for numbers_of in (mesh.cell_points, mesh.cell_edges))
    return Quadratic(
        np.vstack((mesh.points, middles)),
        np.hstack((corners, mesh.n_points + edges)),
        np.column_stack((zone, mesh.n_points + numbers["zone"])),
        np.unique(np.concatenate((mesh.edge_sets[held].ravel(), mesh.n_points + numbers["held"]))).astype(np.int64),
    )


def bodies(block: Block) -> tuple[Quadratic, Quadratic]:
    """The cylinder and the block."""
    return quadratic(block, block.upper, "arc", "cut"), quadratic(block, block.lower, TOP, BASE)


def press_with_kratos(
    block: Block,
    approach: float,
    folder: Path,
    *,
    n_steps: int = 1,
    threads: int = 1,
    friction: float = 0.0,
    shift: float = 0.0,
) -> Pressed:
    """Mortar contact with augmented multipliers (ContactStructuralMechanicsApplication).

    With friction the cut moves to the right by a shift after the approach.

    Raises
    ------
    PeerMissingError
        If Kratos is not installed.

    """
    upper, lower = bodies(block)
    first = len(upper.points)
    halves = [body.contact[:, [0, 2, 2, 1]].reshape(-1, 2) for body in (upper, lower)]
    np.savez(
        folder / "kratos.npz",
        points=np.vstack((upper.points, lower.points)),
        upper_triangles=upper.quarters,
        lower_triangles=lower.quarters + first,
        contact_edges=np.vstack((halves[0], halves[1] + first)),
        slave=np.repeat([True, False], [len(half) for half in halves]),
        cut=upper.held,
        base=lower.held + first,
        approach=approach,
        young=STEEL.young,
        poisson=STEEL.poisson,
        friction=friction,
        shift=shift,
    )
    told = run_python("kratos", "kratos_block.py", str(folder), str(n_steps), threads=threads)
    return Pressed(
        told["seconds"], np.array(told["x"]), np.array(told["pressures"]), told["force"], note=told["version"],
        tractions=np.array(told["tractions"]), tangential_force=abs(told["tangential_force"]),
        cpu_seconds=told["cpu_seconds"],
    )  # fmt: skip


def press_with_calculix(
    block: Block,
    approach: float,
    folder: Path,
    *,
    n_steps: int = 1,
    threads: int = 1,
    friction: float = 0.0,
    shift: float = 0.0,
) -> Pressed:
    """CPE6 with surface-to-surface penalty contact; the time is that of the whole program.

    With friction the cut moves to the right by a shift after the approach.

    Raises
    ------
    PeerMissingError
        If CalculiX is not installed.

    """
    upper, lower = bodies(block)
    first = len(upper.points)
    points = np.vstack((upper.points, lower.points))
    text = deck(
        points,
        (upper.triangles, lower.triangles + first),
        (upper.contact[:, :2], lower.contact[:, :2] + first),
        (upper.held, lower.held + first),
        young=STEEL.young,
        poisson=STEEL.poisson,
        penalty=PENALTY_FACTOR * STEEL.young,
        approach=approach,
        n_steps=n_steps,
        friction=friction,
        shift=shift,
    )
    (folder / "block.inp").write_text(text, encoding="ascii")
    before = _cpu_of_children()
    seconds, version = run_calculix(folder, "block", threads=threads)
    cpu_seconds = _cpu_of_children() - before
    x, values, force = read_tractions(folder / "block")
    return Pressed(
        seconds, x, values[:, 0], float(force[1]), note=version,
        tractions=values[:, 1], tangential_force=float(abs(force[0])), cpu_seconds=cpu_seconds,
    )  # fmt: skip


def _cpu_of_children() -> float:
    """Time of the processors of all programs that were run and have ended."""
    import resource  # noqa: PLC0415 (not on all systems)

    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
