"""A rail on sleepers in three dimensions, from its section at many wavenumbers.

All is a sum over wavenumbers of the section's amplitudes. Sleepers are superposed in two steps. At each wavenumber all
but a share `SPREAD` of the continuous support, of stiffness K per length, is taken away: fields A that loads of the
base's modes (forces along x and y, moment) cause, and their mean displacements G = M' A, become
``A (1 - (1 - SPREAD) K G)^-1``. Then forces of the seats, found from the compliance between them, take its place.
The share that is left bounds the motion beyond the last sleepers, and changes the result by about that much of the
difference between sleepers and continuous support.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flangeway.elements import Lagrange
from flangeway.elements.quadrature import edge_shapes
from flangeway.errors import InputError
from flangeway.materials import Elastic
from flangeway.mesh import triangulate
from flangeway.problems import Harmonic
from flangeway.problems.edges import edge_quadrature
from flangeway.problems.harmonic import mean_and_rotation
from flangeway.railway.profiles.bundled import RailProfile
from flangeway.railway.spatial.rail_supports import RailSupport, rail_problem
from flangeway.solve.surface_compliance import amplitudes, inverse_weights
from flangeway.space import Space
from flangeway.system.disk_cache import Cache, content_key
from flangeway.types import Floats, Ints

SPREAD = 0.003
"""Share of the sleepers' stiffness that stays spread along the rail."""
WAVENUMBERS = (5e-6, 0.3)
"""Range per mm: from the reach of torsion on the share that is spread to waves of 20 mm."""
PER_DECADE = 8
"""Wavenumbers for each decade; three times as many change no displacement by more than 1e-4."""
FAR = 0.02
"""Load of the last sleepers over that of the most loaded one, above which there are too few."""
MAX_OFF_MM = 3.0
"""Distance from the section's surface above which points are in another frame; chords and corners make up to 1 mm."""
CHUNK = 64
"""Distances whose weights are computed together: bounds their memory."""


def weights_at(wavenumbers: Floats, distances: Floats, strip: float, averaged: int) -> tuple[Floats, Floats]:
    """`inverse_weights` at signed distances (...), each (..., n_k): of cosine and sine of ``k z``."""
    apart, places = np.unique(np.round(np.abs(distances), 6).astype(np.float64), return_inverse=True)
    parts = [
        inverse_weights(wavenumbers, apart[start : start + CHUNK], strip, averaged)
        for start in range(0, len(apart), CHUNK)
    ]
    even, odd = (np.concatenate(each)[places.reshape(distances.shape)] for each in zip(*parts, strict=True))
    return even, np.sign(distances)[..., None] * odd


@dataclass(frozen=True, eq=False)
class SupportedRail:
    """A rail on its support, solved once for all positions of the wheel between the sleepers.

    Parameters
    ----------
    problem
        The rail on its continuous support, see `rail_problem`.
    support
        The support; the wheel is at z = 0.
    cache
        Where the section's amplitudes are kept from one process to the next.

    """

    problem: Harmonic
    support: RailSupport
    cache: Cache | None = None

    @property
    def wavenumbers(self) -> Floats:
        """Wavenumbers at which the section is solved, (n_k,)."""
        least, top = WAVENUMBERS
        return np.geomspace(least, top, int(np.ceil(PER_DECADE * np.log10(top / least))) + 1)

    @cached_property
    def base(self) -> tuple[Ints, Floats]:
        """Nodes of the base, and their forces by unit loads of its modes (even along x, along y, moment), (n, 3, 3)."""
        space = self.problem.elasticity.space
        edges = space.mesh.edge_set(self.problem.foundations[0].edges)
        nodes, (mean, slope), _ = mean_and_rotation(edge_quadrature(space, edges))
        loads = np.zeros((len(nodes), 3, 3))
        loads[:, 0, 0], loads[:, 1, 1], loads[:, 1, 2] = mean, mean, slope
        return nodes, loads

    def answers(self, nodes: Ints, loads: Floats) -> Floats:
        """Amplitudes at all wavenumbers by m loads (n, 3, m) at nodes (n,): (n_k, n_dofs, 3, m)."""
        space = self.problem.elasticity.space
        rhs = np.zeros((space.n_dofs, 3, loads.shape[-1]))
        np.add.at(rhs, nodes, loads)
        rhs = rhs.reshape(3 * space.n_dofs, 1, -1)
        found = np.stack(list(amplitudes(self.problem, self.wavenumbers, rhs)))
        return found.reshape(len(found), space.n_dofs, 3, -1)

    @cached_property
    def by_modes(self) -> Floats:
        """Amplitudes by the base's modes on the continuous support, (n_k, n_dofs, 3, 3 modes)."""
        elasticity = self.problem.elasticity
        mesh, foundation = elasticity.space.mesh, self.problem.foundations[0]
        key = content_key(
            "supported rail",
            (mesh.points, mesh.cell_offsets, mesh.cell_points, mesh.edge_set(foundation.edges)),
            (elasticity.space.element, elasticity.material, foundation, WAVENUMBERS, PER_DECADE),
        )
        if self.cache is None or key is None:
            return self.answers(*self.base)
        found: Floats = self.cache.get(key, lambda: {"amplitudes": self.answers(*self.base)})["amplitudes"]
        return found

    @cached_property
    def freedom(self) -> Floats:
        """X = ((1 - SPREAD)^-1 K^-1 - G)^-1 at the wavenumbers, by which A X M' A is what spreading less adds."""
        kept = np.diag(1.0 / ((1.0 - SPREAD) * self.support.per_length))
        return np.linalg.inv(kept - self.on_base(self.by_modes)).astype(np.float64)

    def on_base(self, fields: Floats) -> Floats:
        """Mean displacements of the base along x, y and rotation, of fields (..., n_dofs, 3, m): (..., 3, m)."""
        nodes, loads = self.base
        return np.einsum("nia,...nim->...am", loads, fields[..., nodes, :, :])

    def released(self, fields: Floats) -> Floats:
        """Fields (n_k, n_dofs, 3, m) of the continuous support, as they are with only its share `SPREAD`."""
        if self.support.kind == "continuous":
            return fields
        change: Floats = self.freedom @ self.on_base(fields)
        return fields + np.einsum("kdia,kam->kdim", self.by_modes, change)

    @cached_property
    def by_seats(self) -> Floats:
        """Amplitudes by the base's modes with the share `SPREAD` of the support, (n_k, n_dofs, 3, 3 modes)."""
        return self.released(self.by_modes)

    @cached_property
    def seat_stiffness(self) -> Floats:
        """Forces of seats (minus) by the displacements that others cause there, (n_sleepers, 3, n_sleepers, 3).

        ``R = (K^-1 + G)^-1`` with the stiffnesses K of the seats and the compliance G between them. An `InputError` if
        the load reaches beyond the last ones.
        """
        places = self.support.sleepers_mm
        n = len(places)
        even, _ = weights_at(self.wavenumbers, places - places[:1], self.support.pad_length_mm, 2)
        by_distance = np.einsum("zk,kam->zam", even, self.on_base(self.by_seats))
        apart = np.abs(np.arange(n)[:, None] - np.arange(n))
        between = by_distance[apart].transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)
        found = np.linalg.inv(between + np.diag(np.tile(1.0 / ((1.0 - SPREAD) * self.support.of_seat), n)))
        # a load over the middle sleeper, each along its own mode
        carried = np.abs(np.einsum("sma,am->sm", found.reshape(n, 3, -1), between[:, 3 * (n // 2) :][:, :3]))
        if (carried[[0, -1]] > FAR * carried.max(axis=0)).any():
            raise InputError(
                f"{n} sleepers, the last with {(carried[[0, -1]] / carried.max(axis=0)).max():.2g} of the largest load",
                f"as many as the load reaches, with less than {FAR:g} there",
                "raise the stiffness of the seats or n_sleepers, or take a continuous support",
            )
        return found.reshape(n, 3, n, 3)

    @cached_property
    def at_place(self) -> Floats:
        """Weights of cos kz at z = 0 by forces there, (n_k,)."""
        return weights_at(self.wavenumbers, np.zeros(1), self.support.pad_length_mm, 0)[0][0]

    @cached_property
    def from_seats(self) -> tuple[Floats, Floats]:
        """Weights of cosine and sine at z = 0 by loads of the seats, each (n_sleepers, n_k)."""
        return weights_at(self.wavenumbers, -self.support.sleepers_mm, self.support.pad_length_mm, 1)

    def at(self, position: float) -> "SupportedRail":
        """The same rail with the wheel at another position between the sleepers, see `RailSupport`."""
        moved = replace(self, support=replace(self.support, position=position))
        if self.support.kind == "sleepers":
            shared = ("base", "by_modes", "freedom", "by_seats", "seat_stiffness", "at_place")
            moved.__dict__.update({name: getattr(self, name) for name in shared})
        return moved

    def on_surface(self, points: Floats) -> tuple[Ints, Floats]:
        """Nodes of the boundary's edges nearest to points (n, 2), and their shares at the feet, each (n, order + 1).

        Points of another mesh of the section lie off these chords where the outline turns, most at the joints of a
        measured head with its body: they are projected. An `InputError` if one is farther away than `MAX_OFF_MM`.
        """
        space = self.problem.elasticity.space
        edges = space.mesh.boundary_edges
        start, chords = space.mesh.points[edges[:, 0]], np.diff(space.mesh.points[edges], axis=1)[:, 0]
        squares = (chords**2).sum(axis=1)
        apart = points[:, None] - start
        share = np.clip(np.einsum("nei,ei->ne", apart, chords) / squares, 0.0, 1.0)
        distances = np.linalg.norm(apart - share[..., None] * chords, axis=-1)
        best, rows = distances.argmin(axis=1), np.arange(len(points))
        if len(points) and (maximum := float(distances[rows, best].max())) > MAX_OFF_MM:
            raise InputError(
                f"points up to {maximum:.3g} mm from the surface of `{self.problem.elasticity.name}`",
                "points on the surface, in the frame of the section",
                "check the placement of the rail",
            )
        return space.edge_nodes(edges)[best], edge_shapes(space.order, share[rows, best])

    def seats_from(self, nodes: Ints, shares: Floats) -> Floats:
        """Displacements of points at z = 0 by unit loads of the seats: (n, 3, n_sleepers, 3).

        By reciprocity they are also the displacements of the seats by unit forces at the points.
        """
        at_points = np.einsum("np,knpim->knim", shares, self.by_seats[:, nodes])
        even, odd = self.from_seats
        found = np.einsum("sk,knim->nism", even, at_points)
        found[:, 2] = np.einsum("sk,knm->nsm", odd, at_points[:, :, 2])
        return found

    def seat_forces(self, nodes: Ints, shares: Floats, forces: Floats) -> Floats:
        """Loads of the seats on the rail by forces (n, 3) at points at z = 0: (n_sleepers, 3)."""
        if self.support.kind == "continuous":
            return np.empty((0, 3))
        moved = np.einsum("nism,ni->sm", self.seats_from(nodes, shares), forces)
        return -np.einsum("satb,tb->sa", self.seat_stiffness, moved)


def supported_rail(
    profile: RailProfile,
    material: Elastic,
    support: RailSupport,
    size_mm: float = 6.0,
    cache: Cache | None = None,
) -> SupportedRail:
    """Mesh a rail's section by triangles of order 2 and a size, for what a support does to it.

    Only smooth fields come from this mesh; contact wants a finer one, see `rail_problem`.
    """
    mesh = triangulate(profile.outline, size=size_mm)
    mesh = mesh.with_edge_set("supported base", np.vstack([mesh.edge_set(name) for name in profile.base_names]))
    problem = rail_problem(Space(mesh, Lagrange(2)), material, "supported base", support)
    return SupportedRail(problem, support, cache)


def sleeper_compliance(rail: SupportedRail, points: Floats, frames: Floats) -> Floats:
    """What discrete sleepers change of the compliance of cells near z = 0 on a continuous support.

    It is taken at the wheel's place as constant over a patch: 10 mm from there it differs by less than 0.15 % of the
    rail's whole compliance. The coarse section errs by 2 % of the difference.

    Parameters
    ----------
    rail
        The rail, in its own frame.
    points
        Middles of cells on the surface of any mesh of the section, (n, 2).
    frames
        Axes t, n and z of the cells as rows, (n, 3, 3), see `flangeway.solve.SurfaceCells`.

    Returns
    -------
    Floats
        Displacements by unit forces, mm/N, (n, 3, n, 3), symmetric; zero for a continuous support.

    """
    if rail.support.kind == "continuous":
        return np.zeros((len(points), 3, len(points), 3))
    nodes, shares = rail.on_surface(points)
    seats = rail.seats_from(nodes, shares)
    n, n_loads = len(points), 3 * rail.support.n_sleepers
    in_axes = np.einsum("nai,nim->nam", frames, seats.reshape(n, 3, n_loads)).reshape(3 * n, n_loads)
    taken = in_axes @ rail.seat_stiffness.reshape(n_loads, n_loads) @ in_axes.T
    fields = np.einsum("nai,np,knpim->knam", frames, shares, rail.by_modes[:, nodes], optimize=True)
    fields = fields.reshape(len(fields), 3 * n, 3)
    added = np.einsum("k,krm,kmj,kcj->rc", rail.at_place, fields, rail.freedom, fields, optimize=True).reshape(
        n, 3, n, 3
    )
    added[:, :2, :, 2] = added[:, 2, :, :2] = 0.0  # they vary as the sine
    change: Floats = added - taken.reshape(n, 3, n, 3)
    return change
