"""Checks of a wheelset's result before a user sees it, and which of its stresses are valid."""

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from flangeway.contact import ContactState
from flangeway.contact.solution_checks import BodyOverlap
from flangeway.post import cell_stresses, check_contact
from flangeway.railway.track.placements import SIDES
from flangeway.railway.track.wheelset_problem import ROLES, Role, WheelsetProblem
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.plane_patch import WheelRailPatch
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import Status
from flangeway.types import Bools, Floats

MAX_RESIDUAL = 1e-6  # difference of contact forces and load relative to the vertical load; the search stops below 1e-10

YIELD_MPa = 510.0
"""Least yield strength of standard rail steel, 74 ksi (AREMA Manual for Railway Engineering, chapter 4)."""

MAX_DEFLECTION = 0.05
"""Displacement relative to the rail's height, a mean rotation, above which linear strains of a rotation, half its
square, are no longer small against the elastic ones: 0.00125, 260 MPa in steel."""

STEEL_MPa = (190e3, 220e3)
"""Young's moduli that are taken for those of steel, whose yield strength is assumed where none is given."""

DEPTH_BELOW = 2.0
"""Distance from a centre of pressure, relative to the contact's half width, that is below the contact: the maximum
stresses of Hertz's contact are at 0.7 to 0.8 half widths."""


def yield_strength(problem: WheelsetProblem, *roles: Role) -> float | None:
    """Yield strength in MPa: the one that was given, that of rail steel, or None for bodies that are not of steel."""
    steel = all(STEEL_MPa[0] <= problem.material_of(role).young <= STEEL_MPa[1] for role in roles)
    return problem.material.yield_MPa or (YIELD_MPa if steel else None)


def checked(
    model: WheelsetModel,
    equilibrium: Equilibrium[ContactState],
    patches: Sequence[WheelRailPatch],
    overlaps: Sequence[BodyOverlap],
    displacements: Mapping[str, Floats],
) -> tuple[Status, tuple[str, ...]]:
    """Return the final status, and warnings about what a converged iteration does not show.

    Errors, which make the status not converged: forces that are not in equilibrium with the load, numbers that are not
    finite, tensile contact, contact at the edge of the candidate zone, bodies that overlap, and a penetration as large
    as the elastic approach of the surfaces. Warnings: an unstable equilibrium, a wheel without contact, a mesh too
    coarse for the contact, a pressure that oscillates, penetration that is not small, a rail that deflects farther than
    linear bodies follow, and stresses below the contacts above the yield strength of rail steel.

    - `overlaps`: overlaps of the deformed bodies, see `flangeway.contact.solution_checks.body_overlaps`.
    - `displacements`: of all nodes of each part in its own frame, by name, each (n_dofs, 2).
    """
    names = [f"the {side} contact" for side in SIDES]
    plane = model.problem.plane
    stiffer = "raise penalty_factor" if plane.nodal_penalty_N_per_mm is None else "raise nodal_penalty_N_per_mm"
    if plane.enforcement == "augmented-lagrange":
        stiffer = "lower penetration_mm"
    checks = check_contact(model.system, equilibrium.state, patches, names, "lower size_scale", stiffer)
    errors = [*_unbalanced(model, patches), *checks.errors, *_outside(patches, overlaps)]
    if not all(np.isfinite(values).all() for values in displacements.values()):
        errors.append("displacements are not finite numbers")
    status = equilibrium.status
    if status.converged and errors:
        status = Status(False, "; ".join(errors), status.iterations)
    warnings = [*checks.warnings, *equilibrium.warnings(status, {patch.side for patch in patches})]
    if status.converged:
        warnings += _beyond_linear(model, displacements)
        warnings += _beyond_yield(model, patches, displacements)
    return status, tuple(warnings)


def _unbalanced(model: WheelsetModel, patches: Iterable[WheelRailPatch]) -> list[str]:
    """Compare the sum of the regions' forces with the load, along what is not held."""
    problem = model.problem
    along, onto = problem.forces.in_track
    total = sum((patch.force_on_wheel_N for patch in patches), np.zeros(2))
    rows = (
        ("lateral", problem.position.lateral_mm, total[0] + along),
        ("vertical", problem.position.vertical_mm, total[1] - onto),
    )
    return [
        (
            f"{name} contact forces and load differ by {abs(difference):.3g} N; report this as a fault, with the "
            "case file"
        )
        for name, prescribed, difference in rows
        if prescribed is None and not abs(difference) <= MAX_RESIDUAL * math.hypot(along, onto)
    ]


def _outside(patches: Iterable[WheelRailPatch], overlaps: Sequence[BodyOverlap]) -> list[str]:
    sides = dict.fromkeys(patch.side for patch in patches if patch.at_edge)
    errors = [
        f"the {side} contact reaches the edge of the candidate zone, so contact outside of it is missing; check the "
        "profiles and the load"
        for side in sides
    ]
    return errors + [overlap_error(overlap) for overlap in overlaps if not overlap.is_explained]


def overlap_error(overlap: BodyOverlap) -> str:
    """Sentence about an overlap that neither the contact law nor the mesh explains."""
    x, y = overlap.position
    return (
        f"{' and '.join(overlap.parts)} overlap by {overlap.depth:.3g} mm at ({x:.4g}, {y:.4g}), in the track's "
        "axes; check the profiles, the gauge and the load"
    )


def _beyond_linear(model: WheelsetModel, displacements: Mapping[str, Floats]) -> list[str]:
    """Compare the maximum displacement of each rail with its height."""
    warnings = []
    for side in SIDES:
        points = model.parts[f"rail-{side}"].body.space.mesh.points
        way = float(np.linalg.norm(displacements[f"rail-{side}"], axis=1).max())
        share = way / float(np.ptp(points[:, 1]))
        if share > MAX_DEFLECTION:
            warnings.append(
                f"the {side} rail deflects by {way:.1f} mm, {100.0 * share:.0f} % of its height, more than "
                "linear bodies allow: neither its stresses nor the wheelset's position are valid"
            )
    return warnings


def _beyond_yield(
    model: WheelsetModel, patches: Sequence[WheelRailPatch], displacements: Mapping[str, Floats]
) -> list[str]:
    """Compare the cells' maximum von Mises stress below the contacts with the yield strength."""
    given = model.problem.material.yield_MPa
    strength = YIELD_MPa if given is None else given
    beyond = []
    for role in ROLES:
        if yield_strength(model.problem, role) is None:
            continue
        maximum = 0.0
        for name, displacement in displacements.items():
            if name.startswith(role):
                mises = cell_stresses(model.parts[name].body.elasticity, displacement).von_mises
                maximum = max(maximum, float(mises[below_contacts(model, patches, name)].max(initial=0.0)))
        if maximum > strength:
            beyond.append(f"{maximum / strength:.1f} times in the {role}")
    if not beyond:
        return []
    assumed = "the least yield strength of standard rail steel (AREMA Manual, chapter 4)"
    source = assumed if given is None else "the yield strength"
    return [
        (
            f"elastic von Mises stresses below the contacts exceed {strength:g} MPa, {source}: up to "
            f"{' and '.join(beyond)}; the material would yield, with less pressure on wider contact"
        )
    ]


def below_contacts(model: WheelsetModel, patches: Iterable[WheelRailPatch], name: str) -> Bools:
    """Return which cells of a part lie within `DEPTH_BELOW` half widths below one of its contacts, shape (n_cells,)."""
    mesh = model.parts[name].body.space.mesh
    near = np.zeros(mesh.n_cells, dtype=np.bool_)
    for patch in patches:
        if name.endswith(patch.side):
            centre = patch.wheel_point_mm if name.startswith("wheel") else patch.rail_point_mm
            distance = np.linalg.norm(mesh.cell_centroids - centre, axis=1)
            near |= distance <= max(DEPTH_BELOW * patch.half_width, float(distance.min()))
    return near
