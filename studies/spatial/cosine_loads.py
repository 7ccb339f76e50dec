"""A bar under a pressure that varies as a cosine, as a prism and a body of revolution, and a disc under two forces."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import groupby

import numpy as np

from flangeway.elements import Element, Lagrange, Reconstruction, Virtual
from flangeway.geometry import polygon
from flangeway.geometry.arrays import middles_of
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, dual, rectangle_grid, triangulate
from flangeway.post.lines import locate, polynomials_at
from flangeway.problems import Elasticity, Harmonic, Pressure
from flangeway.problems.edges import EdgeQuadrature, edge_quadrature
from flangeway.solve import solve_harmonic
from flangeway.space import CellBatch, Space
from flangeway.types import Floats
from studies.study import Limit, Row, Run, published_rows

ELEMENTS: dict[str, Element] = {"FEM 2": Lagrange(2), "VEM 1": Virtual(1), "VEM 2": Virtual(2), "VEM 3": Virtual(3)}
SIDES = {True: (96, 192, 384), False: (32, 64, 128)}
"""Sides of the polygon for short waves and for others."""
SHORT_WAVES = 10.0
"""Radius times wavenumber from which waves are short."""
BAR_LIMITS = {1: 0.1, 2: 5e-3, 3: 1e-5}
"""Of displacements on the finest mesh by the order."""
RATES = {1: 2.0, 2: 3.0, 3: 3.0}
"""Of displacements by the order: the order + 1, but the error of a polygon of equal area falls with h^3."""
LESS_THAN_RATE = 0.5
"""Margin below them."""
EDGES_A_WAVE = 15.0
"""Edges in a wave from which a rate is that of small elements."""
ROUND_OFF = 1e-6
"""Errors from which a rate is taken."""
STEEL = Elastic(1.0, 0.3)
POISSON = 0.3
REVOLUTION = (1.0, 2.0, 5.0, 8.0)
"""Radius times wavenumber of bars that are computed as bodies of revolution."""
HARMONICS, AVERAGES = 60, 8
SHOWN = (1.0, 5.0, 40.0)  # radius times wavenumber of the bars in the picture


def exact_bar() -> dict[float, tuple[float, float]]:
    """Displacements u_r and u_z by the wavenumber times the radius."""
    rows = [row for row in published_rows("spatial.csv") if row["case"] == "bar"]
    return {
        float(ka): tuple(float(row["value"]) for row in group)  # type: ignore[misc]
        for ka, group in groupby(rows, lambda row: row["code"])
    }


def bar_rows(run: Run, name: str) -> Iterator[Row]:
    """Displacements on the finest of three meshes, and rates of convergence, by the wavenumber.

    If quick, the finest mesh of short waves is for order 3 only.
    """
    element, series = ELEMENTS[name], dict[float, list[tuple[int, float, float, float]]]()
    order = element.order
    for short in (False, True):
        for n_sides in SIDES[short][: 2 if run.quick and short and order < max(BAR_LIMITS) else 3]:
            harmonic, rim = _bar(n_sides, element, graded=short)
            area = harmonic.elasticity.space.mesh.cell_areas.sum()
            for ka, exact in exact_bar().items():
                if (ka > SHORT_WAVES) != short:
                    continue
                found = solve_harmonic(harmonic, ka)
                along = np.einsum("eq,qm,em->", rim.weights, rim.shapes, found.amplitudes[rim.nodes, 2])
                # int u . n ds = 2 A u_r, on the polygon and on the circle
                values = -found.energy / area, (along / rim.weights.sum())
                error = max(abs(value - wanted) for value, wanted in zip(values, exact, strict=True))
                series.setdefault(ka, []).append((n_sides, *values, error / np.hypot(*exact)))
    for ka, meshes in sorted(series.items()):
        code, (coarse, fine) = f"{name} ka={ka:g}", meshes[-2:]
        if ka in SHOWN:
            run.curve("bar", f"ka = {ka:g}", name, [mesh[0] for mesh in meshes], [mesh[-1] for mesh in meshes], "o-")
        for quantity, wanted, value in zip(("u_r", "u_z"), exact_bar()[ka], fine[1:3], strict=True):
            limit = BAR_LIMITS[order] if order == max(BAR_LIMITS) or ka < SHORT_WAVES else None
            yield Row("Bar", code, quantity, "a/E", value, wanted, limit, f"{fine[0]} sides")
        if fine[-1] > ROUND_OFF:
            rate = np.log(coarse[-1] / fine[-1]) / np.log(fine[0] / coarse[0])
            least, edges = RATES[order] - LESS_THAN_RATE, fine[0] / ka
            small = edges >= EDGES_A_WAVE
            note = "" if small else f"{edges:.0f} edges a wave: not yet the rate of small elements"
            at_least = Limit(f"at least {least:g}", rate >= least) if small else None
            yield Row("Bar", code, "rate of convergence", "", rate, RATES[order], at_least, note)


def plane_strain_row() -> Row:
    """The bar at the wavenumber 0, held against motions in its plane."""
    name = "VEM 2"
    harmonic, _ = _bar(SIDES[False][0], ELEMENTS[name], graded=False)
    points = harmonic.elasticity.space.mesh.points
    first = points[np.argmin(np.hypot(points[:, 0] - 1.0, points[:, 1]))]
    second = points[np.argmin(np.hypot(*(points + first).T))]
    held = Harmonic(harmonic.elasticity, held={tuple(first.tolist()): "xy", tuple(second.tolist()): "y"})
    value = -solve_harmonic(held, 0.0).energy / harmonic.elasticity.space.mesh.cell_areas.sum()
    exact = -(1.0 + POISSON) * (1.0 - 2.0 * POISSON)
    return Row("Bar", f"{name} k=0", "u_r", "a/E", value, exact, 1e-9, "plane strain")


def revolution_numbers() -> Iterator[Row]:
    """Half a wave of the bar as a body of revolution, and a disc in plane strain under two opposite forces."""
    for name, element in ELEMENTS.items():
        for ka in REVOLUTION if name == "VEM 3" else REVOLUTION[2:3]:
            length = np.pi / ka
            n_along = 2 * int(np.ceil(8.0 * length))
            pressure = Pressure("rim", partial(_cosine, ka))
            harmonic = _revolution(_half_section(length, 16, n_along, element), [pressure])
            found = solve_harmonic(harmonic, 0)
            at = [harmonic.elasticity.node_at((1.0, y)) for y in (0.0, length / 2.0)]
            values = found.amplitudes[at[0], 0], found.amplitudes[at[1], 1]
            limit = {1: 0.05, 2: 2e-3, 3: 1e-4}[element.order]
            for quantity, exact, value in zip(("u_r", "u_z"), exact_bar()[ka], values, strict=True):
                yield Row("Bar of revolution", f"{name} ka={ka:g}", quantity, "a/E", value, exact, limit)
    yield from _disc_numbers()


def _disc_numbers() -> Iterator[Row]:
    """H. Hertz, 1883 (Timoshenko and Goodier, "Theory of Elasticity", article 41): forces P at both ends of a diameter.

    With s = x / R on the diameter across and ``q = P / (pi R)``, ``sigma_x = q ((1 - s^2) / (1 + s^2))^2`` and
    ``sigma_y = -q (4 / (1 + s^2)^2 - 1)``. Integrated with plane strain's moduli E' and nu', the diameter grows by
    ``P / (pi E') (4 - pi + nu' pi)``.
    """
    harmonic = _revolution(_half_section(0.05, 20, 1, ELEMENTS["VEM 3"]), [Pressure("rim", 1.0)])
    places = np.array([[1e-9, 0.025], [0.5, 0.025]])
    rim = harmonic.elasticity.node_at((1.0, 0.0))
    grown, stresses = [], np.zeros((2, 6))
    for number in range(0, HARMONICS + 1, 2):
        found = solve_harmonic(harmonic, number)
        # inward forces P = 1 per width at t = 0 and pi, and what is seen at t = pi / 2
        amplitude = (2.0 if number else 1.0) / np.pi * np.cos(number * np.pi / 2.0)
        grown.append(2.0 * amplitude * found.amplitudes[rim, 0])
        stresses += amplitude * fields_at(harmonic, found.amplitudes, number, places)[0]
    # alternating series: means of neighbouring partial sums
    sums = np.cumsum(grown)
    for _ in range(AVERAGES):
        sums = middles_of(sums)
    plane_young, plane_poisson = 1.0 / (1.0 - POISSON**2), POISSON / (1.0 - POISSON)
    exact = (4.0 - np.pi + plane_poisson * np.pi) / (np.pi * plane_young)
    yield Row("Disc", "t=90", "growth of the diameter across", "P/E", sums[-1], exact, 1e-4)
    for s, (radial, _, around, *_) in zip((0.0, 0.5), stresses.tolist(), strict=True):
        code = f"r={s:g} t=90"
        across, along = ((1.0 - s**2) / (1.0 + s**2)) ** 2 / np.pi, (1.0 - 4.0 / (1.0 + s**2) ** 2) / np.pi
        yield Row("Disc", code, "stress across", "P/R", radial, across, 1e-3)
        yield Row("Disc", code, "stress along the forces", "P/R", around, along, 1e-3)


def fields_at(harmonic: Harmonic, amplitudes: Floats, wavenumber: float, points: Floats) -> tuple[Floats, Floats]:
    """Amplitudes of the six stresses (n, 6) and of the displacements (n, 3) at points (n, 2) inside the body."""
    space = harmonic.elasticity.space

    def stresses_and_displacements(batch: CellBatch) -> tuple[Reconstruction, Floats]:
        reconstruction, stress = harmonic.cell_stresses(batch, amplitudes, wavenumber)
        moved = np.einsum("pme,mei->ipe", reconstruction.projected_value, amplitudes[batch.dofs])
        missing = moved.shape[1] - stress.shape[1]  # stresses have a lower degree
        return reconstruction, np.concatenate((np.pad(stress, ((0, 0), (0, missing), (0, 0))), moved))

    found = polynomials_at(space, points, locate(space.mesh, points), stresses_and_displacements, 9)
    return found[:, :6], found[:, 6:]


def _bar(n_sides: int, element: Element, *, graded: bool) -> tuple[Harmonic, EdgeQuadrature]:
    """A round bar of radius 1 as a polygon of equal area under the pressure 1, with coarser cells inside if graded."""
    radius = np.sqrt(2.0 * np.pi / (n_sides * np.sin(2.0 * np.pi / n_sides)))
    angles = 2.0 * np.pi * (np.arange(n_sides + 1) + 0.5) / n_sides
    rim = radius * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    size = 2.1 * np.pi / n_sides
    zones = [Refinement(rim, size=size, growth=48.0 / n_sides)] if graded else []
    mesh = triangulate(polygon(rim[:-1]), size=6.0 * size if graded else size, refinements=zones)
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    space = Space(mesh.with_edge_set("rim", mesh.boundary_edges), element)
    harmonic = Harmonic(Elasticity(space, STEEL, loads=[Pressure("rim", 1.0)]))
    return harmonic, edge_quadrature(space, space.mesh.edge_set("rim"))


def _cosine(wavenumber: float, points: Floats) -> Floats:
    """Return ``cos ky`` at points (n, 2)."""
    return np.cos(wavenumber * points[:, 1])


def _half_section(length: float, n_across: int, n_along: int, element: Element) -> Space:
    """Half section of a round body of radius 1, its axis at x = 0."""
    mesh: PolyMesh = rectangle_grid(1.0, length, n_across, n_along)
    mesh = dual(mesh) if isinstance(element, Virtual) else mesh
    edges, points = mesh.boundary_edges, mesh.points
    for name, axis, place in (("rim", 0, 1.0), ("low", 1, 0.0), ("top", 1, length)):
        mesh = mesh.with_edge_set(name, edges[(np.abs(points[edges][:, :, axis] - place) < 1e-9).all(axis=1)])
    return Space(mesh, element)


def _revolution(space: Space, loads: Sequence[Pressure]) -> Harmonic:
    """Body of revolution whose ends do not move along the axis."""
    material = Elastic(1.0, POISSON, "axisymmetric")
    return Harmonic(Elasticity(space, material, loads=loads), held={"low": "y", "top": "y"})
