"""Bodies in three dimensions by plane problems: what ``flangeway reproduce spatial`` computes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby

import numpy as np
from scipy.interpolate import CubicSpline

from flangeway.cases.section_run import TorsionCase, find_section, run_section, usual_size
from flangeway.elements import Element, Lagrange, Reconstruction, Virtual, monomials
from flangeway.geometry import polygon
from flangeway.geometry.arrays import middles_of
from flangeway.materials import Elastic
from flangeway.mesh import PolyMesh, Refinement, dual, rectangle_grid, triangulate
from flangeway.post import SectionConstants, Stresses
from flangeway.post.stress import locate, polynomials_at
from flangeway.problems import Elasticity, Foundation, Harmonic, LongitudinalTraction, Pressure, Traction
from flangeway.problems.loads import EdgeQuadrature, edge_quadrature
from flangeway.solve import HarmonicSolution, solve_harmonic
from flangeway.space import CellBatch, Space
from flangeway.types import Floats
from flangeway_studies.patches import conforming_rows, hertz_rows
from flangeway_studies.study import Limit, Row, Run, percent, published_rows

# --- A bar under a pressure that varies as a cosine, as a prism and a body of revolution, and a disc under two forces.


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
                solution = solve_harmonic(harmonic, ka)
                along = np.einsum("eq,qm,em->", rim.weights, rim.shapes, solution.amplitudes[rim.nodes, 2])
                # int u . n ds = 2 A u_r, on the polygon and on the circle
                values = -solution.energy / area, (along / rim.weights.sum())
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
            solution = solve_harmonic(harmonic, 0)
            at = [harmonic.elasticity.node_at((1.0, y)) for y in (0.0, length / 2.0)]
            values = solution.amplitudes[at[0], 0], solution.amplitudes[at[1], 1]
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
    points = np.array([[1e-9, 0.025], [0.5, 0.025]])
    rim = harmonic.elasticity.node_at((1.0, 0.0))
    grown, stresses = [], np.zeros((2, 6))
    for number in range(0, HARMONICS + 1, 2):
        solution = solve_harmonic(harmonic, number)
        # inward forces P = 1 per width at t = 0 and pi, and what is seen at t = pi / 2
        amplitude = (2.0 if number else 1.0) / np.pi * np.cos(number * np.pi / 2.0)
        grown.append(2.0 * amplitude * solution.amplitudes[rim, 0])
        stresses += amplitude * fields_at(harmonic, solution.amplitudes, number, points)[0]
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

    polynomials = polynomials_at(space, points, locate(space.mesh, points), stresses_and_displacements, 9)
    return polynomials[:, :6], polynomials[:, 6:]


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
    for name, axis, position in (("rim", 0, 1.0), ("low", 1, 0.0), ("top", 1, length)):
        mesh = mesh.with_edge_set(name, edges[(np.abs(points[edges][:, :, axis] - position) < 1e-9).all(axis=1)])
    return Space(mesh, element)


def _revolution(space: Space, loads: Sequence[Pressure]) -> Harmonic:
    """Body of revolution whose ends do not move along the axis."""
    material = Elastic(1.0, POISSON, "axisymmetric")
    return Harmonic(Elasticity(space, material, loads=loads), held={"low": "y", "top": "y"})


# --- Loads on a small area: a square on a half-space, and a wheel's load on a rail on a foundation.


SQUARE = Elastic(2.56, 0.28)
SQUARE_LIMIT = 3e-3
TANGENTIAL = 0.999
BLOCK = 60.0
"""Depth and half width of the block that stands for a half-space, over the side of the square."""
FAR = 8.0
"""Distance from the square along z, where the block's displacement differs from a half-space's by its rigid motion."""
SQUARE_WAVES: Floats = np.geomspace(1e-3, 60.0, 36)

RAIL, RAIL_STEEL = "136RE", Elastic(210e3, 0.3)
FOUNDATIONS = (3.0, 30.0)
"""Under the whole foot of the rail in N/mm per mm: a weak one, and that of a good track."""
ALONG_FOUNDATION = 0.01
"""Foundation along the rail over that across it."""
ECCENTRICITIES = (0.0, 20.0)
COARSER = 1.4
"""Size of the elements over the usual one."""
LOADED = 8.0
"""Half width of the loaded strip across, in mm."""
STRIP = 12.0
"""Its length along the rail in mm."""
RAIL_WAVES: Floats = np.geomspace(1e-5, 0.5, 33)
LONG_WAVES: Floats = np.array([2e-3, 1e-3, 5e-4])
"""Per mm, from which the limit of long waves is extrapolated."""
SLICES = 400
"""Horizontal slices of the section for its shear area."""
BEAM_LIMIT, STIFFNESS_LIMIT = 0.02, 1e-4


def transformed(waves: Floats, amplitudes: Floats, length: float, distance: float = 0.0) -> Floats:
    """Field at a distance along z by a uniform load on a strip about z = 0.

    ``(1 / pi) int A(k) L sinc(k L / 2) cos kz dk``, A a cubic spline over log k that is constant below the least
    wavenumber; above the normal_stress one it has to be 0.

    Parameters
    ----------
    waves
        Wavenumbers, rising, shape (n_k,).
    amplitudes
        Of the field by a load of amplitude 1 per area, shape (n_k, ...).
    length, distance
        Length of the strip, and place of the field.

    """
    spline = CubicSpline(np.log(waves), amplitudes, bc_type="natural")
    least, most = waves[0], waves[-1]
    k = np.concatenate(([0.0], np.geomspace(least, most, int(20.0 * most * (length + distance)) + 4000)))
    weights = np.zeros(len(k))
    weights[1:] += np.diff(k) / 2.0
    weights[:-1] += np.diff(k) / 2.0
    weights *= length * np.sinc(k * length / (2.0 * np.pi)) * np.cos(k * distance) / np.pi
    result: Floats = np.tensordot(weights, spline(np.log(np.maximum(k, least))), axes=1)
    return result


def square_numbers() -> Iterator[Row]:
    """Displacements and stresses below the centre of a loaded square, the tangential traction across or along z."""
    rows = [row for row in published_rows("spatial.csv") if row["case"] == "square"]
    depths = sorted({float(row["code"]) for row in rows})
    points = np.array([[0.0, -depth] for depth in depths])
    amplitudes = np.array(
        [
            [np.hstack(fields_at(harmonic, solve_harmonic(harmonic, k).amplitudes, k, points)) for harmonic in _block()]
            for k in SQUARE_WAVES.tolist()
        ]
    )
    # stresses xx, yy, zz, xy, yz, xz and displacements x, y, z
    near = transformed(SQUARE_WAVES, amplitudes, 1.0)
    far = transformed(SQUARE_WAVES, amplitudes[:, :, 0, 6:], 1.0, FAR)
    # Boussinesq and Cerruti: a half-space's surface at a distance z from a force along x, -y or z
    compliance = 1.0 / (2.0 * np.pi * SQUARE.shear_modulus * FAR)
    half_space = compliance * np.array([TANGENTIAL * (1.0 - SQUARE.poisson), SQUARE.poisson - 1.0, TANGENTIAL])
    near[0, :, 6:8] -= far[0, :2] - half_space[:2]
    near[1, :, 8] -= far[1, 2] - half_space[2]
    for row in rows:
        exact, name, depth = float(row["value"]), row["quantity"], float(row["code"])
        one, other = near[:, depths.index(depth)]
        sxx, syy, szz, sxy = one[:4]
        normal_stress = abs(float(syy))
        computed = {
            "u_x": ((one[6], "across"), (other[8], "along")),
            "u_z": ((-one[7], ""),),
            "s_xx": ((sxx, ""),),
            "s_yy": ((szz, ""),),
            "s_zz": ((syy, ""),),
            "s_xz": ((-sxy, "across"), (-other[4], "along")),
            "von_Mises": ((Stresses(np.array([[sxx, syy, sxy, szz]])).von_mises[0], ""),),
        }[name]
        for value, which in computed:
            small = name.startswith("s_") and abs(exact) < normal_stress / 2.0
            close = Limit(f"{percent(SQUARE_LIMIT)} of s_zz", abs(value - exact) <= SQUARE_LIMIT * normal_stress)
            location = f"depth {depth:g} {which}".strip()
            yield Row("Square", location, name, "", float(value), exact, close if small else SQUARE_LIMIT)


def _block() -> tuple[Harmonic, Harmonic]:
    """A block with tractions down and across, and along, on the middle of its top."""
    top = (BLOCK, 0.5, -0.5, -BLOCK)
    outline = polygon(
        [(-BLOCK, -BLOCK), (BLOCK, -BLOCK), *((x, 0.0) for x in top)],
        ["base", "right", "top right", "loaded", "top left", "left"],
    )
    zones = [Refinement(np.array([[x, 0.0]]), 0.015, 0.25) for x in (-0.5, 0.5)]
    zones.append(Refinement(np.array([[0.0, 0.0], [0.0, -3.0]]), 0.06, 0.25))
    space = Space(triangulate(outline, size=20.0, refinements=zones), Lagrange(2))
    held: dict[str | tuple[float, float], str] = {"base": "xyz"}
    return (
        Harmonic(Elasticity(space, SQUARE, loads=[Traction("loaded", (TANGENTIAL, -1.0))]), held=held),
        Harmonic(Elasticity(space, SQUARE), [LongitudinalTraction("loaded", TANGENTIAL)], held=held),
    )


@dataclass(frozen=True, eq=False)
class Rail:
    """A meshed rail.

    Parameters
    ----------
    space
        Its section; the foot is the edge set ``base``, the strips of the load are ``load 0``, ``load 1``, ...
    constants
        Of the section.
    foot
        Width of the foot's base.

    """

    space: Space
    constants: SectionConstants
    foot: float

    def harmonic(self, loads: list[Traction], foundation: float) -> Harmonic:
        """Return the rail with loads on a foundation."""
        body, modulus = Elasticity(self.space, RAIL_STEEL, loads=loads), foundation / self.foot
        supports = [Foundation("base", modulus, modulus, ALONG_FOUNDATION * modulus)] if foundation else []
        return Harmonic(body, foundations=supports)

    def length(self, edges: str) -> float:
        """Length of an edge set."""
        ends = self.space.mesh.points[self.space.mesh.edge_set(edges)]
        return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())

    @property
    def shear_area(self) -> float:
        """Area with which a vertical shear force deflects the rail (Jourawski), ``I^2 / int Q^2 / b dy``."""
        mesh, centre = self.space.mesh, self.constants.centroid[1]
        first, last = mesh.points[mesh.boundary_edges].swapaxes(0, 1)
        low, high = float(mesh.points[:, 1].min()), float(mesh.points[:, 1].max())
        step = (high - low) / SLICES
        levels = low + step * (np.arange(SLICES) + 0.5)
        share = (levels[:, None] - first[:, 1]) / np.where(first[:, 1] == last[:, 1], np.inf, last[:, 1] - first[:, 1])
        crossed = np.sign(last[:, 1] - first[:, 1]) * (first[:, 0] + share * (last[:, 0] - first[:, 0]))
        crosses = (first[:, 1] - levels[:, None]) * (last[:, 1] - levels[:, None]) < 0.0
        widths = np.where(crosses, crossed, 0.0).sum(axis=1)
        moments = np.cumsum(((levels - centre) * widths)[::-1])[::-1] * step
        return self.constants.second_moments[0] ** 2 / float((moments**2 / widths).sum() * step)


def meshed_rail() -> Rail:
    """Return the rail with its loaded strips."""
    drawn = find_section(RAIL)
    run = run_section(drawn, TorsionCase.from_values({"size": COARSER * usual_size(drawn.section)}))
    mesh = run.space.mesh
    edges = mesh.boundary_edges
    middles = mesh.points[edges].mean(axis=1)
    for number, eccentricity in enumerate(ECCENTRICITIES):
        on_head = (np.abs(middles[:, 0] - eccentricity) < LOADED) & (middles[:, 1] > middles[:, 1].max() - LOADED)
        mesh = mesh.with_edge_set(f"load {number}", edges[on_head])
    space = Space(mesh, run.case.element)
    return Rail(space, run.constants, float(np.ptp(mesh.points[mesh.edge_set("base")][..., 0])))


def rail_rows() -> Iterator[Row]:
    """Deflection, twist and moment of a rail below its load beside those of beams, and its answers to long waves.

    The beams are Euler and Bernoulli's, and Timoshenko's with shear, with Saint-Venant's and Vlasov's torsion.
    """
    rail = meshed_rail()
    constants = rail.constants
    vertical, lateral, twisting, warping = RAIL_STEEL.young * np.array(
        [*constants.second_moments[:2], constants.torsion_constant / 2.6, constants.warping_constant]
    )
    shear, height, waves = rail.shear_area * RAIL_STEEL.shear_modulus, constants.shear_centre[1], RAIL_WAVES
    foot_nodes = np.unique(rail.space.edge_nodes(rail.space.mesh.edge_set("base")))
    across = rail.space.nodes[foot_nodes, 0]
    for foundation in FOUNDATIONS:
        for number in range(len(ECCENTRICITIES)):
            edges = f"load {number}"
            harmonic = rail.harmonic([Traction(edges, (0.0, -1.0 / rail.length(edges)))], foundation)
            forces = harmonic.load_vector()[: rail.space.n_nodes, 1]
            eccentricity = -float(forces @ rail.space.nodes[:, 0])
            solutions = [solve_harmonic(harmonic, k) for k in waves.tolist()]
            foot: Floats = np.array(
                [np.polyfit(across, solution.amplitudes[foot_nodes, 1], 1) for solution in solutions]
            )
            moments: Floats = np.array([_moment(solution, constants.centroid[1]) for solution in solutions])
            # the beam at each wavenumber: vertical, and lateral at the shear centre with the twist about it
            bending = 1.0 / (vertical * waves**4 + foundation)
            sheared = 1.0 / (vertical * waves**4 / (1.0 + vertical * waves**2 / shear) + foundation)
            sideways, coupling = lateral * waves**4 + foundation, foundation * height
            about = warping * waves**4 + twisting * waves**2 + foundation * (height**2 + rail.foot**2 / 12.0)
            twist = -eccentricity * sideways / (sideways * about - coupling**2)
            at_load = partial(transformed, waves, length=STRIP)
            (slope, down), lowered, turned = at_load(foot) / STRIP, at_load(bending) / STRIP, at_load(twist) / STRIP
            code, value = f"U={foundation:g} e={abs(eccentricity):.0f}", -float(down + slope * eccentricity)
            weak, bend = foundation == FOUNDATIONS[0], float(turned) * eccentricity
            note = "" if weak else "without shear, which adds more than 2 % on a stiff foundation"
            beam = float(lowered) - bend
            yield Row("Rail", code, "deflection", "mm/N", value, beam, BEAM_LIMIT if weak else None, note)
            beam = float(at_load(sheared) / STRIP) - bend
            yield Row("Rail", code, "deflection, with shear", "mm/N", value, beam, BEAM_LIMIT)
            beam = float(at_load(vertical * waves**2 * bending)) / STRIP
            yield Row("Rail", code, "bending moment", "mm", float(at_load(moments)) / STRIP, beam, BEAM_LIMIT)
            if eccentricity > 1.0:
                note = "the web bends: the section does not keep its shape, as that of a beam"
                yield Row("Rail", code, "twist of the foot", "1/N", float(slope), float(turned), None, note)
    exact = RAIL_STEEL.young * np.array(
        [constants.area, constants.second_moments[0], constants.torsion_constant / 2.0 / (1.0 + RAIL_STEEL.poisson)]
    )
    for name, unit, beam, value in zip(
        ("EA", "EI", "GJ"), ("N", "N mm2", "N mm2"), exact, _long_waves(rail), strict=True
    ):
        yield Row("Rail", "long waves", name, unit, value, float(beam), STIFFNESS_LIMIT)


def _long_waves(rail: Rail) -> tuple[float, ...]:
    """EA, EI and GJ of a rail without supports, extrapolated to the wavenumber 0, where they are polynomials in k^2."""
    top, base = (1.0 / rail.length(name) for name in ("load 0", "base"))
    forces = rail.harmonic([Traction("load 0", (0.0, top))], 0.0).load_vector()[: rail.space.n_nodes, 1]
    height = float(forces @ rail.space.nodes[:, 1])
    # a pull without moment about the centroid
    share = rail.constants.centroid[1] / height
    pulls = [LongitudinalTraction("load 0", share * top), LongitudinalTraction("base", (1.0 - share) * base)]
    cases = (
        (Harmonic(Elasticity(rail.space, RAIL_STEEL), pulls), 1.0, 2),
        (rail.harmonic([Traction("load 0", (0.0, top))], 0.0), 1.0, 4),
        (rail.harmonic([Traction("load 0", (top, 0.0)), Traction("base", (-base, 0.0))], 0.0), height, 2),
    )
    return tuple(
        float(
            np.polyfit(
                LONG_WAVES**2,
                [action**2 / (2.0 * solve_harmonic(row, k).energy * k**power) for k in LONG_WAVES.tolist()],
                2,
            )[-1]
        )
        for row, action, power in cases
    )


def _moment(solution: HarmonicSolution, height: float) -> float:
    """Amplitude of the bending moment of a section, ``-int sigma_zz (y - height) dA``."""
    total = 0.0
    for batch in solution.problem.elasticity.space.batches():
        reconstruction, stress = solution.problem.cell_stresses(batch, solution.amplitudes, solution.wavenumber)
        points, weights = batch.quadrature(reconstruction.order + 1)
        at = monomials.evaluate(reconstruction.order, reconstruction.frame.local(points))[: stress.shape[1]]
        total -= float(np.einsum("pe,pqe,qe->", stress[2], at, weights * (points[:, 1] - height)))
    return total


# --- Bodies in three dimensions by plane problems: what ``flangeway reproduce spatial`` computes.


def rows(run: Run) -> Iterator[Row]:
    """Rows of all parts; if quick, the finest mesh of short waves is left out but for the element of order 3."""
    for element in sorted(ELEMENTS):
        yield from bar_rows(run, element)
    yield plane_strain_row()
    yield from revolution_numbers()
    yield from square_numbers()
    yield from rail_rows()
    yield from hertz_rows(run)
    yield from conforming_rows(run)
