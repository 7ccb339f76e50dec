"""Checks of a contact solution that share no code with the gaps, the guards or the iteration that found it."""

from collections.abc import Sequence

import numpy as np

from flangeway.contact.newton import ContactState
from flangeway.contact.node_to_node import MatchedPairs
from flangeway.contact.overlap import BodyOverlap
from flangeway.contact.system import LARGE_OVERLAP, MAX_OVERLAP, ContactSystem
from flangeway.geometry import Placement
from flangeway.geometry.arrays import cross_product, point_text, turned_right
from flangeway.problems import Body, Part
from flangeway.solve import BodyResponse, Checks, Handle
from flangeway.space.symmetric import EPS
from flangeway.types import Floats

MAX_RESIDUAL = 1e-6
"""Sum of forces over the maximum nodal force, and of moments over that and the size: above round-off."""

MAX_SLIDE = 0.5
"""Tangential distance of paired nodes over an edge, above which each faces the partner of another one."""

MAX_KEPT = 1e-3
"""Force along a motion that is kept in place over all forces of the part, see `flangeway.solve.Handle`."""

TINY = float(np.finfo(np.float64).tiny)

LARGE_STRAIN = 0.05
"""Mean strain of a cell, or pressure over the modulus, above which small strains are off by as many parts."""

LARGE_TURN = 0.1
"""Rotation of a cell in rad whose square half, 0.005, is a false strain."""


def check_solution(
    system: ContactSystem,
    response: BodyResponse,
    state: ContactState,
    fields: Sequence[Floats],
    overlaps: Sequence[BodyOverlap],
    given: Sequence[tuple[Placement, Handle | None]],
) -> Checks:
    """Measure a solution whose iteration converged.

    Parameters
    ----------
    system, response, state
        The contacts, the bodies with their loads, and the solution.
    fields
        Displacements of all nodes of each part in its own frame, each (n_dofs, 2).
    overlaps
        See `flangeway.contact.overlap.body_overlaps`.
    given
        Placement of each part before its handle moved it, and the handle with its loads.

    """
    errors = [str(each) for each in overlaps if not each.is_explained]
    undeformed = state.positions - state.displacements
    warnings = [
        f"a corner meets a corner at ({x:.4g}, {y:.4g}): the side that carries the force is arbitrary; move one of "
        "them, or round them off"
        for number in range(len(system.contacts) if state.forces.any() else 0)
        for x, y in system.corners_on_corners(undeformed, number)[:1]
    ]
    size = max(part.body.size for part in system.parts)
    moved = float(np.linalg.norm(state.displacements, axis=1).max(initial=0.0))
    slide, by_slides = _slide(system, state, errors)
    # Forces of a pair act at points that a gap separates: the sum of f.x over all nodes is that of force times gap.
    work = abs(float((state.nodal_forces * (state.positions - state.positions.mean(axis=0))).sum()))
    gap = work / max(float(state.forces.sum()), TINY)
    # forces that displace no digit of the positions are none
    least = TINY + EPS * size / max(part.body.softness for part in system.parts)
    loads = (float(np.abs(handle.load[:2]).max()) for _, handle in given if handle is not None)
    reference = max(float(np.linalg.norm(state.nodal_forces, axis=1).max(initial=0.0)), least, *loads)
    # Friction acts across the gap of a law, and that between nodes; forces of paired nodes across their slides.
    apart = np.abs(state.linearisation.gaps) + LARGE_OVERLAP * moved
    by_gap = 0.0 if state.friction is None else float(np.abs(state.friction.forces) @ apart)
    force, moment = _unbalanced(system, response, state, fields, given)
    force, moment = force / reference, max(0.0, moment - by_slides - by_gap) / (reference * size)
    if not (force <= MAX_RESIDUAL and moment <= MAX_RESIDUAL):
        errors.append(
            f"forces of the contacts and loads are unbalanced by {force:.1e} of the maximum force, moments by "
            f"{moment:.1e} of it times the size; move in smaller steps, or take another pairing"
        )
    inverted, strain, turn = 0, 0.0, 0.0
    for part, field in zip(system.parts, fields, strict=True):
        if isinstance(part.body, Body):
            cells = _cells(part, part.body, field, errors, warnings)
            inverted, strain, turn = inverted + cells[0], max(strain, cells[1]), max(turn, cells[2])
    # without the tolerance for what bends between nodes
    beyond = [each.depth - each.allowed + MAX_OVERLAP * moved for each in overlaps]
    overlap = max([0.0, *beyond])
    if overlap > LARGE_OVERLAP * moved and not errors:
        deepest = overlaps[int(np.argmax(beyond))]
        warnings.append(
            f"{' and '.join(deepest.parts)} overlap by {overlap:.2g} at {point_text(deepest.position)}, "
            f"{100.0 * overlap / moved:.2g} % of the maximum displacement, between nodes: take a finer mesh there"
        )
    measured = force, moment, gap, slide, overlap, inverted, strain, turn
    return Checks(*measured, tuple(errors), tuple(warnings))


def _slide(system: ContactSystem, state: ContactState, errors: list[str]) -> tuple[float, float]:
    """Maximum tangential distance of node-to-node pairs under force over the mean edge, and the moment by all."""
    worst, moment = 0.0, 0.0
    for contact, pairs, _, all_forces in system.solved(state.linearisation, state.forces):
        base = pairs.parts[0]
        if not isinstance(base, MatchedPairs):
            continue
        forces = all_forces[: len(base.keys)]
        if not (loaded := forces > 0.0).any():
            continue
        moment += float(forces @ base.shifts)
        # In mean edges under force: inserted nodes make edges of any shortness, beside which all slides are long.
        slides = np.where(loaded, base.shifts, 0.0) / base.longest[loaded].mean()
        worst = max(worst, most := float(slides.max()))
        if most > MAX_SLIDE:
            at = state.positions[system.nodes_of(contact.secondary)[base.nodes[slides.argmax()]]]
            errors.append(
                f"{contact.secondary.part.name} has slid by {most:.2g} edges from the node opposite it at "
                f"{point_text(at)}, and NodeToNode is for sliding far below an edge; match the boundaries where the "
                "bodies meet, or take SegmentToSegment"
            )
    return worst, moment


def _unbalanced(
    system: ContactSystem,
    response: BodyResponse,
    state: ContactState,
    fields: Sequence[Floats],
    given: Sequence[tuple[Placement, Handle | None]],
) -> tuple[float, float]:
    """Maximum force and moment by which contacts, and each handle with its loads and springs, are unbalanced.

    Motions of a handle that are kept in place take the forces that nothing else does: only their part above
    `MAX_KEPT` of the contact forces counts.
    """
    forces, at = state.nodal_forces, state.positions
    max_moves = [float(np.linalg.norm(field, axis=1).max(initial=0.0)) for field in fields]
    total = forces.sum(axis=0)
    if system.parts[0].body.axisymmetric:
        force, moment = abs(float(total[1])), 0.0
    else:
        force = float(np.linalg.norm(total))
        moment = abs(float(cross_product(at - at.mean(axis=0), forces).sum()))
    for handle in dict.fromkeys(handle for _, handle in given if handle is not None):
        numbers = [number for number, (_, own) in enumerate(given) if own is handle]
        motion = state.placements[numbers[0]].after(given[numbers[0]][0].inverse())
        pivot = motion.points([handle.pivot])[0]
        point = handle.pivot if handle.load_point is None else handle.load_point
        arm = motion.points([point])[0] - pivot
        on_handle = np.append(handle.load[:2], handle.load[2] + cross_product(arm, handle.load[:2]))
        scale, by_strain = 0.0, 0.0
        for number in numbers:
            nodes = slice(*response.offsets[number : number + 2].tolist())
            on_body = response.resultant(number, state.placements[number], pivot)[:3]
            on_handle += on_body
            # loads on a body act where it is not deformed, contact where it is: small strains leave the difference
            by_strain += float(np.linalg.norm(on_body[:2])) * max_moves[number]
            on_handle[:2] += forces[nodes].sum(axis=0)
            on_handle[2] += cross_product(at[nodes] - pivot, forces[nodes]).sum()
            scale += float(np.abs(forces[nodes]).sum())
        left = np.append(handle.directions @ on_handle[:2], on_handle[2:] if handle.turns else [])
        if handle.stiffness is not None:
            moves = np.append(handle.directions @ (pivot - handle.pivot), [motion.rotation_rad] if handle.turns else [])
            left -= handle.stiffness @ moves
        kept = MAX_KEPT * scale if handle.soft_motions == "kept" else 0.0
        reach = max(system.parts[number].body.size for number in numbers)
        slides = np.abs(left[: len(handle.directions)])
        force = max(force, float(slides.max(initial=0.0)) - kept)
        if handle.turns:
            moment = max(moment, abs(float(left[-1])) - kept * reach - by_strain)
    return force, moment


def _cells(part: Part, body: Body, field: Floats, errors: list[str], warnings: list[str]) -> tuple[int, float, float]:
    """Number of inverted cells, and maximum mean strain and rotation of a cell, in the body's frame."""
    mesh = body.mesh
    starts, corners = mesh.cell_offsets[:-1].astype(np.int64), mesh.cell_points
    counts = np.diff(mesh.cell_offsets)
    following = np.arange(1, len(corners) + 1)
    following[mesh.cell_offsets[1:] - 1] = starts
    before, moved = mesh.points[corners], field[: len(mesh.points)][corners]
    areas = np.add.reduceat(cross_product(before, before[following]), starts) / 2.0
    chords = before[following] - before
    normals = turned_right(chords)
    # H_cij = 1/A_c sum over the cell's sides of (u_i + u_i')/2 n_j
    parts = 0.5 * (moved + moved[following])[:, :, None] * normals[:, None, :]
    gradients = np.add.reduceat(parts, starts) / areas[:, None, None]
    turns = np.abs(gradients[:, 1, 0] - gradients[:, 0, 1]) / 2.0
    mean, half = np.trace(gradients, axis1=1, axis2=2) / 2.0, (gradients[:, 0, 0] - gradients[:, 1, 1]) / 2.0
    strains = np.abs(mean) + np.hypot(half, (gradients[:, 0, 1] + gradients[:, 1, 0]) / 2.0)
    # by the mean deformation gradient: the corner between nearly straight sides turns inside out under any strain
    inverted = np.linalg.det(np.eye(2) + gradients) <= 0.0
    centres = np.add.reduceat(before, starts) / counts[:, None]
    if inverted.any():
        errors.append(
            f"{inverted.sum()} cells of {part.name} are inverted, one at {point_text(centres[inverted.argmax()])}; "
            "bodies are linear, for small strains: press less, or take a finer mesh there"
        )
    for values, limit, what in (
        (strains, LARGE_STRAIN, "the strain of {0} is {1:.2g}"),
        (turns, LARGE_TURN, "{0} turns by {1:.2g} rad"),
    ):
        cell = int(values.argmax())
        if values[cell] > limit:
            words = what.format(part.name, values[cell])
            warnings.append(f"{words} at {point_text(centres[cell])}, beyond {limit:g}, where bodies are not linear")
    return int(inverted.sum()), float(strains.max()), float(turns.max())
