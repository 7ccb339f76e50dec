"""A bar under a pressure that varies as a cosine, as a prism and a body of revolution, and a disc under two forces."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, pairwise

import numpy as np

from flangeway.elements import Element, Lagrange, Reconstruction, Virtual
from flangeway.geometry import polygon
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, dual, rectangle_grid, triangulate
from flangeway.post.lines import locate, polynomials_at
from flangeway.problems import Elasticity, Harmonic, Pressure
from flangeway.problems.edges import EdgeQuadrature, edge_quadrature
from flangeway.solve import solve_harmonic
from flangeway.space import CellBatch, Space
from flangeway.types import Floats
from studies.published_numbers import ReproducedNumber, compare, published_rows

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


@dataclass(frozen=True)
class BarRow:
    """A bar under the pressure cos kz on one mesh: a row of ``bar.csv``.

    Parameters
    ----------
    element
        Name in `ELEMENTS`.
    ka
        Wavenumber times radius.
    n_sides
        Sides of the polygon.
    n_unknowns
        Amplitudes.
    u_r, u_z
        Mean displacement outwards, from the work of the pressure, and along z at the surface.
    error
        Larger error of both over the amplitude of the exact displacement.

    """

    element: str
    ka: float
    n_sides: int
    n_unknowns: int
    u_r: float
    u_z: float
    error: float


def exact_bar() -> dict[float, tuple[float, float]]:
    """Displacements u_r and u_z by the wavenumber times the radius."""
    rows = [row for row in published_rows("spatial.csv") if row["case"] == "bar"]
    return {
        float(ka): tuple(float(row["value"]) for row in group)  # type: ignore[misc]
        for ka, group in groupby(rows, lambda row: row["code"])
    }


def bar_rows(element: str, *, quick: bool) -> Iterator[BarRow]:
    """Bars of all wavenumbers on three meshes each; if `quick`, the finest of short waves by order 3 only."""
    for short in (False, True):
        most = 2 if quick and short and ELEMENTS[element].order < max(BAR_LIMITS) else 3
        for n_sides in SIDES[short][:most]:
            harmonic, rim = _bar(n_sides, ELEMENTS[element], graded=short)
            area = float(harmonic.elasticity.space.mesh.cell_areas.sum())
            for ka, (u_r, u_z) in exact_bar().items():
                if (ka > SHORT_WAVES) != short:
                    continue
                found = solve_harmonic(harmonic, ka)
                along = np.einsum("eq,qm,em->", rim.weights, rim.shapes, found.amplitudes[rim.nodes, 2])
                # int u . n ds = 2 A u_r, on the polygon and on the circle
                values = -found.energy / area, float(along / rim.weights.sum())
                error = max(abs(values[0] - u_r), abs(values[1] - u_z)) / float(np.hypot(u_r, u_z))
                yield BarRow(element, ka, n_sides, found.amplitudes.size, *values, error)


def bar_numbers(rows: Sequence[BarRow]) -> Iterator[ReproducedNumber]:
    """Displacements on the finest meshes, and rates of convergence."""
    for (element, ka), group in groupby(
        sorted(rows, key=lambda row: (row.element, row.ka, row.n_sides)), lambda row: (row.element, row.ka)
    ):
        series = list(group)
        finest, order, code = series[-1], ELEMENTS[element].order, f"{element} ka={ka:g}"
        for name, exact, value in zip(("u_r", "u_z"), exact_bar()[ka], (finest.u_r, finest.u_z), strict=True):
            yield compare(
                "Bar",
                code,
                name,
                "a/E",
                (exact, value),
                BAR_LIMITS[order],
                f"{finest.n_sides} sides",
                words=None if order == max(BAR_LIMITS) or ka < SHORT_WAVES else "",
            )
        rate = rates(series)[-1]
        if finest.error > ROUND_OFF:
            least, edges = RATES[order] - LESS_THAN_RATE, finest.n_sides / ka
            words = f"at least {least:g}" if edges >= EDGES_A_WAVE else ""
            note = "" if words else f"{edges:.0f} edges a wave: not yet the rate of small elements"
            yield compare(
                "Bar", code, "rate of convergence", "", (RATES[order], rate), np.inf, note,
                words=words, within=rate >= least,
            )  # fmt: skip
    element = "VEM 2"
    harmonic, _ = _bar(SIDES[False][0], ELEMENTS[element], graded=False)
    points = harmonic.elasticity.space.mesh.points
    first = points[np.argmin(np.hypot(points[:, 0] - 1.0, points[:, 1]))]
    second = points[np.argmin(np.hypot(*(points + first).T))]
    held = Harmonic(harmonic.elasticity, held={tuple(first.tolist()): "xy", tuple(second.tolist()): "y"})
    found = solve_harmonic(held, 0.0)
    value = -found.energy / float(harmonic.elasticity.space.mesh.cell_areas.sum())
    exact = -(1.0 + POISSON) * (1.0 - 2.0 * POISSON)
    yield compare("Bar", f"{element} k=0", "u_r", "a/E", (exact, value), 1e-9, "plane strain")


def rates(series: Sequence[BarRow]) -> list[float]:
    """Rates of convergence between meshes of one series."""
    return [
        float(np.log(coarse.error / fine.error) / np.log(fine.n_sides / coarse.n_sides))
        for coarse, fine in pairwise(series)
    ]


def revolution_numbers() -> Iterator[ReproducedNumber]:
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
                yield compare("Bar of revolution", f"{name} ka={ka:g}", quantity, "a/E", (exact, float(value)), limit)
    yield from _disc_numbers()


def _disc_numbers() -> Iterator[ReproducedNumber]:
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
        sums = (sums[1:] + sums[:-1]) / 2.0
    plane_young, plane_poisson = 1.0 / (1.0 - POISSON**2), POISSON / (1.0 - POISSON)
    exact = (4.0 - np.pi + plane_poisson * np.pi) / (np.pi * plane_young)
    yield compare("Disc", "t=90", "growth of the diameter across", "P/E", (exact, float(sums[-1])), 1e-4)
    for s, (radial, _, around, *_) in zip((0.0, 0.5), stresses.tolist(), strict=True):
        code = f"r={s:g} t=90"
        across, along = ((1.0 - s**2) / (1.0 + s**2)) ** 2 / np.pi, (1.0 - 4.0 / (1.0 + s**2) ** 2) / np.pi
        yield compare("Disc", code, "stress across", "P/R", (across, radial), 1e-3)
        yield compare("Disc", code, "stress along the forces", "P/R", (along, around), 1e-3)


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
