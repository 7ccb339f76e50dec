"""Two conforming blocks pressed together in CalculiX: the numbers that ``flangeway reproduce spatial`` compares with.

``python -m benchmarks.conformal_block [SIZE]`` prints lines for ``flangeway_studies/data/spatial.csv``: quarters of
C3D20 with edges of SIZE mm in the contact (0.7 if left out), pressed by the approach of `flangeway_studies.patches`.
The pressure is the stress along the normal at the nodes in the middle of both surfaces, their mean.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers import run_calculix
from benchmarks.peers.calculix_solid import Solid, deck, middle_pressure, read, solid
from flangeway_studies.patches import BLOCK, STEEL

Floats = NDArray[np.float64]

FINE, LENGTH = 7.0, 24.0  # mm
GROWTH = 1.6
PENALTY = 100.0  # of Young's modulus, per mm


def graded(fine: float, size: float, end: float, growth: float = GROWTH) -> Floats:
    """Abscissae of cells of a size up to `fine`, and growing from there to the end."""
    equal = np.linspace(0.0, fine, round(fine / size) + 1)
    steps = [size * growth]
    while sum(steps) < end - fine:
        steps.append(steps[-1] * growth)
    rest = np.cumsum(steps) * (end - fine) / sum(steps)
    return np.concatenate((equal, fine + rest))


def blocks(size: float) -> tuple[Solid, Solid]:
    """Both quarters; abscissae are the angle from the vertical, the share of the way outwards, and z."""
    along = graded(FINE, size, LENGTH)

    def lower(angle: Floats, share: Floats, z: Floats) -> Floats:
        radius = BLOCK.inner + share * (BLOCK.convex - BLOCK.inner)
        return np.stack((radius * np.sin(angle), radius * np.cos(angle) - BLOCK.convex, z), axis=1)

    def upper(angle: Floats, share: Floats, z: Floats) -> Floats:
        radius = BLOCK.concave + share * (BLOCK.outer - BLOCK.concave)
        # a surface of revolution about an axis at y = rolling: each point rises, at the held arc by nothing
        turning = BLOCK.rolling + BLOCK.concave * (1.0 - np.cos(angle))
        rise = (turning - np.sqrt(turning**2 - z**2)) * (1.0 - share)
        return np.stack((radius * np.sin(angle), radius * np.cos(angle) - BLOCK.concave + rise, z), axis=1)

    down = graded(size, size, BLOCK.convex - BLOCK.inner, 1.5)
    up = graded(size, size, BLOCK.outer - BLOCK.concave, 1.5)
    fine = FINE / BLOCK.convex
    angles = [graded(fine, size / BLOCK.convex, each) for each in (BLOCK.lower_angle, BLOCK.upper_angle)]
    return (
        solid(angles[0], 1.0 - down[::-1] / down[-1], along, lower, upper=False),
        solid(angles[1], up / up[-1], along, upper, upper=True),
    )


def main(size: float) -> None:
    """Run and print."""
    below, above = blocks(size)
    text = deck(
        below, above, young=STEEL.young, poisson=STEEL.poisson, penalty=PENALTY * STEEL.young, approach=BLOCK.approach
    )
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "block.inp").write_text(text, encoding="ascii")
        seconds, version = run_calculix(Path(name), "block")
        stresses, force = read(Path(name) / "block")
    pressure = middle_pressure(below, above, stresses)
    n_elements, n_nodes = (len(below.elements) + len(above.elements), len(below.nodes) + len(above.nodes))
    print(f"# block: CalculiX {version}, {n_elements} C3D20, {n_nodes} nodes, edges of {size:g} mm, {seconds:.0f} s")
    print(f"block,{size:g},force,N,{4.0 * force:.6g}")
    print(f"block,{size:g},p0,MPa,{pressure:.6g}")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 0.7)
