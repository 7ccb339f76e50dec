"""A wheel S1002 on a rail 60E1 in CalculiX: the numbers that ``flangeway reproduce wheelset3d`` compares with.

``python -m benchmarks.profile_blocks [SIZE]`` prints lines for ``flangeway_studies/data/spatial.csv``: the blocks of
`flangeway_studies.patches`, cut at z = 0, as C3D20 with edges of SIZE mm in the contact (1.2 if left
out). Pressures are the stresses along the normals at the nodes, the mean of both surfaces. The semi-axes are those of
an ellipse whose pressure as Hertz's has the same second moments.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.conformal_block import PENALTY, graded
from benchmarks.peers import run_calculix
from benchmarks.peers.calculix_solid import CORNERS, FACES, MIDDLES, Solid, deck, read, solid
from flangeway_studies.patches import APPROACH, BLOCK_DEPTH, HALF, HERTZ_STEEL, LENGTH, cut_surfaces, heights

Floats = NDArray[np.float64]

LEFT, RIGHT, AHEAD = 5.0, 6.5, 7.5
"""Reach of the equal elements about the contact in mm."""
GROWTH = 1.9
QUANTITIES = (("p0", "MPa"), ("x", "mm"), ("along", "mm"), ("across", "mm"))
STEP = 1e-2
"""Over which slopes are taken in mm."""
NOISE = 0.005
"""Stresses at the nodes below this share of the maximum pressure are taken as those of a free surface."""
SHARES = np.array([-1.0, -1.0, -1.0, -1.0, 4.0, 4.0, 4.0, 4.0]) / 12.0
"""Of the nodes of a face in its area: corners, then middles of sides."""


def blocks(size: float) -> tuple[Solid, Solid]:
    """Both halves; abscissae are x, the share of the way up, and z."""
    low, high, axle = cut_surfaces()

    def lower(x: Floats, share: Floats, z: Floats) -> Floats:
        return np.stack((x, share * heights(low, x) - (1.0 - share) * BLOCK_DEPTH, z), axis=1)

    def upper(x: Floats, share: Floats, z: Floats) -> Floats:
        radius = axle - heights(high, x)
        return np.stack((x, (1.0 - share) * (axle - np.sqrt(radius**2 - z**2)) + share * BLOCK_DEPTH, z), axis=1)

    across = np.concatenate((-graded(LEFT, size, HALF, GROWTH)[:0:-1], graded(RIGHT, size, HALF, GROWTH)))
    along, deep = graded(AHEAD, size, LENGTH / 2.0, GROWTH), graded(size, size, BLOCK_DEPTH, GROWTH)
    return (
        solid(across, 1.0 - deep[::-1] / deep[-1], along, lower, upper=False),
        solid(across, deep / deep[-1], along, upper, upper=True),
    )


def measured(body: Solid, stresses: dict[int, list[float]], before: int, axle: float | None) -> Floats:
    """Maximum pressure, centre across, and semi-axes along and across; without an axle the body is a prism."""
    side = 0 if body.face == FACES[0] else 2
    on_face = [number for number, place in enumerate((*CORNERS, *MIDDLES)) if place[1] == side]
    nodes = body.elements[body.faces][:, on_face]
    places = body.nodes[nodes]
    areas = np.linalg.norm(np.cross(places[:, 3] - places[:, 0], places[:, 2] - places[:, 1]), axis=1) / 2.0
    x, y, z = places.reshape(-1, 3).T
    low, high, _ = cut_surfaces()
    surface = low if axle is None else high
    slope = (heights(surface, x + STEP) - heights(surface, x - STEP)) / (2.0 * STEP)
    # the normal leans along z where the surface turns about the axle
    cosine, sine = (np.ones(len(z)), np.zeros(len(z))) if axle is None else (axle - y, -z) / np.hypot(axle - y, z)
    a, b, c = np.stack((-slope, cosine, sine)) / np.sqrt(1.0 + slope**2)
    xx, yy, zz, xy, yz, zx = np.array([stresses[node] for node in (nodes + 1 + before).ravel().tolist()]).T
    pressures = -(a * a * xx + b * b * yy + c * c * zz + 2.0 * (a * b * xy + b * c * yz + c * a * zx))
    forces = np.where(pressures > NOISE * pressures.max(), pressures, 0.0) * (areas[:, None] * SHARES).ravel()
    forces /= forces.sum()
    middle = x @ forces
    return np.array([pressures.max(), middle, *np.sqrt(5.0 * np.array([z**2, (x - middle) ** 2]) @ forces)])


def main(size: float) -> None:
    """Run and print."""
    below, above = blocks(size)
    penalty = PENALTY * HERTZ_STEEL.young
    text = deck(below, above, young=HERTZ_STEEL.young, poisson=HERTZ_STEEL.poisson, penalty=penalty, approach=APPROACH)
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "blocks.inp").write_text(text, encoding="ascii")
        seconds, version = run_calculix(Path(name), "blocks")
        stresses, force = read(Path(name) / "blocks")
    found = [measured(below, stresses, 0, None), measured(above, stresses, len(below.nodes), cut_surfaces()[2])]
    n_elements, n_nodes = (len(below.elements) + len(above.elements), len(below.nodes) + len(above.nodes))
    print(f"# profile: CalculiX {version}, {n_elements} C3D20, {n_nodes} nodes, edges of {size:g} mm, {seconds:.0f} s")
    print(f"profile,{size:g},force,N,{2.0 * force:.6g}")
    for (quantity, unit), value in zip(QUANTITIES, np.mean(found, axis=0).tolist(), strict=True):
        print(f"profile,{size:g},{quantity},{unit},{value:.6g}")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 1.2)
