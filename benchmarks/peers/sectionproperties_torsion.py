"""Torsion of a rectangle with sectionproperties; run by the interpreter of its own environment.

``sectionproperties_torsion.py WIDTH HEIGHT TRIANGLE_AREA`` prints as JSON the number of triangles, the torsion
constant, and the best times without meshing: of the properties for frames and of all warping properties.
"""

import json
import sys
import time
from importlib.metadata import version
from typing import Any

from sectionproperties.analysis import Section
from sectionproperties.pre.library import rectangular_section

REPEATS = 3


def main(width: float, height: float, area: float) -> dict[str, Any]:
    """Mesh, compute, tell."""
    geometry = rectangular_section(d=height, b=width)
    geometry.create_mesh(mesh_sizes=[area])
    times = {"frame": float("inf"), "all": float("inf")}
    for _ in range(REPEATS):
        start = time.perf_counter()
        section = Section(geometry)
        section.calculate_frame_properties()
        times["frame"] = min(times["frame"], time.perf_counter() - start)
        frame = section.get_j()
        start = time.perf_counter()
        section = Section(geometry)
        section.calculate_geometric_properties()
        section.calculate_warping_properties()
        times["all"] = min(times["all"], time.perf_counter() - start)
    return {
        "cells": len(section.elements),
        "frame": {"seconds": times["frame"], "torsion_constant": float(frame)},
        "all": {"seconds": times["all"], "torsion_constant": float(section.get_j())},
    }


if __name__ == "__main__":
    print(json.dumps(main(*map(float, sys.argv[1:4])) | {"version": version("sectionproperties")}))
