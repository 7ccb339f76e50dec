"""Assembly of the scalar stiffness (Laplace) of 10,000 polygons and 20,000 triangles beside other programs.

Our time is from a mesh to the assembled sparse matrix, numbering and pattern included. Accuracy is the relative error
of the energy of u = x, which is the area.
"""

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp

from benchmarks.measurement import Measurement, best_time
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.geometry import square
from flangeway.mesh import PolyMesh, dual, triangulate
from flangeway.problems import Torsion
from flangeway.space import Space, SymmetricMatrix, interpolate

SIZE = 0.01163  # of the triangles: the unit square then has 9,978 points, one polygon each
ORDERS = (1, 2, 3)


def measurements() -> Iterator[Measurement]:
    """Polygons against pypolydim, triangles against scikit-fem."""
    triangles = triangulate(square(1.0, (0.5, 0.5)), size=SIZE)
    polygons = dual(triangles)
    _ = triangles.cell_edges, polygons.cell_edges
    for order in ORDERS:
        yield _against_pypolydim(polygons, order)
    for order in ORDERS:
        yield _against_skfem(triangles, order)


def _ours(mesh: PolyMesh, element: Element) -> tuple[float, float]:
    def assemble() -> SymmetricMatrix:
        return Torsion(Space(mesh, element)).stiffness()

    seconds, matrix = best_time(assemble)
    u = interpolate(Space(mesh, element), lambda points: points[:, 0])
    return seconds, abs(float(u @ (matrix.full() @ u)) - 1.0)


def _against_pypolydim(mesh: PolyMesh, order: int) -> Measurement:
    seconds, accuracy = _ours(mesh, Virtual(order))
    work = f"scalar stiffness of {mesh.n_cells} polygons, virtual elements of order {order}"
    try:
        peer_seconds, peer_accuracy = _pypolydim(mesh, order)
    except ImportError as error:
        note = f"pypolydim could not be run ({error}); install it with pip install pypolydim"
        return Measurement(work, "pypolydim", seconds, None, accuracy, None, note)
    note = "vem_pcc to triplets; its geometry, numbering and conversion to a sparse matrix are not in its time"
    return Measurement(work, "pypolydim", seconds, peer_seconds, accuracy, peer_accuracy, note)


def _pypolydim(mesh: PolyMesh, order: int) -> tuple[float, float]:
    from pypolydim import gedim, polydim  # noqa: PLC0415

    settings = gedim.GeometryUtilitiesConfig()
    settings.tolerance1_d, settings.tolerance2_d = 1e-12, 1e-14
    geometry = gedim.GeometryUtilities(settings)
    data = gedim.MeshMatrices()
    polygons = gedim.MeshMatricesDAO(data)
    points = np.vstack((mesh.points.T, np.zeros(mesh.n_points)))
    cells = [
        np.vstack((mesh.cell_points[a:b], mesh.cell_edges[a:b])).astype(np.int32)
        for a, b in zip(mesh.cell_offsets[:-1], mesh.cell_offsets[1:], strict=True)
    ]
    gedim.MeshUtilities().fill_mesh2_d(points, mesh.edges.T.astype(np.int32), cells, polygons)
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
    seconds, operator = best_time(
        lambda: assembler.assemble_diffusion_operator(*common, dofs, reference, reference, lambda _x, _y, _z: 1.0),
        repeats=3,
    )
    u = assembler.assemble_exact_solution(*common, reference, lambda x, _y, _z: x).function_dofs
    entries = operator.operator_dofs
    matrix = sp.coo_array((entries.values, (entries.rows, entries.cols)), shape=(len(u), len(u))).tocsr()
    return seconds, abs(float(u @ (matrix @ u)) - 1.0)


def _against_skfem(mesh: PolyMesh, order: int) -> Measurement:
    seconds, accuracy = _ours(mesh, Lagrange(order))
    work = f"scalar stiffness of {mesh.n_cells} triangles, Lagrange elements of order {order}"
    try:
        peer_seconds, peer_accuracy = _skfem(mesh, order)
    except ImportError as error:
        note = f"scikit-fem could not be run ({error}); install it with pip install scikit-fem"
        return Measurement(work, "scikit-fem", seconds, None, accuracy, None, note)
    note = "from a mesh to a compressed sparse matrix"
    return Measurement(work, "scikit-fem", seconds, peer_seconds, accuracy, peer_accuracy, note)


def _skfem(mesh: PolyMesh, order: int) -> tuple[float, float]:
    import skfem  # noqa: PLC0415
    from skfem.models.poisson import laplace  # noqa: PLC0415

    triangles = skfem.MeshTri(
        np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.cell_points.reshape(-1, 3).T)
    )
    element = (skfem.ElementTriP1, skfem.ElementTriP2, skfem.ElementTriP3)[order - 1]
    seconds, matrix = best_time(lambda: laplace.assemble(skfem.Basis(triangles, element())))
    u = skfem.Basis(triangles, element()).project(lambda x: x[0])
    return seconds, abs(float(u @ (matrix @ u)) - 1.0)
