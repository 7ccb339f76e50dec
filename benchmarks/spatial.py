"""Contact in three dimensions from plane meshes: a body's table, normal contact, and Hertz's problem beside CalculiX.

The table is that of a block on a plane mesh of about 5,000 nodes with 80 contact cells, at as many wavenumbers as an
interpolation to 1e-4 needs, in a process of its own without the cache. Normal contact is solved on a grid with
coefficients at hand, cold and from the forces at 1 % less load. Hertz's problem, a crowned prism below a cylinder
across it, is timed from meshes to pressures, tables included; CalculiX gets quarters of C3D20 under an approach.
Accuracy is the relative error of the maximum pressure from Hertz's under the force found.
"""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.conformal_block import PENALTY, graded
from benchmarks.growth import exponent
from benchmarks.measurement import NO_PEER, Measurement, best_time, timed
from benchmarks.peers import PeerMissingError, run_calculix
from benchmarks.peers.calculix_solid import deck, middle_pressure, read, solid
from benchmarks.samples import resident_mb, sample
from flangeway.contact.patch.normal_contact import Convolution, NormalContact, solve_normal
from flangeway.contact.patch.patch_contact import PatchContact, press_patch
from flangeway.elements import Lagrange
from flangeway.exact import PointContact, contact_modulus, half_space_influence
from flangeway.geometry import rectangle
from flangeway.mesh import Refinement, triangulate
from flangeway.problems import Elasticity, Harmonic
from flangeway.solve import SurfaceCells, compliance_table
from flangeway.space import Space
from flangeway_studies.patches import HERTZ_STEEL, crowned

Floats = NDArray[np.float64]

CELL, CELLS = 0.4, 80
BLOCK = 100.0
TOLERANCE = 1e-4
ASKED_TABLE_S, ASKED_TABLE_MB = 5.0, 1024.0
ASKED_COLD_S, ASKED_WARM_S, ASKED_EXPONENT = 0.15, 0.05, 1.3
GRIDS = ((40, 20), (80, 40), (160, 80), (320, 160))
RADIUS, FORCE = 300.0, 32_800.0
SOLID_SIZE, SOLID_FINE, SOLID_BLOCK = 0.6, 4.8, 20.0

MODULUS = contact_modulus(HERTZ_STEEL.plane_modulus, HERTZ_STEEL.plane_modulus)


def measurements() -> Iterator[Measurement]:
    """Table, contact, growth, and Hertz's problem beside CalculiX."""
    found = sample("benchmarks.spatial")
    yield Measurement(
        f"table of a body: {found['nodes']} nodes, {CELLS} cells, interpolation to {TOLERANCE:g}",
        NO_PEER, found["seconds"], None, found["error"], None, "accuracy: error of the interpolation",
        more={
            "wavenumbers": found["wavenumbers"], "peak_mb": found["peak_mb"], "asked_s": ASKED_TABLE_S,
            "asked_mb": ASKED_TABLE_MB,
        },
    )  # fmt: skip
    yield from contacts(GRIDS)
    yield hertz(SOLID_SIZE)


def quick() -> Iterator[Measurement]:
    """Small grids."""
    yield from contacts(GRIDS[:2])


def contacts(grids: tuple[tuple[int, int], ...]) -> Iterator[Measurement]:
    """Normal contact cold and warm, and growth over the number of cells: one ellipse on finer and finer grids."""
    sizes: list[dict[str, Any]] = []
    for across, along in grids:
        size, exact = contact_of(across, along)
        sizes.append(size)
        asked = {"asked_cold_s": ASKED_COLD_S, "asked_warm_s": ASKED_WARM_S} if across == CELLS else {}
        yield Measurement(
            f"normal contact on {across} x {along} cells, {size['loaded']} under pressure", NO_PEER, size["cold"], None,
            exact, None, "", more={"warm_s": size["warm"], "iterations": size["iterations"]} | asked,
        )  # fmt: skip
    yield Measurement(
        f"growth from {sizes[0]['unknowns']} to {sizes[-1]['unknowns']} cells", NO_PEER, sizes[-1]["cold"], None, None,
        None, "exponents over the number of cells",
        more={
            "exponents": {name: round(exponent(sizes, name), 3) for name in ("cold", "warm")},
            "asked_exponent": ASKED_EXPONENT,
        },
    )  # fmt: skip


def contact_of(across: int, along: int) -> tuple[dict[str, Any], float]:
    """Times on a grid over one window, and the error of the maximum pressure."""
    hertz = PointContact(FORCE, RADIUS, RADIUS, MODULUS)
    half = 1.4 * hertz.semi_axes[0]
    bounds, strip = np.linspace(-half, half, across + 1), 2.0 * half / along
    x, z = (bounds[1:] + bounds[:-1]) / 2.0, strip * (np.arange(along) - (along - 1) / 2.0)
    influence = Convolution(
        2.0 * half_space_influence(HERTZ_STEEL.young, HERTZ_STEEL.poisson, bounds, strip, along, (1,))
    )
    gaps = (x[:, None] ** 2 + z**2) / (2.0 * RADIUS)

    def solve(force: float, start: Floats | None = None) -> NormalContact:
        return solve_normal(influence, gaps, force=force, start=start)

    near = solve(0.99 * FORCE).forces
    cold, found = best_time(lambda: solve(FORCE))
    warm, _ = best_time(lambda: solve(FORCE, near))
    cell = (bounds[1] - bounds[0]) * strip
    size = {
        "unknowns": across * along, "cold": cold, "warm": warm, "loaded": int((found.forces > 0.0).sum()),
        "iterations": found.status.iterations,
    }  # fmt: skip
    return size, float(found.forces.max()) / cell / hertz.max_pressure - 1.0


def hertz(size: float) -> Measurement:
    """Two bodies with crossed round surfaces, by flangeway and by CalculiX at our approach."""
    bodies = crowned("prism", RADIUS), crowned("cylinder", None, RADIUS)

    def press() -> PatchContact:
        return press_patch(*bodies, force=FORCE)

    seconds, found = timed(press)
    exact = PointContact(FORCE, RADIUS, RADIUS, MODULUS)
    ours = found.patches[0].max_pressure / exact.max_pressure - 1.0
    work = "Hertz's contact of two cylinders across each other"
    try:
        peer_s, peer, force, nodes, version = _calculix(size, exact.approach)
    except PeerMissingError as error:
        return Measurement(work, "calculix", seconds, None, ours, None, str(error))
    n_nodes = sum(each.problem.elasticity.space.n_nodes for each in bodies)
    return Measurement(
        work, "calculix", seconds, peer_s, ours, peer,
        f"ours {n_nodes} plane nodes and {found.pressures.size} cells; the peer {nodes} nodes in quarters of C3D20, "
        f"which found {force:.0f} N",
        peer_version=version, more={"asked_peer_accuracy": 0.01},
    )  # fmt: skip


def _calculix(size: float, approach: float) -> tuple[float, float, float, int, str]:
    """Seconds, error of the maximum pressure, force, nodes and version."""
    along = graded(SOLID_FINE, size, SOLID_BLOCK, 2.0)
    deep = graded(size, size, SOLID_BLOCK)
    lower = solid(along, 1.0 - deep[::-1] / deep[-1], along, _crowned_below, upper=False)
    upper = solid(along, deep / deep[-1], along, _cylinder_above, upper=True)
    penalty = PENALTY * HERTZ_STEEL.young
    text = deck(lower, upper, young=HERTZ_STEEL.young, poisson=HERTZ_STEEL.poisson, penalty=penalty, approach=approach)
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "hertz.inp").write_text(text, encoding="ascii")
        seconds, version = run_calculix(Path(name), "hertz")
        stresses, quarter = read(Path(name) / "hertz")
    force = 4.0 * quarter
    exact = PointContact(force, RADIUS, RADIUS, MODULUS).max_pressure
    pressure = middle_pressure(lower, upper, stresses)
    return seconds, pressure / exact - 1.0, force, len(lower.nodes) + len(upper.nodes), version


def _crowned_below(x: Floats, share: Floats, z: Floats) -> Floats:
    drop = RADIUS - np.sqrt(RADIUS**2 - x**2)
    return np.stack((x, -SOLID_BLOCK * (1.0 - share) - share * drop, z), axis=1)


def _cylinder_above(x: Floats, share: Floats, z: Floats) -> Floats:
    rise = RADIUS - np.sqrt(RADIUS**2 - z**2)
    return np.stack((x, SOLID_BLOCK * share + (1.0 - share) * rise, z), axis=1)


def _table() -> dict[str, Any]:
    """Compute a table in this process."""
    half = CELL * CELLS / 2.0
    zone = Refinement(np.array([[-half, 0.0], [half, 0.0]]), 0.99 * CELL, 0.2)
    mesh = triangulate(rectangle(2.0 * BLOCK, BLOCK, (0.0, -BLOCK / 2.0)), size=10.0, refinements=[zone])
    edges, points = mesh.boundary_edges, mesh.points
    heights = points[edges][:, :, 1]
    base = edges[(heights < 1e-9 - BLOCK).all(axis=1)]
    top = edges[(np.abs(heights) < 1e-9).all(axis=1)]
    chain: NDArray[np.int64] = top[np.argsort(-points[top[:, 0], 0])].astype(np.int64)
    space = Space(mesh.with_edge_set("base", base), Lagrange(2))
    problem = Harmonic(Elasticity(space, HERTZ_STEEL), held={"base": "xyz"})
    bounds: Floats = BLOCK + CELL * (np.arange(CELLS + 1, dtype=np.float64) - CELLS / 2.0)
    seconds, table = timed(
        lambda: compliance_table(SurfaceCells(problem, chain, bounds), 1e-4, np.pi / CELL, TOLERANCE)
    )
    return {
        "nodes": space.n_nodes,
        "seconds": seconds,
        "wavenumbers": len(table.wavenumbers),
        "error": table.error,
        "peak_mb": round(resident_mb()),
    }


if __name__ == "__main__":
    print(json.dumps(_table()))
