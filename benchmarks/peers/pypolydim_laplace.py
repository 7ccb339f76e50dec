"""Diffusion operator of virtual elements with pypolydim; run by the interpreter of its own environment.

``pypolydim_laplace.py MESH ORDER`` prints the best time of three, that of the processor, and the energy of u = x as
JSON.
"""

import itertools
import json
import sys
import time
from importlib.metadata import version
from typing import Any

import numpy as np
from pypolydim import gedim, polydim
from scipy.sparse import coo_array


def main(path: str, order: int) -> dict[str, Any]:
    """Assemble and tell; pypolydim keeps no references, so all its objects live here."""
    with np.load(path) as file:
        stored = dict(file)
    settings = gedim.GeometryUtilitiesConfig()
    settings.tolerance1_d, settings.tolerance2_d = 1e-12, 1e-14
    geometry = gedim.GeometryUtilities(settings)
    data = gedim.MeshMatrices()
    polygons = gedim.MeshMatricesDAO(data)
    points = np.vstack((stored["points"].T, np.zeros(len(stored["points"]))))
    offsets = stored["offsets"].tolist()
    cells = [
        np.vstack((stored["cells"][a:b], stored["cell_edges"][a:b])).astype(np.int32)
        for a, b in itertools.pairwise(offsets)
    ]
    gedim.MeshUtilities().fill_mesh2_d(points, stored["edges"].T.astype(np.int32), cells, polygons)
    tools = polydim.pde_tools
    measures = tools.mesh.pde_mesh_utilities.compute_mesh_2_d_geometry_data(geometry, polygons)
    local = tools.local_space_pcc_2_d
    reference = local.create_reference_element(local.MethodTypes.vem_pcc, order)
    boundary = tools.do_fs.DOFsManager.MeshDOFsInfo.BoundaryInfo()
    boundary.type = boundary.BoundaryTypes.none
    info = local.set_mesh_do_fs_info(reference, polygons, {0: boundary})
    dofs = tools.do_fs.DOFsManager().create_do_fs_2_d(info, tools.mesh.MeshMatricesDAO_mesh_connectivity_data(polygons))
    assembler = tools.assembler_utilities.pcc_2_d
    common = (geometry, polygons, measures, dofs)
    seconds, processor = float("inf"), float("inf")
    for _ in range(3):
        start, start_of_processor = time.perf_counter(), time.process_time()
        operator = assembler.assemble_diffusion_operator(*common, dofs, reference, reference, lambda _x, _y, _z: 1.0)
        seconds = min(seconds, time.perf_counter() - start)
        processor = min(processor, time.process_time() - start_of_processor)
    u = assembler.assemble_exact_solution(*common, reference, lambda x, _y, _z: x).function_dofs
    entries = operator.operator_dofs
    matrix = coo_array((entries.values, (entries.rows, entries.cols)), shape=(len(u), len(u))).tocsr()
    energy = float(u @ (matrix @ u))
    return {"seconds": seconds, "processor_s": processor, "energy": energy, "version": version("pypolydim")}


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], int(sys.argv[2]))))
