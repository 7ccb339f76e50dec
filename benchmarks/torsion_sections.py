"""The torsion constant of rectangles beside sectionproperties, on about as many triangles of order 2 each.

Nobody's meshing counts. ``torsion`` is the torsion constant from the warping function, beside sectionproperties'
properties for frames (torsion and bending); ``all constants`` are those from both functions with shear centres and the
warping constant, beside its warping properties. Accuracy is the relative error of the torsion constant from the series
of the closed form.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from benchmarks.measurement import Measurement, best_time, fastest_in_turns, taken
from benchmarks.peers import PeerMissingError, run_python
from flangeway.elements import Lagrange
from flangeway.geometry import rectangle
from flangeway.mesh import PolyMesh, triangulate
from flangeway.post import section_constants
from flangeway.problems import Torsion
from flangeway.solve import solve_torsion
from flangeway.space import Space
from flangeway_studies.torsion_bars import Rectangle

SECTIONS = ((100.0, 50.0), (100.0, 10.0))  # mm
TRIANGLES = 10_000
QUICK_TRIANGLES = 300
ROUNDS = 3


def measurements(triangles: int = TRIANGLES) -> Iterator[Measurement]:
    """Both works on both rectangles."""
    for width, height in SECTIONS:
        # triangles of an edge h: 2.6 in h^2 as a mean
        mesh = triangulate(rectangle(width, height), size=float(np.sqrt(2.6 * width * height / triangles)))
        yield from _compare(width, height, mesh)


def quick() -> Iterator[Measurement]:
    """Coarse meshes."""
    yield from measurements(QUICK_TRIANGLES)


def _compare(width: float, height: float, mesh: PolyMesh) -> Iterator[Measurement]:
    area = 1.62 * width * height / mesh.n_cells  # largest triangle that is allowed; the mean is less
    jobs: dict[str, Callable[[], dict[str, Any]]] = {
        "ours": partial(_ours, mesh),
        "peer": partial(
            run_python, "sectionproperties", "sectionproperties_torsion.py", str(width), str(height), str(area)
        ),
    }
    found = fastest_in_turns(jobs, dict.fromkeys(jobs, ROUNDS), lambda run: run["frame"]["seconds"])
    ours, peer = taken(found["ours"]), found["peer"]
    exact = Rectangle(width, height).torsion_constant
    for work, name in (("frame", "torsion"), ("all", "all constants")):
        title = f"{name} of a rectangle {width:g} by {height:g}, {mesh.n_cells} triangles of order 2"
        error = abs(ours[work]["torsion_constant"] / exact - 1.0)
        if isinstance(peer, PeerMissingError):
            yield Measurement(title, "sectionproperties", ours[work]["seconds"], None, error, None, str(peer))
            continue
        yield Measurement(
            title, "sectionproperties", ours[work]["seconds"], peer[work]["seconds"], error,
            abs(peer[work]["torsion_constant"] / exact - 1.0), f"the peer's mesh has {peer['cells']} triangles",
            peer["version"],
        )  # fmt: skip


def _ours(mesh: PolyMesh) -> dict[str, Any]:
    frame, solution = best_time(lambda: solve_torsion(Torsion(Space(mesh, Lagrange(2)), formulation="warping")), 3)
    everything, constants = best_time(lambda: section_constants(Space(mesh, Lagrange(2))), 3)
    return {
        "frame": {"seconds": frame, "torsion_constant": solution.torsion_constant},
        "all": {"seconds": everything, "torsion_constant": constants.torsion_constant},
    }
